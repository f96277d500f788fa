"""Counterparts of joints by the names of rigs, against one motion that is written as files of eight rigs.

The truth is that of `rigs`: where the joints of each file are, without the library. Controls are skeletons whose names
look like others and mean something else.
"""

import io
import re

import numpy as np
import pytest
from conftest import in_space
from rigs import LIMBS, POINTS, RIGS, file_of, limbs_of, motion_of, other_side, random_segments

from skpose import Bone, Motion, Skeleton
from skpose.datasets import MotionDataset, humanoid, make_gait
from skpose.io import load_bvh, save_bvh
from skpose.keypoints import fit_skeleton, layouts
from skpose.kinematics import find_counterparts, retarget
from skpose.kinematics._landmarks import find_landmarks
from skpose.kinematics._rigs import RIGS as TABLES
from skpose.skeleton._shared import others

SEGMENTS = random_segments()
BONES = [("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist")]
SIDES = ("left", "right")
# Names in which a person's arms and legs are in ASF files, in SMPL, and in our own person: typed from those files.
ASF = dict(zip(LIMBS, ("hipjoint", "femur", "tibia", "clavicle", "humerus", "wrist"), strict=True))
SMPL = {joint: joint for joint in LIMBS}
OURS = dict(zip(LIMBS, ("pelvis", "thigh", "shank", "clavicle", "upper_arm", "forearm"), strict=True))


@pytest.fixture(scope="module")
def files():
    return {name: motion_of(name, SEGMENTS) for name in RIGS}


def cmu_person():
    """A skeleton with the names, points and offset frame of CMU's ASF files, in their T-pose."""
    rows = {
        "lhipjoint": (None, (0.09, -0.1, 0.03)),
        "lfemur": ("lhipjoint", (0.15, -0.4, 0)),
        "ltibia": ("lfemur", (0.14, -0.39, 0)),
        "lfoot": ("ltibia", (0.01, -0.03, 0.12)),
        "ltoes": ("lfoot", (0, 0, 0.06)),
        "lowerback": (None, (0, 0.116, -0.01)),
        "upperback": ("lowerback", (0, 0.117, 0)),
        "thorax": ("upperback", (0, 0.117, 0)),
        "lowerneck": ("thorax", (0, 0.089, 0.01)),
        "upperneck": ("lowerneck", (0, 0.088, -0.01)),
        "head": ("upperneck", (0, 0.092, 0)),
        "lclavicle": ("thorax", (0.2, 0.05, -0.01)),
        "lhumerus": ("lclavicle", (0.275, 0, 0)),
        "lradius": ("lhumerus", (0.19, 0, 0)),
        "lwrist": ("lradius", (0.095, 0, 0)),
        "lhand": ("lwrist", (0.037, 0, 0)),
        "lfingers": ("lhand", (0.03, 0, 0)),
        "lthumb": ("lwrist", (0.03, 0, 0.03)),
    }
    bones = []
    for name, (parent, offset) in rows.items():
        middle = ("lowerback", "upperback", "thorax", "lowerneck", "upperneck", "head")
        for side in " " if name in middle else "lr":
            new, above = (one if one in (None, *middle) else side + one[1:] for one in (name, parent))
            mirrored = np.array(offset) * [-1.0 if side == "r" else 1.0, 1, 1]
            bones.append(Bone(new, above, mirrored, "rotvec" if not new.endswith("hipjoint") else ""))
    return Skeleton(bones)


def directions_of_limbs(where, limbs):
    """Directions of thighs, shanks, upper arms and forearms; where is a mapping of names to positions."""
    found = []
    for side in SIDES:
        for start, end in BONES:
            bone = where[limbs[f"{side} {end}"]] - where[limbs[f"{side} {start}"]]
            found.append(bone / np.linalg.norm(bone, axis=1, keepdims=True))
    return np.stack(found, axis=1)


def positions_by_name(motion):
    return dict(zip(motion.skeleton.joint_names, in_space(motion).swapaxes(0, 1), strict=True))


def degrees(a, b):
    return np.degrees(2.0 * np.arcsin(np.linalg.norm(a - b, axis=-1) / 2.0))


# --- what is matched -------------------------------------------------------------------------------------------------


RING = [*zip(RIGS, [*list(RIGS)[1:], next(iter(RIGS))], strict=True), ("Bandai-Namco", "CMU as BVH")]
PAIRS = [
    pytest.param(here, there, marks=[] if (here, there) in RING else pytest.mark.slow)
    for here in RIGS
    for there in RIGS
]


