"""Velocities, jerks and centred positions: by slow formulas, in all that compares motions, refused where poses are."""

from dataclasses import replace

import numpy as np
import pytest
import reference
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis
from sklearn.model_selection import GridSearchCV, LeaveOneGroupOut, cross_val_score
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline, make_union
from sklearn.preprocessing import StandardScaler

from skpose import (
    MedoidShift,
    Motion,
    MotionDistanceTransformer,
    MotionKNeighborsTransformer,
    PoseKNeighborsTransformer,
    Skeleton,
    motion_distances,
    pose_distances,
    pose_metric,
)
from skpose.datasets import MotionDataset, make_gait
from skpose.geodesics import frechet_mean
from skpose.metrics import Centered, Jerk, Position, Velocity
from skpose.motions import MotionIndex, align_motions, find_motion, mean_motion, segment_repetitions
from skpose.plot import DistanceMatrixDisplay
from skpose.statistics import outlier_test, two_sample_test
from skpose.view import explorer

METRICS = [Velocity(), Velocity(0.1), Velocity(7), Centered(), Jerk()]


@pytest.fixture(scope="module")
def gait():
    """Walks and runs of three people, of different lengths, at 12 Hz."""
    gait = make_gait(n_subjects=4, n_sequences=3, duration=1.5, frame_rate=12, random_state=0)
    shorter = [motion[: 12 + i % 5] for i, motion in enumerate(gait)]
    return MotionDataset(shorter, gait.subjects, gait.trials, gait.actions)


def rows_of(motion, metric, skeleton):
    """What is compared, frame by frame."""
    positions = np.array([reference.F(angles, skeleton).ravel() for angles in motion.angles])
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


@pytest.mark.parametrize("metric", METRICS, ids=str)
def test_frames_are_compared_by_the_formula(metric, gait):
    same = [motion[:12] for motion in gait[:3]]
    expected = [[np.diag(costs(a, b, metric, gait.skeleton)).mean() for b in same] for a in same]
    found = motion_distances(same, skeleton=gait.skeleton, metric=metric, alignment="frames")
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-14)


def test_weights_of_joints_count(gait):
    weighted = gait.skeleton.with_weights(np.linspace(0, 3, gait.skeleton.n_joints))
    for metric in METRICS:
        of_frames = costs(gait[0], gait[3], metric, weighted)
        (found,) = motion_distances(gait[:1], gait[3:4], skeleton=weighted, metric=metric).ravel()
        assert found == pytest.approx(reference.least_sum(of_frames) / sum(of_frames.shape), rel=1e-12)


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


def test_jitter_has_the_jerk_that_the_page_says():
    noise = np.random.default_rng(0).normal(0, 0.002, (20_000, 3))
    assert Jerk()._rows(noise, np.arange(20_000) / 30).std() == pytest.approx(np.sqrt(20) * 0.002 * 30**3, rel=0.02)


def test_the_unit_is_said():
    assert (Velocity().unit, Centered().unit, Jerk().unit) == ("m/s", "m", "m/s³")
    assert [metric.label for metric in METRICS[:2]] == ["velocity", "Velocity(span=0.1)"]


@pytest.mark.parametrize("metric", METRICS, ids=str)
def test_estimators_compute_the_same(metric, gait, monkeypatch, tmp_path):
    monkeypatch.setattr("skpose.motions._queries.WORTH_FILTERING", 0.0)
    monkeypatch.setattr("skpose.motions._queries.FEWEST_PER_NEIGHBOR", 1)
    among = motion_distances(gait, metric=metric)
    found = MotionDistanceTransformer(metric=metric).fit(gait).transform(gait[:4])
    np.testing.assert_array_equal(found, motion_distances(gait[:4], gait[:], skeleton=gait.skeleton, metric=metric))
    for _ in range(2):
        kept = MotionDistanceTransformer(gait.skeleton, metric=metric, memory=tmp_path).fit_transform(gait)
        np.testing.assert_array_equal(kept, among)
    near = MotionKNeighborsTransformer(metric=metric, n_neighbors=3).fit(gait)
    distances, indices, evaluations = near.kneighbors(n_neighbors=3, return_evaluations=True)
    np.fill_diagonal(among, np.inf)
    order = among.argsort(axis=1, kind="stable")[:, :3]
    np.testing.assert_array_equal(indices, order)
    np.testing.assert_allclose(distances, np.take_along_axis(among, order, axis=1), rtol=1e-12)
    assert evaluations.alignments < len(gait) * (len(gait) - 1)
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


def test_metrics_and_their_parameters_can_be_searched_over(gait):
    knn = make_pipeline(MotionDistanceTransformer(gait.skeleton), KNeighborsClassifier(1, metric="precomputed"))
    grid = {"motiondistancetransformer__metric": ["spatial", "velocity", "centered", Velocity(0.5)]}
    search = GridSearchCV(knn, grid, cv=LeaveOneGroupOut()).fit(gait, gait.actions, groups=gait.subjects)
    assert search.cv_results_["mean_test_score"].min() > 0.65


