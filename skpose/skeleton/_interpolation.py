"""Interpolation of poses: joints with three dofs rotate by the smallest angle, other angles change linearly."""

from collections.abc import Sequence

import numpy as np

from skpose.skeleton._bone import Bone, are_slides, with_columns
from skpose.skeleton._rotations import TWO_PI, columns_of, rotations_of


def interpolate_poses(
    bones: Sequence[Bone], poses: np.ndarray, at: np.ndarray, literal: np.ndarray | None = None
) -> np.ndarray:
    """Poses (n, n_dofs) at rows, not necessarily whole, of others (n_poses, n_dofs); whole rows are kept.

    The rotation of a ball joint, or of one with three Euler angles, is the slerp between two rows, as numbers near the
    row before. Other angles change linearly along their difference wrapped to [−π, π], and slides linearly.

    Some numbers may be `literal`, an array (n_dofs,) or (n_poses, n_dofs) of bool: two of these change linearly within
    their range, not exceeding it even by rounding. A joint with any literal number does not slerp.
    """
    literal = np.broadcast_to(are_slides(bones) if literal is None else are_slides(bones) | literal, poses.shape)
    start, end, part = _rows_around(poses, at)
    before, after, _ = _rows_around(literal, at)
    # Parts are less than one, so the product rounds to less than the difference, and the sum not past the end.
    between = np.where(
        before & after, interpolate_values(start, end, part, 0.0), interpolate_values(start, end, part, TWO_PI)
    )
    moved = (part[:, 0] > 0.0) & (start != end).any(axis=1)
    for bone, columns in with_columns(bones):
        if bone.n_dofs == 3 and moved.any() and not literal[:, columns].any():
            p, q = rotations_of(bone, start[moved, columns]), rotations_of(bone, end[moved, columns])
            turned = p * type(p).from_rotvec(part[moved] * (p.inv() * q).as_rotvec())
            between[moved, columns] = columns_of(bone, turned, start[moved, columns])
    return between


def interpolate_linearly(values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Values (n, k) at rows that need not be whole."""
    return interpolate_values(*_rows_around(values, at), 0.0)


def _rows_around(values: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The rows before and after, and the position in between (n, 1) from 0 to 1."""
    before = np.minimum(at.astype(np.intp), max(len(values) - 1, 0))
    after = np.minimum(before + 1, len(values) - 1)
    return values[before], values[after], (at - before)[:, None]


def straight_line(
    bones: Sequence[Bone], start: np.ndarray, end: np.ndarray, n_poses: int, period: float = 0.0
) -> np.ndarray:
    """Poses on the line of "spatial": slerp of ball joints, angles linearly, wrapped if there is a period."""
    parts = np.linspace(0.0, 1.0, n_poses)
    line = interpolate_values(start, end, parts[:, None], period) if period else np.linspace(start, end, n_poses)
    line[:, are_slides(bones)] = np.linspace(start, end, n_poses)[:, are_slides(bones)]
    turned = interpolate_poses(bones, np.stack([start, end]), parts)
    is_ball = np.repeat([bone.is_ball for bone in bones], [bone.n_dofs for bone in bones])
    line[:, is_ball] = turned[:, is_ball]
    return line


def interpolate_values(start: np.ndarray, end: np.ndarray, part: np.ndarray, period: float) -> np.ndarray:
    """Values between others, their difference wrapped if there is a period."""
    gap = end - start
    return start + part * (gap - period * np.rint(gap / period) if period else gap)
