"""The checked arguments of inverse kinematics as arrays in the order of compiled code, and its tasks."""

import functools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from sklearn.exceptions import ConvergenceWarning

from skpose._compiled.inverse.frames import Found, Observed, Rules, fit_frames
from skpose._compiled.pose.tree import Tree
from skpose._utils.typing import ArrayLike
from skpose._utils.validation import as_numbers, check_poses, check_positions, limits_of
from skpose._utils.warnings import warn
from skpose.keypoints import Keypoints
from skpose.keypoints._pictures import is_spatial, refuse_pictures
from skpose.kinematics._fitted_poses import FittedPoses
from skpose.kinematics._tree import from_tree_order, to_tree_order, tree_of_all_joints
from skpose.skeleton import Skeleton
from skpose.skeleton._rest import positions_at_zero, size_of
from skpose.skeleton._root import with_root_joint

TASK = 512  # frames, some 50 ms; fixed, so that poses do not depend on n_jobs
WARM_UP = 32  # frames before a task that it computes and drops, so that its first frame does not start from scratch
WARM_ITER = 20  # iterations from the frame before
MAX_ITER = 1000  # iterations from the initial pose; a few frames need hundreds
LARGER, SMALLER = 10.0, 50.0  # times that positions may differ in size from the skeleton: few joints may be seen
N_ROOT = 3  # columns of the root's orientation


class Task(NamedTuple):
    """Frames that are computed together."""

    first: int
    last: int  # the one after the last
    start: int  # first frame of the sequence
    end: int


@dataclass(frozen=True, eq=False)
class Problem:
    """Positions and options of inverse kinematics, in the order of a tree with the root as a joint."""

    skeleton: Skeleton
    tree: Tree
    positions: np.ndarray  # (n_frames, n_joints + 2, 3) m; finite
    weights: np.ndarray  # (n_frames, n_joints + 2); the largest of a frame is 1
    stiffness: np.ndarray  # (n_frames,) ρ² of these weights, m²/rad²
    initial: np.ndarray  # (n_frames or 1, n_dofs + 3)
    changes: np.ndarray  # (n_frames,) rad, see `Observed`
    ends: np.ndarray  # (n_sequences,) number of the frame after the last of each sequence
    rules: Rules
    frame_rate: float | None  # of keypoints
    up: Literal["x", "y", "z"] | None

    def tasks(self) -> Iterator[Task]:
        """Yield the parts of the sequences."""
        start = 0
        for end in self.ends.tolist():
            for first in range(start, end, TASK):
                yield Task(first, min(first + TASK, end), start, end)
            start = end

    def empty(self, n: int) -> Found:
        n_dofs = len(self.tree.column)
        residuals = np.empty((n, self.weights.shape[1]))
        return Found(np.empty((n, n_dofs)), np.empty((n, 3)), residuals, np.zeros(n, np.int64), np.zeros(n, bool))

    def solve(self, task: Task) -> Found:
        """Find the poses of some frames."""
        warm_up = self.warm_up(task) if self.rules.is_sequence else np.array([], np.int64)
        frames, found = np.concatenate([warm_up, np.arange(task.first, task.last)]), self.empty(task.last - task.first)
        ever = np.asarray((self.weights[task.start : task.end] > 0.0).any(axis=0))
        observed = Observed(
            self.positions[frames], self.weights[frames], self.stiffness[frames], ever, self.changes[frames]
        )
        initial = self.initial if self.rules.is_sequence else self.initial[frames]
        fit_frames(self.tree, observed, initial, self.rules, len(warm_up), found)
        return found

    def warm_up(self, task: Task) -> np.ndarray:
        """The frames before a task from which it starts.

        They are those just before it, and just before the last sight of each joint: a joint that is lost keeps the
        angles that it had then, however long ago.
        """
        before = self.weights[task.start : task.first] > 0.0
        sights = task.first - np.argmax(before[::-1, before.any(axis=0)], axis=0) if len(before) else task.first
        ends = np.unique(np.append(sights, task.first))
        chosen = [np.arange(max(end - WARM_UP, task.start), end) for end in ends.tolist()]
        return np.unique(np.concatenate(chosen))

    def unseen(self) -> np.ndarray:
        """The frames (n_frames,) in which no joint is seen."""
        return np.asarray(~(self.weights > 0.0).any(axis=1))

    def fit(self, found: Found) -> FittedPoses:
        """The found poses, in the order of the skeleton."""
        n = len(self.weights)
        columns = from_tree_order(self.tree, found.dofs, np.zeros((n, N_ROOT + self.skeleton.n_dofs)))
        unseen = self.unseen()
        held = self.last_seen(unseen) if self.rules.is_sequence else np.arange(n)
        columns = columns[held]
        residuals = np.full((n, self.skeleton.n_joints + 2), np.nan)
        residuals[:, self.tree.code_joint] = np.where(self.weights > 0.0, found.residuals, np.nan)
        return FittedPoses(
            skeleton=self.skeleton,
            poses=columns[:, N_ROOT:],
            residuals=residuals[:, 2:],
            converged=found.converged,
            root_positions=found.origins[held],
            root_rotations=columns[:, :N_ROOT],
            n_iter=found.n_iter,
            frame_rate=self.frame_rate,
            up=self.up,
        )

    def collect(self, found: Found) -> FittedPoses:
        """The found poses, in the order of the skeleton; warn of frames that did not converge."""
        fitted, unseen, n = self.fit(found), self.unseen(), len(self.weights)
        if unseen.any():
            kept = "the one before" if self.rules.is_sequence else "the initial one"
            frames = f"in {unseen.sum()} of {n} frames, first in frame {unseen.argmax()}"
            warn(f"{frames}, no joint is seen: their pose is {kept}")
        left = ~fitted.converged & ~unseen
        if left.any():
            message = f"{left.sum()} of {n} frames did not converge, first in {left.argmax()}: try regularization=0.01"
            warn(message, ConvergenceWarning)
        return fitted

    def last_seen(self, unseen: np.ndarray) -> np.ndarray:
        """The last frame up to each one in which a joint is seen; without one, the sequence's first."""
        starts = np.repeat(np.append(0, self.ends[:-1]), np.diff(self.ends, prepend=0))
        return np.asarray(np.maximum.accumulate(np.where(unseen, starts, np.arange(len(unseen)))))