def test_three_kinds_of_distances_are_features(gait):
    """The recipe of the page on motions."""
    kinds = make_union(
        *(MotionDistanceTransformer(gait.skeleton, metric=metric) for metric in ("position", "velocity", "centered"))
    )
    model = make_pipeline(kinds, StandardScaler(), LinearDiscriminantAnalysis(solver="lsqr", shrinkage="auto"))
    assert kinds.fit_transform(gait).shape == (len(gait), 3 * len(gait))
    scores = cross_val_score(model, gait, gait.actions, groups=gait.subjects, cv=LeaveOneGroupOut())
    assert scores.mean() > 0.9
    shuffled = np.random.default_rng(0).permutation(gait.actions)
    assert cross_val_score(model, gait, shuffled, groups=gait.subjects, cv=LeaveOneGroupOut()).mean() < 0.75


OF_POSES = {
    "pose_distances": lambda gait, metric: pose_distances(gait[0].angles, skeleton=gait.skeleton, metric=metric),
    "pose_metric": lambda gait, metric: pose_metric(gait.skeleton, metric=metric),
    "nearest poses": lambda gait, metric: PoseKNeighborsTransformer(gait.skeleton, metric=metric).fit(gait[0].angles),
    "clusters": lambda gait, metric: MedoidShift(gait.skeleton, metric=metric).fit(gait[0].angles),
    "means": lambda gait, metric: frechet_mean(gait[0].angles, gait.skeleton, metric=metric),
    "alignment": lambda gait, metric: align_motions(gait[0], gait[1], metric=metric),
    "mean motion": lambda gait, metric: mean_motion(gait[:2], metric=metric),
    "repetitions": lambda gait, metric: segment_repetitions(gait[0], metric=metric),
    "test": lambda gait, metric: two_sample_test(
        gait[0].angles[::3], gait[1].angles[::3], skeleton=gait.skeleton, metric=metric
    ),
    "outliers": lambda gait, metric: outlier_test(
        gait[0].angles[::3], gait[1].angles[::3], skeleton=gait.skeleton, metric=metric
    ),
    "display": lambda gait, metric: DistanceMatrixDisplay.from_poses(
        gait[0].angles, skeleton=gait.skeleton, metric=metric
    ),
    "explorer": lambda gait, metric: explorer(gait, metrics=[metric]),
}


@pytest.mark.parametrize("metric", ["velocity", "jerk", "centered", Velocity(0.3), Centered()], ids=str)
@pytest.mark.parametrize("user", OF_POSES.values(), ids=OF_POSES)
def test_where_poses_are_compared_they_are_refused(user, metric, gait):
    with pytest.raises(
        ValueError,
        match=r"(velocity|jerk|centered|Velocity\(span=0.3\)).* whole motions|metrics must be among angle, position",
    ):
        user(gait, metric)


def test_what_has_no_velocity_is_refused_in_words(gait):
    arrays = [motion.angles for motion in gait]
    with pytest.raises(ValueError, match=r"X\[0\]: 'velocity' needs a frame rate, and arrays have none: pass Motion"):
        motion_distances(arrays, skeleton=gait.skeleton, metric="velocity")
    with pytest.raises(ValueError, match=r"X\[1\]: 'velocity' needs two frames or more, got one"):
        motion_distances([gait[0], gait[0][:1]], metric="velocity")
    with pytest.raises(ValueError, match=r"Y: 'jerk' needs four frames or more, got 3"):
        motion_distances(gait, [gait[0][:3]], metric="jerk")
    with pytest.raises(ValueError, match=r"X\[0\]: 'jerk' needs a frame rate, and arrays have none"):
        motion_distances(arrays, skeleton=gait.skeleton, metric=Jerk())
    with pytest.raises(ValueError, match=r"'centered' needs two frames or more, got one"):
        MotionDistanceTransformer(gait.skeleton, metric="centered").fit(gait[0].angles)
    with pytest.raises(ValueError, match="the metric 'centered' needs a skeleton to place the joints"):
        motion_distances(arrays, metric="centered")
    with pytest.raises(ValueError, match="'span' parameter of Velocity must be a float in the range"):
        motion_distances(gait, metric=Velocity(span=0))
    with pytest.raises(TypeError, match="did you mean 'velocity'"):
        motion_distances(gait, metric="Velocity")


@pytest.mark.parametrize(
    "search",
    [
        lambda gait: find_motion(gait[0], gait, metric="centered"),
        lambda gait: MotionIndex(gait, metric=Centered()),
        lambda gait: motion_distances(gait, metric="centered", alignment="subsequence"),
        lambda gait: MotionDistanceTransformer(metric="centered", alignment="subsequence").fit(gait),
    ],
)
def test_the_mean_of_a_window_is_not_known_before_it_is_found(search, gait):
    with pytest.raises(ValueError, match="the mean of a window is not known before the window is found"):
        search(gait)


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
