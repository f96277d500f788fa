"""The share of predicted joints that are near enough to the true ones, and the area under its curve."""

from typing import Any, Literal, get_args

import numpy as np

from skpose._typing import ArrayLike
from skpose._validation.options import check_integer, check_positive
from skpose.metrics._scores._align import align as align_points
from skpose.metrics._scores._mpjpe import PREFIXES, Align, Average, Length, Root, options_of, words_of
from skpose.metrics._scores._points import (
    Points,
    check_unit,
    counts_of,
    factor_of,
    lengths_of,
    mean_of,
    read_points,
    select_joints,
)
from skpose.metrics._scores._score import Score, number_text, signature_of
from skpose.skeleton import Skeleton

Share = Literal["%", "share"]
Rule = Literal["mean", "trapezoid"]
UNITS = {"%": 100.0, "share": 1.0}


def pck(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    *,
    threshold: float = 150.0,
    threshold_unit: Length = "mm",
    inclusive: bool = False,
    root: Root | None = None,
    align: Align | None = None,
    reflection: bool = False,
    joints: Root | None = None,
    average: Average = "points",
    unit: Share = "%",
    data_unit: Length = "m",
    skeleton: Skeleton | None = None,
    sample_weight: ArrayLike | None = None,
) -> Score:
    """Return the percentage of correct keypoints (PCK): of joints that are near enough to the true ones.

    Near enough is less than a threshold away, in space (3DPCK [1]_).

    Parameters
    ----------
    y_true : array-like of shape (n_frames, n_joints, 3)
        True positions of the joints, see `mpjpe`.
    y_pred : as y_true
        Predicted positions.
    threshold : float, default=150
        The distance from which on a joint is wrong; 150 mm is about half the size of a head.
    threshold_unit : {"m", "cm", "mm"}, default="mm"
        Unit of the threshold.
    inclusive : bool, default=False
        Whether a joint exactly as far away as the threshold is right. It matters where errors are exactly zero, as that
        of a root is, and the threshold is zero.
    root : int, str, or list of them, default=None
        The joint that both are relative to, see `mpjpe`.
    align : {None, "scale", "rigid", "similarity"}, default=None
        The alignment, see `mpjpe`.
    reflection : bool, default=False
        Whether a mirror image is as good as a rotation.
    joints : int, str, or list of them, default=None
        The joints that count.
    average : {"points", "frames", "joints"}, default="points"
        What is averaged first, see `mpjpe`.
    unit : {"%", "share"}, default="%"
        Whether the result goes to 100 or to 1.
    data_unit : {"m", "cm", "mm"}, default="m"
        Unit of the positions.
    skeleton : Skeleton, default=None
        The skeleton of poses; None is positions.
    sample_weight : array-like of shape (n_frames,), default=None
        Weights of the frames, or of motions where several are given.

    Returns
    -------
    Score
        The percentage: more is better.

    Raises
    ------
    ValueError
        As `mpjpe`; for a threshold that is not positive.

    Warns
    -----
    UserWarning
        As `mpjpe`.

    See Also
    --------
    pck_auc : The mean over thresholds.

    References
    ----------
    .. [1] D. Mehta et al., "Monocular 3D human pose estimation in the wild using improved CNN supervision", 3DV 2017,
       :doi:`10.1109/3DV.2017.00064`.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose.metrics import pck
    >>> true = np.zeros((1, 4, 3)) + [[0.0], [0.5], [1.0], [1.5]]  # m
    >>> pck(true, true + np.outer([0.0, 0.05, 0.08, 0.2], [1.0, 0.0, 0.0]))
    Score(75, 'PCK|%|150mm', 4 counted)
    """
    check_positive("threshold", threshold)
    how: dict[str, Any] = {
        "root": root,
        "align": align,
        "reflection": reflection,
        "joints": joints,
        "data_unit": data_unit,
    }
    points, distances = _distances(y_true, y_pred, skeleton, sample_weight, **how)
    limit = float(threshold)
    distances *= factor_of(data_unit, threshold_unit)
    value = _share(distances, limit, inclusive, points, average) * _factor(unit)
    words = (*words_of(align, reflection), f"{number_text(limit)}{threshold_unit}", *["inclusive"] * bool(inclusive))
    signature = signature_of(f"{PREFIXES[align]}PCK", unit, options_of(root, joints, average, data_unit), words)
    return Score(value, signature, *counts_of(points))


