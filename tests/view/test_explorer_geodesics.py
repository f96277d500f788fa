"""The geodesic in a page: lengths and poses are compared with the library's, each part with numpy and scipy."""

from itertools import pairwise

import numpy as np
import pytest
from conftest import whole_turns
from numbers_page import TREES, Numbers, poses_of
from reference import path_length
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from skpose import Bone, Skeleton, geodesic, pose_distances
from skpose.kinematics._forward import weighted_positions
from skpose.metrics import Geodesic, Spatial
from skpose.skeleton._continuity import remove_jumps

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def numbers(browser):
    return Numbers(browser)


@pytest.fixture(params=[*TREES, "CMU"])
def tree(request):
    return request.getfixturevalue("cmu").skeleton if request.param == "CMU" else TREES[request.param]


def assert_geodesics_agree(numbers, skeleton, X, Y, rtol):
    """Compare lengths with the library's; poses are a path between the two, with chords of this length."""
    for a, b in zip(X, Y, strict=True):
        found = numbers.geodesic(skeleton, [a, b])
        expected, chord, line = (
            pose_distances([a], [b], skeleton=skeleton, metric=metric)[0, 0]
            for metric in ("geodesic", "position", "spatial")
        )
        assert found["converged"]
        np.testing.assert_allclose(found["length"], expected, rtol=rtol)
        assert chord * (1 - 1e-9) <= found["length"] <= line * (1 + 1e-9)
        F = weighted_positions(np.array(found["poses"]), skeleton)
        np.testing.assert_allclose(F[[0, -1]], weighted_positions(np.array([a, b]), skeleton), atol=1e-9)
        chords = np.linalg.norm(np.diff(F, axis=0), axis=1)
        np.testing.assert_allclose(chords.sum(), found["length"], rtol=1e-6)
        assert chords.max() < 3 * chords.mean()


def test_an_arm_that_folds(numbers):
    arm = Skeleton.chain(3)
    a, b = [0.2, 0.3, 0.0], [2.4, 0.2, 0.1]
    found = numbers.geodesic(arm, [a, b])
    expected = geodesic(a, b, arm)
    assert found["converged"]
    np.testing.assert_allclose(found["length"], expected.length, rtol=1e-5)
    np.testing.assert_allclose(found["poses"], expected.path, atol=2e-2)


@pytest.mark.parametrize("n", [2, 3, 5])
def test_geodesics_of_chains(numbers, n):
    chain = Skeleton.chain(n)
    assert_geodesics_agree(numbers, chain, poses_of(chain, 8, seed=n, extent=2), poses_of(chain, 8, extent=2), 1e-4)


def test_geodesics_of_all_kinds_of_joints(numbers, tree):
    X = poses_of(tree, 3, seed=8, extent=1.0)
    assert_geodesics_agree(numbers, tree, X, X + poses_of(tree, 3, seed=9, extent=0.7), 1e-3)


def test_geodesics_where_a_ball_joint_stays_at_zero(numbers):
    """Its numbers are zero on the whole path, where closed forms have no value."""
    balls = [Bone(name, parent, (0.3, 0.1, 0), "rotvec") for name, parent in zip("abc", (None, "a", "b"), strict=True)]
    tree = Skeleton([*balls, Bone("d", "a", (0, 0.2, 0), "xz")])
    X, Y = poses_of(tree, 3, extent=1), poses_of(tree, 3, seed=1, extent=1)
    X[:, 6:9] = Y[:, 6:9] = 0
    assert_geodesics_agree(numbers, tree, X, Y, 1e-4)


def test_a_geodesic_is_no_longer_than_the_line(numbers):
    """Four chords of an arc are too few, and those of finer paths are longer."""
    arm, ends = Skeleton.chain(1), [[-1.5], [1.5]]
    found = numbers.geodesic(arm, ends, {"chords": 4})
    line = pose_distances(*np.array(ends)[:, None], skeleton=arm, metric=Spatial(4))[0, 0]
    np.testing.assert_allclose(found["length"], line, rtol=1e-12)


