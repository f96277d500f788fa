"""People have volume in displays, seen from the side that shows the movement, on the ground."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from conftest import SKELETONS
from matplotlib.collections import LineCollection, PathCollection

from skpose import Motion, forward_kinematics
from skpose.datasets import make_gait
from skpose.plot import PoseDisplay
from skpose.view._shape import find_shape

pytestmark = pytest.mark.usefixtures("agg")


HUMANOID = SKELETONS["humanoid"]


STANDING = np.zeros(HUMANOID.n_dofs)


def volumes(ax):
    return [one for one in ax.collections if isinstance(one, PathCollection)]


def grounds(ax):
    lines = [one for one in ax.collections if isinstance(one, LineCollection)]
    return [one.get_segments()[0][:, 1] for one in lines]


def test_a_person_has_an_edge_and_an_area_for_each_part():
    ax = PoseDisplay.from_pose(STANDING, HUMANOID).ax_
    (drawn,) = volumes(ax)
    assert len(drawn.get_paths()) == 2 * len(find_shape(HUMANOID).parts)
    corners = np.concatenate([path.vertices for path in drawn.get_paths()])
    joints = forward_kinematics(STANDING[None], HUMANOID)[0][:, :2]
    assert (corners.min(axis=0) <= joints.min(axis=0)).all()
    assert (corners.max(axis=0) >= joints.max(axis=0) - 1e-12).all()  # of the head it is the top


@pytest.mark.parametrize("name", ["chain", "tree"])
def test_others_are_lines_alone(name):
    skeleton = SKELETONS[name]
    assert not PoseDisplay.from_pose(np.zeros(skeleton.n_dofs), skeleton).ax_.collections


def test_the_side_shows_the_movement():
    gait = make_gait(1, 1, random_state=0)
    assert PoseDisplay.from_motion(gait.motions[0]).projection_ == "zy"
    assert (
        PoseDisplay.from_pose(STANDING, HUMANOID).projection_ == "xy"
    )  # nothing moves: wider from shoulder to shoulder
    spread = np.array(np.broadcast_to(STANDING, (5, HUMANOID.n_dofs)))
    spread[:, HUMANOID.dof_names.index("left_upper_arm_rz")] = np.linspace(0, 1.5, 5)
    assert PoseDisplay.from_poses(spread, HUMANOID).projection_ == "xy"
    assert PoseDisplay.from_poses(spread, HUMANOID, projection="zy").projection_ == "zy"


def test_the_vertical_is_that_of_the_motion():
    motion = Motion(HUMANOID, np.zeros((4, HUMANOID.n_dofs)), 30, up="z")
    assert PoseDisplay.from_motion(motion).projection_ == "yz"  # the wider one of the two others


def test_the_ground_is_at_the_lowest_foot_and_in_axes_of_ones_own_alone():
    ax = PoseDisplay.from_pose(STANDING, HUMANOID).ax_
    (ground,) = grounds(ax)
    lowest = forward_kinematics(STANDING[None], HUMANOID)[0][:, 1].min()
    assert ground[0] == ground[1]
    assert lowest - 0.05 < ground[0] < lowest
    _, given = plt.subplots()
    assert not grounds(PoseDisplay.from_pose(STANDING, HUMANOID, ax=given).ax_)
    assert not grounds(PoseDisplay.from_pose(STANDING, HUMANOID, projection="xz").ax_)
    assert len(grounds(PoseDisplay.from_poses(STANDING[None], HUMANOID, ax=given).ax_)) == 1


def test_parts_with_unknown_joints_are_left_out():
    positions = forward_kinematics(STANDING[None], HUMANOID)[0]
    positions[HUMANOID.joint_names.index("left_hand")] = np.nan
    whole, partial = (
        len(volumes(PoseDisplay.from_positions(p, HUMANOID).ax_)[0].get_paths())
        for p in (forward_kinematics(STANDING[None], HUMANOID)[0], positions)
    )
    assert partial == whole - 2  # one part, its edge and its area
