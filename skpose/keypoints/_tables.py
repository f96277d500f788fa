"""The layouts that come with the library as tables, each with the source of the order of its points.

A table has a row for each point of the array, in its order, and then one for each midpoint: name, parent, whether the
point is rigid. Names are those of the source in snake case; those of OpenPose and Kinect have their sides first.
"""

from collections.abc import Mapping
from typing import Literal, NamedTuple

RIGID = True
Row = tuple[str, str | None] | tuple[str, str | None, bool]


class Table(NamedTuple):
    """The points of a layout."""

    name: str
    rows: tuple[Row, ...]
    source: str
    up: Literal["y", "z", "-y"] = "y"
    midpoints: Mapping[str, tuple[str, str]] = {}

    @property
    def names(self) -> list[str]:
        return [row[0] for row in self.rows if row[0] not in self.midpoints]


HIPS, SHOULDERS = ("left_hip", "right_hip"), ("left_shoulder", "right_shoulder")

# Keypoints lifted to 3-D have the axes of whoever lifts them: y up is a choice, `replace(..., up=...)` another one.
COCO17 = Table(
    "coco17",
    (
        ("nose", "neck"),
        ("left_eye", "nose", RIGID),
        ("right_eye", "nose", RIGID),
        ("left_ear", "nose", RIGID),
        ("right_ear", "nose", RIGID),
        ("left_shoulder", "neck", RIGID),
        ("right_shoulder", "neck", RIGID),
        ("left_elbow", "left_shoulder"),
        ("right_elbow", "right_shoulder"),
        ("left_wrist", "left_elbow"),
        ("right_wrist", "right_elbow"),
        ("left_hip", "pelvis", RIGID),
        ("right_hip", "pelvis", RIGID),
        ("left_knee", "left_hip"),
        ("right_knee", "right_hip"),
        ("left_ankle", "left_knee"),
        ("right_ankle", "right_knee"),
        ("pelvis", None),
        ("neck", "pelvis"),
    ),
    source="COCO keypoints, https://github.com/open-mmlab/mmpose/blob/main/configs/_base_/datasets/coco.py",
    midpoints={"pelvis": HIPS, "neck": SHOULDERS},
)

# World landmarks: metres, the origin between the hips, x to the right of the picture, y down, z away from the camera.
MEDIAPIPE33 = Table(
    "mediapipe33",
    (
        ("nose", "neck"),
        ("left_eye_inner", "nose", RIGID),
        ("left_eye", "nose", RIGID),
        ("left_eye_outer", "nose", RIGID),
        ("right_eye_inner", "nose", RIGID),
        ("right_eye", "nose", RIGID),
        ("right_eye_outer", "nose", RIGID),
        ("left_ear", "nose", RIGID),
        ("right_ear", "nose", RIGID),
        ("mouth_left", "nose", RIGID),
        ("mouth_right", "nose", RIGID),
        ("left_shoulder", "neck", RIGID),
        ("right_shoulder", "neck", RIGID),
        ("left_elbow", "left_shoulder"),
        ("right_elbow", "right_shoulder"),
        ("left_wrist", "left_elbow"),
        ("right_wrist", "right_elbow"),
        ("left_pinky", "left_index", RIGID),
        ("right_pinky", "right_index", RIGID),
        ("left_index", "left_wrist"),
        ("right_index", "right_wrist"),
        ("left_thumb", "left_index", RIGID),
        ("right_thumb", "right_index", RIGID),
        ("left_hip", "pelvis", RIGID),
        ("right_hip", "pelvis", RIGID),
        ("left_knee", "left_hip"),
        ("right_knee", "right_hip"),
        ("left_ankle", "left_knee"),
        ("right_ankle", "right_knee"),
        ("left_heel", "left_foot_index", RIGID),
        ("right_heel", "right_foot_index", RIGID),
        ("left_foot_index", "left_ankle"),
        ("right_foot_index", "right_ankle"),
        ("pelvis", None),
        ("neck", "pelvis"),
    ),
    source="MediaPipe Pose Landmarker, https://ai.google.dev/edge/mediapipe/solutions/vision/pose_landmarker; axes: "
    "https://github.com/google-ai-edge/mediapipe/issues/4205",
    up="-y",
    midpoints={"pelvis": HIPS, "neck": SHOULDERS},
)

# Of the 32 joints of the data set, 17 move. World coordinates have z up; the data set is in millimetres. Its joints at
# the ends of the shanks are named feet, and stand at the ankles. Some tables of others exchange the legs.
H36M17 = Table(
    "h36m17",
    (
        ("pelvis", None),
        ("right_hip", "pelvis", RIGID),
        ("right_knee", "right_hip"),
        ("right_ankle", "right_knee"),
        ("left_hip", "pelvis", RIGID),
        ("left_knee", "left_hip"),
        ("left_ankle", "left_knee"),
        ("spine", "pelvis"),
        ("thorax", "spine"),
        ("neck", "thorax"),
        ("head", "neck"),
        ("left_shoulder", "thorax"),
        ("left_elbow", "left_shoulder"),
        ("left_wrist", "left_elbow"),
        ("right_shoulder", "thorax"),
        ("right_elbow", "right_shoulder"),
        ("right_wrist", "right_elbow"),
    ),
    source="Human3.6M, https://github.com/facebookresearch/VideoPose3D/blob/main/common/h36m_dataset.py",
    up="z",
)

