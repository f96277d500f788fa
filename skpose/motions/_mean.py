"""Mean motions: a typical motion whose bones keep their lengths, and the variation about it."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from numbers import Integral, Real
from typing import Any, Literal, NamedTuple

import numpy as np
from joblib import effective_n_jobs
from scipy.spatial.transform import Rotation
from sklearn.exceptions import ConvergenceWarning

from skpose._compiled.path.geodesic import project
from skpose._compiled.warping.paths import Paths, accumulate, path_to
from skpose._utils.parallel import in_threads
from skpose._utils.sklearn import Interval, validate_params
from skpose._utils.units import warn_of_degrees
from skpose._utils.warnings import warn
from skpose.kinematics._forward import forward_kinematics, weighted_positions
from skpose.kinematics._tree import from_tree_order, to_tree_order, tree_of
from skpose.metrics import Position
from skpose.metrics._matrix import DistanceMatrix
from skpose.metrics._means import TOL
from skpose.metrics._registry import METRIC_CONSTRAINTS
from skpose.motions._distances import MotionMatrix
from skpose.motions._inputs import Sequences, check_motions
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._interpolation import interpolate_poses, join_seen
from skpose.skeleton._root import continuous_root_angles, has_root_joint, heading, root_orientations

STEPS_OF_A_POSE = 200  # Newton's, at most
TRAVEL = 0.5  # m, from the first place to the last, of a motion that has a direction of travel
SIDEWAYS = np.radians(30.0)  # between the direction of travel and where the root faces, beyond which it walks aslant


class Aligned(NamedTuple):
    """The pairs of frames along all paths, ordered by the frames of the mean."""

    mean_frames: np.ndarray  # (n_pairs,) frames of the mean, ascending, none left out
    frames: np.ndarray  # (n_pairs,) rows of all motions' poses
    squares: np.ndarray  # (n_pairs,) squared distances, m²

    @property
    def objective(self) -> float:
        """The sum of all squared distances, m²."""
        return float(self.squares.sum())

    @property
    def n_poses(self) -> np.ndarray:
        """The number of poses aligned to each frame of the mean."""
        return np.bincount(self.mean_frames)

    def groups(self) -> list[np.ndarray]:
        """The rows aligned to each frame of the mean."""
        return np.split(self.frames, np.cumsum(self.n_poses)[:-1])


@dataclass(frozen=True, eq=False, repr=False)
class MeanMotion:
    """A mean of motions, from `mean_motion`.

    Attributes
    ----------
    skeleton : Skeleton
        The skeleton.
    poses : ndarray of shape (n_frames, n_dofs)
        The mean: joint angles, rad.
    frame_rate : float or None
        Frames per second, Hz; None for arrays.
    std : ndarray of shape (n_frames,)
        Root mean squared distance between each frame and the poses aligned to it, m.
    joint_std : ndarray of shape (n_frames, n_joints)
        The same for the position of each joint, m, without the weights of the joints.
    n_poses : ndarray of shape (n_frames,) of int
        Number of poses aligned to each frame, at least one of each motion.
    objectives : ndarray of shape (n_iter + 1,)
        Sum of the squared distances along the paths of all motions, m², at the start and after each iteration.
    converged : bool
        Whether the objective stopped decreasing before `max_iter`.
    root_positions : ndarray of shape (n_frames, 3) or None
        Mean positions of the root, m; None for arrays.
    root_angles : ndarray of shape (n_frames, k) or None
        Mean rotations of the root, rad, about `root_axes`, as in a `Motion`; None for arrays.
    root_axes : str
        Those of the motions.
    up : {"x", "y", "z"} or None
        The axis of the world that points up; None for arrays.
    root_name : str
        The name of the root.
    seen : ndarray of shape (n_frames, n_joints) of bool or None
        Joints with positions in all aligned frames, if motions were fitted to positions, see `Motion`.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.motions import mean_motion
    >>> swing = np.linspace(0.0, 1.0, 9)[:, None]
    >>> mean_motion([swing, swing + 0.2], skeleton=Skeleton.chain(1))
    MeanMotion(9 frames, root unknown, standard deviation 0.054 m, converged in 3 iterations)
    """

    skeleton: Skeleton
    poses: np.ndarray
    frame_rate: float | None
    std: np.ndarray
    joint_std: np.ndarray
    n_poses: np.ndarray
    objectives: np.ndarray
    converged: bool
    root_positions: np.ndarray | None = None
    root_angles: np.ndarray | None = None
    root_axes: str = "xyz"
    up: Literal["x", "y", "z"] | None = None
    root_name: str = "root"
    seen: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.poses)

    def __repr__(self) -> str:
        state = "converged" if self.converged else "not converged"
        deviation = float(np.sqrt(np.average(self.std**2, weights=self.n_poses)))
        root = "root unknown" if self.up is None else f"{self.up} up"
        iterations = f"{state} in {self.n_iter} iterations"
        return f"MeanMotion({len(self)} frames, {root}, standard deviation {deviation:.3f} m, {iterations})"

    @property
    def objective(self) -> float:
        """Sum of the squared distances along the paths of all motions, m²."""
        return float(self.objectives[-1])

    @property
    def n_iter(self) -> int:
        """Number of iterations."""
        return len(self.objectives) - 1

    def to_motion(self, frame_rate: float | None = None) -> Motion:
        """Convert the mean to a motion with the mean movement of the root.

        For arrays the root stays at the origin, with y up.

        Parameters
        ----------
        frame_rate : float, default=None
            Frames per second, Hz; arrays need it. None takes it from the motions.

        Returns
        -------
        Motion
            The mean.

        See Also
        --------
        Motion.to_cycle : Close a stride so that it can be looped.
        """
        frame_rate = self.frame_rate if frame_rate is None else frame_rate
        if frame_rate is None:
            raise ValueError("to_motion needs frame_rate for a mean of arrays")
        motion = Motion(self.skeleton, self.poses, frame_rate)
        if self.up is None:
            return motion
        names = ("root_positions", "root_angles", "root_axes", "up", "root_name", "seen")
        return replace(motion, **{name: getattr(self, name) for name in names})


@validate_params(
    {
        "skeleton": METRIC_CONSTRAINTS["skeleton"],
        "n_frames": [Interval(Integral, 1, None, closed="left"), None],
        "window": [Interval(Real, 0, 1, closed="both"), None],
        "max_iter": [Interval(Integral, 1, None, closed="left")],
        "tol": [Interval(Real, 0, None, closed="left")],
        "n_jobs": [None, Integral],
    },
    prefer_skip_nested_validation=True,
)
def mean_motion(
    motions: Any,
    *,
    skeleton: Skeleton | None = None,
    n_frames: int | None = None,
    window: float | None = None,
    max_iter: int = 100,
    tol: float = 1e-4,
    n_jobs: int | None = None,
) -> MeanMotion:
    r"""Find the motion with the least squared distances to given motions, by dynamic time warping.

    DTW barycentre averaging [1]_, on the manifold of poses: with d the distance "position" and :math:`P_k` the monotone
    path that aligns motion k to the mean, whose frames are :math:`\mu_i`,

    .. math:: \min_{\mu, P} \sum_k \sum_{(i, j) \in P_k} d(\mu_i, a_{kj})^2.

    Two steps alternate: all motions are aligned to the mean, and each frame of the mean moves to the `frechet_mean` of
    the poses aligned to it, so bones keep their lengths. Neither step increases the sum. Unlike in `motion_distances`,
    paths minimise *squared* distances.

    Parameters
    ----------
    motions : list of array-like or of Motion, MotionDataset, or array of shape (n_motions, n_frames, n_dofs)
        Motions of shape (n_frames, n_dofs): joint angles, and rotation vectors of ball joints, rad. Lengths may differ.
    skeleton : Skeleton, default=None
        The skeleton of all motions, and of the mean. None takes it from the `Motion` objects, or their mean as
        ``MotionDataset.skeleton``; arrays need it.
    n_frames : int, default=None
        Number of frames of the mean; None takes it from the motion it starts from.
    window : float between 0 and 1, default=None
        Sakoe–Chiba band of the paths, see `motion_distances`. None sets no limit.
    max_iter : int, default=100
        Largest number of iterations.
    tol : float, default=1e-4
        Relative decrease of the sum in an iteration at which the mean has converged.
    n_jobs : int, default=None
        Threads, as in scikit-learn.

    Returns
    -------
    MeanMotion
        The mean, and how much each phase and each joint varies.

    Raises
    ------
    TypeError
        If `motions` is a single motion, or Motions and arrays are mixed.
    ValueError
        For arrays without a skeleton, and if the motions have different frame rates, up axes or skeletons that are not
        comparable, or different parts of the root's orientation in their poses.

    Warns
    -----
    ConvergenceWarning
        If `max_iter` was too small.
    UserWarning
        If the poses look like degrees, see `pose_distances`.

    See Also
    --------
    frechet_mean : The mean of poses.
    motion_distances : The distances between motions.
    segment_repetitions : The repetitions of a movement in one recording.

    Notes
    -----
    The mean starts from the medoid, the motion with the least sum of distances to the others under "position", and is a
    local minimum. It has the frame rate of the motions, or with `n_frames` the duration of the medoid.

    The *root* is not part of the alignment, but averaged along the paths. Each motion is moved along the floor and
    rotated about the vertical, so that all begin at one place and travel in one direction, or begin with one heading if
    one does not travel by 0.5 m; heights and tilts stay. Each frame has
    the mean position and rotation of the root in the frames aligned to it, with equal weight for each motion. The mean
    begins above the origin, and travels straight ahead or begins with heading zero.

    An iteration takes O(n_frames · frames of all motions) distances between poses. 12 to 30 Hz are enough for most
    actions.

    References
    ----------
    .. [1] F. Petitjean, A. Ketterlin, P. Gançarski, "A global averaging method for dynamic time warping, with
       applications to clustering", Pattern Recognition 44(3), 2011, :doi:`10.1016/j.patcog.2010.09.013`.

    Examples
    --------
    The typical stride of a generated walk, and the joint that varies most:

    >>> from skpose.motions import mean_motion, segment_repetitions
    >>> from skpose.datasets import make_gait
    >>> walk = make_gait(1, 1, activities=["walk"], duration=6, frame_rate=20, random_state=0)[0]
    >>> mean = mean_motion(segment_repetitions(walk).motions)
    >>> mean.to_motion()
    Motion(22 frames at 20 Hz, 1.1 s, y up, Skeleton(n_joints=22, n_dofs=48))
    >>> mean.skeleton.joint_names[mean.joint_std.mean(axis=0).argmax()]
    'right_toes'
    """
    motions = list(motions) if isinstance(motions, Iterator) else motions
    checked = check_motions({"motions": motions}, skeleton)[0]
    skeleton, frame_rate = checked.skeleton, checked.frame_rate
    if skeleton is None:
        raise ValueError("mean_motion needs skeleton for arrays")
    given = list(motions) if frame_rate is not None else []  # arrays have no root
    _check_roots(given)
    sequences = checked.sequences.in_float64()
    warn_of_degrees(None, skeleton, motions=sequences.poses)
    distances, _ = MotionMatrix(sequences, None, Position(), skeleton, window=window).write(None, n_jobs)
    mean = sequences.motion(int(distances.sum(axis=0).argmin()))  # the medoid, the first of several
    if n_frames is not None and n_frames != len(mean):
        if frame_rate is not None and n_frames > 1 and len(mean) > 1:
            frame_rate *= (n_frames - 1) / (len(mean) - 1)
        mean = interpolate_poses(skeleton.bones, mean, np.linspace(0, len(mean) - 1, n_frames))
    barycenter = Barycenter(sequences, skeleton, window, effective_n_jobs(n_jobs))
    aligned, before = barycenter.align(mean), None
    objectives, converged = [aligned.objective], False
    while not converged and len(objectives) <= max_iter:
        mean, before = barycenter.move(mean, aligned, before), aligned
        aligned = barycenter.align(mean)
        objectives.append(aligned.objective)
        converged = bool(objectives[-1] >= (1.0 - tol) * objectives[-2])
    if not converged:
        warn(
            f"the mean motion did not converge to tol={tol:g} in max_iter={max_iter} iterations",
            ConvergenceWarning,
        )
    if barycenter.unconverged:
        warn(
            f"the mean pose of {len(barycenter.unconverged)} of {len(mean)} frames did not converge",
            ConvergenceWarning,
        )
    n_poses = aligned.n_poses
    std = np.sqrt(np.bincount(aligned.mean_frames, aligned.squares) / n_poses)
    at, positions = forward_kinematics(mean, skeleton), forward_kinematics(sequences.poses, skeleton)
    off = (positions[group] - at[frame] for frame, group in enumerate(aligned.groups()))
    joint_std = np.sqrt([(vectors**2).sum(axis=2).mean(axis=0) for vectors in off])
    root = _mean_root(given, aligned) if given else {}
    return MeanMotion(skeleton, mean, frame_rate, std, joint_std, n_poses, np.array(objectives), converged, **root)


def _check_roots(motions: Sequence[Motion]) -> None:
    """Refuse motions with different up axes, or with different parts of the root's orientation in their poses."""
    for i, motion in enumerate(motions):
        first = motions[0]
        if motion.up != first.up:
            raise ValueError(f'motions[0] has "{first.up}" up and motions[{i}] "{motion.up}": rotate one of them')
        axes, others = (set(one.root_axes.lower()) for one in (first, motion))
        if axes != others and has_root_joint(motion.skeleton):
            raise ValueError(f"motions[0] and motions[{i}] differ in root axes: call without_root() of all")


