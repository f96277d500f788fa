"""Shared parts of the motion estimators: the checks of X, and the skeleton, frame rate and metric that they learn.

A fitted estimator answers as it was fitted, see `skpose._base`. X is a list of motions, a `MotionDataset`, an array of
three dimensions, or one of two: each row is then a motion of one frame, and scikit-learn's own checks apply.
"""

from typing import Any, ClassVar

import numpy as np
from sklearn.utils.validation import validate_data

from skpose._base import PoseEstimatorMixin
from skpose.datasets import MotionDataset
from skpose.metrics._shared import warn_of_no_skeleton, warn_of_unconverged
from skpose.motions._inputs import CheckedMotions, Sequences, check_motions, rates_differ
from skpose.motions._matrix import MotionMatrix
from skpose.motions._memory import folder_of, remember_distances
from skpose.skeleton import Motion, Skeleton

ALIGNMENT = "alignment", "window"  # parameters of how motions are aligned, of which an estimator may have fewer


class MotionEstimatorMixin(PoseEstimatorMixin):
    """Mixin for estimators with the parameters of `motion_distances`; `alignment` and `window` where they have them.

    Attributes
    ----------
    skeleton_ : Skeleton or None
        The skeleton in use: the given one, or that of the training motions.
    frame_rate_ : float or None
        Frame rate of the training motions, Hz; None for arrays, which have none.
    metric_ : Metric
        The metric in use, a copy of the parameter.
    alignment_ : str
        How motions are aligned. Only where the estimator has the parameter, as the next one.
    window_ : float or None
        The Sakoe–Chiba band in use.
    """

    _of_motions: ClassVar[bool] = True

    frame_rate_: float | None

    def _check_X(self, X, *, reset):  # type: ignore[override]  # validate_data has no options for motions
        """Return what is compared of the motions of X as `Sequences`, on the skeleton in use; a copy if `reset`.

        With `reset` forget what was learnt before, and learn the skeleton, the frame rate and the metric.
        """
        if _is_rows(X):
            poses = super()._check_X(X, reset=reset, copy=reset)
            self._check_kind(None, reset)
            sequences = Sequences(np.ascontiguousarray(poses), np.arange(len(poses) + 1))
            return CheckedMotions(sequences, self.skeleton_, None).rows(self.metric_, "X")
        if reset:
            self._forget()
        else:
            self._check_how_to_answer()
        (checked,) = check_motions({"X": X}, self.skeleton if reset else self.skeleton_, rows=True)
        if reset:
            self._learn_metric(checked.skeleton)
        self._check_kind(checked.frame_rate, reset)
        validate_data(self, checked.sequences.poses, reset=reset, skip_check_array=True)  # the number of features
        if reset:
            warn_of_no_skeleton(self.metric, checked.skeleton)
        return checked.rows(self.metric_, "X")

    def _check_kind(self, frame_rate, reset):
        """Learn the frame rate, or refuse another one; None is that of arrays, whose rate nobody knows."""
        name, fitted = type(self).__name__, None if reset else self.frame_rate_
        if reset:
            self.frame_rate_ = frame_rate
        elif frame_rate is None and fitted is not None:
            raise TypeError(
                f"X holds arrays, but {name} was fitted on Motions: pass Motions, or fit it on arrays too, "
                "[motion.angles for motion in motions] with skeleton="
            )
        elif frame_rate is not None and fitted is None:
            raise TypeError(
                f"X holds Motions, but {name} was fitted on arrays: pass [motion.angles for motion in X], or fit "
                "it on Motions too"
            )
        elif frame_rate is not None and fitted is not None and rates_differ(frame_rate, fitted):
            raise ValueError(
                f"X has {frame_rate:g} Hz, but {name} was fitted on motions of {fitted:g} Hz, and the "
                f"distance counts frames: pass [motion.resample({fitted:g}) for motion in X]"
            )

    def _learn_metric(self, skeleton):
        """Store the metric that the parameter states on a skeleton, and how motions are aligned."""
        super()._learn_metric(skeleton)
        for name in ALIGNMENT:
            if hasattr(self, name):
                setattr(self, f"{name}_", getattr(self, name))

    def _distances(self, X, Y, verbose=None):
        """Distances from the motions X to the motions Y, or among X if Y is None, under the metric of `fit`."""
        alignment = {name: getattr(self, f"{name}_") for name in ALIGNMENT if hasattr(self, f"{name}_")}
        matrix = MotionMatrix(X, Y, self.metric_, self.skeleton_, **alignment)
        verbose = self.verbose if verbose is None else verbose
        if (folder := folder_of(getattr(self, "memory", None))) is None:
            (distances, unconverged), n_cells = matrix.write(None, self.n_jobs, verbose), matrix.n_cells
        else:
            distances, unconverged, n_cells = remember_distances(matrix, folder, self.n_jobs, verbose)
        warn_of_unconverged(unconverged, n_cells)
        return distances

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.input_tags.three_d_array = True
        return tags


def _is_rows(X: Any) -> bool:
    """Return whether X is what scikit-learn's checks expect: an array of two dimensions, or what they refuse as one.

    Words for what is neither that nor motions are those of `check_motions`.
    """
    if isinstance(X, list | tuple):
        return bool(X) and not isinstance(X[0], Motion | MotionDataset | Skeleton | str) and np.ndim(X[0]) < 2
    if isinstance(X, Motion | MotionDataset | Skeleton):
        return False
    if hasattr(X, "shape"):
        is_list = len(X.shape) == 1 and getattr(X, "dtype", None) == np.dtype(object)
        return len(X.shape) < 3 and not is_list
    return hasattr(X, "__array__") and np.asarray(X).ndim < 3
