"""The layouts that come with the library as tables, each with the source of the order of its points."""

from dataclasses import replace

from skpose.keypoints._marker_tables import OPENCAP43, OPENCAP_MOCAP55, PLUG_IN_GAIT39, POSE2SIM21
from skpose.keypoints._table import RIGID, layout_of

HIPS, SHOULDERS = ("left_hip", "right_hip"), ("left_shoulder", "right_shoulder")

# Keypoints lifted to 3-D have the axes of the program that lifts them: y up is a choice, see `replace(..., up=...)`.
COCO17 = layout_of(
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
MEDIAPIPE33 = layout_of(
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
H36M17 = layout_of(
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
BODY25 = layout_of(
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
KINECT25 = layout_of(
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

# The first Kinect: skeleton space, metres, y up, z away from the sensor, which stands still and may be tilted.
KINECT20 = layout_of(
    "kinect20",
    (
        ("hip_center", None),
        ("spine", "hip_center"),
        ("shoulder_center", "spine"),
        ("head", "shoulder_center"),
        ("left_shoulder", "shoulder_center"),
        ("left_elbow", "left_shoulder"),
        ("left_wrist", "left_elbow"),
        ("left_hand", "left_wrist"),
        ("right_shoulder", "shoulder_center"),
        ("right_elbow", "right_shoulder"),
        ("right_wrist", "right_elbow"),
        ("right_hand", "right_wrist"),
        ("left_hip", "hip_center", RIGID),
        ("left_knee", "left_hip"),
        ("left_ankle", "left_knee"),
        ("left_foot", "left_ankle"),
        ("right_hip", "hip_center", RIGID),
        ("right_knee", "right_hip"),
        ("right_ankle", "right_knee"),
        ("right_foot", "right_ankle"),
    ),
    source="NUI_SKELETON_POSITION_INDEX of NuiSkeleton.h, https://www.cnblogs.com/mumuliang/p/2099392.html; axes: "
    "https://learn.microsoft.com/en-us/previous-versions/windows/kinect-1.8/hh973078(v=ieb.10)",
)

# World landmarks of one hand: metres, the axes of the picture, y down. The knuckles move little within the palm.
MEDIAPIPE_HAND21 = layout_of(
    "mediapipe_hand21",
    (
        ("wrist", None),
        ("thumb_cmc", "wrist", RIGID),
        ("thumb_mcp", "thumb_cmc"),
        ("thumb_ip", "thumb_mcp"),
        ("thumb_tip", "thumb_ip"),
        ("index_finger_mcp", "wrist", RIGID),
        ("index_finger_pip", "index_finger_mcp"),
        ("index_finger_dip", "index_finger_pip"),
        ("index_finger_tip", "index_finger_dip"),
        ("middle_finger_mcp", "wrist", RIGID),
        ("middle_finger_pip", "middle_finger_mcp"),
        ("middle_finger_dip", "middle_finger_pip"),
        ("middle_finger_tip", "middle_finger_dip"),
        ("ring_finger_mcp", "wrist", RIGID),
        ("ring_finger_pip", "ring_finger_mcp"),
        ("ring_finger_dip", "ring_finger_pip"),
        ("ring_finger_tip", "ring_finger_dip"),
        ("pinky_mcp", "wrist", RIGID),
        ("pinky_pip", "pinky_mcp"),
        ("pinky_dip", "pinky_pip"),
        ("pinky_tip", "pinky_dip"),
    ),
    source="MediaPipe Hand Landmarker, https://ai.google.dev/edge/mediapipe/solutions/vision/hand_landmarker",
    up="-y",
)

# Hips and the first joint of the spine turn with the pelvis, as in SMPL. There neck and collars turn together too, with
# spine3; here each has a ball joint, as a bone is turned by the joint at its end. Every pose of SMPL can be reached.
SMPL24 = layout_of(
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

# The joints of SMPL's body, without hands.
HUMANML22 = replace(
    SMPL24.without(["left_hand", "right_hand"]),
    name="humanml22",
    source="HumanML3D, https://github.com/EricGuo5513/HumanML3D/blob/main/paramUtil.py",
)

# The root and the 30 bones of CMU's ASF files, in the order of their numbers; each point is the far end of its bone.
CMU31 = layout_of(
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

LAYOUTS = (
    COCO17,
    MEDIAPIPE33,
    H36M17,
    BODY25,
    KINECT25,
    SMPL24,
    HUMANML22,
    CMU31,
    KINECT20,
    MEDIAPIPE_HAND21,
    POSE2SIM21,
    OPENCAP43,
    PLUG_IN_GAIT39,
    OPENCAP_MOCAP55,
)
