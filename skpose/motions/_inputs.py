"""Motions given by the user: checked, on one skeleton, as one array of frames."""

from collections.abc import Iterable, Sequence
from typing import Any, ClassVar, NamedTuple

import numpy as np
from sklearn.utils import check_array
from sklearn.utils.validation import validate_data

from skpose._base import PoseEstimatorMixin
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import check_poses, check_skeleton
from skpose.datasets._motions import ONE_REST, ONE_RIG, MotionDataset
from skpose.kinematics import retarget
from skpose.metrics._metric import Metric, require_skeleton
from skpose.metrics._motion_metrics import MotionMetric
from skpose.metrics._registry import warn_of_no_skeleton
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._rest import check_comparable

RATES_DIFFER = 1e-3  # relative: files round the time between two frames, 0.00833 s for 120 Hz


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
        return self.poses[self.starts[i] : self.starts[i + 1]]

    def slice(self, first: int, last: int) -> "Sequences":
        """The motions first:last, without a copy."""
        starts = self.starts[first : last + 1]
        return Sequences(self.poses[starts[0] : starts[-1]], starts - starts[0])

    def take(self, indices: np.ndarray) -> "Sequences":
        """Some of the motions, as a copy."""
        return Sequences.of([self.motion(i) for i in indices])

    def in_float64(self) -> "Sequences":
        return self._replace(poses=self.poses.astype(np.float64, copy=False))

    @classmethod
    def of(cls, arrays: Sequence[np.ndarray]) -> "Sequences":
        starts = np.concatenate([[0], np.cumsum([len(array) for array in arrays])]).astype(np.int64)
        return cls(np.ascontiguousarray(np.concatenate(arrays)), starts)

    @classmethod
    def join(cls, parts: Sequence["Sequences"]) -> "Sequences":
        """The motions of several collections, one after another, as a copy."""
        return cls.of([part.motion(i) for part in parts for i in range(part.n_motions)])


class CheckedMotions(NamedTuple):
    """Motions on the skeleton on which they are compared."""

    sequences: Sequences
    skeleton: Skeleton | None
    frame_rate: float | None  # Hz; None for arrays
    times: list[np.ndarray] | None = None  # (n_frames,) of each motion, s; None for arrays

    def rows(self, metric: Metric, name: str) -> Sequences:
        """What a metric compares: poses, or what a metric of motions makes of them, in float64."""
        if not isinstance(metric, MotionMetric):
            return self.sequences
        skeleton, arrays = require_skeleton(self.skeleton), []
        for i in range(self.sequences.n_motions):
            times = None if self.times is None else self.times[i]
            try:
                arrays.append(metric.encode_motion(self.sequences.motion(i), skeleton, times))
            except ValueError as error:
                raise ValueError(f"{name}[{i}]: {error}") from None
        return Sequences.of(arrays)


def check_motions(given: dict[str, Any], skeleton: Skeleton | None) -> list[CheckedMotions]:
    """Check motions by argument name; bring them onto one skeleton and require one frame rate.

    Parameters
    ----------
    given : dict
        Lists of arrays (n_frames, n_dofs) or of `Motion`, a `MotionDataset`, or an array (n_motions, n_frames, n_dofs),
        by argument name.
    skeleton : Skeleton or None
        None takes the skeleton of the Motions, or their mean skeleton.
    """
    named = {
        name: {f"{name}[{i}]": motion for i, motion in enumerate(_list_motions(motions, name))}
        for name, motions in given.items()
    }
    return _on_one_skeleton(named, skeleton)


def check_single_motions(given: dict[str, Any], skeleton: Skeleton | None) -> list[CheckedMotions]:
    """Check single motions, each a Motion or an array (n_frames, n_dofs)."""
    for name, motion in given.items():
        is_list = (
            isinstance(motion, list | tuple) and len(motion) and (isinstance(motion[0], Motion) or np.ndim(motion) > 2)
        )
        if is_list or isinstance(motion, MotionDataset) or len(getattr(motion, "shape", ())) == 3:
            raise TypeError(f"{name} must be one motion, got several; pass one of them, such as {name}[0]")
    return _on_one_skeleton({name: {name: motion} for name, motion in given.items()}, skeleton)


