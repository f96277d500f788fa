"""Motions through key poses: along geodesics, or along a smooth curve."""

from dataclasses import replace
from functools import partial
from numbers import Integral

import numpy as np
from joblib import effective_n_jobs
from sklearn.exceptions import ConvergenceWarning

from skpose._compat.sklearn import StrOptions, validate_params
from skpose._parallel.threads import in_threads
from skpose._typing import ArrayLike
from skpose._validation.limits import check_limits
from skpose._validation.motions import check_frame_rate
from skpose._validation.numbers import as_numbers
from skpose._validation.poses import check_poses
from skpose._validation.units import warn_of_degrees
from skpose._warnings import warn
from skpose.geodesics._geodesic import GeodesicResult, shortest_path
from skpose.geodesics._root_between import root_between
from skpose.geodesics._spline import spline_between
from skpose.metrics import Geodesic, Metric
from skpose.metrics._shared import METRIC_CONSTRAINTS, require_geodesic
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import limited_dofs, remove_jumps

ON_KEY = 1e-6  # frames between a frame and a key that are at one time


@validate_params(
    METRIC_CONSTRAINTS
    | {
        "method": [StrOptions(["geodesic", "spline"])],
        "joint_limits": [StrOptions(["ignore", "enforce"])],
        "n_jobs": [None, Integral],
    },
    prefer_skip_nested_validation=True,
)
def interpolate(
    poses: ArrayLike | Motion,
    times: ArrayLike | None = None,
    skeleton: Skeleton | None = None,
    *,
    frame_rate: float,
    method: str = "spline",
    metric: str | Metric = "geodesic",
    joint_limits: str = "ignore",
    n_jobs: int | None = None,
) -> Motion:
    r"""Return a motion through key poses at given times.

    The shortest paths from key to key, at constant speed, or a smooth curve on the kinematic manifold. Every frame is
    a pose of the skeleton, so that bones keep their lengths.

    Parameters
    ----------
    poses : Motion, or array-like of shape (n_poses, n_dofs)
        Key poses, at least two: joint angles, rad. Those of a Motion have a root, which is interpolated too; of an
        array nothing is known of it, and it stays at rest.
    times : array-like of shape (n_poses,), default=None
        Their times, s, increasing. None is those of a Motion; an array needs them.
    skeleton : Skeleton, default=None
        The skeleton of the poses. None is that of a Motion; an array needs it.
    frame_rate : float
        Frames a second of the motion.
    method : {"spline", "geodesic"}, default="spline"
        "geodesic" goes along the geodesic to each next key at constant speed; directions and speeds change at the keys.
        "spline" has continuous velocities of the joints, and may swing out further than the keys.
    metric : str or Metric, default="geodesic"
        The geodesics from key to key: "geodesic", or a ``skpose.metrics.Geodesic`` with its parameters.
    joint_limits : {"ignore", "enforce"}, default="ignore"
        "enforce" keeps all frames inside ``skeleton.limits``, as in `geodesic`. The keys must be inside. A dof that
        the spline would swing out past its limit stops there.
    n_jobs : int, default=None
        Threads, as in scikit-learn.

    Returns
    -------
    Motion
        Frames at ``times[0] + i / frame_rate`` up to ``times[-1]``. A key pose that falls on a frame is met exactly.
        The numbers of the angles do not jump from frame to frame; those of a key may be others of the same rotations,
        but for dofs whose limits are enforced.
        The root has the axes, the axis that points up and the name of that of a Motion; axes that cannot describe a
        rotation between two keys are replaced by "xyz".

    Raises
    ------
    ValueError
        For fewer than two poses, poses of the wrong width, out of order by name or not finite; for times of the wrong
        shape, not finite or not increasing; for a frame rate that is not positive; for arrays without times or
        skeleton, and a Motion with another skeleton than the one given; for limits to be enforced on a skeleton that
        has none, or on poses outside of them: the message names the dof, its angle and its limits.

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge: the motion is still one through the keys.
    UserWarning
        If the poses look like degrees, see `skpose.pose_distances`.

    See Also
    --------
    geodesic : The path between two poses.
    Motion.resample : Another frame rate, each joint by itself.

    Notes
    -----
    *Spline.* The curve of geodesics is unrolled onto one flat space by parallel transport, a natural cubic spline is
    drawn through the keys there, and is rolled up again [1]_. Rolled up, a difference from the geodesics is a velocity
    of the joints, which these follow for a unit of time, each by its own turn. For one joint with one angle it is the
    natural cubic spline of the angle. De Casteljau's algorithm [2]_ would take three geodesics for each frame, and
    slopes from elsewhere. ``benchmarks/in_betweening.py`` compares with other methods.

    *The root* goes from key to key in a straight line with "geodesic", and rotates by slerp. With "spline" its position
    is the natural cubic spline of the keys, and its orientation ``scipy``'s RotationSpline, whose angular acceleration
    is continuous. It rotates by less than half a turn from key to key: faster turns need more keys. Poses and root are
    interpolated each by itself, so that a foot that stands on the floor at two keys may slide between them.

    *Twists.* What no joint shows turns as on the line to the next key, by slerp for joints with three dofs, and its
    speed may change at keys; so do joints without weight. Where a limb is nearly straight, small movements may need
    large turns: geodesics take them, and the spline adds little to these.

    *Limits.* Under "enforce" the geodesics keep the limits, and each angle of a pose of the spline is clipped to its
    own. The velocity of that dof is then zero at once, as at the stop of a hinge; the other dofs follow the spline.

    *Velocities.* They are those of the positions. A geodesic is made of n_steps slerps, between which velocities
    change a little; less with more of them.

    The time is that of a geodesic for each key, some milliseconds or some tens where it is refined; "spline" takes some
    milliseconds for each frame too.

    References
    ----------
    .. [1] P. E. Jupp, J. T. Kent, "Fitting smooth paths to spherical data", Applied Statistics 36(1), 1987,
       :doi:`10.2307/2347843`.
    .. [2] F. C. Park, B. Ravani, "Bézier curves on Riemannian manifolds and Lie groups with kinematics applications",
       Journal of Mechanical Design 117(1), 1995, :doi:`10.1115/1.2826114`.

    Examples
    --------
    An arm that goes up, and down again:

    >>> from skpose import Skeleton
    >>> from skpose.geodesics import interpolate
    >>> arm = Skeleton.chain(1)
    >>> keys, times = [[0.0], [1.0], [0.0]], [0.0, 1.0, 2.0]
    >>> interpolate(keys, times, arm, frame_rate=2, method="geodesic").angles.ravel().round(3)
    array([0. , 0.5, 1. , 0.5, 0. ])
    >>> interpolate(keys, times, arm, frame_rate=2).angles.ravel().round(2)  # slows down at the top
    array([0.  , 0.69, 1.  , 0.69, 0.  ])

    Every tenth frame of a recording as keys, and all that is known of the root:

    >>> import numpy as np
    >>> from skpose import Motion
    >>> forward = np.linspace([0, 1, 0], [0, 1, 2], 61)
    >>> recording = Motion(arm, np.sin(np.linspace(0, 3, 61))[:, None], 30, root_positions=forward)
    >>> motion = interpolate(recording[::10], frame_rate=30)
    >>> len(motion), np.allclose(motion.root_positions, forward)
    (61, True)
    """
    keys, skeleton, times = _check_keys(poses, times, skeleton)
    X = check_poses(poses if keys is None else keys.angles, skeleton, "poses").astype(np.float64)
    if len(X) < 2:
        raise ValueError(f"poses must be at least two key poses, got {len(X)}: one pose is no motion")
    warn_of_degrees(None, skeleton, poses=X)
    limited = None
    if joint_limits == "enforce":
        X = check_limits(X, skeleton, "poses" if keys is None else "poses.angles")
        limited = limited_dofs(skeleton.bones)
    frame_rate = check_frame_rate(frame_rate)
    at = _check_times(times, len(X), frame_rate)
    n_threads = effective_n_jobs(n_jobs)
    chosen = require_geodesic(metric, skeleton, "interpolate")
    geodesics = _geodesics(X, skeleton, chosen, joint_limits, n_threads)
    segment, shares = _locate_frames(at, frame_rate)
    in_segments = [shares[segment == i] for i in range(len(geodesics))]
    if method == "spline":
        between = spline_between(geodesics, np.diff(at), in_segments, skeleton, joint_limits, n_threads)
    else:
        between = [path._at(share) for path, share in zip(geodesics, in_segments, strict=True)]
    frames = np.concatenate(between)
    on_key = np.isin(shares, [0.0, 1.0])
    frames[on_key] = X[(segment + shares.astype(int))[on_key]]
    motion = Motion(skeleton, remove_jumps(skeleton.bones, frames, limited), frame_rate)
    if keys is None:
        return motion
    positions, angles, axes = root_between(keys, at, at[segment] + shares * np.diff(at)[segment], method)
    positions[on_key] = keys.root_positions[(segment + shares.astype(int))[on_key]]
    return replace(
        motion,
        root_positions=positions,
        root_angles=angles,
        root_axes=axes,
        up=keys.up,
        root_name=keys.root_name,
        seen=None if keys.seen is None else keys.seen[segment] & keys.seen[segment + 1],
    )


