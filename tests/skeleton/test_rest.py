"""Skeletons with different rest poses."""

import numpy as np
import pytest
from reference import forward_kinematics
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton, pose_distances
from skpose.datasets import MotionDataset
from skpose.kinematics import retarget


def person(dofs="ZXY", frame="parent", arm=(1, 0, 0)):
    """A trunk with a head, two legs and one arm, which points in a given direction."""
    arm = np.array(arm) / np.linalg.norm(arm)
    bones = [
        Bone("spine", None, (0, 0.2, 0), dofs),
        Bone("shoulder", "spine", (0.2, 0.3, 0), dofs),
        Bone("elbow", "shoulder", 0.3 * arm, dofs),
        Bone("wrist", "elbow", 0.25 * arm, dofs),
        Bone("tip", "wrist", 0.1 * arm),
        Bone("head", "spine", (0, 0.5, 0.02), dofs),
        Bone("left_hip", None, (0.1, -0.05, 0), dofs),
        Bone("right_hip", None, (-0.1, -0.05, 0), dofs),
        Bone("left_knee", "left_hip", (0, -0.4, 0), dofs),
        Bone("right_knee", "right_hip", (0, -0.4, 0), dofs),
    ]
    return Skeleton(bones, frame)


T_POSE, A_POSE = person(), person(arm=(1, -1.3, 0))


def test_a_t_pose_and_an_a_pose_are_not_mixed():
    """All zeros on both are different poses; the distance after conversion is that of the positions in the world."""
    t, a = (Motion(skeleton, np.zeros((2, skeleton.n_dofs)), 30) for skeleton in (T_POSE, A_POSE))
    wrong = "bone of 'elbow' by 52°"
    with pytest.raises(ValueError, match=wrong):
        Skeleton.mean([T_POSE, A_POSE])
    with pytest.raises(ValueError, match=wrong):
        retarget(a, T_POSE)
    dataset = MotionDataset([t, t, a], *[["0", "1", "2"]] * 3, rotations="file")
    with pytest.raises(ValueError, match=wrong):
        dataset.poses()

    X, _ = dataset.retarget(T_POSE, method="orientations").poses()
    gap = forward_kinematics(np.zeros(T_POSE.n_dofs), T_POSE) - forward_kinematics(np.zeros(A_POSE.n_dofs), A_POSE)
    distance = pose_distances(X, skeleton=T_POSE, metric="position")[0, 4]
    np.testing.assert_allclose(distance, np.linalg.norm(gap), atol=1e-9)
    assert distance > 0.5
    X, _ = dataset.retarget(T_POSE, method="unchecked").poses()
    np.testing.assert_array_equal(X, 0.0)


def test_rest_rotations_are_compared():
    def joint(angle, dofs="x"):
        rest = Rotation.from_euler("x", angle, degrees=True).as_matrix()
        return Skeleton([Bone("a", None, (1, 0, 0), "z"), Bone("b", "a", (1, 0, 0), dofs, rest)])

    assert Skeleton.mean([joint(0), joint(44)]).n_joints == 2
    with pytest.raises(ValueError, match="rest rotation of 'b' by 46°"):
        Skeleton.mean([joint(0), joint(46)])
    assert Skeleton.mean([joint(0, ""), joint(46, "")]).n_joints == 2  # its axes move nothing
