"""The error of joints along the path of dynamic time warping."""

from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from skpose._compiled.warping.paths import Paths, accumulate, path_to
from skpose._typing import ArrayLike
from skpose.metrics._scores._align import align as align_points
from skpose.metrics._scores._mpjpe import PREFIXES, Align, Length, Root, options_of, words_of
from skpose.metrics._scores._points import (
    Points,
    check_data_unit,
    check_finite,
    check_predictions,
    check_unit,
    factor_of,
    is_list_of_motions,
    joint_indices,
    read_weights,
    split_motions,
    warn_of_unit,
)
from skpose.metrics._scores._score import Score, signature_of
from skpose.skeleton import Skeleton

Cost = Literal["joints", "norm", "l1"]
Divide = Literal["path", "true"]
Warp = Literal["pose", "joint"]
AT_ONCE = 1 << 20  # distances of joints in memory


def dtw_mje(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    *,
    cost: Cost = "joints",
    error: Cost | None = None,
    divide: Divide | None = "path",
    warp: Warp = "pose",
    pool: bool = False,
    root: Root | None = None,
    align: Align | None = None,
    joints: Root | None = None,
    unit: Length = "mm",
    data_unit: Length = "m",
    skeleton: Skeleton | None = None,
    sample_weight: ArrayLike | None = None,
) -> Score:
    r"""Return the mean joint error of motions after dynamic time warping (DTW-MJE).

    Of all monotone paths from the first frames to the last ones of both motions, the one with the least sum of costs
    [1]_; the error along it is averaged, and then that of several motions. The two may differ in length. Published
    programs differ in nearly everything; by default the cost and the error are the mean distance of the joints, and the
    sum is divided by the number of pairs of frames on the path.

    Parameters
    ----------
    y_true : array-like of shape (n_frames, n_joints, 3)
        The true motion, see `mpjpe`; of several motions a list, or (n_motions, n_frames, n_joints, 3). NaN where a
        joint is not known: with "joints" it is left out; each frame needs one joint.
    y_pred : as y_true
        The predicted motion, or as many of them, of any length. NaN is refused.
    cost : {"joints", "norm", "l1"}, default="joints"
        What the path minimises: the mean distance of the joints of two frames, the Euclidean norm of all their
        coordinates, or the sum of the absolute differences of the coordinates.
    error : {"joints", "norm", "l1"}, default=None
        What is added along the path. None is the cost.
    divide : {"path", "true"}, default="path"
        What the sum is divided by: the pairs on the path, or the frames of the true motion. None is the sum.
    warp : {"pose", "joint"}, default="pose"
        One path for the whole pose, or one for each joint, over which the results are averaged.
    pool : bool, default=False
        With "path", whether all pairs of frames of all motions count equally, so that long motions count more.
    root : int, str, or list of them, default=None
        The joint that both are relative to, see `mpjpe`.
    align : {None, "scale", "rigid", "similarity"}, default=None
        Alignment of each pair of frames, see `mpjpe`; with the cost "joints" only.
    joints : int, str, or list of them, default=None
        The joints that count; all take part in the alignment.
    unit : {"m", "cm", "mm"}, default="mm"
        Unit of the result.
    data_unit : {"m", "cm", "mm"}, default="m"
        Unit of the positions.
    skeleton : Skeleton, default=None
        The skeleton of poses; None is positions.
    sample_weight : array-like of shape (n_motions,), default=None
        Weights of the motions.

    Returns
    -------
    Score
        The error; the counts are of joints of true frames.

    Raises
    ------
    ValueError
        For motions that differ in joints or number; for predictions that are NaN; for a true frame without any joint;
        for missing joints under "norm" and "l1", which would be smaller without them; as `mpjpe`.

    See Also
    --------
    skpose.motions.align_motions : The path itself, under a metric between poses.

    Notes
    -----
    Time and memory O(n · m) for n and m frames, 8 n · m bytes; two motions of 300 frames of 17 joints take 10 ms. Where
    several paths have the least sum, the one that ends with diagonal steps is taken, which divides by the fewest pairs.

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
    >>> from skpose.metrics import dtw_mje
    >>> time = np.linspace(0.0, 1.0, 20)
    >>> true = np.stack([np.outer(time, [1.0, 0.0, 0.0]), np.outer(time**2, [0.0, 1.0, 0.0])], axis=1)  # m
    >>> print(dtw_mje(true, np.repeat(true, 2, axis=0)))  # half as fast
    0.0
    >>> dtw_mje(true, true + [0.0, 0.0, 0.01])
    Score(10, 'DTW-MJE|mm|cost=joints|divide=path', 40 counted)
    """
    how = _How(cost, cost if error is None else error, divide, warp, align)
    _check(how, pool)
    motions = _read_motions(y_true, y_pred, skeleton, data_unit, root, joints)
    weights = read_weights(sample_weight, [1] * len(motions), True)
    sums, sizes = zip(*(_follow(motion, how) for motion in motions), strict=True)
    if pool:
        value = float(weights @ np.array(sums) / (weights @ np.array(sizes)))
    else:
        value = float(np.average(np.array(sums) / np.array(sizes), weights=weights))
    options: dict[str, tuple[Any, Any]] = {"error": (error, None), "warp": (warp, "pose"), "pool": (bool(pool), False)}
    options |= options_of(root, joints, "points", data_unit)
    words = (*words_of(align, False), f"cost={cost}", f"divide={divide}")
    signature = signature_of(f"{PREFIXES[align]}DTW-MJE", unit, options, words)
    counted = [motion for motion, weight in zip(motions, weights, strict=True) if weight > 0.0]
    seen = [motion.seen[:, motion.joints] for motion in counted]
    n_seen = sum(int(one.sum()) for one in seen)
    return Score(value * factor_of(data_unit, unit), signature, n_seen, sum(one.size for one in seen) - n_seen)


