"""Shared parts of the pose estimators: validation of X, the fitted metric, and the link to their documentation.

`fit` starts with `_check_X(X, reset=True)`, which deletes the attributes of an earlier fit and stores `skeleton_` and
`metric_`. Other methods use these attributes instead of the parameters; parameters such as `n_jobs` and `n_neighbors`
are read when a method is called, as in scikit-learn.
"""

from numbers import Integral
from typing import Any, ClassVar

import numpy as np
from sklearn.utils.validation import check_non_negative, validate_data

from skpose._utils.sklearn import StrOptions
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import check_layout, check_width
from skpose.metrics import Metric, pose_distances
from skpose.metrics._registry import METRIC_CONSTRAINTS, METRICS, resolve, warn_of_no_skeleton
from skpose.skeleton import Skeleton

# Parameters of an estimator of poses, and of one that also accepts precomputed distances.
POSE_CONSTRAINTS = {**METRIC_CONSTRAINTS, "n_jobs": [None, Integral], "verbose": ["verbose"]}
ESTIMATOR_CONSTRAINTS = {
    **POSE_CONSTRAINTS,
    "metric": [StrOptions(["auto", "precomputed", *METRICS]), *METRIC_CONSTRAINTS["metric"][1:]],
}


class EstimatorMixin:
    """Mixin for all estimators: parameter validation, refitting, and the link to the documentation."""

    skeleton: Skeleton | None

    _parameter_constraints: ClassVar[dict]

    # Linked from scikit-learn's HTML representation.
    _doc_link_module = "skpose"
    _doc_link_template = "https://skpose.github.io/skpose/api/{estimator_module}.{estimator_name}.html"

    def _forget(self):
        """Delete the attributes of an earlier fit."""
        for name in [name for name in vars(self) if name.endswith("_") and not name.startswith("_")]:
            delattr(self, name)


class PoseEstimatorMixin(EstimatorMixin):
    """Mixin for estimators with the parameters of `pose_distances`.

    Attributes
    ----------
    skeleton_ : Skeleton or None
        The skeleton in use; None with "precomputed".
    metric_ : Metric or None
        The metric in use, a copy of the parameter; None with "precomputed".
    """

    _auto_metric: ClassVar[str] = "spatial"  # with a skeleton; "position" in estimators that compute means

    _of_motions: ClassVar[bool] = False  # whether metrics of motions are allowed

    metric: str | Metric
    n_jobs: int | None
    verbose: int

    skeleton_: Skeleton | None
    metric_: Any  # a Metric; None with "precomputed"

    def _check_X(self, X, *, reset, **options):
        """Validate poses or precomputed distances; `reset` also resolves the metric."""
        if reset:
            self._forget()
            self._learn_metric(self.skeleton)
        check_layout(X, self.skeleton_, "X")
        X = validate_data(self, X, dtype=[np.float64, np.float32], reset=reset, **options)
        if self.skeleton_ is not None:
            check_width(X, self.skeleton_, "X")
            warn_of_degrees(None, self.skeleton_, X=X, in_estimator=True)
        elif reset:
            warn_of_no_skeleton(self.metric, self.skeleton)
        if self.metric_ is None:
            check_non_negative(X, f"{type(self).__name__} as precomputed distances")
            if reset and X.shape[0] != X.shape[1]:
                raise ValueError(f"precomputed distances must be a square matrix to fit, got shape {X.shape}")
        return X

    def _learn_metric(self, skeleton):
        """Set `skeleton_` and `metric_`."""
        if self._is_precomputed():
            self.skeleton_, self.metric_ = None, None
            return
        self.metric_ = resolve(self.metric, skeleton, auto=self._auto_metric, of_motions=self._of_motions)
        self.skeleton_ = skeleton

    def set_params(self, **params):
        """Set parameters; ``metric__n_steps=20`` sets a parameter of the metric.

        Parameters
        ----------
        **params : dict
            Parameters by name.

        Returns
        -------
        object
            The estimator.
        """
        metric = params.get("metric", self.metric)
        of_metric = [name for name in params if name.startswith("metric__")]
        if of_metric and not isinstance(metric, Metric):
            raise ValueError(f"{of_metric[0]} needs a metric object such as metric=Spatial(), got metric={metric!r}")
        return super().set_params(**params)  # type: ignore[misc]  # of BaseEstimator, as __sklearn_tags__

    def _is_precomputed(self):
        return isinstance(self.metric, str) and self.metric == "precomputed"

    def _distances(self, X, Y, verbose=None):
        """Distances from X to Y, or within X if Y is None, under the fitted metric."""
        return pose_distances(
            X,
            Y,
            skeleton=self.skeleton_,
            metric=self.metric_,
            n_jobs=self.n_jobs,
            verbose=self.verbose if verbose is None else verbose,
        )

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()  # type: ignore[misc]  # of the estimator's other base classes
        tags.input_tags.pairwise = tags.input_tags.positive_only = self._is_precomputed()
        return tags