@pytest.mark.parametrize(("here", "there"), PAIRS)
def test_limbs_keep_their_directions_between_rigs(files, here, there):
    """Joints are where they were but for some centimetres: of one person, whose collarbones begin elsewhere."""
    (motion, where), (other, _) = files[here], files[there]
    dataset = MotionDataset([motion]).retarget(other.skeleton, method="auto")
    found = positions_by_name(dataset[0])
    a, b = directions_of_limbs(where, limbs_of(here)), directions_of_limbs(found, limbs_of(there))
    if here == there:
        assert dataset.retargeting == ("same numbers",)
    else:
        assert re.match(
            r"orientations, 2\d of [23]\d joints, directions within [\d.]+°(; at rest: .*)?$", dataset.retargeting[0]
        )
    # Worlds stay: z is up in the result of a file with z up. Only in the rest pose axes are others.
    assert degrees(a, b).max() < 1e-5
    limbs = [(limbs_of(here)[key], limbs_of(there)[key]) for key in limbs_of(here)]
    apart = np.stack([found[new] - where[old] for old, new in limbs], axis=1)
    assert np.linalg.norm(apart, axis=2).max() < (0.06 if "CMU as BVH" in (here, there) else 0.025)


@pytest.mark.parametrize("name", RIGS)
def test_joints_of_limbs_are_their_counterparts(files, name):
    """Against names that are typed here, and not taken from the library's tables."""
    source = files[name][0].skeleton
    for target, base, pattern in (
        (cmu_person(), ASF, "{0[0]}{1}"),
        (humanoid(), OURS, "{0}_{1}"),
    ):
        found = find_counterparts(source, target)
        places = [(side, joint) for side in SIDES for joint in LIMBS]
        expected = {pattern.format(side, base[joint]): limbs_of(name)[f"{side} {joint}"] for side, joint in places}
        assert {joint: found.get(joint) for joint in expected} == expected
        back = find_counterparts(target, source)
        assert {back[old] for old in expected.values()} == set(expected)


def test_the_wrist_of_an_asf_file_is_where_it_bends(files):
    """Its radius ends within the forearm: the two bones of the forearm stay on one line."""
    motion, where = files["Mixamo"]
    target = cmu_person()
    found = find_counterparts(motion.skeleton, target)
    assert (found["lwrist"], "lradius" in found) == ("mixamorig:LeftHand", False)
    there = positions_by_name(retarget(motion, target, method="orientations"))
    forearm = where["mixamorig:LeftHand"] - where["mixamorig:LeftForeArm"]
    for start, end in (("lhumerus", "lradius"), ("lradius", "lwrist")):
        bone = there[end] - there[start]
        sizes = np.linalg.norm(forearm, axis=1) * np.linalg.norm(bone, axis=1)
        np.testing.assert_allclose((bone * forearm).sum(axis=1) / sizes, 1.0, atol=1e-12)


def test_heads_are_not_matched_by_name():
    """The joint "Head" of a BVH file is where the head begins, the "head" of an ASF file its top."""
    bvh = motion_of("LAFAN1", SEGMENTS)[0].skeleton
    found = find_counterparts(bvh, cmu_person())
    assert (found["upperneck"], found["head"]) == ("Head", "Head_end")
    # "LeftShoulder" is where the collarbone begins in the one, and the shoulder in the other.
    found = find_counterparts(bvh, motion_of("Xsens as BVH", SEGMENTS)[0].skeleton)
    assert (found["LeftCollar"], found["LeftShoulder"]) == ("LeftShoulder", "LeftArm")


@pytest.mark.parametrize(
    ("rig", "rename"),
    [
        ("Mixamo", lambda name: name.removeprefix("mixamorig:")),
        ("Mixamo", lambda name: name.replace(":", "_")),
        ("Mixamo", lambda name: name.replace("mixamorig:", "Character1_")),
        ("Mixamo", str.upper),
        ("Biped", lambda name: name.replace("Bip01", "Bip001")),
        ("Biped", lambda name: name.replace("Bip01 ", "ValveBiped.")),
        ("Bandai-Namco", lambda name: re.sub(r"^(\w+?)_([LR])", r"\2_\1", name)),
        ("Bandai-Namco", lambda name: name.replace("_L", ".L").replace("_R", ".R")),
        ("Bandai-Namco", lambda name: name.replace("_L", "_left").replace("_R", "_right")),
        ("Xsens as BVH", lambda name: name.replace("Left", "l_").replace("Right", "r_")),
        ("LAFAN1", lambda name: f"sim{name}"),
        ("Xsens as BVH", lambda name: f"{name}_01"),
        ("Mixamo", lambda name: f"{name}.001"),
        ("Unreal", lambda name: f"SK_{name}_2"),
    ],
)
def test_prefixes_sides_and_cases(files, rig, rename):
    """A file with other spelling has the same counterparts."""
    other = files["Rokoko"][0].skeleton
    text, _ = file_of(RIGS[rig], SEGMENTS, rename=rename)
    spelt = load_bvh(io.StringIO(text), scale=0.01, up=RIGS[rig].up)
    expected = find_counterparts(files[rig][0].skeleton, other)

    def renamed(name):  # the reader names End Sites by the joint and "_end"
        joint = name.removesuffix("_end")
        return rename(name) if joint == name else f"{rename(joint)}_end"

    assert find_counterparts(spelt.skeleton, other) == {new: renamed(old) for new, old in expected.items()}


