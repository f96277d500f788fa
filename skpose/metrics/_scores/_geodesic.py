"""The mean angle between predicted and true rotations."""

from typing import Any, Literal, get_args

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._typing import ArrayLike
from skpose._validation.columns import check_column_names, check_width
from skpose._validation.numbers import as_numbers
from skpose._validation.skeletons import check_skeleton
from skpose._validation.units import warn_of_degrees
from skpose.metrics._scores._angles import ANGLES, AngleUnit
from skpose.metrics._scores._mpjpe import Average
from skpose.metrics._scores._points import (
    Points,
    check_finite,
    check_predictions,
    check_unit,
    counts_of,
    is_list_of_motions,
    mean_of,
    read_weights,
    refuse_motions,
)
from skpose.metrics._scores._score import Score, signature_of
from skpose.skeleton import Skeleton
from skpose.skeleton._shared import FORMS, RotationForm, rotations_of

Frame = Literal["parent", "world"]


def geodesic_error(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    *,
    form: RotationForm = "matrix",
    frame: Frame = "parent",
    average: Average = "points",
    unit: AngleUnit = "deg",
    skeleton: Skeleton | None = None,
    sample_weight: ArrayLike | None = None,
) -> Score:
    r"""Return the mean geodesic distance of predicted and true rotations.

    The angle of the rotation from one to the other, the length of the shortest path in SO(3) [1]_, averaged over joints
    and frames:

    .. math:: \varphi = \| \log(R^\top \hat R) \| = \arccos \frac{\operatorname{tr}(R^\top \hat R) - 1}{2}

    It is at most 180°, and does not depend on how rotations are written.

    Parameters
    ----------
    y_true : array-like of shape (n_frames, n_joints, ...)
        True rotations; also (n_frames, n_joints * n_numbers), as regressors have them, or a list of motions. With a
        skeleton poses, of shape (n_frames, n_dofs), rad. Rotations with NaN are left out, and counted in the result.
    y_pred : as y_true
        Predicted rotations, of the same shape. NaN is refused.
    form : {"quaternion_wxyz", "quaternion_xyzw", "matrix", "6d", "rotvec"}, default="matrix"
        What the last axes are, see `poses_from_rotations`. Predicted numbers that are not exactly a rotation have
        one in "6d" and in "rotvec" only.
    frame : {"parent", "world"}, default="parent"
        With a skeleton, whether rotations are relative to the joint's parent, of joints that have dofs, or to the root,
        of all joints. Rotations that are given are compared as they are.
    average : {"points", "frames", "joints"}, default="points"
        What is averaged first, see `mpjpe`.
    unit : {"deg", "rad"}, default="deg"
        Unit of the result.
    skeleton : Skeleton, default=None
        The skeleton of poses; None is rotations.
    sample_weight : array-like of shape (n_frames,), default=None
        Weights of the frames.

    Returns
    -------
    Score
        The error; the counts are of rotations.

    Raises
    ------
    ValueError
        For shapes that differ, also of the motions of lists; for predictions that are NaN; for numbers that are no
        rotation in the form, see `poses_from_rotations`; for an unknown unit or option.

    Warns
    -----
    UserWarning
        If poses or rotation vectors look like degrees.

    See Also
    --------
    mean_angle_error : Of angles.
    Rotation : A distance between poses by the rotations of their bones, weighted by their lengths.

    Notes
    -----
    By quaternions, exact to rounding also for small angles, where the arccosine has errors of 1e-8 rad. 100,000 frames
    of 17 joints take about a second.

    References
    ----------
    .. [1] D. Q. Huynh, "Metrics for 3D rotations: comparison and analysis", Journal of Mathematical Imaging and Vision
       35, 2009, :doi:`10.1007/s10851-009-0161-2`, the metric Φ6.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose.metrics import geodesic_error
    >>> true, pred = np.zeros((1, 2, 3)), np.array([[[0.0, 0.0, 0.5], [0.0, 0.3, 0.0]]])  # rotation vectors, rad
    >>> geodesic_error(true, pred, form="rotvec", unit="rad")
    Score(0.4, 'Geodesic|rad|form=rotvec', 2 counted)
    """
    check_unit("unit", unit, tuple(ANGLES))
    check_unit("form", form, get_args(RotationForm))
    check_unit("frame", frame, get_args(Frame))
    refuse_motions(y_true, "y_true", skeleton)
    refuse_motions(y_pred, "y_pred", skeleton)
    _check_lengths(y_true, y_pred)
    if skeleton is None and frame == "world":
        raise ValueError("frame='world' needs skeleton= and poses: rotations are compared as they are given")
    if skeleton is not None:
        check_skeleton(skeleton)
        true, seen = _of_poses(y_true, "y_true", skeleton, frame)
        pred, there = _of_poses(y_pred, "y_pred", skeleton, frame)
    else:
        true, seen = _of_numbers(y_true, "y_true", form)
        pred, there = _of_numbers(y_pred, "y_pred", form)
    if seen.shape != there.shape:
        raise ValueError(
            f"y_true and y_pred must have equal shapes, got {seen.shape} and {there.shape} frames and joints"
        )
    weights = read_weights(sample_weight, [len(seen)], False)
    angles = np.zeros(seen.shape)
    both = seen.ravel()
    angles.ravel()[both] = _between(true.as_quat()[both], pred.as_quat()[both])
    nothing = np.zeros((*seen.shape, 0))
    points = Points(nothing, nothing, seen, weights, (len(seen),), None)
    value = mean_of(angles, points, average) / ANGLES[unit]
    words = (f"frame={frame}",) if skeleton is not None else (f"form={form}",)
    signature = signature_of("Geodesic", unit, {"average": (average, "points")}, words)
    return Score(value, signature, *counts_of(points))


