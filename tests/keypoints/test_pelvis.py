"""The rotation of the pelvis about the line of the hips."""

import numpy as np
import pytest

from skpose import inverse_kinematics
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
