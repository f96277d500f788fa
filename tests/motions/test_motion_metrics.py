"""Metrics of motions: velocities, jerks and centred positions."""

from dataclasses import replace

import numpy as np
import pytest
import reference

from skpose import Motion, Skeleton, motion_distances
from skpose.datasets import MotionDataset, make_gait
from skpose.metrics import Centered, Jerk, Position, Velocity
from skpose.motions import (
    MotionDistanceTransformer,
    MotionIndex,
    MotionKNeighborsTransformer,
    align_motions,
    find_motion,
    segment_repetitions,
)

METRICS = [Velocity(), Velocity(0.1), Centered(), Jerk()]


@pytest.fixture(scope="module")
def gait():
    """Walks and runs of three people, of different lengths, at 12 Hz."""
    gait = make_gait(n_subjects=4, n_sequences=3, duration=1.5, frame_rate=12, random_state=0)
    shorter = [motion[: 12 + i % 5] for i, motion in enumerate(gait)]
    return MotionDataset(shorter, gait.subjects, gait.trials, gait.actions)


def rows_of(motion, metric, skeleton):
    """What is compared, frame by frame."""
    positions = reference.F(motion.angles, skeleton)
    if isinstance(metric, Centered):
        return positions - positions.mean(axis=0)
    if isinstance(metric, Jerk):
        firsts = [min(max(0, i - 1), len(positions) - 4) for i in range(len(positions))]
        return np.array([[-1, 3, -3, 1] @ positions[i : i + 4] for i in firsts]) * motion.frame_rate**3
    reach = max(1, round(metric.span * motion.frame_rate / 2))
    rows = []
    for i in range(len(positions)):
        first, last = max(0, i - reach), min(len(positions) - 1, i + reach)
        rows.append((positions[last] - positions[first]) / (last - first) * motion.frame_rate)
    return np.array(rows)


def costs(a, b, metric, skeleton):
    rows, others = (rows_of(motion, metric, skeleton) for motion in (a, b))
    return np.array([[np.linalg.norm(row - other) for other in others] for row in rows])


@pytest.mark.parametrize("metric", METRICS, ids=str)
def test_distances_are_those_of_the_formula(metric, gait):
    found = motion_distances(gait[:3], gait[3:5], skeleton=gait.skeleton, metric=metric)
    for i, j in np.ndindex(found.shape):
        of_frames = costs(gait[i], gait[3 + j], metric, gait.skeleton)
        assert found[i, j] == pytest.approx(reference.least_sum(of_frames) / sum(of_frames.shape), rel=1e-12)


def test_a_movement_that_is_twice_as_fast_has_twice_the_velocity():
    arm, turn = Skeleton.chain(1), np.linspace(0, 1, 40)[:, None]
    still = Motion(arm, np.zeros((40, 1)), 30)
    slow, fast = Motion(arm, turn, 30), Motion(arm, turn, 60)
    (of_slow,) = motion_distances([slow], [still], metric=Velocity(2 / 30)).ravel()
    (of_fast,) = motion_distances([fast], [Motion(arm, np.zeros((40, 1)), 60)], metric=Velocity(2 / 60)).ravel()
    assert of_fast == pytest.approx(2 * of_slow, rel=1e-12)
    # Chords of two steps of 1/39 rad at the end of a bone of 1 m, and of one at both ends
    expected = (38 * 2 * np.sin(1 / 39) * 15 + 2 * 2 * np.sin(1 / 78) * 30) / 40
    found = motion_distances([slow], [still], metric=Velocity(2 / 30), alignment="frames").item()
    assert found == pytest.approx(expected, rel=1e-12)


def test_frames_that_are_missing_make_no_joint_faster(gait):
    """A movement at constant speed has it across a gap too; frame numbers that forget the gap would not say so."""
    arm = Skeleton.chain(1)
    turn = Motion(arm, np.linspace(0, 1, 61)[:, None], 60)
    kept = np.r_[0:20, 40:61]
    cut = replace(turn, angles=turn.angles[kept], frame_numbers=kept, root_positions=None, root_angles=None)
    (speeds,) = (np.linalg.norm(Velocity(0.1).encode_motion(cut.angles, arm, cut.times), axis=1),)
    assert speeds.max() < 1.0 + 1e-9
    assert speeds.min() > 0.98
    closed = replace(cut, frame_numbers=np.arange(len(kept)))
    jumped = np.linalg.norm(Velocity(0.1).encode_motion(closed.angles, arm, closed.times), axis=1)
    assert jumped.max() > 2.0
    assert motion_distances([cut], [closed], metric=Velocity(0.1)).item() > 0.1
    with_gap = replace(gait[0], frame_numbers=gait[0].frame_numbers + 7 * (np.arange(len(gait[0])) > 5))
    assert motion_distances([with_gap], [gait[0]], metric="velocity").item() > 0.01


