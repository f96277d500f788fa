"""The layouts that come with the library: their tables."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from skpose._utils.validation import check_choice
from skpose.keypoints._layout import DAVIS, RIGID, Layout, find_names, layout_of

# As Pose2Sim writes them, y up. Some of its files have a point Hip, which is then taken, and some have none.
POSE2SIM21 = layout_of(
    "pose2sim21",
    (
        ("right_hip", "hip", RIGID),
        ("right_knee", "right_hip"),
        ("right_ankle", "right_knee"),
        ("right_big_toe", "right_ankle"),
        ("right_small_toe", "right_big_toe", RIGID),
        ("right_heel", "right_big_toe", RIGID),
        ("left_hip", "hip", RIGID),
        ("left_knee", "left_hip"),
        ("left_ankle", "left_knee"),
        ("left_big_toe", "left_ankle"),
        ("left_small_toe", "left_big_toe", RIGID),
        ("left_heel", "left_big_toe", RIGID),
        ("neck", "hip"),
        ("head", "neck"),
        ("nose", "head", RIGID),
        ("right_shoulder", "neck", RIGID),
        ("right_elbow", "right_shoulder"),
        ("right_wrist", "right_elbow"),
        ("left_shoulder", "neck", RIGID),
        ("left_elbow", "left_shoulder"),
        ("left_wrist", "left_elbow"),
        ("hip", None),
    ),
    source="HALPE_26 without eyes and ears, https://github.com/perfanalytics/pose2sim/blob/main/Pose2Sim/skeletons.py",
    midpoints={
        "hip": ("left_hip", "right_hip"),
    },
)

# The 43 markers that OpenCap estimates besides its keypoints, y up; files write r_knee_study and L_knee_study.
OPENCAP43 = layout_of(
    "opencap43",
    (
        ("R.ASIS_study", "pelvis", RIGID),
        ("L.ASIS_study", "pelvis", RIGID),
        ("R.PSIS_study", "pelvis", RIGID),
        ("L.PSIS_study", "pelvis", RIGID),
        ("R_knee_study", "right_knee", RIGID),
        ("R_mknee_study", "right_knee", RIGID),
        ("R_ankle_study", "right_ankle", RIGID),
        ("R_mankle_study", "right_ankle", RIGID),
        ("R_toe_study", "right_ankle"),
        ("R_5meta_study", "R_toe_study", RIGID),
        ("R_calc_study", "R_toe_study", RIGID),
        ("L_knee_study", "left_knee", RIGID),
        ("L_mknee_study", "left_knee", RIGID),
        ("L_ankle_study", "left_ankle", RIGID),
        ("L_mankle_study", "left_ankle", RIGID),
        ("L_toe_study", "left_ankle"),
        ("L_calc_study", "L_toe_study", RIGID),
        ("L_5meta_study", "L_toe_study", RIGID),
        ("R_shoulder_study", "C7_study", RIGID),
        ("L_shoulder_study", "C7_study", RIGID),
        ("C7_study", "pelvis"),
        ("R_thigh1_study", "right_knee", RIGID),
        ("R_thigh2_study", "right_knee", RIGID),
        ("R_thigh3_study", "right_knee", RIGID),
        ("L_thigh1_study", "left_knee", RIGID),
        ("L_thigh2_study", "left_knee", RIGID),
        ("L_thigh3_study", "left_knee", RIGID),
        ("R_sh1_study", "right_ankle", RIGID),
        ("R_sh2_study", "right_ankle", RIGID),
        ("R_sh3_study", "right_ankle", RIGID),
        ("L_sh1_study", "left_ankle", RIGID),
        ("L_sh2_study", "left_ankle", RIGID),
        ("L_sh3_study", "left_ankle", RIGID),
        ("RHJC_study", "pelvis", RIGID),
        ("LHJC_study", "pelvis", RIGID),
        ("R_lelbow_study", "right_elbow", RIGID),
        ("R_melbow_study", "right_elbow", RIGID),
        ("R_lwrist_study", "right_wrist", RIGID),
        ("R_mwrist_study", "right_wrist", RIGID),
        ("L_lelbow_study", "left_elbow", RIGID),
        ("L_melbow_study", "left_elbow", RIGID),
        ("L_lwrist_study", "left_wrist", RIGID),
        ("L_mwrist_study", "left_wrist", RIGID),
        ("pelvis", None),
        ("right_knee", "RHJC_study"),
        ("right_ankle", "right_knee"),
        ("right_elbow", "R_shoulder_study"),
        ("right_wrist", "right_elbow"),
        ("left_knee", "LHJC_study"),
        ("left_ankle", "left_knee"),
        ("left_elbow", "L_shoulder_study"),
        ("left_wrist", "left_elbow"),
    ),
    source="getOpenPoseMarkers_lowerExtremity2 and the markers of the arms, https://github.com/stanfordnmbl/opencap-core/blob/main/"
    "utils.py; the order of the files, https://github.com/stanfordnmbl/opencap-processing",
    midpoints={
        "pelvis": ("R.ASIS_study", "L.ASIS_study", "R.PSIS_study", "L.PSIS_study"),
        "right_knee": ("R_knee_study", "R_mknee_study"),
        "right_ankle": ("R_ankle_study", "R_mankle_study"),
        "right_elbow": ("R_lelbow_study", "R_melbow_study"),
        "right_wrist": ("R_lwrist_study", "R_mwrist_study"),
        "left_knee": ("L_knee_study", "L_mknee_study"),
        "left_ankle": ("L_ankle_study", "L_mankle_study"),
        "left_elbow": ("L_lelbow_study", "L_melbow_study"),
        "left_wrist": ("L_lwrist_study", "L_mwrist_study"),
    },
)

# The markers of OpenCap's recordings with motion capture in the laboratory, and the joint centres of the hips that its
# files state, y up; files write r_knee and L_knee. _HJC are found from movements, _HJC_reg by regression. The other
# joint centres, _KJC of knees, _AJC, _EJC and _WJC, are amid two markers; the files of movements lack the
# medial ones of knees and ankles. _toe is at the head of the second metatarsal. Clusters of left and right differ.
OPENCAP_MOCAP55 = layout_of(
    "opencap_mocap55",
    (
        ("C7", "pelvis"),
        ("L.ASIS", "pelvis", RIGID),
        ("L.PSIS", "pelvis", RIGID),
        ("L_5meta", "L_toe", RIGID),
        ("L_HJC", "pelvis", RIGID),
        ("L_HJC_reg", "pelvis", RIGID),
        ("L_Shoulder", "C7", RIGID),
        ("L_Sternum", "C7", RIGID),
        ("L_ankle", "L_AJC", RIGID),
        ("L_calc", "L_toe", RIGID),
        ("L_elbow_lat", "L_EJC", RIGID),
        ("L_elbow_med", "L_EJC", RIGID),
        ("L_forearm", "L_WJC", RIGID),
        ("L_humerus", "L_EJC", RIGID),
        ("L_knee", "L_KJC", RIGID),
        ("L_mankle", "L_AJC", RIGID),
        ("L_mknee", "L_KJC", RIGID),
        ("L_sh2", "L_AJC", RIGID),
        ("L_sh3", "L_AJC", RIGID),
        ("L_shank_antsup", "L_AJC", RIGID),
        ("L_thigh1", "L_KJC", RIGID),
        ("L_thigh2", "L_KJC", RIGID),
        ("L_thigh3", "L_KJC", RIGID),
        ("L_thigh4", "L_KJC", RIGID),
        ("L_toe", "L_AJC"),
        ("L_wrist_radius", "L_WJC", RIGID),
        ("L_wrist_ulna", "L_WJC", RIGID),
        ("R_HJC", "pelvis", RIGID),
        ("R_HJC_reg", "pelvis", RIGID),
        ("R_Shoulder", "C7", RIGID),
        ("R_Sternum", "C7", RIGID),
        ("R_elbow_lat", "R_EJC", RIGID),
        ("R_elbow_med", "R_EJC", RIGID),
        ("R_forearm", "R_WJC", RIGID),
        ("R_humerus", "R_EJC", RIGID),
        ("R_wrist_radius", "R_WJC", RIGID),
        ("R_wrist_ulna", "R_WJC", RIGID),
        ("R.ASIS", "pelvis", RIGID),
        ("R.PSIS", "pelvis", RIGID),
        ("R_5meta", "R_toe", RIGID),
        ("R_ankle", "R_AJC", RIGID),
        ("R_calc", "R_toe", RIGID),
        ("R_knee", "R_KJC", RIGID),
        ("R_mankle", "R_AJC", RIGID),
        ("R_mknee", "R_KJC", RIGID),
        ("R_sh2", "R_AJC", RIGID),
        ("R_sh3", "R_AJC", RIGID),
        ("R_sh4", "R_AJC", RIGID),
        ("R_shank_antsup", "R_AJC", RIGID),
        ("R_thigh1", "R_KJC", RIGID),
        ("R_thigh2", "R_KJC", RIGID),
        ("R_thigh3", "R_KJC", RIGID),
        ("R_thigh4", "R_KJC", RIGID),
        ("R_thigh5", "R_KJC", RIGID),
        ("R_toe", "R_AJC"),
        ("pelvis", None),
        ("L_KJC", "L_HJC"),
        ("L_AJC", "L_KJC"),
        ("L_EJC", "L_Shoulder"),
        ("L_WJC", "L_EJC"),
        ("R_KJC", "R_HJC"),
        ("R_AJC", "R_KJC"),
        ("R_EJC", "R_Shoulder"),
        ("R_WJC", "R_EJC"),
    ),
    source="S. D. Uhlrich et al., OpenCap, PLOS Computational Biology 19, 2023, doi:10.1371/journal.pcbi.1011462; the "
    "order of the files of its data set LabValidation, https://github.com/keenon/nimblephysics, data/grf/Subject4",
    midpoints={
        "pelvis": ("R.ASIS", "L.ASIS", "R.PSIS", "L.PSIS"),
        "L_KJC": ("L_knee", "L_mknee"),
        "L_AJC": ("L_ankle", "L_mankle"),
        "L_EJC": ("L_elbow_lat", "L_elbow_med"),
        "L_WJC": ("L_wrist_radius", "L_wrist_ulna"),
        "R_KJC": ("R_knee", "R_mknee"),
        "R_AJC": ("R_ankle", "R_mankle"),
        "R_EJC": ("R_elbow_lat", "R_elbow_med"),
        "R_WJC": ("R_wrist_radius", "R_wrist_ulna"),
    },
)

PLUG_IN_GAIT39 = layout_of(
    "plug_in_gait39",
    (
        ("LFHD", "head", RIGID),
        ("RFHD", "head", RIGID),
        ("LBHD", "head", RIGID),
        ("RBHD", "head", RIGID),
        ("C7", "thorax", RIGID),
        ("T10", "thorax", RIGID),
        ("CLAV", "thorax", RIGID),
        ("STRN", "thorax", RIGID),
        ("RBAK", "thorax", RIGID),
        ("LSHO", "thorax"),
        ("LUPA", "LELB", RIGID),
        ("LELB", "LSHO"),
        ("LFRM", "left_wrist", RIGID),
        ("LWRA", "left_wrist", RIGID),
        ("LWRB", "left_wrist", RIGID),
        ("LFIN", "left_wrist"),
        ("RSHO", "thorax"),
        ("RUPA", "RELB", RIGID),
        ("RELB", "RSHO"),
        ("RFRM", "right_wrist", RIGID),
        ("RWRA", "right_wrist", RIGID),
        ("RWRB", "right_wrist", RIGID),
        ("RFIN", "right_wrist"),
        ("LASI", "pelvis", RIGID),
        ("RASI", "pelvis", RIGID),
        ("LPSI", "pelvis", RIGID),
        ("RPSI", "pelvis", RIGID),
        ("LTHI", "left_knee", RIGID),
        ("LKNE", "left_knee", RIGID),
        ("LTIB", "left_ankle", RIGID),
        ("LANK", "left_ankle", RIGID),
        ("LHEE", "LTOE", RIGID),
        ("LTOE", "left_ankle"),
        ("RTHI", "right_knee", RIGID),
        ("RKNE", "right_knee", RIGID),
        ("RTIB", "right_ankle", RIGID),
        ("RANK", "right_ankle", RIGID),
        ("RHEE", "RTOE", RIGID),
        ("RTOE", "right_ankle"),
        ("pelvis", None),
        ("left_hip", "pelvis", RIGID),
        ("right_hip", "pelvis", RIGID),
        ("left_knee", "left_hip"),
        ("right_knee", "right_hip"),
        ("left_ankle", "left_knee"),
        ("right_ankle", "right_knee"),
        ("thorax", "pelvis"),
        ("head", "thorax"),
        ("left_wrist", "LELB"),
        ("right_wrist", "RELB"),
    ),
    source="Plug-in Gait full body, https://jssm.org/mobile/ShowTable.php?TableId=table002&jid=jssm-15-92.xml; "
    "https://vicon-help.atlassian.net/wiki/spaces/Nexus215/pages/11376865/Full+body+modeling+with+Plug-in+Gait",
    up="z",
    midpoints={
        "pelvis": ("LASI", "RASI", "LPSI", "RPSI"),
        "left_hip": (DAVIS, "LASI", "RASI", "LPSI", "RPSI", "LKNE", "LANK"),
        "right_hip": (DAVIS, "RASI", "LASI", "RPSI", "LPSI", "RKNE", "RANK"),
        "left_knee": ("davis_knee", "left_hip", "LKNE", "LTHI"),
        "right_knee": ("davis_knee", "right_hip", "RKNE", "RTHI"),
        "left_ankle": ("davis_ankle", "left_knee", "LANK", "LTIB"),
        "right_ankle": ("davis_ankle", "right_knee", "RANK", "RTIB"),
        "thorax": ("C7", "CLAV", "T10", "STRN"),
        "head": ("LFHD", "RFHD", "LBHD", "RBHD"),
        "left_wrist": ("LWRA", "LWRB"),
        "right_wrist": ("RWRA", "RWRB"),
    },
)


# --- tables -----------------------------------------------------------------------------------------------------------


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


class _Layouts(dict[str, Layout]):
    """The layouts that come with the library, by name.

    ================== ======================================== ====== ===========================================
    name               keypoints of                             up     added midpoints
    ================== ======================================== ====== ===========================================
    "coco17"           COCO, lifted to 3-D: MMPose, MoveNet ... y      pelvis, neck
    "mediapipe33"      MediaPipe Pose, its world landmarks      −y     pelvis, neck
    "h36m17"           Human3.6M, in world coordinates          z
    "body25"           OpenPose BODY_25, triangulated           −y
    "kinect25"         Kinect v2, in camera space               y
    "smpl24"           SMPL, its joints                         y
    "humanml22"        HumanML3D, joints of SMPL without hands  y
    "cmu31"            CMU's ASF files, the root and 30 bones   y
    "kinect20"         the first Kinect, in skeleton space      y
    "mediapipe_hand21" MediaPipe Hands, one, world landmarks    −y
    "pose2sim21"       Pose2Sim, HALPE_26 without the face      y      hip
    "opencap43"        OpenCap's markers, of video              y      pelvis, knees, ankles, elbows, wrists
    "plug_in_gait39"   markers of Plug-in Gait, the full body   z      pelvis, hips to ankles, thorax, head, wrists
    "opencap_mocap55"  OpenCap's markers, of motion capture     y      pelvis, knees, ankles, elbows, wrists
    ================== ======================================== ====== ===========================================

    ``layouts["coco17"].source`` is the source of the order of the points. Keypoints lifted from pictures to 3-D have
    the axes of the program that lifts them: if y is not up, pass ``dataclasses.replace(layouts["coco17"], up="z")``.
    `Layout` makes your own in a few lines.

    Files of markers name their points, and some lack a few:
    ``layouts["plug_in_gait39"].without(["LUPA", "RUPA"]).keypoints(load_c3d("walk.c3d"))``. Markers are on the skin,
    and so are the ends of bones that are markers; the hips, knees and ankles of "plug_in_gait39" are computed as in
    Plug-in Gait, see `Layout`. If a file has joint centres, a `Layout` with these is better. Medial markers
    of knees and ankles are often in the standing trial only: ``layout.keypoints(markers, absent="unseen")`` reads the
    other trials.

    Examples
    --------
    >>> from skpose.keypoints import layouts
    >>> list(layouts)[:3]
    ['coco17', 'mediapipe33', 'h36m17']
    >>> layouts["coco17"].names[:3]
    ('nose', 'left_eye', 'right_eye')
    >>> layouts["coco17"].pairs[0]
    ('left_eye', 'right_eye')
    """


layouts = _Layouts({layout.name: layout for layout in LAYOUTS})


def check_layout(layout: Any) -> Layout:
    """A layout, given as such or by name."""
    if isinstance(layout, Layout):
        return layout
    check_choice("layout", layout, tuple(layouts))
    return layouts[layout]


def find_layout(names: Sequence[str]) -> Layout | None:
    """The layout with all of its points among the names, in any spelling; the one with the most points."""
    complete = (layout for layout in layouts.values() if _share(layout, names) == 1.0)
    return max(complete, key=lambda layout: len(layout.names), default=None)


def missing_points(layout: Layout, names: Sequence[str]) -> list[str]:
    """The points of a layout that are not among names, in any spelling."""
    found = find_names(layout.names, names)
    return [name for name in layout.names if name not in found]


def nearest_layout(names: Sequence[str]) -> Layout | None:
    """The layout with the largest share of its points among names; None if that is less than half."""
    nearest = max(layouts.values(), key=lambda layout: _share(layout, names))
    return nearest if _share(nearest, names) >= 0.5 else None


def _share(layout: Layout, names: Sequence[str]) -> float:
    """The share of a layout's points among names."""
    try:
        return 1.0 - len(missing_points(layout, names)) / len(layout.names)
    except ValueError:  # two names differ in spelling only
        return 0.0
