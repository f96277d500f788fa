"""The geodesic: closed forms, scipy's minima, and the lengths that it reports."""

import warnings

import numpy as np
import pytest
import reference
from conftest import ALL_SKELETONS, SKELETONS, in_turns, quick_on, whole_turns
from sklearn.exceptions import ConvergenceWarning

from skpose import Bone, Skeleton, forward_kinematics, geodesic, pose_distances
from skpose.kinematics import position_jacobian
from skpose.metrics import Geodesic, Spatial
from skpose.preprocessing import PoseDistanceTransformer

TIGHT = 0.0  # down to rounding: tol where the path itself is compared, and not only its length
HUMANOID = SKELETONS["humanoid"]


def near_and_far(skeleton, far=0.3, seed=0):
    """Two poses that differ in every angle."""
    rng = np.random.default_rng(seed)
    a = rng.uniform(-1, 1, skeleton.n_dofs)
    return a, a + far * rng.normal(size=skeleton.n_dofs)


def kinematics(skeleton):
    """F and J of a path, which have tests of their own, with the roots of the weights."""
    scale = np.repeat(np.sqrt(reference.weights(skeleton)), 3)
    return lambda path: (
        forward_kinematics(path, skeleton).reshape(len(path), -1) * scale,
        position_jacobian(path, skeleton) * scale[:, None],
    )


