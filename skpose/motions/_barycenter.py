"""The two steps of a mean motion: align all motions, and move each frame to the mean of the poses aligned to it.

Neither step increases the sum of the squared distances of all aligned pairs (F. Petitjean, A. Ketterlin, P. Gançarski,
2011, doi:10.1016/j.patcog.2010.09.013).
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from skpose._compiled.path.geodesic import project
from skpose._compiled.warping.paths import Paths, accumulate, path_to
from skpose._utils.parallel import in_threads
from skpose.kinematics._forward import weighted_positions
from skpose.kinematics._tree import from_tree_order, to_tree_order, tree_of
from skpose.metrics import Position
from skpose.metrics._matrix import DistanceMatrix
from skpose.metrics._means import TOL
from skpose.motions._inputs import Sequences
from skpose.skeleton import Skeleton

STEPS_OF_A_POSE = 200  # Newton's, at most


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
            target = self.positions[group].mean(axis=0)
            found, outcome = project(self.tree, target, start, STEPS_OF_A_POSE, TOL)
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