def _mean_root(motions: Sequence[Motion], aligned: Aligned) -> dict[str, Any]:
    """Average the roots, each relative to the place at which its motion begins, and to its heading.

    Each motion has the same weight in each frame, however many of its frames are aligned there; otherwise the mean
    would jump where these numbers change.
    """
    first = motions[0]
    turned = []
    begin = root_orientations(first.root_angles[:1], first.root_axes)
    ways = [_way(motion.root_positions, first.up) for motion in motions]
    for motion, way in zip(motions, ways, strict=True):
        own = root_orientations(motion.root_angles, motion.root_axes)
        # Relative to the first motion: bones that point down at angle zero have no heading of their own.
        turn = heading(own[:1] * begin.inv(), first.up)
        if way is not None and ways[0] is not None:
            turn = np.array([way - ways[0]])
        turned.append(_turn_back(own, motion.root_positions, turn, first.up))
    orientations, positions = zip(*turned, strict=True)
    everywhere, places = Rotation.concatenate(orientations), np.concatenate(positions)
    motion_of = np.repeat(np.arange(len(motions)), [len(motion) for motion in motions])
    means, mean_places = [], []
    for rows in aligned.groups():
        counts = np.bincount(motion_of[rows], minlength=len(motions))
        weights = 1.0 / (len(motions) * counts[motion_of[rows]])
        means.append(everywhere[rows].mean(weights))
        mean_places.append(weights @ places[rows])
    mean = Rotation.concatenate(means)
    there = np.array(mean_places)
    turn = heading(mean[:1], first.up)
    if (way := _way(there, first.up)) is not None:
        # Forward is the axis along which the motion travels while the root faces it, on average.
        faced = np.angle(np.exp(1j * heading(mean, first.up)).mean())
        ahead = np.angle(np.exp(1j * (way - faced)))
        off = ahead - np.round(ahead / (np.pi / 2.0)) * (np.pi / 2.0)
        turn = np.array([faced + (off if abs(off) < SIDEWAYS else 0.0)])
    mean, there = _turn_back(mean, there, turn, first.up)
    angles, axes = continuous_root_angles(mean, first.root_axes)
    seen = join_seen([motion.seen for motion in motions], list(map(len, motions)))
    if seen is not None:
        seen = np.stack([seen[rows].all(axis=0) for rows in aligned.groups()])
    return {
        "root_positions": there,
        "root_angles": angles,
        "root_axes": axes,
        "up": first.up,
        "root_name": first.root_name,
        "seen": seen,
    }