def problem_of(
    positions: ArrayLike | Keypoints,
    skeleton: Skeleton,
    weights: ArrayLike | None,
    initial: ArrayLike | None,
    lengths: ArrayLike | None,
    joint_limits: str,
    regularization: float,
) -> Problem:
    """Check the arguments of `inverse_kinematics`, and bring them into the order of a tree."""
    given, confidences = _match(positions, skeleton)
    n = len(given)
    seen = confidences * _weights(weights, confidences.shape)
    seen[np.isnan(given).any(axis=2)] = 0.0
    _warn_of_units(given, skeleton)
    tree = _tree_with_root(skeleton)
    order = tree.code_joint  # 0 is the root, 1 the joint that is added to turn it
    padded, padded_weights = np.zeros((n, len(order), 3)), np.zeros((n, len(order)))
    padded[:, 2:], padded_weights[:, 2:] = np.where(seen[:, :, None] > 0.0, given, 0.0), seen
    start = _check_initial(initial, skeleton, n)
    lower, upper = _limits(tree, skeleton, joint_limits)
    scales = seen.max(axis=1, initial=0.0)  # tolerances are distances, so weights are relative
    scales[scales == 0.0] = 1.0
    dofs = to_tree_order(tree, np.concatenate([np.zeros((len(start), N_ROOT)), start], axis=1))
    rules = Rules(
        is_sequence=len(start) == 1,
        warm_iter=WARM_ITER,
        max_iter=MAX_ITER,
        tries_first=False,
        lower=lower,
        upper=upper,
    )
    return Problem(
        skeleton=skeleton,
        tree=tree,
        positions=padded[:, order],
        weights=padded_weights[:, order] / scales[:, None],
        stiffness=regularization**2 / scales,
        initial=np.clip(dofs, lower, upper),
        changes=np.full(n, np.inf),
        ends=_ends(lengths, n),
        rules=rules,
        frame_rate=positions.frame_rate if isinstance(positions, Keypoints) else None,
        up=positions.up if isinstance(positions, Keypoints) else None,
    )


