"""The robots whose links are known, one table each, with its source.

A table has for each landmark of a person the link, and the offset from its origin if any: in m at angle zero, in the
axes of the root, x forward, y left and z up. It has the left side; the right one is its mirror image. Names are those
of bodies in MJCF files and of links in URDF files.

A hip is where the axis of the hinge that swings the leg forward meets the plane of the leg, a shoulder likewise, so
that both move with the trunk. An ankle is at the hinge that the shank carries. Heels and toes are the ends of the sole,
below the middle of the foot.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from skpose.kinematics._anatomy import ANKLE, ELBOW, HAND, HIP, KNEE, SHOULDER, WRIST

HEEL, TIP = "heel", "tip"  # the ends of the sole
Vector = tuple[float, float, float]


class Robot(NamedTuple):
    """The landmarks of a robot."""

    name: str
    source: str
    left: Mapping[str, Any]  # a link, or a link and how far from its origin
    right: tuple[tuple[str, str], ...]  # parts of names on the left side, and on the right
    sole: float = 0.0  # half its width, m


ROBOTS = (
    Robot(
        "Unitree G1",
        "g1_29dof.xml of https://github.com/unitreerobotics/unitree_mujoco: the soles are the spheres of 5 mm at the "
        "corners of each foot, the hinges of the hips, the shoulders and the wrists do not meet by up to 5 cm",
        {HIP: ("left_hip_pitch_link", (0.0, 0.052, 0.0)), KNEE: "left_knee_link", ANKLE: "left_ankle_pitch_link"}
        | {HEEL: ("left_ankle_roll_link", (-0.05, 0.0, -0.035)), TIP: ("left_ankle_roll_link", (0.12, 0.0, -0.035))}
        | {
            SHOULDER: ("left_shoulder_pitch_link", (0.0, 0.0466, 0.0135)),
            ELBOW: "left_elbow_link",
            WRIST: "left_wrist_pitch_link",
        }
        | {HAND: ("left_wrist_yaw_link", (0.05, 0.0, 0.0))},
        (("left", "right"),),
        0.03,
    ),
    Robot(
        "Booster T1",
        "t1.xml of https://github.com/google-deepmind/mujoco_menagerie: the soles are the boxes of its feet; and the "
        "model with hands of https://github.com/YanjieZe/GMR",
        {HIP: "Hip_Pitch_Left", KNEE: "Shank_Left", ANKLE: "Ankle_Cross_Left"}
        | {HEEL: ("left_foot_link", (-0.1015, 0.0, -0.03)), TIP: ("left_foot_link", (0.1215, 0.0, -0.03))}
        | {SHOULDER: "AL2", ELBOW: "AL4", WRIST: "AL6"},
        (("Left", "Right"), ("left", "right"), ("AL", "AR")),
        0.05,
    ),
    Robot(
        "EngineAI PM01",
        "serial_pm01_edu.xml of https://github.com/engineai-robotics/engineai_robotics_native_sdk: the soles are the "
        "boxes of its feet, and the forearm is one link without a wrist",
        {HIP: ("LINK_HIP_PITCH_L", (0.0, 0.0494, -0.0132)), KNEE: "LINK_KNEE_PITCH_L", ANKLE: "LINK_ANKLE_PITCH_L"}
        | {HEEL: ("LINK_ANKLE_ROLL_L", (-0.0853, 0.0, -0.0463)), TIP: ("LINK_ANKLE_ROLL_L", (0.1193, 0.0, -0.0463))}
        | {SHOULDER: ("LINK_SHOULDER_PITCH_L", (0.0, 0.0669, -0.0208)), ELBOW: "LINK_ELBOW_PITCH_L"}
        | {WRIST: "LINK_ELBOW_YAW_L"},
        (("_L", "_R"),),
        0.0536,
    ),
    Robot(
        "Galaxea R1 Pro",
        "r1_pro.xml of https://github.com/YanjieZe/GMR: the hinges of shoulders, elbows and wrists meet in these "
        "points; wheels carry it",
        {SHOULDER: ("left_arm_link1", (0.0, 0.0813, 0.0)), ELBOW: ("left_arm_link4", (0.0, -0.0351, 0.0))}
        | {WRIST: ("left_arm_link6", (0.0, 0.028, 0.0)), HAND: ("left_arm_link7", (-0.0295, 0.0, -0.1))},
        (("left", "right"),),
    ),
)


def places_of(robot: Robot) -> dict[str, tuple[str, Vector]]:
    """The link and the offset of each landmark, "left_knee" and so on."""
    places = {}
    for mark, place in robot.left.items():
        link, (x, y, z) = (place, (0.0, 0.0, 0.0)) if isinstance(place, str) else place
        other = link
        for left, right in robot.right:
            other = other.replace(left, right)
        places[f"left_{mark}"] = link, (x, y, z)
        places[f"right_{mark}"] = other, (x, -y, z)
    return places