def test_found_counterparts_can_be_passed(files):
    motion, other = files["Bandai-Namco"][0], files["Unreal"][0].skeleton
    found = find_counterparts(motion.skeleton, other)
    one = retarget(motion, other, method="orientations")
    two = retarget(motion, other, method="orientations", joints=found)
    np.testing.assert_array_equal(one.angles, two.angles)
    np.testing.assert_array_equal(one.root_positions, two.root_positions)
    # Only the legs: the arms stay at rest, as their joints are left out, and the chest is not rotated by them.
    legs = {new: old for new, old in found.items() if old.startswith(("UpperLeg", "LowerLeg", "Foot"))}
    found = retarget(motion, other, method="orientations", joints=legs)
    columns = [i for i, name in enumerate(other.dof_names) if name.startswith(("clav", "upper", "lower", "hand"))]
    np.testing.assert_array_equal(found.angles[:, columns], 0.0)
    dataset = MotionDataset([motion]).retarget(other, method="orientations", joints=legs)
    assert dataset.retargeting[0].startswith("orientations, 6 of 28 joints")


def test_hips_stay_where_they_are():
    """The root of one file is at the hips, that of the other 10 cm above them."""
    motion, where = motion_of("Xsens as BVH", SEGMENTS)
    other = motion_of("CMU as BVH", SEGMENTS)[0]
    found = positions_by_name(retarget(motion, other.skeleton, method="orientations"))
    for side in ("Left", "Right"):
        np.testing.assert_allclose(found[f"{side}UpLeg"], where[f"{side}Hip"], atol=1e-9)
        np.testing.assert_allclose(found[f"{side}Foot"], where[f"{side}Ankle"], atol=1e-9)


def test_people_of_another_size(files):
    """Lengths of limbs are compared, and not those of trunks, which begin and end elsewhere."""
    motion = files["Mixamo"][0]
    text, _ = file_of(RIGS["Bandai-Namco"], SEGMENTS)
    small = load_bvh(io.StringIO(text), scale=0.008).skeleton
    found = retarget(motion, small, method="orientations", scale="lengths")
    feet = positions_by_name(found)["Foot_L"][:, 1]
    np.testing.assert_allclose(feet, 0.8 * positions_by_name(motion)["mixamorig:LeftFoot"][:, 1], atol=2e-3)


def test_a_person_whose_joints_are_hinges(files):
    """Positions of the limbs, and of the feet and the head, are reached; those of the trunk have no part in it."""
    dataset = MotionDataset([files["Mixamo"][0]]).retarget(humanoid(), method="auto", scale="lengths")
    found = re.match(r"positions, 15 of 22 joints within ([\d.]+) cm; at rest: (.*)$", dataset.retargeting[0])
    assert float(found[1]) < 12.0
    assert set(found[2].split(", ")) == {"head", *(f"{side}_{end}" for side in SIDES for end in ("hand", "toes"))}
    assert repr(dataset) == "MotionDataset(1 motions; retargeted by 1 positions, 15 of 22 joints or more)"


@pytest.mark.parametrize("name", ["coco17", "mediapipe33", "h36m17", "body25", "kinect25", "smpl24", "cmu31"])
def test_keypoint_layouts(name):
    """Skeletons that are fitted to keypoints are people too."""
    layout = layouts[name]
    rng = np.random.default_rng(0)
    person = person_of_layout(layout)
    positions = np.stack([person[point] for point in layout.names])[None] + rng.normal(scale=1e-3, size=(4, 1, 1))
    if layout.up.startswith("-"):
        positions = positions * [1, -1, -1]
    elif layout.up == "z":
        positions = positions[..., [0, 2, 1]] * [1, -1, 1]
    skeleton = fit_skeleton(layout.keypoints(positions, 30), layout)
    found = find_landmarks(skeleton)
    assert name in found.rig or {"smpl24": "SMPL", "cmu31": "CMU"}[name] in found.rig
    limbs = ASF if name == "cmu31" else SMPL
    pattern = "{0[0]}{1}" if name == "cmu31" else "{0}_{1}"
    there = find_counterparts(skeleton, humanoid())
    for side in SIDES:
        for joint in LIMBS:
            assert there[f"{side}_{OURS[joint]}"] == pattern.format(side, limbs[joint])
    motion = make_gait(1, 1, random_state=0).motions[0][:5]
    result = retarget(motion, skeleton, method="orientations")
    a = directions_of_limbs(
        positions_by_name(motion), {f"{side} {joint}": f"{side}_{OURS[joint]}" for side in SIDES for joint in LIMBS}
    )
    names = {f"{side} {joint}": pattern.format(side, limbs[joint]) for side in SIDES for joint in LIMBS}
    assert degrees(a, directions_of_limbs(positions_by_name(result), names)).max() < 1e-5


