"""Distances in float32 have the absolute error that `pose_distances` documents, at any distance."""

import numpy as np
import pytest
from conftest import SKELETONS

from skpose import pose_distances
from skpose.metrics import Angle, Geodesic, Position, Rotation, Spatial

EPSILON = 2.0**-20


def size_of(skeleton):
    """√Σ w r², r the length of the bones from the root to a joint, m."""
    reach = {}
    for bone in skeleton.bones:
        reach[bone.name] = np.linalg.norm(bone.offset) + (reach[bone.parent] if bone.parent else 0.0)
    return np.sqrt(np.square(list(reach.values())) @ skeleton.weights)


def bound_of(metric, skeleton, X, Y):
    if isinstance(metric, Angle):
        return EPSILON * max(np.linalg.norm(X, axis=1).max(), np.linalg.norm(Y, axis=1).max())
    return EPSILON * size_of(skeleton) * (1 + metric.n_steps / 2 if isinstance(metric, Spatial) else 1)


@pytest.mark.filterwarnings("ignore:.*did not converge")
@pytest.mark.parametrize("name", ["humanoid", "ball joints", "weights"])
@pytest.mark.parametrize(
    "metric", [Angle(), Angle(wrap=True), Position(), Rotation(), Geodesic(2), Spatial(2), Spatial(wrap=False)], ids=str
)
def test_the_error_is_within_its_bound(metric, name):
    skeleton, rng = SKELETONS[name], np.random.default_rng(0)
    for apart in (0.0, 1e-5, 0.1) + (() if isinstance(metric, Geodesic) else (3.0,)):
        X = rng.normal(scale=0.7, size=(4 if isinstance(metric, Geodesic) else 12, skeleton.n_dofs))
        X, Y = X.astype(np.float32), (X + apart * rng.normal(size=X.shape)).astype(np.float32)
        found = pose_distances(X, Y, skeleton=skeleton, metric=metric)
        assert found.dtype == np.float32
        expected = pose_distances(X.astype(float), Y.astype(float), skeleton=skeleton, metric=metric)
        np.testing.assert_allclose(found, expected, rtol=0, atol=bound_of(metric, skeleton, X, Y))
