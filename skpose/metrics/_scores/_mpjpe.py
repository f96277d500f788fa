"""The mean distance between predicted and true joints."""

from typing import Any, Literal

from skpose._typing import ArrayLike
from skpose.metrics._scores._align import align as align_points
from skpose.metrics._scores._points import counts_of, factor_of, lengths_of, mean_of, read_points, select_joints
from skpose.metrics._scores._score import Score, signature_of
from skpose.skeleton import Skeleton

Length = Literal["m", "cm", "mm"]
Align = Literal["scale", "rigid", "similarity"]
Average = Literal["points", "frames", "joints"]
Root = int | str | list[int] | list[str]
PREFIXES = {None: "", "scale": "N-", "rigid": "PA-", "similarity": "PA-"}


def words_of(align: str | None, reflection: bool) -> tuple[str, ...]:
    """Return the words of a signature about an alignment."""
    words = {"rigid": ("rigid",), "similarity": ("scale",)}.get(align or "", ())
    return (*words, "reflection") if reflection else words


def mpjpe(
    y_true: ArrayLike,
    y_pred: ArrayLike,
    *,
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
    r"""Return the mean per joint position error (MPJPE), after alignment if requested.

    The mean over frames and joints of the Euclidean distance between the predicted and the true position [1]_:

    .. math:: \frac{1}{n_\text{frames} \, n_\text{joints}} \sum_{f, j} \| \hat x_{fj} - x_{fj} \|_2

    Parameters
    ----------
    y_true : array-like of shape (n_frames, n_joints, 3)
        True positions of the joints. NaN where a joint is not known: it is left out, and counted in the result. Also
        (n_frames, 3 n_joints), as regressors have it, (n_motions, n_frames, n_joints, 3), or a list of motions; with a
        skeleton, poses of shape (n_frames, n_dofs), rad.
    y_pred : as y_true
        Predicted positions, of the same shape. NaN is refused.
    root : int, str, or list of them, default=None
        The joint that both are relative to (root-relative MPJPE), or some whose middle it is, such as the hips; by name
        with a skeleton. It counts as a joint whose error is zero, unless `joints` leaves it out. None is none.
    align : {None, "scale", "rigid", "similarity"}, default=None
        What takes each predicted frame to the true one, by least squares. "scale": a factor about the origin (N-MPJPE
        [2]_), which with `root` is the root. "rigid": a rotation and a translation. "similarity": these and a factor
        (PA-MPJPE, Procrustes alignment [3]_; "protocol 2").
    reflection : bool, default=False
        Whether a mirror image is as good as a rotation, for "rigid" and "similarity".
    joints : int, str, or list of them, default=None
        The joints that count; all take part in the alignment. None is all.
    average : {"points", "frames", "joints"}, default="points"
        What is averaged first where joints are missing: "points", all joints of all frames count equally; "frames",
        first those of each frame; "joints", first the frames of each joint. Without missing joints they are equal.
    unit : {"m", "cm", "mm"}, default="mm"
        Unit of the result.
    data_unit : {"m", "cm", "mm"}, default="m"
        Unit of the positions.
    skeleton : Skeleton, default=None
        The skeleton of poses; their joints are relative to the root as `forward_kinematics` has them. None is
        positions.
    sample_weight : array-like of shape (n_frames,), default=None
        Weights of the frames, or of motions where several are given.

    Returns
    -------
    Score
        The error, a number with its unit, signature and counts.

    Raises
    ------
    ValueError
        For shapes that differ; for predictions that are NaN; for an unknown unit or option; for Procrustes alignment
        of a frame with less than three joints, or whose joints are one point or lie on one line, so that the rotation
        is not determined.

    Warns
    -----
    UserWarning
        If the true joints of a frame are less than 2 cm or more than 10 m apart, which is a sign of another unit; if
        poses look like degrees.

    See Also
    --------
    pck : The share of joints that are near enough.
    pose_score : The same by a signature, "PA-MPJPE|mm|scale".
    get_scorer : A scorer for scikit-learn.

    Notes
    -----
    Frames of a motion or independent ones; their order has no effect. 100,000 frames of 17 joints take 0.1 s, with
    Procrustes alignment 1 s.

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
    >>> from skpose.metrics import mpjpe
    >>> true = np.random.default_rng(0).normal(scale=0.3, size=(100, 17, 3))  # m
    >>> pred = 1.1 * true + [0.0, 0.0, 0.02]
    >>> mpjpe(true, pred)
    Score(51.5287, 'MPJPE|mm', 1700 counted)
    >>> mpjpe(true, pred, root=0)
    Score(60.2287, 'MPJPE|mm|root=0', 1700 counted)
    >>> print(f'{mpjpe(true, pred, align="similarity"):.6f}')
    0.000000
    """
    points = read_points(y_true, y_pred, skeleton, sample_weight, data_unit)
    points = select_joints(align_points(points, root, align, reflection), joints)
    distances = lengths_of(points.pred - points.true)
    value = mean_of(distances, points, average) * factor_of(data_unit, unit)
    options = options_of(root, joints, average, data_unit)
    signature = signature_of(f"{PREFIXES[align]}MPJPE", unit, options, words_of(align, reflection))
    return Score(value, signature, *counts_of(points))


def options_of(root: Any, joints: Any, average: str, data_unit: str) -> dict[str, tuple[Any, Any]]:
    """Return the options that scores of positions share, with their defaults."""
    return {
        "root": (root, None),
        "joints": (joints, None),
        "average": (average, "points"),
        "data_unit": (data_unit, "m"),
    }
