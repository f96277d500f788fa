"""The difference between the accelerations of predicted and true joints."""

from numbers import Real
from typing import Any

import numpy as np

from skpose._utils.sklearn import Interval, validate_params
from skpose._utils.typing import ArrayLike
from skpose.scores._inputs import CONSTRAINTS, LENGTHS, Joints, Length, lengths_of, mean_of, read_errors
from skpose.scores._mpjpe import Align, Average
from skpose.skeleton import Skeleton


@validate_params(
    CONSTRAINTS | {"frame_rate": [Interval(Real, 0, None, closed="neither"), None]},
    prefer_skip_nested_validation=True,
)
def acceleration_error(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    *,
    frame_rate: float | None = None,
    root: Joints | None = None,
    align: Align | None = None,
    reflection: bool = False,
    joints: Joints | None = None,
    average: Average | None = "points",
    unit: Length = "mm",
    data_unit: Length = "m",
    skeleton: Skeleton | None = None,
    sample_weight: ArrayLike | None = None,
) -> Any:
    r"""Mean length of the difference between the accelerations of predicted and true joints, a measure of jitter.

    Accelerations are second differences of consecutive frames [1]_: with :math:`e_f = \hat x_f - x_f` the result is the
    mean of :math:`\| e_{f-1} - 2 e_f + e_{f+1} \|_2` over joints and inner frames.

    Parameters
    ----------
    y_true : array-like of shape (n_frames, n_joints, 3)
        Consecutive frames of one motion, or several motions as (n_motions, n_frames, n_joints, 3) or as a list, see
        `mpjpe`. Accelerations that contain an unknown position do not count.
    y_pred : array-like
        Predicted positions.
    frame_rate : float, default=None
        Frames per second; the result is then in ``unit``/s². None is ``unit``/frame², as in most publications, which
        cannot be compared between frame rates.
    root : int, str, or list of them, default=None
        Joint to which both are relative, see `mpjpe`.
    align : {None, "scale", "rigid", "similarity"}, default=None
        Alignment of each frame, before differences are taken, see `mpjpe`.
    reflection : bool, default=False
        Whether "rigid" and "similarity" may also reflect.
    joints : int, str, or list of them, default=None
        Joints that count.
    average : {"points", "frames", "joints"} or None, default="points"
        What is averaged first, see `mpjpe`. None: the errors of all joints in all inner frames.
    unit : {"m", "cm", "mm"}, default="mm"
        Unit of length in the result.
    data_unit : {"m", "cm", "mm"}, default="m"
        Unit of the positions.
    skeleton : Skeleton, default=None
        The skeleton, if `y_true` and `y_pred` are poses.
    sample_weight : array-like of shape (n_frames,), default=None
        Weights of the frames, for an acceleration the weight of its middle frame; or of the motions if there are
        several.

    Returns
    -------
    float or ndarray of shape (n_inner_frames, n_joints)
        The error; the array, for ``average=None``, has two frames less per motion than `y_true`.

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
    >>> from skpose.scores import acceleration_error
    >>> true = np.zeros((5, 2, 3)) + [[[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]]  # m
    >>> pred = true.copy()
    >>> pred[2] += [0.01, 0.0, 0.0]  # a jump of 1 cm, for one frame
    >>> round(acceleration_error(true, pred), 2)  # mm/frame²
    13.33
    >>> round(acceleration_error(true, pred, frame_rate=30, unit="m"), 2)  # m/s²
    12.0
    """
    errors, weights, motions = read_errors(
        y_true, y_pred, skeleton, sample_weight, data_unit, root, align, reflection, joints
    )
    if min(motions.lengths) < 3:
        raise ValueError(f"each motion must have at least three frames, got one with {min(motions.lengths)}")
    middle = np.concatenate([part[1:-1] for part in motions.split(np.arange(len(errors)))])
    second = errors[middle - 1] - 2.0 * errors[middle] + errors[middle + 1]
    factor = LENGTHS[data_unit] / LENGTHS[unit] * (1.0 if frame_rate is None else float(frame_rate) ** 2)
    return mean_of(lengths_of(second), weights[middle], average) * factor
