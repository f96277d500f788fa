"""The test of two sets: its statistics by definition, its p-values by scipy's, level and power, what is permuted."""

import re
from math import comb

import numpy as np
import pytest
import reference
from conftest import random_tree
from scipy import stats

from skpose import Motion, Skeleton, pose_distances
from skpose.datasets import MotionDataset, make_gait
from skpose.metrics import _matrix
from skpose.metrics._registry import METRICS
from skpose.statistics import _two_sample, _units, two_sample_test

TREE, CHAIN = random_tree(0), Skeleton.chain(2)
STATISTICS = ["energy", "mmd"]


def motions(lengths, shift=0.0, skeleton=TREE, seed=0):
    rng = np.random.default_rng(seed)
    return [shift + rng.normal(0, 0.5, skeleton.n_dofs) + rng.normal(0, 0.3, (n, skeleton.n_dofs)) for n in lengths]


def poses(n, shift=0.0, skeleton=TREE, seed=0):
    return shift + np.random.default_rng(seed).normal(0, 0.4, (n, skeleton.n_dofs))


def gaussian(width, distance):
    return lambda a, b: np.exp(-0.5 * (distance(a, b) / width) ** 2)


@pytest.mark.parametrize("metric", [name for name in METRICS if name != "geodesic"])
def test_the_energy_statistic_is_its_definition(metric):
    X, Y = motions([3, 1, 4]), motions([2, 5], 0.3, seed=1)
    found = two_sample_test(X, Y, skeleton=TREE, metric=metric)

    def d(a, b):
        return reference.distance(a, b, TREE, metric, wrap=metric == "spatial")

    assert found.statistic == pytest.approx(reference.two_sample_statistic(X, Y, d), rel=1e-9)
    assert (found.n_x, found.n_y, found.width, found.negative_share) == (3, 2, None, None)


def test_the_energy_statistic_of_geodesics():
    X, Y = motions([2, 1], skeleton=CHAIN), motions([2], 0.3, CHAIN, seed=1)
    found = two_sample_test(X, Y, skeleton=CHAIN, metric="geodesic").statistic

    def d(a, b):
        return pose_distances([a], [b], skeleton=CHAIN, metric="geodesic")[0, 0]

    assert found == pytest.approx(reference.two_sample_statistic(X, Y, d), rel=1e-9)


@pytest.mark.parametrize("metric", ["angle", "position"])
def test_the_squared_mmd_is_its_definition(metric):
    X, Y = motions([3, 1, 4]), motions([2, 5], 0.3, seed=1)
    found = two_sample_test(X, Y, skeleton=TREE, metric=metric, statistic="mmd")
    unit = np.repeat(np.arange(5), [3, 1, 4, 2, 5])
    D = pose_distances(np.concatenate([*X, *Y]), skeleton=TREE, metric=metric)
    assert found.width == pytest.approx(np.median([D[i, j] for i, j in np.ndindex(D.shape) if unit[i] < unit[j]]))

    def d(a, b):
        return reference.distance(a, b, TREE, metric)

    expected = -reference.two_sample_statistic(X, Y, gaussian(found.width, d))
    assert found.statistic == pytest.approx(expected, rel=1e-9)
    assert found.negative_share == 0.0


def test_energy_in_one_dimension_is_the_square_of_scipys():
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=30), rng.normal(0.5, 2.0, size=20)
    found = two_sample_test(a[:, None], b[:, None], metric="angle", n_permutations=1)
    assert found.statistic == pytest.approx(stats.energy_distance(a, b) ** 2, rel=1e-12)


def statistic_of_indices(G):
    def statistic(a, b):
        a, b = a.astype(int), b.astype(int)
        return 2 * G[np.ix_(a, b)].mean() - G[np.ix_(a, a)].mean() - G[np.ix_(b, b)].mean()

    return statistic


