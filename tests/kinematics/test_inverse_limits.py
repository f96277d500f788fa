"""Inverse kinematics within limits: none is left, and what has none is as free as without any."""

import numpy as np
import pytest
from limited import assert_inside, limited_skeleton, poses_inside

from skpose import Bone, Skeleton, forward_kinematics, inverse_kinematics
from skpose.datasets import humanoid

# Far joints, which determine the root's orientation, and an elbow.
ARM = [*(Bone(name, None, 10 * np.eye(3)["xyz".index(name)]) for name in "xyz"), Bone("elbow", None, (0.3, 0, 0))]


@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning", "ignore:values of .* reach:UserWarning")
@pytest.mark.parametrize("seeds", [range(k, k + 15) for k in range(0, 60, 15)])
def test_no_pose_leaves_the_limits(seeds):
    """Not for starts far outside, nor for positions that cannot be reached or are not seen."""
    for seed in seeds:
        skeleton, rng = limited_skeleton(seed), np.random.default_rng(seed)
        n = 6
        positions = forward_kinematics(poses_inside(skeleton, n, seed), skeleton)
        positions = positions + rng.normal(size=positions.shape) * rng.choice([0.0, 0.2])
        positions[2, rng.integers(skeleton.n_joints)] = np.nan
        outside = 4 * rng.normal(size=(n, skeleton.n_dofs))
        for initial in (None, outside[0], outside):
            for regularization in (0.0, 0.02):
                options = {"initial": initial, "regularization": regularization, "joint_limits": "enforce"}
                assert_inside(inverse_kinematics(positions, skeleton, **options).poses, skeleton)


def test_joints_without_limits_turn_freely():
    """Limits of elbows and knees do not make shoulders and hips angles with their gimbal lock."""
    free = humanoid()
    skeleton = Skeleton(b._replace(limits=((-0.1, 2.6),)) if b.n_dofs == 1 else b for b in free.bones)
    poses = np.clip(np.random.default_rng(0).normal(0, 0.7, (60, free.n_dofs)), *skeleton.limits.T)
    fitted = inverse_kinematics(
        forward_kinematics(poses, free), skeleton, initial=np.zeros_like(poses), joint_limits="enforce"
    )
    assert_inside(fitted.poses, skeleton)
    assert (fitted.residuals.max(axis=1) < 1e-5).mean() > 0.8


@pytest.mark.parametrize("limits", [(-3.0, 2.8), (0.5, 5.5), (-6.0, 6.0), (-0.5, np.inf), (-np.inf, 2.0)])
def test_hinges_find_angles_on_the_other_side_of_the_gap(limits):
    """The first turn from the initial pose goes past π; the same rotation within the limits is taken."""
    arm = Skeleton([*ARM, Bone("wrist", "elbow", (0.25, 0, 0), "z", limits=(limits,))])
    lower, upper = np.clip(limits, -4.0, 6.0)
    poses, starts = np.meshgrid(np.linspace(lower, upper, 15), np.linspace(lower, upper, 7))
    positions = forward_kinematics(poses.reshape(-1, 1), arm)
    fitted = inverse_kinematics(positions, arm, initial=starts.reshape(-1, 1), joint_limits="enforce")
    assert_inside(fitted.poses, arm)
    assert fitted.residuals.max() < 1e-3


@pytest.mark.parametrize("start", [-2.9, 0.0, 2.7])
def test_hinges_that_cannot_reach_stop_at_the_nearer_limit(start):
    """In the gap of a limited hinge; the reference is the best of a fine grid of angles, with the root fixed."""
    wide = Skeleton([*ARM, Bone("wrist", "elbow", (0.25, 0, 0), "z")])
    arm = Skeleton([*wide.bones[:-1], wide.bones[-1]._replace(limits=((-3.0, 2.8),))])
    targets = np.array([[2.85], [2.9], [-3.05], [3.0], [3.1]])
    positions = forward_kinematics(targets, wide)
    fitted = inverse_kinematics(positions, arm, initial=np.full((5, 1), start), joint_limits="enforce")
    grid = np.linspace(-3.0, 2.8, 2001)[:, None]
    off = np.linalg.norm(forward_kinematics(grid, wide)[:, None, -1] - positions[None, :, -1], axis=2)
    np.testing.assert_allclose(fitted.poses, grid[off.argmin(axis=0)], atol=3e-3)