def _between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the angles, rad, between rotations as unit quaternions (n, 4).

    On the sphere of quaternions, half the angle lies between a and b, or a and −b, a chord and its complement.
    """
    chords = [np.sqrt(np.einsum("nk,nk->n", gap, gap)) for gap in (a - b, a + b)]
    return 4.0 * np.arctan2(np.minimum(*chords), np.maximum(*chords))


def _check_lengths(y_true: Any, y_pred: Any) -> None:
    """Refuse motions of which one is not as long as the other."""
    true, pred = ([len(one) for one in values] if is_list_of_motions(values) else None for values in (y_true, y_pred))
    if (true is None) != (pred is None):
        raise ValueError("y_true and y_pred must both be lists of motions, or both arrays")
    if true != pred:
        raise ValueError(
            f"y_true and y_pred must be equal motions, frame by frame, got lists of motions of {_list(true)} and "
            f"{_list(pred)} frames"
        )


def _list(lengths: list[int] | None) -> str:
    return ", ".join(map(str, lengths or []))


def _join(values: Any, name: str) -> np.ndarray:
    """Return the frames of an array, or of all motions of a list."""
    if not is_list_of_motions(values):
        return as_numbers(values, name)
    arrays = [as_numbers(one, f"{name}[{i}]") for i, one in enumerate(values)]
    shapes = sorted({one.shape[1:] for one in arrays})
    if len(shapes) > 1:
        raise ValueError(f"all motions of {name} must have the same columns, got frames of shapes {shapes}")
    return np.concatenate(arrays)


def _of_numbers(values: Any, name: str, form: str) -> tuple[Rotation, np.ndarray]:
    """Return rotations (n_frames * n_joints,), and whether each (n_frames, n_joints) is known."""
    known = FORMS[form]
    array = _join(values, name)
    size = int(np.prod(known.shape))
    if array.ndim == 2 and array.shape[1] and array.shape[1] % size == 0:
        array = array.reshape(len(array), -1, *known.shape)
    if array.ndim != 2 + len(known.shape) or array.shape[2:] != known.shape or not array.size:
        shape = ", ".join(map(str, ("n_frames", "n_joints", *known.shape)))
        raise ValueError(
            f"{name} must have shape ({shape}) or (n_frames, {size} n_joints) for form {form!r}, got {array.shape}"
        )
    flat = np.array(array.reshape(-1, *known.shape), dtype=np.float64)
    if name == "y_pred":
        check_predictions(array, name)
    check_finite(array, name)
    seen = np.asarray(~np.isnan(flat.reshape(len(flat), -1)).any(axis=1))
    if not seen.any():
        raise ValueError(f"all rotations of {name} are NaN, so that there is nothing to score")
    if form == "rotvec":
        angles = np.where(seen[:, None], flat, 0.0).reshape(len(array), -1)
        warn_of_degrees(**{name: angles}, in_estimator=True)
    flat[~seen] = flat[seen.argmax()]  # a rotation, which is not counted

    def refuse(bad: np.ndarray, expected: str) -> None:
        bad = bad & seen
        if bad.any():
            where, joint = divmod(int(bad.argmax()), array.shape[1])
            remedy = "" if form in ("6d", "rotvec") else '; form="6d" and form="rotvec" take other numbers too'
            raise ValueError(f"{name}[{where}, {joint}] {expected}, to three digits{remedy}")

    return known.read(flat, refuse), seen.reshape(array.shape[:2])


def _of_poses(values: Any, name: str, skeleton: Skeleton, frame: str) -> tuple[Rotation, np.ndarray]:
    """Return rotations (n_frames * n_joints,) of the joints of poses, and whether each is known."""
    if is_list_of_motions(values):
        for i, one in enumerate(values):
            check_column_names(one, skeleton, f"{name}[{i}]")
    else:
        check_column_names(values, skeleton, name)
    poses = _join(values, name)
    poses = poses[:, None] if poses.ndim == 1 and skeleton.n_dofs == 1 else poses
    if poses.ndim != 2 or not len(poses):
        raise ValueError(
            f"{name} must be poses of shape (n_frames, {skeleton.n_dofs}) with a skeleton, got {poses.shape}"
        )
    check_width(poses, skeleton, name)
    if name == "y_pred":
        check_predictions(poses, name)
    check_finite(poses, name)
    seen = ~np.isnan(poses).any(axis=1)
    warn_of_degrees(**{name: poses[seen]}, in_estimator=True)
    poses[~seen] = 0.0
    axes: list[Rotation] = []
    own: list[Rotation] = []
    column = 0
    for bone, parent, rest in zip(skeleton.bones, skeleton.parents, skeleton.rest_rotations, strict=True):
        rotation = Rotation.identity(len(poses))
        if bone.dofs:
            rotation = rotations_of(bone, poses[:, column : column + bone.n_dofs])
            own.append(rotation)
        column += bone.n_dofs
        before = Rotation.identity(len(poses)) if parent < 0 else axes[int(parent)]
        axes.append(before * Rotation.from_matrix(rest.copy()) * rotation)
    chosen = own if frame == "parent" else axes
    quaternions = np.stack([rotation.as_quat() for rotation in chosen], axis=1)
    return Rotation.from_quat(quaternions.reshape(-1, 4)), np.repeat(seen[:, None], len(chosen), axis=1)