class _How(NamedTuple):
    """The options that say what is computed of a pair of motions."""

    cost: str
    error: str
    divide: str | None
    warp: str
    align: str | None


class _Pair(NamedTuple):
    """A true motion, with the joints of its frames that are seen, and a predicted one."""

    true: np.ndarray  # (n, n_joints, 3)
    seen: np.ndarray  # (n, n_joints)
    pred: np.ndarray  # (m, n_joints, 3)
    joints: list[int]  # those that count


def _check(how: _How, pool: bool) -> None:
    check_unit("cost", how.cost, get_args(Cost))
    check_unit("error", how.error, get_args(Cost))
    check_unit("warp", how.warp, get_args(Warp))
    if how.divide not in (None, *get_args(Divide)):
        raise ValueError(f"divide must be 'path', 'true' or None, got {how.divide!r}")
    if pool and how.divide != "path":
        raise ValueError(f"pool=True is the mean over all pairs of frames, with divide='path', got {how.divide!r}")
    if how.align is not None and (how.cost, how.error, how.warp) != ("joints", "joints", "pose"):
        raise ValueError(
            "align= needs cost='joints' and warp='pose': it takes the joints of a frame to those of another"
        )


def _read_motions(y_true: Any, y_pred: Any, skeleton: Any, data_unit: str, root: Any, joints: Any) -> list[_Pair]:
    """Return the pairs of motions, relative to the root."""
    check_data_unit(data_unit, skeleton)
    if is_list_of_motions(y_true) != is_list_of_motions(y_pred):
        raise ValueError("y_true and y_pred must both be lists of motions, or both arrays")
    true, pred = split_motions(y_true, "y_true", skeleton)[0], split_motions(y_pred, "y_pred", skeleton)[0]
    if len(true) != len(pred):
        raise ValueError(f"y_true and y_pred must be as many motions, got {len(true)} and {len(pred)}")
    if not true:
        raise ValueError("y_true has no motions: a score needs one at least")
    if skeleton is None:
        warn_of_unit(np.concatenate(true), data_unit)
    pairs = []
    for i, (one, another) in enumerate(zip(true, pred, strict=True)):
        if not len(one) or not len(another):
            raise ValueError(f"motion {i} has no frames, in y_true or in y_pred")
        if one.shape[1] != another.shape[1]:
            raise ValueError(
                f"y_true and y_pred must have the same joints, and motion {i} has {one.shape[1]} and {another.shape[1]}"
            )
        check_finite(one, "y_true")
        check_predictions(another, "y_pred")
        found = []
        for motion in (one, another):
            seen = ~np.isnan(motion).any(axis=2)
            motion = np.where(seen[:, :, None], motion, 0.0)
            names = None if skeleton is None else skeleton.joint_names
            points = Points(motion, motion.copy(), seen, np.ones(len(motion)), (len(motion),), names)
            found.append(align_points(points, root, None, False))
        chosen = list(range(one.shape[1])) if joints is None else joint_indices(joints, found[0], "joints")
        pairs.append(_Pair(found[0].true, found[0].seen, found[1].true, chosen))
    return pairs


