"""Motions that are given by the user: checked, on one skeleton, as one array of frames."""

from collections.abc import Iterable, Sequence
from numbers import Number
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from skpose._validation.poses import check_poses
from skpose._validation.skeletons import check_skeleton
from skpose._validation.units import warn_of_degrees
from skpose.datasets import MotionDataset
from skpose.datasets._shared import ONE_REST, ONE_RIG
from skpose.kinematics import retarget
from skpose.metrics import Metric
from skpose.metrics._shared import MotionMetric, require_skeleton
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import check_comparable

RATES_DIFFER = 1e-3  # as a share: files state the time between two frames with few digits, 0.00833 s for 120 Hz
ONE_MOTION = "must be one motion, a skpose.Motion or an array (n_frames, n_dofs), got "


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

    def slice(self, first: int, last: int) -> "Sequences":
        """Return the motions first:last, without a copy."""
        starts = self.starts[first : last + 1]
        return Sequences(self.poses[starts[0] : starts[-1]], starts - starts[0])

    def take(self, indices: np.ndarray) -> "Sequences":
        """Return some of the motions, as a copy."""
        return Sequences.of([self.motion(i) for i in indices])

    def in_float64(self) -> "Sequences":
        return self._replace(poses=self.poses.astype(np.float64, copy=False))

    @classmethod
    def of(cls, arrays: Sequence[np.ndarray]) -> "Sequences":
        starts = np.concatenate([[0], np.cumsum([len(array) for array in arrays])]).astype(np.int64)
        return cls(np.ascontiguousarray(np.concatenate(arrays)), starts)

    @classmethod
    def join(cls, parts: Sequence["Sequences"]) -> "Sequences":
        """Return all motions of several, one after another, as a copy."""
        return cls.of([part.motion(i) for part in parts for i in range(part.n_motions)])


class CheckedMotions(NamedTuple):
    """Motions on the skeleton on which they are compared."""

    sequences: Sequences
    skeleton: Skeleton | None
    frame_rate: float | None  # Hz; None for arrays, which have none
    times: list[np.ndarray] | None = None  # (n_frames,) of each motion, s; None for arrays

    def rows(self, metric: Metric, name: str) -> Sequences:
        """Return what a metric compares: poses, or of a metric of motions what it makes of them, in float64."""
        if not isinstance(metric, MotionMetric):
            return self.sequences
        skeleton, arrays = require_skeleton(self.skeleton), []
        for i in range(self.sequences.n_motions):
            times = None if self.times is None else self.times[i]
            try:
                arrays.append(metric.encode_motion(self.sequences.motion(i), skeleton, times))
            except ValueError as error:
                raise ValueError(
                    f"{name}[{i}]: {error}" if self.sequences.n_motions > 1 else f"{name}: {error}"
                ) from None
        return Sequences.of(arrays)


def check_motions(given: dict[str, Any], skeleton: Skeleton | None, *, rows: bool = False) -> list[CheckedMotions]:
    """Return the given motions, by name, on one skeleton and at one frame rate.

    Functions call `warn_of_degrees` themselves, as only what the user calls warns; for estimators it is called here.

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
    lists = {name: _list_motions(motions, name, rows) for name, motions in given.items()}
    named = {name: {f"{name}[{i}]": motion for i, motion in enumerate(one)} for name, one in lists.items()}
    return _on_one_skeleton(named, skeleton, [m for m in given.values() if isinstance(m, MotionDataset)], rows)


def check_single_motions(given: dict[str, Any], skeleton: Skeleton | None) -> list[CheckedMotions]:
    """Return motions that are given one by one, each a Motion or an array (n_frames, n_dofs)."""
    for name, motion in given.items():
        _check_is_one(motion, name)
    return _on_one_skeleton({name: {name: motion} for name, motion in given.items()}, skeleton, [], rows=False)


def check_motion(motion: Any, skeleton: Skeleton | None, name: str) -> CheckedMotions:
    """Return one motion, a Motion or an array (n_frames, n_dofs)."""
    return check_single_motions({name: motion}, skeleton)[0]


def _check_is_one(motion: Any, name: str) -> None:
    """Refuse several motions where one belongs; what else is no motion is refused with the lists' elements."""
    shape = _shape(motion)
    if isinstance(motion, MotionDataset) or (isinstance(motion, list | tuple) and motion and shape is None):
        raise TypeError(f"{name} {ONE_MOTION}{_describe(motion)}: pass one of them, such as {name}[0]")
    if shape is not None and len(shape) == 3:
        raise TypeError(f"{name} {ONE_MOTION}an array of shape {shape}: pass one of them, such as {name}[0]")


