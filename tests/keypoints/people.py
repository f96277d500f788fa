"""Synthetic people with the points of any layout: standing and moving, with bones of constant length."""

import numpy as np
import reference
from scipy.spatial.transform import Rotation

from skpose import Bone, Skeleton
from skpose.keypoints import Keypoints, Layout

PEOPLE = ["coco17", "smpl24", "plug_in_gait39"]

ALONE = {"opencap_mocap55": ["R_sh4", "R_thigh5"]}  # markers on one side alone

# Points of a standing person, m: x to the left, y up, z forward. Those of the right mirror those of the left.
MIDDLE = {
    "pelvis": (0, 0.92, 0),
    "mid_hip": (0, 0.92, 0),
    "spine_base": (0, 0.93, -0.01),
    "root": (0, 0.97, -0.02),
    "spine1": (0, 1.03, -0.02),
    "lowerback": (0, 1.06, -0.03),
    "spine": (0, 1.15, -0.02),
    "spine_mid": (0, 1.17, -0.02),
    "upperback": (0, 1.18, -0.03),
    "spine2": (0, 1.16, -0.02),
    "spine3": (0, 1.3, -0.02),
    "thorax": (0, 1.38, -0.02),
    "spine_shoulder": (0, 1.4, -0.02),
    "lowerneck": (0, 1.46, 0.0),
    "neck": (0, 1.45, 0),
    "upperneck": (0, 1.53, 0.02),
    "head": (0, 1.65, 0.03),
    "nose": (0, 1.58, 0.12),
    "hip": (0, 0.92, 0),
    "hip_center": (0, 0.93, -0.01),
    "shoulder_center": (0, 1.42, -0.02),
    "C7": (0, 1.47, -0.07),
    "C7_study": (0, 1.47, -0.07),
    "T10": (0, 1.2, -0.1),
    "CLAV": (0, 1.4, 0.05),
    "STRN": (0, 1.22, 0.1),
    "RBAK": (-0.1, 1.33, -0.1),
    "L_humerus": (0.25, 1.33, -0.01),  # a marker on the upper arm, and not the elbow, as CMU's is
    "R_humerus": (-0.25, 1.33, -0.01),
    "wrist": (0.28, 0.93, 0.08),
}
# One hand, whose wrist is that of no side; fingers point down.
HAND = {
    "thumb": ("cmc mcp ip tip", (0.26, 0.91, 0.1), (-0.01, -0.025, 0.015)),
    "index_finger": ("mcp pip dip tip", (0.27, 0.84, 0.11), (0.002, -0.03, 0.004)),
    "middle_finger": ("mcp pip dip tip", (0.28, 0.835, 0.09), (0.0, -0.032, 0.004)),
    "ring_finger": ("mcp pip dip tip", (0.285, 0.84, 0.07), (0.001, -0.03, 0.003)),
    "pinky": ("mcp pip dip tip", (0.29, 0.85, 0.05), (0.002, -0.022, 0.001)),
}
for finger, (joints, first, step) in HAND.items():
    MIDDLE |= {f"{finger}_{name}": np.add(first, np.multiply(i, step)) for i, name in enumerate(joints.split())}
