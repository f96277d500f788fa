"""Skeletons that are fitted to sets of markers are people: their joints have counterparts in other rigs."""

import pytest
from people import moving

from skpose import inverse_kinematics
from skpose.datasets import humanoid
from skpose.keypoints import fit_skeleton, layouts
from skpose.kinematics import retarget


@pytest.mark.parametrize("name", ["plug_in_gait39", "opencap43", "pose2sim21"])
def test_markers_of_a_person_move_another_rig(name):
    layout = layouts[name]
    keypoints = layout.keypoints(moving(layout, n=20), 30)
    motion = inverse_kinematics(keypoints, fit_skeleton(keypoints, layout)).to_motion()
    assert len(retarget(motion, humanoid(), method="auto", scale="lengths")) == 20
