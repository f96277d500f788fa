"""The error of joints along the path of dynamic time warping."""

from typing import Any, Literal

import numpy as np

from skpose._compiled.warping.paths import Paths, accumulate, path_to
from skpose._utils.sklearn import StrOptions, check_sample_weight, validate_params
from skpose._utils.typing import ArrayLike
from skpose.scores._inputs import (
    CONSTRAINTS,
    LENGTHS,
    Joints,
    Length,
    Points,
    align_points,
    check_length_unit,
    joint_indices,
    points_of,
    read_positions,
)
from skpose.scores._mpjpe import Align
from skpose.skeleton import Skeleton

Cost = Literal["joints", "norm", "l1"]
COSTS = "joints", "norm", "l1"
AT_ONCE = 1 << 20  # distances of joints in memory


@validate_params(
    {name: CONSTRAINTS[name] for name in ("align", "unit", "data_unit", "skeleton")}
    | {
        "cost": [StrOptions(COSTS)],
        "error": [StrOptions(COSTS), None],
        "divide": [StrOptions(["path", "true"]), None],
        "warp": [StrOptions(["pose", "joint"])],
        "average": [StrOptions(["motions", "pairs"]), None],
    },
    prefer_skip_nested_validation=True,
)
def dtw_mje(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    *,
    cost: Cost = "joints",
    error: Cost | None = None,
    divide: Literal["path", "true"] | None = "path",
    warp: Literal["pose", "joint"] = "pose",
    root: Joints | None = None,
    align: Align | None = None,
    joints: Joints | None = None,
    average: Literal["motions", "pairs"] | None = "motions",
    unit: Length = "mm",
    data_unit: Length = "m",
    skeleton: Skeleton | None = None,
    sample_weight: ArrayLike | None = None,
) -> Any:
    r"""Mean joint error of motions after dynamic time warping (DTW-MJE).

    Of all monotone paths from the first to the last frames of both motions, the path with the least sum of costs [1]_
    is taken. The errors along it are averaged, and then the errors of all motions. Published programs differ in almost
    every respect; by default the cost and the error are the mean distance of the joints, and the sum is divided by the
    number of pairs of frames on the path.

    Parameters
    ----------
    y_true : array-like of shape (n_frames, n_joints, 3)
        The true motion, see `mpjpe`; several as a list, or (n_motions, n_frames, n_joints, 3). NaN where a joint is
        unknown, which is allowed for "joints" if each frame has a known joint.
    y_pred : array-like
        The predicted motion, or as many as the true ones, of any length, without NaN.
    cost : {"joints", "norm", "l1"}, default="joints"
        What the path minimises: the mean distance of the joints of two frames, the Euclidean norm of all their
        coordinates, or the sum of the absolute differences of the coordinates.
    error : {"joints", "norm", "l1"}, default=None
        What is added along the path. None is the cost.
    divide : {"path", "true"}, default="path"
        What the sum is divided by: the pairs on the path, or the frames of the true motion. None is the sum.
    warp : {"pose", "joint"}, default="pose"
        One path for the whole pose, or one per joint, over which the results are averaged.
    root : int, str, or list of them, default=None
        Joint to which both are relative, see `mpjpe`.
    align : {None, "scale", "rigid", "similarity"}, default=None
        Alignment of each pair of frames, see `mpjpe`; only with the cost "joints".
    joints : int, str, or list of them, default=None
        Joints that count; all joints are aligned.
    average : {"motions", "pairs"} or None, default="motions"
        "motions": the mean of the motions' errors. "pairs": the mean over all pairs of frames of all motions, so that
        long motions count more, only for "path". None: the error of each motion.
    unit : {"m", "cm", "mm"}, default="mm"
        Unit of the result.
    data_unit : {"m", "cm", "mm"}, default="m"
        Unit of the positions.
    skeleton : Skeleton, default=None
        The skeleton, if `y_true` and `y_pred` are poses.
    sample_weight : array-like of shape (n_motions,), default=None
        Weights of the motions.

    Returns
    -------
    float or ndarray of shape (n_motions,)
        The error; the array for ``average=None``.

    Raises
    ------
    ValueError
        For motions that differ in joints or number; for NaN in predictions; for a true frame without a known joint; for
        unknown joints under "norm" and "l1", which would be smaller without them; as `mpjpe`.

    See Also
    --------
    skpose.motions.align_motions : The path itself, under a metric between poses.

    Notes
    -----
    Time and memory O(n · m) for n and m frames, 8 n · m bytes; two motions of 300 frames of 17 joints take 10 ms. Of
    several paths with the least sum, the one that ends with diagonal steps is taken, which divides by the fewest pairs.

    References
    ----------
    .. [1] H. Sakoe, S. Chiba, "Dynamic programming algorithm optimization for spoken word recognition", IEEE
       Transactions on Acoustics, Speech, and Signal Processing 26(1), 1978, :doi:`10.1109/TASSP.1978.1163055`.
    .. [2] W. Huang, W. Pan, Z. Zhao, Q. Tian, "Towards fast and high-quality sign language production", ACM Multimedia
       2021, :doi:`10.1145/3474085.3475463`, where DTW-MJE has its name.
    .. [3] B. Saunders, N. C. Camgoz, R. Bowden, "Progressive transformers for end-to-end sign language production",
       ECCV 2020, :doi:`10.1007/978-3-030-58621-8_40`, ``cost="l1", divide="true"``.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose.scores import dtw_mje
    >>> time = np.linspace(0.0, 1.0, 20)
    >>> true = np.stack([np.outer(time, [1.0, 0.0, 0.0]), np.outer(time**2, [0.0, 1.0, 0.0])], axis=1)  # m
    >>> dtw_mje(true, np.repeat(true, 2, axis=0))  # half as fast
    0.0
    >>> round(dtw_mje(true, true + [0.0, 0.0, 0.01]), 6)  # mm
    10.0
    """
    error = cost if error is None else error
    if average == "pairs" and divide != "path":
        raise ValueError(f"average='pairs' needs divide='path', got {divide!r}")
    if align is not None and (cost, error, warp) != ("joints", "joints", "pose"):
        raise ValueError("align= needs cost='joints' and warp='pose'")
    pairs, chosen = _read_pairs(y_true, y_pred, skeleton, data_unit, root, joints)
    weights = check_sample_weight(sample_weight, np.empty((len(pairs), 1)))
    found = [_follow(pair, chosen, cost, error, divide, warp, align) for pair in pairs]
    sums, sizes = (np.array(one) for one in zip(*found, strict=True))
    factor = LENGTHS[data_unit] / LENGTHS[unit]
    if average is None:
        return sums / sizes * factor
    if average == "pairs":
        return float(weights @ sums / (weights @ sizes)) * factor
    return float(np.average(sums / sizes, weights=weights)) * factor


