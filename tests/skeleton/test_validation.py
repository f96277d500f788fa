"""Skeletons, motions, positions and rotations passed as poses."""

import numpy as np
import pytest

from skpose import Bone, Motion, Skeleton, forward_kinematics, pose_distances
from skpose.geodesics import frechet_mean
from skpose.preprocessing import PoseDistanceTransformer

ARM = Skeleton.chain(2)
MOTION = Motion(ARM, np.linspace([0, 0], [1, 2], 5), 10)
POSES = MOTION.angles

OF_POSES = {
    "pose_distances": ("X", lambda X: pose_distances(X, skeleton=ARM)),
    "pose_distances, no skeleton": ("X", lambda X: pose_distances(X, metric="angle")),
    "pose_distances, Y": ("Y", lambda X: pose_distances(POSES, X, skeleton=ARM)),
    "forward_kinematics": ("angles", lambda X: forward_kinematics(X, ARM)),
    "frechet_mean": ("X", lambda X: frechet_mean(X, ARM)),
    "fit": ("X", lambda X: PoseDistanceTransformer(ARM).fit(X)),
    "transform": ("X", lambda X: PoseDistanceTransformer(ARM).fit(POSES).transform(X)),
}


@pytest.mark.parametrize("name", OF_POSES)
def test_motions_and_skeletons_are_not_poses(name):
    argument, function = OF_POSES[name]
    for wrong, remedy in ((MOTION, "motion.angles"), (ARM, "skeleton="), ([MOTION, MOTION], "motion.angles")):
        with pytest.raises(TypeError, match=f"{argument} must be an array of poses.*{remedy}"):
            function(wrong)


BALLS = Skeleton([Bone("a", None, (1, 0, 0), "zx"), Bone("b", "a", (1, 0, 0), "y"), Bone("c", "b", (1, 0, 0))])


@pytest.mark.parametrize("shape", [(5, 9), (5, 12), (5, 4, 3)])
def test_positions_of_joints_are_recognised(shape):
    """With the root or without it, as rows or as (n_poses, n_joints, 3); lists too."""
    for X in (np.ones(shape), np.ones(shape).tolist()):
        with pytest.raises(ValueError, match="PoseFromPositions"):
            pose_distances(X, skeleton=BALLS)


@pytest.mark.parametrize("shape", [(5, 2, 4), (5, 2, 6), (5, 2, 3, 3)])
def test_rotations_of_joints_are_recognised(shape):
    with pytest.raises(ValueError, match="poses_from_rotations"):
        pose_distances(np.ones(shape), skeleton=BALLS)
