"""One person and one motion in files of many rigs: names, rest poses, axes and joints of the trunk as they have them.

The person is points of a T-pose, and the motion the rotation of each segment in the world, so that it is known where
every joint of every file is, without the library.
"""

import io
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from skpose import Bone, Skeleton
from skpose.io import load_bvh
from skpose.skeleton._sides import others

# A T-pose: m, x to the left, y up, z forward, the origin in the middle between the hips. Of the left and the middle.
POINTS = {
    "hip": (0.09, 0.0, 0.0),
    "knee": (0.09, -0.42, 0.01),
    "ankle": (0.09, -0.83, -0.01),
    "ball": (0.09, -0.9, 0.12),
    "toe": (0.09, -0.91, 0.19),
    "floor": (0.09, -0.93, -0.01),
    "collar": (0.03, 0.48, 0.01),
    "shoulder": (0.18, 0.49, -0.01),
    "elbow": (0.46, 0.49, -0.02),
    "wrist": (0.72, 0.49, -0.01),
    "hand": (0.81, 0.485, 0.0),
    "tip": (0.86, 0.48, 0.0),
    "thumb": (0.75, 0.48, 0.04),
    "neck": (0.0, 0.52, -0.01),
    "neck1": (0.0, 0.57, 0.0),
    "head": (0.0, 0.62, 0.01),
    "top": (0.0, 0.8, 0.02),
}
LIMBS = ("hip", "knee", "ankle", "shoulder", "elbow", "wrist")
IDENTITY = Rotation.identity()
SPINE_ALONG_X = Rotation.from_matrix([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])  # y becomes x, z becomes y
Z_UP = Rotation.from_euler("x", 90, degrees=True)


class Rig(NamedTuple):
    """Names of a file: those of trunk and neck, and of the left arm and leg, each with its point and its segment.

    The point "" is that of the chest, "root" that of the root. A point of the trunk is its height, m, and its segment
    the share of the chest in the rotation; the last one of the trunk carries the neck and the arms. Names without a
    segment are End Sites.
    """

    root: tuple[str, float]
    trunk: list[tuple[str, float, float]]
    neck: list[tuple[str, str, str]]
    arm: list[tuple[str, str, str]]
    leg: list[tuple[str, str, str]]
    sides: tuple[str, str] = ("Left", "Right")
    whole: Rotation = IDENTITY  # of the rest pose
    arms_down: float = 0.0  # degrees, in the rest pose
    up: str = "y"
    twisted: bool = False  # in the rest pose the pelvis is rotated by 90° about the spine, and the left leg points up


