"""The mean distance between predicted and true joints."""

from typing import Any, Literal

from skpose._utils.sklearn import validate_params
from skpose._utils.typing import ArrayLike
from skpose.kinematics._arrays import namespace_of
from skpose.scores._arrays import array_mpjpe
from skpose.scores._inputs import (
    CONSTRAINTS,
    LENGTHS,
    Joints,
    Length,
    check_data_unit,
    lengths_of,
    mean_of,
    read_errors,
)
from skpose.skeleton import Skeleton

Align = Literal["scale", "rigid", "similarity"]
Average = Literal["points", "frames", "joints"]


@validate_params(CONSTRAINTS, prefer_skip_nested_validation=True)
def mpjpe(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    *,
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
    r"""Mean per joint position error (MPJPE), optionally after alignment.

    The mean over frames and joints of the Euclidean distance between the predicted and the true position [1]_:

    .. math:: \frac{1}{n_\text{frames} \, n_\text{joints}} \sum_{f, j} \| \hat x_{fj} - x_{fj} \|_2

    Parameters
    ----------
    y_true : array-like of shape (n_frames, n_joints, 3)
        True positions of the joints; NaN where unknown, which does not count. Also (n_frames, 3 n_joints), as
        regressors have it, (n_motions, n_frames, n_joints, 3), or a list of motions. With a skeleton, poses of shape
        (n_frames, n_dofs), rad.
    y_pred : array-like
        Predicted positions, of the same shape, without NaN.
    root : int, str, or list of them, default=None
        Joint to which both are relative (root-relative MPJPE), or joints whose middle is the root, such as the hips; by
        name only with a skeleton. It counts as a joint of error zero, unless `joints` excludes it.
    align : {None, "scale", "rigid", "similarity"}, default=None
        Least-squares alignment of each predicted frame with the true one. "scale": a factor about the origin (N-MPJPE
        [2]_), which is the root if there is one. "rigid": a rotation and a translation. "similarity": these and a
        factor (PA-MPJPE, Procrustes alignment [3]_, "protocol 2").
    reflection : bool, default=False
        Whether "rigid" and "similarity" may also reflect.
    joints : int, str, or list of them, default=None
        Joints that count; all joints are aligned. None is all.
    average : {"points", "frames", "joints"} or None, default="points"
        "points": the mean over all known joints of all frames. "frames": first the mean of each frame; "joints": first
        the mean of each joint. They differ only if joints are unknown. None: the errors of all joints in all frames.
    unit : {"m", "cm", "mm"}, default="mm"
        Unit of the result.
    data_unit : {"m", "cm", "mm"}, default="m"
        Unit of the positions.
    skeleton : Skeleton, default=None
        The skeleton, if `y_true` and `y_pred` are poses. Positions are then relative to the root, as those of
        `forward_kinematics`.
    sample_weight : array-like of shape (n_frames,), default=None
        Weights of the frames, or of the motions if there are several.

    Returns
    -------
    float or ndarray of shape (n_frames, n_joints)
        The error. The array, for ``average=None``, has NaN where the truth is unknown, and no weights; its
        ``nanmean(axis=0)`` is the error of each joint, its ``nanmean(axis=1)`` the error of each frame.

    Raises
    ------
    ValueError
        For different shapes, NaN in predictions, and Procrustes alignment of a frame with less than three joints, or
        with joints on one line, whose rotation is not determined.

    Warns
    -----
    UserWarning
        If the true joints of a frame are less than 2 cm or more than 10 m apart, or poses look like degrees.

    See Also
    --------
    pck : Share of the joints within a distance.
    sklearn.metrics.make_scorer : Makes a scorer: ``make_scorer(mpjpe, greater_is_better=False)``.

    Notes
    -----
    100,000 frames of 17 joints take 0.1 s, with Procrustes alignment 1 s.

    Arrays of torch, JAX, CuPy or another library of the array API standard give an array of that library, with
    gradients, without `align`. Their values are not checked: NaN in a prediction gives NaN.

    References
    ----------
    .. [1] C. Ionescu, D. Papava, V. Olaru, C. Sminchisescu, "Human3.6M", IEEE Transactions on Pattern Analysis and
       Machine Intelligence 36(7), 2014, :doi:`10.1109/TPAMI.2013.248`.
    .. [2] H. Rhodin et al., "Learning monocular 3D human pose estimation from multi-view images", CVPR 2018,
       :doi:`10.1109/CVPR.2018.00880`.
    .. [3] S. Umeyama, "Least-squares estimation of transformation parameters between two point patterns", IEEE
       Transactions on Pattern Analysis and Machine Intelligence 13(4), 1991, :doi:`10.1109/34.88573`, eqs. 40 to 43.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose.scores import mpjpe
    >>> true = np.random.default_rng(0).normal(scale=0.3, size=(100, 17, 3))  # m
    >>> pred = 1.1 * true + [0.0, 0.0, 0.02]
    >>> round(mpjpe(true, pred), 2)  # mm
    51.53
    >>> round(mpjpe(true, pred, root=0), 2), round(mpjpe(true, pred, align="similarity"), 6)
    (60.23, 0.0)
    >>> mpjpe(true, pred, average=None).mean(axis=0).round(1)[:3]  # of each joint
    array([47.2, 52. , 52.4])
    """
    xp, factor = namespace_of(y_true, y_pred), LENGTHS[data_unit] / LENGTHS[unit]
    if xp is not None:
        check_data_unit(skeleton, data_unit)
        return array_mpjpe(xp, y_true, y_pred, root, align, joints, average, skeleton, sample_weight) * factor
    errors, weights, _ = read_errors(
        y_true, y_pred, skeleton, sample_weight, data_unit, root, align, reflection, joints
    )
    return mean_of(lengths_of(errors), weights, average) * factor