def gradient(path, skeleton, n_steps=None):
    """The energy's gradient in the poses that are free: of a refined path those between which the others lie evenly."""
    inner = reference.energy_gradient(*kinematics(skeleton)(path))
    parts = 1 if n_steps is None else (len(path) - 1) // n_steps
    free, samples = np.arange(1, (len(path) - 1) // parts), np.arange(1, len(path) - 1) / parts
    return np.maximum(0, 1 - np.abs(samples - free[:, None])) @ inner


@quick_on("bvh", "tree, offsets in the parent's frame", "mixed joints", "weights")
def test_gradient_of_eq_6_keeps_the_term_that_eq_13_loses(skeleton):
    a, b = near_and_far(skeleton)
    path = reference.line(a, b, 4)
    closed, by_differences = gradient(path, skeleton), np.zeros((3, skeleton.n_dofs))
    for i in range(3):
        for d in range(skeleton.n_dofs):
            step = np.zeros_like(path)
            step[i + 1, d] = 1e-5
            rise = reference.path_energy(path + step, skeleton) - reference.path_energy(path - step, skeleton)
            by_differences[i, d] = rise / 2e-5
    np.testing.assert_allclose(closed, by_differences, atol=1e-8)
    F, J = kinematics(skeleton)(path)
    as_printed = 2 * np.einsum("nr,nrd->nd", F[:-2] - F[2:], J[1:-1])
    assert np.abs(as_printed - by_differences).max() > 1e-2


@pytest.mark.parametrize(("n_steps", "skeleton"), in_turns([2, 10], ALL_SKELETONS), indirect=["skeleton"])
def test_same_minimum_as_scipy(n_steps, skeleton):
    a, b = near_and_far(skeleton, far=0.1)
    found = geodesic(a, b, skeleton, metric=Geodesic(n_steps), tol=TIGHT)
    naive = reference.least_energy_path(a, b, kinematics(skeleton), n_steps)
    assert len(found.path) == n_steps + 1
    assert found.energy <= reference.path_energy(naive, skeleton) * (1 + 1e-9)


def test_no_more_of_the_length_is_left_to_gain_than_requested(skeleton):
    a, b = near_and_far(skeleton, far=0.1)  # of farther poses there may be several minima
    tight = geodesic(a, b, skeleton, tol=TIGHT)
    for tol in (1e-3, 1e-6, 1e-9):
        found = geodesic(a, b, skeleton, tol=tol)
        assert found.converged
        assert found.gain <= tol
        assert found.length <= (1.0 + 3.0 * tol) * tight.length  # it is a model that knows what is left
        assert found.n_iter <= tight.n_iter
    assert geodesic(a, b, skeleton).length == geodesic(a, b, skeleton, tol=1e-6).length


@pytest.mark.parametrize("ends", [((0.1, 0.2), (1.0, -0.7)), ((-1.2, 0.4), (1.2, 0.4)), ((0.3, 0.3), (0.3, -0.9))])
def test_one_bone_with_two_dofs_follows_a_great_circle(ends):
    skeleton = Skeleton([Bone("bone", None, (0, 0, 1.5), "xy")])
    found = geodesic(*ends, skeleton, tol=TIGHT)
    F = reference.forward_kinematics(found.path, skeleton)[:, 0] / 1.5
    angle = np.arccos(F[0] @ F[-1])
    np.testing.assert_allclose(found.length, 1.5 * 10 * 2 * np.sin(angle / 20), rtol=1e-9)
    np.testing.assert_allclose(found.curve_length, 1.5 * angle, rtol=1e-3)
    normal = np.cross(F[0], F[-1])
    np.testing.assert_allclose(F @ normal / np.linalg.norm(normal), 0, atol=1e-7)


def test_a_saddle_is_left():
    """A stretched arm that swings in its plane: folded to either side it is shorter, and both sides are equal."""
    skeleton = Skeleton.chain(3)
    a, b = np.array([0.2, 0, 0]), np.array([2.9, 0, 0])
    line = reference.line(a, b, 10)
    np.testing.assert_allclose(gradient(line, skeleton), 0, atol=1e-9)
    found = geodesic(a, b, skeleton)
    assert found.curve_length < 0.85 * reference.path_length(line, skeleton, 8)
    assert found.converged


@pytest.mark.parametrize(("far", "skeleton"), in_turns([0.1, 1.0, 3.0], ALL_SKELETONS), indirect=["skeleton"])
def test_fact_1_between_the_chord_and_the_line(far, skeleton):
    rng = np.random.default_rng(1)
    X = rng.uniform(-1, 1, size=(2, skeleton.n_dofs))
    Y = X + far * rng.normal(size=(2, skeleton.n_dofs))
    for n_steps in (2, 10):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            shortest = pose_distances(X, Y, skeleton=skeleton, metric=Geodesic(n_steps))
            curves = [[geodesic(x, y, skeleton, metric=Geodesic(n_steps)).curve_length for y in Y] for x in X]
        chord = pose_distances(X, Y, skeleton=skeleton, metric="position")
        line = pose_distances(X, Y, skeleton=skeleton, metric=Spatial(n_steps))
        assert (chord <= shortest * (1 + 1e-12)).all()
        assert (shortest <= line).all()
        fine = [
            [reference.path_length(reference.line(x, y, 1, skeleton=skeleton), skeleton, 400) for y in Y] for x in X
        ]
        assert (curves <= np.array(fine) * (1 + 1e-4)).all()


@pytest.mark.parametrize("seed", [1, 7, 17])
def test_discretisation_error_is_found_and_removed(seed):
    """Where ten points skip what is long, scipy's minimum is no curve of that length, and ours is one."""
    skeleton = SKELETONS["bvh"]
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(-2, 2, size=(2, skeleton.n_dofs))
    naive = reference.least_energy_path(a, b, kinematics(skeleton))
    line = reference.path_length(reference.line(a, b, 10), skeleton, 8)
    assert reference.path_length(naive, skeleton) < 0.9 * reference.path_length(naive, skeleton, 8)
    found = geodesic(a, b, skeleton, max_iter=2000)
    assert found.converged
    assert len(found.path) > 11
    np.testing.assert_allclose(reference.path_length(found.path, skeleton, 20), found.length, rtol=5e-3)
    assert found.curve_length < 0.95 * line


def test_limits_make_the_path_longer():
    """An elbow that must stay nearly straight makes the arm swing wide."""
    arm = [("upper", None, (1, 0, 0), "z"), ("fore", "upper", (1, 0, 0), "z", None, ((-0.3, 0.3),))]
    arm = Skeleton([Bone(*bone) for bone in arm])
    a, b = [0.0, 0.1], [2.6, -0.1]
    free, limited = geodesic(a, b, arm), geodesic(a, b, arm, joint_limits="enforce")
    assert np.abs(free.path[:, 1]).max() > 0.5
    assert limited.path[:, 1].min() >= -0.3
    assert limited.path[:, 1].max() <= 0.3
    assert np.isclose(np.abs(limited.path[:, 1]), 0.3).any()
    assert limited.converged
    assert limited.length > free.length * 1.01
    bounds = [(-np.inf, np.inf), (-0.3, 0.3)]
    naive = reference.least_energy_path(np.array(a), np.array(b), kinematics(arm), bounds=bounds)
    assert limited.energy <= reference.path_energy(naive, arm) * (1 + 1e-6)


@pytest.mark.filterwarnings("ignore:values of .* reach:UserWarning")
def test_whole_turns_do_not_matter(skeleton):
    a, b = near_and_far(skeleton)
    turns = whole_turns(np.array([a, b]), skeleton, np.random.default_rng(5).integers(-3, 4, (2, skeleton.n_dofs)))
    plain, wound = geodesic(a, b, skeleton), geodesic(a, b + turns[1], skeleton)
    np.testing.assert_allclose(wound.length, plain.length, rtol=1e-9)
    np.testing.assert_allclose(wound.path[-1], b, atol=1e-9)
    X = np.array([a, b])
    D = pose_distances(X, X + turns, skeleton=skeleton, metric="geodesic")
    np.testing.assert_allclose(D, [[0, plain.length], [plain.length, 0]], atol=1e-9)


@pytest.mark.parametrize("off", [0.0, 1e-12, 5e-8, 1e-6])
def test_a_path_close_to_gimbal_lock_has_its_rotations(off):
    skeleton = Skeleton([Bone("hand", None, (0.3, 0.2, 0.4), "xyz")])
    found = geodesic([0.1, np.pi / 2 - off, 0.0], [0.9, np.pi / 2 - off, 0.3], skeleton)
    chords = np.diff(reference.forward_kinematics(found.path, skeleton)[:, 0], axis=0)
    np.testing.assert_allclose(found.length, np.linalg.norm(chords, axis=1).sum(), rtol=1e-12)


@quick_on("bvh", "tree, offsets in the parent's frame", "mixed joints", "weights")
def test_resample_has_constant_speed(skeleton):
    a, b = near_and_far(skeleton)
    found = geodesic(a, b, skeleton, tol=TIGHT)
    for n in (2, 7, 50):
        poses = found.resample(n)
        assert poses.shape == (n, skeleton.n_dofs)
        np.testing.assert_allclose(poses[[0, -1]], [a, b], rtol=1e-12)
        lengths = [reference.path_length(poses[i : i + 2], skeleton) for i in range(n - 1)]
        np.testing.assert_allclose(lengths, np.mean(lengths), rtol=2e-3)
    with pytest.raises(ValueError, match="n must be an integer"):
        found.resample(1)


def test_the_matrix_contains_the_lengths(skeleton):
    rng = np.random.default_rng(2)
    X = rng.uniform(-1, 1, size=(4, skeleton.n_dofs)) * 0.3
    D = pose_distances(X, skeleton=skeleton, metric="geodesic")
    np.testing.assert_array_equal(D, D.T)
    np.testing.assert_array_equal(np.diag(D), 0)
    upper = np.triu_indices(len(X), 1)
    expected = [geodesic(X[i], X[j], skeleton).length for i, j in zip(*upper, strict=True)]
    np.testing.assert_allclose(D[upper], expected, rtol=2e-6, atol=1e-13)
    rows = pose_distances(X[:2], X[::-1], skeleton=skeleton, metric="geodesic")
    np.testing.assert_allclose(rows, D[:2, ::-1], rtol=1e-9)
    distances = PoseDistanceTransformer(skeleton, metric="geodesic").fit_transform(X)
    np.testing.assert_array_equal(distances, D)


def test_warns_when_it_does_not_converge():
    a, b = near_and_far(HUMANOID)
    with pytest.warns(ConvergenceWarning, match="did not converge.*raise max_iter"):
        found = geodesic(a, b, HUMANOID, max_iter=1)
    assert not found.converged
    assert found.gain > 1e-6
    assert "converged=False" in repr(found)
    assert found.curve_length <= reference.path_length(reference.line(a, b, 10), HUMANOID, 8)


# --- real poses -------------------------------------------------------------------------------------------------------


def frames_of(cmu, subject, trial):
    X, sequence = cmu.poses()
    (i,) = np.flatnonzero((cmu.subjects == subject) & (cmu.trials == trial))
    return X[sequence == i]


def test_walking_poses_of_cmu(cmu):
    """Section 3.1: pairs from one walk. The paper's lowest ratio of eq. 8 is 0.94."""
    walks = [i for i, action in enumerate(cmu.actions) if action == "walk" and cmu.subjects[i] == "35"]
    X, sequence = cmu.poses(frame_rate=12)
    rng = np.random.default_rng(0)
    for _ in range(25):
        i, j = rng.choice(np.flatnonzero(sequence == rng.choice(walks)), 2, replace=False)
        found = geodesic(X[i], X[j], cmu.skeleton, tol=TIGHT)
        assert found.gradient_norm <= 1e-7
        assert np.linalg.norm(gradient(found.path, cmu.skeleton, 10)) <= 1.01e-7
        assert found.length <= found.curve_length <= 1.005 * found.length
        line = pose_distances(X[[i]], X[[j]], skeleton=cmu.skeleton)[0, 0]
        assert 0.94 <= found.length / line <= 1


@pytest.mark.parametrize("trial", ["10", "07"])
def test_paths_between_poses_far_apart_are_real_curves(trial, cmu):
    """Walking against washing and sword play, where the chords of a naive minimiser are not those of a curve."""
    A, B = frames_of(cmu, "02", "01"), frames_of(cmu, "02", trial)
    rng = np.random.default_rng(0)
    shorter = 0
    for _ in range(6):
        a, b = A[rng.integers(len(A))], B[rng.integers(len(B))]
        found = geodesic(a, b, cmu.skeleton)
        line = reference.path_length(reference.line(a, b, 10), cmu.skeleton, 32)
        fine = reference.path_length(found.path, cmu.skeleton, 32)
        assert found.length <= fine <= 1.006 * found.length
        assert fine <= line
        shorter += fine < 0.9 * line
    assert shorter >= 2


def test_more_starts_never_give_a_longer_path():
    arm = Skeleton([(f"b{i}", f"b{i - 1}" if i else None, (1, 0, 0), "rotvec") for i in range(4)])
    pairs = np.random.default_rng(0).normal(size=(25, 2, 12))
    one, four = (np.array([geodesic(*pair, arm, n_starts=n).curve_length for pair in pairs]) for n in (1, 4))
    assert (four <= one).all()
    assert (four < 0.995 * one).any()
