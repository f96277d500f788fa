"""The mean difference between predicted and true angles."""

from typing import Any, Literal

import numpy as np

from skpose._utils.sklearn import StrOptions, validate_params
from skpose._utils.typing import ArrayLike
from skpose._utils.units import warn_of_degrees
from skpose.scores._inputs import ANGLES, AngleUnit, check_equal, mean_of, read_columns, read_weights

CONSTANT = 1e-4  # rad, standard deviation up to which published programs call an angle constant


@validate_params(
    {
        "kind": [StrOptions(["each", "norm"])],
        "wrap": ["boolean"],
        "drop_constant": [StrOptions(["true", "pred"]), None],
        "average": [StrOptions(["points"]), None],
        "unit": [StrOptions(ANGLES)],
        "data_unit": [StrOptions(ANGLES)],
    },
    prefer_skip_nested_validation=True,
)
def mean_angle_error(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    *,
    kind: Literal["each", "norm"] = "each",
    wrap: bool = True,
    drop_constant: Literal["true", "pred"] | None = None,
    average: Literal["points"] | None = "points",
    unit: AngleUnit = "rad",
    data_unit: AngleUnit = "rad",
    sample_weight: ArrayLike | None = None,
) -> Any:
    r"""Mean difference between predicted and true angles.

    With the differences δ of the angles k in frame f, wrapped to [−π, π]: "each" is the mean of :math:`|\delta_{fk}|`
    over frames and angles (MPJAE of [1]_), "norm" the mean over frames of :math:`\sqrt{\sum_k \delta_{fk}^2}`, which
    motion prediction reports of Euler angles [2]_ and which grows with the number of angles.

    Parameters
    ----------
    y_true : array-like of shape (n_frames, n_angles)
        True angles, such as poses, of one motion or of independent frames; also (n_motions, n_frames, n_angles) or a
        list of motions. NaN where unknown: "each" leaves out the angle, "norm" the frame.
    y_pred : array-like
        Predicted angles, of the same shape, without NaN.
    kind : {"each", "norm"}, default="each"
        The mean of the angles or the norm of each frame.
    wrap : bool, default=True
        Whether a difference of 359° counts as 1°. Programs for motion prediction do not wrap.
    drop_constant : {"true", "pred"}, default=None
        Leave out angles whose standard deviation over the frames of a motion is at most 0.0001 rad, in the truth or in
        the prediction.
    average : {"points"} or None, default="points"
        "points": the mean. None: the errors themselves.
    unit : {"rad", "deg"}, default="rad"
        Unit of the result.
    data_unit : {"rad", "deg"}, default="rad"
        Unit of the angles.
    sample_weight : array-like of shape (n_frames,), default=None
        Weights of the frames, or of the motions if there are several.

    Returns
    -------
    float or ndarray of shape (n_frames, n_angles) or (n_frames,)
        The error. The array, for ``average=None``, has one number per angle for "each", one per frame for "norm", and
        NaN where nothing counts.

    Raises
    ------
    ValueError
        For different shapes, NaN in predictions, and if no angle is left; for "norm" of a vector, which may be one
        frame or one angle.

    Warns
    -----
    UserWarning
        If the angles look like degrees, and `data_unit` is "rad".

    See Also
    --------
    geodesic_error : Error of rotations, independent of the order of Euler angles.

    References
    ----------
    .. [1] C. Ionescu, D. Papava, V. Olaru, C. Sminchisescu, "Human3.6M", IEEE Transactions on Pattern Analysis and
       Machine Intelligence 36(7), 2014, :doi:`10.1109/TPAMI.2013.248`.
    .. [2] J. Martinez, M. J. Black, J. Romero, "On human motion prediction using recurrent neural networks", CVPR 2017,
       :doi:`10.1109/CVPR.2017.497`.

    Examples
    --------
    >>> from skpose.scores import mean_angle_error
    >>> true, pred = [[0.0, 179.0], [0.0, 179.0]], [[3.0, -177.0], [3.0, 179.0]]
    >>> round(mean_angle_error(true, pred, unit="deg", data_unit="deg"), 3)
    2.5
    >>> mean_angle_error(true, pred, kind="norm", average=None, unit="deg", data_unit="deg").round(3)
    array([5., 3.])
    """
    true, pred = (read_columns(*one, kind == "each") for one in ((y_true, "y_true"), (y_pred, "y_pred")))
    check_equal(true, pred)
    if data_unit == "rad":
        given = {"y_true": np.nan_to_num(true.frames), "y_pred": pred.frames}
        warn_of_degrees('data_unit="deg"', **given, in_estimator=True)
    gaps, turn = true.frames - pred.frames, 2.0 * np.pi / ANGLES[data_unit]
    if wrap:
        gaps -= turn * np.rint(gaps / turn)
    dropped = np.zeros(gaps.shape, dtype=bool)
    if drop_constant is not None:
        motions = (true if drop_constant == "true" else pred).split()
        spreads = [np.ma.masked_invalid(motion).std(axis=0).filled(0.0) for motion in motions]
        dropped = np.repeat(np.array(spreads) * ANGLES[data_unit] <= CONSTANT, true.lengths, axis=0)
    if kind == "each":
        errors = np.where(dropped, np.nan, np.abs(gaps))
    else:
        norms = np.linalg.norm(np.where(dropped, 0.0, gaps), axis=1)
        errors = np.where(dropped.all(axis=1), np.nan, norms)[:, None]
    result = mean_of(errors, read_weights(sample_weight, true), average) * (ANGLES[data_unit] / ANGLES[unit])
    return result[:, 0] if average is None and kind == "norm" else result
