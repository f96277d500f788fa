"""Positions of joints that the user gives: frames of joints, of which the truth may lack some, and weights."""

import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from skpose._validation.columns import check_column_names, check_width
from skpose._validation.numbers import as_numbers
from skpose._validation.skeletons import check_skeleton
from skpose._validation.units import extent_of, warn_of_degrees
from skpose._warnings import warn
from skpose.kinematics import forward_kinematics
from skpose.skeleton import Motion, Skeleton

LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
SMALLEST, LARGEST = 0.02, 10.0  # m, between the farthest joints of a frame: from a hand to an animal

ANGLE = re.compile(r".+_(r|rotvec_)[xyz]")  # the name of a dof that is an angle


class Points(NamedTuple):
    """Frames of one or several motions, one after another."""

    true: np.ndarray  # (n_frames, n_joints, 3), zero where a joint is not seen
    pred: np.ndarray  # (n_frames, n_joints, 3)
    seen: np.ndarray  # (n_frames, n_joints) whether the truth has the joint, and the frame can be aligned
    weights: np.ndarray  # (n_frames,)
    lengths: tuple[int, ...]  # frames of each motion
    joint_names: tuple[str, ...] | None

    @property
    def n_joints(self) -> int:
        return self.true.shape[1]


def is_list_of_motions(values: Any) -> bool:
    """Return whether a value is a list of arrays of two or more dimensions; nested lists are an array."""
    return isinstance(values, list | tuple) and bool(values) and all(getattr(one, "ndim", 0) >= 2 for one in values)


def read_points(y_true: Any, y_pred: Any, skeleton: Skeleton | None, sample_weight: Any, data_unit: str) -> Points:
    """Return the frames of truth and prediction, checked."""
    check_data_unit(data_unit, skeleton)
    motions_true, shape = split_motions(y_true, "y_true", skeleton)
    motions_pred, shape_pred = split_motions(y_pred, "y_pred", skeleton)
    if shape != shape_pred:
        raise ValueError(
            f"y_true and y_pred must have equal shapes, frame by frame and joint by joint, got {_shape_text(shape)} "
            f"and {_shape_text(shape_pred)}"
        )
    lengths = tuple(len(motion) for motion in motions_true)
    true, pred = np.concatenate(motions_true), np.concatenate(motions_pred)
    if not len(true):
        raise ValueError("y_true has no frames: a score needs one at least")
    check_predictions(pred, "y_pred")
    seen = ~(np.isnan(true[:, :, 0]) | np.isnan(true[:, :, 1]) | np.isnan(true[:, :, 2]))
    check_finite(true, "y_true")
    if skeleton is None:
        warn_of_unit(true, data_unit)
    if not seen.all():
        true[~seen] = 0.0
    weights = read_weights(sample_weight, lengths, len(shape) == 4 or isinstance(shape[0], tuple))
    return Points(true, pred, seen, weights, lengths, None if skeleton is None else skeleton.joint_names)


