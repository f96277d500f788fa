"""The metrics by name, and what the parameter `metric` of functions and estimators means."""

from typing import cast

from sklearn.base import clone

from skpose._utils.sklearn import HasMethods, StrOptions
from skpose._utils.warnings import warn
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
OUT = [HasMethods(["__setitem__"]), None]
METRIC_CONSTRAINTS: dict[str, list] = {
    "skeleton": [Skeleton, None],
    "metric": [StrOptions(["auto", *METRICS]), Metric],
}
OF_MOTIONS = [StrOptions(["auto", *METRICS, *MOTION_METRICS]), Metric]
MEAN_CONSTRAINTS = METRIC_CONSTRAINTS | {"skeleton": [Skeleton]}


def resolve(
    metric: str | Metric, skeleton: Skeleton | None, *, auto: str = "spatial", of_motions: bool = False
) -> Metric:
    """A new copy of the metric that a parameter `metric` stands for.

    "auto" is `auto` with a skeleton and "angle" without one. A `MotionMetric` needs `of_motions`.
    """
    if isinstance(metric, str):
        if metric == "auto":
            metric = "angle" if skeleton is None else auto
        chosen = (METRICS | MOTION_METRICS)[metric]()
    else:
        chosen = clone(metric)
        chosen.check_params()
    if isinstance(chosen, MotionMetric) and not of_motions:
        raise ValueError(f"the metric {chosen.label!r} compares whole motions: use motion_distances, not poses")
    if chosen.needs_skeleton and skeleton is None:
        raise ValueError(f'the metric {chosen.label!r} needs a skeleton, got None: pass skeleton= or metric="angle"')
    if isinstance(chosen, Angle) and skeleton is not None and any(bone.is_slide for bone in skeleton.bones):
        raise ValueError('metric="angle" needs columns in rad, got slides in m: use "position" or "spatial"')
    return chosen


def warn_of_no_skeleton(metric: str | Metric, skeleton: Skeleton | None) -> None:
    """Warn where "auto" means "angle", after the arguments have been checked."""
    if skeleton is None and isinstance(metric, str) and metric == "auto":
        warn('metric="auto" without a skeleton means "angle": distances in rad. Pass skeleton= for distances in space')


def require(metric: Metric, user: str, need: str, able: bool) -> None:
    """Refuse a metric that is not able to do what a function or an estimator needs."""
    if not able:
        raise ValueError(f"{user} needs {need}, which {metric.label!r} does not have")


def require_means(metric: Metric, user: str) -> None:
    """Refuse a metric without means."""
    require(metric, user, "means of poses", metric.has_means)


def require_geodesic(metric: str | Metric, skeleton: Skeleton, user: str) -> Geodesic:
    """The metric whose shortest paths a function follows, which have two steps or more."""
    chosen = resolve(metric, skeleton, auto="geodesic")
    require(chosen, user, "shortest paths of two steps or more", isinstance(chosen, Geodesic) and chosen.has_means)
    return cast(Geodesic, chosen)
