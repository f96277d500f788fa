"""The study that `skpose compare` prints: which metric tells walking from running best?

Protocol, after section 3.3 of the paper: poses at 12 Hz on the mean skeleton of all subjects; the nearest neighbour
among the poses of the other sequences (or of the other subjects) decides; the figure is the share of poses that it gets
right.
"""

import re
import time
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from sklearn.model_selection import LeaveOneGroupOut, cross_val_predict
from sklearn.neighbors import KNeighborsClassifier

from skpose.datasets import MotionDataset
from skpose.metrics import METRICS
from skpose.pairwise import pose_distances

FRAME_RATE = 12.0  # Hz, the paper's
ACTIVITIES = ("walk", "run")
PAPER = {"angle": 0.90, "spatial": 1.00}  # sec. 3.3, leaving one sequence out, on other sequences of the CMU database


class Result(NamedTuple):
    """One row of the table."""

    metric: str
    leave_subject_out: float  # share of poses classified right
    leave_sequence_out: float
    seconds: float  # for the matrix of distances and both validations


def walks_and_runs(dataset: MotionDataset) -> MotionDataset:
    """The motions whose action begins with the word walk or run, which it becomes."""
    first = np.array([re.split(r"\W", action.strip().lower())[0] for action in dataset.actions])
    chosen = np.isin(first, ACTIVITIES)
    missing = [activity for activity in ACTIVITIES if activity not in first]
    if missing:
        raise ValueError(
            f"comparing metrics takes motions of walking and running, but none has an action that begins with "
            f"{missing[0]!r}: write one line for each motion into an index.csv, see skpose.datasets.load_cmu"
        )
    return MotionDataset(
        dataset.select(chosen).motions, dataset.subjects[chosen], dataset.trials[chosen], first[chosen]
    )


def compare(dataset: MotionDataset, *, n_jobs: int | None = None) -> Iterator[Result]:
    """Results of all metrics on the walks and runs of a dataset, one after the other."""
    dataset = walks_and_runs(dataset)
    X, sequence = dataset.poses(FRAME_RATE)
    y, subject = dataset.actions[sequence], dataset.subjects[sequence]
    for metric in METRICS:
        pose_distances(X[:1], skeleton=dataset.skeleton, metric=metric)  # compile before the clock starts
        start = time.perf_counter()
        distances = pose_distances(X, skeleton=dataset.skeleton, metric=metric, n_jobs=n_jobs)
        accuracies = [_accuracy(distances, y, groups) for groups in (subject, sequence)]
        yield Result(metric, *accuracies, time.perf_counter() - start)


def _accuracy(distances: np.ndarray, y: np.ndarray, groups: np.ndarray) -> float:
    """Share of poses whose nearest neighbour outside their own group is of their class; NaN with one group alone."""
    if len(np.unique(groups)) < 2:
        return np.nan
    nearest = KNeighborsClassifier(n_neighbors=1, metric="precomputed")
    return float(np.mean(cross_val_predict(nearest, distances, y, groups=groups, cv=LeaveOneGroupOut()) == y))
