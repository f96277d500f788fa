"""Motions through key poses: closed forms, what is met at the keys, smoothness, and errors."""

from itertools import pairwise

import numpy as np
import pytest
from conftest import ALL_SKELETONS, SKELETONS, in_turns
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from skpose import Bone, Skeleton, forward_kinematics, geodesic
from skpose.geodesics import interpolate
from skpose.geodesics._interpolate import Segment, _segment_of, natural_slopes
from skpose.metrics import Geodesic

METHODS = ["geodesic", "spline"]
TIMES = np.array([0.0, 0.5, 0.8, 1.4])  # uneven; all on frames at 10 Hz


def keys_of(skeleton, n=4, size=0.5, seed=0):
    return size * np.random.default_rng(seed).normal(size=(n, skeleton.n_dofs))


@pytest.mark.parametrize(("method", "skeleton"), in_turns(METHODS, ALL_SKELETONS), indirect=["skeleton"])
def test_keys_on_frames_are_met_exactly_and_others_nearly(method, skeleton):
    X = keys_of(skeleton, size=0.2)
    motion = interpolate(X, TIMES + 3.0, skeleton, frame_rate=10, method=method)
    assert motion.skeleton is skeleton
    assert motion.frame_rate == 10
    assert len(motion) == 15
    np.testing.assert_allclose(
        forward_kinematics(motion.angles[[0, 5, 8, 14]], skeleton), forward_kinematics(X, skeleton), atol=1e-12
    )
    np.testing.assert_array_equal(motion.angles[0], X[0])


def test_one_angle_moves_at_constant_speed_along_geodesics():
    arm, X = Skeleton.chain(1), np.array([[0.0], [1.0], [0.3], [0.5]])
    motion = interpolate(X, TIMES, arm, frame_rate=50, method="geodesic")
    np.testing.assert_allclose(motion.angles[:, 0], np.interp(motion.times, TIMES, X[:, 0]), atol=1e-9)


@pytest.mark.parametrize("n", [2, 3, 4])
def test_one_angle_has_the_natural_cubic_spline(n):
    arm, X = Skeleton.chain(1), np.array([[0.0], [1.0], [0.3], [0.5]])[:n]
    motion = interpolate(X, TIMES[:n], arm, frame_rate=50)
    expected = CubicSpline(TIMES[:n], X, bc_type="natural")(motion.times)
    np.testing.assert_allclose(motion.angles, expected, atol=2e-4)
    if n > 2:
        assert np.abs(expected[:, 0] - np.interp(motion.times, TIMES[:n], X[:, 0])).max() > 0.05


def test_slopes_solve_the_equations_of_the_natural_spline():
    rng = np.random.default_rng(0)
    keys, spans = rng.normal(size=(6, 3)), rng.uniform(0.2, 2.0, 5)
    turns = [np.linalg.qr(rng.normal(size=(3, 3)))[0] for _ in spans]  # each key has axes of its own
    axes = [np.eye(3)]
    for turn in turns:
        axes.append(turn @ axes[-1])
    gaps = np.diff(keys, axis=0)
    segments = [Segment(None, None, None, axes[i] @ gaps[i], axes[i + 1] @ gaps[i], turns[i]) for i in range(5)]
    found = natural_slopes(segments, spans)
    times = np.concatenate([[0.0], np.cumsum(spans)])
    expected = CubicSpline(times, keys, bc_type="natural")(times, 1)
    np.testing.assert_allclose([a.T @ m for a, m in zip(axes, found, strict=True)], expected, atol=1e-12)


def test_transport_around_a_triangle_on_a_sphere_turns_by_its_area():
    """Gauss and Bonnet. In these angles a line bends near the pole, so that it takes many steps."""
    rod = Skeleton([Bone("rod", None, (1.0, 0.0, 0.0), "yz")])
    corners = np.array([[0.0, 0.0], [0.0, np.pi / 2], [-1.2, np.pi / 2], [0.0, 0.0]])
    segments = [_segment_of(geodesic(a, b, rod, metric=Geodesic(80)), rod) for a, b in pairwise(corners)]
    vector = segments[0].leaving / np.linalg.norm(segments[0].leaving)
    for segment, following in pairwise([*segments, segments[0]]):
        vector = following.first.T @ segment.last @ segment.forth @ vector
    angle = np.arccos(vector @ segments[0].leaving / np.linalg.norm(segments[0].leaving))
    # Its sides give the area (L'Huilier).
    a, b, c = (np.linalg.norm(segment.leaving) for segment in segments)
    s = (a + b + c) / 2
    area = 4 * np.arctan(np.sqrt(np.tan(s / 2) * np.tan((s - a) / 2) * np.tan((s - b) / 2) * np.tan((s - c) / 2)))
    assert area > 1.0
    np.testing.assert_allclose(angle, area, atol=0.03)