def split_motions(values: Any, name: str, skeleton: Skeleton | None) -> tuple[list[np.ndarray], tuple]:
    """Return positions of each motion, (n_frames, n_joints, 3), and the shape of what was given."""
    if is_list_of_motions(values):
        parts = [split_motions(one, f"{name}[{i}]", skeleton) for i, one in enumerate(values)]
        motions = [motion for found, _ in parts for motion in found]
        widths = {motion.shape[1] for motion in motions}
        if len(widths) > 1:
            raise ValueError(f"all motions of {name} must have the same joints, got {sorted(widths)} of them")
        return motions, tuple(shape for _, shape in parts)
    refuse_motions(values, name, skeleton)
    if hasattr(values, "positions") and not hasattr(values, "dtype"):
        raise TypeError(f"{name} must be an array of positions, got {type(values).__name__}: pass {name}.positions")
    if skeleton is not None:
        return _positions_of_poses(values, name, skeleton)
    _refuse_angles(values, name)
    array = as_numbers(values, name)
    shape = array.shape
    if array.ndim == 2 and array.shape[1] == 3:
        raise ValueError(
            f"{name} has shape {shape}, which does not say what a frame is: pass {name}[None] for one frame of "
            f"{shape[0]} joints, {name}[:, None] for {shape[0]} frames of one joint"
        )
    if array.ndim == 2:
        if shape[1] % 3 or not shape[1]:
            raise ValueError(
                f"{name} has {shape[1]} columns, which are not x, y and z of some joints: their number must be a "
                "multiple of three. If they are joint angles, pass skeleton="
            )
        return [array.reshape(len(array), -1, 3)], (shape[0], shape[1] // 3, 3)
    if array.ndim not in (3, 4) or shape[-1] != 3:
        flat = (
            ". Positions in two dimensions are not scored: their unit is that of a picture"
            if shape[-1:] == (2,)
            else ""
        )
        raise ValueError(
            f"{name} must have shape (n_frames, n_joints, 3), (n_frames, 3 n_joints), (n_motions, n_frames, n_joints, "
            f"3), or be a list of motions, got {shape}{flat}"
        )
    if not shape[-2]:
        raise ValueError(f"{name} has no joints, shape {shape}")
    return (list(array) if array.ndim == 4 else [array]), shape


def refuse_motions(values: Any, name: str, skeleton: Skeleton | None) -> None:
    """Refuse a `Motion`, or a list of them, with what to pass: angles alone would be read as positions."""
    first, remedy, of = values, f"{name}.angles", name
    if isinstance(values, list | tuple) and values:
        first, remedy, of = values[0], f"[motion.angles for motion in {name}]", f"{name}[0]"
    if isinstance(first, Motion):
        needed = "" if skeleton is not None else f", with skeleton={of}.skeleton"
        raise TypeError(f"{name} must be arrays, got a Motion, whose numbers are angles: pass {remedy}{needed}")


def _refuse_angles(values: Any, name: str) -> None:
    """Refuse a data frame whose columns are named after angles."""
    columns = getattr(values, "columns", ())
    angles = [str(one) for one in columns if isinstance(one, str) and ANGLE.fullmatch(one)]
    if angles:
        raise ValueError(
            f"{name} must be positions, and {len(angles)} of its {len(columns)} columns are named after joint angles, "
            f"the first {angles[0]!r}: if they are poses, pass skeleton="
        )


def _positions_of_poses(values: Any, name: str, skeleton: Skeleton) -> tuple[list[np.ndarray], tuple]:
    """Return the positions of the joints of poses, NaN in frames without a whole pose."""
    check_column_names(values, skeleton, name)
    poses = as_numbers(values, name)
    poses = poses[:, None] if poses.ndim == 1 and skeleton.n_dofs == 1 else poses
    if poses.ndim not in (2, 3):
        raise ValueError(
            f"{name} must be poses of shape (n_frames, {skeleton.n_dofs}) with a skeleton, got {poses.shape}; "
            "positions need no skeleton="
        )
    flat = poses.reshape(-1, poses.shape[-1])
    check_width(flat, skeleton, name)
    check_finite(flat, name)
    whole = ~np.isnan(flat).any(axis=1)
    warn_of_degrees(**{name: flat[whole]}, in_estimator=True)
    positions = np.full((len(flat), skeleton.n_joints, 3), np.nan)
    positions[whole] = forward_kinematics(flat[whole], skeleton)
    shape = (*poses.shape[:-1], skeleton.n_joints, 3)
    return list(positions.reshape(shape)) if poses.ndim == 3 else [positions], shape


def check_data_unit(data_unit: str, skeleton: Skeleton | None) -> None:
    """Refuse an unknown unit of the data, and one that is not that of positions on a skeleton."""
    check_unit("data_unit", data_unit, tuple(LENGTHS))
    if skeleton is not None:
        check_skeleton(skeleton)
        if data_unit != "m":
            raise ValueError(f"data_unit must be 'm' with a skeleton, whose positions are in m, got {data_unit!r}")


def lengths_of(vectors: np.ndarray) -> np.ndarray:
    """Return the lengths (n_frames, n_joints) of vectors; faster than numpy's norm."""
    return np.sqrt(np.einsum("njk,njk->nj", vectors, vectors))


def check_finite(array: np.ndarray, name: str) -> None:
    """Refuse infinite numbers."""
    infinite = np.isinf(array)
    if infinite.any():
        where = ", ".join(map(str, np.argwhere(infinite)[0]))
        raise ValueError(f"{name} is infinite at [{where}]: use NaN where the truth is not known")


def check_predictions(array: np.ndarray, name: str) -> None:
    """Refuse predictions that are not all there."""
    check_finite(array, name)
    missing = np.isnan(array)
    if missing.any():
        where = ", ".join(map(str, np.argwhere(missing)[0]))
        raise ValueError(
            f"{name} has {missing.sum()} numbers that are NaN, the first at [{where}], and a prediction must be there "
            "for all that is scored: only the truth may lack joints. Leave these frames out of both, or fill them in"
        )


def read_weights(sample_weight: Any, lengths: Sequence[int], by_motion: bool) -> np.ndarray:
    """Return a weight for each frame, from weights of frames, or of motions if several are given."""
    n_frames = int(np.sum(lengths))
    if sample_weight is None:
        return np.ones(n_frames)
    weights = as_numbers(sample_weight, "sample_weight")
    n = len(lengths) if by_motion else n_frames
    what = "motions" if by_motion else "frames"
    if weights.shape != (n,):
        raise ValueError(f"sample_weight must have shape ({n},), one for each of the {what}, got {weights.shape}")
    if not np.isfinite(weights).all() or (weights < 0.0).any():
        raise ValueError("sample_weight must be finite and not negative")
    if not weights.any():
        raise ValueError(f"sample_weight must be somewhere positive, but the weights of all {n} {what} are zero")
    return np.repeat(weights, lengths) if by_motion else weights


def check_unit(name: str, unit: object, units: Sequence[str]) -> None:
    """Refuse a unit that is none of some."""
    if unit not in units:
        raise ValueError(f"{name} must be {' or '.join(map(repr, units))}, got {unit!r}")


def factor_of(data_unit: str, unit: str) -> float:
    """Return the number of units of the score in one unit of the data."""
    check_unit("unit", unit, tuple(LENGTHS))
    return LENGTHS[data_unit] / LENGTHS[unit]


def select_joints(points: Points, joints: Any) -> Points:
    """Return the points of some joints."""
    if joints is None:
        return points
    indices = joint_indices(joints, points, "joints")
    return points._replace(true=points.true[:, indices], pred=points.pred[:, indices], seen=points.seen[:, indices])


def joint_indices(joints: Any, points: Points, name: str) -> list[int]:
    """Return the indices of joints, which are given by index or, with a skeleton, by name; one, or some."""
    given = [joints] if isinstance(joints, str | int | np.integer) else list(joints)
    indices = []
    for one in given:
        if isinstance(one, str):
            if points.joint_names is None:
                raise ValueError(f"{name}={one!r} needs skeleton=, which has names: without it pass the joint's index")
            if one not in points.joint_names:
                raise ValueError(f"{name}={one!r} is no joint of the skeleton: skeleton.joint_names are its joints")
            indices.append(points.joint_names.index(one))
        elif isinstance(one, int | np.integer) and not isinstance(one, bool) and 0 <= one < points.n_joints:
            indices.append(int(one))
        else:
            raise ValueError(f"{name} must be indices from 0 to {points.n_joints - 1} of the joints, got {one!r}")
    if not indices or len(set(indices)) < len(indices):
        raise ValueError(f"{name} must be one joint or several different ones, got {joints!r}")
    return indices


AVERAGES = ("points", "frames", "joints")


def mean_of(values: np.ndarray, points: Points, average: str) -> float:
    """Return the mean of values (n_frames, n_joints) of the points that are seen.

    "points": of all of them; "frames": first over the joints of a frame; "joints": first over the frames of a joint.
    """
    if average not in AVERAGES:
        raise ValueError(f"average must be {' or '.join(map(repr, AVERAGES))}, got {average!r}")
    weights = points.weights[:, None] * points.seen
    if not weights.any():
        raise ValueError("no joint of y_true is seen in a frame of positive weight, so that there is nothing to score")
    if average == "points":
        return float((values * weights).sum() / weights.sum())
    if average == "frames":
        n_seen = points.seen.sum(axis=1)
        some = n_seen > 0
        frames = (values * points.seen).sum(axis=1)[some] / n_seen[some]
        return float(np.average(frames, weights=points.weights[some]))
    totals = weights.sum(axis=0)
    some = totals > 0.0
    return float(((values * weights).sum(axis=0)[some] / totals[some]).mean())


def counts_of(points: Points) -> tuple[int, int]:
    """Return how many points of positive weight are seen, and how many are not."""
    seen = points.seen[points.weights > 0.0]
    return int(seen.sum()), int((~seen).sum())


def warn_of_unit(true: np.ndarray, data_unit: str) -> None:
    size = extent_of(true) * LENGTHS[data_unit]
    if size != 0.0 and not SMALLEST <= size <= LARGEST:
        likely = min(LENGTHS, key=lambda unit: abs(np.log(size / LENGTHS[data_unit] * LENGTHS[unit] / 1.7)))
        remedy = f'if they are in {likely}, pass data_unit="{likely}"' if likely != data_unit else "is that so?"
        warn(f"the joints of y_true are {size:.3g} m apart in the median frame, with data_unit={data_unit!r}: {remedy}")


def _shape_text(shape: tuple) -> str:
    return f"a list of {', '.join(map(str, shape))}" if shape and isinstance(shape[0], tuple) else str(shape)