LEFT = {
    "hip": (0.1, 0.92, 0),
    "hipjoint": (0.09, 0.88, 0.01),
    "knee": (0.11, 0.5, 0.02),
    "femur": (0.11, 0.5, 0.02),
    "ankle": (0.11, 0.09, -0.02),
    "tibia": (0.11, 0.09, -0.02),
    "foot": (0.12, 0.02, 0.1),
    "toes": (0.13, 0.02, 0.17),
    "foot_index": (0.13, 0.02, 0.17),
    "big_toe": (0.11, 0.02, 0.17),
    "small_toe": (0.16, 0.02, 0.14),
    "heel": (0.11, 0.02, -0.06),
    "collar": (0.08, 1.4, -0.01),
    "shoulder": (0.18, 1.45, 0),
    "clavicle": (0.18, 1.44, -0.02),
    "elbow": (0.25, 1.17, -0.03),
    "humerus": (0.25, 1.17, -0.03),
    "radius": (0.27, 1.0, 0.05),
    "wrist": (0.28, 0.93, 0.08),
    "hand": (0.28, 0.86, 0.11),
    "index": (0.27, 0.83, 0.14),
    "hand_tip": (0.28, 0.78, 0.14),
    "fingers": (0.28, 0.78, 0.14),
    "pinky": (0.3, 0.83, 0.08),
    "thumb": (0.25, 0.87, 0.15),
    "eye": (0.03, 1.62, 0.1),
    "eye_inner": (0.02, 1.62, 0.11),
    "eye_outer": (0.045, 1.62, 0.09),
    "ear": (0.08, 1.6, 0.01),
    "mouth": (0.025, 1.54, 0.1),
    "FHD": (0.07, 1.66, 0.1),
    "BHD": (0.07, 1.66, -0.07),
    "SHO": (0.18, 1.48, 0),
    "UPA": (0.24, 1.33, 0),
    "ELB": (0.28, 1.17, -0.03),
    "FRM": (0.29, 1.04, 0.02),
    "WRA": (0.25, 0.94, 0.11),
    "WRB": (0.3, 0.94, 0.05),
    "FIN": (0.29, 0.85, 0.12),
    "ASI": (0.12, 1.0, 0.1),
    "PSI": (0.05, 1.03, -0.09),
    "THI": (0.16, 0.7, 0.02),
    "KNE": (0.16, 0.5, 0.02),
    "TIB": (0.15, 0.3, 0.0),
    "ANK": (0.15, 0.09, -0.02),
    "HEE": (0.11, 0.04, -0.08),
    "TOE": (0.12, 0.04, 0.12),
    "ASIS_study": (0.12, 1.0, 0.1),
    "PSIS_study": (0.05, 1.03, -0.09),
    "HJC_study": (0.09, 0.92, 0.02),
    "knee_study": (0.15, 0.5, 0.02),
    "mknee_study": (0.06, 0.5, 0.02),
    "ankle_study": (0.14, 0.09, -0.02),
    "mankle_study": (0.07, 0.1, -0.02),
    "toe_study": (0.1, 0.03, 0.15),
    "5meta_study": (0.16, 0.02, 0.1),
    "calc_study": (0.11, 0.05, -0.07),
    "shoulder_study": (0.18, 1.48, 0),
    "thigh1_study": (0.17, 0.75, 0.03),
    "thigh2_study": (0.15, 0.65, 0.08),
    "thigh3_study": (0.16, 0.66, -0.03),
    "sh1_study": (0.16, 0.36, 0.0),
    "sh2_study": (0.13, 0.25, 0.05),
    "sh3_study": (0.14, 0.26, -0.05),
    "lelbow_study": (0.28, 1.17, -0.03),
    "melbow_study": (0.21, 1.16, -0.03),
    "lwrist_study": (0.25, 0.94, 0.11),
    "mwrist_study": (0.3, 0.94, 0.05),
    "KJC": (0.085, 0.5, 0.02),
    "AJC": (0.09, 0.095, -0.02),
    "EJC": (0.245, 1.165, -0.03),
    "WJC": (0.275, 0.94, 0.08),
    "ASIS": (0.12, 1.0, 0.1),
    "PSIS": (0.05, 1.03, -0.09),
    "HJC": (0.09, 0.92, 0.02),
    "HJC_reg": (0.09, 0.925, 0.03),
    "Shoulder": (0.18, 1.48, 0),
    "Sternum": (0.03, 1.42, 0.05),
    "mknee": (0.06, 0.5, 0.02),
    "mankle": (0.07, 0.1, -0.02),
    "toe": (0.1, 0.03, 0.15),
    "5meta": (0.16, 0.02, 0.1),
    "calc": (0.11, 0.05, -0.07),
    "elbow_lat": (0.28, 1.17, -0.03),
    "elbow_med": (0.21, 1.16, -0.03),
    "wrist_radius": (0.25, 0.94, 0.11),
    "wrist_ulna": (0.3, 0.94, 0.05),
    "forearm": (0.29, 1.04, 0.02),
    "thigh1": (0.17, 0.75, 0.03),
    "thigh2": (0.15, 0.65, 0.08),
    "thigh3": (0.16, 0.66, -0.03),
    "thigh4": (0.17, 0.6, 0.02),
    "thigh5": (0.17, 0.62, -0.04),
    "sh2": (0.13, 0.25, 0.05),
    "sh3": (0.14, 0.26, -0.05),
    "sh4": (0.16, 0.3, 0.0),
    "shank_antsup": (0.12, 0.4, 0.07),
}


