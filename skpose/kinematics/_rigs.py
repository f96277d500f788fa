"""The rigs whose names of joints are known, one table each, with the source of the names.

A table has the names of the left side and of the middle. It states for each name the landmark, the place of the joint
on a person: of the joint, not of its bone, as the same word is the shoulder in one rig and the end of the collarbone in
another. Joints between landmarks, and others, are `OTHER`: they help to identify the rig, and joints of trunk and neck
become counterparts by their place along it.

Names of the ends of chains, such as "Head_end", differ between programs and are not in the tables; they are landmarks
by the joint before them, see `ENDS`.
"""

from collections.abc import Mapping
from typing import Literal, NamedTuple

# Joints of the limbs, at the same place in every rig.
HIP, KNEE, ANKLE, SHOULDER, ELBOW, WRIST = "hip", "knee", "ankle", "shoulder", "elbow", "wrist"
LIMBS = ((HIP, KNEE, ANKLE), (SHOULDER, ELBOW, WRIST))
COLLAR = "collar"  # where the collarbone begins
BALL, TOE = "ball", "toe"  # of the foot, where the toes begin, and their end
HAND = "hand"  # a point of the hand that shows its direction from the wrist
HEAD = "head"  # the joint between neck and head
HEAD_TOP, HEAD_CENTER = "head_top", "head_center"
OTHER = ""
ENDS = {WRIST: HAND, HEAD: HEAD_TOP, BALL: TOE}  # of a chain whose last joint is there
# Suffixes of the names of ends: End Sites as the reader names them, Blender's leaf bones, 3ds Max's.
END_NAMES = ("end", "nub")

Frame = Literal["own", "parent"]


class Rig(NamedTuple):
    """The names of a rig."""

    name: str
    source: str
    left: Mapping[str, str]
    middle: Mapping[str, str]
    frame: Frame | None = None  # if names are names of bones: the frame in which the joint is at the bone's far end


_ASF_LEGS = {"lfemur": KNEE, "ltibia": ANKLE, "lfoot": BALL, "ltoes": TOE}
# The wrist bends between lwrist, which has the twist of the forearm, and lhand: lradius ends within the forearm.
_ASF_ARMS = {"lclavicle": SHOULDER, "lhumerus": ELBOW, "lradius": OTHER, "lwrist": WRIST, "lhand": HAND}
_ASF_MIDDLE = ("lowerback", "upperback", "thorax", "lowerneck")
_ARM = {"LeftShoulder": COLLAR, "LeftArm": SHOULDER, "LeftForeArm": ELBOW, "LeftHand": WRIST}
_LEG = {"LeftUpLeg": HIP, "LeftLeg": KNEE, "LeftFoot": ANKLE}
_POINTS = {"left_hip": HIP, "left_knee": KNEE, "left_ankle": ANKLE}
_POINTS |= {"left_shoulder": SHOULDER, "left_elbow": ELBOW, "left_wrist": WRIST}
_FACE = {"left_eye": OTHER, "left_ear": OTHER}
LAYOUT = "skpose.keypoints.layouts[{!r}], with its source"