def test_a_geodesic_is_no_shorter_than_the_chord(numbers):
    """Not even by rounding, where the two are equal."""
    tree = TREES["humanoid"]
    X = poses_of(tree, 40, seed=1)
    Y = X + 1e-7 * poses_of(tree, 40, seed=2)
    chords = [one["position"] for one in numbers.distances(tree, X, Y, 10)]
    assert all(numbers.geodesic(tree, [a, b])["length"] >= d for a, b, d in zip(X, Y, chords, strict=True))


def test_geodesics_of_walks(numbers, cmu):
    X = np.concatenate([m.angles for m, action in zip(cmu.motions, cmu.actions, strict=True) if action == "walk"])
    X = np.random.default_rng(0).permutation(X)[:50]
    assert_geodesics_agree(numbers, cmu.skeleton, X[:25], X[25:], 1e-3)


def test_geodesics_on_ball_joints(numbers, hdm05):
    balls = hdm05.to_rotvec()
    X = np.random.default_rng(0).permutation(np.concatenate([motion.angles for motion in balls.motions]))
    # Far poses: either search may end in another minimum, see docs/view.md.
    assert_geodesics_agree(numbers, balls.skeleton, X[:3], X[6:9], 2e-3)


def test_a_stretched_arm_leaves_the_saddle(numbers):
    """By symmetry no step of Gauss and Newton bends it."""
    arm = Skeleton.chain(3)
    a, b = np.zeros(3), np.array([2.5, 0.0, 0.0])
    expected, line = (pose_distances([a], [b], skeleton=arm, metric=m)[0, 0] for m in ("geodesic", "spatial"))
    assert expected < 0.95 * line
    np.testing.assert_allclose(numbers.geodesic(arm, [a, b])["length"], expected, rtol=1e-4)


@pytest.mark.parametrize("name", ["humanoid", "mixed joints"])
def test_a_geodesic_is_the_same_from_both_ends(numbers, name):
    tree = TREES[name]
    a, b = poses_of(tree, 2, seed=3, extent=0.8)
    forth, back = numbers.geodesic(tree, [a, b]), numbers.geodesic(tree, [b, a])
    assert forth["length"] == back["length"]
    F, G = (weighted_positions(np.array(found["poses"]), tree) for found in (forth, back))
    np.testing.assert_allclose(F, G[::-1], atol=1e-9)
    assert forth["poses"][0] == a.tolist()
    assert back["poses"][0] == b.tolist()


def test_a_geodesic_does_not_change_with_whole_turns(numbers):
    tree = TREES["mixed joints"]
    a, b = poses_of(tree, 2, seed=5, extent=0.8)
    turns = whole_turns(b[None], tree, np.random.default_rng(0).integers(-2, 3, (1, tree.n_dofs)))[0]
    found = [numbers.geodesic(tree, [a, end])["length"] for end in (b, b + turns)]
    np.testing.assert_allclose(*found, rtol=1e-6)


def test_angles_of_a_geodesic_stay_near_those_of_its_start(numbers):
    a, b = [1.0, 0.5], [0.2 + 4 * np.pi, 0.3 - 2 * np.pi]
    for ends in ([a, b], [b, a]):
        poses = np.array(numbers.geodesic(Skeleton.chain(2), ends)["poses"])
        assert poses[0].tolist() == ends[0]
        assert np.abs(np.diff(poses, axis=0)).max() < 0.5


def test_a_geodesic_between_twins_has_no_length(numbers):
    arm = Skeleton([Bone("elbow", None, (0.3, 0, 0), "ZXY"), Bone("wrist", "elbow", (0.25, 0, 0), "y")])
    a = np.array([0.4, 0.9, -0.3, 0.5])
    twin = np.array([0.4 + np.pi, np.pi - 0.9, -0.3 + np.pi, 0.5])
    for b in (a, twin):
        found = numbers.geodesic(arm, [a, b])
        assert found["length"] < 1e-12
        np.testing.assert_allclose(found["poses"], np.tile(a, (11, 1)), atol=1e-9)