def rates_differ(one: float, other: float) -> bool:
    """Whether two frame rates differ by more than the rounding of files."""
    return max(one, other) > (1.0 + RATES_DIFFER) * min(one, other)


def _on_one_skeleton(given: dict[str, dict[str, Any]], skeleton: Skeleton | None) -> list[CheckedMotions]:
    """Check motions by argument and by name, see `check_motions`."""
    if skeleton is not None:
        check_skeleton(skeleton)
    everything = {name: motion for named in given.values() for name, motion in named.items()}
    found = {name: motion for name, motion in everything.items() if isinstance(motion, Motion)}
    if 0 < len(found) < len(everything):
        raise TypeError(f"{' and '.join(given)} must be all Motion objects or all arrays, got both")
    frame_rate = _common_frame_rate(found)
    if found and skeleton is None:
        names: dict[Skeleton, str] = {}
        for name, motion in found.items():
            names.setdefault(motion.skeleton, name)
        check_comparable(list(names), list(names.values()), ONE_REST, ONE_RIG)
        skeleton = Skeleton.mean(names)
    poses = {name: _poses(motion, skeleton, name) for name, motion in everything.items()}
    first, width = next((name, array.shape[1]) for name, array in poses.items())
    for name, array in poses.items():
        if array.shape[1] != width:
            raise ValueError(f"{name} has {array.shape[1]} columns, but {first} has {width}")
    return [
        CheckedMotions(
            Sequences.of([poses[name] for name in named]),
            skeleton,
            frame_rate,
            [motion.times for motion in named.values()] if found else None,
        )
        for named in given.values()
    ]


def _list_motions(motions: Any, name: str) -> list[Any]:
    """Motions as a list, each a Motion or something that may be an array of poses."""
    is_array = hasattr(motions, "shape") or hasattr(motions, "__array__")
    if isinstance(motions, Motion | Skeleton | str | bytes) or not (is_array or isinstance(motions, Iterable)):
        raise TypeError(f"{name} must be a list of motions, got {type(motions).__name__}; pass [{name}] for one Motion")
    if isinstance(motions, MotionDataset) or not is_array or getattr(motions, "dtype", None) == np.dtype(object):
        motions = list(motions)
        if motions and (isinstance(motions[0], Motion | MotionDataset) or np.ndim(motions[0]) == 2):
            return motions
    array = check_array(
        motions, dtype=None, ensure_2d=False, allow_nd=True, ensure_all_finite=False, ensure_min_samples=0
    )
    if array.ndim == 2 or not len(array):
        raise ValueError(
            f"{name} must be a list of motions, got an array of shape {array.shape}; pass [{name}] for one"
        )
    return list(array)


def _common_frame_rate(found: dict[str, Motion]) -> float | None:
    """The rate of the first Motion; the others may differ by the rounding of files."""
    rates = {motion.frame_rate: name for name, motion in reversed(found.items())}
    if rates and rates_differ(min(rates), max(rates)):
        (one, first), (other, second) = min(rates.items()), max(rates.items())
        raise ValueError(f"{first} has {one:g} Hz and {second} {other:g} Hz: pass motion.resample({one:g}) of each")
    return next(iter(found.values())).frame_rate if found else None


def _poses(motion: Any, skeleton: Skeleton | None, name: str) -> np.ndarray:
    """The poses of a motion, float32 if they were and else float64, in the columns of the skeleton."""
    if isinstance(motion, Motion):
        if not len(motion):
            raise ValueError(f"{name} has no frames")
        if skeleton is not None and motion.skeleton != skeleton:
            try:
                motion = retarget(motion, skeleton, method="numbers")
            except ValueError as error:
                raise ValueError(f"{name}: {error}") from None
        return motion.angles
    return check_poses(motion, skeleton, name)


