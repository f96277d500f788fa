"""Motions that are given by the user: checked, on one skeleton, as one array of frames."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from skpose.datasets import MotionDataset
from skpose.datasets._motions import ONE_REST, ONE_RIG
from skpose.kinematics import retarget
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._arguments import check_skeleton
from skpose.skeleton._skeleton import check_comparable
from skpose.skeleton._units import warn_of_degrees
from skpose.skeleton._validation import check_poses


class Sequences(NamedTuple):
    """Poses of several motions, one motion after another."""

    poses: np.ndarray  # (n_frames, n_dofs) of all motions
    starts: np.ndarray  # (n_motions + 1,) motion i is poses[starts[i]:starts[i + 1]]

    @property
    def n_motions(self) -> int:
        return len(self.starts) - 1

    @property
    def lengths(self) -> np.ndarray:
        """The number of frames of each motion."""
        return np.diff(self.starts)

    def motion(self, i: int) -> np.ndarray:
        """Return the poses of a motion."""
        return self.poses[self.starts[i] : self.starts[i + 1]]

    def part(self, first: int, last: int) -> "Sequences":
        """Return the motions first:last, without a copy."""
        starts = self.starts[first : last + 1]
        return Sequences(self.poses[starts[0] : starts[-1]], starts - starts[0])

    def in_float64(self) -> "Sequences":
        return self._replace(poses=self.poses.astype(np.float64, copy=False))

    @classmethod
    def of(cls, arrays: Sequence[np.ndarray]) -> "Sequences":
        starts = np.concatenate([[0], np.cumsum([len(array) for array in arrays])]).astype(np.int64)
        return cls(np.ascontiguousarray(np.concatenate(arrays)), starts)


class Checked(NamedTuple):
    """Motions on the skeleton on which they are compared."""

    sequences: Sequences
    skeleton: Skeleton | None
    frame_rate: float | None  # Hz; None for arrays, which have none


def check_motions(given: dict[str, Any], skeleton: Skeleton | None, *, rows: bool = False) -> list[Checked]:
    """Return the given motions, by name, on one skeleton and at one frame rate.

    Parameters
    ----------
    given : dict
        Lists of arrays (n_frames, n_dofs) or of `Motion`, a `MotionDataset`, or an array (n_motions, n_frames, n_dofs),
        by the name of the argument.
    skeleton : Skeleton or None
        None is that of the Motions: of several the mean skeleton.
    rows : bool
        Whether a two-dimensional array is motions of one frame each, as estimators take it, and no mistake.
    """
    if skeleton is not None:
        check_skeleton(skeleton)
    lists = {name: _listed(motions, name, rows) for name, motions in given.items()}
    found = {f"{name}[{i}]": m for name, one in lists.items() for i, m in enumerate(one) if isinstance(m, Motion)}
    _check_one_kind(lists, len(found))
    frame_rate = _common_frame_rate(found)
    if found and skeleton is None:
        skeleton = _common_skeleton(found, [m for m in given.values() if isinstance(m, MotionDataset)])
    checked = []
    for name, motions in lists.items():
        arrays = [_poses(m, skeleton, f"{name}[{i}]") for i, m in enumerate(motions)]
        _check_same_width(arrays, name)
        sequences = Sequences.of(arrays)
        if skeleton is not None:
            warn_of_degrees(in_estimator=rows, **{name: sequences.poses})
        checked.append(Checked(sequences, skeleton, frame_rate))
    widths = [one.sequences.poses.shape[1] for one in checked]
    if len(set(widths)) > 1:
        first, second = list(given)[:2]
        raise ValueError(
            f"{first} has {widths[0]} columns and {second} has {widths[1]}; poses of one skeleton have equally many"
        )
    return checked


def check_motion(motion: Any, skeleton: Skeleton | None, name: str) -> Checked:
    """Return one motion, a Motion or an array (n_frames, n_dofs)."""
    if isinstance(motion, MotionDataset) or (isinstance(motion, list | tuple) and motion and np.ndim(motion[0]) > 1):
        raise TypeError(f"{name} must be one motion, got {len(motion)}: pass one of them")
    return check_motions({name: [motion]}, skeleton)[0]


def _listed(motions: Any, name: str, rows: bool) -> list[Any]:
    """Return motions as a list, each a Motion or what may be an array of poses."""
    expected = f"{name} must be motions: a list of arrays (n_frames, n_dofs) or of skpose.Motion, got "
    if isinstance(motions, Motion):
        raise TypeError(f"{expected}one Motion: pass [{name}]")
    if isinstance(motions, Skeleton | str | bytes | dict) or not isinstance(motions, Iterable):
        raise TypeError(f"{expected}{motions!r}" if not isinstance(motions, Skeleton) else f"{expected}a Skeleton")
    if isinstance(motions, np.ndarray) and motions.dtype == object and motions.ndim == 1:
        motions = list(motions)
    if hasattr(motions, "shape") and not isinstance(motions, MotionDataset):
        return _rows_of(motions, tuple(motions.shape), name, rows)
    listed = list(motions)
    if not listed:
        raise ValueError(f"{expected}none")
    if not isinstance(listed[0], Motion) and np.ndim(listed[0]) == 1:
        return _rows_of(np.asarray(listed), (len(listed), len(listed[0])), name, rows)
    return listed


def _rows_of(array: Any, shape: tuple[int, ...], name: str, rows: bool) -> list[Any]:
    """Return the motions of an array; where it has two dimensions each row is a motion of one frame, or a mistake."""
    if len(shape) == 3 and shape[0]:
        return list(np.asarray(array))
    if len(shape) == 2 and rows:
        return [row[np.newaxis] for row in np.asarray(array)]
    remedy = f": pass [{name}] for one motion, {name}[:, None] for motions of one frame" if len(shape) == 2 else ""
    raise ValueError(
        f"{name} must be motions: a list of arrays (n_frames, n_dofs), a list of skpose.Motion, or an array "
        f"(n_motions, n_frames, n_dofs), got an array of shape {shape}{remedy}"
    )


def _check_one_kind(lists: dict[str, list[Any]], n_motions: int) -> None:
    """Refuse Motions and arrays together, as an array has neither a skeleton nor a frame rate."""
    if 0 < n_motions < sum(map(len, lists.values())):
        arrays = [f"{name}[{i}]" for name, one in lists.items() for i, m in enumerate(one) if not isinstance(m, Motion)]
        raise TypeError(
            f"{' and '.join(lists)} must be all skpose.Motion or all arrays, got {n_motions} Motions, and "
            f"{len(arrays)} others, {arrays[0]} among them: pass motion.angles of all, or Motions alone"
        )


def _common_frame_rate(found: dict[str, Motion]) -> float | None:
    rates = {motion.frame_rate: name for name, motion in found.items()}
    if len(rates) > 1:
        (one, first), (other, second) = sorted(rates.items())[:2]
        raise ValueError(
            f"motions must have one frame rate, as the distance counts frames, but {first} has {one:g} Hz and {second} "
            f"{other:g} Hz: pass motion.resample({one:g}) of each"
        )
    return next(iter(rates), None)


def _common_skeleton(found: dict[str, Motion], datasets: list[MotionDataset]) -> Skeleton:
    """Return the skeleton of Motions, of several the mean, as `MotionDataset.skeleton`."""
    if len(datasets) == 1 and len(found) == len(datasets[0]):
        return datasets[0].skeleton
    names: dict[Skeleton, str] = {}
    for name, motion in found.items():
        names.setdefault(motion.skeleton, name)
    check_comparable(list(names), list(names.values()), ONE_REST, ONE_RIG)
    return Skeleton.mean(names)


def _poses(motion: Any, skeleton: Skeleton | None, name: str) -> np.ndarray:
    """Return the poses of a motion, float32 if they were and else float64, in columns of the skeleton."""
    if isinstance(motion, Motion):
        if len(motion) == 0:
            raise ValueError(f"{name} has no frames: leave it out")
        if skeleton is not None and motion.skeleton != skeleton:
            try:
                motion = retarget(motion, skeleton, method="numbers")
            except ValueError as error:
                raise ValueError(f"{name}: {error}") from None
        return motion.angles
    return check_poses(motion, skeleton, name)


def _check_same_width(arrays: list[np.ndarray], name: str) -> None:
    for i, array in enumerate(arrays):
        if array.shape[1] != arrays[0].shape[1]:
            raise ValueError(
                f"{name}[0] has {arrays[0].shape[1]} columns and {name}[{i}] has {array.shape[1]}; poses of one "
                "skeleton have equally many"
            )
