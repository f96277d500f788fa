"""Positions of the joints of a motion in the world, and the motion as keypoints."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import SKELETONS, in_space

from skpose import Motion, inverse_kinematics
from skpose.datasets import make_actions


@pytest.mark.parametrize("name", ["humanoid", "mixed joints", "tree, offsets in the parent's frame"])
def test_positions_are_rotated_and_moved_by_the_root(name):
    rng, skeleton = np.random.default_rng(0), SKELETONS[name]
    poses = rng.normal(size=(5, skeleton.n_dofs))
    motion = Motion(skeleton, poses, 30, rng.normal(size=(5, 3)), rng.normal(size=(5, 3)), root_axes="ZYX")
    np.testing.assert_allclose(motion.positions(), in_space(motion), atol=1e-12)


def test_keypoints_are_the_root_and_the_joints_at_their_times():
    jump = make_actions(1, 1, actions=["jump"], frame_rate=20, random_state=0)[0]
    seen = np.ones((len(jump), jump.skeleton.n_joints), bool)
    seen[3, 2] = False
    kept = np.r_[0:5, 8 : len(jump)]
    rows = {name: getattr(jump, name)[kept] for name in ("angles", "root_positions", "root_angles")}
    points = replace(jump, **rows, frame_numbers=kept, seen=seen[kept]).to_keypoints()
    assert points.names == (jump.root_name, *jump.skeleton.joint_names)
    assert (len(points), points.frame_rate, points.up) == (len(jump), 20, jump.up)
    expected = np.concatenate([jump.root_positions[:, None], in_space(jump)], axis=1)
    expected[5:8] = expected[3, 3] = np.nan
    np.testing.assert_allclose(points.positions, expected, atol=1e-12)


def test_poses_are_found_again_from_keypoints():
    jump = make_actions(1, 1, actions=["jump"], frame_rate=20, random_state=0)[0]
    again = inverse_kinematics(jump.to_keypoints(), jump.skeleton).to_motion()
    np.testing.assert_allclose(again.positions(), jump.positions(), atol=1e-6)