def pck_auc(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    *,
    threshold: float = 150.0,
    threshold_unit: Length = "mm",
    n_thresholds: int = 31,
    rule: Rule = "mean",
    inclusive: bool = False,
    root: Root | None = None,
    align: Align | None = None,
    reflection: bool = False,
    joints: Root | None = None,
    average: Average = "points",
    unit: Share = "%",
    data_unit: Length = "m",
    skeleton: Skeleton | None = None,
    sample_weight: ArrayLike | None = None,
) -> Score:
    """Return the area under the curve of PCK over thresholds from zero to the largest one.

    Divided by the largest threshold, so that 100 % is the best.

    Parameters
    ----------
    y_true : array-like of shape (n_frames, n_joints, 3)
        True positions of the joints, see `mpjpe`.
    y_pred : as y_true
        Predicted positions.
    threshold : float, default=150
        The largest threshold.
    threshold_unit : {"m", "cm", "mm"}, default="mm"
        Unit of the threshold.
    n_thresholds : int, default=31
        Number of thresholds, evenly spaced, zero among them: every 5 mm.
    rule : {"mean", "trapezoid"}, default="mean"
        The mean over the thresholds, as the evaluation of MPI-INF-3DHP [1]_ has it, or the trapezoidal rule.
    inclusive : bool, default=False
        Whether a joint exactly as far away as the threshold is right.
    root : int, str, or list of them, default=None
        The joint that both are relative to, see `mpjpe`.
    align : {None, "scale", "rigid", "similarity"}, default=None
        The alignment, see `mpjpe`.
    reflection : bool, default=False
        Whether a mirror image is as good as a rotation.
    joints : int, str, or list of them, default=None
        The joints that count.
    average : {"points", "frames", "joints"}, default="points"
        What is averaged first, see `mpjpe`.
    unit : {"%", "share"}, default="%"
        Whether the result goes to 100 or to 1.
    data_unit : {"m", "cm", "mm"}, default="m"
        Unit of the positions.
    skeleton : Skeleton, default=None
        The skeleton of poses; None is positions.
    sample_weight : array-like of shape (n_frames,), default=None
        Weights of the frames, or of motions where several are given.

    Returns
    -------
    Score
        The area: more is better. With "mean" and without `inclusive` a perfect prediction has 96.8 %, as no joint is
        less than zero away.

    Raises
    ------
    ValueError
        As `pck`; for less than two thresholds.

    Warns
    -----
    UserWarning
        As `mpjpe`.

    See Also
    --------
    pck : At one threshold.

    References
    ----------
    .. [1] D. Mehta et al., "Monocular 3D human pose estimation in the wild using improved CNN supervision", 3DV 2017,
       :doi:`10.1109/3DV.2017.00064`.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose.metrics import pck_auc
    >>> true = np.zeros((1, 4, 3)) + [[0.0], [0.5], [1.0], [1.5]]  # m
    >>> pck_auc(true, true + np.outer([0.0, 0.05, 0.08, 0.2], [1.0, 0.0, 0.0]))
    Score(51.6129, 'PCK-AUC|%|150mm|n_thresholds=31|rule=mean', 4 counted)
    """
    check_positive("threshold", threshold)
    check_integer(n_thresholds, 2, "n_thresholds")
    check_unit("rule", rule, get_args(Rule))
    how: dict[str, Any] = {
        "root": root,
        "align": align,
        "reflection": reflection,
        "joints": joints,
        "data_unit": data_unit,
    }
    points, distances = _distances(y_true, y_pred, skeleton, sample_weight, **how)
    distances *= factor_of(data_unit, threshold_unit)
    limits = np.linspace(0.0, float(threshold), int(n_thresholds))
    curve = np.array([_share(distances, limit, inclusive, points, average) for limit in limits])
    area = curve.mean() if rule == "mean" else (curve[1:] + curve[:-1]).mean() / 2.0
    words = (*words_of(align, reflection), f"{number_text(float(threshold))}{threshold_unit}")
    words += (f"n_thresholds={n_thresholds}", f"rule={rule}", *["inclusive"] * bool(inclusive))
    signature = signature_of(f"{PREFIXES[align]}PCK-AUC", unit, options_of(root, joints, average, data_unit), words)
    return Score(float(area) * _factor(unit), signature, *counts_of(points))


def _distances(
    y_true: Any,
    y_pred: Any,
    skeleton: Skeleton | None,
    sample_weight: Any,
    *,
    root: Any,
    align: Any,
    reflection: bool,
    joints: Any,
    data_unit: str,
) -> tuple[Points, np.ndarray]:
    """Return the points that count, aligned, and their distances from the truth."""
    points = read_points(y_true, y_pred, skeleton, sample_weight, data_unit)
    points = select_joints(align_points(points, root, align, reflection), joints)
    return points, lengths_of(points.pred - points.true)


def _share(distances: np.ndarray, limit: float, inclusive: bool, points: Points, average: str) -> float:
    right = distances <= limit if inclusive else distances < limit
    return mean_of(right.astype(np.float64), points, average)


def _factor(unit: str) -> float:
    check_unit("unit", unit, tuple(UNITS))
    return UNITS[unit]
