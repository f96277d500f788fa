"""`MotionDistanceTransformer(memory=)`: the numbers are those without it, each computed once; content decides."""

import collections
from pathlib import Path

import joblib
import numpy as np
import pytest
from sklearn.base import clone
from sklearn.exceptions import ConvergenceWarning
from sklearn.model_selection import GridSearchCV, KFold, ShuffleSplit, cross_val_score
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline

from skpose import MotionDistanceTransformer, Skeleton
from skpose.datasets import make_gait
from skpose.metrics import Spatial
from skpose.motions import _memory
from skpose.motions._matrix import MotionMatrix
from skpose.motions._memory import Block, split

ARM = Skeleton.chain(3)
LONGER = Skeleton([(b.name, b.parent, 2 * np.array(b.offset), b.dofs) for b in ARM.bones])


@pytest.fixture(scope="module")
def motions():
    rng = np.random.default_rng(0)
    return [rng.uniform(-3, 3, size=(n, 3)) for n in (4, 7, 1, 5, 6, 3, 8, 2, 4, 9)]


@pytest.fixture
def computed(monkeypatch):
    """How often the distance from one motion to another has been computed, by their content."""
    counts = collections.Counter()
    write = MotionMatrix.write

    def count(self, *arguments):
        rows, columns = ([one.motion(i).tobytes() for i in range(one.n_motions)] for one in (self.X, self.columns))
        for i, a in enumerate(rows):
            counts.update((a, b) for b in (columns[i + 1 :] if self.symmetric else columns))
        return write(self, *arguments)

    monkeypatch.setattr(MotionMatrix, "write", count)
    return counts


def knn(transformer):
    return make_pipeline(transformer, KNeighborsClassifier(1, metric="precomputed"))


def assert_same_in_all_folds(one, other, X, cv):
    """Distances are equal to the last bit, among the motions of each training set and from its test set to it."""
    for train, test in cv.split(X):
        first, second = ([X[i] for i in some] for some in (train, test))
        one, other = clone(one), clone(other)
        np.testing.assert_array_equal(one.fit_transform(first), other.fit_transform(first))
        np.testing.assert_array_equal(one.transform(second), other.transform(second))


# --- the same numbers, each computed once ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "parameters",
    [
        {},
        {"metric": "position"},
        {"metric": "rotation", "window": 0.2},
        {"metric": Spatial(3, wrap=False)},
        {"metric": "geodesic"},
        {"alignment": "subsequence"},
        {"alignment": "frames"},
        {"skeleton": ARM.with_weights([0.2, 1.0, 2.0])},
        {"skeleton": None, "metric": "angle"},
    ],
    ids=str,
)
@pytest.mark.filterwarnings("ignore:.*geodesics did not converge")
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_distances_are_those_without_a_memory_to_the_last_bit(motions, tmp_path, parameters, dtype):
    X = [motion.astype(dtype) for motion in motions]
    if parameters.get("alignment") == "frames":
        X = [np.resize(motion, (5, 3)) for motion in X]
    plain = MotionDistanceTransformer(**{"skeleton": ARM} | parameters)
    kept = clone(plain).set_params(memory=tmp_path)
    for _ in range(2):  # the second time all are known
        for cv in (KFold(3), KFold(3, shuffle=True, random_state=0), ShuffleSplit(3, random_state=0)):
            assert_same_in_all_folds(plain, kept, X, cv)
    assert kept.fit(X).transform(X).dtype == dtype


def test_each_distance_is_computed_once(motions, tmp_path, computed):
    """The ones from a to b and from b to a are two, as they may differ in the last bit."""
    y, requested = [0, 1] * 5, set()
    keys = [motion.tobytes() for motion in motions]
    model = knn(MotionDistanceTransformer(ARM, memory=tmp_path))
    for cv in (KFold(3), KFold(5, shuffle=True, random_state=1), ShuffleSplit(4, random_state=1)):
        for train, test in cv.split(motions):
            requested |= {(keys[i], keys[j]) for a, i in enumerate(train) for j in train[a + 1 :]}
            requested |= {(keys[i], keys[j]) for i in test for j in train}
        cross_val_score(model, motions, y, cv=cv)
        assert set(computed) == requested
        assert set(computed.values()) == {1}


def test_a_search_computes_each_distance_once_for_each_kind(motions, tmp_path, computed):
    y = [0, 1] * 5
    grid = {
        "motiondistancetransformer__metric__n_steps": [2, 5],
        "motiondistancetransformer__window": [None, 0.3],
        "kneighborsclassifier__n_neighbors": [1, 2, 3],
    }
    plain = knn(MotionDistanceTransformer(ARM, metric=Spatial()))
    expected = GridSearchCV(plain, grid, cv=KFold(3)).fit(motions, y)
    n_without, keys = sum(computed.values()), set(computed)
    computed.clear()
    kept = plain.set_params(motiondistancetransformer__memory=str(tmp_path))
    found = GridSearchCV(kept, grid, cv=KFold(3)).fit(motions, y)
    np.testing.assert_array_equal(found.cv_results_["mean_test_score"], expected.cv_results_["mean_test_score"])
    assert found.best_params_ == expected.best_params_
    assert set(computed) == keys
    assert sum(computed.values()) == 4 * len(keys) < n_without / 2
    assert len(list((tmp_path / "skpose_distances").iterdir())) == 4


