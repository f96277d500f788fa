"""Motions through key poses, along geodesics or a spline."""

from dataclasses import replace
from functools import partial
from itertools import pairwise
from numbers import Integral
from typing import NamedTuple

import numpy as np
from joblib import effective_n_jobs
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import RotationSpline, Slerp
from sklearn.exceptions import ConvergenceWarning

from skpose._compiled.path.exponential import tangent_space
from skpose._compiled.pose.tree import Tree
from skpose._utils.parallel import in_threads
from skpose._utils.sklearn import StrOptions, validate_params
from skpose._utils.typing import ArrayLike
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import as_numbers, check_frame_rate, check_limits, check_poses, limits_of
from skpose._utils.warnings import warn
from skpose.geodesics._geodesic import GeodesicResult, shortest_path
from skpose.kinematics._forward import weighted_positions
from skpose.kinematics._tree import from_tree_order, jacobian_at, retract, to_tree_order, tree_of
from skpose.metrics import Geodesic, Metric
from skpose.metrics._registry import METRIC_CONSTRAINTS, require_geodesic
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._bone import limited_dofs
from skpose.skeleton._root import continuous_root_angles, root_orientations
from skpose.skeleton._rotations import remove_jumps

NEAR_END = 1e-4  # step from the ends of a geodesic, relative to its length, for its velocity there
DAMPING = 0.5  # 1/rad, of turns that hardly move the joints, relative to the size of the whole displacement
SOLUTIONS = 3  # steps of iterated Tikhonov regularisation
ROUNDING = 1e-12  # of the metric tensor, relative to its trace
ORTHONORMAL = 2  # Newton-Schulz iterations; error below 1e-4 for a turn by 20°


class Segment(NamedTuple):
    """What the spline needs of the geodesic from one key to the next."""

    path: GeodesicResult
    first: np.ndarray  # (n, rank) basis of the tangent space at the first key
    last: np.ndarray
    leaving: np.ndarray  # (rank,) first velocity per unit of s, in the basis
    arriving: np.ndarray
    forth: np.ndarray  # (rank at the last key, rank at the first) parallel transport


def spline_between(
    geodesics: list[GeodesicResult],
    spans: np.ndarray,
    shares: list[np.ndarray],
    skeleton: Skeleton,
    joint_limits: str,
    n_jobs: int,
) -> list[np.ndarray]:
    """Poses between keys, for each segment.

    `spans` are the times between keys, and `shares` the fractions s of the poses of each segment. With
    joint_limits="enforce" the angles are clipped.
    """
    segments = in_threads((partial(_segment_of, path, skeleton) for path in geodesics), n_jobs)
    slopes = natural_slopes(segments, spans)

    def draw(i: int) -> np.ndarray:
        segment, h = segments[i], spans[i]
        start = h * slopes[i] - segment.leaving
        end = h * slopes[i + 1] - segment.arriving
        drawn = _draw(segment, start, end, shares[i], skeleton)
        return np.clip(drawn, *limits_of(skeleton).T) if joint_limits == "enforce" else drawn

    return in_threads((partial(draw, i) for i in range(len(geodesics))), n_jobs)


def natural_slopes(segments: list[Segment], spans: np.ndarray) -> list[np.ndarray]:
    """Slopes of the natural cubic spline at the keys, per unit of time, in the basis of each key.

    Solves h' m₋ + 2 (h + h') m + h m₊ = 3 (h' a + h a'), with h the time before a key and h' the time after it.
    """
    n = len(segments)
    share, right = np.full(n, 0.5), [1.5 * segments[0].leaving / spans[0]]
    for i in range(1, n + 1):
        before = segments[i - 1]
        arriving, brought = before.arriving / spans[i - 1], before.forth @ right[i - 1]
        if i == n:
            right.append((3.0 * arriving - brought) / (2.0 - share[i - 1]))
            break
        h, after = spans[i - 1], spans[i]
        pivot = 2.0 * (h + after) - after * share[i - 1]
        leaving = segments[i].leaving / after
        share[i] = h / pivot
        right.append((3.0 * (after * arriving + h * leaving) - after * brought) / pivot)
    slopes = [right[n]]
    for i in range(n - 1, -1, -1):
        slopes.append(right[i] - share[i] * (segments[i].forth.T @ slopes[-1]))
    return slopes[::-1]