def person_of_layout(layout):
    """Points of a layout on the person of `rigs`: exact for limbs, somewhere near for all others."""
    near = {"nose": (0, 0.68, 0.1), "spine": (0, 0.25, 0), "thorax": (0, 0.48, 0), "eye": (0.03, 0.7, 0.08)}
    asf = {"femur": "knee", "tibia": "ankle", "foot": "ball", "toes": "toe", "clavicle": "shoulder", "humerus": "elbow"}
    asf |= {"wrist": "wrist", "hand": "hand", "fingers": "tip", "thumb": "thumb", "hipjoint": "hip"}
    middle = {"lowerback": 0.12, "upperback": 0.25, "thorax": 0.42, "lowerneck": 0.52, "upperneck": 0.6, "head": 0.8}
    middle |= {"spine_base": 0.05, "spine_mid": 0.25, "spine_shoulder": 0.49, "neck": 0.55, "mid_hip": 0.0, "root": 0.1}
    middle |= {"spine1": 0.12, "spine2": 0.25, "spine3": 0.36, "spine": 0.25, "pelvis": 0.02}
    found = {}
    rng = np.random.default_rng(1)
    for name in layout.names:
        side = 1.0 if name.startswith(("left", "l")) or name.endswith("left") else -1.0
        base = name.removeprefix("left_").removeprefix("right_")
        if layout.name == "cmu31" and name not in middle:
            point = np.array(POINTS["elbow"]) * 0.4 + np.array(POINTS["wrist"]) * 0.6 if name[1:] == "radius" else None
            point = np.array(POINTS[asf[name[1:]]]) if point is None else point
            found[name] = point * [side, 1, 1]
        elif name in middle:
            found[name] = np.array([0, 0.62 if name == "head" and layout.name == "smpl24" else middle[name], 0.0])
        elif base in POINTS:
            found[name] = np.array(POINTS[base]) * [side, 1, 1]
        elif base in near:
            found[name] = np.array(near[base]) * [side if "eye" in base else 1, 1, 1]
        else:
            where = POINTS["toe"] if any(part in base for part in ("foot", "toe", "heel")) else POINTS["hand"]
            where = (0.08, 0.68, 0) if any(part in base for part in ("ear", "eye", "mouth")) else where
            found[name] = (np.array(where) + rng.normal(scale=0.01, size=3)) * [side, 1, 1]
    return found


# --- what is refused: controls ---------------------------------------------------------------------------------------


def test_a_trunk_of_equal_names_is_not_a_person(files):
    """Spine, Neck and Head are in both, and all limbs have other names: this froze them, and reported success."""
    unknown = {"UpperArm": "Oberarm", "LowerArm": "Unterarm", "UpperLeg": "Oberbein", "LowerLeg": "Unterbein"}
    unknown |= {"Shoulder": "Schulter", "Hand": "Griff", "Foot": "Fuss", "Toes": "Zehen"}

    def rename(name):
        for old, new in unknown.items():
            name = name.replace(old, new)
        return name

    text, _ = file_of(RIGS["Bandai-Namco"], SEGMENTS, rename=rename)
    motion = load_bvh(io.StringIO(text), scale=0.01)
    target = files["CMU as BVH"][0].skeleton
    message = (
        r"only 4 of 33 joints of the given skeleton have counterparts in the motion's, and limbs would stay at rest: "
        r"'LeftUpLeg', 'LeftLeg', 'LeftFoot', 'LeftArm', .* have none; the motion's skeleton has names of no rig that "
        r"is known, the given one has names of CMU as BVH\. Pass joints=, a mapping of joints of the given skeleton to "
        r"the motion's, of which 'Chest', 'Schulter_L', .* are free; joints that it leaves out stay at rest"
    )
    for method in ("orientations", "positions", "auto"):
        with pytest.raises(ValueError, match=message):
            retarget(motion, target, method=method)
    with pytest.raises(ValueError, match=rf"motions\[0\]: {message}"):
        MotionDataset([motion]).retarget(target, method="auto")
    # With the names of the rig it is exact, and all limbs move.
    dataset = MotionDataset([files["Bandai-Namco"][0]]).retarget(target, method="auto")
    assert dataset.retargeting[0].startswith("orientations, 24 of 33 joints, directions within 0°")
    moving = np.ptp(dataset[0].angles, axis=0) > 1e-6
    for name in ("LeftArm", "LeftUpLeg", "RightLeg", "RightForeArm"):
        assert moving[[column.startswith(f"{name}_") for column in target.dof_names]].any()


