"""Distances in float32 are those in float64 of the same poses, within one error for poses at any distance."""

import numpy as np
import pytest
from conftest import SKELETONS

from skpose import Bone, Skeleton, pose_distances
from skpose.metrics import Angle, Geodesic, Position, Rotation, Spatial
from skpose.metrics._registry import METRICS

EPSILON = 2.0**-20  # as documented in `docs/metrics.md`
METRICS_TO_TEST = [Angle(), Angle(wrap=True), Position(), Rotation(), Geodesic(2)]
METRICS_TO_TEST += [Spatial(n_steps, wrap) for n_steps, wrap in ((1, True), (2, True), (10, True), (10, False))]
METRICS_TO_TEST += [pytest.param(Spatial(40), marks=pytest.mark.slow)]
NAMES = ["chain", "asf", "humanoid", "ball joints", "weights"]


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


def pairs_at(apart, skeleton, n=12, seed=0):
    rng = np.random.default_rng(seed)
    X = rng.normal(scale=0.7, size=(n, skeleton.n_dofs))
    Y = X + apart * rng.normal(size=X.shape)
    return X.astype(np.float32), Y.astype(np.float32)


def both(X, Y, skeleton, metric):
    """Distances computed in float32 and in float64, of the same numbers."""
    found = pose_distances(X, Y, skeleton=skeleton, metric=metric)
    assert found.dtype == np.float32
    return found, pose_distances(X.astype(np.float64), Y.astype(np.float64), skeleton=skeleton, metric=metric)


def test_every_metric_is_here():
    named = [metric.values[0] if hasattr(metric, "values") else metric for metric in METRICS_TO_TEST]
    assert {type(metric) for metric in named} == set(METRICS.values())


@pytest.mark.filterwarnings("ignore:.*did not converge")
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("metric", METRICS_TO_TEST, ids=str)
def test_one_absolute_error_holds_at_any_distance(metric, name):
    skeleton = SKELETONS[name]
    for apart in (0.0, 1e-7, 1e-5, 1e-3, 0.1) + (() if isinstance(metric, Geodesic) else (1.0, 3.0)):
        X, Y = pairs_at(apart, skeleton, 4 if isinstance(metric, Geodesic) else 12)
        found, expected = both(X, Y, skeleton, metric)
        np.testing.assert_allclose(found, expected, rtol=0, atol=bound_of(metric, skeleton, X, Y))


def test_distances_of_the_size_of_the_error_mean_nothing():
    """The bound is not far above what happens: fifty times smaller, it would not hold."""
    skeleton = SKELETONS["humanoid"]
    X, Y = pairs_at(1e-7, skeleton)
    found, expected = both(X, Y, skeleton, Spatial(10))
    error = np.abs(found - expected).max()
    assert error > 0.5 * np.diag(expected).max()
    assert error > 0.02 * bound_of(Spatial(10), skeleton, X, Y)


def test_units_and_weights_scale_the_error():
    for length, weight in ((1e3, 1.0), (1.0, 1e6)):
        bones = [Bone(f"b{i}", f"b{i - 1}" if i else None, (length, 0.0, 0.0), "z") for i in range(5)]
        large = Skeleton(bones).with_weights([weight] * 5)
        X, Y = pairs_at(1e-5, large)
        found, expected = both(X, Y, large, Position())
        np.testing.assert_allclose(found, expected, rtol=0, atol=bound_of(Position(), large, X, Y))
        assert np.abs(found - expected).max() > 1e-5
