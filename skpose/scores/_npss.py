"""The similarity of the power spectra of predicted and true motions."""

from typing import Any, Literal

import numpy as np

from skpose._utils.sklearn import StrOptions, validate_params
from skpose._utils.typing import ArrayLike
from skpose.scores._inputs import check_equal, read_columns, read_weights


@validate_params(
    {"spectrum": [StrOptions(["power", "real"])], "average": [StrOptions(["power"]), None]},
    prefer_skip_nested_validation=True,
)
def npss(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    *,
    spectrum: Literal["power", "real"] = "power",
    average: Literal["power"] | None = "power",
    sample_weight: ArrayLike | None = None,
) -> Any:
    r"""Normalized power spectrum similarity (NPSS) of motions; it is a distance, and zero is the best.

    With the power spectra :math:`P_{ik}(\omega)` of the true motion i in column k, and :math:`\hat P` of the predicted
    one, both over all frequencies of the discrete Fourier transform [1]_:

    .. math:: \frac{\sum_{ik} p_{ik} \sum_\omega | C_{ik}(\omega) - \hat C_{ik}(\omega) |}{\sum_{ik} p_{ik}}, \quad
              p_{ik} = \sum_\omega P_{ik}(\omega)

    where C is the cumulative sum of :math:`P / p` over the frequencies: the earth mover's distance of spectra of unit
    sum, weighted by the power of the truth. Shifts in time do not change it.

    Parameters
    ----------
    y_true : array-like of shape (n_motions, n_frames, n_features)
        True motions: joint angles, rotations as numbers, or positions, in any unit; also (n_frames, n_features) for
        one motion, (n_motions, n_frames, n_joints, 3), or a list of motions of any lengths. A column of a motion with
        NaN does not count.
    y_pred : array-like
        Predicted motions, of the same shape, without NaN.
    spectrum : {"power", "real"}, default="power"
        "power" is the squared magnitude of the Fourier coefficients. "real" is the square of their real parts, as most
        programs compute it, including the authors'; it changes with a shift in time.
    average : {"power"} or None, default="power"
        "power": the mean weighted by power. None: the distances of all columns of all motions.
    sample_weight : array-like of shape (n_motions,), default=None
        Weights of the motions. For a single motion, equal weights of its frames.

    Returns
    -------
    float or ndarray of shape (n_motions, n_features)
        The distance, without unit. The array, for ``average=None``, has NaN for columns without power or with NaN.

    Raises
    ------
    ValueError
        For different shapes, NaN in predictions, and a motion of one frame; if the prediction of a column is zero in
        all frames and the truth is not; if the truth is zero everywhere.

    Notes
    -----
    Columns that are zero in all frames of the truth have no power and no weight. Time O(n log n) in the frames.

    References
    ----------
    .. [1] A. Gopalakrishnan, A. Mali, D. Kifer, C. L. Giles, A. G. Ororbia, "A neural temporal model for human motion
       prediction", CVPR 2019, :doi:`10.1109/CVPR.2019.01239`.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose.scores import npss
    >>> time = np.arange(50) / 50.0
    >>> true = np.sin(2 * np.pi * np.outer(time, [2.0, 3.0]))  # two angles of one motion
    >>> round(npss(true, np.roll(true, 7, axis=0)), 6)
    0.0
    >>> npss(true, np.sin(2 * np.pi * np.outer(time, [3.0, 3.0])), average=None).round(3)
    array([[1., 0.]])
    """
    true, pred = read_columns(y_true, "y_true"), read_columns(y_pred, "y_pred")
    check_equal(true, pred)
    if min(true.lengths) < 2:
        raise ValueError("each motion must have at least two frames, got one with a single frame")
    weights = read_weights(sample_weight, true)
    if not true.several and np.ptp(weights):
        raise ValueError("sample_weight must be the same for all frames of a motion")
    distances, powers = [], []
    for a, b in zip(true.split(), pred.split(), strict=True):
        spectra, predicted = _spectra(a, spectrum), _spectra(b, spectrum)
        power = spectra.sum(axis=0)  # NaN with a frame that is not known
        if ((predicted.sum(axis=0) == 0.0) & (power > 0.0)).any():
            raise ValueError("a column of y_pred is zero in all frames of a motion, and has no spectrum")
        some = power > 0.0
        curves = [np.cumsum(one[:, some] / one[:, some].sum(axis=0), axis=0) for one in (spectra, predicted)]
        distances.append(np.full(len(power), np.nan))
        distances[-1][some] = np.abs(curves[0] - curves[1]).sum(axis=0)
        powers.append(np.where(some, power, 0.0))
    if average is None:
        return np.stack(distances)
    weight = np.stack(powers) * weights[np.cumsum(true.lengths) - 1][:, None]
    if not weight.any():
        raise ValueError("y_true must not be zero or unknown in all columns of motions of positive weight")
    return float(np.average(np.stack(distances)[weight > 0.0], weights=weight[weight > 0.0]))


def _spectra(series: np.ndarray, spectrum: str) -> np.ndarray:
    """Spectra (n_frames, n_columns) of columns."""
    coefficients = np.fft.fft(series, axis=0)
    return coefficients.real**2 if spectrum == "real" else coefficients.real**2 + coefficients.imag**2
