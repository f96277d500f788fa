"""Skeletons that are fitted to sets of markers are people: their joints have counterparts in other rigs."""

import pytest
from people import moving

from skpose import inverse_kinematics
from skpose.datasets import humanoid
from skpose.keypoints import fit_skeleton, layouts
from skpose.kinematics import retarget

# Where our own person's joints are in each set, for the left side, and the bones that have one direction in both.
PLACES = {
    "plug_in_gait39": "left_hip LKNE LANK LTOE LSHO LELB left_wrist LFIN",
    "opencap43": "LHJC_study left_knee left_ankle L_toe_study L_shoulder_study left_elbow left_wrist",
    "opencap_mocap55": "L_HJC L_KJC L_AJC L_toe L_Shoulder L_EJC L_WJC",
    "pose2sim21": "left_hip left_knee left_ankle left_big_toe left_shoulder left_elbow left_wrist",
}


@pytest.mark.parametrize("name", PLACES)
def test_markers_of_a_person_move_another_rig(name):
    layout = layouts[name]
    keypoints = layout.keypoints(moving(layout, n=20), 30)
    motion = inverse_kinematics(keypoints, fit_skeleton(keypoints, layout)).to_motion()
    assert len(retarget(motion, humanoid(), method="auto", scale="lengths")) == 20
