"""The motions of which a classifier has confused the classes, and the nearest of those that they were taken for."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.cluster.hierarchy import leaves_list, linkage
from scipy.sparse.csgraph import connected_components
from scipy.spatial.distance import squareform
from sklearn.metrics import confusion_matrix
from sklearn.utils.multiclass import unique_labels

from skpose.datasets import MotionDataset
from skpose.metrics import Metric, pose_distances
from skpose.motions import motion_distances
from skpose.motions._shared import CheckedMotions
from skpose.skeleton import Skeleton

ROUNDING = 1e-3  # of the largest distance: of a square root of float32
SOME = 4  # indices of poses in a label


class Confusion(NamedTuple):
    """A motion, or a pose, that was taken for another class, of a `ConfusionDisplay`.

    Attributes
    ----------
    sample : int
        Its index in X.
    true : str or int
        Its class.
    predicted : str or int
        The class that it was taken for.
    frequency : int
        How many of its class were taken for this one.
    nearest : int or None
        The motion of the class that it was taken for that is nearest to it: its index in ``X_train``, where that is
        given, else in X. None: there is none.
    distance : float
        The distance to this one, NaN without it.

    Examples
    --------
    >>> from skpose.plot import Confusion
    >>> Confusion(sample=7, true="walk", predicted="run", frequency=2, nearest=12, distance=0.4).nearest
    12
    """

    sample: int
    true: Any
    predicted: Any
    frequency: int
    nearest: int | None
    distance: float


class Recordings(NamedTuple):
    """Motions, or poses as motions of one frame, with their classes."""

    name: str  # of the argument
    noun: str  # what one of them is
    given: list  # Motions, or the arrays of `poses`
    poses: list[np.ndarray]  # (n_frames, n_dofs) of each, on the skeleton of all
    classes: np.ndarray
    subjects: list | None
    frame_rate: float | None

    def describe(self, indices: list) -> str:
        """Return some of them in words: index, subject and duration of one, indices of several."""
        known = [i for i in indices if i is not None]
        if not known:
            return f"none {'of others ' * (self.subjects is not None)}in {self.name}"
        if len(known) > 1:
            words = ", ".join(map(str, known[:SOME])) + ", …" * (len(known) > SOME)
            return f"{self.noun}s {words}"
        index = known[0]
        words = f"{self.noun} {index}" + ("" if self.subjects is None else f", subject {self.subjects[index]}")
        if self.frame_rate is None or len(self.poses[index]) == 1:
            return words
        return f"{words}\n{(len(self.poses[index]) - 1) / self.frame_rate:.1f} s"


def list_recordings(X, name, checked: CheckedMotions, classes, name_of_classes, subjects) -> Recordings:
    """Return motions with their classes and subjects, which must be as many."""
    n = checked.sequences.n_motions
    poses = [checked.sequences.motion(i) for i in range(n)]
    if subjects is None:
        subjects = getattr(X, "subjects", None) if isinstance(X, MotionDataset) else None
    return Recordings(
        name,
        ("training " if name == "X_train" else "") + ("pose" if max(map(len, poses)) == 1 else "motion"),
        poses if checked.times is None else list(X),
        poses,
        check_column(classes, name_of_classes, n, name),
        None if subjects is None else check_column(subjects, "subjects", n, name).tolist(),
        checked.frame_rate,
    )


def check_column(values, name: str, n: int, of: str) -> np.ndarray:
    """Return one value for each motion."""
    values = np.asarray(values)
    if values.shape != (n,):
        raise ValueError(f"{name} must have one value for each of the {n} motions of {of}, got shape {values.shape}")
    return values


def check_distances(distances, n: int, train: Recordings, is_own: bool) -> np.ndarray:
    """Return the distances from motions to those that were learnt from."""
    distances = np.asarray(distances, dtype=np.float64)
    expected = (n, len(train.poses))
    if distances.shape != expected:
        raise ValueError(
            f"distances must have shape {expected}, from each motion of X to each of {train.name}, got "
            f"{distances.shape}"
        )
    if np.isnan(distances).any():
        raise ValueError(f"distances must be numbers, got {np.isnan(distances).sum()} NaN")
    finite = distances[np.isfinite(distances)]
    rounding = ROUNDING * np.abs(finite).max(initial=0.0)
    if distances.min(initial=0.0) < -rounding:
        raise ValueError(
            f"distances must not be negative, got {distances.min():.4g}: if it is a kernel, K(a, a) + K(b, b) - "
            "2 K(a, b) is a squared distance"
        )
    if is_own:
        own = np.diag(distances)
        bad = np.isfinite(own) & (own > rounding)  # an infinite one leaves the motion itself out
        if bad.any():
            raise ValueError(
                f"distances from motions of X to themselves must be zero, got {own[bad.argmax()]:.4g} for motion "
                f"{bad.argmax()}: a kernel, or a similarity, is no distance; distances to other motions need X_train="
            )
    return distances


def count_confusions(y_true: np.ndarray, y_pred: np.ndarray, labels: Sequence | None) -> tuple[np.ndarray, list]:
    """Return the matrix of counts, and its classes in order."""
    known = unique_labels(y_true, y_pred)
    if labels is None:
        order = known[_arrange(confusion_matrix(y_true, y_pred, labels=known))]
    else:
        order = np.asarray(labels)
        lacking = np.setdiff1d(known, order)
        if len(lacking):
            column = "y_true" if lacking[0] in y_true else "y_pred"
            raise ValueError(f"labels must be all classes, got none that is {lacking.tolist()[0]!r}, as in {column}")
        if len(np.unique(order)) < len(order):
            raise ValueError(f"labels must be different classes, got {order.tolist()}")
    return confusion_matrix(y_true, y_pred, labels=order), order.tolist()


def _arrange(counts: np.ndarray) -> np.ndarray:
    """Return an order of classes in which those that are confused with each other are adjacent; else as they are."""
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    shares = shares + shares.T
    np.fill_diagonal(shares, 0.0)
    _, parts = connected_components(shares > 0)
    order: list[int] = []
    for part in dict.fromkeys(parts.tolist()):
        members = np.flatnonzero(parts == part)
        if len(members) > 2:
            apart = 1.0 - shares[np.ix_(members, members)] / shares.max()
            np.fill_diagonal(apart, 0.0)
            leaves = leaves_list(linkage(squareform(apart), "average", optimal_ordering=True))
            members = members[leaves if leaves[0] < leaves[-1] else leaves[::-1]]
        order += members.tolist()
    return np.array(order)


def find_nearest(
    confused: np.ndarray,
    predicted: np.ndarray,
    motions: Recordings,
    train: Recordings,
    distances: np.ndarray | None,
    skeleton: Skeleton,
    metric: str | Metric,
    n_jobs: int | None,
) -> dict[int, tuple[int | None, float]]:
    """Return for each motion that is confused the nearest one of the class that it was taken for, and how far it is."""
    found: dict[int, tuple[int | None, float]] = {int(i): (None, np.nan) for i in confused}
    for label in np.unique(predicted[confused]).tolist():
        rows, columns = confused[predicted[confused] == label], np.flatnonzero(train.classes == label)
        if not len(columns):
            if train is not motions:
                raise ValueError(f"y_pred has {label!r}, which is no class of y_train: pass what was learnt from")
            continue
        if distances is None:
            some = [motions.given[i] for i in rows], [train.given[j] for j in columns]
            given: dict[str, Any] = {"skeleton": skeleton, "metric": metric, "n_jobs": n_jobs}
            if motions.noun == "pose" and train.noun.endswith("pose") and isinstance(some[0][0], np.ndarray):
                between = pose_distances(*map(np.concatenate, some), **given)
            else:
                between = motion_distances(*some, **given)
        else:
            between = distances[np.ix_(rows, columns)]
        if train is motions and motions.subjects is not None:
            subjects = np.asarray(motions.subjects)
            between = np.where(subjects[rows, np.newaxis] == subjects[columns], np.inf, between)
        for i, of_one in zip(rows.tolist(), between, strict=True):
            if np.isfinite(of_one.min()):
                found[i] = int(columns[of_one.argmin()]), float(of_one.min())
    return found


def sort_confusions(confused, y_true, y_pred, nearest, counts, labels) -> list[Confusion]:
    """Return confusions: the most frequent pairs of classes first, and of a pair what is nearest."""
    row = {label: i for i, label in enumerate(labels)}
    found, true_classes, predicted_classes = [], y_true.tolist(), y_pred.tolist()
    for i in confused.tolist():
        true, predicted = true_classes[i], predicted_classes[i]
        found.append(Confusion(i, true, predicted, int(counts[row[true], row[predicted]]), *nearest[i]))
    return sorted(
        found,
        key=lambda one: (-one.frequency, row[one.true], row[one.predicted], np.nan_to_num(one.distance, nan=np.inf)),
    )
