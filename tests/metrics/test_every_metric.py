"""What holds for every metric, including those of users, in every function that takes one."""

import functools
import os
import pickle
import subprocess
import sys

import numpy as np
import pytest
import reference
from every_metric import EVERY_METRIC, SKELETON, LargestDistance, measure_largest, measure_sum
from sklearn.base import clone
from sklearn.neighbors import KNeighborsClassifier

from skpose import PoseKNeighborsTransformer, motion_distances, pose_distances, pose_metric
from skpose.cluster import MedoidShift, PoseKMeans
from skpose.datasets import make_gait
from skpose.geodesics import frechet_mean, geometric_median
from skpose.manifold import SpatialMDS
from skpose.metrics import Angle, Metric, Position, Spatial, compile_encode, compile_measure, pose_distances_chunked
from skpose.motions import (
    MotionDistanceTransformer,
    MotionKNeighborsTransformer,
    align_motions,
    find_motion,
)
from skpose.neighbors import PoseRadiusNeighborsTransformer
from skpose.preprocessing import PoseDistanceTransformer
from skpose.statistics import PoseKernelRegressor, PoseTangentPCA, two_sample_test

X = np.random.default_rng(0).normal(0.0, 0.5, size=(12, SKELETON.n_dofs))
GAIT = make_gait(2, 1, frame_rate=6, duration=2, random_state=0)
ROUNDING = 1e-12


SLOW = {entry.metric.label for entry in EVERY_METRIC if entry.metric.iterative} | {"heights"}
ENTRIES = [
    pytest.param(entry, id=entry.metric.label, marks=pytest.mark.slow if entry.metric.label in SLOW else ())
    for entry in EVERY_METRIC
]


@pytest.fixture(params=ENTRIES, scope="module")
def entry(request):
    return request.param


@pytest.fixture(scope="module")
def metric(entry):
    return entry.metric


@pytest.fixture(scope="module")
def D(metric):
    return pose_distances(X, skeleton=SKELETON, metric=metric)


