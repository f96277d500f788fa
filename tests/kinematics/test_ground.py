"""The ground below a motion."""

import numpy as np
import pytest

from skpose.kinematics._ground import find_ground
from skpose.view._scene import scene_of

RATE, SIZE = 50.0, 1.7  # Hz, m


def stepping(n_steps=10, height=0.3, floor=0.1):
    """Two feet and a head: while one foot stands for half a second, the other one swings; then times."""
    n = round(0.5 * RATE)
    swing = np.sin(np.linspace(0.0, np.pi, n)) ** 2
    points = np.zeros((n_steps * n, 3, 3))
    points[:, 2, 1] = SIZE
    for i in range(n_steps):
        part = slice(i * n, (i + 1) * n)
        points[part, i % 2, 1] = height * swing
        points[part, i % 2, 0] = i + np.linspace(0.0, 2.0, n)
        points[part, 1 - i % 2, 0] = i + 1.0
    points[:, :, 1] += floor
    return points, np.arange(len(points)) / RATE


def test_feet_stand_on_the_ground():
    points, times = stepping()
    height, n_frames = find_ground(points, times, SIZE)
    assert height == pytest.approx(0.1, abs=1e-12)
    assert n_frames > 0.9 * len(points)


@pytest.mark.parametrize("depth", [0.02, 0.5])
def test_a_toe_that_dips_does_not_lift_the_others(depth):
    points, times = stepping()
    points[60, 1, 1] -= depth
    assert find_ground(points, times, SIZE)[0] == pytest.approx(0.1, abs=1e-12)


def test_of_stairs_it_is_the_lowest_floor():
    points, times = stepping()
    points[..., 1] += 0.17 * (times // 1.0)[:, None]
    assert find_ground(points, times, SIZE)[0] == pytest.approx(0.1, abs=1e-12)


def test_who_is_in_the_air_all_the_time_has_it_at_the_lowest_point():
    _, times = stepping()
    falling = np.zeros((len(times), 2, 3))
    falling[:, 0, 1], falling[:, 1, 1] = 80.0 - 3.0 * times**2, 90.0 - 3.0 * times**2
    falling[..., 0] = 5.0 * times[:, None]
    assert find_ground(falling, times, SIZE) == (falling[..., 1].min(), 0)


@pytest.mark.parametrize("rate", [12.0, 120.0])
def test_at_the_top_of_a_jump_one_does_not_stand(rate):
    times = np.arange(round(0.5 * rate)) / rate
    jump = np.zeros((len(times), 2, 3))
    jump[:, 0, 1] = 1.0 - 4.9 * (times - times[len(times) // 2]) ** 2
    jump[:, 1, 1] = jump[:, 0, 1] + SIZE
    assert find_ground(jump, times, SIZE) == (jump[..., 1].min(), 0)


def test_a_point_that_is_not_seen_stands_nowhere():
    points, times = stepping()
    points[:100, :2] = np.nan  # nothing but the head
    assert find_ground(points, times, SIZE)[0] == pytest.approx(0.1, abs=1e-12)
    points[5] = np.nan
    assert find_ground(points, times, SIZE)[0] == pytest.approx(0.1, abs=1e-12)


def lowest(motion):
    """Heights (n_frames,) of the lowest joint above the ground, m."""
    scene = scene_of(motion)
    return (scene.joints[..., 1] + scene.root[:, None, 1]).min(axis=1)


def test_feet_of_walks_are_on_the_ground(cmu):
    """Within 2 cm in the median of the frames of each, where the lowest point was up to 10 cm below."""
    walks = [motion for motion, action in zip(cmu, cmu.actions, strict=True) if action == "walk"]
    assert len(walks) > 20
    assert max(np.median(np.abs(lowest(motion))) for motion in walks) < 0.02
    assert max(np.median(lowest(motion) - lowest(motion).min()) for motion in walks) > 0.08
