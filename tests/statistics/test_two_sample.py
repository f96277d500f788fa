"""The test of two sets: its statistics by definition, its p-values by scipy's, level and power, what is permuted."""

import re
from itertools import combinations, product
from math import comb

import numpy as np
import pytest
import reference
from conftest import random_tree
from scipy import stats
from sklearn.exceptions import ConvergenceWarning

from skpose import Motion, PoseDistanceTransformer, Skeleton, pose_distances
from skpose.datasets import MotionDataset, make_gait
from skpose.metrics._convergence import Unconverged
from skpose.metrics._matrix import DistanceMatrix
from skpose.metrics._registry import METRICS
from skpose.statistics import _permutations, _unit_means, two_sample_test

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


@pytest.mark.parametrize("paired", [False, True])
def test_random_p_values_agree_with_all_splits(paired):
    X, Y = poses(8), poses(8, 0.06, seed=1)
    options = {"skeleton": TREE, "metric": "position", "paired": paired}
    n = 256 if paired else comb(16, 8)
    every, drawn = (
        two_sample_test(X, Y, n_permutations=n_permutations, random_state=0, **options)
        for n_permutations in (n, n - 1 if paired else 5000)
    )
    assert every.exact
    assert not drawn.exact
    n_drawn = len(drawn.null_distribution)
    assert drawn.pvalue == (1 + np.sum(drawn.null_distribution >= drawn.statistic * (1 - 1e-12))) / (1 + n_drawn)
    assert 0.02 < every.pvalue < 0.9  # where a Monte Carlo error shows
    assert abs(drawn.pvalue - every.pvalue) < 5 * np.sqrt(every.pvalue * (1 - every.pvalue) / n_drawn)
    assert drawn.least_pvalue == 1 / (n_drawn + 1)
    # Each value of all splits is drawn about equally often: the mean and the spread of the two agree.
    assert drawn.null_distribution.mean() == pytest.approx(every.null_distribution.mean(), rel=0.2)


def test_pairs_exchange_their_two_members_alone():
    """The difference of the pairs is constant, and small among the people: only the paired test finds it."""
    people = poses(8, seed=3) * 3.0
    before, after = people + poses(8, seed=4) * 0.02, people + 0.1 + poses(8, seed=5) * 0.02
    assert two_sample_test(before, after, metric="angle", paired=True).pvalue == 2 / 2**8
    assert two_sample_test(before, after, metric="angle", random_state=0).pvalue > 0.5


def test_the_splits_of_a_small_paired_design():
    X, Y = motions([2, 3, 1]), motions([1, 2, 4], 0.5, seed=1)
    found = two_sample_test(X, Y, skeleton=TREE, metric="angle", paired=True)
    expected = []
    for flips in product([False, True], repeat=3):
        one, other = zip(*[(b, a) if flip else (a, b) for a, b, flip in zip(X, Y, flips, strict=True)], strict=True)
        expected.append(reference.two_sample_statistic(one, other, lambda a, b: np.linalg.norm(a - b)))
    np.testing.assert_allclose(np.sort(found.null_distribution), np.sort(expected))


def test_the_splits_of_motions():
    X, Y = motions([2, 3]), motions([1, 2, 4], 0.5, seed=1)
    found = two_sample_test(X, Y, skeleton=TREE, metric="angle")
    expected = [
        reference.two_sample_statistic(
            [(X + Y)[i] for i in chosen],
            [(X + Y)[i] for i in range(5) if i not in chosen],
            lambda a, b: np.linalg.norm(a - b),
        )
        for chosen in combinations(range(5), 2)
    ]
    np.testing.assert_allclose(np.sort(found.null_distribution), np.sort(expected))
    assert found.pvalue == np.mean(np.array(expected) >= expected[0] * (1 - 1e-12))


@pytest.mark.parametrize("statistic", STATISTICS)
def test_equal_sets_have_statistic_zero_and_p_one(statistic):
    X = poses(6)
    found = two_sample_test(X, X[::-1].copy(), skeleton=TREE, metric="position", statistic=statistic)
    assert found.statistic == pytest.approx(0, abs=1e-12)
    assert found.pvalue == 1.0


@pytest.mark.parametrize("statistic", STATISTICS)
def test_poses_that_are_all_equal_do_not_differ(statistic):
    X = np.zeros((4, TREE.n_dofs))
    found = two_sample_test(X, X, skeleton=TREE, metric="position", statistic=statistic)
    assert (found.statistic, found.pvalue) == (0.0, 1.0)