@functools.lru_cache(maxsize=64)
def _tree_with_root(skeleton: Skeleton) -> Tree:
    """A skeleton with a joint that turns its root as flat arrays."""
    return tree_of_all_joints(with_root_joint(skeleton))


def _match(positions: ArrayLike | Keypoints, skeleton: Skeleton) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n_frames, n_joints, 3) and confidences (n_frames, n_joints) in the skeleton's order."""
    if not isinstance(positions, Keypoints):
        given = check_positions(positions, skeleton.n_joints, "positions")
        if is_spatial(positions_at_zero(skeleton)):  # an arm may move in one plane
            refuse_pictures(given, skeleton.joint_names, "positions")
        return given, np.ones(given.shape[:2])
    common = [name for name in skeleton.joint_names if name in positions.names]
    if not common:
        names = f"the first are {positions.names[0]!r} and {skeleton.joint_names[0]!r}"
        raise ValueError(f"no keypoint has the name of a joint: {names}; use skpose.keypoints.fit_skeleton")
    chosen = [skeleton.joint_names.index(name) for name in common]
    given = np.full((len(positions), skeleton.n_joints, 3), np.nan)
    confidences = np.zeros(given.shape[:2])
    part = positions.select(common)
    given[:, chosen], confidences[:, chosen] = part.positions, part.confidences
    return given, confidences


def _weights(weights: ArrayLike | None, shape: tuple[int, ...]) -> np.ndarray:
    """Check weights (n_frames, n_joints)."""
    if weights is None:
        return np.ones(shape)
    array = as_numbers(weights, "weights", masked=0.0)
    if array.shape not in (shape, shape[1:]):
        raise ValueError(f"weights must have shape {shape[1:]} or {shape}, got {array.shape}")
    if not np.isfinite(array).all() or (array < 0.0).any():
        raise ValueError("weights must be finite and not negative")
    return np.broadcast_to(array, shape)


def _check_initial(initial: ArrayLike | None, skeleton: Skeleton, n: int) -> np.ndarray:
    """Check the first poses (1, n_dofs) or (n_frames, n_dofs)."""
    if initial is None:
        return np.zeros((1, skeleton.n_dofs))
    array = np.asarray(initial)
    if array.ndim == 1:
        array = array[None]
    elif len(array) != n:
        raise ValueError(f"initial must be one pose, or one for each of the {n} frames, got {len(array)}")
    return check_poses(array, skeleton, "initial").astype(np.float64)


def _ends(lengths: ArrayLike | None, n: int) -> np.ndarray:
    """The number of the frame after the last of each sequence."""
    if lengths is None:
        return np.array([n])
    array = np.asarray(lengths)
    if array.ndim != 1 or array.dtype.kind not in "iu" or (array < 1).any() or array.sum() != n:
        raise ValueError(f"lengths must be positive integers whose sum is the number of frames, {n}, got {lengths!r}")
    return np.cumsum(array)


def _limits(tree: Tree, skeleton: Skeleton, joint_limits: str) -> tuple[np.ndarray, np.ndarray]:
    """The limits of each dof, in the tree's order."""
    lower = np.full(len(tree.column), -np.inf)
    if joint_limits == "ignore":
        return lower, -lower
    upper, limited = -lower, np.append(tree.angle_dof, tree.slide_dof)
    limits = limits_of(skeleton)[tree.column[limited] - N_ROOT] * tree.sign[limited, None]  # a reversed axis swaps them
    lower[limited], upper[limited] = limits.min(axis=1), limits.max(axis=1)
    return lower, upper


def _warn_of_units(positions: np.ndarray, skeleton: Skeleton) -> None:
    """Warn if positions and skeleton are likely in different units."""
    seen = positions[(~np.isnan(positions[:, :, 0])).sum(axis=1) > 1]
    size = size_of(skeleton)
    if not len(seen) or not size > 0.0:
        return
    extent = float(np.median(np.nanmax(np.nanmax(seen, axis=1) - np.nanmin(seen, axis=1), axis=1)))
    if extent > LARGER * size or 0.0 < extent < size / SMALLER:
        warn(f"positions extend over {extent:.3g} m, the skeleton over {size:.3g} m: one is likely not in metres")
