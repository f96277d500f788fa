"""The rotation of the pelvis about the line of the hips."""

import numpy as np
import pytest
from people import standing_in

from skpose import forward_kinematics, inverse_kinematics
from skpose.keypoints import fit_skeleton, layouts

STANDING = {
    "nose": (0, 1.58, 0.12),
    "head": (0, 1.7, 0),
    "eye": (0.03, 1.62, 0.1),
    "ear": (0.08, 1.6, 0.01),
    "shoulder": (0.18, 1.45, 0),
    "elbow": (0.25, 1.17, -0.03),
    "wrist": (0.28, 0.93, 0.08),
    "hip": (0.1, 0.92, 0),
    "knee": (0.11, 0.5, 0.02),
    "ankle": (0.11, 0.09, -0.02),
    "pelvis": (0, 0.92, 0),
    "spine": (0, 1.2, -0.03),
    "neck": (0, 1.48, 0),
}


@pytest.mark.parametrize(("name", "scores"), [("coco17", True), ("h36m17", False)])
def test_a_person_who_stands_still_keeps_the_pelvis(name, scores):
    layout, rng = layouts[name], np.random.default_rng(0)
    person = [
        np.array(STANDING.get(point, STANDING.get(point.split("_")[-1], (0, 1.6, 0))))
        * ((-1, 1, 1) if "right" in point else 1)
        for point in layout.names
    ]
    positions = np.array(person) + 0.005 * rng.normal(size=(75, len(person), 3))
    confidences = rng.uniform(0.5, 1.0, size=(75, len(person))) if scores else None
    if layout.up == "z":
        positions = positions[:, :, [0, 2, 1]] * [1.0, -1.0, 1.0]
    keypoints = layout.keypoints(positions, 25, confidences)
    fitted = inverse_kinematics(keypoints, fit_skeleton(keypoints, layout))
    tilts = fitted.root_rotations - fitted.root_rotations.mean(axis=0)
    assert np.degrees(np.abs(tilts)).max() < 10.0


@pytest.mark.filterwarnings("ignore:lengths of bones are uncertain")
@pytest.mark.parametrize(("noise", "drop"), [(0.02, 0.06), (0.03, 0.06), (0.02, 0.0)])
def test_many_frames_show_the_hips_of_a_depth_camera(noise, drop):
    """Hips 9 cm to each side and 6 cm below the centre make 113°, or 180° on a line; each frame has noise of cm."""
    layout, rng = layouts["kinect20"], np.random.default_rng(0)
    hips = {"hip_center": (0, 0.92, 0), "left_hip": (0.09, 0.92 - drop, 0), "right_hip": (-0.09, 0.92 - drop, 0)}
    trunk = {"shoulder_center": (0, 1.42, 0), "spine": (0, 1.15, -0.02)}
    person = np.array([(standing_in(layout) | trunk | hips)[name] for name in layout.names])
    angles = []
    for _ in range(5):
        positions = person + rng.normal(0, noise, (100, *person.shape))
        skeleton = fit_skeleton(layout.keypoints(positions, 15), layout)
        (zero,) = forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton)
        left, right = (zero[skeleton.joint_names.index(name)] for name in ("left_hip", "right_hip"))
        angles.append(np.degrees(np.arctan2(np.linalg.norm(np.cross(left, right)), left @ right)))
    assert np.abs(np.array(angles) - (113 if drop else 180)).max() < 15


@pytest.mark.filterwarnings("ignore:lengths of bones", "ignore:.*point backward")
def test_a_pelvis_that_does_not_fit_is_a_warning():
    """Three frames with noise of 5 cm: no frame shows how the pelvis is turned."""
    layout, rng = layouts["kinect20"], np.random.default_rng(1)
    hips = {"hip_center": (0, 1.0, 0), "left_hip": (0.09, 0.94, 0), "right_hip": (-0.09, 0.94, 0)}
    trunk = {"shoulder_center": (0, 1.4, 0), "spine": (0, 1.08, 0)}
    person = np.array([(standing_in(layout) | trunk | hips)[name] for name in layout.names])
    with pytest.warns(UserWarning, match=r"turned by \d\d°"):
        fit_skeleton(layout.keypoints(person + rng.normal(0, 0.05, (3, *person.shape)), 15), layout)
