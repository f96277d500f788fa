"""Shared parts of the motion estimators: the checks of X, and the skeleton, frame rate and metric learned from it."""

from typing import Any, ClassVar

import numpy as np
from sklearn.utils.validation import validate_data

from skpose._base import PoseEstimatorMixin
from skpose.datasets import MotionDataset
from skpose.metrics._registry import warn_of_no_skeleton
from skpose.motions._inputs import CheckedMotions, Sequences, check_motions, rates_differ
from skpose.skeleton import Motion, Skeleton

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
        (checked,) = check_motions({"X": X}, self.skeleton if reset else self.skeleton_, rows=True)
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