def _follow(pair: _Pair, how: _How) -> tuple[float, float]:
    """Return the sum of the errors along the path, and what it is divided by."""
    if how.warp == "joint":
        results = [_follow(pair._replace(joints=[j]), how._replace(warp="pose")) for j in pair.joints]
        return float(np.mean([total / size for total, size in results])), 1.0
    costs = _costs(pair, how.cost, how.align)
    errors = costs if how.error == how.cost else _costs(pair, how.error, None)
    sums = costs.copy()
    accumulate(sums, Paths.of(None))
    path = path_to(sums, False, sums.shape[1] - 1)
    total = float(sums[-1, -1]) if errors is costs else float(errors[path[:, 0], path[:, 1]].sum())
    return total, float({"path": len(path), "true": len(pair.true), None: 1}[how.divide])


def _costs(pair: _Pair, cost: str, align: str | None) -> np.ndarray:
    """Return the costs (n, m) of all pairs of frames."""
    if align is None:  # else all joints take part
        true, seen, pred = (array[:, pair.joints] for array in pair[:3])
        pair = _Pair(true, seen, pred, list(range(len(pair.joints))))
    n, m = len(pair.true), len(pair.pred)
    counted = pair.seen[:, pair.joints]
    n_seen = counted.sum(axis=1)
    if cost != "joints" and not counted.all():
        raise ValueError(
            f"{cost!r} needs all joints in all frames of y_true, as it would be smaller without some: use cost='joints'"
        )
    if not n_seen.all():
        raise ValueError(
            f"no joint of frame {n_seen.argmin()} of a motion of y_true is seen, and dynamic time warping needs every "
            "frame: leave the frame out, or fill it in"
        )
    costs = np.empty((n, m))
    rows = max(1, AT_ONCE // (m * pair.true.shape[1]))
    for start in range(0, n, rows):
        true, seen = pair.true[start : start + rows, None], pair.seen[start : start + rows, None]
        pred = np.broadcast_to(pair.pred, (len(true), *pair.pred.shape))
        if align is not None:
            pred = _align_pairs(true, seen, pred, align, start)[:, :, pair.joints]
            true, seen = true[:, :, pair.joints], seen[:, :, pair.joints]
        gaps = true - pred
        if cost == "l1":
            costs[start : start + rows] = np.abs(gaps).sum(axis=(2, 3))
        elif cost == "norm":
            costs[start : start + rows] = np.sqrt((gaps * gaps).sum(axis=(2, 3)))
        else:
            distances = np.sqrt((gaps * gaps).sum(axis=3)) * seen
            costs[start : start + rows] = distances.sum(axis=2) / seen.sum(axis=2)
    return costs


def _align_pairs(true: np.ndarray, seen: np.ndarray, pred: np.ndarray, align: str, start: int) -> np.ndarray:
    """Return predicted frames (n, m, n_joints, 3) aligned with each true one."""
    shape = pred.shape
    flat_true = np.broadcast_to(true, shape).reshape(-1, *shape[2:])
    flat_seen = np.broadcast_to(seen, shape[:3]).reshape(-1, shape[2])
    flat = Points(flat_true, pred.reshape(flat_true.shape), flat_seen, np.ones(len(flat_true)), (len(flat_true),), None)
    try:
        return align_points(flat, None, align, False).pred.reshape(shape)
    except ValueError:
        raise ValueError(
            f"one of the frames {start} to {start + len(true) - 1} of y_true cannot be aligned with one of y_pred: "
            "less than three joints are seen, or they are one point or lie on one line. Use align=None, or leave "
            "such frames out"
        ) from None