def test_matrices(entry, metric, D):
    if entry.distances is not None:
        np.testing.assert_allclose(D, entry.distances(X, X, SKELETON), rtol=0, atol=1e-9)
    assert (D == D.T).all()
    assert (np.diag(D) == 0).all()
    assert (D[~np.eye(len(D), dtype=bool)] > 0).all()
    assert (pose_distances(X, skeleton=SKELETON, metric=metric, n_jobs=2) == D).all()
    single = pose_distances(X.astype(np.float32), skeleton=SKELETON, metric=metric)
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, D, rtol=1e-4)
    chunks = pose_distances_chunked(X, skeleton=SKELETON, metric=metric, working_memory=1e-3)
    of_two, dask = pose_metric(SKELETON, metric=metric), pytest.importorskip("dask.array")
    lazy = pose_distances(dask.from_array(X, chunks=(5, -1)), skeleton=SKELETON, metric=metric)
    for found in (np.concatenate(list(chunks)), lazy.compute()):
        np.testing.assert_allclose(found, D, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose([of_two(X[0], x) for x in X], D[0], rtol=0, atol=1e-9)


def test_neighbours_are_those_of_the_matrix(metric, D):
    others = D + np.diag(np.full(len(D), np.inf))
    nearest = PoseKNeighborsTransformer(SKELETON, n_neighbors=3, metric=metric).fit(X)
    distances, indices = nearest.kneighbors()
    assert (indices == others.argsort(axis=1, kind="stable")[:, :3]).all()
    assert np.allclose(distances, np.sort(others, axis=1)[:, :3], rtol=0, atol=1e-9)
    radius = float(np.median(D))
    within = PoseRadiusNeighborsTransformer(SKELETON, radius=radius, metric=metric).fit(X)
    assert [sorted(row) for row in within.radius_neighbors(return_distance=False)] == [
        np.flatnonzero(row <= radius).tolist() for row in others
    ]


@pytest.mark.filterwarnings("ignore:the default bandwidth:UserWarning")
def test_estimators_of_poses(metric, D):
    transformed = PoseDistanceTransformer(SKELETON, metric=metric).fit(X).transform(X)
    np.testing.assert_allclose(transformed, D, rtol=0, atol=ROUNDING)
    mds = SpatialMDS(SKELETON, n_components=2, metric=metric).fit(X)
    given = SpatialMDS(n_components=2, metric="precomputed").fit(D)
    np.testing.assert_allclose(mds.explained_variance_ratio_, given.explained_variance_ratio_)
    assert mds.metric_ == metric
    assert mds.metric_ is not metric
    labels = MedoidShift(SKELETON, metric=metric).fit(X).labels_
    assert (labels == MedoidShift(metric="precomputed").fit(D).labels_).all()
    of_pairs = KNeighborsClassifier(1, metric=pose_metric(SKELETON, metric=metric), algorithm="brute")
    assert (of_pairs.fit(X, range(len(X))).predict(X) == range(len(X))).all()


def test_whole_motions(entry, metric):
    poses, skeleton = [motion.angles for motion in GAIT], GAIT.skeleton
    found = motion_distances(GAIT, metric=metric)
    if entry.distances is not None:
        costs = entry.distances(poses[0], poses[1], skeleton)
        assert found[0, 1] == pytest.approx(reference.least_sum(costs) / sum(costs.shape), rel=1e-9)
        of_two = motion_distances([GAIT[0]], [GAIT[1]], metric=metric)[0, 0]  # whose skeleton is the mean of two
        assert align_motions(GAIT[0], GAIT[1], metric=metric).distance == pytest.approx(of_two, rel=1e-9)
    assert np.allclose(MotionDistanceTransformer(metric=metric).fit_transform(GAIT), found, rtol=0, atol=1e-9)
    near = MotionKNeighborsTransformer(metric=metric, n_neighbors=1).fit(GAIT)
    others = found + np.diag(np.full(len(found), np.inf))
    assert (near.kneighbors()[1].ravel() == others.argmin(axis=1)).all()
    (match,) = find_motion(GAIT[1].angles[3:9], poses, k=1, skeleton=skeleton, metric=metric)
    assert (match.motion, match.start, match.stop) == (1, 3, 9)
    if not metric.iterative:  # whose pairs take long one at a time
        statistic = two_sample_test(GAIT.motions[:2], GAIT.motions[2:], metric=metric).statistic
        of_two = pose_metric(skeleton, metric=metric)
        assert statistic == pytest.approx(reference.two_sample_statistic(poses[:2], poses[2:], of_two), rel=1e-9)


def call_means(metric):
    k_means = PoseKMeans(SKELETON, n_clusters=2, metric=metric, n_init=1, max_iter=2, tol=1.0, random_state=0)
    yield lambda: frechet_mean(X, SKELETON, metric=metric)
    yield lambda: geometric_median(X, SKELETON, metric=metric)
    yield lambda: k_means.fit(X)
    yield lambda: PoseKernelRegressor(SKELETON, metric=metric).fit(X[:, :1], X)
    yield lambda: PoseTangentPCA(SKELETON, metric=metric).fit(X)


# Means under the other metrics have tests of their own in tests/geodesics.
@pytest.mark.parametrize("metric", [Angle(), Position(), LargestDistance()], ids=lambda metric: metric.label)
@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning")
def test_means_are_found_or_refused(metric):
    errors = []
    for call in call_means(metric):
        try:
            call()
        except ValueError as error:
            errors.append(str(error))
    assert all("does not have" in error for error in errors)
    assert (len(errors) == 5) == (not metric.has_means)


def test_objects_are_equal_copied_and_pickled():
    for metric in (LargestDistance(), *(entry.metric for entry in EVERY_METRIC)):
        assert metric == clone(metric) == pickle.loads(pickle.dumps(metric))
        assert hash(metric) == hash(clone(metric))
    assert len({entry.metric for entry in EVERY_METRIC}) == len(EVERY_METRIC)


# --- metrics of users ------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_functions_use_no_memory_that_is_free():
    # GNU's allocator writes this byte over all that is freed; without it, the old content may still be there.
    code = """
import numpy as np
from every_metric import EVERY_METRIC, SKELETON
from skpose import pose_distances

X = np.random.default_rng(0).normal(0.0, 0.5, size=(12, SKELETON.n_dofs))
(entry,) = [entry for entry in EVERY_METRIC if "compile_encode" in entry.metric.encode.__qualname__]
found = pose_distances(X, skeleton=SKELETON, metric=entry.metric, n_jobs=2)
print(np.abs(found - entry.distances(X, X, SKELETON)).max())
"""
    environment = os.environ | {"MALLOC_PERTURB_": "165", "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert float(done.stdout) < 1e-9


def test_a_metric_with_another_measure_inherits_no_bounds():
    with pytest.raises(TypeError, match="Longest must derive from Metric"):

        class Longest(Position):
            measure = measure_largest

    class Renamed(LargestDistance):  # of which everything is still true
        name = "another"
        measure = measure_largest

    assert Renamed() != LargestDistance()


def own_metric(length=lambda tree, n_dofs: n_dofs, **members):
    """A metric of a user, whose code is the columns."""
    members = {"encode": Angle.encode, "measure": measure_sum, "needs_skeleton": False, **members}
    return type("Own", (Metric,), {"n_codes": lambda self, tree, n_dofs: length(tree, n_dofs), **members})()


@compile_encode
def encode_twice(pose, positions, code):
    for d in range(len(pose)):
        code[d], code[len(pose) + d] = pose[d], 2.0 * pose[d]


@compile_encode
def encode_some(pose, positions, code):
    if pose[0] < 5.0:
        code[:] = pose


@compile_measure
def measure_signed(a, b):
    return a[0] - b[0] + 5.0 * (a[0] != b[0])


@compile_measure
def measure_beyond(a, b):
    return abs(a[len(a)] - b[0])


@compile_measure
def measure_from_one(a, b):
    return 1.0 + np.abs(a - b).sum()


@compile_measure
def measure_some(a, b):
    return np.nan if a[0] * b[0] < -1.0 else np.abs(a - b).sum()


@pytest.mark.parametrize(
    ("metric", "message"),
    [
        (own_metric(lambda tree, n_dofs: n_dofs + 1), "n_codes"),
        (own_metric(lambda tree, n_dofs: 2.0 * n_dofs, encode=encode_twice), "n_codes"),
        (own_metric(encode=encode_twice), "out of bounds"),
        (own_metric(lambda tree, n_dofs: 3 * n_dofs, encode=encode_twice), "encode_twice must write"),
        (own_metric(measure=measure_signed), "symmetric"),
        (own_metric(measure=measure_beyond), "out of bounds"),
        (own_metric(measure=measure_from_one), "zero for equal poses"),
        (own_metric(measure=lambda a, b: 0.0), "compile_measure"),
    ],
)
def test_functions_that_measure_no_distance_are_refused(metric, message):
    """Compiled, they would write into other memory, or give plausible numbers."""
    for call in (lambda: pose_distances([[0.0, 1.0], [2.0, 3.0]], metric=metric), lambda: pose_metric(metric=metric)):
        with pytest.raises((ValueError, IndexError), match=message):
            call()


FAR = np.array([[-1.0], [9.0], [1.0], [-1.0], [9.0], [0.0]])
CALLS = {
    "pose_distances": lambda metric: pose_distances(FAR, metric=metric),
    "pose_metric": lambda metric: pose_metric(metric=metric)(*FAR[:2]),
    "k nearest": lambda metric: PoseKNeighborsTransformer(metric=metric, n_neighbors=2).fit(FAR).kneighbors(),
    "motion_distances": lambda metric: motion_distances([FAR, FAR[::-1]], metric=metric),
}


@pytest.mark.slow
@pytest.mark.parametrize("call", CALLS)
def test_numbers_that_are_no_distances_are_errors(call):
    """Two example poses do not show what a function does with all others."""
    for metric, name in (
        (own_metric(measure=measure_some), "measure_some"),
        (own_metric(encode=encode_some), "encode_some"),
    ):
        with pytest.raises(ValueError, match=name):
            CALLS[call](metric)


@pytest.mark.slow
def test_a_code_may_be_longer_than_a_pose():
    metric, poses = own_metric(lambda tree, n_dofs: 2 * n_dofs, encode=encode_twice), np.array([[0.0, 1.0], [2.0, 5.0]])
    assert pose_distances(poses, metric=metric)[0, 1] == pytest.approx(18.0)
    assert pose_metric(metric=metric)(*poses) == pytest.approx(18.0)


def test_a_lower_bound_must_be_euclidean():
    class Fine(LargestDistance):
        def lower_bound(self):
            return Spatial(2)

    with pytest.raises(ValueError, match="lower bound"):
        PoseKNeighborsTransformer(SKELETON, metric=Fine()).fit(X)


class Scaled(Metric):
    """A metric whose compiled function depends on a parameter."""

    encode = Angle.encode
    needs_skeleton = False

    def __init__(self, scale=1.0):
        self.scale = scale

    @property
    def measure(self):
        return measure_scaled(self.scale)

    def n_codes(self, tree, n_dofs):
        return n_dofs


@functools.cache
def measure_scaled(scale):
    @compile_measure
    def measure(a, b):
        return scale * np.abs(a - b).sum()

    return measure


@pytest.mark.slow
def test_compiled_functions_may_depend_on_parameters():
    assert [pose_distances([[0.0], [1.0]], metric=Scaled(s))[0, 1] for s in (1.0, 3.0)] == [1.0, 3.0]
    assert (Scaled().label, Scaled(3.0).label) == ("Scaled", "Scaled(scale=3.0)")
