"""The share of predicted joints that are near the true ones, and the area under its curve."""

from numbers import Integral, Real
from typing import Any, Literal

import numpy as np

from skpose._utils.sklearn import Interval, StrOptions, validate_params
from skpose._utils.typing import ArrayLike
from skpose.scores._inputs import CONSTRAINTS, LENGTHS, Joints, Length, lengths_of, mean_of, read_errors
from skpose.scores._mpjpe import Align, Average
from skpose.skeleton import Skeleton

Share = Literal["%", "share"]
UNITS = {"%": 100.0, "share": 1.0}
SHARE_CONSTRAINTS = CONSTRAINTS | {
    "threshold": [Interval(Real, 0, None, closed="neither")],
    "threshold_unit": [StrOptions(LENGTHS)],
    "inclusive": ["boolean"],
    "unit": [StrOptions(UNITS)],
}


@validate_params(SHARE_CONSTRAINTS, prefer_skip_nested_validation=True)
def pck(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    *,
    threshold: float = 150.0,
    threshold_unit: Length = "mm",
    inclusive: bool = False,
    root: Joints | None = None,
    align: Align | None = None,
    reflection: bool = False,
    joints: Joints | None = None,
    average: Average | None = "points",
    unit: Share = "%",
    data_unit: Length = "m",
    skeleton: Skeleton | None = None,
    sample_weight: ArrayLike | None = None,
) -> Any:
    """Percentage of correct keypoints (PCK): joints whose error is less than a threshold (3DPCK [1]_).

    Parameters
    ----------
    y_true : array-like of shape (n_frames, n_joints, 3)
        True positions of the joints, see `mpjpe`.
    y_pred : array-like
        Predicted positions.
    threshold : float, default=150
        Distance from which a joint is wrong; 150 mm is about half the size of a head.
    threshold_unit : {"m", "cm", "mm"}, default="mm"
        Unit of the threshold.
    inclusive : bool, default=False
        Whether a joint exactly at the threshold is correct.
    root : int, str, or list of them, default=None
        Joint to which both are relative, see `mpjpe`.
    align : {None, "scale", "rigid", "similarity"}, default=None
        Alignment, see `mpjpe`.
    reflection : bool, default=False
        Whether "rigid" and "similarity" may also reflect.
    joints : int, str, or list of them, default=None
        Joints that count.
    average : {"points", "frames", "joints"} or None, default="points"
        What is averaged first, see `mpjpe`. None: the result of all joints in all frames.
    unit : {"%", "share"}, default="%"
        Whether the best result is 100 or 1.
    data_unit : {"m", "cm", "mm"}, default="m"
        Unit of the positions.
    skeleton : Skeleton, default=None
        The skeleton, if `y_true` and `y_pred` are poses.
    sample_weight : array-like of shape (n_frames,), default=None
        Weights of the frames, or of the motions if there are several.

    Returns
    -------
    float or ndarray of shape (n_frames, n_joints)
        The percentage: more is better. The array, for ``average=None``, has 0 and 100 (or 1), and NaN where the truth
        is unknown.

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
    >>> from skpose.scores import pck
    >>> true = np.zeros((1, 4, 3)) + [[0.0], [0.5], [1.0], [1.5]]  # m
    >>> pck(true, true + np.outer([0.0, 0.05, 0.08, 0.2], [1.0, 0.0, 0.0]))
    75.0
    """
    errors, weights, _ = read_errors(
        y_true, y_pred, skeleton, sample_weight, data_unit, root, align, reflection, joints
    )
    distances = lengths_of(errors) * (LENGTHS[data_unit] / LENGTHS[threshold_unit])
    return mean_of(_correct(distances, float(threshold), inclusive), weights, average) * UNITS[unit]


@validate_params(
    SHARE_CONSTRAINTS
    | {"n_thresholds": [Interval(Integral, 2, None, closed="left")], "rule": [StrOptions(["mean", "trapezoid"])]},
    prefer_skip_nested_validation=True,
)
def pck_auc(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    *,
    threshold: float = 150.0,
    threshold_unit: Length = "mm",
    n_thresholds: int = 31,
    rule: Literal["mean", "trapezoid"] = "mean",
    inclusive: bool = False,
    root: Joints | None = None,
    align: Align | None = None,
    reflection: bool = False,
    joints: Joints | None = None,
    average: Average | None = "points",
    unit: Share = "%",
    data_unit: Length = "m",
    skeleton: Skeleton | None = None,
    sample_weight: ArrayLike | None = None,
) -> Any:
    """Area under the curve of PCK over thresholds from zero to the largest one, divided by the largest.

    Parameters
    ----------
    y_true : array-like of shape (n_frames, n_joints, 3)
        True positions of the joints, see `mpjpe`.
    y_pred : array-like
        Predicted positions.
    threshold : float, default=150
        The largest threshold.
    threshold_unit : {"m", "cm", "mm"}, default="mm"
        Unit of the threshold.
    n_thresholds : int, default=31
        Number of evenly spaced thresholds, including zero: every 5 mm.
    rule : {"mean", "trapezoid"}, default="mean"
        The mean over the thresholds, as in the evaluation of MPI-INF-3DHP [1]_, or the trapezoidal rule.
    inclusive : bool, default=False
        Whether a joint exactly at the threshold is correct.
    root : int, str, or list of them, default=None
        Joint to which both are relative, see `mpjpe`.
    align : {None, "scale", "rigid", "similarity"}, default=None
        Alignment, see `mpjpe`.
    reflection : bool, default=False
        Whether "rigid" and "similarity" may also reflect.
    joints : int, str, or list of them, default=None
        Joints that count.
    average : {"points", "frames", "joints"} or None, default="points"
        What is averaged first, see `mpjpe`. None: the area of each joint in each frame.
    unit : {"%", "share"}, default="%"
        Whether the best result is 100 or 1.
    data_unit : {"m", "cm", "mm"}, default="m"
        Unit of the positions.
    skeleton : Skeleton, default=None
        The skeleton, if `y_true` and `y_pred` are poses.
    sample_weight : array-like of shape (n_frames,), default=None
        Weights of the frames, or of the motions if there are several.

    Returns
    -------
    float or ndarray of shape (n_frames, n_joints)
        The area: more is better. With "mean" and without `inclusive`, a perfect prediction has 96.8 %, since no error
        is less than the threshold zero.

    Raises
    ------
    ValueError
        As `pck`.

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
    >>> from skpose.scores import pck_auc
    >>> true = np.zeros((1, 4, 3)) + [[0.0], [0.5], [1.0], [1.5]]  # m
    >>> round(pck_auc(true, true + np.outer([0.0, 0.05, 0.08, 0.2], [1.0, 0.0, 0.0])), 2)
    51.61
    """
    errors, weights, _ = read_errors(
        y_true, y_pred, skeleton, sample_weight, data_unit, root, align, reflection, joints
    )
    distances = lengths_of(errors) * (LENGTHS[data_unit] / LENGTHS[threshold_unit])
    limits = np.linspace(0.0, float(threshold), int(n_thresholds))
    curve = np.array([mean_of(_correct(distances, limit, inclusive), weights, average) for limit in limits])
    area = curve.mean(axis=0) if rule == "mean" else (curve[1:] + curve[:-1]).mean(axis=0) / 2.0
    return (area if average is None else float(area)) * UNITS[unit]


def _correct(errors: np.ndarray, limit: float, inclusive: bool) -> np.ndarray:
    """1 where an error is within the limit, else 0; NaN stays."""
    return np.where(np.isnan(errors), np.nan, errors <= limit if inclusive else errors < limit)