def quadruped(tail=True):
    """A dog with the names of a person, as a public set of recordings has them."""
    rows = [("Spine", None, (0, 0, 0.2)), ("Spine1", "Spine", (0, 0, 0.3)), ("Neck", "Spine1", (0, 0.05, 0.2))]
    rows += [("Head", "Neck", (0, 0.1, 0.1))]
    for side, x in (("Left", 0.08), ("Right", -0.08)):
        rows += [(f"{side}Shoulder", "Spine1", (x, 0, 0.05)), (f"{side}Arm", f"{side}Shoulder", (0, -0.1, 0))]
        rows += [(f"{side}ForeArm", f"{side}Arm", (0, -0.18, -0.02)), (f"{side}Hand", f"{side}ForeArm", (0, -0.18, 0))]
        rows += [(f"{side}UpLeg", None, (x, 0, 0)), (f"{side}Leg", f"{side}UpLeg", (0, -0.18, 0.05))]
        rows += [(f"{side}Foot", f"{side}Leg", (0, -0.18, -0.08))]
    rows += [("Tail", None, (0, 0, -0.1)), ("Tail1", "Tail", (0, 0, -0.1))] * tail
    return Skeleton([Bone(name, parent, offset, "ZXY") for name, parent, offset in rows], "parent")


def hand(side="left"):
    bones = []
    for finger in ("thumb", "index"):
        for i in (1, 2, 3):
            parent = f"{side}_{finger}{i - 1}" if i > 1 else None
            bones.append(Bone(f"{side}_{finger}{i}", parent, (0.03, 0, 0), "rotvec"))
    return Skeleton(bones, "parent")


def still(skeleton, n=2):
    return Motion(skeleton, np.zeros((n, skeleton.n_dofs)), 30)


ROBOT = ("left_hip_pitch", "left_hip_roll", "left_knee", "left_ankle_pitch")
ROBOT += ("left_shoulder_pitch", "left_elbow", "left_wrist")


def robot():
    """Links of a humanoid robot: a knee of this name is one, but the hip is three."""
    bones = [Bone("waist_yaw_link", None, (0, 0.1, 0), "y"), Bone("torso_link", "waist_yaw_link", (0, 0.3, 0), "x")]
    for side in SIDES:
        above = None
        for i, joint in enumerate(ROBOT):
            name = joint.replace("left", side) + "_link"
            above = "torso_link" if i == 4 else above
            bones.append(Bone(name, above, (0.1 if i in (0, 4) else 0.0, -0.3 if i in (2, 3, 5, 6) else 0.0, 0), "x"))
            above = name
    return Skeleton(bones, "parent")


@pytest.mark.parametrize(
    ("other", "message"),
    [
        (quadruped(), r"may mean other joints than those of a person of LAFAN1: .* 'Tail', as animals have"),
        (robot(), r"no name of a joint in common"),
        (hand(), r"no name of a joint in common"),
    ],
    ids=["animal", "robot", "hand"],
)
def test_what_is_no_person(files, other, message):
    person = files["LAFAN1"][0]
    with pytest.raises(ValueError, match=message):
        retarget(person, other, method="auto")
    with pytest.raises(ValueError, match=message):
        retarget(still(other), person.skeleton, method="auto")
    np.testing.assert_allclose(retarget(still(other), other, method="orientations").angles, 0.0, atol=1e-12)
    assert set(find_counterparts(other, other)) == set(other.joint_names)


def test_hands_of_two_sides_are_no_counterparts():
    with pytest.raises(ValueError, match="no name of a joint in common"):
        find_counterparts(hand("left"), hand("right"))
    arm = Skeleton([Bone("L_arm", None, (0.3, 0, 0), "xyz"), Bone("L_hand", "L_arm", (0.3, 0, 0), "xyz")])
    other = Skeleton(b._replace(name=b.name.replace("L", "R"), parent=b.parent and "R_arm") for b in arm.bones)
    with pytest.raises(ValueError, match="no name of a joint in common"):
        find_counterparts(arm, other)


def test_names_of_bones_at_the_other_end():
    """Where names are those of the bones before the joints, a thigh is three times as long as its shank."""
    own = cmu_person()
    parent = Skeleton(own.bones, "parent")
    motion, _ = motion_of("Mixamo", SEGMENTS)
    with pytest.raises(ValueError, match=r"left thigh is 3\.3 times as long as its shank"):
        retarget(motion, parent, method="orientations")
    # The same with names that are those of joints in all files: the knee has the name of the ankle's joint.
    bones = {"LeftLeg": "LeftUpLeg", "LeftFoot": "LeftLeg", "LeftToeBase": "LeftFoot", "LeftToe_End": "LeftToeBase"}
    bones |= {old.replace("Left", "Right"): new.replace("Left", "Right") for old, new in bones.items()}
    bones |= {"LeftUpLeg": "LeftHip", "RightUpLeg": "RightHip", None: None}

    def renamed(name):
        name = name and name.removeprefix("mixamorig:")
        return bones.get(name, name)

    shifted = Skeleton(
        (b._replace(name=renamed(b.name), parent=renamed(b.parent)) for b in motion.skeleton.bones), "parent"
    )
    with pytest.raises(ValueError, match=r"left thigh is .* times as long as its shank"):
        retarget(still(shifted), cmu_person(), method="orientations")


