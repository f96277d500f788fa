"""scikit-learn's checks of every estimator in every form, and the checks that no precomputed form can pass."""

import numpy as np
import pytest
from conftest import ChainMixin
from sklearn.utils.estimator_checks import (
    check_param_validation,
    check_set_output_transform,
    check_transformer_get_feature_names_out,
    parametrize_with_checks,
)

from skpose import PoseKNeighborsTransformer, Skeleton
from skpose.cluster import MedoidShift, PoseKMeans
from skpose.manifold import SpatialMDS
from skpose.metrics import Angle
from skpose.motions import MotionDistanceTransformer, MotionKNeighborsTransformer
from skpose.neighbors import PoseRadiusNeighborsTransformer
from skpose.preprocessing import PoseDistanceTransformer, PoseFromPositions
from skpose.statistics import PoseKernelRegressor, PoseTangentPCA

pytestmark = [
    pytest.mark.filterwarnings('ignore:metric="auto" without a skeleton:UserWarning'),  # the default form
    pytest.mark.filterwarnings("ignore:the distances have only:UserWarning"),  # data of one dimension
    pytest.mark.filterwarnings("ignore:all distances are zero:UserWarning"),
    pytest.mark.filterwarnings("ignore:the default bandwidth:UserWarning"),  # data without clusters
    pytest.mark.filterwarnings("ignore:no bandwidth was found:sklearn.exceptions.ConvergenceWarning"),
    pytest.mark.filterwarnings("ignore:only . distinct clusters:sklearn.exceptions.ConvergenceWarning"),
    # Any numbers are no positions of a chain.
    pytest.mark.filterwarnings("ignore:the joints of a frame are .* apart:UserWarning"),
    pytest.mark.filterwarnings("ignore:.* frames did not converge:sklearn.exceptions.ConvergenceWarning"),
]


class ChainDistances(ChainMixin, PoseDistanceTransformer):
    """The spatial metric on data of any width."""


class ChainMDS(ChainMixin, SpatialMDS):
    """The same."""


class ChainShift(ChainMixin, MedoidShift):
    """The same."""


class ChainKNeighbors(ChainMixin, PoseKNeighborsTransformer):
    """The same."""


class ChainRadiusNeighbors(ChainMixin, PoseRadiusNeighborsTransformer):
    """The same."""


class ChainMotionDistances(ChainMixin, MotionDistanceTransformer):
    """The same; each row is a motion of one frame."""


class ChainMotionNeighbors(ChainMixin, MotionKNeighborsTransformer):
    """The same; each row is a motion of one frame."""


class ChainKMeans(ChainMixin, PoseKMeans):
    """The same."""


class ChainRegressor(PoseKernelRegressor):
    """Targets that are poses of a planar chain as wide as y."""

    def _check_y(self, y):
        poses = super()._check_y(y)
        if self.skeleton_ is None:
            super()._learn_metric(Skeleton.chain(poses.shape[1]))
        return poses

    def _learn_metric(self, skeleton):
        """Wait for the width of y."""
        self.skeleton_, self.metric_ = None, Angle()


class ChainTangentPCA(ChainMixin, PoseTangentPCA):
    """The same, under "position" or "geodesic"."""


class ChainPositions(PoseFromPositions):
    """Positions of a planar chain of as many joints as columns need, the last ones zero."""

    def _positions(self, X, skeleton):
        X = np.pad(X, ((0, 0), (0, -X.shape[1] % 3)))
        return super()._positions(X, Skeleton.chain(X.shape[1] // 3))

    def _check_X(self, X, *, reset):
        positions = super()._check_X(X, reset=reset)
        if reset:
            self.skeleton_ = Skeleton.chain(positions.shape[1])
        return positions


SPATIAL = [
    ChainDistances(),
    ChainMDS(),
    ChainShift(),
    ChainKMeans(),
    ChainRegressor(),
    ChainKNeighbors(),
    ChainRadiusNeighbors(radius=3.0),
    ChainMotionDistances(),
    ChainMotionNeighbors(),
    ChainTangentPCA(),
]
POSITIONS = [ChainPositions(Skeleton.chain(1))]
PRECOMPUTED = [SpatialMDS(metric="precomputed"), MedoidShift(metric="precomputed")]

# As docs/development.md says.
EXPECTED_FAILURES = {
    (MedoidShift, "precomputed"): {
        "check_clustering": "fits points where a matrix of distances is expected; so does DBSCAN's precomputed form"
    },
    (ChainShift, "auto"): {
        "check_sample_weight_equivalence_on_dense_data": "shuffles the samples, whose order numbers the clusters, and "
        "relies on the default bandwidth, which does not depend on weights"
    },
}


def expected_failures(estimator):
    return EXPECTED_FAILURES.get((type(estimator), getattr(estimator, "metric", None)), {})


@parametrize_with_checks(SPATIAL + POSITIONS + PRECOMPUTED, expected_failed_checks=expected_failures)
def test_every_check_of_scikit_learn(estimator, check):
    check(estimator)


@pytest.mark.parametrize("estimator", SPATIAL + POSITIONS, ids=lambda estimator: type(estimator).__name__)
@pytest.mark.parametrize(
    "check",
    [check_param_validation, check_set_output_transform, check_transformer_get_feature_names_out],
    ids=lambda check: check.__name__,
)
def test_checks_that_are_not_in_the_standard_list(estimator, check):
    if hasattr(estimator, "transform") or check is check_param_validation:
        check(type(estimator).__name__, estimator)