ARM = [
    ("LeftShoulder", "collar", "clavicle"),
    ("LeftArm", "shoulder", "upper_arm"),
    ("LeftForeArm", "elbow", "forearm"),
]
LEG = [("LeftUpLeg", "hip", "thigh"), ("LeftLeg", "knee", "shank"), ("LeftFoot", "ankle", "foot")]
NECK = [("Neck", "neck", "neck"), ("Head", "head", "head"), ("Head_end", "top", "")]
RIGS = {
    "CMU as BVH": Rig(
        ("Hips", 0.1),
        [("LowerBack", 0.1, 0.2), ("Spine", 0.22, 0.6), ("Spine1", 0.44, 1.0)],
        [("Neck", "", "neck"), ("Neck1", "neck1", "neck"), ("Head", "head", "head"), ("Head_end", "top", "")],
        [
            ("LeftShoulder", "", "clavicle"),
            *ARM[1:],
            ("LeftHand", "wrist", "hand"),
            ("LeftFingerBase", "wrist", "hand"),
            ("LeftHandIndex1", "hand", "hand"),
            ("LeftHandIndex1_end", "tip", ""),
        ],
        [("LHipJoint", "root", "pelvis"), *LEG, ("LeftToeBase", "ball", "toe"), ("LeftToeBase_end", "toe", "")],
    ),
    "Bandai-Namco": Rig(
        ("Hips", 0.03),
        [("Spine", 0.18, 0.5), ("Chest", 0.3, 1.0)],
        [*NECK[:2], ("Head_end", "head", "")],
        [
            ("Shoulder_L", "collar", "clavicle"),
            ("UpperArm_L", "shoulder", "upper_arm"),
            ("LowerArm_L", "elbow", "forearm"),
            ("Hand_L", "wrist", "hand"),
            ("Hand_L_end", "wrist", ""),
        ],
        [
            ("UpperLeg_L", "hip", "thigh"),
            ("LowerLeg_L", "knee", "shank"),
            ("Foot_L", "ankle", "foot"),
            ("Toes_L", "ball", "toe"),
            ("Toes_L_end", "ball", ""),
        ],
        ("_L", "_R"),
        SPINE_ALONG_X,
        -80.0,
        twisted=True,
    ),
    "LAFAN1": Rig(
        ("Hips", 0.05),
        [("Spine", 0.12, 0.3), ("Spine1", 0.22, 0.7), ("Spine2", 0.32, 1.0)],
        NECK,
        [*ARM, ("LeftHand", "wrist", "hand"), ("LeftHand_end", "hand", "")],
        [*LEG, ("LeftToe", "ball", "toe"), ("LeftToe_end", "toe", "")],
        whole=SPINE_ALONG_X,
    ),
    "Mixamo": Rig(
        ("mixamorig:Hips", 0.06),
        [("mixamorig:Spine", 0.16, 0.3), ("mixamorig:Spine1", 0.27, 0.7), ("mixamorig:Spine2", 0.38, 1.0)],
        [(f"mixamorig:{name}", *rest) for name, *rest in NECK[:2]] + [("mixamorig:HeadTop_End", "top", "head")],
        [(f"mixamorig:{name}", *rest) for name, *rest in ARM]
        + [("mixamorig:LeftHand", "wrist", "hand"), ("mixamorig:LeftHandMiddle1", "hand", "hand")]
        + [("mixamorig:LeftHandMiddle1_end", "tip", "")],
        [(f"mixamorig:{name}", *rest) for name, *rest in LEG]
        + [("mixamorig:LeftToeBase", "ball", "toe"), ("mixamorig:LeftToe_End", "toe", "toe")],
    ),
    "Rokoko": Rig(
        ("Hips", 0.02),
        [("Spine1", 0.1, 0.25), ("Spine2", 0.2, 0.5), ("Spine3", 0.3, 0.75), ("Spine4", 0.4, 1.0)],
        NECK,
        [*ARM, ("LeftHand", "wrist", "hand"), ("LeftHand_end", "hand", "")],
        [
            ("LeftThigh", "hip", "thigh"),
            ("LeftShin", "knee", "shank"),
            LEG[2],
            ("LeftToe", "ball", "toe"),
            ("LeftToeTip", "toe", "toe"),
        ],
    ),
    "Xsens as BVH": Rig(
        ("Hips", 0.0),
        [("Chest", 0.11, 0.25), ("Chest2", 0.2, 0.5), ("Chest3", 0.29, 0.75), ("Chest4", 0.38, 1.0)],
        NECK,
        [
            ("LeftCollar", "collar", "clavicle"),
            ("LeftShoulder", "shoulder", "upper_arm"),
            ("LeftElbow", "elbow", "forearm"),
            ("LeftWrist", "wrist", "hand"),
            ("LeftWrist_end", "hand", ""),
        ],
        [
            ("LeftHip", "hip", "thigh"),
            ("LeftKnee", "knee", "shank"),
            ("LeftAnkle", "ankle", "foot"),
            ("LeftToe", "ball", "toe"),
            ("LeftToe_end", "toe", ""),
        ],
    ),
    "Unreal": Rig(
        ("pelvis", 0.04),
        [("spine_01", 0.1, 0.3), ("spine_02", 0.22, 0.7), ("spine_03", 0.35, 1.0)],
        [("neck_01", "neck", "neck"), ("head", "head", "head"), ("head_end", "top", "")],
        [
            ("clavicle_l", "collar", "clavicle"),
            ("upperarm_l", "shoulder", "upper_arm"),
            ("lowerarm_l", "elbow", "forearm"),
            ("hand_l", "wrist", "hand"),
            ("middle_01_l", "hand", "hand"),
            ("middle_01_l_end", "tip", ""),
        ],
        [
            ("thigh_l", "hip", "thigh"),
            ("calf_l", "knee", "shank"),
            ("foot_l", "ankle", "foot"),
            ("ball_l", "ball", "toe"),
            ("ball_l_end", "toe", ""),
        ],
        ("_l", "_r"),
        Z_UP,
        45.0,
        "z",
    ),
    "Biped": Rig(
        ("Bip01 Pelvis", 0.05),
        [("Bip01 Spine", 0.15, 0.5), ("Bip01 Spine1", 0.33, 1.0)],
        [(f"Bip01 {name}", *rest) for name, *rest in NECK],
        [
            ("Bip01 L Clavicle", "collar", "clavicle"),
            ("Bip01 L UpperArm", "shoulder", "upper_arm"),
            ("Bip01 L Forearm", "elbow", "forearm"),
            ("Bip01 L Hand", "wrist", "hand"),
            ("Bip01 L Finger2", "hand", "hand"),
            ("Bip01 L Finger2_end", "tip", ""),
        ],
        [
            ("Bip01 L Thigh", "hip", "thigh"),
            ("Bip01 L Calf", "knee", "shank"),
            ("Bip01 L Foot", "ankle", "foot"),
            ("Bip01 L Toe0", "ball", "toe"),
            ("Bip01 L Toe0_end", "toe", ""),
        ],
        (" L ", " R "),
        arms_down=50.0,
    ),
}