def test_bones_that_are_written_as_bvh_have_their_names_at_the_other_end(tmp_path):
    """All names are equal, and "lfemur" is the knee in the ASF file and the hip in the BVH file."""
    rng = np.random.default_rng(0)
    skeleton = cmu_person()
    motion = Motion(skeleton, rng.uniform(-0.3, 0.3, (4, skeleton.n_dofs)), 30)
    save_bvh(tmp_path / "person.bvh", motion, scale=0.01)
    written = load_bvh(tmp_path / "person.bvh", scale=0.01)
    found = find_counterparts(motion.skeleton, written.skeleton)
    assert (found["lfemur"], found["ltibia"], found["lhumerus"]) == ("lhipjoint", "lfemur", "lclavicle")
    back = retarget(written, skeleton, method="orientations")
    names = {f"{side} {joint}": f"{side[0]}{ASF[joint]}" for side in SIDES for joint in LIMBS}
    a, b = (directions_of_limbs(positions_by_name(one), names) for one in (motion, back))
    assert degrees(a, b).max() < 1e-4


def test_a_mixed_vocabulary_is_no_rig(files):
    """The legs are Bandai-Namco's, and "Shoulder" is the shoulder itself: no collarbone."""
    rename = {"UpperArm": "Shoulder", "LowerArm": "Elbow", "Hand": "Wrist", "Shoulder": "Clavicula"}

    def other(name):
        return next((name.replace(old, new) for old, new in rename.items() if name.startswith(old)), name)

    text, _ = file_of(RIGS["Bandai-Namco"], SEGMENTS, rename=other)
    motion = load_bvh(io.StringIO(text), scale=0.01)
    assert not any("arm" in name or "shoulder" in name for name in find_landmarks(motion.skeleton).joints)
    with pytest.raises(ValueError, match=r"limbs would stay at rest: .*'mixamorig:LeftArm'"):
        retarget(motion, files["Mixamo"][0].skeleton, method="auto")
    with pytest.raises(ValueError, match=r"limbs would stay at rest: .*'Shoulder_L', 'Elbow_L'"):
        retarget(files["Mixamo"][0], motion.skeleton, method="auto")


def test_legs_alone(files):
    """A person's legs get the motion of a person; their motion leaves arms at rest, which has to be said."""
    motion, where = files["Mixamo"]
    legs = humanoid().to_rotvec().select(["left_toes", "right_toes"])
    balls = Skeleton(b._replace(dofs="rotvec" if b.dofs else "", limits=None) for b in legs.bones)
    found = positions_by_name(retarget(motion, balls, method="orientations"))
    thigh = found["left_thigh"] - found["left_pelvis"]
    truth = where["mixamorig:LeftLeg"] - where["mixamorig:LeftUpLeg"]
    np.testing.assert_allclose(np.cross(thigh, truth), 0.0, atol=1e-9)
    with pytest.raises(ValueError, match=r"limbs would stay at rest: 'mixamorig:LeftArm', 'mixamorig:LeftForeArm'"):
        retarget(still(balls), motion.skeleton, method="orientations")
    joints = find_counterparts(motion.skeleton, balls)
    result = retarget(still(balls), motion.skeleton, method="orientations", joints={b: a for a, b in joints.items()})
    arms = [i for i, name in enumerate(result.skeleton.dof_names) if "Arm" in name]
    np.testing.assert_array_equal(result.angles[:, arms], 0.0)


def test_roots_on_the_ground_are_refused(files):
    """As in files for games: the root is between the feet."""
    bones = [Bone("hips", None, (0, 0.9, 0), "ZXY"), *files["LAFAN1"][0].skeleton.bones]
    bones = [bones[0], *(b._replace(parent=b.parent or "hips") for b in bones[1:])]
    ground = Skeleton(bones, "parent")
    with pytest.raises(ValueError, match=r"the root of the given one is far from its hips, .*\(\.\.\., root='hips'\)"):
        retarget(files["Mixamo"][0], ground, method="orientations")
    with pytest.raises(ValueError, match=r"the root of the motion's skeleton is far from its hips"):
        retarget(still(ground), files["Mixamo"][0].skeleton, method="orientations")


def test_a_longer_arm_on_one_side(files):
    text, _ = file_of(RIGS["LAFAN1"], SEGMENTS, stretch={"LeftForeArm": 1.6, "LeftHand": 1.6})
    motion = load_bvh(io.StringIO(text), scale=0.01)
    with pytest.raises(ValueError, match=r"one arm of it is 1\.6 times as long as the other"):
        retarget(motion, files["Mixamo"][0].skeleton, method="auto")


