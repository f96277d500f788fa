"""Geodesics and motions through key poses that keep joint limits: none leaves them, by wrapping, slerp or rounding."""

from functools import partial

import numpy as np
import pytest
from limited import assert_inside, hinge, limited_skeleton, poses_inside
from scipy.interpolate import CubicSpline

from skpose import Skeleton, geodesic
from skpose.datasets import humanoid
from skpose.geodesics import interpolate
from skpose.metrics import Geodesic

METHODS = ["geodesic", "spline"]
enforced = partial(geodesic, joint_limits="enforce")
GAP = (-3.0, 2.8)  # the wrapped difference of the two is outside
SEEDS = [range(4), pytest.param(range(4, 40), marks=pytest.mark.slow)]


@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning", "ignore:values of .* reach:UserWarning")
@pytest.mark.parametrize("seeds", SEEDS)
def test_no_pose_of_a_path_leaves_the_limits(seeds):
    for seed in seeds:
        skeleton = limited_skeleton(seed)
        a, b = poses_inside(skeleton, 2, seed)
        limited = np.isfinite(skeleton.limits).any(axis=1)
        for metric in (Geodesic(), Geodesic(2), Geodesic(3, wrap=False)):
            found = enforced(a, b, skeleton, metric=metric, max_iter=30)
            assert_inside(found.path, skeleton)
            assert_inside(found.resample(97), skeleton)
            np.testing.assert_array_equal(found.path[0], a)
            np.testing.assert_array_equal(found.path[-1, limited], b[limited])
            np.testing.assert_array_equal(found.resample(5)[-1, limited], b[limited])


@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning", "ignore:values of .* reach:UserWarning")
@pytest.mark.parametrize("seeds", SEEDS)
@pytest.mark.parametrize("method", METHODS)
def test_no_frame_between_keys_leaves_the_limits(method, seeds):
    for seed in seeds:
        skeleton = limited_skeleton(seed)
        X = poses_inside(skeleton, 4, seed)
        limited = np.isfinite(skeleton.limits).any(axis=1)
        motion = interpolate(
            X, [0, 1, 1.5, 3], skeleton, frame_rate=20, method=method, metric=Geodesic(5), joint_limits="enforce"
        )
        assert_inside(motion.angles, skeleton)
        np.testing.assert_array_equal(motion.angles[[0, 20, 30, 60]][:, limited], X[:, limited])
        free = motion.angles[:, ~limited & [name[-2] == "r" for name in skeleton.dof_names]]
        if method == "geodesic":
            assert np.abs(np.diff(free, axis=0)).max(initial=0.0) <= np.pi


@pytest.mark.parametrize("n_steps", [2, 3, 10])
@pytest.mark.parametrize("wrap", [True, False])
def test_a_limited_hinge_never_takes_the_closed_way(wrap, n_steps):
    arm = Skeleton([hinge(GAP)])
    found = enforced([-2.9], [2.7], arm, metric=Geodesic(n_steps, wrap))
    assert (np.diff(found.path[:, 0]) > 0).all()
    np.testing.assert_allclose(found.resample(50)[:, 0], np.linspace(-2.9, 2.7, 50), atol=1e-3)
    motion = interpolate([[-2.9], [2.7]], [0, 1], arm, frame_rate=8, joint_limits="enforce", metric=Geodesic(n_steps))
    np.testing.assert_allclose(motion.angles[:, 0], np.linspace(-2.9, 2.7, 9), atol=1e-2)
    assert geodesic([-2.9], [2.7], arm).path[-1, 0] < -3.0  # what is ignored does not hold


def test_joints_without_limits_turn_freely():
    """Limits of the hinges that no pose comes near do not make a path of shoulders and hips another one."""
    skeleton = humanoid()
    wide = Skeleton(bone._replace(limits=((-3.1, 3.1),)) if bone.n_dofs == 1 else bone for bone in skeleton.bones)
    a, b = np.random.default_rng(0).normal(0, 0.8, (2, skeleton.n_dofs))
    free, limited = geodesic(a, b, skeleton), enforced(a, b, wide)
    assert np.abs(free.path[:, wide.limits[:, 1] < 4]).max() < 3.0
    np.testing.assert_allclose(limited.path, free.path, atol=1e-9)
    np.testing.assert_allclose(limited.resample(20), free.resample(20), atol=1e-9)


def test_splines_stop_at_limits():
    """The natural spline of one angle, clipped."""
    keys, times = np.array([[0.0], [1.0], [0.99], [0.0]]), np.arange(4.0)
    free, limited = (
        interpolate(keys, times, Skeleton([hinge((0.0, 1.0))]), frame_rate=40, joint_limits=joint_limits)
        for joint_limits in ("ignore", "enforce")
    )
    expected = CubicSpline(times, keys, bc_type="natural")(free.times)
    assert expected.max() > 1.03
    np.testing.assert_allclose(free.angles, expected, atol=1e-3)
    np.testing.assert_array_equal(limited.angles, np.clip(free.angles, 0.0, 1.0))
    assert (limited.angles == 1.0).sum() > 5
