"""Skeletons that are fitted to sets of markers are people: their joints have counterparts in other rigs."""

import numpy as np
import pytest
from conftest import in_space
from people import moving

from skpose import inverse_kinematics
from skpose.datasets import humanoid, make_gait
from skpose.keypoints import fit_skeleton, layouts
from skpose.kinematics import find_counterparts, retarget

# Where our own person's joints are in each set, for the left side, and the bones that have one direction in both.
PLACES = {
    "plug_in_gait39": "left_hip LKNE LANK LTOE LSHO LELB left_wrist LFIN",
    "opencap43": "LHJC_study left_knee left_ankle L_toe_study L_shoulder_study left_elbow left_wrist",
    "opencap_mocap55": "L_HJC L_KJC L_AJC L_toe L_Shoulder L_EJC L_WJC",
    "pose2sim21": "left_hip left_knee left_ankle left_big_toe left_shoulder left_elbow left_wrist",
}
_BONES = ("pelvis", "thigh", "shank", "foot", "clavicle", "upper_arm", "forearm", "hand")
OURS = [f"left_{bone}" for bone in _BONES]
BONES = [(0, 1), (1, 2), (2, 3), (4, 5), (5, 6), (6, 7)]


def other_side(name):
    return name.replace("left", "right") if "left" in name else "R" + name[1:]


@pytest.mark.parametrize("name", PLACES)
def test_bones_of_other_rigs_have_counterparts_in_marker_sets(name):
    layout = layouts[name]
    keypoints = layout.keypoints(moving(layout, n=20), 30)
    skeleton = fit_skeleton(keypoints, layout)
    left = PLACES[name].split()
    pairs = [*zip(OURS, left, strict=False)]
    pairs += [(other_side(one), other_side(other)) for one, other in pairs]
    found = find_counterparts(skeleton, humanoid())
    toes = {f"{side}_toes": found.get(f"{side}_toes") for side in ("left", "right")} if name == "pose2sim21" else {}
    if toes:  # the end of the toe, where the others have the head of a metatarsal
        assert list(toes.values()) == ["left_big_toe", "right_big_toe"]
        pairs = [pair for pair in pairs if "foot" not in pair[0]]
    assert {ours: found.get(ours) for ours, _ in pairs} == dict(pairs)
    assert ("head" in found) == (name in ("plug_in_gait39", "pose2sim21"))

    # A motion of our own person on the markers: bones point where they did, by plain differences of positions.
    motion = make_gait(1, 1, random_state=0).motions[0][:5]
    there = retarget(motion, skeleton, method="orientations")
    places = [in_space(one) for one in (motion, there)]
    for start, end in BONES[:2] + BONES[3:5]:
        for side in (0, 1):
            ours, theirs = ([other_side(n) if side else n for n in names] for names in (OURS, left))
            a = places[0][:, [motion.skeleton.joint_names.index(ours[i]) for i in (start, end)]]
            b = places[1][:, [skeleton.joint_names.index(theirs[i]) for i in (start, end)]]
            a, b = (x[:, 1] - x[:, 0] for x in (a, b))
            cosines = (a * b).sum(axis=1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
            np.testing.assert_allclose(cosines, 1.0, atol=1e-9)


@pytest.mark.parametrize("name", PLACES)
def test_markers_of_a_person_move_another_rig(name):
    layout = layouts[name]
    keypoints = layout.keypoints(moving(layout, n=20), 30)
    motion = inverse_kinematics(keypoints, fit_skeleton(keypoints, layout)).to_motion()
    assert len(retarget(motion, humanoid(), method="auto", scale="lengths")) == 20
