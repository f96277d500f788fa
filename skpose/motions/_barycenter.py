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
from skpose.geodesics._descent import MEAN, descend
from skpose.kinematics._forward import weighted_positions
from skpose.kinematics._tree import from_tree_order, to_tree_order, tree_of
from skpose.metrics import Metric, Position
from skpose.metrics._convergence import Unconverged
from skpose.metrics._matrix import DistanceMatrix
from skpose.metrics._means import TOL as TOL_EXTRINSIC
from skpose.motions._inputs import Sequences
from skpose.skeleton import Skeleton

STEPS_OF_A_POSE = 200  # Newton's or Karcher's, at most
TOL_GEODESIC = 1e-3  # as in `frechet_mean`


class Aligned(NamedTuple):
    """The pairs of frames along all paths, ordered by the frames of the mean."""

    mean_frames: np.ndarray  # (n_pairs,) frames of the mean, ascending, none left out
    frames: np.ndarray  # (n_pairs,) rows of all motions' poses
    squares: np.ndarray  # (n_pairs,) squared distances, m²
    unconverged: Unconverged
    n_geodesics: int  # measured; zero for "position"

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

    def __init__(self, motions: Sequences, skeleton: Skeleton, metric: Metric, window: float | None, n_jobs: int):
        self.motions, self.skeleton, self.metric = motions, skeleton, metric
        self.is_chord = metric == metric.lower_bound()
        self.paths = Paths.of(window)
        self.n_jobs = n_jobs
        self.tree = tree_of(skeleton)
        self.positions = weighted_positions(motions.poses, skeleton)
        self.unconverged: set[int] = set()

    def align(self, mean: np.ndarray) -> Aligned:
        """Find the best path of every motion under squared distances."""
        bounds, _ = DistanceMatrix(mean, self.motions.poses, Position(), self.skeleton).write(None, 1)
        bounds **= 2
        found: list[tuple[int, np.ndarray, np.ndarray, Unconverged, int]] = []

        def align_one(k: int) -> None:
            start = self.motions.starts[k]
            costs = np.ascontiguousarray(bounds[:, start : self.motions.starts[k + 1]])
            if self.is_chord:
                path, unconverged, n_geodesics = _best_path(costs, self.paths), Unconverged(0, 0.0), 0
            else:
                path, unconverged, n_geodesics = self._path_of_geodesics(costs, mean, self.motions.motion(k))
            found.append((k, path + np.array([0, start]), costs[path[:, 0], path[:, 1]], unconverged, n_geodesics))

        in_threads((partial(align_one, k) for k in range(self.motions.n_motions)), self.n_jobs)
        found.sort(key=lambda one: one[0])  # sums do not depend on the threads
        pairs, squares = np.concatenate([one[1] for one in found]), np.concatenate([one[2] for one in found])
        order = np.argsort(pairs[:, 0], kind="stable")
        unconverged = Unconverged.join(one[3] for one in found)
        n_geodesics = sum(one[4] for one in found)
        return Aligned(pairs[order, 0], pairs[order, 1], squares[order], unconverged, n_geodesics)

    def _path_of_geodesics(
        self, costs: np.ndarray, mean: np.ndarray, motion: np.ndarray
    ) -> tuple[np.ndarray, Unconverged, int]:
        """Find the best path; replace lower bounds in `costs` by geodesics as needed.

        While the best path contains bounds, these are replaced. A best path without bounds is the best of all.
        """
        known = np.zeros(costs.shape, dtype=bool)
        parts: list[Unconverged] = []
        while True:
            path = _best_path(costs, self.paths)
            missing = path[~known[path[:, 0], path[:, 1]]]
            if not len(missing):
                return path, Unconverged.join(parts), int(known.sum())
            for i in np.unique(missing[:, 0]):
                columns = missing[missing[:, 0] == i, 1]
                squares, some = self._squares(mean[i], motion[columns])
                costs[i, columns] = np.maximum(squares, costs[i, columns])  # a chord is longer by rounding only
                known[i, columns] = True
                parts += some

    def _squares(self, pose: np.ndarray, others: np.ndarray) -> tuple[np.ndarray, list[Unconverged]]:
        """Squared distances of a pose to others."""
        matrix = DistanceMatrix(pose[np.newaxis], others, self.metric, self.skeleton)
        distances, unconverged = matrix.write(None, 1)
        return distances[0] ** 2, unconverged

    def move(self, mean: np.ndarray, aligned: Aligned, before: Aligned | None) -> np.ndarray:
        """Move each frame to the `frechet_mean` of the poses aligned to it, unless these are the same as `before`.

        The search starts from the frame itself, so the motion stays continuous in angles that move no joint.
        """
        moved = mean.copy()
        earlier = [] if before is None else before.groups()
        squares = np.split(aligned.squares, np.cumsum(aligned.n_poses)[:-1])
        pose_of = self._nearest_to_mean if self.is_chord else self._karcher_mean

        def move_one(frame: int, group: np.ndarray) -> None:
            pose, converged = pose_of(mean[frame], group)
            (self.unconverged.discard if converged else self.unconverged.add)(frame)
            if self._squares(pose, self.motions.poses[group])[0].sum() <= squares[frame].sum():
                moved[frame] = pose

        tasks: list[Callable[[], None]] = [
            partial(move_one, frame, group)
            for frame, group in enumerate(aligned.groups())
            if not earlier or frame in self.unconverged or not np.array_equal(earlier[frame], group)
        ]
        in_threads(tasks, self.n_jobs)
        return moved

    def _nearest_to_mean(self, pose: np.ndarray, group: np.ndarray) -> tuple[np.ndarray, bool]:
        start = to_tree_order(self.tree, pose[np.newaxis])[0]
        target = self.positions[group].mean(axis=0)
        found, outcome = project(self.tree, target, start, STEPS_OF_A_POSE, TOL_EXTRINSIC)
        return from_tree_order(self.tree, found, pose), bool(outcome.converged)

    def _karcher_mean(self, pose: np.ndarray, group: np.ndarray) -> tuple[np.ndarray, bool]:
        weights = np.full(len(group), 1.0 / len(group))
        sample = self.metric.sample(self.motions.poses[group], weights, self.skeleton, 1)
        start = to_tree_order(self.tree, pose[np.newaxis])[0]
        spread, _, converged = descend(sample, start, MEAN, STEPS_OF_A_POSE, TOL_GEODESIC)
        return sample.columns(spread.pose, pose), converged


def _best_path(costs: np.ndarray, paths: Paths) -> np.ndarray:
    sums = costs.copy()
    accumulate(sums, paths)
    return path_to(sums, paths.is_open, sums.shape[1] - 1)
