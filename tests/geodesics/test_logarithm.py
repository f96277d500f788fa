import numpy as np
import pytest
import reference
from conftest import SKELETONS, random_tree, weighted

from skpose import Bone, Skeleton, geodesic, pose_distances
from skpose.geodesics import exp_map, log_map
from skpose.kinematics import position_jacobian as jacobian_of
from skpose.metrics import Geodesic

ONE_BONE = Skeleton.chain(1)
BALL = Skeleton([Bone("hand", None, (0.0, 0.0, 0.5), "rotvec")])
# A straight arm at angle zero: the shoulder's twist moves no joint until the elbow bends.
ARM = Skeleton([Bone("elbow", None, (0.3, 0.0, 0.0), "rotvec"), Bone("wrist", "elbow", (0.25, 0.0, 0.0), "y")])


def arc(angle, n_steps):
    """Length of n equal chords of an arc of radius one."""
    return 2.0 * n_steps * np.sin(angle / (2.0 * n_steps))


def lengths(velocities, skeleton):
    weights = reference.weights(skeleton)
    return np.sqrt(np.square(velocities).sum(axis=-1) @ weights)


def poses_near(skeleton, n=6, scale=0.4, seed=0):
    return np.random.default_rng(seed).normal(scale=scale, size=(n, skeleton.n_dofs))


def assert_same_joints(X, Y, skeleton, atol=1e-6):
    np.testing.assert_allclose(reference.F(X, skeleton), reference.F(Y, skeleton), atol=atol)


# --- closed forms ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n_steps", [2, 10, 80])
def test_one_bone_moves_on_a_circle(n_steps):
    base, angles = np.array([0.4]), np.array([0.4, 0.9, -1.1, 1.9])
    velocities = log_map(base, angles[:, None], ONE_BONE, metric=Geodesic(n_steps))
    tangent = [-np.sin(0.4), np.cos(0.4), 0.0]
    np.testing.assert_allclose(velocities[:, 0], arc(angles - 0.4, n_steps)[:, None] * tangent, atol=1e-9)
    np.testing.assert_allclose(exp_map(base, velocities, ONE_BONE, metric=Geodesic(n_steps))[:, 0], angles, atol=1e-8)


@pytest.mark.parametrize("n_steps", [2, 10, 80])
def test_a_ball_joint_moves_on_great_circles(n_steps):
    rng = np.random.default_rng(0)
    base, X = rng.normal(scale=0.5, size=3), rng.normal(scale=0.8, size=(5, 3))
    start, ends = reference.forward_kinematics(base, BALL)[0, 0], reference.forward_kinematics(X, BALL)[:, 0]
    angles = np.arccos(ends @ start / 0.25)
    across = ends - (ends @ start / 0.25)[:, None] * start
    expected = 0.5 * arc(angles, n_steps)[:, None] * across / np.linalg.norm(across, axis=1, keepdims=True)
    velocities = log_map(base, X, BALL, metric=Geodesic(n_steps))
    np.testing.assert_allclose(velocities[:, 0], expected, atol=1e-6)
    found = exp_map(base, velocities, BALL, metric=Geodesic(n_steps))
    np.testing.assert_allclose(reference.forward_kinematics(found, BALL)[:, 0], ends, atol=1e-6)


# --- log and exp -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["chain", "asf", "bvh"])
def test_exp_inverts_log(name):
    skeleton = SKELETONS[name]
    base, *X = poses_near(skeleton)
    found = exp_map(base, log_map(base, X, skeleton), skeleton)
    assert_same_joints(found, np.array(X), skeleton, atol=2e-4)


def near_poses(skeleton, scale, n, seed=0):
    """Return a base and poses about it."""
    rng = np.random.default_rng(seed)
    base = rng.normal(scale=0.3, size=skeleton.n_dofs)
    return base, base + rng.normal(scale=scale, size=(n, skeleton.n_dofs))


@pytest.mark.parametrize("n_steps", [2, 10, 40])
def test_log_inverts_exp(n_steps):
    for skeleton in (Skeleton.chain(3), BALL, SKELETONS["humanoid"]):
        base, X = near_poses(skeleton, 0.1, 2, seed=1)
        velocities = 1.3 * log_map(base, X, skeleton, metric=Geodesic(n_steps))
        found = exp_map(base, velocities, skeleton, metric=Geodesic(n_steps))
        again = log_map(base, found, skeleton, metric=Geodesic(n_steps))
        off = lengths(again - velocities, skeleton) / lengths(velocities, skeleton)
        assert (off < 1e-6).all()