# --- level and power -------------------------------------------------------------------------------------------------


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


@pytest.mark.parametrize("statistic", STATISTICS)
def test_sets_of_equal_means_that_spread_differently_are_found(statistic):
    X, Y = poses(40), 2.0 * poses(40, seed=1)
    found = two_sample_test(X, Y, metric="angle", statistic=statistic, random_state=0)
    assert found.pvalue == 0.001


def recordings(rng, n, n_frames=12):
    """Recordings of one person, each with a posture of its own, that the frames share."""
    return [rng.normal(size=2) + 0.3 * rng.normal(size=(n_frames, 2)) for _ in range(n)]


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
    with pytest.warns(UserWarning, match=rf"rows of {name} follow one another .* pass a list of motions"):
        two_sample_test(**given, skeleton=walk.skeleton, metric="position", n_permutations=1)
    two_sample_test(X, X, skeleton=walk.skeleton, metric="position", n_permutations=1)  # in any order: no warning


def test_independent_rows_give_no_warning():
    rng = np.random.default_rng(0)
    for n in (2, 5, 17, 30, 100, 400):
        for _ in range(30):  # clusters in one dimension are the farthest from normal
            X, Y = (rng.normal(0, 0.1, (n, 1)) + 5.0 * (rng.random((n, 1)) < 0.1) for _ in range(2))
            two_sample_test(X, Y, metric="angle", n_permutations=1, random_state=0)


# --- the kernel ------------------------------------------------------------------------------------------------------


def test_the_kernel_is_repaired():
    """Poses on which the kernel of "spatial" has negative eigenvalues; the statistic is of the repaired one."""
    X = np.random.default_rng(0).uniform(-3, 3, (40, TREE.n_dofs))
    found = two_sample_test(X[:20], X[20:], skeleton=TREE, metric="spatial", statistic="mmd", random_state=0)
    gamma = 0.5 / found.width**2
    transformer = PoseDistanceTransformer(TREE, metric="spatial", kernel="rbf", gamma=gamma, psd="clip")
    K = transformer.fit_transform(X)
    assert found.negative_share == pytest.approx(transformer.negative_share_)
    assert found.negative_share > 0
    expected = -statistic_of_indices(K)(np.arange(20), np.arange(20, 40))
    assert found.statistic == pytest.approx(expected, rel=1e-9)
    assert found.null_distribution.min() > 0
    unrepaired = PoseDistanceTransformer(TREE, metric="spatial", kernel="rbf", gamma=gamma).fit_transform(X)
    assert found.statistic != pytest.approx(-statistic_of_indices(unrepaired)(np.arange(20), np.arange(20, 40)))


def test_the_width_does_not_depend_on_the_split():
    everything = motions([700, 30, 40, 200], skeleton=CHAIN)  # of the first not all poses are taken
    one = two_sample_test(everything[:2], everything[2:], skeleton=CHAIN, statistic="mmd")
    other = two_sample_test(
        [everything[2], everything[0]], [everything[3], everything[1]], skeleton=CHAIN, statistic="mmd"
    )
    assert one.width == pytest.approx(other.width, rel=1e-12)
    np.testing.assert_allclose(np.sort(one.null_distribution), np.sort(other.null_distribution), rtol=1e-9)


def test_the_width_from_some_of_the_poses_is_near_that_from_all(monkeypatch):
    X, Y = motions([300, 40, 250]), motions([100, 350], 0.3, seed=1)
    some = two_sample_test(X, Y, metric="angle", statistic="mmd")
    monkeypatch.setattr(_unit_means, "POSES_FOR_WIDTH", 10**6)
    every = two_sample_test(X, Y, metric="angle", statistic="mmd")
    assert some.width != every.width
    assert some.width == pytest.approx(every.width, rel=0.1)
    assert some.statistic == pytest.approx(every.statistic, rel=0.1)