class Joint(NamedTuple):
    """A joint of a file."""

    name: str
    parent: str | None
    point: np.ndarray  # in the T-pose
    segment: str  # that rotates with it; empty for an End Site


def joints_of(rig, leave_out=()):
    """The joints of a rig of `RIGS`, parents first; chains end before joints that are left out."""
    name, height = rig.root
    root = np.array([0.0, height, 0.0])
    joints = [Joint(name, None, root, "pelvis")]
    for name, height, share in rig.trunk:
        joints.append(Joint(name, joints[-1].name, np.array([0.0, height, 0.0]), f"chest {share}"))
    chest = joints[-1]
    chains = [(chest, rig.neck, "")]
    for side in ("left", "right"):
        for start, chain in ((chest, rig.arm), (joints[0], rig.leg)):
            names = [name if side == "left" else other_side(name, rig) for name, *_ in chain]
            chains.append((start, [(n, *rest) for n, (_, *rest) in zip(names, chain, strict=True)], side))
    for before, chain, side in chains:
        for name, point, segment in chain:
            if name in leave_out:
                break
            at = np.array({"": chest.point, "root": root}.get(point, POINTS.get(point)), dtype=float)
            at *= [-1.0 if side == "right" else 1.0, 1.0, 1.0]
            segment = f"{segment} {side}" if side and segment not in ("", "pelvis") else segment
            before = Joint(name, before.name, at, segment)
            joints.append(before)
    return joints


def other_side(name, rig):
    """The name of the right side."""
    left, right = rig.sides
    return name.replace(left, right) if left in name else name.replace("LHip", "RHip")


def file_of(rig, segments, *, rename=None, leave_out=(), stretch=None):
    """The text of a BVH file, in cm, and where its joints are: names to positions (n_frames, 3), m.

    `rename` is a function of names, `stretch` factors of the bones before some joints.
    """
    joints = {joint.name: joint for joint in joints_of(rig, leave_out)}
    world = Z_UP if rig.up == "z" else IDENTITY
    rest, turned, where, rows, offsets = {}, {}, {}, {}, {}
    for name, joint in joints.items():
        arm = joint.segment.startswith(("upper_arm", "forearm", "hand"))
        down = -rig.arms_down if "left" in joint.segment else rig.arms_down
        rest[name] = rig.whole * Rotation.from_euler("z", down * arm, degrees=True)
        if rig.twisted and joint.segment.startswith(("pelvis", "thigh", "shank", "foot", "toe")):
            up = 180.0 if "left" in joint.segment else 0.0
            rest[name] = rig.whole * Rotation.from_euler("yz", [90.0, up], degrees=True)
        if joint.segment:
            turned[name] = world * rotation_of(joint.segment, segments)
        if joint.parent is None:
            where[name] = world.apply(segments["root"] + segments["pelvis"].apply(joint.point))
            offsets[name] = np.zeros(3)
            rows[name] = np.concatenate([100.0 * where[name], angles(turned[name] * rest[name].inv())], axis=1)
            continue
        bone = (joint.point - joints[joint.parent].point) * (stretch or {}).get(name, 1.0)
        offsets[name] = 100.0 * rest[joint.parent].apply(bone)
        where[name] = where[joint.parent] + turned[joint.parent].apply(bone)
        if joint.segment:
            above = turned[joint.parent] * rest[joint.parent].inv()
            rows[name] = angles(above.inv() * turned[name] * rest[name].inv())
    lines = ["HIERARCHY", *hierarchy(joints, offsets, rename or str), "MOTION", f"Frames: {len(segments['root'])}"]
    order = [line for line in lines if line.strip().startswith(("ROOT", "JOINT"))]
    new = {(rename or str)(name): name for name in joints}
    table = np.concatenate([rows[new[line.strip().partition(" ")[2]]] for line in order], axis=1)
    lines += ["Frame Time: 0.0333333", *(" ".join(f"{x:.9f}" for x in row) for row in table)]
    return "\n".join(lines) + "\n", where


