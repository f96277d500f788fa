"""Where a person is in a skeleton, for the names of many rigs; the positions are one person's in all of them."""

import numpy as np
import pytest
from rigs import NAMES, motion_of, person_of, random_segments

from skpose import Bone, Motion, Skeleton
from skpose.kinematics import find_counterparts, retarget

SIDES = ("left", "right")


@pytest.mark.parametrize("options", [{}, {"twists": True}, {"collapsed": True}])
@pytest.mark.parametrize("name", NAMES)
def test_joints_of_all_rigs_are_found(name, options):
    """Onto other rigs and back: equal places of the body are counterparts, whatever they are called."""
    one, truth = person_of(name, **options)
    for other_name in ("LAFAN1", "SOMA", "MMD"):
        other, others_truth = person_of(other_name)
        found = find_counterparts(one, other)
        assert {key: found.get(joint) for key, joint in others_truth.items()} == truth
        back = find_counterparts(other, one)
        assert {key: back.get(joint) for key, joint in truth.items()} == others_truth


def test_a_name_of_the_shank_in_one_rig_is_of_the_thigh_in_another():
    """LeftLeg is the shank of LAFAN1, and the thigh of SOMA; without arms too."""
    lafan, soma = (person_of(name)[0].select(drop=["Spine", "Chest", "Neck", "Head"]) for name in ("LAFAN1", "SOMA"))
    squat = np.zeros(lafan.n_dofs)
    squat[[lafan.dof_names.index(f"{side}Leg_rx") for side in ("Left", "Right")]] = np.radians(70)
    result = retarget(Motion(lafan, [squat], 30), soma, method="auto")
    angles = dict(zip(soma.dof_names, np.degrees(result.angles[0]), strict=True))
    assert angles["LeftShin_rx"] == pytest.approx(70)
    assert angles["LeftLeg_rx"] == pytest.approx(0)


def test_fingers_and_legs_of_chairs_are_not_people():
    """Left and right do not suffice: lengths are not those of legs and arms, or there are none."""
    fingers = [
        Bone(f"{side}_{i}", f"{side}_{i - 1}" if i else None, (0.03, 0, 0), "xyz") for side in SIDES for i in range(2)
    ]
    legs = [
        Bone(f"{side}_{i}", f"{side}_{i - 1}" if i else None, (0, -length, 0), "xyz")
        for side in SIDES
        for i, length in enumerate((0.1, 0.1, 0.5, 0.1))
    ]
    for bones in (fingers, legs):
        with pytest.raises(ValueError, match="not both people"):
            find_counterparts(person_of("LAFAN1")[0], Skeleton(bones, "parent"))


def test_hair_and_tails_and_props_are_not_limbs():
    """Hair on the head is as long as an arm, and both hands hold something."""
    skeleton, truth = person_of("letters")
    extra = []
    for side in "LR":
        extra += [Bone(f"p{side}", "s4", (0.05, 0.1, 0), "ZXY"), Bone(f"q{side}", f"p{side}", (0, -0.3, 0), "ZXY")]
        extra += [Bone(f"r{side}", f"q{side}", (0, -0.26, 0), "ZXY"), Bone(f"t{side}", f"r{side}", (0, -0.05, 0))]
    found = find_counterparts(Skeleton([*skeleton.bones, *extra], "parent"), person_of("SMPL")[0])
    expected = {"left_shoulder": truth["left shoulder"], "right_wrist": truth["right wrist"]}
    assert {joint: found[joint] for joint in expected} == expected
    armed = [Bone(f"{side}Gun", f"{side}Hand", (0, -0.3, 0.2)) for side in ("Left", "Right")]
    armed = Skeleton([*person_of("LAFAN1")[0].bones, *armed], "parent")
    assert "LeftGun" not in find_counterparts(armed, motion_of("Xsens as BVH", random_segments(2))[0].skeleton).values()
    tail = [Bone("Tail", None, (0, 0, -0.2), "ZXY"), Bone("Tail1", "Tail", (0, 0, -0.2), "ZXY")]
    cat = Skeleton([*person_of("LAFAN1")[0].bones, *tail], "parent")
    still, other = Motion(cat, np.zeros((2, cat.n_dofs)), 30), person_of("SMPL")[0]
    with pytest.raises(ValueError, match="Tail"):
        retarget(still, other, method="orientations")
    retarget(still, other, method="orientations", joints={"left_hip": "LeftUpLeg"})