RIGS = (
    Rig(
        "CMU or HDM05",
        "the 30 bones of the CMU Graphics Lab Motion Capture Database, http://mocap.cs.cmu.edu/subjects/35/35.asf, and "
        'of M. Müller et al., "Documentation Mocap Database HDM05", 2007, and its file HDM_bd.asf',
        {"lhipjoint": HIP} | _ASF_LEGS | _ASF_ARMS | {"lfingers": OTHER, "lthumb": OTHER},
        dict.fromkeys(_ASF_MIDDLE, OTHER) | {"upperneck": HEAD, "head": HEAD_TOP},
        "own",
    ),
    # A bone of an ASF file begins where the one before ends, and a BVH joint with its name is at its beginning.
    Rig(
        "CMU's bones as BVH",
        "skpose.io.save_bvh: each joint has the name of the bone that begins at it",
        {"lhipjoint": OTHER, "lfemur": HIP, "ltibia": KNEE, "lfoot": ANKLE, "ltoes": BALL}
        | {"lclavicle": COLLAR, "lhumerus": SHOULDER, "lradius": ELBOW, "lwrist": OTHER, "lhand": WRIST}
        | {"lfingers": HAND, "lthumb": OTHER},
        dict.fromkeys((*_ASF_MIDDLE, "upperneck"), OTHER) | {"head": HEAD},
        "parent",
    ),
    Rig(
        "CMU as BVH",
        "B. Hahne's conversion for MotionBuilder, http://cgspeed.com: LHipJoint, LowerBack, Neck1, LeftFingerBase, "
        "LThumb",
        _ARM
        | _LEG
        | {"LHipJoint": OTHER, "LeftToeBase": BALL, "LeftFingerBase": OTHER}
        # LeftFingerBase is at LeftHand, and the bone to LeftHandIndex1 is the hand.
        | {"LeftHandIndex1": HAND, "LThumb": OTHER},
        dict.fromkeys(("LowerBack", "Spine", "Spine1", "Neck", "Neck1"), OTHER) | {"Head": HEAD},
    ),
    Rig(
        "Bandai-Namco",
        "Bandai-Namco-Research-Motiondataset, https://github.com/BandaiNamcoResearchInc/Bandai-Namco-Research-Motiondataset"
        "; with other spelling Unity's HumanBodyBones, https://docs.unity3d.com/400/Documentation/ScriptReference/HumanBodyBones.html",
        {"Shoulder_L": COLLAR, "UpperArm_L": SHOULDER, "LowerArm_L": ELBOW, "Hand_L": WRIST}
        | {"UpperLeg_L": HIP, "LowerLeg_L": KNEE, "Foot_L": ANKLE, "Toes_L": BALL},
        dict.fromkeys(("Hips", "Spine", "Chest", "UpperChest", "Neck"), OTHER) | {"Head": HEAD},
    ),
    Rig(
        "LAFAN1",
        "Ubisoft La Forge Animation Dataset, https://github.com/ubisoft/ubisoft-laforge-animation-dataset",
        _ARM | _LEG | {"LeftToe": BALL},
        dict.fromkeys(("Hips", "Spine", "Spine1", "Spine2", "Neck"), OTHER) | {"Head": HEAD},
    ),
    Rig(
        "Mixamo",
        "the list of a rig compatible with Mixamo's, https://docs.readyplayer.me/asset-creation-guide/asset-creation/templates"
        "; the prefix: https://gist.github.com/frnsys/e1eaea896bd01e6388b54e1ebf9782c7",
        _ARM
        | _LEG
        | {"LeftToeBase": BALL, "LeftToe_End": TOE, "LeftHandMiddle1": HAND, "LeftEye": OTHER}
        | {f"LeftHand{finger}{i}": OTHER for finger in ("Thumb", "Index", "Ring", "Pinky") for i in (1, 2, 3, 4)}
        | {f"LeftHandMiddle{i}": OTHER for i in (2, 3, 4)},
        dict.fromkeys(("Hips", "Spine", "Spine1", "Spine2", "Neck"), OTHER) | {"Head": HEAD, "HeadTop_End": HEAD_TOP},
    ),
    Rig(
        "SMPL",
        "https://github.com/vchoutas/smplx/blob/main/smplx/joint_names.py",
        {"left_hip": HIP, "left_knee": KNEE, "left_ankle": ANKLE, "left_foot": BALL, "left_collar": COLLAR}
        | {"left_shoulder": SHOULDER, "left_elbow": ELBOW, "left_wrist": WRIST, "left_hand": HAND, "left_middle1": HAND}
        | {f"left_{finger}{i}": OTHER for finger in ("index", "pinky", "ring", "thumb") for i in (1, 2, 3)}
        | {"left_middle2": OTHER, "left_middle3": OTHER, "left_eye": OTHER},
        dict.fromkeys(("pelvis", "spine1", "spine2", "spine3", "neck", "jaw"), OTHER) | {"head": HEAD},
    ),
    Rig(
        "Rokoko",
        "Rokoko Studio's export in the format Newton, "
        "https://github.com/DADIU-2019-Team-4/MoMa/blob/master/Assets/Scripts/PMAnimation/BoneType.cs",
        _ARM | {"LeftThigh": HIP, "LeftShin": KNEE, "LeftFoot": ANKLE, "LeftToe": BALL, "LeftToeTip": TOE},
        dict.fromkeys(("Hips", "Spine1", "Spine2", "Spine3", "Spine4", "Neck"), OTHER) | {"Head": HEAD},
    ),
    Rig(
        "Rokoko Studio Live",
        "https://github.com/Rokoko/rokoko-studio-live-blender/blob/master/core/animation_lists.py",
        {"leftShoulder": COLLAR, "leftUpperArm": SHOULDER, "leftLowerArm": ELBOW, "leftHand": WRIST}
        | {"leftUpLeg": HIP, "leftLeg": KNEE, "leftFoot": ANKLE, "leftToe": BALL},
        dict.fromkeys(("hip", "spine", "chest", "neck"), OTHER) | {"head": HEAD},
    ),
    Rig(
        "Xsens as BVH",
        "Xsens MVN's export as BVH, "
        "https://github.com/YanjieZe/GMR/blob/master/general_motion_retargeting/ik_configs/xsens_bvh_to_g1.json; the "
        "names that character studio reads, http://www.character-studio.net/bvh_file_specification.htm",
        {"LeftCollar": COLLAR, "LeftShoulder": SHOULDER, "LeftElbow": ELBOW, "LeftWrist": WRIST}
        | {"LeftHip": HIP, "LeftKnee": KNEE, "LeftAnkle": ANKLE, "LeftToe": BALL},
        dict.fromkeys(("Hips", "Chest", "Chest2", "Chest3", "Chest4", "Neck"), OTHER) | {"Head": HEAD},
    ),
    Rig(
        "AnimatedDrawings",
        "CMU's bones with names of character studio, https://github.com/facebookresearch/AnimatedDrawings, "
        "examples/bvh",
        {"LeftCollar": COLLAR, "LeftShoulder": SHOULDER, "LeftElbow": ELBOW, "LeftWrist": WRIST, "LFingers": HAND}
        | {"LeftHip": HIP, "LeftKnee": KNEE, "LeftAnkle": ANKLE, "LeftToe": BALL}
        | {"LHipJoint": OTHER, "lhand": OTHER, "LThumb": OTHER},
        dict.fromkeys(("Hips", "lowerback", "Chest", "Chest2", "lowerneck", "Neck"), OTHER) | {"Head": HEAD},
    ),
    Rig(
        "character studio",
        "the other names of its BVH files, http://www.character-studio.net/bvh_file_specification.htm",
        {"LeftCollar": COLLAR, "LeftUpArm": SHOULDER, "LeftLowArm": ELBOW, "LeftHand": WRIST}
        | {"LeftUpLeg": HIP, "LeftLowLeg": KNEE, "LeftFoot": ANKLE},
        dict.fromkeys(("Hips", "Chest", "Neck"), OTHER) | {"Head": HEAD},
    ),
    Rig(
        "Xsens MVN",
        "the segments of the MVN User Manual, MV0319P, whose origins are the joints before them",
        {"LeftShoulder": COLLAR, "LeftUpperArm": SHOULDER, "LeftForeArm": ELBOW, "LeftHand": WRIST}
        | {"LeftUpperLeg": HIP, "LeftLowerLeg": KNEE, "LeftFoot": ANKLE, "LeftToe": BALL},
        dict.fromkeys(("Pelvis", "L5", "L3", "T12", "T8", "Neck"), OTHER) | {"Head": HEAD},
    ),
    Rig(
        "Unreal",
        "the mannequins of Unreal Engine 4 and 5, "
        "https://github.com/Nick-Pearson/ParkourGame/blob/master/ParkourGame/Source/ParkourGame/Private/Utils/ParkourFNames.cpp",
        {"clavicle_l": COLLAR, "upperarm_l": SHOULDER, "lowerarm_l": ELBOW, "hand_l": WRIST, "middle_01_l": HAND}
        | {"thigh_l": HIP, "calf_l": KNEE, "foot_l": ANKLE, "ball_l": BALL}
        | {f"{finger}_0{i}_l": OTHER for finger in ("thumb", "index", "ring", "pinky") for i in (1, 2, 3)}
        | {"middle_02_l": OTHER, "middle_03_l": OTHER, "upperarm_twist_01_l": OTHER, "lowerarm_twist_01_l": OTHER}
        | {"thigh_twist_01_l": OTHER, "calf_twist_01_l": OTHER},
        dict.fromkeys(("pelvis", *(f"spine_0{i}" for i in range(1, 6)), "neck_01", "neck_02"), OTHER) | {"head": HEAD},
    ),
    Rig(
        "Biped",
        "3ds Max, with the prefix Bip01 or Bip001, https://docs.unity.cn/ScriptReference/HumanBone.html and "
        "https://pastebin.com/VHFSDJqM",
        {"L Clavicle": COLLAR, "L UpperArm": SHOULDER, "L Forearm": ELBOW, "L Hand": WRIST, "L Finger2": HAND}
        | {"L Thigh": HIP, "L Calf": KNEE, "L Foot": ANKLE, "L Toe0": BALL},
        dict.fromkeys(("Pelvis", "Spine", "Spine1", "Spine2", "Spine3", "Neck"), OTHER) | {"Head": HEAD},
    ),
    Rig("coco17", LAYOUT.format("coco17"), _POINTS | _FACE, dict.fromkeys(("nose", "pelvis", "neck"), OTHER)),
    Rig(
        "mediapipe33",
        LAYOUT.format("mediapipe33"),
        _POINTS
        | _FACE
        | dict.fromkeys(("left_eye_inner", "left_eye_outer", "mouth_left", "left_pinky", "left_thumb"), OTHER)
        # The knuckle of the index finger, some 10° from the middle of the hand.
        | {"left_index": HAND, "left_heel": OTHER, "left_foot_index": TOE},
        dict.fromkeys(("nose", "pelvis", "neck"), OTHER),
    ),
    # Its neck is between nose and neck, its head the top of the head.
    Rig(
        "h36m17",
        LAYOUT.format("h36m17"),
        _POINTS,
        dict.fromkeys(("pelvis", "spine", "thorax", "neck"), OTHER) | {"head": HEAD_TOP},
    ),
    Rig(
        "body25",
        LAYOUT.format("body25"),
        _POINTS | _FACE | {"left_big_toe": TOE, "left_small_toe": OTHER, "left_heel": OTHER},
        dict.fromkeys(("nose", "neck", "mid_hip"), OTHER),
    ),
    Rig(
        "kinect25",
        LAYOUT.format("kinect25"),
        _POINTS | {"left_hand": HAND, "left_hand_tip": OTHER, "left_thumb": OTHER, "left_foot": TOE},
        dict.fromkeys(("spine_base", "spine_mid", "spine_shoulder", "neck"), OTHER) | {"head": HEAD_CENTER},
    ),
    Rig(
        "Kinect v1",
        "the 20 joints of Kinect for Windows 1.8, as MATLAB's Image Acquisition Toolbox, User's Guide, 12-22, "
        "lists them",
        _POINTS | {"left_hand": HAND, "left_foot": TOE},
        dict.fromkeys(("hip_center", "spine", "shoulder_center"), OTHER) | {"head": HEAD_CENTER},
    ),
    # Hips are means of markers of the pelvis, shoulders and toes markers on the skin, toes on the head of a metatarsal.
    Rig(
        "plug_in_gait39",
        LAYOUT.format("plug_in_gait39"),
        {"left_hip": HIP, "LKNE": KNEE, "LANK": ANKLE, "LTOE": BALL, "LHEE": OTHER}
        | {"LSHO": SHOULDER, "LELB": ELBOW, "left_wrist": WRIST, "LFIN": HAND}
        | dict.fromkeys(("LTHI", "LTIB", "LASI", "LPSI", "LUPA", "LFRM", "LWRA", "LWRB", "LFHD", "LBHD"), OTHER),
        dict.fromkeys(("pelvis", "thorax", "C7", "T10", "CLAV", "STRN", "RBAK"), OTHER) | {"head": HEAD_CENTER},
    ),
    Rig(
        "opencap43",
        LAYOUT.format("opencap43"),
        {"LHJC_study": HIP, "left_knee": KNEE, "left_ankle": ANKLE, "L_toe_study": BALL}
        | {"L_shoulder_study": SHOULDER, "left_elbow": ELBOW, "left_wrist": WRIST}
        | dict.fromkeys((f"L_{name}_study" for name in ("knee", "mknee", "ankle", "mankle", "5meta", "calc")), OTHER)
        | dict.fromkeys((f"L_{name}_study" for name in ("lelbow", "melbow", "lwrist", "mwrist")), OTHER)
        | {f"L_{name}{i}_study": OTHER for name in ("thigh", "sh") for i in (1, 2, 3)}
        | {"L.ASIS_study": OTHER, "L.PSIS_study": OTHER},
        {"pelvis": OTHER, "C7_study": OTHER},
    ),
    Rig(
        "opencap_mocap55",
        LAYOUT.format("opencap_mocap55"),
        {"L_HJC": HIP, "L_KJC": KNEE, "L_AJC": ANKLE, "L_toe": BALL}
        | {"L_Shoulder": SHOULDER, "L_EJC": ELBOW, "L_WJC": WRIST}
        | dict.fromkeys(
            (f"L_{name}" for name in ("knee", "mknee", "ankle", "mankle", "5meta", "calc", "HJC_reg")), OTHER
        )
        | dict.fromkeys((f"L_{name}" for name in ("elbow_lat", "elbow_med", "wrist_radius", "wrist_ulna")), OTHER)
        | dict.fromkeys((f"L_{name}" for name in ("humerus", "forearm", "Sternum", "shank_antsup")), OTHER)
        | {f"L_thigh{i}": OTHER for i in (1, 2, 3, 4)}
        | {"L_sh2": OTHER, "L_sh3": OTHER, "L.ASIS": OTHER, "L.PSIS": OTHER},
        {"pelvis": OTHER, "C7": OTHER},
    ),
    Rig(
        "pose2sim21",
        LAYOUT.format("pose2sim21"),
        _POINTS | {"left_big_toe": TOE, "left_small_toe": OTHER, "left_heel": OTHER},
        dict.fromkeys(("hip", "neck", "nose"), OTHER) | {"head": HEAD_TOP},
    ),
    Rig(
        "humanoid",
        "skpose.datasets.humanoid",
        {"left_pelvis": HIP, "left_thigh": KNEE, "left_shank": ANKLE, "left_foot": BALL, "left_toes": TOE}
        | {"left_clavicle": SHOULDER, "left_upper_arm": ELBOW, "left_forearm": WRIST, "left_hand": HAND},
        dict.fromkeys(("abdomen", "chest"), OTHER) | {"neck": HEAD, "head": HEAD_TOP},
        "own",
    ),
    Rig(
        "humanoid as BVH",
        "skpose.io.save_bvh: each joint has the name of the bone that begins at it",
        {"left_pelvis": OTHER, "left_thigh": HIP, "left_shank": KNEE, "left_foot": ANKLE, "left_toes": BALL}
        | {"left_clavicle": COLLAR, "left_upper_arm": SHOULDER, "left_forearm": ELBOW, "left_hand": WRIST},
        dict.fromkeys(("abdomen", "chest", "neck"), OTHER) | {"head": HEAD},
        "parent",
    ),
)
