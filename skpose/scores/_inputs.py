"""What scores take: positions, poses, rotations or other columns, of one motion or several, and their weights."""

import re
from typing import Any, Literal, NamedTuple

import numpy as np

from skpose._utils.sklearn import StrOptions, check_sample_weight
from skpose._utils.typing import ArrayLike
from skpose._utils.units import extent_of, warn_of_degrees
from skpose._utils.validation import as_numbers, check_column_names, check_width
from skpose._utils.warnings import warn
from skpose.kinematics import forward_kinematics
from skpose.skeleton import Skeleton

Length = Literal["m", "cm", "mm"]
AngleUnit = Literal["rad", "deg"]
Joints = int | str | list[int] | list[str]

LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
ANGLES = {"rad": 1.0, "deg": float(np.pi / 180.0)}
SMALLEST, LARGEST = 0.02, 10.0  # m, between the farthest joints of a frame: from a hand to an animal
ANGLE_NAME = re.compile(r".+_(r|rotvec_)[xyz]")  # of a column that is an angle

# Constraints of the parameters that scores of positions share.
CONSTRAINTS: dict[str, list] = {
    "align": [StrOptions(["scale", "rigid", "similarity"]), None],
    "reflection": ["boolean"],
    "average": [StrOptions(["points", "frames", "joints"]), None],
    "unit": [StrOptions(LENGTHS)],
    "data_unit": [StrOptions(LENGTHS)],
    "skeleton": [Skeleton, None],
}


class Motions(NamedTuple):
    """The frames of one or several motions, one motion after another."""

    frames: np.ndarray  # (n_frames, ...)
    lengths: tuple[int, ...]  # number of frames of each motion
    several: bool  # whether several motions could be passed

    def split(self, frames: np.ndarray | None = None) -> list[np.ndarray]:
        """The frames of each motion, or other rows in their order."""
        return np.split(self.frames if frames is None else frames, np.cumsum(self.lengths)[:-1])


def read_motions(values: ArrayLike, name: str, n_axes: int, skeleton: Skeleton | None = None) -> Motions:
    """Read one motion, or several as a list or as an array with more than `n_axes` axes."""
    is_list = isinstance(values, list | tuple) and bool(values) and all(getattr(one, "ndim", 0) >= 2 for one in values)
    several = is_list or (not hasattr(values, "columns") and np.ndim(values) > n_axes)
    arrays = []
    for i, one in enumerate(values if several else [values]):  # type: ignore[arg-type]
        label = f"{name}[{i}]" if several else name
        if skeleton is not None:
            check_column_names(one, skeleton, label)
        arrays.append(as_numbers(one, label))
    frames = np.concatenate(arrays)
    if not frames.size or not all(map(len, arrays)):
        raise ValueError(f"{name} must have at least one frame in each motion, got shape {frames.shape}")
    if np.isinf(frames).any():
        raise ValueError(f"{name} must be finite, or NaN where the truth is unknown")
    if name == "y_pred" and np.isnan(frames).any():
        raise ValueError(f"y_pred must not contain NaN, got {np.isnan(frames).sum()}: only y_true may")
    return Motions(frames, tuple(map(len, arrays)), several)


def read_positions(values: ArrayLike, name: str, skeleton: Skeleton | None) -> Motions:
    """Read positions (n_frames, n_joints, 3), or poses if there is a skeleton; NaN where they are unknown."""
    if skeleton is not None:
        motions = read_poses(values, name, skeleton)
        known = ~np.isnan(motions.frames).any(axis=1)
        positions = np.full((len(known), skeleton.n_joints, 3), np.nan)
        positions[known] = forward_kinematics(motions.frames[known], skeleton)
        return motions._replace(frames=positions)
    if any(ANGLE_NAME.fullmatch(str(column)) for column in getattr(values, "columns", ())):
        raise ValueError(f"the columns of {name} are named after joint angles: pass skeleton=")
    motions = read_motions(values, name, 3)
    shape = motions.frames.shape
    if len(shape) == 2 and shape[1] > 3 and shape[1] % 3 == 0:
        return motions._replace(frames=motions.frames.reshape(len(motions.frames), -1, 3))
    if len(shape) != 3 or shape[2] != 3:
        raise ValueError(f"{name} must have shape (n_frames, n_joints, 3) or (n_frames, 3 n_joints), got {shape}")
    return motions


def read_poses(values: ArrayLike, name: str, skeleton: Skeleton) -> Motions:
    """Read poses (n_frames, n_dofs)."""
    motions = read_motions(values, name, 2, skeleton)
    if motions.frames.ndim == 1:  # of one column
        motions = motions._replace(frames=motions.frames[:, None])
    check_width(motions.frames, skeleton, name)
    warn_of_degrees(**{name: motions.frames[~np.isnan(motions.frames).any(axis=1)]}, in_estimator=True)
    return motions


