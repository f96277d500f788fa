"""The difference between accelerations of predicted and true joints."""

from typing import Any

import numpy as np

from skpose._typing import ArrayLike
from skpose._validation.options import check_positive
from skpose.metrics._scores._align import align as align_points
from skpose.metrics._scores._mpjpe import PREFIXES, Align, Average, Length, Root, options_of, words_of
from skpose.metrics._scores._points import Points, counts_of, factor_of, lengths_of, mean_of, read_points, select_joints
from skpose.metrics._scores._score import Score, signature_of
from skpose.skeleton import Skeleton

PER_FRAME, PER_SECOND = "/frame²", "/s²"


def acceleration_error(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    *,
    frame_rate: float | None = None,
    root: Root | None = None,
    align: Align | None = None,
    reflection: bool = False,
    joints: Root | None = None,
    average: Average = "points",
    unit: Length = "mm",
    data_unit: Length = "m",
    skeleton: Skeleton | None = None,
    sample_weight: ArrayLike | None = None,
) -> Score:
    r"""Return the mean length of the difference between the accelerations of predicted and true joints.

    Accelerations are second differences of consecutive frames [1]_: with :math:`e_f = \hat x_f - x_f` it is the mean of
    :math:`\| e_{f-1} - 2 e_f + e_{f+1} \|_2` over joints and inner frames. It shows jitter.

    Parameters
    ----------
    y_true : array-like of shape (n_frames, n_joints, 3)
        Consecutive frames of one motion, see `mpjpe`; of several as (n_motions, n_frames, n_joints, 3) or as a list.
        Where a joint is not known in a frame (NaN) the three accelerations are left out that the frame is part of.
    y_pred : as y_true
        Predicted positions.
    frame_rate : float, default=None
        Frames a second: the result is in ``unit``/s². None is in ``unit``/frame², as most published ones are, which
        differ between frame rates.
    root : int, str, or list of them, default=None
        The joint that both are relative to, see `mpjpe`.
    align : {None, "scale", "rigid", "similarity"}, default=None
        The alignment, see `mpjpe`; it comes first, frame by frame.
    reflection : bool, default=False
        Whether a mirror image is as good as a rotation.
    joints : int, str, or list of them, default=None
        The joints that count.
    average : {"points", "frames", "joints"}, default="points"
        What is averaged first, see `mpjpe`.
    unit : {"m", "cm", "mm"}, default="mm"
        Unit of lengths in the result.
    data_unit : {"m", "cm", "mm"}, default="m"
        Unit of the positions.
    skeleton : Skeleton, default=None
        The skeleton of poses; None is positions.
    sample_weight : array-like of shape (n_frames,), default=None
        Weights of frames, of which an acceleration has that of the middle one; or of motions where several are given.

    Returns
    -------
    Score
        The error.

    Raises
    ------
    ValueError
        As `mpjpe`; for a motion of less than three frames.

    Warns
    -----
    UserWarning
        As `mpjpe`.

    References
    ----------
    .. [1] A. Kanazawa, J. Y. Zhang, P. Felsen, J. Malik, "Learning 3D human dynamics from video", CVPR 2019,
       :doi:`10.1109/CVPR.2019.00576`.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose.metrics import acceleration_error
    >>> true = np.zeros((5, 2, 3)) + [[[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]]  # m
    >>> pred = true.copy()
    >>> pred[2] += [0.01, 0.0, 0.0]  # a jump of 1 cm, for one frame
    >>> acceleration_error(true, pred)
    Score(13.3333, 'Accel|mm/frame²', 6 counted)
    >>> acceleration_error(true, pred, frame_rate=30, unit="m")
    Score(12, 'Accel|m/s²|frame_rate=30', 6 counted)
    """
    if frame_rate is not None:
        check_positive("frame_rate", frame_rate)
    points = read_points(y_true, y_pred, skeleton, sample_weight, data_unit)
    short = np.flatnonzero(np.array(points.lengths) < 3)
    if len(short):
        which = f"motion {short[0]}" if len(points.lengths) > 1 else "the motion"
        raise ValueError(
            f"an acceleration needs three frames, and {which} has {points.lengths[short[0]]}: pass consecutive frames "
            "of longer motions"
        )
    points = select_joints(align_points(points, root, align, reflection), joints)
    accelerations = _second_differences(points)
    value = mean_of(lengths_of(accelerations.pred), accelerations, average)
    value *= factor_of(data_unit, unit) * (1.0 if frame_rate is None else float(frame_rate) ** 2)
    options: dict[str, tuple[Any, Any]] = {"frame_rate": (frame_rate, None)}
    options |= options_of(root, joints, average, data_unit)
    per = PER_FRAME if frame_rate is None else PER_SECOND
    signature = signature_of(f"{PREFIXES[align]}Accel", unit + per, options, words_of(align, reflection))
    return Score(value, signature, *counts_of(accelerations))


def _second_differences(points: Points) -> Points:
    """Return the second differences of the errors as points: inside motions, where three frames are seen."""
    errors, first = points.pred - points.true, np.repeat(np.cumsum((0, *points.lengths[:-1])), points.lengths)
    index = np.arange(len(errors))
    last = first + np.repeat(points.lengths, points.lengths) - 1
    middle = index[(index > first) & (index < last)]
    differences = errors[middle - 1] - 2.0 * errors[middle] + errors[middle + 1]
    seen = points.seen[middle - 1] & points.seen[middle] & points.seen[middle + 1]
    lengths = tuple(length - 2 for length in points.lengths)
    return Points(np.zeros_like(differences), differences, seen, points.weights[middle], lengths, points.joint_names)
