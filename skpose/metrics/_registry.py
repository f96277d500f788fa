"""The metrics by name, and what the parameters that choose one mean."""

from collections.abc import Callable
from numbers import Integral
from os import PathLike
from typing import NamedTuple

import numpy as np

from skpose._compat.sklearn import HasMethods, Hidden, Interval, StrOptions
from skpose._compiled.path import geodesic
from skpose._compiled.pose import encode, loops, measure, middle
from skpose._compiled.pose.tree import Steps, Tree
from skpose._validation.skeletons import IS_SKELETON
from skpose._warnings import warn
from skpose.kinematics._shared import tree_of
from skpose.skeleton import Skeleton


class Coarse(NamedTuple):
    """A lower bound of a distance between poses, in float32 and where the number of steps is even: as a Metric."""

    encode: Callable
    measure: Callable
    n_codes: Callable[[Tree], int]
    slack: Callable[[Tree], float]  # by how much rounding may lengthen the bound, m


class Metric(NamedTuple):
    """A distance between poses: two compiled functions, and their needs."""

    encode: Callable  # one pose -> its code
    measure: Callable  # one code, other codes -> distances
    n_codes: Callable[[Tree, int], int]  # length of a code, given the number of dofs
    needs_skeleton: bool
    wraps: bool | None  # meaning of wrap="auto"; None for a metric that whole turns do not change
    bound: str | None  # a Euclidean metric that is a lower bound of this one with wrap="auto"
    encode_work: float  # for each number of a code; adding a square to a sum is 1, some 0.2 ns
    measure_work: float  # for each number of a code, in each pair
    always_float64: bool = False
    measure_within: Callable | None = None  # the same up to `Results.limit`
    coarse: Coarse | None = None

    def encoded(self, poses: np.ndarray, skeleton: Skeleton | None, steps: Steps) -> np.ndarray:
        """Return the codes of poses, in float64."""
        tree = tree_of(skeleton if self.needs_skeleton else None)
        codes = np.empty((len(poses), self.n_codes(tree, poses.shape[1])))
        loops.encode_poses(poses, self.encode, tree, steps, codes)
        return codes


def _n_coordinates(tree: Tree, n_dofs: int) -> int:
    return 3 * (len(tree.offset) - 1)


def _n_quaternions(tree: Tree, n_dofs: int) -> int:
    return 4 * (len(tree.frame_parent) - 1)


def _n_curve_end(tree: Tree, n_dofs: int) -> int:
    return encode.count_line_codes(tree) + _n_coordinates(tree, n_dofs)


def _n_middle(tree: Tree) -> int:
    return middle.count_middle_codes(tree) + 3 * (len(tree.offset) - 1)


METRICS = {
    "angle": Metric(
        encode.encode_angles,
        measure.measure_euclidean,
        lambda tree, n_dofs: n_dofs,
        needs_skeleton=False,
        wraps=False,
        bound="angle",
        encode_work=3,
        measure_work=1,
    ),
    "position": Metric(
        encode.encode_positions,
        measure.measure_euclidean,
        _n_coordinates,
        needs_skeleton=True,
        wraps=None,
        bound="position",
        encode_work=60,
        measure_work=1,
    ),
    "rotation": Metric(
        encode.encode_rotations,
        measure.measure_rotations,
        _n_quaternions,
        needs_skeleton=True,
        wraps=None,
        bound=None,
        encode_work=40,
        measure_work=8,
    ),
    "spatial": Metric(
        encode.encode_curve_end,
        measure.measure_line,
        _n_curve_end,
        needs_skeleton=True,
        wraps=True,
        bound="position",
        encode_work=20,
        measure_work=16,
        measure_within=measure.measure_line_within,
        coarse=Coarse(middle.encode_middle, middle.measure_two_chords, _n_middle, middle.middle_slack),
    ),
    "geodesic": Metric(
        encode.encode_curve_end,
        geodesic.measure_geodesic,
        _n_curve_end,
        needs_skeleton=True,
        wraps=True,
        bound="position",
        encode_work=20,
        measure_work=100_000,
        always_float64=True,
    ),
}

# Constraints of the parameters that every function and estimator of distances has, for scikit-learn's validation.
OUT = [HasMethods(["__getitem__", "__setitem__"]), Hidden(str), Hidden(PathLike), None]  # a path has its own error
METRIC_CONSTRAINTS = {
    "skeleton": [IS_SKELETON, None],
    "metric": [StrOptions({"auto", *METRICS})],
    "n_steps": [Interval(Integral, 1, None, closed="left")],
    "wrap": ["boolean", StrOptions({"auto"})],
}


class Chosen(NamedTuple):
    """The metric that parameters choose."""

    name: str  # a key of METRICS
    metric: Metric
    steps: Steps


def warn_of_no_skeleton(metric: str, skeleton: Skeleton | None) -> None:
    """Warn where "auto" is "angle", once the arguments are known to be in order."""
    if metric == "auto" and skeleton is None:
        warn(
            'metric="auto" without a skeleton means "angle": distances between joint angles, in rad, not between '
            'positions in space. Pass skeleton= for those, or metric="angle" if angles are meant'
        )


def resolve(metric: str, skeleton: Skeleton | None, n_steps: int, wrap: bool | str) -> Chosen:
    """Return the metric that parameters choose; "auto" is "spatial" with a skeleton and "angle" without one.

    Estimators that take means have "position" for "auto", and pass that: `PoseEstimatorMixin._auto_metric`.
    """
    if metric == "auto":
        metric = "angle" if skeleton is None else "spatial"
    chosen = METRICS[metric]
    if chosen.needs_skeleton and skeleton is None:
        raise ValueError(
            f'metric="{metric}" needs a skeleton to place the joints, got skeleton=None: pass the Skeleton that the '
            'poses belong to, or use metric="angle"'
        )
    wraps = chosen.wraps if wrap == "auto" or chosen.wraps is None else wrap
    return Chosen(metric, chosen, Steps.of(n_steps, bool(wraps)))