def read_columns(values: ArrayLike, name: str, allows_vector: bool = True) -> Motions:
    """Read other columns (n_frames, n_columns), such as the coordinates of joints; a vector is one column."""
    motions = read_motions(values, name, 2)
    if motions.frames.ndim == 1 and not allows_vector:
        raise ValueError(f"{name} must have shape (n_frames, n_columns), got {motions.frames.shape}")
    if getattr(values, "shape", ())[2:] == (3,):  # motions of three columns, or frames of joints
        raise ValueError(f"{name} of shape {values.shape} is ambiguous: pass a list of motions")  # type: ignore[union-attr]
    return motions._replace(frames=motions.frames.reshape(len(motions.frames), -1))


def check_equal(true: Motions, pred: Motions) -> None:
    if true.frames.shape != pred.frames.shape or true.lengths != pred.lengths:
        raise ValueError(
            "y_true and y_pred must have equal shapes, also of each motion, "
            f"got {true.frames.shape} and {pred.frames.shape}"
        )


def read_weights(sample_weight: ArrayLike | None, motions: Motions) -> np.ndarray:
    """A weight for each frame, from weights of frames, or of motions if there can be several."""
    if motions.several:
        return np.repeat(check_sample_weight(sample_weight, np.empty((len(motions.lengths), 1))), motions.lengths)
    return check_sample_weight(sample_weight, motions.frames)


class Points(NamedTuple):
    """True and predicted positions."""

    true: np.ndarray  # (n_frames, n_joints, 3), zero where a joint is not seen
    pred: np.ndarray  # (n_frames, n_joints, 3)
    seen: np.ndarray  # (n_frames, n_joints), whether the true position is known, and the frame can be aligned
    joint_names: tuple[str, ...]  # empty without a skeleton


def read_errors(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    skeleton: Skeleton | None,
    sample_weight: ArrayLike | None,
    data_unit: str,
    root: Joints | None,
    how: str | None,
    reflection: bool,
    joints: Joints | None,
) -> tuple[np.ndarray, np.ndarray, Motions]:
    """Errors (n_frames, n_joints, 3) of aligned positions, NaN where a joint is not seen; weights of the frames.

    Also the motions of the truth.
    """
    true, pred = read_positions(y_true, "y_true", skeleton), read_positions(y_pred, "y_pred", skeleton)
    check_equal(true, pred)
    check_length_unit(true.frames, skeleton, data_unit)
    points = align_points(points_of(true.frames, pred.frames, skeleton), root, how, reflection)
    errors = points.pred - points.true
    errors[~points.seen] = np.nan
    if joints is not None:
        errors = errors[:, joint_indices(joints, points, "joints")]
    return errors, read_weights(sample_weight, true), true


def points_of(true: np.ndarray, pred: np.ndarray, skeleton: Skeleton | None) -> Points:
    seen = ~np.isnan(true).any(axis=2)
    return Points(np.where(seen[:, :, None], true, 0.0), pred, seen, () if skeleton is None else skeleton.joint_names)


def check_data_unit(skeleton: Skeleton | None, data_unit: str) -> None:
    if skeleton is not None and data_unit != "m":
        raise ValueError(f"data_unit must be 'm' with a skeleton, got {data_unit!r}")


def check_length_unit(true: np.ndarray, skeleton: Skeleton | None, data_unit: str) -> None:
    """Refuse another unit than m with a skeleton, and warn if positions seem to have another unit."""
    check_data_unit(skeleton, data_unit)
    size = extent_of(true) * LENGTHS[data_unit]
    if skeleton is None and size != 0.0 and not SMALLEST <= size <= LARGEST:
        warn(f"the joints of y_true are {size:.3g} m apart with data_unit={data_unit!r}: check the unit")


def joint_indices(joints: Joints, points: Points, name: str) -> list[int]:
    """Indices of joints that are given by index or, with a skeleton, by name."""
    given = [joints] if isinstance(joints, str | int | np.integer) else list(joints)
    n_joints = points.true.shape[1]
    known = dict(zip(points.joint_names, range(n_joints), strict=False)) | {i: i for i in range(n_joints)}
    indices = [known[one] for one in given if one in known]
    if not given or len(set(indices)) < len(given):
        raise ValueError(f"{name} must be different joints, by index or with skeleton= by name, got {joints!r}")
    return indices


def lengths_of(errors: np.ndarray) -> np.ndarray:
    return np.sqrt(np.einsum("njk,njk->nj", errors, errors))


def mean_of(errors: np.ndarray, weights: np.ndarray, average: str | None) -> Any:
    """Weighted mean of errors (n_frames, n_joints), NaN where they do not count; None for the errors themselves."""
    if average is None:
        return errors
    seen = ~np.isnan(errors)
    counted = weights[:, None] * seen
    if not counted.any():
        raise ValueError("y_true must have a known value in a frame of positive weight")
    return float(weighted_mean(np, np.where(seen, errors, 0.0), counted, weights, average))