def _on_one_skeleton(
    given: dict[str, dict[str, Any]], skeleton: Skeleton | None, datasets: list[MotionDataset], rows: bool
) -> list[CheckedMotions]:
    """Return motions by argument and by name on one skeleton and at one frame rate, see `check_motions`."""
    if skeleton is not None:
        check_skeleton(skeleton)
    everything = {name: motion for named in given.values() for name, motion in named.items()}
    found = {name: motion for name, motion in everything.items() if isinstance(motion, Motion)}
    _check_one_kind(list(given), everything, len(found))
    frame_rate = _common_frame_rate(found)
    if found and skeleton is None:
        skeleton = _common_skeleton(found, datasets)
    checked = []
    for argument, named in given.items():
        arrays = {name: _poses(motion, skeleton, name) for name, motion in named.items()}
        _check_same_width(arrays)
        sequences = Sequences.of(list(arrays.values()))
        if rows and skeleton is not None:
            warn_of_degrees(None, skeleton, in_estimator=True, **{argument: sequences.poses})
        times = [motion.times for motion in named.values()] if found else None
        checked.append(CheckedMotions(sequences, skeleton, frame_rate, times))
    widths = [one.sequences.poses.shape[1] for one in checked]
    if len(set(widths)) > 1:
        first, second = list(given)[:2]
        raise ValueError(
            f"{first} has {widths[0]} columns and {second} has {widths[1]}; poses of one skeleton have equally many"
        )
    return checked


def _list_motions(motions: Any, name: str, rows: bool) -> list[Any]:
    """Return motions as a list, each a Motion or what may be an array of poses."""
    expected = f"{name} must be motions: a list of arrays (n_frames, n_dofs) or of skpose.Motion, got "
    if isinstance(motions, Motion):
        raise TypeError(f"{expected}one Motion: pass [{name}]")
    if isinstance(motions, dict):
        raise TypeError(f"{expected}a dict: pass list({name}.values())")
    if isinstance(motions, Skeleton | str | bytes) or not isinstance(motions, Iterable):
        raise TypeError(f"{expected}{_describe(motions)}{_remedy(motions)}")
    shape = None if isinstance(motions, MotionDataset) else getattr(motions, "shape", None)
    holds_motions = shape is not None and len(shape) == 1 and getattr(motions, "dtype", None) == np.dtype(object)
    if shape is not None and not holds_motions:
        return _rows_of(motions, tuple(shape), name, rows)
    listed = list(motions)
    if not listed:
        raise ValueError(f"{expected}none")
    if len(_shape(listed[0]) or ()) == 1 and (shape := _shape(listed)):
        return _rows_of(np.asarray(listed), shape, name, rows)
    return listed


def _shape(value: Any) -> tuple[int, ...] | None:
    """Return the shape of an array or of a list of numbers; None for what has none."""
    if isinstance(value, list | tuple):
        try:
            return np.shape(value)
        except (TypeError, ValueError):  # Motions; rows of different lengths
            return None
    shape = getattr(value, "shape", None)
    return None if shape is None else tuple(shape)


def _describe(value: Any) -> str:
    """Return what a value is, for errors."""
    if isinstance(value, Skeleton):
        return "a Skeleton"
    if isinstance(value, MotionDataset):
        return f"a MotionDataset of {len(value)}"
    if isinstance(value, list | tuple):
        kinds = sorted({type(item).__name__ for item in value})
        return f"a {type(value).__name__} of {' and '.join(kinds) or 'nothing'}"
    known = value is None or isinstance(value, Number | str | bytes | PathLike)
    return repr(value) if known else f"a {type(value).__name__}"


