"""Poses between poses: joints with three dofs rotate by the smallest angle, other angles change linearly."""

from collections.abc import Sequence

import numpy as np

from skpose.skeleton._bone import Bone, are_slides
from skpose.skeleton._rotations import TWO_PI, columns_of, rotations_of


def interpolate_poses(
    bones: Sequence[Bone], poses: np.ndarray, at: np.ndarray, literal: np.ndarray | None = None
) -> np.ndarray:
    """Return poses (n, n_dofs) at rows of others, (n_poses, n_dofs), which need not be whole; whole rows are kept.

    The rotation of a ball joint, or of one with three Euler angles, is the slerp between two rows, as numbers near the
    row before. Other angles change linearly along their difference wrapped to [−π, π], and slides as they are.

    Some numbers may be `literal`, an array (n_dofs,) or (n_poses, n_dofs) of bool: two such numbers change linearly,
    and what is between them never leaves their range, not by rounding either. A joint that has any does not slerp.
    """
    start, end, part = _rows_around(poses, at)
    between = interpolate_values(start, end, part, TWO_PI)
    slides = are_slides(bones)
    if slides.any():
        literal = slides if literal is None else slides | literal
    if literal is not None:
        literal = np.broadcast_to(literal, poses.shape)
        before, after, _ = _rows_around(literal, at)
        # Parts are less than one: then the product rounds to less than the difference, and the sum not past the end.
        between = np.where(before & after, interpolate_values(start, end, part, 0.0), between)
    moved = (part[:, 0] > 0.0) & (start != end).any(axis=1)
    first = 0
    for bone in bones:
        columns = slice(first, first + bone.n_dofs)
        first += bone.n_dofs
        if bone.n_dofs < 3 or not moved.any() or (literal is not None and literal[:, columns].any()):
            continue
        p, q = rotations_of(bone, start[moved, columns]), rotations_of(bone, end[moved, columns])
        turned = p * type(p).from_rotvec(part[moved] * (p.inv() * q).as_rotvec())
        between[moved, columns] = columns_of(bone, turned, start[moved, columns])
    return between


def interpolate_linearly(values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return values (n, k) at rows of others, which need not be whole."""
    return interpolate_values(*_rows_around(values, at), 0.0)


def _rows_around(values: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the rows before and after, and how far in between (n, 1) from 0 to 1."""
    before = np.minimum(at.astype(np.intp), max(len(values) - 1, 0))
    after = np.minimum(before + 1, len(values) - 1)
    return values[before], values[after], (at - before)[:, None]


def straight_line(
    bones: Sequence[Bone], start: np.ndarray, end: np.ndarray, n_poses: int, period: float = 0.0
) -> np.ndarray:
    """Return poses on the line of "spatial": slerp of ball joints, angles linearly, wrapped where there is a period."""
    parts = np.linspace(0.0, 1.0, n_poses)
    line = interpolate_values(start, end, parts[:, None], period) if period else np.linspace(start, end, n_poses)
    line[:, are_slides(bones)] = np.linspace(start, end, n_poses)[:, are_slides(bones)]
    turned = interpolate_poses(bones, np.stack([start, end]), parts)
    is_ball = np.repeat([bone.is_ball for bone in bones], [bone.n_dofs for bone in bones])
    line[:, is_ball] = turned[:, is_ball]
    return line


def interpolate_values(start: np.ndarray, end: np.ndarray, part: np.ndarray, period: float) -> np.ndarray:
    """Return values between others, their difference wrapped where there is a period."""
    gap = end - start
    return start + part * (gap - period * np.rint(gap / period) if period else gap)