def test_poses_of_a_geodesic_do_not_jump(numbers, hdm05):
    X = np.random.default_rng(1).permutation(np.concatenate([motion.angles for motion in hdm05.motions]))
    for a, b in zip(X[:4], X[4:8], strict=True):
        poses = np.array(numbers.geodesic(hdm05.skeleton, [a, b])["poses"])
        for one, other in pairwise(poses):
            nearest = remove_jumps(hdm05.skeleton.bones, np.stack([one, other]))[1]
            np.testing.assert_allclose(other, nearest, atol=1e-9)


def test_chords_and_refinements_are_those_that_are_asked_for(numbers):
    arm = Skeleton.chain(3)
    a, b = [0.2, 0.3, 0.0], [2.4, 0.2, 0.1]
    found = numbers.geodesic(arm, [a, b], {"chords": 20})
    np.testing.assert_allclose(found["length"], geodesic(a, b, arm, metric=Geodesic(20)).length, rtol=1e-5)
    assert len(found["poses"]) == 21
    unchecked = numbers.geodesic(arm, [a, b], {"refined": [[1, 1]]})
    assert not unchecked["converged"]
    np.testing.assert_allclose(unchecked["length"], pose_distances([a], [b], skeleton=arm)[0, 0], rtol=1e-9)


def test_the_page_serves_events_while_it_searches(numbers):
    tree = TREES["humanoid"]
    a, b = poses_of(tree, 2, seed=1, extent=1.5)
    searches = [numbers.events(tree, [a, b]) for _ in range(3)]
    assert min(found["duration"] for found in searches) > 50
    assert min(found["longest"] / found["duration"] for found in searches) < 0.5  # in one that nothing else stops
    assert min(found["events"] for found in searches) > 2


# --- its parts --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("axes", ["xyz", "yzx", "zxy", "xzy", "zyx", "yxz"])
@pytest.mark.parametrize("intrinsic", [True, False])
def test_angles_of_a_rotation_are_the_nearest(numbers, axes, intrinsic):
    """No other angles of this rotation are nearer: no twins, no whole turns, no others where two axes are one."""
    order = axes.upper() if intrinsic else axes
    rng = np.random.default_rng(0)
    given, near = rng.uniform(-np.pi, np.pi, (9, 3)), rng.uniform(-7, 7, (9, 3))
    given[:4, 1] = np.pi / 2 * np.array([1, -1, 1, -1])
    q = Rotation.from_euler(order, given)
    axes = ["xyz".index(letter) for letter in axes]
    found = np.array(numbers.angles(TREES["chain"], q.as_quat()[:, [3, 0, 1, 2]], axes, intrinsic, near))
    assert (Rotation.from_euler(order, found) * q.inv()).magnitude().max() < 1e-7
    shifts = np.linspace(-np.pi, np.pi, 73)
    turns = 2 * np.pi * np.stack(np.meshgrid(*[[-1, 0, 1]] * 3), axis=-1).reshape(-1, 3)
    for i, (one, close) in enumerate(zip(found, near, strict=True)):
        for base in (one, [one[0] + np.pi, np.pi - one[1], one[2] + np.pi]):
            others = base + shifts[:, None, None] * np.array([[1, 0, 1], [1, 0, -1]])
            others = (others.reshape(-1, 1, 3) + turns).reshape(-1, 3)
            same = (Rotation.from_euler(order, others) * q[i].inv()).magnitude() < 1e-7
            assert same.sum() >= (73 * 27 if i < 4 else 27)
            assert np.linalg.norm(others[same] - close, axis=1).min() > np.linalg.norm(one - close) - 1e-7


@pytest.mark.parametrize("parts", [1, 8])
def test_the_length_of_a_curve(numbers, tree, parts):
    X = poses_of(tree, 4, seed=2, extent=1.4)
    np.testing.assert_allclose(numbers.curve(tree, X[[0, -1]], X, parts), path_length(X, tree, parts), rtol=1e-9)


def whole_matrix(equations, width):
    """Return the matrix of the free nodes, of its lower triangles and the blocks next to them."""
    lower = [np.reshape(one, (width, width)) for one in equations["diagonal"][1:-1]]
    matrix = block_diag(*(np.tril(one) + np.tril(one, -1).T for one in lower))
    for i, block in enumerate(equations["between"][1:-1]):
        here, after = (slice(width * k, width * (k + 1)) for k in (i, i + 1))
        matrix[here, after] = np.reshape(block, (width, width))
        matrix[after, here] = matrix[here, after].T
    return matrix


