"""Shared parts of the pose estimators: the checks of X, and the distances by their parameters."""

from numbers import Integral

import numpy as np
from sklearn.utils.validation import check_non_negative, validate_data

from skpose._compat.sklearn import StrOptions
from skpose.metrics import pose_distances
from skpose.metrics._registry import METRIC_CONSTRAINTS, METRICS
from skpose.skeleton import Skeleton
from skpose.skeleton._columns import check_column_names, check_dimensions, check_width
from skpose.skeleton._units import warn_of_degrees
from skpose.skeleton._validation import check_is_array

# Constraints of the parameters of an estimator that also takes distances.
ESTIMATOR_CONSTRAINTS = {
    **METRIC_CONSTRAINTS,
    "metric": [StrOptions({"auto", "precomputed", *METRICS})],
    "n_jobs": [None, Integral],
    "verbose": ["verbose"],
}


class PoseEstimatorMixin:
    """Mixin for estimators with the parameters of `pose_distances`."""

    skeleton: Skeleton | None
    metric: str
    n_steps: int
    wrap: bool | str
    n_jobs: int | None
    verbose: int

    def _checked(self, X, *, reset, **options):
        """Return X as an array that fits the skeleton; precomputed distances as they are."""
        check_is_array(X, "X")
        skeleton = None if self.metric == "precomputed" else self.skeleton
        if skeleton is not None:
            check_column_names(X, skeleton, "X")
            check_dimensions(X, skeleton, "X")
        X = validate_data(self, X, dtype=[np.float64, np.float32], reset=reset, **options)
        if skeleton is not None:
            check_width(X, skeleton, "X")
            warn_of_degrees(X=X, in_estimator=True)
        if self.metric == "precomputed":
            check_non_negative(X, f"{type(self).__name__} as precomputed distances")
            if reset and X.shape[0] != X.shape[1]:
                raise ValueError(f"precomputed distances must be a square matrix to fit, got shape {X.shape}")
        return X

    def _distances(self, X, Y, verbose=None):
        """Distances from X to Y, or among X if Y is None."""
        return pose_distances(
            X,
            Y,
            skeleton=self.skeleton,
            metric=self.metric,
            n_steps=self.n_steps,
            wrap=self.wrap,
            n_jobs=self.n_jobs,
            verbose=self.verbose if verbose is None else verbose,
        )

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()  # type: ignore[misc]  # of the estimator's other base classes
        tags.input_tags.pairwise = self.metric == "precomputed"
        return tags
