"""Alignment of predicted joints with the true ones, frame by frame: by a root, a scale, or Procrustes analysis.

Least squares over the joints that are seen, with p the predicted and t the true positions of a frame, both minus their
means: the rotation R = U S Vᵀ of the singular values D of Σ t pᵀ = U D Vᵀ, with S = diag(1, 1, ±1) so that det R = 1,
and the scale tr(D S) / Σ ‖p‖² (S. Umeyama, 1991, doi:10.1109/34.88573, eqs. 40 to 43).
"""

import numpy as np

from skpose.scores._inputs import Joints, Points, joint_indices

AT_ONCE = 1 << 14  # frames, to limit memory
LINE = 1e-8  # ratio of singular values below which a rotation is not determined
POINT = 1e-10  # size of a set of points, relative to its distance from the origin, below which they are one point


def align(points: Points, root: Joints | None, how: str | None, reflection: bool) -> Points:
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
        frame = start + (bad & some).argmax()
        raise ValueError(f"the rotation of frame {frame} is not determined: it needs three joints not on a line")
    U[:, :, 2] *= sign[:, None]
    aligned = np.matmul(p, np.matmul(U, Vt))
    if with_scale:
        scale = D[:, 0] + D[:, 1] + sign * D[:, 2]
        aligned *= np.divide(scale, squares, out=np.ones_like(scale), where=some)[:, None, None]
    aligned += middle_true[:, None]
    return aligned