# --- what changes nothing --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("statistic", STATISTICS)
@pytest.mark.parametrize("of_motions", [True, False])
def test_tiles_and_chunks_change_nothing(of_motions, statistic, monkeypatch):
    X, Y = (motions([7, 1, 12]), motions([3, 9], 0.3, seed=1)) if of_motions else (poses(12), poses(9, 0.1, seed=1))
    options = {"skeleton": TREE, "statistic": statistic, "random_state": 0, "n_permutations": 50}
    whole = two_sample_test(X, Y, **options)
    monkeypatch.setattr(_unit_means, "POSES_FOR_WIDTH", 10**6 if statistic == "mmd" else 1)
    monkeypatch.setattr(_permutations, "VALUES_AT_ONCE", 60)
    monkeypatch.setattr(_unit_means, "TILE", 5)
    parts = two_sample_test(X, Y, **options)
    assert parts.pvalue == whole.pvalue
    np.testing.assert_allclose(parts.statistic, whole.statistic, rtol=1e-9)
    np.testing.assert_allclose(parts.null_distribution, whole.null_distribution, rtol=1e-9)


def test_the_kernel_tile_by_tile(monkeypatch):
    X, Y = motions([20, 1, 30]), motions([8, 25], 0.3, seed=1)
    monkeypatch.setattr(_unit_means, "POSES_FOR_WIDTH", 10)
    whole = two_sample_test(X, Y, skeleton=TREE, statistic="mmd")
    monkeypatch.setattr(_unit_means, "TILE", 6)
    parts = two_sample_test(X, Y, skeleton=TREE, statistic="mmd")
    assert parts.width == whole.width
    np.testing.assert_allclose(parts.null_distribution, whole.null_distribution, rtol=1e-9)