def _check_keys(
    poses: ArrayLike | Motion, times: ArrayLike | None, skeleton: Skeleton | None
) -> tuple[Motion | None, Skeleton, ArrayLike]:
    """Return the keys as a Motion, or None for an array, their skeleton, and their times."""
    if isinstance(poses, Motion):
        if skeleton is not None and skeleton != poses.skeleton:
            raise ValueError("skeleton must be that of the Motion or None, got another one; retarget converts motions")
        return poses, poses.skeleton, poses.times if times is None else times
    if times is None or skeleton is None:
        missing = "times" if times is None else "skeleton"
        raise ValueError(f"an array of key poses needs {missing}=")
    return None, skeleton, times


def _check_times(times: ArrayLike, n_poses: int, frame_rate: float) -> np.ndarray:
    """Return the times of the keys as an array that increases."""
    at = as_numbers(times, "times")
    if at.shape != (n_poses,):
        raise ValueError(f"times must have shape ({n_poses},), one for each of the poses, got {at.shape}")
    if not (np.diff(at) * frame_rate > 2.0 * ON_KEY).all():  # NaN too
        i = int(np.argmin(np.diff(at)))
        raise ValueError(f"times must be finite and increase, got {at[i]!r} s followed by {at[i + 1]!r} s")
    return at


