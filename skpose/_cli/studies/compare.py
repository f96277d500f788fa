"""The study of `skpose compare`: accuracy of action recognition under each metric.

Poses are at 12 Hz, on the mean skeleton of all people, without the root.

- Frames: a pose gets the action of its nearest neighbour among the poses of other people (or of other motions).
- Motions: a motion gets the action of its nearest neighbour among the motions of other people (or among all other
  motions) by dynamic time warping, see `motion_distances`.
- Dimension: the share of variance in the first component of multidimensional scaling, the median over the motions.

The results are 1-NN accuracies. `--paper` is the protocol of sections 3.2 and 3.3 of the paper: walking and running,
with the joint angles of the files. Otherwise joints of two or three angles are ball joints, so "spatial" follows the
shortest rotations.
"""

import time
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from skpose._compiled.warping.paths import Paths, accumulate
from skpose.datasets import MotionDataset, walks_and_runs
from skpose.manifold import SpatialMDS
from skpose.metrics import pose_distances

FRAME_RATE = 12.0  # Hz, the paper's
COMPARED = ("angle", "position", "rotation", "spatial")  # without "geodesic": a million of them take an hour
PAPER = (
    "Paper: Hauberg & Pedersen 2012, other sequences of the CMU data. Sec. 3.3, ten walks and ten runs, 1,096 poses: "
    "frames among other motions, angle 90 %, spatial 100 %. Fig. 4 (c), modes over 673 sequences: first MDS component, "
    "angle 40 %, spatial 80 %."
)


class Result(NamedTuple):
    """A row of the table."""

    metric: str
    frames_of_others: float  # share of poses recognised among other people; NaN for a single person
    motions_of_others: float
    frames: float  # among other motions, of the same person too
    motions: float
    first_component: float  # share of variance, median over the motions
    seconds: float  # for the distances, the searches and the scaling


def choose_actions(dataset: MotionDataset) -> MotionDataset:
    """The motions whose action two people or more do; for a single person, actions done at least twice.

    Actions are compared without regard to case.
    """
    names = [" ".join(action.lower().split()) for action in dataset.actions]
    actions = np.array(names, dtype=str)
    n_people = len(set(dataset.subjects))
    several = dataset.subjects if n_people > 1 else np.arange(len(dataset))
    count = {action: len(set(several[actions == action])) for action in dict.fromkeys(names) if action}
    chosen = [action for action, n in count.items() if n > 1]
    if len(chosen) < 2:
        expected = "two people do" if n_people > 1 else "are done twice"
        raise ValueError(f"expected two actions that {expected}, found {chosen} among {sorted(count)[:6]}")
    chosen_motions = dataset[np.isin(actions, chosen)]
    chosen_motions.actions = actions[np.isin(actions, chosen)]
    return chosen_motions


def prepare(dataset: MotionDataset, *, paper: bool = False) -> MotionDataset:
    """The motions to compare, at 12 Hz."""
    dataset = walks_and_runs(dataset) if paper else choose_actions(dataset)
    dataset = dataset[[len(motion) > 0 for motion in dataset]]
    motions = [motion.resample(FRAME_RATE) for motion in dataset]
    return MotionDataset(motions, dataset.subjects, dataset.trials, dataset.actions, rotations="file")


def compare(dataset: MotionDataset, *, n_jobs: int | None = None) -> Iterator[Result]:
    """Yield the result of each metric on prepared motions."""
    X, sequence = dataset.poses()
    skeleton, actions, people = dataset.skeleton, dataset.actions, dataset.subjects
    y, person, everyone = actions[sequence], people[sequence], np.arange(len(dataset))
    frames = np.split(np.arange(len(X)), np.searchsorted(sequence, everyone[1:]))
    accumulate(np.zeros((2, 2)), Paths.of(None))  # compile before the clock starts
    for metric in COMPARED:
        pose_distances(X[:1], skeleton=skeleton, metric=metric)
        start = time.perf_counter()
        D = pose_distances(X, skeleton=skeleton, metric=metric, n_jobs=n_jobs)
        of_motions = warp_all(D, frames)
        accuracies = [
            float(np.mean(classify(distances, labels, groups)))
            for distances, labels, groups in (
                (D, y, person),
                (of_motions, actions, people),
                (D, y, sequence),
                (of_motions, actions, everyone),
            )
        ]
        shares = [first_component(D[np.ix_(f, f)]) for f in frames if len(f) > 2]
        component = float(np.median(shares)) if shares else np.nan
        yield Result._make([metric, *accuracies, component, time.perf_counter() - start])


def classify(distances: np.ndarray, y: np.ndarray, groups: np.ndarray) -> np.ndarray:
    """1.0 where the nearest row of another group has the same class, else 0.0; NaN for a single group."""
    is_correct = np.full(len(y), np.nan)
    for group in np.unique(groups):
        rows, others = np.flatnonzero(groups == group), np.flatnonzero(groups != group)
        if len(others):
            is_correct[rows] = y[others[distances[np.ix_(rows, others)].argmin(axis=1)]] == y[rows]
    return is_correct


def warp_all(distances: np.ndarray, frames: list[np.ndarray]) -> np.ndarray:
    """The distances of all motions by dynamic time warping, from the distances of their frames."""
    result = np.zeros((len(frames), len(frames)))
    for i, rows in enumerate(frames):
        for j, columns in enumerate(frames[:i]):
            costs = distances[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1].copy()
            accumulate(costs, Paths.of(None))
            result[i, j] = result[j, i] = costs[-1, -1] / (len(rows) + len(columns))
    return result


def first_component(distances: np.ndarray) -> float:
    """The share of variance in the first component of multidimensional scaling."""
    return float(SpatialMDS(n_components=1, metric="precomputed").fit(distances).explained_variance_ratio_[0])
