"""The similarity of the power spectra of predicted and true motions."""

from typing import Literal, get_args

import numpy as np

from skpose._typing import ArrayLike
from skpose.metrics._scores._points import check_unit
from skpose.metrics._scores._score import Score, signature_of
from skpose.metrics._scores._series import read_series

Spectrum = Literal["power", "real"]


def npss(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    *,
    spectrum: Spectrum = "power",
    sample_weight: ArrayLike | None = None,
) -> Score:
    r"""Return the normalized power spectrum similarity (NPSS) of motions, a distance: zero is the best.

    With the power spectra :math:`P_{ik}(\omega)` of the true motion i in column k, and :math:`\hat P` of the predicted
    one, both over all frequencies of the discrete Fourier transform [1]_:

    .. math:: \frac{\sum_{ik} p_{ik} \sum_\omega | C_{ik}(\omega) - \hat C_{ik}(\omega) |}{\sum_{ik} p_{ik}}, \quad
              p_{ik} = \sum_\omega P_{ik}(\omega)

    where C is the cumulative sum of :math:`P / p` over the frequencies: the earth mover's distance of spectra of unit
    sum, weighted by the power of the truth. It does not see shifts in time.

    Parameters
    ----------
    y_true : array-like of shape (n_motions, n_frames, n_features)
        True motions: joint angles, rotations as numbers, or positions, in any unit; also (n_frames, n_features) for
        one, (n_motions, n_frames, n_joints, 3), or a list of motions of any lengths. A column of a motion that has NaN
        is left out, and counted in the result.
    y_pred : as y_true
        Predicted motions, of the same shape. NaN is refused.
    spectrum : {"power", "real"}, default="power"
        "power" is the squared magnitude of the Fourier coefficients. "real" is the square of their real parts, which
        most programs compute, the authors' among them: it changes with a shift in time.
    sample_weight : array-like of shape (n_motions,), default=None
        Weights of the motions, or of the frames of a single one, which then are of no use.

    Returns
    -------
    Score
        The distance, without unit; the counts are of columns of motions.

    Raises
    ------
    ValueError
        For shapes that differ; for predictions that are NaN; for a motion of one frame, which has no spectrum; where
        the prediction is zero in all frames and the truth is not; where the truth is zero everywhere.

    Notes
    -----
    Columns that are zero in all frames of the truth have no power and no weight. A prediction that is zero in all
    frames has no spectrum; one that is constant has. Time O(n log n) of the number of frames.

    References
    ----------
    .. [1] A. Gopalakrishnan, A. Mali, D. Kifer, C. L. Giles, A. G. Ororbia, "A neural temporal model for human motion
       prediction", CVPR 2019, :doi:`10.1109/CVPR.2019.01239`.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose.metrics import npss
    >>> time = np.arange(50) / 50.0
    >>> true = np.sin(2 * np.pi * np.outer(time, [2.0, 3.0]))  # two angles of one motion
    >>> print(f"{npss(true, np.roll(true, 7, axis=0)):.6f}")
    0.000000
    >>> npss(true, np.sin(2 * np.pi * np.outer(time, [3.0, 3.0])))
    Score(0.5, 'NPSS|spectrum=power', 2 counted)
    """
    check_unit("spectrum", spectrum, get_args(Spectrum))
    series = read_series(y_true, y_pred, sample_weight, "features")
    distances, powers, n_counted, n_missing = [], [], 0, 0
    for i, (true, pred, weights) in enumerate(zip(*series, strict=True)):
        if len(true) < 2:
            raise ValueError(f"a spectrum needs two frames at least, and motion {i} has one")
        if (weights != weights[0]).any():
            raise ValueError("sample_weight must be one number a motion: a spectrum is that of all frames")
        known = ~np.isnan(true).any(axis=0)
        if weights[0] > 0.0:
            n_counted, n_missing = n_counted + int(known.sum()), n_missing + int((~known).sum())
        spectra_true, spectra_pred = (_spectra(one[:, known], spectrum) for one in (true, pred))
        power, power_pred = spectra_true.sum(axis=0), spectra_pred.sum(axis=0)
        empty = (power_pred == 0.0) & (power > 0.0)
        if empty.any():
            column = np.flatnonzero(known)[empty.argmax()]
            raise ValueError(
                f"y_pred is zero in all frames of column {column} of motion {i}, and y_true is not: such a prediction "
                "has no spectrum. Leave the column out of both"
            )
        some = power > 0.0
        curves = [np.cumsum(one[:, some] / one[:, some].sum(axis=0), axis=0) for one in (spectra_true, spectra_pred)]
        distances.append(np.abs(curves[0] - curves[1]).sum(axis=0))
        powers.append(weights[0] * power[some])
    weight = np.concatenate(powers)
    if not weight.any():
        raise ValueError("y_true is zero, or not known, in every column of motions of positive weight: it has no power")
    value = float(np.average(np.concatenate(distances), weights=weight))
    return Score(value, signature_of("NPSS", "", {}, (f"spectrum={spectrum}",)), n_counted, n_missing)


def _spectra(series: np.ndarray, spectrum: str) -> np.ndarray:
    """Return the spectra (n_frames, n_columns) of columns."""
    coefficients = np.fft.fft(series, axis=0)
    return coefficients.real**2 if spectrum == "real" else coefficients.real**2 + coefficients.imag**2
