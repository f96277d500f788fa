"""Inverse kinematics within limits: none is left, and what has none is as free as without any."""

import numpy as np
import pytest
from limited import assert_inside, limited_skeleton, poses_inside

from skpose import Bone, Skeleton, forward_kinematics, inverse_kinematics

# Far joints, which determine the root's orientation, and an elbow.
ARM = [*(Bone(name, None, 10 * np.eye(3)["xyz".index(name)]) for name in "xyz"), Bone("elbow", None, (0.3, 0, 0))]


@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning", "ignore:values of .* reach:UserWarning")
@pytest.mark.parametrize("seeds", [range(6)])
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


@pytest.mark.parametrize("limits", [(-3.0, 2.8), (0.5, 5.5), (-0.5, np.inf)])
def test_hinges_find_angles_on_the_other_side_of_the_gap(limits):
    """The first turn from the initial pose goes past π; the same rotation within the limits is taken."""
    arm = Skeleton([*ARM, Bone("wrist", "elbow", (0.25, 0, 0), "z", limits=(limits,))])
    lower, upper = np.clip(limits, -4.0, 6.0)
    poses, starts = np.meshgrid(np.linspace(lower, upper, 15), np.linspace(lower, upper, 7))
    positions = forward_kinematics(poses.reshape(-1, 1), arm)
    fitted = inverse_kinematics(positions, arm, initial=starts.reshape(-1, 1), joint_limits="enforce")
    assert_inside(fitted.poses, arm)
    assert fitted.residuals.max() < 1e-3
