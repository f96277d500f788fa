"""Shared parts of the pose estimators: the checks of X, the metric that they learn, and where they are documented.

A fitted estimator answers as it was fitted. `fit` begins with `_check_X(X, reset=True)`, which forgets a fit before and
stores the skeleton and the metric as fitted attributes; what comes after `fit` reads these, never the parameters of the
same meaning. Parameters that only state how to answer, `HOW_TO_ANSWER`, are read when they are used, as in
scikit-learn.
"""

import inspect
from numbers import Integral
from typing import Any, ClassVar

import numpy as np
from sklearn.utils.validation import check_non_negative, validate_data

from skpose._compat.sklearn import InvalidParameterError, StrOptions, validate_parameter_constraints
from skpose._validation.columns import check_column_names, check_dimensions, check_width
from skpose._validation.poses import check_is_array
from skpose._validation.skeletons import is_skeleton
from skpose._validation.units import warn_of_degrees
from skpose.metrics import Metric, pose_distances
from skpose.metrics._shared import METRIC_CONSTRAINTS, METRICS, resolve, warn_of_no_skeleton
from skpose.skeleton import Skeleton

# Constraints of the parameters of an estimator of poses, and of one that also takes distances.
POSE_CONSTRAINTS = {**METRIC_CONSTRAINTS, "n_jobs": [None, Integral], "verbose": ["verbose"]}
ESTIMATOR_CONSTRAINTS = {
    **POSE_CONSTRAINTS,
    "metric": [StrOptions(["auto", "precomputed", *METRICS]), *METRIC_CONSTRAINTS["metric"][1:]],
}


class EstimatorMixin:
    """Mixin for all estimators: `skeleton` is first, nothing is left of a fit before, the documentation is found."""

    skeleton: Skeleton | None

    _parameter_constraints: ClassVar[dict]

    # Where scikit-learn's HTML representation finds the page of an estimator, and with it a tooltip for each parameter.
    _doc_link_module = "skpose"
    _doc_link_template = "https://skpose.github.io/skpose/api/{page}.html"
    _is_experimental: ClassVar[bool] = False  # and so not a name of `skpose` itself

    def _doc_link_url_param_generator(self):
        package = type(self).__module__.rpartition(".")[0] if self._is_experimental else "skpose"
        return {"page": f"{package}.{type(self).__name__}"}

    def _validate_params(self):
        """Check all parameters, as scikit-learn's `fit` begins; another one in the place of the skeleton has words."""
        if self.skeleton is not None and not is_skeleton(self.skeleton):
            self._explain_no_name(self.skeleton)
        super()._validate_params()  # type: ignore[misc]  # of BaseEstimator

    def _explain_no_name(self, value):
        """Refuse a value that stands first if another parameter, which needs its name, accepts it."""
        name = type(self).__name__
        for other in list(inspect.signature(type(self)).parameters)[1:]:
            try:
                validate_parameter_constraints({other: self._parameter_constraints[other]}, {other: value}, name)
            except InvalidParameterError:
                continue
            raise InvalidParameterError(
                f"skeleton must be a skpose.Skeleton, got {type(value).__name__}: it comes first, and the other "
                f"parameters of {name} need their names, as in {other}={value!r}"
            )

    def _forget(self):
        """Remove the attributes of a fit before."""
        for name in [name for name in vars(self) if name.endswith("_") and not name.startswith("_")]:
            delattr(self, name)

    def _check_how_to_answer(self):
        """Check the parameters that may have changed since `fit`, which checks all of them."""
        given = {name: getattr(self, name) for name in HOW_TO_ANSWER if hasattr(self, name)}
        constraints = {name: self._parameter_constraints[name] for name in given}
        validate_parameter_constraints(constraints, given, type(self).__name__)


class PoseEstimatorMixin(EstimatorMixin):
    """Mixin for estimators with the parameters of `pose_distances`.

    Attributes
    ----------
    skeleton_ : Skeleton or None
        The skeleton in use; None with "precomputed".
    metric_ : Metric or None
        The metric in use, a copy of the parameter; None with "precomputed".
    """

    _auto_metric: ClassVar[str] = "spatial"  # with a skeleton; "position" where means are taken, which are quick then

    _of_motions: ClassVar[bool] = False  # whether the metric may be one of motions

    metric: str | Metric
    n_jobs: int | None
    verbose: int

    skeleton_: Skeleton | None
    metric_: Any  # a Metric; None with "precomputed"

    def _check_X(self, X, *, reset, **options):
        """Return X as an array that fits the skeleton; precomputed distances as they are.

        With `reset` forget what was learnt before, and learn the metric.
        """
        check_is_array(X, "X")
        if reset:
            self._forget()
            self._learn_metric(self.skeleton)
        else:
            self._check_how_to_answer()
        if self.skeleton_ is not None:
            check_column_names(X, self.skeleton_, "X")
            check_dimensions(X, self.skeleton_, "X")
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
        """Store the metric that the parameter states on a skeleton."""
        if self._is_precomputed():
            self.skeleton_, self.metric_ = None, None
            return
        self.metric_ = resolve(self.metric, skeleton, auto=self._auto_metric, of_motions=self._of_motions)
        self.skeleton_ = skeleton

    def set_params(self, **params):
        """Set parameters, those of the metric by ``metric__n_steps=20`` and the like.

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
            raise ValueError(
                f"{of_metric[0]} is a parameter of a metric, but metric={metric!r} is no object, which has some: pass "
                "one of skpose.metrics, such as metric=Spatial()"
            )
        return super().set_params(**params)  # type: ignore[misc]  # of BaseEstimator, as __sklearn_tags__

    def _is_precomputed(self):
        return isinstance(self.metric, str) and self.metric == "precomputed"

    def _distances(self, X, Y, verbose=None):
        """Distances from X to Y, or among X if Y is None, under the metric of `fit`."""
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


HOW_TO_ANSWER = "n_jobs", "verbose", "n_neighbors", "radius", "mode", "joint_limits", "regularization", "memory"