def weighted_mean(xp: Any, errors: Any, counted: Any, weights: Any, average: str) -> Any:
    """The mean of errors (n_frames, n_joints), arrays of numpy or of another library, that count with some weights.

    "points": of all of them; "frames": first over the joints of each frame; "joints": first over the frames of each
    joint. The weights of the frames are None if they are equal.
    """
    axis = {"points": None, "frames": 1, "joints": 0}[average]
    totals = xp.sum(counted, axis=axis)
    means = xp.sum(errors * counted, axis=axis) / xp.where(totals > 0.0, totals, 1.0)
    shares = xp.where(totals > 0.0, xp.ones_like(totals), 0.0)
    if average == "frames" and weights is not None:
        shares = shares * weights
    return xp.sum(means * shares) / xp.sum(shares)


# --- align ------------------------------------------------------------------------------------------------------------
# Alignment of predicted joints with the true ones, frame by frame: by a root, a scale, or Procrustes analysis.
#
# Least squares over the joints that are seen, with p the predicted and t the true positions of a frame, both minus
# their means: the rotation R = U S Vᵀ of the singular values D of Σ t pᵀ = U D Vᵀ, with S = diag(1, 1, ±1) so that
# det R = 1, and the scale tr(D S) / Σ ‖p‖² (S. Umeyama, 1991, doi:10.1109/34.88573, eqs. 40 to 43).


AT_ONCE = 1 << 14  # frames, to limit memory
LINE = 1e-8  # ratio of singular values below which a rotation is not determined
POINT = 1e-10  # size of a set of points, relative to its distance from the origin, below which they are one point


def align_points(points: Points, root: Joints | None, how: str | None, reflection: bool) -> Points:
    """Positions relative to the root, with the predicted ones aligned."""
    if reflection and how not in ("rigid", "similarity"):
        raise ValueError(f"reflection=True needs align='rigid' or 'similarity', got align={how!r}")
    if root is not None:
        points = _subtract_root(points, root)
    if how is None:
        return points
    pred = np.empty_like(points.pred)
    for start in range(0, len(pred), AT_ONCE):
        part = slice(start, start + AT_ONCE)
        frames = points.true[part], points.pred[part], points.seen[part], start
        pred[part] = _scale(*frames) if how == "scale" else _procrustes(*frames, how == "similarity", reflection)
    return points._replace(pred=pred)


def _subtract_root(points: Points, root: Joints) -> Points:
    """Positions relative to a joint, or to the middle of several; frames without it are not seen."""
    indices = joint_indices(root, points, "root")
    true, pred = (array - array[:, indices].mean(axis=1, keepdims=True) for array in (points.true, points.pred))
    seen = points.seen & points.seen[:, indices].all(axis=1, keepdims=True)
    true[~seen] = 0.0
    return points._replace(true=true, pred=pred, seen=seen)


def _scale(true: np.ndarray, pred: np.ndarray, seen: np.ndarray, start: int) -> np.ndarray:
    """Predictions times the scale of least squares, about the origin."""
    counted = pred * seen[:, :, None]
    squares = (counted * counted).sum(axis=(1, 2))
    zero = (squares == 0.0) & seen.any(axis=1)
    if zero.any():
        raise ValueError(f"frame {start + zero.argmax()} of y_pred cannot be scaled: all joints are at the origin")
    products = (counted * true).sum(axis=(1, 2))
    scale = np.divide(products, squares, out=np.ones_like(products), where=squares > 0.0)
    return pred * scale[:, None, None]


def _procrustes(
    true: np.ndarray, pred: np.ndarray, seen: np.ndarray, start: int, with_scale: bool, reflection: bool
) -> np.ndarray:
    """Predictions (n, n_joints, 3) moved, rotated and scaled to the true ones; `start` is the first frame's number."""
    n_seen = seen.sum(axis=1)
    some = n_seen > 0
    mask, count = seen.astype(np.float64), np.maximum(n_seen, 1)[:, None]
    middle_true, middle_pred = (np.matmul(mask[:, None], points)[:, 0] / count for points in (true, pred))
    t, p = true - middle_true[:, None], pred - middle_pred[:, None]
    counted = p
    if not seen.all():
        t, counted = t * mask[:, :, None], p * mask[:, :, None]
    squares_true, squares = (np.einsum("njk,njk->n", points, points) for points in (t, counted))
    U, D, Vt = np.linalg.svd(np.matmul(counted.transpose(0, 2, 1), t))
    sign = np.ones(len(D)) if reflection else np.sign(np.linalg.det(U) * np.linalg.det(Vt))
    bad = (n_seen < 3) | (D[:, 1] + sign * D[:, 2] <= LINE * D[:, 0])  # the second also if the rotation is ambiguous
    for size, middle in ((squares_true, middle_true), (squares, middle_pred)):
        bad |= size <= (POINT * np.abs(middle).max(axis=1)) ** 2
    if (bad & some).any():
        raise ValueError(
            f"the rotation of frame {start + (bad & some).argmax()} is not determined: it needs three joints not on a "
            "line"
        )
    U[:, :, 2] *= sign[:, None]
    aligned = np.matmul(p, np.matmul(U, Vt))
    if with_scale:
        scale = D[:, 0] + D[:, 1] + sign * D[:, 2]
        aligned *= np.divide(scale, squares, out=np.ones_like(scale), where=some)[:, None, None]
    aligned += middle_true[:, None]
    return aligned
