"""What comes out of estimators for float32 poses; what is float64 says so where it is documented."""

import numpy as np
import pytest

from skpose import PoseKNeighborsTransformer, Skeleton, forward_kinematics
from skpose.cluster import MedoidShift, PoseKMeans
from skpose.manifold import SpatialMDS
from skpose.motions import MotionDistanceTransformer, MotionKNeighborsTransformer
from skpose.neighbors import PoseRadiusNeighborsTransformer
from skpose.preprocessing import PoseDistanceTransformer, PoseFromPositions
from skpose.statistics import PoseKernelRegressor, PoseTangentPCA

CHAIN = Skeleton.chain(3)
POSES = np.random.default_rng(0).normal(scale=0.5, size=(30, 3)).astype(np.float32)
POSITIONS = forward_kinematics(POSES, CHAIN).reshape(30, -1)
MOTIONS = [POSES[:10], POSES[10:20], POSES[20:]]

# What scikit-learn's counterpart has in float32 is in float32, but for the fitted attributes of PoseTangentPCA and
# PoseKMeans, whose means are searched for in float64.
OUTPUTS = [
    (PoseDistanceTransformer(CHAIN), POSES, {"fit_transform": "float32", "transform": "float32"}),
    (PoseFromPositions(CHAIN), POSITIONS, {"transform": "float32", "inverse_transform": "float32"}),
    (
        SpatialMDS(CHAIN, n_components=2),
        POSES,
        {"fit_transform": "float64", "transform": "float64", "embedding_": "float64"},
    ),
    (MedoidShift(CHAIN, n_clusters=3), POSES, {"cluster_centers_": "float32", "labels_": "int64", "predict": "int64"}),
    (
        PoseKMeans(CHAIN, n_clusters=3, metric="position", n_init=1, random_state=0),
        POSES,
        {"cluster_centers_": "float64", "labels_": "int64", "predict": "int64", "transform": "float32"},
    ),
    (PoseKNeighborsTransformer(CHAIN), POSES, {"kneighbors": "float64"}),
    (PoseRadiusNeighborsTransformer(CHAIN), POSES, {"radius_neighbors": "float64"}),
    (
        PoseTangentPCA(CHAIN),
        POSES,
        {
            "fit_transform": "float32",
            "transform": "float32",
            "inverse_transform": "float32",
            "reconstruction_error": "float64",
            "mean_": "float64",
            "components_": "float64",
            "explained_variance_": "float64",
        },
    ),
    (MotionDistanceTransformer(CHAIN), MOTIONS, {"fit_transform": "float32", "transform": "float32"}),
    (MotionKNeighborsTransformer(CHAIN, n_neighbors=1), MOTIONS, {"kneighbors": "float64"}),
]


@pytest.mark.parametrize(("estimator", "X", "expected"), OUTPUTS, ids=[type(case[0]).__name__ for case in OUTPUTS])
def test_outputs_for_float32(estimator, X, expected):
    estimator.fit(X)
    for name, dtype in expected.items():
        value = getattr(estimator, name)
        if callable(value):
            value = value(estimator.transform(X) if name == "inverse_transform" else X)
        value = value[0] if isinstance(value, tuple) else value
        value = value[0] if value.dtype == object else value
        assert value.dtype == dtype, name


def test_predictions_have_the_dtype_of_the_training_poses():
    inputs = np.random.default_rng(1).normal(size=(30, 2))
    for dtype in (np.float32, np.float64):
        regressor = PoseKernelRegressor(CHAIN, metric="position").fit(inputs, POSES.astype(dtype))
        assert regressor.predict(inputs).dtype == dtype