# In 3-D, as OpenPose triangulates them: the axes of one camera, metres, y down. The network estimates neck and mid_hip.
BODY25 = Table(
    "body25",
    (
        ("nose", "neck"),
        ("neck", "mid_hip"),
        ("right_shoulder", "neck"),
        ("right_elbow", "right_shoulder"),
        ("right_wrist", "right_elbow"),
        ("left_shoulder", "neck"),
        ("left_elbow", "left_shoulder"),
        ("left_wrist", "left_elbow"),
        ("mid_hip", None),
        ("right_hip", "mid_hip", RIGID),
        ("right_knee", "right_hip"),
        ("right_ankle", "right_knee"),
        ("left_hip", "mid_hip", RIGID),
        ("left_knee", "left_hip"),
        ("left_ankle", "left_knee"),
        ("right_eye", "nose", RIGID),
        ("left_eye", "nose", RIGID),
        ("right_ear", "nose", RIGID),
        ("left_ear", "nose", RIGID),
        ("left_big_toe", "left_ankle"),
        ("left_small_toe", "left_big_toe", RIGID),
        ("left_heel", "left_big_toe", RIGID),
        ("right_big_toe", "right_ankle"),
        ("right_small_toe", "right_big_toe", RIGID),
        ("right_heel", "right_big_toe", RIGID),
    ),
    source="https://cmu-perceptual-computing-lab.github.io/openpose/web/html/doc/md_doc_02_output.html; axes: "
    "https://github.com/CMU-Perceptual-Computing-Lab/openpose/blob/master/doc/advanced/calibration_module.md",
    up="-y",
)

# Camera space: metres, y up, z away from the sensor, which stands still and may be tilted.
KINECT25 = Table(
    "kinect25",
    (
        ("spine_base", None),
        ("spine_mid", "spine_base"),
        ("neck", "spine_shoulder"),
        ("head", "neck"),
        ("left_shoulder", "spine_shoulder"),
        ("left_elbow", "left_shoulder"),
        ("left_wrist", "left_elbow"),
        ("left_hand", "left_wrist"),
        ("right_shoulder", "spine_shoulder"),
        ("right_elbow", "right_shoulder"),
        ("right_wrist", "right_elbow"),
        ("right_hand", "right_wrist"),
        ("left_hip", "spine_base", RIGID),
        ("left_knee", "left_hip"),
        ("left_ankle", "left_knee"),
        ("left_foot", "left_ankle"),
        ("right_hip", "spine_base", RIGID),
        ("right_knee", "right_hip"),
        ("right_ankle", "right_knee"),
        ("right_foot", "right_ankle"),
        ("spine_shoulder", "spine_mid"),
        ("left_hand_tip", "left_hand"),
        ("left_thumb", "left_wrist"),
        ("right_hand_tip", "right_hand"),
        ("right_thumb", "right_wrist"),
    ),
    source="https://learn.microsoft.com/en-us/previous-versions/windows/kinect/dn758663(v=ieb.10); "
    "axes: https://learn.microsoft.com/en-us/previous-versions/windows/kinect/dn772836(v=ieb.10)",
)

# Hips and the first joint of the spine turn with the pelvis, as in SMPL. There neck and collars turn together too, with
# spine3; here each has a ball joint, as a bone is turned by the joint at its end. Every pose of SMPL can be reached.
SMPL24 = Table(
    "smpl24",
    (
        ("pelvis", None),
        ("left_hip", "pelvis", RIGID),
        ("right_hip", "pelvis", RIGID),
        ("spine1", "pelvis", RIGID),
        ("left_knee", "left_hip"),
        ("right_knee", "right_hip"),
        ("spine2", "spine1"),
        ("left_ankle", "left_knee"),
        ("right_ankle", "right_knee"),
        ("spine3", "spine2"),
        ("left_foot", "left_ankle"),
        ("right_foot", "right_ankle"),
        ("neck", "spine3"),
        ("left_collar", "spine3"),
        ("right_collar", "spine3"),
        ("head", "neck"),
        ("left_shoulder", "left_collar"),
        ("right_shoulder", "right_collar"),
        ("left_elbow", "left_shoulder"),
        ("right_elbow", "right_shoulder"),
        ("left_wrist", "left_elbow"),
        ("right_wrist", "right_elbow"),
        ("left_hand", "left_wrist"),
        ("right_hand", "right_wrist"),
    ),
    source="SMPL, https://github.com/vchoutas/smplx/blob/main/smplx/joint_names.py",
)

# The root and the 30 bones of CMU's ASF files, in the order of their numbers; each point is the far end of its bone.
CMU31 = Table(
    "cmu31",
    (
        ("root", None),
        ("lhipjoint", "root", RIGID),
        ("lfemur", "lhipjoint"),
        ("ltibia", "lfemur"),
        ("lfoot", "ltibia"),
        ("ltoes", "lfoot"),
        ("rhipjoint", "root", RIGID),
        ("rfemur", "rhipjoint"),
        ("rtibia", "rfemur"),
        ("rfoot", "rtibia"),
        ("rtoes", "rfoot"),
        ("lowerback", "root"),
        ("upperback", "lowerback"),
        ("thorax", "upperback"),
        ("lowerneck", "thorax"),
        ("upperneck", "lowerneck"),
        ("head", "upperneck"),
        ("lclavicle", "thorax"),
        ("lhumerus", "lclavicle"),
        ("lradius", "lhumerus"),
        ("lwrist", "lradius"),
        ("lhand", "lwrist"),
        ("lfingers", "lhand"),
        ("lthumb", "lwrist"),
        ("rclavicle", "thorax"),
        ("rhumerus", "rclavicle"),
        ("rradius", "rhumerus"),
        ("rwrist", "rradius"),
        ("rhand", "rwrist"),
        ("rfingers", "rhand"),
        ("rthumb", "rwrist"),
    ),
    source="CMU Graphics Lab Motion Capture Database, http://mocap.cs.cmu.edu/subjects/35/35.asf",
)

TABLES = (COCO17, MEDIAPIPE33, H36M17, BODY25, KINECT25, SMPL24, CMU31)