@pytest.mark.slow
def test_processes_compute_each_distance_once(tmp_path):
    gait = make_gait(n_subjects=4, n_sequences=2, duration=1.5, random_state=0)
    X = [motion.resample(12).angles for motion in gait]
    grid = {"motiondistancetransformer__window": [None, 0.3], "kneighborsclassifier__n_neighbors": [1, 2]}
    transformer = MotionDistanceTransformer(gait.skeleton)
    expected = GridSearchCV(knn(transformer), grid, cv=KFold(4)).fit(X, gait.actions)
    kept = knn(clone(transformer).set_params(memory=tmp_path))
    found = GridSearchCV(kept, grid, cv=KFold(4), n_jobs=2).fit(X, gait.actions)
    np.testing.assert_array_equal(found.cv_results_["mean_test_score"], expected.cv_results_["mean_test_score"])
    kinds = list((tmp_path / "skpose_distances").iterdir())
    assert len(kinds) == 2
    for kind in kinds:
        counts = collections.Counter()
        for path in kind.iterdir():
            block = Block.load(path)
            counts.update((block.rows[i], block.columns[j]) for i, j in np.argwhere(~np.isnan(block.distances)))
        assert set(counts.values()) == {1}


def test_motions_of_equal_content_are_one(motions, tmp_path):
    X = [motions[0], motions[1], motions[0].copy(), motions[3], motions[1]]
    plain, kept = MotionDistanceTransformer(ARM), MotionDistanceTransformer(ARM, memory=tmp_path)
    for _ in range(2):
        np.testing.assert_array_equal(kept.fit_transform(X), plain.fit_transform(X))
        np.testing.assert_array_equal(kept.transform(X[::-1]), plain.transform(X[::-1]))


def test_some_motions_in_float32(motions, tmp_path):
    small = [motion.astype(np.float32) for motion in motions]
    plain, kept = MotionDistanceTransformer(ARM), MotionDistanceTransformer(ARM, memory=tmp_path)
    for fit, X in [
        (motions, motions),
        (small, small),
        (small, motions),
        (motions, small),
        ([*small[:3], *motions], small),
    ]:
        expected, found = plain.fit(fit).transform(X), kept.fit(fit).transform(X)
        np.testing.assert_array_equal(found, expected)
        assert found.dtype == expected.dtype


@pytest.mark.parametrize("triangle", [True, False])
@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 1.0])
@pytest.mark.parametrize("most", [1, 7, 1000])
def test_parts_are_what_is_missing(triangle, share, most):
    missing = np.random.default_rng(0).uniform(size=(9, 9 if triangle else 6)) < share
    missing = np.triu(missing, 1) if triangle else missing
    found = np.zeros(missing.shape, dtype=int)
    for rows, columns in split(missing, triangle, most):
        n_pairs = len(rows) * len(rows if columns is None else columns)
        assert n_pairs <= max(most, len(missing) if len(rows) == 1 else 0, missing.shape[1])
        part = np.triu(np.ones((len(rows), len(rows)), dtype=int), 1) if columns is None else 1
        found[np.ix_(rows, rows if columns is None else columns)] += part
    np.testing.assert_array_equal(found, missing)