def test_names_of_a_person_with_other_proportions(files):
    """The counterparts are found, with a warning, to check and to pass; they are refused otherwise."""
    text, where = file_of(RIGS["LAFAN1"], SEGMENTS, stretch={"LeftForeArm": 4.3, "RightForeArm": 4.3})
    odd, other = load_bvh(io.StringIO(text), scale=0.01), files["Rokoko"][0].skeleton
    message = "the names of the motion's skeleton may mean other joints .* its left upper arm is .*find_counterparts"
    with pytest.raises(ValueError, match=message):
        retarget(odd, other, method="orientations")
    with pytest.warns(UserWarning, match=r"rest on names of the motion's skeleton that may mean .* its left upper arm"):
        joints = find_counterparts(odd.skeleton, other)
    assert joints == find_counterparts(files["LAFAN1"][0].skeleton, other)
    found = positions_by_name(retarget(odd, other, method="orientations", joints=joints))
    a, b = directions_of_limbs(where, limbs_of("LAFAN1")), directions_of_limbs(found, limbs_of("Rokoko"))
    assert degrees(a, b).max() < 1e-5
    with pytest.warns(UserWarning, match="rest on names of the given skeleton"):
        find_counterparts(other, odd.skeleton)
    with pytest.raises(ValueError, match="'Tail', as animals have"):  # what is no person has no counterparts to check
        find_counterparts(quadruped(), other)


def test_the_report_is_printed(files, capsys):
    retarget(files["LAFAN1"][0], files["Xsens as BVH"][0].skeleton, method="orientations", verbose=1)
    assert capsys.readouterr().out == "orientations, 26 of 27 joints, directions within 0°\n"


# --- the tables ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.name)
def test_tables_name_each_place_once_and_their_source(table):
    """Left names have right ones, limbs are whole, and two tables agree on names that mean the same as a set."""
    assert table.source
    assert all(len(others(name)) >= 1 for name in table.left), table.left
    marks = [mark for mark in (*table.left.values(), *table.middle.values()) if mark]
    assert set(LIMBS) <= set(marks)
    doubled = {mark for mark in marks if marks.count(mark) > 1}
    assert doubled <= {"toe", "hand"}  # as files without fingers have other names for them


# --- the ends of hands, feet and head --------------------------------------------------------------------------------

ENDS_OF = [("ankle", "ball"), ("ball", "toe"), ("wrist", "hand"), ("head", "top")]
# What the reader names End Sites, and what other programs do; the last joints of each rig's file without fingers.
END_SITES = {"reader": "{}_end", "Blender": "{}_End", "together": "{}End", "3ds Max": "{}Nub"}


def without_fingers(name):
    """A rig of `rigs` whose hands end after the wrist, feet after the ball and the head after its joint."""
    rig = RIGS[name]
    arm = [row for row in rig.arm if row[1] in ("collar", "shoulder", "elbow", "wrist", "")][:4]
    leg = [row for row in rig.leg if row[1] != "toe" and row[2]]
    neck = [row for row in rig.neck if row[1] != "top" and row[2]]
    return rig, arm, neck, leg


@pytest.mark.parametrize("end", END_SITES)
@pytest.mark.parametrize("name", RIGS)
def test_ends_of_hands_feet_and_head_are_known_without_fingers(name, end):
    """Every rig, whose file names its End Sites after the last joint of each chain."""
    rig, arm, neck, leg = without_fingers(name)
    if not END_SITES[end].startswith("{}_") and rig.sides[0] in ("_L", "_l"):
        return  # the side would stand within a word

    def row_of(last, point):
        return END_SITES[end].format(last[0]), point, "" if end == "reader" else last[2]

    rig = rig._replace(
        arm=[*arm, row_of(arm[-1], "hand")], neck=[*neck, row_of(neck[-1], "top")], leg=[*leg, row_of(leg[-1], "toe")]
    )
    text, where = file_of(rig, SEGMENTS)
    motion = load_bvh(io.StringIO(text), scale=0.01, up=rig.up)
    # The directions of our own person, on balls, against positions of the file that are known without the library.
    balls = Skeleton(b._replace(dofs="rotvec" if b.dofs else "", limits=None) for b in humanoid().bones)
    found = positions_by_name(retarget(motion, balls, method="orientations"))
    lasts = {point: row[0] for row in (*rig.arm, *rig.leg, *rig.neck) for point in row[1:2]}
    ours = {"ankle": "shank", "ball": "foot", "toe": "toes", "wrist": "forearm", "hand": "hand"}
    for start, stop in ENDS_OF:
        for side in SIDES if start != "head" else [""]:
            old = [lasts[point] for point in (start, stop)]
            new = [f"{side}_{ours[point]}" for point in (start, stop)] if side else ["neck", "head"]
            if side == "right":
                old = [other_side(one, rig) for one in old]
            a, b = (x[pair[1]] - x[pair[0]] for x, pair in ((where, old), (found, new)))
            a, b = (x / np.linalg.norm(x, axis=1, keepdims=True) for x in (a, b))
            assert degrees(a, b).max() < 1e-4, (start, stop, side)


