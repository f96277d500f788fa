"""The parts of inverse kinematics against differences: gradient, Hessian, steps; and one fit from end to end."""

import numpy as np
import pytest
import reference
from conftest import MIXED, random_tree
from entries import from_python
from scipy.spatial.transform import Rotation

from skpose import Bone, Skeleton, inverse_kinematics
from skpose._compiled.inverse.energy import (
    Target,
    add_second_derivatives_of_pose,
    evaluate_pose,
    fill_gradient,
    fill_matrix,
    set_pose,
    start_at,
    workspace_of,
)
from skpose._compiled.inverse.step import retract
from skpose.kinematics._tree import tree_of_all_joints
from skpose.skeleton._root import with_root_joint

evaluate_pose, fill_gradient, fill_matrix = map(from_python, (evaluate_pose, fill_gradient, fill_matrix))
retract, set_pose, start_at = map(from_python, (retract, set_pose, start_at))
add_second_derivatives_of_pose, workspace_of = map(from_python, (add_second_derivatives_of_pose, workspace_of))

pytestmark = pytest.mark.slow  # compiled anew in each process

# Small, so that the tests run without compilation too.
SKELETONS = {
    "ball joints": random_tree(2, n=4, kinds=["rotvec"]),
    "mixed joints": random_tree(3, n=6, kinds=MIXED, offset_frame="parent"),
}


@pytest.fixture(params=SKELETONS)
def case(request):
    """A workspace whose state is a random pose, and a target far from it, some joints without weight."""
    tree = tree_of_all_joints(with_root_joint(SKELETONS[request.param]))
    rng, n, n_frames = np.random.default_rng(0), len(tree.column), len(tree.frame_parent)
    bounds = np.full(n, np.inf)
    work = workspace_of(tree, -bounds, bounds)
    prior = np.tile([1.0, 0.0, 0.0, 0.0], (n_frames, 1)), np.zeros(n)
    set_pose(tree, rng.normal(0, 0.3, n), *prior)
    now = np.tile([1.0, 0.0, 0.0, 0.0], (n_frames, 1)), np.zeros(n)
    set_pose(tree, rng.normal(0, 0.3, n), *now)
    start_at(work.tree, work.here, *now)
    weights = rng.uniform(0.5, 2.0, len(tree.offset))
    weights[:2] = weights[-1] = 0.0
    return work, Target(rng.normal(size=(len(weights), 3)), weights, *prior, 0.3, -bounds, bounds)


def energy(work, target, step, stiffness):
    retract(work.tree, work.here, step, target, work.there)
    return evaluate_pose(work, work.there, target, stiffness)


def dense(work):
    """The matrix, whose entries that no two dofs share are zero."""
    lower = np.tril(work.equations.matrix)
    return lower + np.tril(lower, -1).T


@pytest.mark.parametrize("stiffness", [0.0, 0.3])
def test_the_gradient_is_that_of_the_energy(case, stiffness):
    work, target = case
    evaluate_pose(work, work.here, target, stiffness)
    fill_gradient(work.here, target, stiffness, work)
    n, h = len(work.equations.gradient), 1e-6
    differences = [
        (energy(work, target, h * e, stiffness) - energy(work, target, -h * e, stiffness)) / (2 * h) for e in np.eye(n)
    ]
    np.testing.assert_allclose(work.equations.gradient, differences, atol=1e-7)


def test_the_matrix_with_second_derivatives_is_the_hessian(case):
    work, target = case
    evaluate_pose(work, work.here, target, 0.0)
    fill_gradient(work.here, target, 0.0, work)
    fill_matrix(work.here, 0.0, work)
    add_second_derivatives_of_pose(work.here, work)
    n, h = len(work.equations.gradient), 1e-4
    hessian, steps = np.empty((n, n)), h * np.eye(n)
    for i, a in enumerate(steps):
        for k, b in enumerate(steps):
            terms = (s * t * energy(work, target, s * a + t * b, 0.0) for s in (1, -1) for t in (1, -1))
            hessian[i, k] = sum(terms) / (4 * h * h)
    np.testing.assert_allclose(dense(work), hessian, atol=1e-5)


@pytest.mark.parametrize("limits", ["ignore", "enforce"])
def test_a_small_arm_is_fitted(limits):
    arm = Skeleton(
        [
            Bone("hip", None, (0.2, 0, 0)),
            Bone("back", None, (0, 0, 0.2)),
            Bone("elbow", None, (0, 0.3, 0), "rotvec"),
            Bone("wrist", "elbow", (0, 0.25, 0), "x", limits=[(0.0, 1.0)]),
        ]
    )
    poses = np.array([[0.3, 0.1, -0.5, 0.7], [0.4, 0.1, -0.6, 0.8], [0.4, 0.1, -0.6, 1.4]])
    turn = Rotation.from_rotvec([0.1, 0.2, 0.3])
    positions = np.stack([turn.apply(p) for p in reference.forward_kinematics(poses, arm)]) + np.array([1.0, 2.0, 3.0])
    fitted = inverse_kinematics(positions, arm, joint_limits=limits)
    free = inverse_kinematics(positions, arm, joint_limits=limits, initial=np.zeros((3, 4)))
    for found in (fitted, free):
        assert found.converged.all()
        np.testing.assert_allclose(found.poses[:2, 3], poses[:2, 3], atol=1e-6)
        np.testing.assert_allclose(found.residuals[:2], 0, atol=1e-6)
        np.testing.assert_allclose(found.root_rotations[:2], [[0.1, 0.2, 0.3]] * 2, atol=1e-6)
        assert found.poses[2, 3] == pytest.approx(1.0 if limits == "enforce" else 1.4, abs=1e-6)