def _read_pairs(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    skeleton: Skeleton | None,
    data_unit: str,
    root: Joints | None,
    joints: Joints | None,
) -> tuple[list[Points], list[int]]:
    """The pairs of motions, of different lengths, relative to the root, and the indices of the joints that count."""
    true, pred = read_positions(y_true, "y_true", skeleton), read_positions(y_pred, "y_pred", skeleton)
    n_joints = true.frames.shape[1]
    if len(true.lengths) != len(pred.lengths) or n_joints != pred.frames.shape[1]:
        raise ValueError("y_true and y_pred must have the same joints and number of motions")
    check_length_unit(true.frames, skeleton, data_unit)
    pairs = []
    for one, another in zip(true.split(), pred.split(), strict=True):
        a, b = (align_points(points_of(x, x, skeleton), root, None, False) for x in (one, another))
        pairs.append(a._replace(pred=b.true))
    return pairs, list(range(n_joints)) if joints is None else joint_indices(joints, pairs[0], "joints")


def _follow(
    pair: Points, joints: list[int], cost: str, error: str, divide: str | None, warp: str, align: str | None
) -> tuple[float, float]:
    """The sum of the errors along the path, and what it is divided by."""
    if warp == "joint":
        results = [_follow(pair, [j], cost, error, divide, "pose", align) for j in joints]
        return float(np.mean([total / size for total, size in results])), 1.0
    costs = _costs(pair, joints, cost, align)
    errors = costs if error == cost else _costs(pair, joints, error, None)
    sums = costs.copy()
    accumulate(sums, Paths.of(None))
    path = path_to(sums, False, sums.shape[1] - 1)
    total = float(sums[-1, -1]) if errors is costs else float(errors[path[:, 0], path[:, 1]].sum())
    return total, float({"path": len(path), "true": len(pair.true), None: 1}[divide])


def _costs(pair: Points, joints: list[int], cost: str, align: str | None) -> np.ndarray:
    """The costs (n, m) of all pairs of frames."""
    if align is None:  # else all joints take part
        pair = Points(pair.true[:, joints], pair.pred[:, joints], pair.seen[:, joints], ())
        joints = list(range(len(joints)))
    n, m = len(pair.true), len(pair.pred)
    counted = pair.seen[:, joints]
    if cost != "joints" and not counted.all():
        raise ValueError(f"{cost!r} needs all joints in all frames of y_true: use cost='joints'")
    if not counted.any(axis=1).all():
        raise ValueError(f"each frame of y_true must have a known joint, not so frame {counted.any(axis=1).argmin()}")
    costs = np.empty((n, m))
    rows = max(1, AT_ONCE // (m * pair.true.shape[1]))
    for start in range(0, n, rows):
        true, seen = pair.true[start : start + rows, None], pair.seen[start : start + rows, None]
        pred = np.broadcast_to(pair.pred, (len(true), *pair.pred.shape))
        if align is not None:
            pred = _align_pairs(true, seen, pred, align)[:, :, joints]
            true, seen = true[:, :, joints], seen[:, :, joints]
        gaps = true - pred
        if cost == "l1":
            costs[start : start + rows] = np.abs(gaps).sum(axis=(2, 3))
        elif cost == "norm":
            costs[start : start + rows] = np.sqrt((gaps * gaps).sum(axis=(2, 3)))
        else:
            distances = np.sqrt((gaps * gaps).sum(axis=3)) * seen
            costs[start : start + rows] = distances.sum(axis=2) / seen.sum(axis=2)
    return costs


def _align_pairs(true: np.ndarray, seen: np.ndarray, pred: np.ndarray, align: str) -> np.ndarray:
    """Predicted frames (n, m, n_joints, 3) aligned with each true one."""
    shape = pred.shape
    flat_true = np.broadcast_to(true, shape).reshape(-1, *shape[2:])
    flat_seen = np.broadcast_to(seen, shape[:3]).reshape(-1, shape[2])
    points = Points(flat_true, pred.reshape(flat_true.shape), flat_seen, ())
    return align_points(points, None, align, False).pred.reshape(shape)
