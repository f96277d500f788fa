"""Angles between the two segments of each joint, and of the pelvis in the world.

Rotations are matrices (n, 3, 3) from the axes of the distal segment to the proximal ones. They are taken apart
as Grood and Suntay (1983) do, about the proximal z, then x, then the distal y. With the axes of the ISB these are
flexion, adduction and internal rotation of a right limb. Left ones are mirrored, which reverses the last two.

A limb of positions alone, with no point off its line, shows flexion and adduction by its direction, but not how it
is rotated about itself. Where the next segment is bent, its direction shows that too, if the joint between them is a
hinge, as knee and elbow are.
"""

import numpy as np
from scipy.spatial.transform import Rotation

# Bend of a joint, degrees, that shows the rotation of the segment before it, fully and at all. In
# between a straight limb becomes a bent one without a jump; flexion of a straight limb is measured as if it were not
# rotated, which is off by less than 1° for rotations of 30°.
BENT, STRAIGHT = 15.0, 5.0
# Cosine of the second angle below which the first and the third are one (gimbal lock): within 3° of a right angle.
LOCKED = 0.05
HANGING = 0.05  # sine of the elevation below which an arm has no plane of elevation


def angles_of(rotations: np.ndarray) -> tuple[np.ndarray, ...]:
    """The angles about z, x and y of rotations (n, 3, 3), rad; NaN if undefined."""
    flexion, adduction = direction_angles(rotations[:, :, 1])
    rotation = np.arctan2(-rotations[:, 2, 0], rotations[:, 2, 2])
    return flexion, adduction, np.where(np.isnan(flexion), np.nan, rotation)


def direction_angles(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The angles about z and then x that take up to directions (n, 3), in the axes of the proximal segment."""
    flexion = np.arctan2(-y[:, 0], y[:, 1])
    adduction = np.arcsin(np.clip(y[:, 2], -1.0, 1.0))
    return np.where(np.hypot(y[:, 0], y[:, 1]) < LOCKED, np.nan, flexion), adduction


def pelvis_angles(rotations: np.ndarray) -> tuple[np.ndarray, ...]:
    """Tilt, list and rotation of a pelvis, rotations (n, 3, 3), taken apart about y, x and z (Baker 2001).

    The rotation comes first, so that tilt and list do not depend on the heading.
    """
    tilt = np.arctan2(rotations[:, 1, 0], rotations[:, 1, 1])
    lean = np.arcsin(np.clip(-rotations[:, 1, 2], -1.0, 1.0))
    rotation = np.arctan2(rotations[:, 0, 2], rotations[:, 2, 2])
    is_locked = np.hypot(rotations[:, 0, 2], rotations[:, 2, 2]) < LOCKED
    return np.where(is_locked, np.nan, tilt), lean, np.where(is_locked, np.nan, rotation)


def elevation_angles(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Plane and angle of elevation (Wu 2005) of right arms with y (n, 3), in the axes of the trunk."""
    elevation = np.arctan2(np.hypot(y[:, 0], y[:, 2]), y[:, 1])
    plane = np.arctan2(-y[:, 0], -y[:, 2])
    return np.where(np.hypot(y[:, 0], y[:, 2]) < HANGING, np.nan, plane), elevation


def set_upright(y: np.ndarray) -> np.ndarray:
    """Axes (n, 3, 3) of segments with these y (n, 3) that have no rotation about them, in proximal axes.

    Directions to the side, where flexion is not defined, are taken as adduction alone.
    """
    flexion, adduction = direction_angles(y)
    return np.asarray(Rotation.from_euler("ZX", np.stack([np.nan_to_num(flexion), adduction], axis=1)).as_matrix())


def hinge_rotations(axes: np.ndarray, distal: np.ndarray, sign: float) -> tuple[np.ndarray, np.ndarray]:
    """The rotation of segments about themselves that bends of a hinge show, rad, and the bends, degrees.

    Axes (n, 3, 3) come from `set_upright`, distal (n, 3) the y of the next ones in the same axes. The sign
    is 1 where a bend goes forward, as of an elbow, and -1 where it goes backward.
    """
    y = axes[:, :, 1]
    hinge = sign * np.cross(y, distal)
    rotation = np.arctan2((hinge * axes[:, :, 0]).sum(axis=1), (hinge * axes[:, :, 2]).sum(axis=1))
    return rotation, degrees_between(y, distal)


def degrees_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The angles between vectors (..., 3), degrees."""
    return np.asarray(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(axis=-1))))


def partly(bend: np.ndarray) -> np.ndarray:
    """How far a rotation that a bend (n,) shows counts, from 0 for a straight limb to 1 for a bent one."""
    t = np.clip((bend - STRAIGHT) / (BENT - STRAIGHT), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)