def _geodesics(
    X: np.ndarray, skeleton: Skeleton, metric: Geodesic, joint_limits: str, n_jobs: int
) -> list[GeodesicResult]:
    """Return the geodesics from each key to the next; one warning for all that did not converge."""
    found: dict[int, GeodesicResult] = {}

    def find(i: int) -> None:
        found[i] = shortest_path(X[i], X[i + 1], skeleton, metric, joint_limits)

    in_threads((partial(find, i) for i in range(len(X) - 1)), n_jobs)
    n_unconverged = sum(not path.converged for path in found.values())
    if n_unconverged:
        warn(
            f"{n_unconverged} of the {len(found)} geodesics between keys did not converge; a larger n_steps may help",
            ConvergenceWarning,
        )
    return [found[i] for i in range(len(X) - 1)]


def _locate_frames(times: np.ndarray, frame_rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Return of each frame the segment between keys that it is in, and its share of the time there, 0 or 1 on keys."""
    keys = (times - times[0]) * frame_rate  # in frames
    frames = np.arange(np.floor(keys[-1] + ON_KEY) + 1)
    nearest = np.abs(keys - np.rint(keys)) < ON_KEY
    keys[nearest] = np.rint(keys[nearest])
    segment = np.clip(np.searchsorted(keys, frames, side="right") - 1, 0, len(keys) - 2)
    return segment, (frames - keys[segment]) / np.diff(keys)[segment]