# --- base -------------------------------------------------------------------------------------------------------------
# Shared parts of the motion estimators: the checks of X, and the skeleton, frame rate and metric learned from it.


ALIGNMENT = "alignment", "window"  # parameters of the alignment; an estimator may have fewer


class MotionEstimatorMixin(PoseEstimatorMixin):
    """Mixin for estimators with the parameters of `motion_distances`.

    X is a list of motions, a `MotionDataset`, or an array of three dimensions. The rows of an array of two dimensions
    are motions of one frame each, which scikit-learn's own checks need.

    Attributes
    ----------
    skeleton_ : Skeleton or None
        The skeleton in use: the parameter, or from the training motions.
    frame_rate_ : float or None
        Frame rate of the training motions, Hz; None for arrays.
    metric_ : Metric
        The metric in use, a copy of the parameter.
    alignment_ : str
        How motions are aligned. Only for estimators with the parameter, as is `window_`.
    window_ : float or None
        The Sakoe–Chiba band in use.
    """

    _of_motions: ClassVar[bool] = True

    frame_rate_: float | None

    def _check_X(self, X, *, reset):  # type: ignore[override]  # validate_data has no options for motions
        """Check X and convert it to rows for the metric, as `Sequences`; learn from it if `reset`."""
        if is_rows(X):
            poses = super()._check_X(X, reset=reset, copy=reset)
            self._check_frame_rate(None, reset)
            sequences = Sequences(np.ascontiguousarray(poses), np.arange(len(poses) + 1))
            return CheckedMotions(sequences, self.skeleton_, None).rows(self.metric_, "X")
        if reset:
            self._forget()
        (checked,) = check_motions({"X": X}, self.skeleton if reset else self.skeleton_)
        if checked.skeleton is not None:
            warn_of_degrees(None, checked.skeleton, in_estimator=True, X=checked.sequences.poses)
        if reset:
            self._learn_metric(checked.skeleton)
            warn_of_no_skeleton(self.metric, checked.skeleton)
        self._check_frame_rate(checked.frame_rate, reset)
        validate_data(self, checked.sequences.poses, reset=reset, skip_check_array=True)  # the number of features
        return checked.rows(self.metric_, "X")

    def _check_frame_rate(self, frame_rate, reset):
        """Learn the frame rate, None for arrays, or refuse a different one."""
        fitted, name = None if reset else self.frame_rate_, type(self).__name__
        if reset:
            self.frame_rate_ = frame_rate
        elif (frame_rate is None) != (fitted is None):
            given, other = ("Motion objects", "arrays") if fitted is None else ("arrays", "Motion objects")
            raise TypeError(f"X holds {given}, but {name} was fitted on {other}")
        elif fitted is not None and rates_differ(frame_rate, fitted):
            raise ValueError(f"X has {frame_rate:g} Hz, but {name} was fitted on {fitted:g} Hz: resample X")

    def _learn_metric(self, skeleton):
        super()._learn_metric(skeleton)
        for name in ALIGNMENT:
            if hasattr(self, name):
                setattr(self, f"{name}_", getattr(self, name))

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.input_tags.three_d_array = True
        return tags


def is_rows(X: Any) -> bool:
    """Whether X is for scikit-learn's checks: an array of two dimensions, or something they refuse as one."""
    if isinstance(X, Motion | MotionDataset | Skeleton):
        return False
    if isinstance(X, list | tuple):
        return bool(X) and not isinstance(X[0], Motion | MotionDataset | Skeleton | str) and np.ndim(X[0]) < 2
    is_list_of_motions = getattr(X, "dtype", None) == np.dtype(object) and X.ndim == 1
    return hasattr(X, "__array__") and not is_list_of_motions and len(getattr(X, "shape", ())) < 3
