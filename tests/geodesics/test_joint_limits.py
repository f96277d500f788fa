"""Geodesics and motions through key poses that keep joint limits: none leaves them, by wrapping, slerp or rounding."""

from functools import partial

import numpy as np
import pytest
from limited import assert_inside, hinge, limited_skeleton, poses_inside
from scipy.interpolate import CubicSpline

from skpose import Bone, Motion, Skeleton, geodesic
from skpose.datasets import humanoid
from skpose.geodesics import interpolate
from skpose.metrics import Geodesic

METHODS = ["geodesic", "spline"]
enforced = partial(geodesic, joint_limits="enforce")
GAP = (-3.0, 2.8)  # the wrapped difference of the two is outside
SEEDS = [range(k, k + 10) for k in range(0, 40, 10)]


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


@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning")
def test_refined_paths_do_not_round_past_a_limit():
    """The line ends at lower + (upper − lower), which rounds to more than upper here, and is then divided."""
    rng, n_refined = np.random.default_rng(0), 0
    for _ in range(40):
        lower, upper = -rng.uniform(2, 3), rng.uniform(0.1, 1)
        if lower + (upper - lower) <= upper:
            continue
        bones = [Bone("a", None, (1, 0, 0), "xyz"), Bone("b", "a", (0, 1, 0), "z", None, ((lower, upper),))]
        skeleton = Skeleton([*bones, Bone("c", "b", (0, 0, 1), "zx")])
        a, b = rng.uniform(-2, 2, (2, 6))
        a[3], b[3] = lower, upper
        path = enforced(a, b, skeleton).path
        assert_inside(path, skeleton)
        n_refined += len(path) > 11
    assert n_refined > 3


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


@pytest.mark.parametrize("limits", [GAP, (-np.pi, np.pi), (-4.0, np.inf), (-np.inf, 3.0), (-7.0, 7.0)])
def test_numbers_of_limited_dofs_are_no_directions(limits):
    """Ranges of more than a turn too, such as a robot's wrist, whose cables do not wind."""
    found = enforced([-2.9, -2.9], [2.7, 2.7], Skeleton([hinge(limits), hinge(None, "other")]))
    np.testing.assert_array_equal(found.path[[0, -1], 0], [-2.9, 2.7])
    np.testing.assert_allclose(found.path[-1, 1], 2.7 - 2 * np.pi)  # no limits: wrapped
    free = [hinge(None), hinge(None, "other")]
    assert found.length > 3 * geodesic([-2.9, -2.9], [2.7, 2.7], Skeleton(free)).length


def test_infinite_limits_are_none():
    arm = Skeleton([hinge((-np.inf, np.inf)), hinge((-1, 1), "other")])
    np.testing.assert_allclose(enforced([-2.9, 0], [2.7, 0.5], arm).path[-1], [2.7 - 2 * np.pi, 0.5])


def test_limits_of_joints_without_weight_that_have_a_gap():
    arm = Skeleton([hinge(None, "seen"), hinge(GAP)._replace(weight=0.0), hinge(None, "free")._replace(weight=0.0)])
    path = enforced([0.0, -2.9, -2.9], [1.0, 2.7, 2.7], arm).path
    np.testing.assert_allclose(path[:, 1], np.linspace(-2.9, 2.7, len(path)), atol=1e-12)
    np.testing.assert_allclose(path[:, 2], np.linspace(-2.9, 2.7 - 2 * np.pi, len(path)), atol=1e-12)


def test_limits_of_joints_without_weight_that_are_more_than_a_turn_apart():
    arm = Skeleton([hinge(None, "seen"), hinge((-7, 9))._replace(weight=0.0)])
    found = enforced([0.0, -6.5], [0.01, 8.5], arm, metric=Geodesic(2))
    np.testing.assert_array_equal(found.path[:, 1], [-6.5, 1.0, 8.5])


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


ELBOW = Skeleton(
    [Bone("shoulder", None, (0.3, 0, 0), "xyz"), Bone("elbow", "shoulder", (0.3, 0, 0), "y", None, ((0, 2),))]
)


def test_poses_outside_are_refused_in_words():
    inside, outside = [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, -0.5]
    words = r"elbow_ry is -28.6\S*°, its limits 0° and 114.5\S*°\. Take the nearest pose inside, np.clip\({}, "
    for ends, name in (((outside, inside), "start"), ((inside, outside), "end")):
        with pytest.raises(ValueError, match=f"in {name} " + words.format(name)):
            enforced(*ends, ELBOW)
    nearest = np.clip(outside, *ELBOW.limits.T)
    assert_inside(enforced(inside, nearest, ELBOW).path, ELBOW)
    keys, options = np.array([inside, inside, outside]), {"frame_rate": 10, "joint_limits": "enforce"}
    with pytest.raises(ValueError, match=r"in poses\[2\] " + words.format("poses")):
        interpolate(keys, [0, 1, 2], ELBOW, **options)
    with pytest.raises(ValueError, match=r"in poses.angles\[2\] " + words.format("poses.angles")):
        interpolate(Motion(ELBOW, keys, 1), **options)


def test_the_refusal_names_the_worst_and_a_remedy_by_whole_turns():
    turned = [0.0, 0.0, 0.0, 1.0 - 4 * np.pi]
    with pytest.raises(ValueError, match=r"elbow_ry is -662\.\d*°, .* \(57.2957\d°, the same rotation, is inside\)"):
        enforced(turned, np.zeros(4), ELBOW)
    keys = np.array([[0, 0, 0, 2.1], [0, 0, 0, 1], [0, 0, 0, -1.0]])
    with pytest.raises(ValueError, match=r"in poses\[2\] .*; 2 numbers are outside in all\."):
        interpolate(keys, [0, 1, 2], ELBOW, frame_rate=10, joint_limits="enforce")
    half = Skeleton([hinge((0.5, np.inf))])
    with pytest.raises(ValueError, match=r"arm_rz is 0°, its limits 28.6\S* and inf° \(360°, the same rotation, is"):
        enforced([0.0], [1.0], half)


def test_ends_that_rounding_moves_outside_are_at_the_limit():
    arm = Skeleton([hinge((-1.2, 1.2))])
    ends = np.array([[-1.2], [1.2]], np.float32)
    assert float(ends[1, 0]) > 1.2
    np.testing.assert_array_equal(enforced(*ends, arm).path[[0, -1]], [[-1.2], [1.2]])
    motion = interpolate(ends, [0, 1], arm, frame_rate=10, joint_limits="enforce")
    np.testing.assert_array_equal(motion.angles[[0, -1]], [[-1.2], [1.2]])
    with pytest.raises(ValueError, match=r"arm_rz is 68\.75511°, its limits -68\.75494° and 68\.75494°"):
        enforced([0.0], [1.2 + 3e-6], arm)


def test_limits_to_keep_are_needed():
    with pytest.raises(ValueError, match='joint_limits="enforce" needs a skeleton with limits'):
        interpolate([[0.0], [1.0]], [0, 1], Skeleton.chain(1), frame_rate=10, joint_limits="enforce")