def test_a_mixamo_file_without_fingers_is_mixamo():
    """Its End Sites are as those of LAFAN1, whose other names all are Mixamo's too: LeftToe_End is no LeftToe_end."""
    rig, arm, neck, leg = without_fingers("Mixamo")
    rig = rig._replace(
        arm=[*arm, ("mixamorig:LeftHand_end", "hand", "")],
        neck=[*neck, ("mixamorig:Head_end", "top", "")],
        leg=[*leg, ("mixamorig:LeftToe_End", "toe", "toe")],
    )
    for prefix in ("mixamorig:", ""):
        text, _ = file_of(rig, SEGMENTS, rename=lambda name, prefix=prefix: name.replace("mixamorig:", prefix))
        skeleton = load_bvh(io.StringIO(text), scale=0.01).skeleton
        found = find_landmarks(skeleton)
        names = {mark: skeleton.joint_names[j].removeprefix("mixamorig:") for mark, j in found.joints.items()}
        assert (found.rig, names["left_ball"], names["left_toe"]) == ("Mixamo", "LeftToeBase", "LeftToe_End")
        assert (names["left_hand"], names["head_top"]) == ("LeftHand_end", "Head_end")
        there = find_counterparts(cmu_person(), skeleton)
        assert there[f"{prefix}LeftToeBase"] == "lfoot"


def feet(point):
    """The rig of LAFAN1 without a joint at the ball: its foot ends at a point of the person."""
    return RIGS["LAFAN1"]._replace(
        leg=[*RIGS["LAFAN1"].leg[:3], ("LeftFoot_end", point, "")], whole=RIGS["Mixamo"].whole
    )


def test_a_foot_without_a_ball_ends_at_the_toe_where_it_points_forward(files):
    """The sole, from the ankle to the toe, keeps its direction; an end at the floor shows none."""
    text, where = file_of(feet("toe"), SEGMENTS)
    short = load_bvh(io.StringIO(text), scale=0.01)
    balls = Skeleton(b._replace(dofs="rotvec" if b.dofs else "", limits=None) for b in humanoid().bones)
    for target, ankle, toe in (
        (files["Mixamo"][0].skeleton, "mixamorig:{}Foot", "mixamorig:{}Toe_End"),
        (files["Unreal"][0].skeleton, "foot_{}", "ball_{}_end"),
        (balls, "{}_shank", "{}_toes"),
    ):
        found = positions_by_name(retarget(short, target, method="orientations"))
        for side in SIDES:
            word = {"m": side.capitalize(), "f": side[0], "{": side}[ankle[0]]
            a = where[f"{side.capitalize()}Foot_end"] - where[f"{side.capitalize()}Foot"]
            b = found[toe.format(word)] - found[ankle.format(word)]
            a, b = (x / np.linalg.norm(x, axis=1, keepdims=True) for x in (a, b))
            assert degrees(a, b).max() < 1e-4
    text, _ = file_of(feet("floor"), SEGMENTS)
    down = find_landmarks(load_bvh(io.StringIO(text), scale=0.01).skeleton)
    assert not any("toe" in mark or "ball" in mark for mark in down.joints)


def test_what_stays_at_rest_is_said(files, capsys):
    """Feet that end at the floor say nothing about the direction of a foot: it stays, with a warning and by name."""
    text, _ = file_of(feet("floor"), SEGMENTS)
    down = load_bvh(io.StringIO(text), scale=0.01).skeleton
    motion = make_gait(1, 1, random_state=0).motions[0][:5]
    message = r"'LeftFoot', 'RightFoot' stay at rest.*pass joints=, .* such as 'left_foot', 'right_foot'"
    with pytest.warns(UserWarning, match=message):
        result = retarget(motion, down, method="orientations", verbose=1)
    assert capsys.readouterr().out.endswith("°; at rest: LeftFoot, RightFoot\n")
    columns = [i for i, name in enumerate(down.dof_names) if "Foot" in name]
    np.testing.assert_array_equal(result.angles[:, columns], 0.0)
    with pytest.warns(UserWarning, match=message):
        report = MotionDataset([motion]).retarget(down, method="orientations").retargeting[0]
    assert report.endswith("; at rest: LeftFoot, RightFoot")
    # Given counterparts are the user's own: no warning. The report says what stays at rest.
    joints = find_counterparts(motion.skeleton, down)
    retarget(motion, down, method="orientations", joints=joints, verbose=1)
    assert capsys.readouterr().out.endswith("at rest: LeftFoot, RightFoot\n")
    # A thumb that has no counterpart is no hand: no warning. What moves is not named.
    retarget(files["Mixamo"][0], files["CMU as BVH"][0].skeleton, method="orientations", verbose=1)
    assert "Hand" not in capsys.readouterr().out.partition("at rest")[2]