@pytest.mark.parametrize(("n_x", "n_y", "paired"), [(4, 3, False), (4, 4, False), (5, 5, True), (2, 6, False)])
def test_exact_p_values_are_scipys(n_x, n_y, paired):
    X, Y = poses(n_x), poses(n_y, 0.15, seed=1)
    found = two_sample_test(X, Y, skeleton=TREE, metric="position", paired=paired)
    D = pose_distances(np.concatenate([X, Y]), skeleton=TREE, metric="position")
    expected = stats.permutation_test(
        (np.arange(n_x), n_x + np.arange(n_y)),
        statistic_of_indices(D),
        permutation_type="samples" if paired else "independent",
        alternative="greater",
        n_resamples=999,
    )
    assert found.exact
    assert found.statistic == pytest.approx(expected.statistic)
    assert found.pvalue == expected.pvalue
    np.testing.assert_allclose(np.sort(found.null_distribution), np.sort(expected.null_distribution), rtol=1e-9)
    n_splits = 2**n_x if paired else comb(n_x + n_y, n_x)
    assert len(found.null_distribution) == n_splits
    assert found.least_pvalue == (2 if n_x == n_y else 1) / n_splits


@pytest.mark.parametrize("statistic", STATISTICS)
def test_equal_sets_have_statistic_zero_and_p_one(statistic):
    X = poses(6)
    found = two_sample_test(X, X[::-1].copy(), skeleton=TREE, metric="position", statistic=statistic)
    assert found.statistic == pytest.approx(0, abs=1e-12)
    assert found.pvalue == 1.0


# --- level and power -------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("paired", [False, True])
@pytest.mark.parametrize("statistic", STATISTICS)
def test_p_values_are_uniform_where_the_sets_do_not_differ(statistic, paired):
    rng = np.random.default_rng(0)
    p = []
    for _ in range(200):
        X, Y = rng.normal(size=(2, 10, 2))
        if paired:
            X, Y = X + (people := rng.normal(size=(10, 2))), Y + people
        p.append(
            two_sample_test(X, Y, metric="angle", statistic=statistic, paired=paired, random_state=rng_seed(rng)).pvalue
        )
    assert stats.kstest(p, "uniform").pvalue > 0.01
    assert np.mean(np.array(p) <= 0.05) < 0.05 + 4 * np.sqrt(0.05 * 0.95 / 200)


def rng_seed(rng):
    return int(rng.integers(2**31))


@pytest.mark.parametrize("statistic", STATISTICS)
@pytest.mark.parametrize("metric", [name for name in METRICS if name != "geodesic"])
def test_shifted_sets_are_found_under_every_metric(metric, statistic):
    X, Y = poses(15), poses(15, 0.5, seed=1)
    found = two_sample_test(X, Y, skeleton=TREE, metric=metric, statistic=statistic, random_state=0)
    assert found.pvalue == found.least_pvalue == 0.001


def recordings(rng, n, n_frames=12):
    """Recordings of one person, each with a posture of its own, that the frames share."""
    return [rng.normal(size=2) + 0.3 * rng.normal(size=(n_frames, 2)) for _ in range(n)]


@pytest.mark.slow
@pytest.mark.parametrize("statistic", STATISTICS)
def test_frames_of_recordings_are_not_exchangeable_but_recordings_are(statistic):
    """Under a true null: frames permuted one by one reject far too often, recordings as often as the level says."""
    rng = np.random.default_rng(1)
    of_frames, of_recordings = [], []
    options = {"metric": "angle", "statistic": statistic, "n_permutations": 99}
    for _ in range(100):
        X, Y = recordings(rng, 4), recordings(rng, 4)
        seed = rng_seed(rng)
        of_recordings.append(two_sample_test(X, Y, random_state=seed, **options).pvalue)
        a, b = (rng.permutation(np.concatenate(one)) for one in (X, Y))  # in an order that gives no warning
        of_frames.append(two_sample_test(a, b, random_state=seed, **options).pvalue)
    assert np.mean(np.array(of_frames) <= 0.05) > 0.8
    assert np.mean(np.array(of_recordings) <= 0.05) < 0.15
    assert stats.kstest(of_recordings, "uniform").pvalue > 0.01


@pytest.mark.parametrize("name", ["X", "Y"])
def test_consecutive_frames_as_rows_give_a_warning(name):
    walk = make_gait(1, 1, activities=["walk"], frame_rate=12, duration=4, random_state=0)[0]
    X = np.random.default_rng(0).permutation(walk.angles)
    given = {"X": X, "Y": X} | {name: walk.angles}
    with pytest.warns(UserWarning, match=rf"rows of {name} look like consecutive frames"):
        two_sample_test(**given, skeleton=walk.skeleton, metric="position", n_permutations=1)
    two_sample_test(X, X, skeleton=walk.skeleton, metric="position", n_permutations=1)  # in any order: no warning