def motion_of(name, segments, **options):
    """The motion of a file of one of `RIGS`, read by the library, and where its joints are."""
    text, where = file_of(RIGS[name], segments, **options)
    return load_bvh(io.StringIO(text), scale=0.01, up=RIGS[name].up), where


def limbs_of(name):
    """The names of the joints of the limbs of a rig of `RIGS`, by side and joint: "left knee" and so on."""
    found = {}
    for joint_name, point, _ in (*RIGS[name].arm, *RIGS[name].leg):
        if point in LIMBS and f"left {point}" not in found:
            found[f"left {point}"] = joint_name
            found[f"right {point}"] = other_side(joint_name, RIGS[name])
    return found


def rotation_of(segment, segments):
    """The rotations of a segment in the world; those of the trunk between pelvis and chest."""
    name, _, share = segment.partition(" ")
    if name != "chest":
        return segments[segment]
    pairs = zip(segments["pelvis"], segments["chest"], strict=True)
    return Rotation.concatenate([Slerp([0, 1], Rotation.concatenate(pair))(float(share or 1)) for pair in pairs])


def angles(rotations):
    """Angles (n_frames, 3), degrees, of the channels ZXY."""
    return rotations.as_euler("ZXY", degrees=True)


def hierarchy(joints, offsets, rename):
    """Lines of the hierarchy, depth first."""
    depth = {}

    def lines(name):
        joint = joints[name]
        depth[name] = 0 if joint.parent is None else depth[joint.parent] + 1
        indent = "\t" * depth[name]
        yield indent + (
            f"ROOT {rename(name)}" if joint.parent is None else f"JOINT {rename(name)}" * bool(joint.segment)
        )
        if not joint.segment:
            yield f"{indent}End Site"
        yield f"{indent}{{"
        yield f"{indent}\tOFFSET {' '.join(f'{x:.9f}' for x in offsets[name])}"
        place = "6 Xposition Yposition Zposition" if joint.parent is None else "3"
        if joint.segment:
            yield f"{indent}\tCHANNELS {place} Zrotation Xrotation Yrotation"
        children = [other.name for other in joints.values() if other.parent == name]
        for child in children:
            yield from lines(child)
        if joint.segment and not children:
            yield f"{indent}\tEnd Site\n{indent}\t{{\n{indent}\t\tOFFSET 0 0 0\n{indent}\t}}"
        yield f"{indent}}}"

    return [line for line in lines(next(iter(joints))) if line.strip()]


def random_segments(n_frames=8, seed=0, size=1.0):
    """Rotations (n_frames,) of the segments of a person in the world, and positions of the middle of the hips, m.

    They change smoothly; thighs and arms by some 50° with the size 1, elbows and knees bend forward.
    """
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.0, n_frames)[:, None]

    def smooth(*degrees):
        return size * np.array(degrees) * np.sin(2 * np.pi * (t * rng.uniform(0.5, 1.0, 3) + rng.uniform(0, 1, 3)))

    def about(*degrees):
        return Rotation.from_euler("YXZ", smooth(*degrees), degrees=True)

    segments = {"root": np.array([0.0, 0.9, 0.0]) + smooth(0.3, 0.02, 0.3), "pelvis": about(60, 12, 8)}
    segments["chest"] = segments["pelvis"] * about(20, 15, 8)
    segments["neck"] = segments["chest"] * about(15, 15, 8)
    segments["head"] = segments["neck"] * about(25, 15, 8)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        elbow, knee = np.abs(smooth(70, 70, 0)).T[:2, :, None]
        down = Rotation.from_euler("z", -60.0 * sign, degrees=True)
        segments[f"clavicle {side}"] = segments["chest"] * about(5, 0, 5)
        segments[f"upper_arm {side}"] = segments[f"clavicle {side}"] * about(40, 25, 30) * down
        segments[f"forearm {side}"] = segments[f"upper_arm {side}"] * Rotation.from_euler(
            "y", -sign * elbow, degrees=True
        )
        segments[f"hand {side}"] = segments[f"forearm {side}"] * about(15, 10, 15)
        segments[f"thigh {side}"] = segments["pelvis"] * about(10, 40, 12)
        segments[f"shank {side}"] = segments[f"thigh {side}"] * Rotation.from_euler("x", knee, degrees=True)
        segments[f"foot {side}"] = segments[f"shank {side}"] * about(8, 15, 8)
        segments[f"toe {side}"] = segments[f"foot {side}"] * about(0, 10, 0)
    return segments