@pytest.mark.parametrize("name", ["chain", "tree", "mixed joints", "weights", "mixed 10", "angles 11"])
@pytest.mark.parametrize("substeps", [1, 3])
def test_derivatives_of_the_energy_of_a_path(numbers, name, substeps):
    """Compare gradient, Gauss-Newton matrix and Hessian of half the energy with differences."""
    tree, step = TREES[name], 1e-5
    width, rng = tree.n_dofs, np.random.default_rng(4)
    nodes = rng.uniform(-1.2, 1.2, (5, width))
    nodes[2] = 0  # where closed forms have no value
    ends = poses_of(tree, 2, seed=1, extent=0.8)
    paths = np.tile(nodes, (2 * 3 * width, 1, 1))
    for k in range(3 * width):
        paths[2 * k : 2 * k + 2, 1 + k // width, k % width] += [step, -step]
    (middle,) = numbers.energies(tree, ends, nodes[None], substeps)
    found = numbers.energies(tree, ends, paths, substeps)
    halves = np.array([one["half"] for one in found])
    gradients = np.reshape([one["gradient"] for one in found], (len(found), -1))
    positions = np.reshape([one["positions"] for one in found], (len(found), 4 * substeps + 1, -1, 3))
    chords = (np.diff(positions, axis=1) * np.sqrt(tree.weights)[:, None]).reshape(len(found), -1)
    np.testing.assert_allclose(halves, np.square(chords).sum(axis=1) / 2, rtol=1e-12)
    slope, jacobian, hessian = ((one[::2] - one[1::2]) / (2 * step) for one in (halves, chords, gradients))
    scale = np.abs(hessian).max()
    np.testing.assert_allclose(np.ravel(middle["gradient"]), slope, atol=1e-8 * scale)
    for whole, expected in ((False, jacobian @ jacobian.T), (True, hessian)):
        matrix = whole_matrix(numbers.matrix(tree, ends, nodes, substeps, whole), width)
        np.testing.assert_allclose(matrix, expected, atol=1e-7 * scale)
    assert np.abs(hessian - jacobian @ jacobian.T).max() > 1e-2 * scale


@pytest.mark.parametrize("sizes", [[1], [2, 3], [4], [5, 1, 6], [9]])
def test_normal_equations_are_solved(numbers, sizes):
    """Branches move no joint in common: all numbers between two of them are zero."""
    width, n, rng = sum(sizes), 4, np.random.default_rng(0)
    ends = np.cumsum([0, *sizes])
    branches = list(pairwise(ends))
    together = block_diag(*(np.ones((size, size)) for size in sizes))
    blocks = np.abs(np.subtract.outer(range(n), range(n))) < 2
    J = (
        rng.normal(size=(n, width, n, width))
        * together[:, None]
        * np.tri(n)[:, None, :, None]
        * blocks[:, None, :, None]
    )
    J = J.reshape(n * width, -1)
    A, damping = J.T @ J, 0.3
    gradient = rng.normal(size=(n + 2, width))
    shaped = A.reshape(n, width, n, width)
    unread = np.full((1, width, width), 7.0)
    diagonal = np.concatenate([unread, [np.tril(shaped[i, :, i]) for i in range(n)], unread])
    between = np.concatenate([unread, [shaped[i, :, i + 1] for i in range(n - 1)], unread])
    given = [one.reshape(len(one), -1) for one in (diagonal, between, gradient)]
    expected = np.linalg.solve(A + damping * np.eye(n * width), -gradient[1:-1].ravel()).reshape(n, width)
    found = np.array(numbers.solved(TREES["chain"], *given, branches, damping))
    np.testing.assert_allclose(found[1:-1], expected, rtol=1e-9, atol=1e-9)
    assert not found[[0, -1]].any()
    assert numbers.solved(TREES["chain"], *given, branches, -1.1 * np.linalg.eigvalsh(A)[0]) is None
