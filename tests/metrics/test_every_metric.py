"""What holds for every metric, those of one's own too: through all that takes one."""

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

from skpose import (
    MedoidShift,
    MotionDistanceTransformer,
    MotionKNeighborsTransformer,
    PoseDistanceTransformer,
    PoseKNeighborsTransformer,
    PoseRadiusNeighborsTransformer,
    SpatialMDS,
    motion_distances,
    pose_distances,
    pose_distances_chunked,
    pose_metric,
)
from skpose.cluster import PoseKMeans
from skpose.datasets import make_gait
from skpose.geodesics import frechet_mean, geometric_median
from skpose.metrics import Angle, Metric, Position, Spatial, compile_encode, compile_measure
from skpose.metrics._shared import metric_fingerprint
from skpose.motions import align_motions, find_motion, mean_motion, segment_repetitions
from skpose.statistics import PoseKernelRegressor, PoseTangentPCA, two_sample_test
from skpose.view import explorer

X = np.random.default_rng(0).normal(0.0, 0.5, size=(12, SKELETON.n_dofs))
GAIT = make_gait(2, 1, frame_rate=6, duration=2, random_state=0)
ROUNDING = 1e-12


@pytest.fixture(params=EVERY_METRIC, ids=lambda entry: entry.metric.label, scope="module")
def entry(request):
    return request.param


@pytest.fixture(scope="module")
def metric(entry):
    return entry.metric


@pytest.fixture(scope="module")
def D(metric):
    return pose_distances(X, skeleton=SKELETON, metric=metric)


def test_distances_are_those_of_the_definition(entry, D):
    if entry.distances is None:
        pytest.skip("found by a search")
    assert np.allclose(D, entry.distances(X, X, SKELETON), rtol=0, atol=1e-9)


def test_distances_are_symmetric_and_zero_on_the_diagonal(metric, D):
    assert (D == D.T).all()
    assert (np.diag(D) == 0).all()
    assert (D[~np.eye(len(D), dtype=bool)] > 0).all()
    twice = pose_distances(X, X.copy(), skeleton=SKELETON, metric=metric)
    assert np.allclose(twice, D, rtol=0, atol=ROUNDING)
    assert (np.diag(twice) == 0).all()


def test_float32_differs_by_rounding(metric, D):
    found = pose_distances(X.astype(np.float32), skeleton=SKELETON, metric=metric)
    assert found.dtype == np.float32
    assert np.allclose(found, D, rtol=1e-4)


def test_chunks_threads_and_pairs_give_the_same(metric, D):
    chunks = pose_distances_chunked(X, skeleton=SKELETON, metric=metric, working_memory=1e-3)
    assert np.allclose(np.concatenate(list(chunks)), D, rtol=0, atol=ROUNDING)
    assert (pose_distances(X, skeleton=SKELETON, metric=metric, n_jobs=2) == D).all()
    of_two = pose_metric(SKELETON, metric=metric)
    assert np.allclose([of_two(X[0], x) for x in X], D[0], rtol=0, atol=1e-9)