# Names of the left leg and arm, of the trunk, and of neck and head, as they are in public files. Points are in order:
# hip, knee, ankle, ball; collar, shoulder, elbow, wrist. A rig may begin and end later or sooner, or have more.
LEG_POINTS, ARM_POINTS = ("hip", "knee", "ankle", "ball"), ("collar", "shoulder", "elbow", "wrist")
NAMES = {
    "LAFAN1": ("LeftUpLeg LeftLeg LeftFoot LeftToe", "LeftShoulder LeftArm LeftForeArm LeftHand"),
    "SOMA": ("LeftLeg LeftShin LeftFoot LeftToeBase", "LeftShoulder LeftArm LeftForeArm LeftHand"),
    "SMPL": ("left_hip left_knee left_ankle left_foot", "left_collar left_shoulder left_elbow left_wrist"),
    "Xsens": ("LeftHip LeftKnee LeftAnkle LeftToe", "LeftCollar LeftShoulder LeftElbow LeftWrist"),
    "Rigify": ("thigh.L shin.L foot.L toe.L", "shoulder.L upper_arm.L forearm.L hand.L"),
    "Auto-Rig": ("thigh_stretch.l leg_stretch.l foot.l toes.l", "shoulder.l arm_stretch.l forearm_stretch.l hand.l"),
    "DAZ": ("lThighBend lShin lFoot lToe", "lCollar lShldrBend lForearmBend lHand"),
    "Second Life": ("lThigh lShin lFoot", "lCollar lShldr lForeArm lHand"),
    "OptiTrack": ("LThigh LShin LFoot LToe", "LShoulder LUArm LFArm LHand"),
    "Character Creator": (
        "CC_Base_L_Thigh CC_Base_L_Calf CC_Base_L_Foot CC_Base_L_ToeBase",
        "CC_Base_L_Clavicle CC_Base_L_Upperarm CC_Base_L_Forearm CC_Base_L_Hand",
    ),
    "GENEA": ("b_l_upleg b_l_leg b_l_foot", "b_l_shoulder b_l_arm b_l_forearm b_l_wrist"),
    "FLEX": ("lefthip leftknee leftfoot", "leftcollar leftshoulder leftelbow lefthand"),
    "VRChat": ("Left leg|Left knee|Left ankle|Left toe", "Left shoulder|Left arm|Left elbow|Left wrist"),
    "MMD": ("左足 左ひざ 左足首 左つま先", "左肩 左腕 左ひじ 左手首"),
    "ends": ("LeftHip LeftUpLeg LeftLeg LeftFoot", "LeftCollar LeftShoulder LeftArm LeftForeArm"),
    "letters": ("aL bL cL dL", "eL fL gL hL"),
}
MIDDLES = dict.fromkeys(NAMES, "Spine Chest Neck Head") | {"MMD": "上半身 上半身2 首 頭", "letters": "s1 s2 s3 s4"}


def person_of(name, *, twists=False, collapsed=False):
    """A skeleton of a rig in T-pose, and the names of the joints of its limbs by side and landmark."""
    trunk = MIDDLES[name].split()
    rows = [(trunk[0], None, (0, 0.15, 0)), (trunk[1], trunk[0], (0, 0.35, 0))]
    rows += [(trunk[2], trunk[1], POINTS["neck"]), (trunk[3], trunk[2], POINTS["head"])]
    truth = {}
    for start, marks, names in ((None, LEG_POINTS, NAMES[name][0]), (trunk[1], ARM_POINTS, NAMES[name][1])):
        names = names.split("|") if "|" in names else names.split()
        for side, sign in (("left", 1), ("right", -1)):
            parent = start
            for joint, mark in zip(names, marks, strict=False):
                joint = joint if side == "left" else others(joint)[0]
                at = np.array(POINTS[mark]) * [sign, 1, 1]
                if twists and mark in ("knee", "elbow", "wrist"):  # halfway along the bone before
                    middle = (at + next(point for one, _, point in rows if one == parent)) / 2
                    rows.append((f"Twist_{parent}", parent, middle))
                    parent = f"Twist_{parent}"
                rows.append((joint, parent, at))
                truth[f"{side} {mark}"] = parent = joint
    at = {None: np.zeros(3)} | {joint: np.array(point, float) for joint, _, point in rows}
    offsets = {joint: at[joint] - at[parent] for joint, parent, _ in rows}
    if collapsed:  # all bones along x
        offsets = {joint: (np.linalg.norm(offset), 0, 0) for joint, offset in offsets.items()}
    bones = [Bone(joint, parent, offsets[joint], "ZXY") for joint, parent, _ in rows]
    return Skeleton(bones, "parent"), {key: joint for key, joint in truth.items() if key.split()[1] in LIMBS}