# --- the kernel ------------------------------------------------------------------------------------------------------


# --- what changes nothing --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("statistic", STATISTICS)
@pytest.mark.parametrize("of_motions", [True, False])
def test_tiles_and_chunks_change_nothing(of_motions, statistic, monkeypatch):
    X, Y = (motions([7, 1, 12]), motions([3, 9], 0.3, seed=1)) if of_motions else (poses(12), poses(9, 0.1, seed=1))
    options = {"skeleton": TREE, "statistic": statistic, "random_state": 0, "n_permutations": 50}
    whole = two_sample_test(X, Y, **options)
    monkeypatch.setattr(_units, "POSES_FOR_WIDTH", 10**6 if statistic == "mmd" else 1)
    monkeypatch.setattr(_two_sample, "VALUES_AT_ONCE", 60)
    monkeypatch.setattr(_matrix, "ENCODED_AT_ONCE", 5)
    parts = two_sample_test(X, Y, **options)
    assert parts.pvalue == whole.pvalue
    np.testing.assert_allclose(parts.statistic, whole.statistic, rtol=1e-9)
    np.testing.assert_allclose(parts.null_distribution, whole.null_distribution, rtol=1e-9)


@pytest.mark.parametrize("statistic", STATISTICS)
def test_the_kinds_of_input_give_the_same(statistic):
    gait = make_gait(2, 3, activities=["walk"], frame_rate=12, duration=1, random_state=0)
    gait = MotionDataset([Motion(gait.skeleton, m.angles, m.frame_rate) for m in gait], subjects=gait.subjects)
    X, Y = gait[gait.subjects == "01"], gait[gait.subjects == "02"]
    options = {"metric": "position", "statistic": statistic}
    expected = two_sample_test(X, Y, **options)
    arrays = [motion.angles for motion in X], [motion.angles for motion in Y]
    for a, b in ((list(X), list(Y)), arrays, map(np.stack, arrays)):
        found = two_sample_test(a, b, skeleton=gait.skeleton, **options)
        assert (found.statistic, found.pvalue) == (expected.statistic, expected.pvalue)


def test_p_is_never_zero_and_the_least_is_reported():
    X, Y = poses(20), poses(20, 2.0, seed=1)
    found = two_sample_test(X, Y, metric="angle", random_state=0)
    assert found.pvalue == found.least_pvalue == 1 / 1000
    assert "pvalue=0.001, the least possible, 999 permutations, 20 against 20" in repr(found)
    three = two_sample_test(X[:3], X[3:6], metric="angle")
    assert three.least_pvalue == 0.1
    assert repr(two_sample_test(X[:5], X[5:10] + 1, metric="angle", paired=True)).endswith("exact, 5 pairs)")
    assert re.search(r"pvalue=\S+, (at least 0.1|the least possible), exact, 3 against 3", repr(three))


# --- errors ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("statistic", STATISTICS)
def test_two_people_of_hdm05(hdm05, statistic):
    """Squats of two people differ as much as so few permutations can show; those of one person do not."""
    squats = hdm05[hdm05.actions == "squat"]
    one, other = ([motion.resample(6) for motion in squats[squats.subjects == name]] for name in ("bd", "bk"))
    options = {"skeleton": squats.skeleton, "statistic": statistic, "metric": "position", "random_state": 0}
    assert two_sample_test(one, other, **options).pvalue == 0.001
    assert two_sample_test(one[::2], one[1::2], **options).pvalue > 0.05


@pytest.mark.parametrize("statistic", STATISTICS)
def test_walks_and_runs_of_cmu(cmu, statistic):
    """One person's walks and runs differ; every other of the walks does not differ from the rest."""
    own = cmu[cmu.subjects == "35"]
    walks, runs = ([motion.resample(6) for motion in own[own.actions == action]] for action in ("walk", "run/jog"))
    options = {"statistic": statistic, "metric": "position", "random_state": 0}
    assert two_sample_test(walks, runs, **options).pvalue == 0.001
    assert two_sample_test(walks[::2], walks[1::2], **options).pvalue > 0.05
