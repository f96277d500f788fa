"""The frames of a motion in which repetitions are searched: which of them move, and the distances between them.

Up to 2,000 frames all distances are computed once. For longer motions they are computed on demand, which bounds memory,
and those of every k-th frame state how far apart frames are.
"""

import numpy as np
from joblib import effective_n_jobs

from skpose.metrics import Metric
from skpose.metrics._shared import DistanceMatrix, Unconverged, paired_distances
from skpose.skeleton import Skeleton

FAST, FAR = 0.95, 0.95  # quantiles of speeds, and of distances between frames, that count as large
NEAR = 0.25  # quantile of distances that counts as small
TRAVEL = 0.3  # speed is measured over enough frames for fast ones to travel this share of a far distance
STILL = 0.2  # speed below which a frame is still, relative to a fast one


class Frames:
    """The frames of a motion.

    Attributes
    ----------
    is_moving : ndarray of shape (n,) of bool
        Whether each frame moves.
    median, near : float
        Median distance between moving frames, zeros included, and a small distance above zero.
    unconverged : list of Unconverged, n_pairs : int
        Distances that did not converge, and the number of all.
    """

    most = 2000  # frames with all distances in memory

    def __init__(self, poses: np.ndarray, metric: Metric, skeleton: Skeleton | None, n_jobs: int | None):
        self.n = len(poses)
        self.unconverged: list[Unconverged] = []
        self.n_pairs = 0
        self._given = poses, metric, skeleton, n_jobs
        self._all: np.ndarray | None = None
        some = np.arange(0, self.n, -(-self.n // self.most))
        distances = self._measure(some, None)
        if len(some) == self.n:
            self._all = distances
        self.is_moving = self._find_moving(some, np.quantile(distances, FAR))
        moving = self.is_moving[some]
        distances = distances[np.ix_(moving, moving)].astype(np.float64)
        positive = distances[distances > 0.0]
        self.median = float(np.median(distances)) if len(distances) else 0.0
        self.near = float(np.quantile(positive, NEAR)) if len(positive) else 0.0

    def moving(self, every: int) -> np.ndarray:
        """The moving ones of every k-th frame."""
        return np.flatnonzero(self.is_moving[::every]) * every

    def sections(self, every: int, n: int | None = None) -> list[np.ndarray]:
        """These in sections with distances that fit into memory, or n of the sections, spread evenly."""
        moving = self.moving(every)
        n_sections = -(-len(moving) // self.most)
        sections = np.array_split(moving, max(1, n_sections))
        chosen = np.linspace(0, len(sections) - 1, min(len(sections), n or len(sections)))
        return [sections[i] for i in chosen.astype(int)]

    def distances(self, rows: np.ndarray, columns: np.ndarray | None = None) -> np.ndarray:
        """Distances of some frames from others, or from each other."""
        if self._all is not None:
            return self._all[np.ix_(rows, rows if columns is None else columns)].astype(np.float64)
        return self._measure(rows, columns).astype(np.float64, copy=False)

    def _measure(self, rows: np.ndarray, columns: np.ndarray | None) -> np.ndarray:
        poses, metric, skeleton, n_jobs = self._given
        others = None if columns is None else poses[columns]
        distances, unconverged = DistanceMatrix(poses[rows], others, metric, skeleton).write(None, n_jobs)
        self.unconverged += unconverged
        self.n_pairs += distances.size
        return distances

    def _find_moving(self, some: np.ndarray, far: float) -> np.ndarray:
        """Find the moving frames by their speeds, the distances between the frames `reach` before and after each."""
        reach = 1
        while True:
            speeds = self._speeds(some, reach)
            fast = np.quantile(speeds, FAST)
            if fast >= TRAVEL * far or reach > self.n // 8:
                break
            reach += 1 + reach // 4
        if len(some) < self.n:
            speeds = self._speeds(np.arange(self.n), reach)
        return speeds > STILL * fast

    def _speeds(self, frames: np.ndarray, reach: int) -> np.ndarray:
        """Distances over twice `reach` frames, fewer at both ends."""
        before, after = np.maximum(frames - reach, 0), np.minimum(frames + reach, self.n - 1)
        return self._apart(before, after) * (2 * reach / np.maximum(after - before, 1))

    def _apart(self, some: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Return the distances of frames from others, one by one."""
        if self._all is not None:
            return self._all[some, others]
        poses, metric, skeleton, n_jobs = self._given
        return paired_distances(poses[some], poses[others], skeleton, metric, effective_n_jobs(n_jobs))