def _segment_of(path: GeodesicResult, skeleton: Skeleton) -> Segment:
    tree = tree_of(skeleton)
    shares = np.linspace(0.0, 1.0, len(path.path))
    ends = np.array([NEAR_END, 2.0 * NEAR_END])
    poses = path._at(np.concatenate([shares, ends, 1.0 - ends]))
    near = weighted_positions(poses[[0, -4, -3, len(shares) - 1, -2, -1]], skeleton)
    difference = np.array([-1.5, 2.0, -0.5]) / NEAR_END
    bases = _bases(tree, poses[: len(shares)])
    forth = _transport(np.eye(bases[0].shape[1]), [_step(before, after) for before, after in pairwise(bases)])[-1]
    first, last = bases[0], bases[-1]
    leaving, arriving = first.T @ (difference @ near[:3]), -last.T @ (difference @ near[3:])
    return Segment(path, first, last, leaving, arriving, _turn(forth @ leaving, arriving) @ forth)


def _turn(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The smallest rotation from the direction of a to the direction of b.

    A geodesic transports its own velocity; this makes the transport along its chords do so exactly.
    """
    lengths = np.linalg.norm(a), np.linalg.norm(b)
    if min(lengths) == 0.0:
        return np.eye(len(a))
    u, v = a / lengths[0], b / lengths[1]
    if u @ v < 0.0:  # chords too long to determine the rotation
        return np.eye(len(a))
    return np.eye(len(a)) - np.outer(u + v, u + v) / (1.0 + u @ v) + 2.0 * np.outer(v, u)


def _draw(segment: Segment, start: np.ndarray, end: np.ndarray, shares: np.ndarray, skeleton: Skeleton) -> np.ndarray:
    """Poses of the spline between two keys, from the differences of its slopes from the geodesic's at the ends."""
    tree = tree_of(skeleton)
    nodes, at = np.unique(np.concatenate([np.linspace(0.0, 1.0, len(segment.path.path)), shares]), return_inverse=True)
    base = segment.path._at(nodes)
    bases = _bases(tree, base)
    steps = [_step(before, after) for before, after in pairwise(bases)]
    forth = _transport(bases[0].T @ (segment.first @ start), steps)
    back = _transport(bases[-1].T @ (segment.last @ end), [step.T for step in steps[::-1]])[::-1]
    poses, dofs = base.copy(), to_tree_order(tree, base)
    drawn = at[len(at) - len(shares) :]
    for k in sorted(set(drawn)):
        s = nodes[k]
        off = bases[k] @ (s * (1.0 - s) ** 2 * forth[k] - s**2 * (1.0 - s) * back[k])
        poses[k] = from_tree_order(tree, _displace(tree, dofs[k], off), base[k])
    return poses[drawn]


def _displace(tree: Tree, pose: np.ndarray, displacement: np.ndarray) -> np.ndarray:
    """Displace the joints of a pose by one damped Gauss-Newton step.

    Iterated Tikhonov regularisation keeps straight limbs from twisting far for a small movement. The damping vanishes
    with the displacement, so the velocity of the curve is exact where it meets the geodesic.
    """
    size = np.linalg.norm(displacement)
    if size == 0.0:
        return pose
    jacobian = jacobian_at(tree, pose, True)
    matrix = jacobian.T @ jacobian
    matrix[np.diag_indices(len(matrix))] += max((DAMPING * size) ** 2, ROUNDING * np.trace(matrix))
    inverse, turns = np.linalg.inv(matrix), np.zeros(len(matrix))
    for _ in range(SOLUTIONS):
        turns += inverse @ (jacobian.T @ (displacement - jacobian @ turns))
    return retract(tree, pose, turns, True)


def _transport(vector: np.ndarray, steps: list[np.ndarray]) -> list[np.ndarray]:
    """A vector, or several, at all poses of a path, transported from the first."""
    carried = [vector]
    for step in steps:
        carried.append(step @ carried[-1])
    return carried


def _bases(tree: Tree, poses: np.ndarray) -> list[np.ndarray]:
    return [tangent_space(tree, pose) for pose in to_tree_order(tree, poses)]


def _step(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Transport between two close tangent spaces: the projection, made orthonormal (Newton, Schulz).

    A direction in only one of the two spaces, as near a straight limb, becomes short.
    """
    matrix = after.T @ before
    for _ in range(ORTHONORMAL):
        matrix = 1.5 * matrix - 0.5 * matrix @ (matrix.T @ matrix)
    return matrix


# --- interpolate ------------------------------------------------------------------------------------------------------


ON_KEY = 1e-6  # tolerance, in frames, for a key that falls on a frame


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
    r"""Interpolate a motion through key poses.

    The motion follows the shortest paths from key to key at constant speed, or a smooth curve on the kinematic
    manifold. Every frame is a pose of the skeleton, so bones keep their lengths.

    Parameters
    ----------
    poses : Motion, or array-like of shape (n_poses, n_dofs)
        At least two key poses: joint angles, rad. The root of a Motion is interpolated too; for an array it stays at
        rest.
    times : array-like of shape (n_poses,), default=None
        Increasing times of the keys, s. Required for an array; None takes the times of the Motion.
    skeleton : Skeleton, default=None
        The skeleton of the poses. Required for an array; None takes the skeleton of the Motion.
    frame_rate : float
        Frames per second of the result.
    method : {"spline", "geodesic"}, default="spline"
        "geodesic" follows the geodesic from each key to the next at constant speed; direction and speed change at the
        keys. "spline" has continuous joint velocities and may overshoot the keys.
    metric : str or Metric, default="geodesic"
        "geodesic" or a ``skpose.metrics.Geodesic`` object.
    joint_limits : {"ignore", "enforce"}, default="ignore"
        "enforce" keeps all frames inside ``skeleton.limits``, as in `geodesic`. The keys must be inside. The spline is
        clipped at the limits.
    n_jobs : int, default=None
        Number of threads, as in scikit-learn.

    Returns
    -------
    Motion
        Frames at ``times[0] + i / frame_rate`` up to ``times[-1]``. Key poses on frames are met exactly. Angles do not
        jump from frame to frame, so the angles at a key may differ from the key's by an equivalent rotation, except
        for dofs with enforced limits. The root keeps the axes, up axis and name of the Motion; axes that cannot
        describe an intermediate rotation become "xyz".

    Raises
    ------
    ValueError
        If there are fewer than two poses, poses have the wrong number of columns, their columns are in the wrong order
        (checked by name), or they are not finite; if times are not finite or do not increase; if an array comes without
        times or skeleton, or a Motion with a different skeleton; if limits are to be enforced but the skeleton has
        none, or a key is outside.

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge. The motion still passes through the keys.
    UserWarning
        If the poses seem to be in degrees, see `skpose.pose_distances`.

    See Also
    --------
    geodesic : The path between two poses.
    Motion.resample : Change the frame rate joint by joint.

    Notes
    -----
    *Spline.* The geodesics between the keys are unrolled onto a flat space by parallel transport, a natural cubic
    spline is drawn through the keys there, and the result is rolled back [1]_: the difference from the geodesics
    becomes a velocity of the joints, followed for a unit of time with constant turning rates. For one joint with one
    angle this is the natural cubic spline of the angle. De Casteljau's algorithm [2]_ would take three geodesics per
    frame and needs slopes at the keys.

    *Root.* With "geodesic", positions are linear and orientations use slerp. With "spline", positions are a natural
    cubic spline and orientations scipy's RotationSpline with continuous angular acceleration. The root turns by less
    than half a turn from key to key; faster turns need more keys. Poses and root are interpolated independently, so
    planted feet may slide.

    *Twists.* Twists that move no joint, and joints without weight, follow the straight line between keys (slerp for
    joints with three dofs); their speed may change at keys. If a limb is nearly straight, small movements may need
    large turns: geodesics take them, and the spline adds little.

    *Limits.* With "enforce" the geodesics stay inside the limits, and every angle of the spline is clipped. The
    velocity of that dof then drops to zero at once, as at the stop of a hinge; the other dofs follow the spline.

    *Velocities.* With "spline", velocities of the joint positions are continuous, up to small changes between the
    n_steps slerps of a geodesic; more steps reduce these.

    Each key takes one geodesic, a few milliseconds or tens of milliseconds if it is refined; "spline" takes a few
    milliseconds per frame in addition.

    References
    ----------
    .. [1] P. E. Jupp, J. T. Kent, "Fitting smooth paths to spherical data", Applied Statistics 36(1), 1987,
       :doi:`10.2307/2347843`.
    .. [2] F. C. Park, B. Ravani, "Bézier curves on Riemannian manifolds and Lie groups with kinematics applications",
       Journal of Mechanical Design 117(1), 1995, :doi:`10.1115/1.2826114`.

    Examples
    --------
    An arm that goes up and down again:

    >>> from skpose import Skeleton
    >>> from skpose.geodesics import interpolate
    >>> arm = Skeleton.chain(1)
    >>> keys, times = [[0.0], [1.0], [0.0]], [0.0, 1.0, 2.0]
    >>> interpolate(keys, times, arm, frame_rate=2, method="geodesic").angles.ravel().round(3)
    array([0. , 0.5, 1. , 0.5, 0. ])
    >>> interpolate(keys, times, arm, frame_rate=2).angles.ravel().round(2)  # slower at the top
    array([0.  , 0.69, 1.  , 0.69, 0.  ])

    Every tenth frame of a recording as keys, with its root:

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
        raise ValueError(f"poses must contain at least two key poses, got {len(X)}")
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
    """The keys as a Motion (None for an array), their skeleton and their times."""
    if isinstance(poses, Motion):
        if skeleton is not None and skeleton != poses.skeleton:
            raise ValueError("skeleton must be None or equal to the skeleton of the Motion; use retarget to convert it")
        return poses, poses.skeleton, poses.times if times is None else times
    if times is None or skeleton is None:
        missing = "times" if times is None else "skeleton"
        raise ValueError(f"an array of key poses needs {missing}=")
    return None, skeleton, times


def _check_times(times: ArrayLike, n_poses: int, frame_rate: float) -> np.ndarray:
    at = as_numbers(times, "times")
    if at.shape != (n_poses,):
        raise ValueError(f"times must have shape ({n_poses},), one per pose, got {at.shape}")
    if not (np.diff(at) * frame_rate > 2.0 * ON_KEY).all():  # also rejects NaN
        raise ValueError(f"times must be finite and increasing, got {at}")
    return at


def _geodesics(
    X: np.ndarray, skeleton: Skeleton, metric: Geodesic, joint_limits: str, n_jobs: int
) -> list[GeodesicResult]:
    """The geodesics from each key to the next, with one warning for all."""
    pairs = pairwise(X)
    found = in_threads((partial(shortest_path, *pair, skeleton, metric, joint_limits) for pair in pairs), n_jobs)
    n_unconverged = sum(not path.converged for path in found)
    if n_unconverged:
        warn(
            f"{n_unconverged} of the {len(found)} geodesics between keys did not converge; a larger n_steps may help",
            ConvergenceWarning,
        )
    return found


def _locate_frames(times: np.ndarray, frame_rate: float) -> tuple[np.ndarray, np.ndarray]:
    """The segment between keys of each frame, and the fraction of its time, exactly 0 or 1 on keys."""
    keys = (times - times[0]) * frame_rate  # in frames
    frames = np.arange(np.floor(keys[-1] + ON_KEY) + 1)
    nearest = np.abs(keys - np.rint(keys)) < ON_KEY
    keys[nearest] = np.rint(keys[nearest])
    segment = np.clip(np.searchsorted(keys, frames, side="right") - 1, 0, len(keys) - 2)
    return segment, (frames - keys[segment]) / np.diff(keys)[segment]


def root_between(keys: Motion, at: np.ndarray, times: np.ndarray, method: str) -> tuple[np.ndarray, np.ndarray, str]:
    """Positions (n, 3), angles (n, k) and axes of the root at some times; `at` are the times of the keys."""
    orientations = root_orientations(keys.root_angles, keys.root_axes)
    if method == "spline":
        positions = CubicSpline(at, keys.root_positions, bc_type="natural")(times)
        between = RotationSpline(at, orientations)(times)
    else:
        positions = np.stack([np.interp(times, at, values) for values in keys.root_positions.T], axis=1)
        between = Slerp(at, orientations)(times)
    return positions, *continuous_root_angles(between, keys.root_axes)