def test_no_matrix_between_frames_is_kept(monkeypatch):
    shapes = []
    write = DistanceMatrix.write

    def recorded(self, *arguments):
        shapes.append(self.shape)
        return write(self, *arguments)

    monkeypatch.setattr(DistanceMatrix, "write", recorded)
    monkeypatch.setattr(_unit_means, "TILE", 64)
    two_sample_test(motions([150, 90]), motions([130], seed=1), metric="angle")
    assert max(map(max, shapes)) == 64
    assert sum(n * m if n != m else n * (n + 1) // 2 for n, m in shapes) < 0.62 * 370**2  # one triangle


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


def test_rows_are_motions_of_one_frame():
    X, Y = poses(5), poses(4, 0.2, seed=1)
    for statistic in STATISTICS:
        options = {"skeleton": TREE, "metric": "spatial", "statistic": statistic}
        rows, one_frame = two_sample_test(X, Y, **options), two_sample_test(X[:, None], Y[:, None], **options)
        lists = two_sample_test(X.tolist(), Y.tolist(), **options)
        assert rows.statistic == one_frame.statistic == lists.statistic
        assert rows.pvalue == one_frame.pvalue == lists.pvalue


def test_a_data_frame_is_poses():
    pandas = pytest.importorskip("pandas")
    X, Y = (pandas.DataFrame(one, columns=list(TREE.dof_names)) for one in (poses(5), poses(4, 0.2, seed=1)))
    found = two_sample_test(X, Y, skeleton=TREE, metric="position")
    assert found.pvalue == two_sample_test(X.to_numpy(), Y.to_numpy(), skeleton=TREE, metric="position").pvalue
    with pytest.raises(ValueError, match="columns of Y"):
        two_sample_test(X, Y[list(TREE.dof_names[::-1])], skeleton=TREE)


def test_each_motion_counts_once():
    """Every pose of a motion, given several times, changes nothing, nor does the order of its frames."""
    X, Y = motions([4, 3]), motions([2, 5, 3], 0.3, seed=1)
    expected = two_sample_test(X, Y, skeleton=TREE)
    found = two_sample_test([np.repeat(X[0], 5, axis=0), X[1][::-1]], Y, skeleton=TREE)
    np.testing.assert_allclose(found.null_distribution, expected.null_distribution, rtol=1e-9)


def test_exchanging_the_sets_changes_nothing():
    X, Y = motions([4, 3]), motions([2, 5, 3], 0.3, seed=1)
    one, other = two_sample_test(X, Y, skeleton=TREE), two_sample_test(Y, X, skeleton=TREE)
    assert one.statistic == pytest.approx(other.statistic)
    assert one.pvalue == other.pvalue


def test_float32_and_threads():
    X, Y = poses(30), poses(25, 0.1, seed=1)
    options = {"skeleton": TREE, "random_state": 0}
    expected = two_sample_test(X, Y, **options)
    assert two_sample_test(X, Y, n_jobs=2, **options).statistic == expected.statistic
    single = two_sample_test(X.astype(np.float32), Y.astype(np.float32), **options)
    assert single.statistic == pytest.approx(expected.statistic, rel=1e-4)
    assert single.pvalue == pytest.approx(expected.pvalue, abs=0.01)


def test_random_state():
    X, Y = poses(12), poses(12, 0.05, seed=1)
    null = [
        two_sample_test(X, Y, metric="angle", random_state=state).null_distribution
        for state in (0, 0, np.random.RandomState(0), 1)
    ]
    assert (null[0] == null[1]).all()
    assert (null[0] == null[2]).all()
    assert (null[0] != null[3]).any()


def test_ties_count_as_larger():
    """Four poses at two places: splits have few values, and rounding makes no difference between equal ones."""
    X = np.array([[0.1], [0.1], [0.7], [0.7]])
    found = two_sample_test(X[[0, 2]], X[[1, 3]], metric="angle")
    assert found.pvalue == 1.0
    found = two_sample_test(X[:2], X[2:], metric="angle")
    assert found.pvalue == found.least_pvalue == pytest.approx(1 / 3)


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


@pytest.mark.parametrize(
    ("X", "Y", "options", "error", "message"),
    [
        (poses(3), motions([2, 3]), {}, ValueError, "X is poses and Y motions: pass lists of motions, or two arrays"),
        (motions([2, 3]), poses(3), {}, ValueError, "X is motions and Y poses"),
        (
            poses(3),
            poses(4),
            {"paired": True},
            ValueError,
            "X has 3 poses and Y has 4: leave out those without a partn",
        ),
        (motions([2]), motions([3]), {}, ValueError, "one of the motions each, so that p would be 1"),
        (poses(1), poses(1), {}, ValueError, "one of the poses each, so that p would be 1"),
        (poses(1), poses(1), {"paired": True}, ValueError, "one of the poses each"),
        (poses(3), poses(3)[:, 1:], {"skeleton": None, "metric": "angle"}, ValueError, "Y has .* equally many"),
        (poses(3)[:, 1:], poses(3), {}, ValueError, "X has"),
        (poses(3), np.full((3, TREE.n_dofs), np.nan), {}, ValueError, "Y contains NaN"),
        (poses(3), poses(3)[0], {}, ValueError, "1D array"),
        (poses(3), poses(3), {"skeleton": None, "metric": "position"}, ValueError, "needs a skeleton"),
        (poses(3), poses(3), {"statistic": "t"}, ValueError, "'statistic' parameter"),
        (poses(3), poses(3), {"n_permutations": 0}, ValueError, "'n_permutations' parameter"),
        (poses(3), None, {}, (TypeError, ValueError), "Y must be"),
    ],
)
def test_errors(X, Y, options, error, message):
    with pytest.raises(error, match=message):
        two_sample_test(X, Y, **{"skeleton": TREE} | options)


def test_one_motion_in_the_place_of_several():
    motion = Motion(TREE, motions([4])[0], 12)
    with pytest.raises(TypeError, match=r"X must be motions: .* got one Motion: pass \[X\]"):
        two_sample_test(motion, [motion])
    with pytest.raises(TypeError, match="X and Y must be all skpose"):
        two_sample_test([motion], [motion.angles, motion.angles])


def test_warnings():
    X, Y = np.degrees(poses(30, 0.3)), np.degrees(poses(30, 0.3, seed=1))
    with pytest.warns(UserWarning, match="values of X reach .* degrees"):
        two_sample_test(X, Y, skeleton=TREE, n_permutations=1)
    with pytest.warns(UserWarning, match='metric="auto" without a skeleton means "angle"'):
        two_sample_test(X, Y, n_permutations=1)


@pytest.mark.parametrize("statistic", STATISTICS)
def test_unconverged_geodesics_give_one_warning(statistic, monkeypatch):
    distances = DistanceMatrix.distances

    def unconverged(self, *arguments):
        return distances(self, *arguments)[0], Unconverged(1, 0.5)

    monkeypatch.setattr(DistanceMatrix, "distances", unconverged)
    monkeypatch.setattr(_unit_means, "TILE", 4)
    with pytest.warns(ConvergenceWarning) as caught:
        two_sample_test(poses(4), poses(3), skeleton=TREE, statistic=statistic)
    assert len(caught) == 1
    assert "of 21 geodesics did not converge" in str(caught[0].message)


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