def test_the_base_is_zero():
    base = poses_near(ARM)[0]
    np.testing.assert_allclose(log_map(base, base[None], ARM), 0.0, atol=1e-12)
    np.testing.assert_array_equal(exp_map(base, np.zeros((1, 2, 3)), ARM), base[None])


def test_lengths_are_distances():
    for skeleton in (Skeleton.chain(4), ARM, weighted(random_tree(1, n=6), 1)):
        base, *X = poses_near(skeleton)
        expected = pose_distances(base[None], X, skeleton=skeleton, metric="geodesic")[0]
        np.testing.assert_allclose(lengths(log_map(base, X, skeleton), skeleton), expected, rtol=5e-3)


def test_a_part_of_a_logarithm_leads_to_a_pose_of_the_geodesic():
    skeleton = Skeleton.chain(3)
    start, end = np.array([0.2, 0.3, 0.1]), np.array([1.6, -0.4, 0.5])
    path = geodesic(start, end, skeleton, tol=0.0).path
    velocity = log_map(start, end[None], skeleton)
    for k in (3, 7):  # with as many chords as are walked: the same chords
        found = exp_map(start, k / 10 * velocity, skeleton, metric=Geodesic(k))[0]
        np.testing.assert_allclose(found, path[k], atol=1e-4)
        finer = exp_map(start, k / 10 * velocity, skeleton)
        apart = pose_distances(start[None], finer, skeleton=skeleton, metric="geodesic")[0]
        np.testing.assert_allclose(apart, k / 10 * lengths(velocity, skeleton), rtol=1e-2)


def test_the_logarithm_is_the_gradient_of_half_the_squared_distance():
    for skeleton, scale in ((Skeleton.chain(4), 0.4), (ARM, 0.7)):
        base, end = poses_near(skeleton, 2, scale, seed=3)
        velocity = log_map(base, end[None], skeleton, metric=Geodesic(40))[0]
        weights, J = reference.weights(skeleton), jacobian_of(base[None], skeleton)[0]
        for d in range(skeleton.n_dofs):
            moved = base + 1e-3 * np.eye(skeleton.n_dofs)[d] * np.array([[1.0], [-1.0]])
            near = pose_distances(moved, end[None], skeleton=skeleton, metric=Geodesic(40))[:, 0]
            slope = 0.5 * (near[0] ** 2 - near[1] ** 2) / 2e-3
            expected = -(velocity * J[:, d].reshape(-1, 3) * weights[:, None]).sum()
            size = lengths(velocity, skeleton) * np.linalg.norm(J[:, d])
            np.testing.assert_allclose(slope, expected, atol=2e-3 * size)


def test_velocities_are_in_the_tangent_space():
    base, *X = poses_near(ARM)
    J = jacobian_of(base[None], ARM)[0]
    for velocity in log_map(base, X, ARM).reshape(5, -1):
        np.testing.assert_allclose(J @ np.linalg.lstsq(J, velocity, rcond=1e-8)[0], velocity, atol=1e-9)


def test_a_straight_limb_at_the_base():
    """The twist of a straight arm moves no joint, but turns the plane in which the elbow bends."""
    X = np.array([[0.3, 0.2, -0.4, 0.9], [1.2, 0.0, 0.1, 0.5], [0.0, 0.4, 0.0, -0.7]])
    for base in (np.zeros(4), np.array([0.7, 0.0, 0.0, 0.0]), np.array([0.0, 0.0, 0.0, 1e-3])):
        velocities = log_map(base, X, ARM)
        assert (np.abs(velocities[..., 0]) < (2e-3 if base[3] else 1e-9)).all()  # no bone grows
        expected = pose_distances(base[None], X, skeleton=ARM, metric="geodesic")[0]
        np.testing.assert_allclose(lengths(velocities, ARM), expected, rtol=1e-2)
        assert_same_joints(exp_map(base, velocities, ARM), X, ARM, atol=1e-5)


# --- weights, conventions of angles ----------------------------------------------------------------------------------


def test_weights_scale_lengths_and_not_velocities():
    chain = Skeleton.chain(3)
    base, *X = poses_near(chain)
    heavy = chain.with_weights([4.0, 4.0, 4.0])
    velocities = log_map(base, X, heavy)
    np.testing.assert_allclose(velocities, log_map(base, X, chain), atol=1e-6)
    expected = pose_distances(base[None], X, skeleton=heavy, metric="geodesic")[0]
    np.testing.assert_allclose(lengths(velocities, heavy), expected, rtol=5e-3)
    np.testing.assert_allclose(exp_map(base, velocities, heavy), X, atol=1e-5)


# --- conduct ---------------------------------------------------------------------------------------------------------