def _remedy(value: Any) -> str:
    """Return what to pass instead of a value that is no motion, where that is known."""
    if isinstance(value, Skeleton):
        return ": pass it as skeleton="
    if isinstance(value, str | bytes | PathLike):
        return ": skpose.io.load_motion(path) reads a motion from a file"
    if isinstance(value, MotionDataset):
        return ": join datasets by [*first, *second]"
    return ""


def _rows_of(array: Any, shape: tuple[int, ...], name: str, rows: bool) -> list[Any]:
    """Return the motions of an array; where it has two dimensions each row is a motion of one frame, or a mistake."""
    if len(shape) == 3 and shape[0]:
        return list(np.asarray(array))
    if len(shape) == 2 and rows:
        return [row[np.newaxis] for row in np.asarray(array)]
    remedy = f": pass [{name}] for one motion" if len(shape) == 2 else ""
    if remedy and isinstance(array, np.ndarray):
        remedy += f", {name}[:, None] for motions of one frame"
    raise ValueError(
        f"{name} must be motions: a list of arrays (n_frames, n_dofs), a list of skpose.Motion, or an array "
        f"(n_motions, n_frames, n_dofs), got an array of shape {shape}{remedy}"
    )


def _check_one_kind(arguments: list[str], motions: dict[str, Any], n_motions: int) -> None:
    """Refuse Motions and arrays together, as an array has neither a skeleton nor a frame rate."""
    if 0 < n_motions < len(motions):
        others = [name for name, motion in motions.items() if not isinstance(motion, Motion)]
        raise TypeError(
            f"{' and '.join(arguments)} must be all skpose.Motion or all arrays, got {n_motions} "
            f"Motion{'s' * (n_motions > 1)}, and {len(others)} other{'s' * (len(others) > 1)}, {others[0]} among them: "
            "pass motion.angles of all, or Motions alone"
        )


def _common_frame_rate(found: dict[str, Motion]) -> float | None:
    """Return the rate of the first Motion, which the others have too, but for the rounding of files."""
    rates: dict[float, str] = {}
    for name, motion in found.items():
        rates.setdefault(motion.frame_rate, name)
    if rates and rates_differ(min(rates), max(rates)):
        (one, first), (other, second) = min(rates.items()), max(rates.items())
        raise ValueError(
            f"motions must have one frame rate, as the distance counts frames, but {first} has {one:g} Hz and {second} "
            f"{other:g} Hz: pass motion.resample({one:g}) of each"
        )
    return next(iter(rates), None)


def rates_differ(one: float, other: float) -> bool:
    """Return whether two frame rates differ by more than the digits of files."""
    return max(one, other) > (1.0 + RATES_DIFFER) * min(one, other)


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
    shape = (len(motion),) if isinstance(motion, Motion) else _shape(motion)
    if shape and shape[0] == 0:
        raise ValueError(f"{name} has no frames: leave it out")
    if isinstance(motion, Motion):
        if skeleton is not None and motion.skeleton != skeleton:
            try:
                motion = retarget(motion, skeleton, method="numbers")
            except ValueError as error:
                raise ValueError(f"{name}: {error}") from None
        return motion.angles
    described = None
    if shape is not None and len(shape) < 2:
        described = f"an array of shape {shape}" if shape else _describe(motion)
    elif isinstance(motion, MotionDataset | Skeleton) or (shape is None and not hasattr(motion, "__array__")):
        described = _describe(motion)
    if described and not hasattr(motion, "collect"):  # what has no values yet has a remedy of its own
        raise TypeError(f"{name} {ONE_MOTION}{described}{_remedy(motion)}")
    return check_poses(motion, skeleton, name)


def _check_same_width(arrays: dict[str, np.ndarray]) -> None:
    (first, width), *others = ((name, array.shape[1]) for name, array in arrays.items())
    for name, other in others:
        if other != width:
            raise ValueError(
                f"{first} has {width} columns and {name} has {other}; poses of one skeleton have equally many"
            )