def standing(name):
    """Return the position of a point on the standing person."""
    if name in MIDDLE:
        return np.array(MIDDLE[name])
    for side, sign in (("left", 1), ("right", -1)):
        for part, point in LEFT.items():
            letter = side[0].upper()
            spellings = f"{side}_{part}", f"{part}_{side}", side[0] + part
            if name in (*spellings, letter + part, f"{letter}_{part}", f"{letter}.{part}"):
                return np.array(point) * [sign, 1, 1]
    raise KeyError(name)


def standing_in(layout):
    """Return the position of each point of a layout on the standing person."""
    given = Keypoints([[standing(name) for name in layout.names]], layout.names, 30)
    found = layout.keypoints(given)
    return dict(zip(found.names, found.positions[0], strict=True))


def person(layout):
    """Return the skeleton of the standing person: bones in the axes of the world at rest."""
    bones, at = [], standing_in(layout)
    for name, parent in layout.parents.items():
        offset = np.zeros(3) if parent is None else at[name] - at[parent]
        bones.append(Bone(name, parent, offset, "" if parent is None or name in layout.rigid else "rotvec"))
    return Skeleton(bones)


def moving(layout, n=300, spread=0.25, seed=0):
    """Return positions (n, n_names, 3) in the layout's axes of the person, who moves and turns slowly."""
    rng = np.random.default_rng(seed)
    skeleton = person(layout)
    times = np.linspace(0, 2 * np.pi, n)[:, None]
    angles = sum(
        rng.normal(size=skeleton.n_dofs) * np.sin(k * times + rng.uniform(0, 7, skeleton.n_dofs)) for k in (1, 2, 3, 5)
    )
    found = reference.forward_kinematics(spread / np.sqrt(2) * angles, skeleton)
    heading = Rotation.from_euler("yxz", np.concatenate([times, 0.2 * np.sin(times), 0.1 * np.cos(times)], axis=1))
    found = np.stack([heading.apply(found[:, i]) for i in range(found.shape[1])], axis=1)
    found += np.concatenate([np.cos(times), 0.92 + 0.05 * np.sin(4 * times), np.sin(times)], axis=1)[:, None]
    found = found[:, [skeleton.joint_names.index(name) for name in layout.names]]
    return {"y": found, "z": found[..., [2, 0, 1]], "-y": found * [1.0, -1.0, -1.0]}[layout.up]


def lengths(skeleton):
    """Return the length of each bone by name."""
    return dict(zip(skeleton.joint_names, np.linalg.norm(skeleton.offsets, axis=1), strict=True))


def true_lengths(layout):
    """Return the length of each bone of the standing person by name."""
    at = standing_in(layout)
    return {n: np.linalg.norm(at[n] - at[p]) for n, p in layout.parents.items() if p is not None}


def errors(skeleton, truth):
    """Return relative errors of the lengths by name."""
    found = lengths(skeleton)
    return {name: found[name] / length - 1.0 for name, length in truth.items()}


def one_bone(length, n, noise, seed, change=None):
    """Positions of a rigid bone in all directions, with noise at both ends and a second bone without noise."""
    rng = np.random.default_rng(seed)
    unit = rng.normal(size=(n, 3))
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    length = length if change is None else length * (1.0 + change[:, None])
    joints = np.stack([np.zeros((n, 3)), length * unit, length * unit + [0.0, 1.0, 0.0]], axis=1)
    joints[:, :2] += noise * rng.normal(size=(n, 2, 3))
    return joints


ARM = Layout("arm", ["shoulder", "elbow", "wrist"], {"shoulder": None, "elbow": "shoulder", "wrist": "elbow"})
