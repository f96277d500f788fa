"""The study of `skpose compare`: which metric separates walking and running best?

Protocol, after sections 3.2 and 3.3 of the paper: poses at 12 Hz on the mean skeleton of all subjects.

- Classification: a pose gets the class of its nearest neighbour among the poses of the other sequences (or of the other
  subjects). The result is the share of poses that are classified right.
- Dimension: the share of variance in the first component of multidimensional scaling, for each sequence. The result is
  the median over the sequences.
"""

import time
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from sklearn.model_selection import LeaveOneGroupOut, cross_val_predict
from sklearn.neighbors import KNeighborsClassifier

from skpose.datasets import MotionDataset, walks_and_runs
from skpose.manifold import SpatialMDS
from skpose.metrics import pose_distances

FRAME_RATE = 12.0  # Hz, the paper's
COMPARED = ("angle", "position", "rotation", "spatial")  # without "geodesic": a million of them take an hour
# The paper, for other sequences of the CMU database: sec. 3.3, leaving one sequence out; modes of figure 4 (c).
PAPER_ACCURACY = {"angle": 0.90, "spatial": 1.00}
PAPER_FIRST_COMPONENT = {"angle": 0.40, "spatial": 0.80}
COLUMNS = "Subject out: unknown people. Seq. out: known people. MDS: how well one dimension describes a sequence."


class Result(NamedTuple):
    """A row of the table."""

    metric: str
    leave_subject_out: float  # share of poses classified right
    leave_sequence_out: float
    first_component: float  # share of variance, median over the sequences
    seconds: float  # for the matrix of distances, both validations and the scaling


def compare(dataset: MotionDataset, *, n_jobs: int | None = None) -> Iterator[Result]:
    """Yield the result of each metric on the walks and runs of a dataset."""
    dataset = walks_and_runs(dataset)
    X, sequence = dataset.poses(FRAME_RATE)
    y, subject = dataset.actions[sequence], dataset.subjects[sequence]
    for metric in COMPARED:
        pose_distances(X[:1], skeleton=dataset.skeleton, metric=metric)  # compile before the clock starts
        start = time.perf_counter()
        distances = pose_distances(X, skeleton=dataset.skeleton, metric=metric, n_jobs=n_jobs)
        right = [float(np.mean(classify(distances, y, groups))) for groups in (subject, sequence)]
        frames = [np.flatnonzero(sequence == i) for i in np.unique(sequence)]
        shares = [first_component(distances[np.ix_(f, f)]) for f in frames if len(f) > 2]
        component = float(np.median(shares)) if shares else np.nan
        yield Result(metric, right[0], right[1], component, time.perf_counter() - start)


def classify(distances: np.ndarray, y: np.ndarray, groups: np.ndarray) -> np.ndarray:
    """Return whether the nearest neighbour of each pose outside its group has its class; NaN for a single group."""
    if len(np.unique(groups)) < 2:
        return np.full(len(y), np.nan)
    nearest = KNeighborsClassifier(n_neighbors=1, metric="precomputed")
    return cross_val_predict(nearest, distances, y, groups=groups, cv=LeaveOneGroupOut()) == y


def first_component(distances: np.ndarray) -> float:
    """Return the share of variance in the first component of multidimensional scaling."""
    return float(SpatialMDS(n_components=1, metric="precomputed").fit(distances).explained_variance_ratio_[0])