# --- content decides -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "change",
    [
        {"metric": Spatial(9)},
        {"metric": Spatial(wrap=False)},
        {"metric": "position"},
        {"window": 0.5},
        {"alignment": "subsequence"},
        {"skeleton": ARM.with_weights([1.0, 1.0, 1.001])},
        {"skeleton": LONGER},
        {"skeleton": None, "metric": "angle"},
    ],
    ids=str,
)
def test_nothing_is_known_of_another_distance(motions, tmp_path, computed, change):
    plain = MotionDistanceTransformer(ARM)
    D = clone(plain).set_params(memory=tmp_path).fit_transform(motions)
    plain.set_params(**change)
    expected, _ = plain.fit_transform(motions), computed.clear()
    found = clone(plain).set_params(memory=tmp_path).fit_transform(motions)
    np.testing.assert_array_equal(found, expected)
    assert (found != D).any()
    n = len(motions)
    assert sum(computed.values()) == (n * n if plain.alignment == "subsequence" else n * (n - 1) // 2)


def test_only_a_motion_that_changed_is_computed_anew(motions, tmp_path, computed):
    kept = MotionDistanceTransformer(ARM, memory=tmp_path)
    kept.fit_transform(motions)
    changed = [motion.copy() for motion in motions]
    changed[4][3, 1] = np.nextafter(changed[4][3, 1], 9)  # the last bit of one number
    computed.clear()
    found = kept.fit_transform(changed)
    assert all(changed[4].tobytes() in pair for pair in computed)
    assert sum(computed.values()) == len(motions) - 1
    np.testing.assert_array_equal(found, MotionDistanceTransformer(ARM).fit_transform(changed))


def test_the_order_of_motions_does_not_decide(motions, tmp_path, computed):
    kept = MotionDistanceTransformer(ARM, memory=tmp_path).fit(motions)
    D = kept.transform(motions)
    computed.clear()
    order = np.random.default_rng(0).permutation(len(motions))
    shuffled = [motions[i] for i in order]
    np.testing.assert_array_equal(kept.fit(shuffled).transform(shuffled), D[np.ix_(order, order)])
    assert not computed


def test_a_mean_skeleton_is_one_of_each_training_set(tmp_path, computed):
    """So nothing is known, unless the skeleton is given."""
    gait = list(make_gait(n_subjects=3, n_sequences=1, duration=1.0, random_state=0))
    X = [motion.resample(12) for motion in gait]
    plain, kept = MotionDistanceTransformer(), MotionDistanceTransformer(memory=tmp_path)
    assert_same_in_all_folds(plain, kept, X, KFold(3))
    assert len(list((tmp_path / "skpose_distances").iterdir())) == 3


# --- files -----------------------------------------------------------------------------------------------------------


def test_a_folder_by_any_name(motions, tmp_path, computed):
    D = MotionDistanceTransformer(ARM, memory=tmp_path).fit_transform(motions)
    computed.clear()
    for memory in (str(tmp_path), Path(tmp_path), joblib.Memory(tmp_path, verbose=0)):
        np.testing.assert_array_equal(MotionDistanceTransformer(ARM, memory=memory).fit_transform(motions), D)
    assert not computed
    for memory in (None, joblib.Memory(None)):
        np.testing.assert_array_equal(MotionDistanceTransformer(ARM, memory=memory).fit_transform(motions), D)
    assert sum(computed.values()) == 2 * 45
    with pytest.raises(ValueError, match="'memory' parameter of MotionDistanceTransformer must be"):
        MotionDistanceTransformer(ARM, memory=3).fit(motions)


@pytest.mark.parametrize("inner", ["", "folder"])
def test_a_file_is_no_folder(motions, tmp_path, inner):
    file = tmp_path / "distances.npy"
    file.write_bytes(b"")
    words = f"memory must be a folder for distances.*got '{file / inner}': {file} is a file"
    with pytest.raises(NotADirectoryError, match=words):
        MotionDistanceTransformer(ARM, memory=str(file / inner)).fit(motions)


def test_an_interrupted_run_continues(motions, tmp_path, computed, monkeypatch):
    monkeypatch.setattr(_memory, "WORK_PER_BLOCK", 1.0)
    D = MotionDistanceTransformer(ARM).fit_transform(motions)
    computed.clear()
    write = MotionMatrix.write

    def stop(self, *arguments):
        if sum(computed.values()) > 20:
            raise KeyboardInterrupt
        return write(self, *arguments)

    kept = MotionDistanceTransformer(ARM, memory=tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(MotionMatrix, "write", stop)
        with pytest.raises(KeyboardInterrupt):
            kept.fit_transform(motions)
    assert 20 < sum(computed.values()) < 45
    np.testing.assert_array_equal(kept.fit_transform(motions), D)
    assert set(computed.values()) == {1}
    assert len(computed) == 45
    assert {path.suffix for path in tmp_path.rglob("*") if path.is_file()} == {".npz"}


def test_a_damaged_file_is_named(motions, tmp_path):
    kept = MotionDistanceTransformer(ARM, memory=tmp_path)
    D = kept.fit_transform(motions)
    (path,) = tmp_path.rglob("*.npz")
    content = bytearray(path.read_bytes())
    for damaged in (content[: len(content) // 2], b"", content[:-400] + bytes([content[-400] ^ 1]) + content[-399:]):
        path.write_bytes(damaged)
        with pytest.raises(ValueError, match=rf"{path.name}.* is damaged .*: delete it"):
            kept.fit_transform(motions)
    path.unlink()
    np.testing.assert_array_equal(kept.fit_transform(motions), D)


def test_geodesics_that_did_not_converge_are_said_each_time(motions, tmp_path, monkeypatch):
    write = MotionMatrix.write
    monkeypatch.setattr(MotionMatrix, "write", lambda self, *arguments: (write(self, *arguments)[0], [(2, 0.5)]))
    kept = MotionDistanceTransformer(ARM, memory=tmp_path)
    for _ in range(2):
        with pytest.warns(ConvergenceWarning, match=r"2 of 1050 geodesics did not converge.* is 0\.5$") as caught:
            kept.fit_transform(motions)
        assert [warning.filename for warning in caught] == [__file__]
