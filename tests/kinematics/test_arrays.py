"""Poses in arrays of other libraries: the numbers of the compiled path, and gradients."""

import numpy as np
import pytest
from conftest import SKELETONS, random_tree
from sklearn import config_context

from skpose import Bone, Skeleton, forward_kinematics, pose_distances
from skpose.metrics import Geodesic, Position, Rotation, Spatial, pose_distances_chunked
from skpose.scores import geodesic_error, mpjpe
from skpose.skeleton import rotations_from_poses

ALL = SKELETONS | {
    "slides": random_tree(5, kinds=("rotvec", "slide", "ZXY", "slide", "hinge"), offset_frame="parent"),
    "slides at the root": random_tree(6, kinds=("slide", "slide", "ZXY", "slide", "hinge")),
}
METRICS = [Position(), Rotation(), Spatial(), Spatial(n_steps=3, wrap=False)]
BALLS = Skeleton([Bone(f"b{i}", f"b{i - 1}" if i else None, (0.3, 0.01 * i, 0.02), "rotvec") for i in range(3)])


class Library:
    """Arrays of a library from numpy's, and back."""

    def __init__(self, name, xp):
        self.name, self.xp = name, xp

    def array(self, X, dtype="float64"):
        return self.xp.asarray(X.tolist(), dtype=getattr(self.xp, dtype))

    def numpy(self, X):
        return np.from_dlpack(X)


LIBRARIES = ["array_api_strict", "torch", pytest.param("jax.numpy", marks=pytest.mark.slow)]  # jax compiles each shape


@pytest.fixture(params=LIBRARIES, scope="module")
def library(request):
    xp = pytest.importorskip(request.param, reason=f"{request.param} is not installed")
    if request.param != "jax.numpy":
        yield Library(request.param, xp)
        return
    import jax

    with jax.enable_x64(True):
        yield Library(request.param, xp)


@pytest.fixture(scope="module")
def torch():
    return pytest.importorskip("torch", reason="torch is not installed")


@pytest.fixture
def jax():
    jax = pytest.importorskip("jax", reason="jax is not installed")
    with jax.enable_x64(True):
        yield jax


def some_poses(skeleton, n=8, seed=0, dtype=np.float64):
    return np.random.default_rng(seed).uniform(-3, 3, (n, skeleton.n_dofs)).astype(dtype)


@pytest.mark.parametrize("name", ALL)
def test_equal_to_the_compiled_path(library, name):
    """1e-12 in float64; in float32 2e-6 m where "spatial" is up to four metres, more in proportion elsewhere."""
    skeleton = ALL[name]
    X, Y = some_poses(skeleton, dtype=np.float32), some_poses(skeleton, 5, seed=1, dtype=np.float32)
    Y[0] = X[0]
    double = X.astype(float), Y.astype(float)
    for dtype in ("float64", "float32"):
        A, B = library.array(X, dtype), library.array(Y, dtype)
        pairs = [(forward_kinematics(A, skeleton), forward_kinematics(double[0], skeleton))]
        for metric in METRICS:
            D = pose_distances(A, B, skeleton=skeleton, metric=metric)
            pairs.append((D, pose_distances(*double, skeleton=skeleton, metric=metric)))
            farthest = pairs[-1][1].max()
            assert library.numpy(D)[0, 0] == 0.0  # of equal poses
        for found, expected in pairs:
            assert found.dtype == A.dtype
            tolerance = 1e-12 if dtype == "float64" else 2e-6 * max(1.0, farthest / 4.0)
            np.testing.assert_allclose(library.numpy(found), expected, rtol=0, atol=tolerance)