def velocities_at_key(skeleton, X, method):
    """Velocities of the joints just before the second key and just after it, to second order."""
    rate = 80_000
    motion = interpolate(X[:3], [0.0, 0.01, 0.02], skeleton, frame_rate=rate, method=method)
    p = forward_kinematics(motion.angles[798:803], skeleton)
    return (3 * p[2] - 4 * p[1] + p[0]) * rate / 2, (-3 * p[2] + 4 * p[3] - p[4]) * rate / 2


@pytest.mark.parametrize(
    "name",
    ["chain", *(pytest.param(name, marks=pytest.mark.slow) for name in ("humanoid", "ball joints", "mixed joints"))],
)
def test_velocities_are_continuous_at_keys(name):
    skeleton = SKELETONS[name]
    X = 0.7 + keys_of(skeleton, size=0.2)  # bent
    before, after = velocities_at_key(skeleton, X, "spline")
    size = np.linalg.norm(after)
    assert np.linalg.norm(after - before) < 0.02 * size
    before, after = velocities_at_key(skeleton, X, "geodesic")
    assert np.linalg.norm(after - before) > 0.3 * size


def test_geodesic_pieces_are_those_of_geodesic_at_constant_speed():
    skeleton = SKELETONS["humanoid"]
    X = keys_of(skeleton, n=2, size=0.3)
    motion = interpolate(X, [0.0, 1.0], skeleton, frame_rate=8, method="geodesic")
    np.testing.assert_allclose(motion.angles, geodesic(X[0], X[1], skeleton).resample(9), atol=1e-9)


def test_two_keys_have_one_geodesic_and_no_spline():
    skeleton = SKELETONS["humanoid"]
    X = keys_of(skeleton, n=2, size=0.3)
    a, b = (interpolate(X, [0.0, 1.0], skeleton, frame_rate=8, method=method).angles for method in METHODS)
    np.testing.assert_allclose(forward_kinematics(b, skeleton), forward_kinematics(a, skeleton), atol=5e-5)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_whole_turns_of_keys_change_no_position_and_make_no_jump(method):
    skeleton = SKELETONS["humanoid"]
    X = keys_of(skeleton, size=0.2)
    turned = X + 2 * np.pi * np.random.default_rng(1).integers(-1, 2, X.shape)
    turned[0] = X[0]
    a, b = (interpolate(one, TIMES, skeleton, frame_rate=10, method=method).angles for one in (X, turned))
    np.testing.assert_allclose(b, a, atol=1e-6)
    assert np.abs(np.diff(b, axis=0)).max() < 1.0


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("what", ["a twist", "no weight"])
def test_what_moves_no_joint_turns_by_slerp(method, what):
    """The last joint: a ball joint that twists its own bone, or has no weight."""
    last = Bone("hand", "arm", (1.0, 0.0, 0.0), "rotvec", weight=0.0 if what == "no weight" else 1.0)
    skeleton = Skeleton([Bone("arm", None, (1.0, 0.0, 0.0), "z"), last])
    turns = np.array([0.2, 1.0, 0.5, 0.9])
    axis = np.array([1.0, 0.0, 0.0]) if what == "a twist" else np.array([0.6, 0.0, 0.8])
    X = np.column_stack([[0.1, 0.5, 0.3, 0.9], turns[:, None] * axis])
    found = interpolate(X, TIMES, skeleton, frame_rate=50, method=method)
    rotation = Rotation.from_rotvec(found.angles[:, 1:]).as_rotvec()
    angle = rotation @ axis
    np.testing.assert_allclose(rotation, angle[:, None] * axis, atol=2e-3)
    np.testing.assert_allclose(angle, np.interp(found.times, TIMES, turns), atol=0.02)


@pytest.mark.slow
def test_is_nearer_to_a_smooth_motion_than_geodesics_are():
    skeleton = SKELETONS["humanoid"]
    rng = np.random.default_rng(0)
    phase, size = rng.uniform(0, 6, skeleton.n_dofs), 0.4 * rng.uniform(size=skeleton.n_dofs)
    at = np.arange(41) / 20.0
    truth = forward_kinematics(size * np.sin(3 * at[:, None] + phase), skeleton)
    X = size * np.sin(3 * at[::5, None] + phase)
    errors = [
        np.sqrt(
            np.square(
                forward_kinematics(interpolate(X, at[::5], skeleton, frame_rate=20, method=m).angles, skeleton) - truth
            ).mean()
        )
        for m in METHODS
    ]
    assert errors[1] < 0.4 * errors[0]