def _way(places: np.ndarray, up: str) -> float | None:
    """The direction along the floor, rad about the vertical, from the first place (n_frames, 3) to the last.

    None if the motion does not travel.
    """
    i = "xyz".index(up)
    x, y = (places[-1] - places[0])[[(i + 1) % 3, (i + 2) % 3]]
    return float(np.arctan2(y, x)) if np.hypot(x, y) >= TRAVEL else None


def _turn_back(orientations: Rotation, places: np.ndarray, turn: np.ndarray, up: str) -> tuple[Rotation, np.ndarray]:
    """A root's orientations (n,) and places (n, 3), turned back about the vertical and moved to begin at the origin."""
    back, on_floor = Rotation.from_euler(up, -turn), np.array([float(axis != up) for axis in "xyz"])
    return back * orientations, back.apply(places - places[0] * on_floor)


# --- the two steps ----------------------------------------------------------------------------------------------------


class Barycenter:
    """The motions of a mean, and the two steps.

    `unconverged` are the frames whose mean did not converge; they move again in the next step.
    """

    def __init__(self, motions: Sequences, skeleton: Skeleton, window: float | None, n_jobs: int):
        self.motions, self.skeleton = motions, skeleton
        self.paths = Paths.of(window)
        self.n_jobs = n_jobs
        self.tree = tree_of(skeleton)
        self.positions = weighted_positions(motions.poses, skeleton)
        self.unconverged: set[int] = set()

    def align(self, mean: np.ndarray) -> Aligned:
        """Find the best path of every motion under squared distances."""
        squares = self._squares(mean, self.motions.poses)

        def align_one(k: int) -> tuple[np.ndarray, np.ndarray]:
            start = self.motions.starts[k]
            costs = squares[:, start : self.motions.starts[k + 1]]
            sums = costs.copy()
            accumulate(sums, self.paths)
            path = path_to(sums, self.paths.is_open, sums.shape[1] - 1)
            return path + np.array([0, start]), costs[path[:, 0], path[:, 1]]

        found = in_threads((partial(align_one, k) for k in range(self.motions.n_motions)), self.n_jobs)
        pairs, squares_along = (np.concatenate(part) for part in zip(*found, strict=True))
        order = np.argsort(pairs[:, 0], kind="stable")
        return Aligned(pairs[order, 0], pairs[order, 1], squares_along[order])

    def _squares(self, poses: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Squared distances of poses to others."""
        return np.square(DistanceMatrix(poses, others, Position(), self.skeleton).write(None, 1)[0])

    def move(self, mean: np.ndarray, aligned: Aligned, before: Aligned | None) -> np.ndarray:
        """Move each frame to the `frechet_mean` of the poses aligned to it, unless these are the same as `before`.

        The search starts from the frame itself, so the motion stays continuous in angles that move no joint.
        """
        moved = mean.copy()
        earlier = [] if before is None else before.groups()
        squares = np.split(aligned.squares, np.cumsum(aligned.n_poses)[:-1])

        def move_one(frame: int, group: np.ndarray) -> None:
            start = to_tree_order(self.tree, mean[[frame]])[0]
            found, outcome = project(self.tree, self.positions[group].mean(axis=0), start, STEPS_OF_A_POSE, TOL)
            pose = from_tree_order(self.tree, found, mean[frame])
            (self.unconverged.discard if outcome.converged else self.unconverged.add)(frame)
            if self._squares(pose[np.newaxis], self.motions.poses[group]).sum() <= squares[frame].sum():
                moved[frame] = pose

        tasks: list[Callable[[], None]] = [
            partial(move_one, frame, group)
            for frame, group in enumerate(aligned.groups())
            if not earlier or frame in self.unconverged or not np.array_equal(earlier[frame], group)
        ]
        in_threads(tasks, self.n_jobs)
        return moved
