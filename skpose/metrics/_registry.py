"""The metrics by name, and what the parameter `metric` of functions and estimators means."""

from collections.abc import Callable
from difflib import get_close_matches
from os import PathLike

from sklearn.base import clone

from skpose._compat.sklearn import HasMethods, Hidden, InstanceOf, StrOptions
from skpose._validation.skeletons import IS_SKELETON
from skpose._warnings import warn
from skpose.metrics._angle import Angle
from skpose.metrics._geodesic import Geodesic
from skpose.metrics._metric import Metric
from skpose.metrics._motion_metrics import Centered, Jerk, MotionMetric, Velocity
from skpose.metrics._position import Position
from skpose.metrics._rotation import Rotation
from skpose.metrics._spatial import Spatial
from skpose.skeleton import Skeleton

METRICS: dict[str, type[Metric]] = {metric.name: metric for metric in (Angle, Position, Rotation, Spatial, Geodesic)}
MOTION_METRICS: dict[str, type[MotionMetric]] = {metric.name: metric for metric in (Velocity, Jerk, Centered)}


def _explain_no_metric(value: object) -> None:
    """Raise the error of a class in the place of a metric, or of a word that is nearly one; say nothing of others."""
    if isinstance(value, str) and value in MOTION_METRICS:
        raise ValueError(_of_motions(MOTION_METRICS[value]()))
    words = {word.lower(): word for word in ("auto", "precomputed", *METRICS, *MOTION_METRICS)}
    if (
        isinstance(value, str)
        and value not in words.values()
        and (near := get_close_matches(value.lower(), words, n=1))
    ):
        raise TypeError(
            f"metric must be a word or a skpose.metrics.Metric, got {value!r}: did you mean {words[near[0]]!r}?"
        )
    if isinstance(value, type) and issubclass(value, Metric):
        raise TypeError(f"metric is the class {value.__name__}: pass a metric with its parameters, {value.__name__}()")


def _of_motions(metric: MotionMetric) -> str:
    return (
        f"the metric {metric.label!r} compares frames of whole motions, by what comes before and after them: only "
        "motion_distances, MotionDistanceTransformer, MotionKNeighborsTransformer, MotionIndex, find_motion, "
        "two_sample_test and outlier_test take it"
    )


IS_METRIC = InstanceOf(lambda value: isinstance(value, Metric), "skpose.metrics.Metric", _explain_no_metric)

# Constraints of the parameters that every function and estimator of distances has, for scikit-learn's validation.
OUT = [HasMethods(["__getitem__", "__setitem__"]), Hidden(str), Hidden(PathLike), None]  # a path has its own error
METRIC_CONSTRAINTS: dict[str, list] = {
    "skeleton": [IS_SKELETON, None],
    "metric": [StrOptions(["auto", *METRICS]), IS_METRIC],
}
OF_MOTIONS = [StrOptions(["auto", *METRICS, *MOTION_METRICS]), IS_METRIC]  # the metric, where motions are compared
MEAN_CONSTRAINTS = METRIC_CONSTRAINTS | {"skeleton": [IS_SKELETON]}  # where poses cannot do without one


def resolve(
    metric: str | Metric, skeleton: Skeleton | None, *, auto: str = "spatial", of_motions: bool = False
) -> Metric:
    """Return the metric that a parameter states: a copy, which nobody else changes.

    "auto" is `auto` with a skeleton and "angle" without one. Only with `of_motions` may it be a `MotionMetric`.
    """
    if isinstance(metric, str):
        if metric == "auto":
            metric = "angle" if skeleton is None else auto
        chosen = (METRICS | MOTION_METRICS)[metric]()
    else:
        chosen = clone(metric)
        chosen.check_params()
    if isinstance(chosen, MotionMetric) and not of_motions:
        raise ValueError(_of_motions(chosen))
    if chosen.needs_skeleton and skeleton is None:
        raise ValueError(
            f"the metric {chosen.label!r} needs a skeleton to place the joints, got skeleton=None: pass the Skeleton "
            'that the poses belong to, or use metric="angle"'
        )
    if isinstance(chosen, Angle) and skeleton is not None:
        _refuse_slides(skeleton)
    return chosen


def _refuse_slides(skeleton: Skeleton) -> None:
    """Refuse a skeleton whose columns are not all angles, for a metric that adds them up."""
    slides = [name for bone in skeleton.bones if bone.is_slide for name in bone.dof_names]
    if slides:
        more = f" and {len(slides) - 3} more" if len(slides) > 3 else ""
        raise ValueError(
            f'the metric "angle" adds the squares of all columns, in rad, but {", ".join(slides[:3])}{more} are in m: '
            'use a metric in m, such as "position" or "spatial", or multiply slides by what 1 m shall count in rad and '
            "pass the array alone, without a skeleton"
        )


def warn_of_no_skeleton(metric: str | Metric, skeleton: Skeleton | None) -> None:
    """Warn where "auto" is "angle", once the arguments are known to be in order."""
    if skeleton is None and isinstance(metric, str) and metric == "auto":
        warn(
            'metric="auto" without a skeleton means "angle": distances between joint angles, in rad, not between '
            'positions in space. Pass skeleton= for those, or metric="angle" if angles are meant'
        )


def require(metric: Metric, user: str, need: str, why_not: Callable[[Metric], str]) -> None:
    """Refuse a metric that has not what a function or an estimator needs, and say which ones have."""
    if reason := why_not(metric):
        able = [f'"{name}"' for name, one in METRICS.items() if not why_not(one())]
        raise ValueError(
            f"{user} needs {need}, which the metric {metric.label!r} has not: {reason}. Take {', '.join(able)}"
        )


def require_means(metric: Metric, user: str) -> None:
    """Refuse a metric under which no means are found."""
    require(metric, user, "means of poses", lambda one: one.why_no_means())


def require_geodesic(metric: str | Metric, skeleton: Skeleton, user: str) -> Geodesic:
    """Return the metric whose paths a function follows: geodesics of two steps or more."""
    chosen = resolve(metric, skeleton, auto="geodesic")
    require(chosen, user, "shortest paths", why_no_paths)
    return chosen


def why_no_paths(metric: Metric) -> str:
    """Return why a metric has no shortest paths of several steps; empty where it has."""
    return metric.why_no_means() if isinstance(metric, Geodesic) else "its curves are not geodesics"
