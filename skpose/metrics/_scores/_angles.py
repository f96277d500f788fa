"""The mean difference between predicted and true angles."""

from typing import Literal, get_args

import numpy as np

from skpose._typing import ArrayLike
from skpose._validation.units import warn_of_degrees
from skpose.metrics._scores._points import check_unit
from skpose.metrics._scores._score import Score, signature_of
from skpose.metrics._scores._series import read_series

AngleUnit = Literal["rad", "deg"]
Kind = Literal["each", "norm"]
Constant = Literal["true", "pred"]
ANGLES = {"rad": 1.0, "deg": float(np.pi / 180.0)}
CONSTANT = 1e-4  # standard deviation, rad, up to which the published programs call an angle constant


def mean_angle_error(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    *,
    kind: Kind = "each",
    wrap: bool = True,
    drop_constant: Constant | None = None,
    unit: AngleUnit = "rad",
    data_unit: AngleUnit = "rad",
    sample_weight: ArrayLike | None = None,
) -> Score:
    r"""Return the mean difference between predicted and true angles.

    With the differences δ of the angles k in frame f, wrapped to [−π, π]: "each" is the mean of :math:`|\delta_{fk}|`
    over frames and angles (MPJAE of [1]_), "norm" the mean over frames of :math:`\sqrt{\sum_k \delta_{fk}^2}`, which
    motion prediction reports of Euler angles [2]_. The second grows with the number of angles.

    Parameters
    ----------
    y_true : array-like of shape (n_frames, n_angles)
        True angles, such as poses, of one motion or of independent frames; also (n_motions, n_frames, n_angles) or a
        list of motions. NaN where an angle is not known: it is left out for "each", and its frame for "norm".
    y_pred : as y_true
        Predicted angles, of the same shape. NaN is refused.
    kind : {"each", "norm"}, default="each"
        The mean of the angles or the norm of each frame.
    wrap : bool, default=True
        Whether a difference of 359° is one of 1°. Programs for motion prediction do not wrap.
    drop_constant : {"true", "pred"}, default=None
        Leave out angles whose standard deviation over the frames of a motion is at most 0.0001 rad, in the truth or in
        the prediction. None keeps all.
    unit : {"rad", "deg"}, default="rad"
        Unit of the result.
    data_unit : {"rad", "deg"}, default="rad"
        Unit of the angles.
    sample_weight : array-like of shape (n_frames,), default=None
        Weights of the frames, or of motions where several are given.

    Returns
    -------
    Score
        The error; the counts are of angles.

    Raises
    ------
    ValueError
        For shapes that differ; for predictions that are NaN; for an unknown unit or option; if no angle is left; for
        "norm" of vectors, which may be one frame or one angle.

    Warns
    -----
    UserWarning
        If the angles look like degrees, and `data_unit` is "rad".

    See Also
    --------
    geodesic_error : Of rotations, which does not depend on the order of Euler angles.

    References
    ----------
    .. [1] C. Ionescu, D. Papava, V. Olaru, C. Sminchisescu, "Human3.6M", IEEE Transactions on Pattern Analysis and
       Machine Intelligence 36(7), 2014, :doi:`10.1109/TPAMI.2013.248`.
    .. [2] J. Martinez, M. J. Black, J. Romero, "On human motion prediction using recurrent neural networks", CVPR 2017,
       :doi:`10.1109/CVPR.2017.497`.

    Examples
    --------
    >>> from skpose.metrics import mean_angle_error
    >>> true, pred = [[0.0, 179.0], [0.0, 179.0]], [[3.0, -177.0], [3.0, 179.0]]
    >>> mean_angle_error(true, pred, unit="deg", data_unit="deg")
    Score(2.5, 'Angle|deg|each|wrap=True|data_unit=deg', 4 counted)
    >>> mean_angle_error(true, pred, kind="norm", unit="deg", data_unit="deg")
    Score(4, 'Angle|deg|norm|wrap=True|data_unit=deg', 4 counted)
    """
    check_unit("kind", kind, get_args(Kind))
    check_unit("unit", unit, tuple(ANGLES))
    check_unit("data_unit", data_unit, tuple(ANGLES))
    if drop_constant not in (None, *get_args(Constant)):
        raise ValueError(f"drop_constant must be None, 'true' or 'pred', got {drop_constant!r}")
    series = read_series(y_true, y_pred, sample_weight, "angles", is_vector_known=kind == "each")
    if data_unit == "rad":
        both = {"y_true": series.true, "y_pred": series.pred}
        found = {name: np.nan_to_num(np.concatenate(motions)) for name, motions in both.items()}
        warn_of_degrees('data_unit="deg"', **found, in_estimator=True)
    total = weight = 0.0
    n_counted = n_missing = 0
    turn = 2.0 * np.pi / ANGLES[data_unit]
    for true, pred, weights in zip(*series, strict=True):
        gap = true - pred
        if wrap:
            gap -= turn * np.rint(gap / turn)
        if drop_constant is not None:
            spread = _spread(true if drop_constant == "true" else pred)
            gap = gap[:, spread * ANGLES[data_unit] > CONSTANT]
        known = ~np.isnan(gap)
        if kind == "norm":
            known &= known.all(axis=1, keepdims=True)
        gap = np.where(known, gap, 0.0)
        size = known.sum(axis=1) if kind == "each" else known.any(axis=1).astype(int)
        sums = np.abs(gap).sum(axis=1) if kind == "each" else np.linalg.norm(gap, axis=1)
        total, weight = total + float(weights @ sums), weight + float(weights @ size)
        counted = known[weights > 0.0]
        n_counted, n_missing = n_counted + int(counted.sum()), n_missing + int((~counted).sum())
    if weight == 0.0:
        raise ValueError("no angle is left to score: all are unknown, constant, or of no weight")
    options = {"drop_constant": (drop_constant, None), "data_unit": (data_unit, "rad")}
    signature = signature_of("Angle", unit, options, (kind, f"wrap={bool(wrap)}"))
    return Score(total / weight * ANGLES[data_unit] / ANGLES[unit], signature, n_counted, n_missing)


def _spread(angles: np.ndarray) -> np.ndarray:
    """Return the standard deviation of each column, of what is known in it; zero where nothing is."""
    known = ~np.isnan(angles)
    n = np.maximum(known.sum(axis=0), 1)
    mean = np.where(known, angles, 0.0).sum(axis=0) / n
    return np.sqrt((np.where(known, angles - mean, 0.0) ** 2).sum(axis=0) / n)