def test_jerks_are_third_derivatives():
    """Of each coordinate of a joint that moves along a cubic in time: exact, with frames missing too."""
    times = np.arange(40)[np.r_[0:9, 11:30, 38, 39]] / 25
    coefficients = np.random.default_rng(0).normal(size=(4, 6))
    rows = Jerk()._rows(times[:, None] ** np.arange(4) @ coefficients, times)
    np.testing.assert_allclose(rows, np.tile(6 * coefficients[3], (len(times), 1)), rtol=1e-8)


@pytest.mark.parametrize("metric", METRICS, ids=str)
def test_estimators_compute_the_same(metric, gait, monkeypatch):
    monkeypatch.setattr("skpose.motions._search.WORTH_FILTERING", 0.0)
    monkeypatch.setattr("skpose.motions._search.FEWEST_PER_NEIGHBOR", 1)
    among = motion_distances(gait, metric=metric)
    found = MotionDistanceTransformer(metric=metric).fit(gait).transform(gait[:4])
    np.testing.assert_array_equal(found, motion_distances(gait[:4], gait[:], skeleton=gait.skeleton, metric=metric))
    near = MotionKNeighborsTransformer(metric=metric, n_neighbors=3).fit(gait)
    distances, indices = near.kneighbors(n_neighbors=3)
    np.fill_diagonal(among, np.inf)
    order = among.argsort(axis=1, kind="stable")[:, :3]
    np.testing.assert_array_equal(indices, order)
    np.testing.assert_allclose(distances, np.take_along_axis(among, order, axis=1), rtol=1e-12)
    assert near.metric_ == metric


@pytest.mark.parametrize("metric", [*METRICS[:2], Jerk()], ids=str)
def test_windows_have_the_velocities_that_they_have_in_the_recording(metric, gait):
    query = gait[1][3:10]
    found = find_motion(query, MotionIndex(gait, metric=metric), k=4)
    assert (found[0].motion, found == find_motion(query, gait, k=4, metric=metric)) == (1, True)
    for match in found:
        inside = reference.least_sum(
            costs(query, gait[match.motion], metric, gait.skeleton)[:, match.start : match.stop]
        )
        assert match.distance == pytest.approx(inside / len(query), rel=1e-12, abs=1e-10)
    whole = motion_distances([query], gait[:], skeleton=gait.skeleton, metric=metric, alignment="subsequence")
    assert found[0].distance == pytest.approx(whole.min(), rel=1e-12, abs=1e-10)


def test_a_motion_that_is_moved_as_a_whole_keeps_what_is_compared(gait):
    """Control: under "position" the same is far."""
    arm, wave = Skeleton.chain(1), 0.05 * np.sin(np.linspace(0, 6, 30))[:, None]
    down, up = Motion(arm, wave, 30), Motion(arm, wave + np.pi, 30)
    mirrored = Motion(arm, np.pi - wave, 30)  # the movement of `down` at another place, as far as 0.05 rad is small
    (there,) = motion_distances([down], [up], metric="centered").ravel()
    (same,) = motion_distances([down], [Motion(arm, wave.copy(), 30)], metric="centered").ravel()
    (like,) = motion_distances([down], [mirrored], metric="centered").ravel()
    assert same == 0.0
    assert like < 0.002 < 0.01 < there < 0.1 < motion_distances([down], [up], metric=Position()).item()


@pytest.mark.parametrize(
    "call",
    [
        lambda gait: motion_distances([m.angles for m in gait], skeleton=gait.skeleton, metric="velocity"),
        lambda gait: motion_distances([gait[0], gait[0][:1]], metric="velocity"),
        lambda gait: motion_distances(gait, [gait[0][:3]], metric="jerk"),
        lambda gait: find_motion(gait[0], gait, metric="centered"),
        lambda gait: align_motions(gait[0], gait[1], metric="velocity"),
        lambda gait: segment_repetitions(gait[0], metric="centered"),
    ],
)
def test_refused(call, gait):
    with pytest.raises(ValueError, match=r"velocity|jerk|centered"):
        call(gait)