def test_functions_of_ones_own_use_no_memory_that_is_free():
    # GNU's allocator writes this byte over all that is freed; without it, what was there may be there still.
    code = """
import numpy as np
from every_metric import EVERY_METRIC, SKELETON
from skpose import pose_distances

X = np.random.default_rng(0).normal(0.0, 0.5, size=(12, SKELETON.n_dofs))
for entry in EVERY_METRIC:
    if hasattr(entry.metric.encode, "plain"):
        for n_jobs in (1, 2):
            found = pose_distances(X, skeleton=SKELETON, metric=entry.metric, n_jobs=n_jobs)
            print(np.abs(found - entry.distances(X, X, SKELETON)).max())
"""
    environment = os.environ | {"MALLOC_PERTURB_": "165", "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    differences = [float(line) for line in done.stdout.split()]
    assert len(differences) == 2
    assert max(differences) < 1e-9


def test_dask_gives_the_same(metric, D):
    array = pytest.importorskip("dask.array")
    found = pose_distances(array.from_array(X, chunks=(5, -1)), skeleton=SKELETON, metric=metric).compute()
    assert np.allclose(found, D, rtol=0, atol=ROUNDING)


def test_a_matrix_in_a_file_knows_its_metric(metric, D, tmp_path):
    out = np.lib.format.open_memmap(tmp_path / "D.npy", "w+", np.float64, D.shape)
    assert np.allclose(pose_distances(X, skeleton=SKELETON, metric=metric, out=out), D, rtol=0, atol=ROUNDING)


def test_bounds_are_bounds(metric, D):
    for bound, sign in ((metric.lower_bound(), 1), (metric.upper_bound(), -1)):
        if bound is not None:
            assert (sign * (D - pose_distances(X, skeleton=SKELETON, metric=bound)) >= -1e-9).all()
    if (lower := metric.lower_bound()) is not None:
        codes = lower.encode_poses(X, SKELETON)
        of_codes = np.linalg.norm(codes[:, None] - codes[None], axis=2)
        assert np.allclose(of_codes, pose_distances(X, skeleton=SKELETON, metric=lower), rtol=0, atol=1e-9)


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


def test_estimators_of_poses_take_it(metric, D):
    assert np.allclose(PoseDistanceTransformer(SKELETON, metric=metric).fit(X).transform(X), D, rtol=0, atol=ROUNDING)
    for estimator in (SpatialMDS(SKELETON, n_components=2), MedoidShift(skeleton=SKELETON)):
        own = clone(estimator).set_params(metric=metric).fit(X)
        given = clone(estimator).set_params(metric="precomputed", skeleton=None).fit(D)
        assert own.metric_ == metric
        assert own.metric_ is not metric
        if hasattr(own, "labels_"):
            assert (own.labels_ == given.labels_).all()
        else:
            assert np.allclose(own.explained_variance_ratio_, given.explained_variance_ratio_)
    of_pairs = KNeighborsClassifier(1, metric=pose_metric(SKELETON, metric=metric), algorithm="brute")
    assert (of_pairs.fit(X, range(len(X))).predict(X) == range(len(X))).all()


def test_whole_motions_take_it(entry, metric):
    poses, skeleton = [motion.angles for motion in GAIT], GAIT.skeleton
    found = motion_distances(GAIT, metric=metric)
    if entry.distances is not None:
        costs = entry.distances(poses[0], poses[1], skeleton)
        assert found[0, 1] == pytest.approx(reference.least_sum(costs) / sum(costs.shape), rel=1e-9)
        assert align_motions(GAIT[0], GAIT[1], metric=metric).distance == pytest.approx(
            motion_distances([GAIT[0]], [GAIT[1]], metric=metric)[0, 0], rel=1e-9
        )
    assert np.allclose(MotionDistanceTransformer(metric=metric).fit_transform(GAIT), found, rtol=0, atol=1e-9)
    near = MotionKNeighborsTransformer(metric=metric, n_neighbors=1).fit(GAIT)
    others = found + np.diag(np.full(len(found), np.inf))
    assert (near.kneighbors()[1].ravel() == others.argmin(axis=1)).all()
    (match,) = find_motion(GAIT[1].angles[3:9], poses, k=1, skeleton=skeleton, metric=metric)
    assert (match.motion, match.start, match.stop) == (1, 3, 9)
    repetitions = segment_repetitions(GAIT[0], metric=metric)
    assert (repetitions.starts[1:] >= repetitions.stops[:-1]).all()
    assert (repetitions.stops <= len(GAIT[0])).all()
    statistic = two_sample_test(GAIT.motions[:2], GAIT.motions[2:], metric=metric).statistic
    if not metric.iterative:  # one pair at a time takes long
        of_two = pose_metric(skeleton, metric=metric)
        assert statistic == pytest.approx(reference.two_sample_statistic(poses[:2], poses[2:], of_two), rel=1e-9)
    if not metric.iterative:
        assert explorer(GAIT, metrics=[metric]).title


def call_means(metric):
    yield lambda: frechet_mean(X, SKELETON, metric=metric)
    yield lambda: geometric_median(X, SKELETON, metric=metric)
    yield lambda: PoseKMeans(SKELETON, n_clusters=2, metric=metric, n_init=1, max_iter=2, tol=1.0, random_state=0).fit(
        X
    )
    yield lambda: PoseKernelRegressor(SKELETON, metric=metric).fit(X[:, :1], X)
    yield lambda: PoseTangentPCA(SKELETON, metric=metric).fit(X)
    yield lambda: mean_motion(GAIT[:2], metric=metric, max_iter=1)


# Means by descent take seconds: of the library's own they are tested one by one in tests/geodesics too.
DESCENDING = {"spatial", "Spatial(n_steps=7, wrap=False)", "geodesic"}


@pytest.mark.parametrize(
    "metric",
    [
        pytest.param(entry.metric, id=label, marks=pytest.mark.slow if label in DESCENDING else ())
        for entry in EVERY_METRIC
        for label in [entry.metric.label]
    ],
)
@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning")
def test_means_are_found_or_refused_in_words(metric):
    """A metric that says nothing about means gets none, and no other metric's."""
    for call in call_means(metric):
        error = ""
        try:
            call()
        except ValueError as refused:
            error = str(refused)
        if error:
            assert f"which the metric {metric.label!r} has not: " in error
            assert "Take " in error
        else:
            assert metric.why_no_means() == ""
    if type(metric).sample is Metric.sample:
        for call in call_means(metric):
            with pytest.raises(ValueError, match="Take "):
                call()


def test_objects_are_equal_copied_and_pickled(metric):
    assert metric == clone(metric) == pickle.loads(pickle.dumps(metric)) == eval(repr(metric), vars_of(metric))
    assert hash(metric) == hash(clone(metric))
    assert metric != object()
    assert len({entry.metric for entry in EVERY_METRIC}) == len(EVERY_METRIC)


def vars_of(metric):
    return {type(metric).__name__: type(metric)}


def test_a_metric_that_measures_anew_inherits_no_bounds_and_means():
    with pytest.raises(TypeError, match=r"Longest measures another distance than Position.*derive Longest from Metric"):

        class Longest(Position):
            measure = measure_largest

    with pytest.raises(TypeError, match="inherits name from it"):

        class Nameless(LargestDistance):
            measure = measure_largest

    with pytest.raises(TypeError, match="Both measures another distance than Spatial"):

        class Both(LargestDistance, Spatial):
            name = "both"

    class Renamed(LargestDistance):  # nothing is inherited that is not true of it
        name = "another"
        measure = measure_largest

    assert Renamed() != LargestDistance()


def own_metric(length=lambda tree, n_dofs: n_dofs, **members):
    """Return a metric of one's own that takes the columns as its code."""
    members = {"encode": Angle.encode, "measure": measure_sum, "needs_skeleton": False, **members}
    return type("Own", (Metric,), {"n_codes": lambda self, tree, n_dofs: length(tree, n_dofs), **members})()


@compile_encode
def encode_twice(pose, positions, code):
    for d in range(len(pose)):
        code[d], code[len(pose) + d] = pose[d], 2.0 * pose[d]


@compile_measure
def measure_signed(a, b):
    return a[0] - b[0] + 5.0 * (a[0] != b[0])


@compile_measure
def measure_beyond(a, b):
    return abs(a[len(a)] - b[0])


@compile_measure
def measure_from_one(a, b):
    return 1.0 + np.abs(a - b).sum()


@pytest.mark.parametrize(
    ("metric", "words"),
    [
        (own_metric(lambda tree, n_dofs: n_dofs + 1), r"n_codes gives \d+, but its encode, that of Angle, writes"),
        (
            own_metric(lambda tree, n_dofs: 2.0 * n_dofs, encode=encode_twice),
            r"what Own.n_codes returns, the length of a code, must be a whole number of at least 0, got \d+\.0",
        ),
        (own_metric(encode=encode_twice), "Own.encode failed: IndexError.*numbers that Own.n_codes states"),
        (own_metric(lambda tree, n_dofs: 3 * n_dofs, encode=encode_twice), "numbers of a code unwritten"),
        (own_metric(measure=measure_signed), "Own.measure gives 4.4 from one pose to another and 5.6 back"),
        (own_metric(measure=measure_beyond), "Own.measure failed: IndexError.*called with codes"),
        (own_metric(measure=measure_from_one), "Own.measure gives 1 between equal poses"),
        (
            own_metric(measure=lambda a, b: 0.0),
            "Own.measure must be a compiled function: make it with .*compile_measure",
        ),
    ],
    ids=[
        "length",
        "no whole number",
        "writes beyond",
        "writes too little",
        "no symmetry",
        "reads beyond",
        "not zero",
        "not compiled",
    ],
)
def test_functions_that_make_no_distance_are_refused_in_words(metric, words):
    """Compiled, they would write into other memory, or give numbers that look right."""
    for call in (lambda: pose_distances([[0.0, 1.0], [2.0, 3.0]], metric=metric), lambda: pose_metric(metric=metric)):
        with pytest.raises(ValueError, match=words):
            call()


def test_a_code_may_be_longer_than_a_pose_where_there_is_no_skeleton():
    metric = own_metric(lambda tree, n_dofs: 2 * n_dofs, encode=encode_twice)
    poses = np.random.default_rng(0).normal(size=(2, 5))
    expected = 3.0 * np.abs(poses[0] - poses[1]).sum()
    assert pose_distances(poses, metric=metric)[0, 1] == pytest.approx(expected)
    assert pose_metric(metric=metric)(*poses) == pytest.approx(expected)


def test_a_lower_bound_that_is_not_euclidean_is_refused():
    class Fine(LargestDistance):
        def lower_bound(self):
            return Spatial(2)

    with pytest.raises(ValueError, match=r"lower bound of 'largest distance' must be .*Euclidean.*got Spatial"):
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


@compile_measure
def measure_some(a, b):
    return np.nan if a[0] * b[0] < -1.0 else np.abs(a - b).sum()


@compile_measure
def measure_below_zero(a, b):
    return np.abs(a - b).sum() if a[0] * b[0] >= -1.0 else -1.0


@compile_encode
def encode_some(pose, positions, code):
    if pose[0] < 5.0:
        code[:] = pose


NO_DISTANCE = "which measures codes, gives NaN, infinity or less than zero for some poses"
FAR = np.array([[-1.0], [9.0], [1.0], [-1.0], [9.0], [0.0]])
CALLS = {
    "pose_distances": lambda metric: pose_distances(FAR, metric=metric),
    "pose_metric": lambda metric: pose_metric(metric=metric)(*FAR[:2]),
    "k nearest": lambda metric: PoseKNeighborsTransformer(metric=metric, n_neighbors=2).fit(FAR).kneighbors(),
    "within": lambda metric: PoseRadiusNeighborsTransformer(metric=metric, radius=2.0).fit(FAR).radius_neighbors(),
    "motion_distances": lambda metric: motion_distances([FAR, FAR[::-1]], metric=metric),
    "find_motion": lambda metric: find_motion(FAR[:2], [FAR], metric=metric, k=1),
}


@pytest.mark.parametrize(
    ("metric", "words"),
    [
        (own_metric(measure=measure_some), f"measure_some, {NO_DISTANCE}"),
        pytest.param(
            own_metric(measure=measure_below_zero), f"measure_below_zero, {NO_DISTANCE}", marks=pytest.mark.slow
        ),
        pytest.param(
            own_metric(encode=encode_some),
            "encode_some, which encodes poses, leaves a number of some pose's code",
            marks=pytest.mark.slow,
        ),
    ],
    ids=["NaN", "below zero", "unwritten"],
)
@pytest.mark.parametrize("call", CALLS)
def test_no_number_comes_of_what_is_no_distance(call, metric, words):
    """Two example poses do not show what a function does with all others."""
    with pytest.raises(ValueError, match=words):
        CALLS[call](metric)


def test_a_file_knows_the_functions_of_a_metric():
    """A metric that is edited between two runs has another function of the same name."""
    fingerprints = [metric_fingerprint(own_metric(measure=measure)) for measure in (measure_sum, measure_some)]
    assert fingerprints[0] == metric_fingerprint(own_metric(measure=measure_sum)) != fingerprints[1]


def test_a_file_knows_what_the_functions_of_a_metric_use():
    """Compiled code has the values of names outside the function, and calls other functions."""

    def fingerprint(factor, weights, inner):
        def part(a, b):
            return inner(a[0], b[0]) * weights[0]

        @compile_measure
        def measure(a, b):
            return factor * part(a, b)

        return metric_fingerprint(own_metric(measure=measure))

    def first(x, y):
        return abs(x - y)

    def second(x, y):
        return abs(x - y) * 2.0

    expected = fingerprint(1.0, np.ones(2000), first)
    assert fingerprint(1.0, np.ones(2000), first) == expected
    changed = np.ones(2000)
    changed[1000] = 2.0
    for other in [(2.0, np.ones(2000), first), (1.0, changed, first), (1.0, np.ones(2000), second)]:
        assert fingerprint(*other) != expected


def test_compiled_functions_may_depend_on_parameters():
    assert [pose_distances([[0.0], [1.0]], metric=Scaled(s))[0, 1] for s in (1.0, 3.0)] == [1.0, 3.0]
    assert Scaled().label == "Scaled"
    assert Scaled(np.float64(3.0)).label == "Scaled(scale=3.0)"
    with pytest.raises(ValueError, match=r"scale of Scaled is \[1\.0\], a list: pass a tuple"):
        pose_distances([[0.0], [1.0]], metric=Scaled([1.0]))


def test_parameters_of_a_name_are_refused_in_words():
    model = PoseDistanceTransformer(SKELETON, metric="spatial")
    with pytest.raises(ValueError, match=r"metric__n_steps is a parameter.*'spatial' is no object.*metric=Spatial"):
        model.set_params(metric__n_steps=5)
    assert model.set_params(metric=Spatial(), metric__n_steps=5).metric == Spatial(5)
