"""Scores of arrays of torch, JAX and other libraries, as arrays without axes through which gradients flow.

Numbers are not checked: a score is NaN where its input is, or if no truth is known.
"""

import math
from typing import Any

from skpose.kinematics._arrays import (
    Array,
    Numbers,
    array_orientations,
    array_positions,
    at_least_tiny,
    constant,
    quaternion_of,
    root,
)
from skpose.scores._inputs import Joints, Points, joint_indices, weighted_mean
from skpose.skeleton import Skeleton

SHAPES: dict[str, tuple[int, ...]] = {"matrix": (3, 3), "6d": (6,), "rotvec": (3,)}  # of one rotation, else (4,)


def array_mpjpe(
    xp: Any,
    y_true: Array,
    y_pred: Array,
    roots: Joints | None,
    align: str | None,
    joints: Joints | None,
    average: str | None,
    skeleton: Skeleton | None,
    sample_weight: Any,
) -> Array:
    """`mpjpe` of arrays of another library, in the unit of the data."""
    if align is not None:
        raise ValueError(f"align must be None for arrays of {xp.__name__}, got {align!r}")
    true, pred, weights = _read(xp, y_true, y_pred, (3,) if skeleton is None else (), sample_weight)
    if skeleton is not None:
        unknown = xp.any(xp.isnan(true), axis=1)[:, None]
        true = array_positions(xp, xp.where(unknown, pred, true), skeleton)
        true, pred = xp.where(unknown[..., None], xp.nan, true), array_positions(xp, pred, skeleton)
    seen = xp.logical_not(xp.any(xp.isnan(true), axis=2))
    names = () if skeleton is None else skeleton.joint_names
    points = Points(xp.where(seen[..., None], true, pred), pred, seen, names)
    errors = pred - points.true
    if roots is not None:
        at = joint_indices(roots, points, "root")
        errors = errors - xp.mean(xp.stack([errors[:, i, :] for i in at], axis=0), axis=0)[:, None, :]
        for i in at:
            seen = seen & points.seen[:, i, None]
    lengths = root(xp, xp.sum(errors * errors, axis=2))
    if joints is not None:
        at = joint_indices(joints, points, "joints")
        lengths, seen = (xp.stack([values[:, j] for j in at], axis=1) for values in (lengths, seen))
    return _mean(xp, lengths, seen, weights, average)


def array_geodesic_error(
    xp: Any,
    y_true: Array,
    y_pred: Array,
    form: str,
    frame: str,
    average: str | None,
    skeleton: Skeleton | None,
    sample_weight: Any,
) -> Array:
    """`geodesic_error` of arrays of another library, rad."""
    shape = SHAPES.get(form, (4,)) if skeleton is None else ()
    true, pred, weights = _read(xp, y_true, y_pred, shape, sample_weight)
    unknown = xp.any(xp.isnan(true), axis=-1)
    true = xp.where(unknown[..., None], pred, true)
    if skeleton is None:
        a, b = (_quaternions(xp, numbers, form) for numbers in (true, pred))
    else:
        a, b = (array_orientations(xp, poses, skeleton, frame == "parent") for poses in (true, pred))
        unknown = unknown[:, None]
    minus, plus = (sum((x + sign * y) ** 2 for x, y in zip(a, b, strict=True)) for sign in (-1.0, 1.0))
    nearer, farther = xp.minimum(minus, plus), xp.maximum(minus, plus)
    r = xp.sqrt(at_least_tiny(xp, nearer))
    angles = 4.0 * root(xp, nearer) * (xp.atan2(r, xp.sqrt(farther)) / r)
    return _mean(xp, angles, xp.logical_not(unknown), weights, average)


def _read(
    xp: Any, y_true: Array, y_pred: Array, shape: tuple[int, ...], sample_weight: Any
) -> tuple[Array, Array, Array | None]:
    """Frames (n_frames, n_joints, size) of numbers of a shape, or (n_frames, n_dofs) for none, and their weights."""
    if tuple(y_true.shape) != tuple(y_pred.shape):
        raise ValueError(f"y_true and y_pred must have equal shapes, got {y_true.shape} and {y_pred.shape}")
    n_axes, found = 2 + len(shape), tuple(y_true.shape)
    if len(found) >= n_axes and found[len(found) - len(shape) :] != shape:
        raise ValueError(f"y_true must have shape (n_frames, n_joints, {str(shape)[1:]}, got {found}")
    weights = None if sample_weight is None else constant(xp, sample_weight, y_pred)
    if len(found) > n_axes and weights is not None:  # of motions
        one = xp.ones_like(y_pred[(slice(None), slice(None), *[0] * (n_axes - 1))])
        weights = xp.reshape(weights[:, None] * one, (-1,))
    rows = (-1, found[-1]) if not shape else (-1, found[1 - n_axes], math.prod(shape))
    if len(found) < n_axes:
        rows = (found[0], -1, math.prod(shape))
    return xp.reshape(y_true, rows), xp.reshape(y_pred, rows), weights


def _mean(xp: Any, errors: Array, seen: Array, weights: Array | None, average: str | None) -> Array:
    """`mean_of` of errors (n_frames, n_joints)."""
    if average is None:
        return xp.where(seen, errors, xp.nan)
    one = xp.ones_like(errors)
    counted = xp.where(seen, one if weights is None else one * weights[:, None], 0.0)
    return weighted_mean(xp, errors, counted, weights, average)


def _quaternions(xp: Any, numbers: Array, form: str) -> Numbers:
    """Unit quaternions of rotations, the numbers in any order."""
    if form == "rotvec":
        return quaternion_of(xp, *(numbers[..., i] for i in range(3)))
    if form in ("matrix", "6d"):
        places = (0, 3, 6, 1, 4, 7) if form == "matrix" else range(6)  # of the first two columns
        q: Numbers = _of_columns(xp, *(numbers[..., i] for i in places))
    else:
        q = [numbers[..., i] for i in range(4)]
    length = xp.sqrt(at_least_tiny(xp, sum(x * x for x in q)))
    return [x / length for x in q]


def _of_columns(xp: Any, a: Array, b: Array, c: Array, d: Array, e: Array, f: Array) -> Numbers:
    """Quaternions, not of length one, of the rotations whose matrices begin with two columns, made orthonormal."""
    length = xp.sqrt(at_least_tiny(xp, a * a + b * b + c * c))
    a, b, c = a / length, b / length, c / length
    dot = a * d + b * e + c * f
    d, e, f = d - dot * a, e - dot * b, f - dot * c
    length = xp.sqrt(at_least_tiny(xp, d * d + e * e + f * f))
    d, e, f = d / length, e / length, f / length
    g, h, i = b * f - c * e, c * d - a * f, a * e - b * d
    # Row k is the quaternion times four times its number k: take the row whose number is largest.
    rows = [
        [1.0 + a + e + i, f - h, g - c, b - d],
        [f - h, 1.0 + a - e - i, b + d, c + g],
        [g - c, b + d, 1.0 - a + e - i, f + h],
        [b - d, c + g, f + h, 1.0 - a - e + i],
    ]
    best, largest = rows[0], rows[0][0]
    for k in range(1, 4):
        larger = rows[k][k] > largest
        largest = xp.where(larger, rows[k][k], largest)
        best = [xp.where(larger, x, y) for x, y in zip(rows[k], best, strict=True)]
    return best