@pytest.mark.parametrize("metric", METRICS[1:3], ids=lambda metric: metric.name)
def test_half_turns_and_whole_turns_are_those_of_the_compiled_path(library, metric):
    skeleton = ALL["mixed joints"]
    X = np.concatenate([some_poses(skeleton, 3), np.zeros((2, skeleton.n_dofs))])
    X[3], X[1] = np.pi, X[0] + np.pi
    Y = X + 2.0 * np.pi * np.random.default_rng(0).integers(-2, 3, X.shape) * (np.arange(skeleton.n_dofs) % 2)
    D = pose_distances(library.array(X), library.array(Y), skeleton=skeleton, metric=metric)
    expected = pose_distances(X, Y, skeleton=skeleton, metric=metric)
    np.testing.assert_allclose(library.numpy(D), expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize("metric", METRICS[:3], ids=lambda metric: metric.name)
def test_tiles_and_chunks_are_the_whole(library, metric):
    skeleton = ALL["asf"]
    X, Y = some_poses(skeleton, 5), some_poses(skeleton, 4, seed=1)
    A, B = library.array(X), library.array(Y)
    small = {"skeleton": skeleton, "metric": metric}
    with config_context(working_memory=0.04 if metric == Spatial() else 0.004):  # MiB, for eight pairs
        among, between = pose_distances(A, **small), pose_distances(A, B, **small)
    np.testing.assert_allclose(library.numpy(among), pose_distances(X, **small), rtol=0, atol=1e-12)
    np.testing.assert_allclose(library.numpy(between), pose_distances(X, Y, **small), rtol=0, atol=1e-12)
    np.testing.assert_array_equal(library.numpy(among), library.numpy(among).T)
    assert not library.numpy(among).diagonal().any()
    chunks = [library.numpy(D) for D in pose_distances_chunked(A, B, **small, working_memory=1e-4)]
    assert len(chunks) > 1
    np.testing.assert_allclose(np.concatenate(chunks), pose_distances(X, Y, **small), rtol=0, atol=1e-12)


def test_refused_by_name(library):
    A = library.array(np.zeros((2, 4)))
    arm = Skeleton.chain(4)
    for metric in ("angle", "geodesic", Geodesic(5)):
        with pytest.raises(ValueError, match="need 'position'"):
            pose_distances(A, skeleton=arm, metric=metric)
    with pytest.raises(ValueError, match="columns"):
        pose_distances(A, skeleton=Skeleton.chain(3))
    with pytest.raises(ValueError, match="shape"):
        forward_kinematics(A[0, :], arm)
    with pytest.raises(TypeError, match="one library"):
        pose_distances(A, np.zeros((2, 4)), skeleton=arm)
    with pytest.raises(ValueError, match="align"):
        mpjpe(A, A, skeleton=arm, align="rigid")


@pytest.mark.parametrize("average", ["points", "frames", "joints", None])
def test_scores_are_those_of_numpy(library, average):
    rng = np.random.default_rng(0)
    true, weights = rng.normal(scale=0.3, size=(6, 5, 3)), rng.uniform(size=6)
    pred = true + rng.normal(scale=0.05, size=true.shape)
    true[2, 3] = np.nan
    skeleton = ALL["mixed joints"]
    poses = some_poses(skeleton, 6), some_poses(skeleton, 6, seed=1)
    poses[0][1, 0] = np.nan
    options = {"average": average, "sample_weight": weights}
    calls = [
        (mpjpe, (true, pred), {}),
        (mpjpe, (true, pred), {"root": [0, 2], "joints": [1, 3], "unit": "cm"}),
        (mpjpe, (true.reshape(6, 15), pred.reshape(6, 15)), {"root": 1}),
        (mpjpe, poses, {"skeleton": skeleton, "root": "b3"}),
        (geodesic_error, poses, {"skeleton": skeleton}),
        (geodesic_error, poses, {"skeleton": skeleton, "frame": "world", "unit": "rad"}),
    ]
    balls = some_poses(BALLS, 6), some_poses(BALLS, 6, seed=1)
    for form in ("quaternion_wxyz", "quaternion_xyzw", "matrix", "6d", "rotvec"):
        numbers = tuple(rotations_from_poses(one, BALLS, form=form) for one in balls)
        numbers[0][2, 1] = np.nan
        calls.append((geodesic_error, numbers, {"form": form}))
    for score, values, parameters in calls:
        found = score(*(library.array(one) for one in values), **parameters, **options)
        expected = score(*values, **parameters, **options)
        np.testing.assert_allclose(library.numpy(found), expected, rtol=1e-11, atol=1e-11)


def test_motions_have_one_weight_each(library):
    rng = np.random.default_rng(0)
    true, pred = rng.normal(scale=0.3, size=(2, 3, 4, 5, 3))
    found = mpjpe(library.array(true), library.array(pred), sample_weight=[1.0, 2.0, 0.5])
    assert abs(float(found) - mpjpe(true, pred, sample_weight=[1.0, 2.0, 0.5])) < 1e-9


# --- gradients --------------------------------------------------------------------------------------------------------


def gradient(torch, function, X):
    X = torch.tensor(X, requires_grad=True)
    function(X).backward()
    return X.grad.numpy()


def central_differences(function, X, step=1e-5):
    slopes = np.zeros_like(X)
    for index in np.ndindex(X.shape):
        shift = np.zeros_like(X)
        shift[index] = step
        slopes[index] = (float(function(X + shift)) - float(function(X - shift))) / (2.0 * step)
    return slopes


@pytest.mark.parametrize("name", ["asf", "slides", "mixed joints"])
@pytest.mark.parametrize("metric", METRICS[:3], ids=lambda metric: metric.name)
def test_gradients_are_those_of_the_compiled_path(torch, metric, name):
    skeleton = ALL[name]
    X, Y = 0.3 * some_poses(skeleton, 2), 0.3 * some_poses(skeleton, 1, seed=1)

    def total(A, B):
        return pose_distances(A, B, skeleton=skeleton, metric=metric).sum()

    found = gradient(torch, lambda A: total(A, torch.tensor(Y)), X)
    np.testing.assert_allclose(found, central_differences(lambda A: total(A, Y), X), rtol=0, atol=1e-6)


def test_gradients_of_positions_and_scores(torch):
    skeleton = ALL["mixed joints"]
    X, Y = 0.3 * some_poses(skeleton, 1), 0.3 * some_poses(skeleton, 1, seed=1)
    functions = [
        lambda A, B: (forward_kinematics(A, skeleton) ** 2).sum(),
        lambda A, B: mpjpe(B, A, skeleton=skeleton, root="b3", unit="m"),
        lambda A, B: geodesic_error(B, A, skeleton=skeleton, frame="world", unit="rad"),
    ]
    for function in functions:
        found = gradient(torch, lambda A, f=function: f(A, torch.tensor(Y)), X)
        np.testing.assert_allclose(found, central_differences(lambda A, f=function: f(A, Y), X), rtol=0, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_gradients_are_finite_at_equal_poses_half_turns_and_zero(torch, dtype):
    skeleton = ALL["mixed joints"]
    zero, half = np.zeros(skeleton.n_dofs), np.full(skeleton.n_dofs, 0.0)
    half[0::3] = np.pi  # of each ball joint and some angles
    some = some_poses(skeleton, 1)[0]
    pairs = [(some, some), (zero, zero), (zero, half), (some, zero), (zero, np.full_like(zero, 1e-9))]
    for start, end in pairs:
        A, B = (torch.tensor(one[None], dtype=getattr(torch, dtype), requires_grad=True) for one in (start, end))
        values = [pose_distances(A, B, skeleton=skeleton, metric=metric).sum() for metric in METRICS[:3]]
        values += [mpjpe(A, B, skeleton=skeleton), geodesic_error(A, B, skeleton=skeleton)]
        for value in values:
            A.grad = B.grad = None
            value.backward(retain_graph=True)
            assert torch.isfinite(A.grad).all()
            assert torch.isfinite(B.grad).all()


def test_a_missing_truth_leaves_the_gradient_finite(torch):
    true, pred = torch.zeros((2, 4, 3)), torch.ones((2, 4, 3), requires_grad=True)
    true[0, 1] = torch.nan
    mpjpe(true, pred, root=0).backward()
    assert torch.isfinite(pred.grad).all()


def test_gradient_descent_brings_one_pose_to_another(torch):
    X, goal = (torch.tensor(0.4 * some_poses(BALLS, 1, seed)) for seed in (0, 1))
    X.requires_grad_()
    start = pose_distances(X, goal, skeleton=BALLS).item()
    for _ in range(60):
        distance = pose_distances(X, goal, skeleton=BALLS)[0, 0]
        (slope,) = torch.autograd.grad(distance, X)
        with torch.no_grad():
            X -= distance / (slope * slope).sum() * slope
    assert pose_distances(X, goal, skeleton=BALLS).item() < 0.05 * start


# --- compilers --------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_torch_compile_traces_distances_and_gradients(torch):
    skeleton = BALLS.with_weights({"b0": 2.0})  # which nothing has been computed for
    X, Y = (torch.tensor(some_poses(BALLS, 3, seed), requires_grad=True) for seed in (0, 1))

    def distances(A, B):
        return pose_distances(A, B, skeleton=skeleton, metric="spatial")

    compiled = torch.compile(distances, backend="aot_eager")
    found = compiled(X, Y)
    (slope,) = torch.autograd.grad(found.sum(), X)
    (expected,) = torch.autograd.grad(distances(X, Y).sum(), X)
    torch.testing.assert_close(found, distances(X, Y), rtol=0, atol=1e-12)
    torch.testing.assert_close(slope, expected, rtol=0, atol=1e-12)


@pytest.mark.slow
def test_jax_traces_distances_and_gradients(jax):
    X, Y = some_poses(BALLS, 3), some_poses(BALLS, 3, seed=1)

    def distances(A, B):
        return pose_distances(A, B, skeleton=BALLS, metric="spatial")

    def paired(A, B):
        return jax.vmap(lambda a, b: distances(a[None], b[None])[0, 0])(A, B)

    expected = pose_distances(X, Y, skeleton=BALLS, metric="spatial")
    np.testing.assert_allclose(jax.jit(distances)(jax.numpy.asarray(X), jax.numpy.asarray(Y)), expected, atol=1e-12)
    np.testing.assert_allclose(jax.jit(paired)(X, jax.numpy.asarray(Y)), expected.diagonal(), atol=1e-12)
    found = jax.jit(jax.grad(lambda A: paired(A, jax.numpy.asarray(Y)).sum()))(jax.numpy.asarray(X))
    slopes = central_differences(lambda A: pose_distances(A, Y, skeleton=BALLS, metric="spatial").diagonal().sum(), X)
    np.testing.assert_allclose(found, slopes, rtol=0, atol=1e-6)
