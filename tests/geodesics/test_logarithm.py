import re
import warnings

import numpy as np
import pytest
import reference
from conftest import MIXED, SKELETONS, random_tree, weighted
from scipy.spatial.transform import Rotation
from sklearn.exceptions import ConvergenceWarning

from skpose import Bone, Motion, Skeleton, forward_kinematics, geodesic, pose_distances
from skpose import position_jacobian as jacobian_of
from skpose.datasets import make_gait
from skpose.geodesics import exp_map, log_map
from skpose.geodesics._tangent_space import TangentSpace
from skpose.metrics import Geodesic
from skpose.statistics import PoseTangentPCA

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


def miss(base, pose, skeleton, n_steps):
    """Return by how much exp(log) misses a pose, relative to the logarithm's length, and whether log warns of it."""
    metric = Geodesic(n_steps)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ConvergenceWarning)
        velocity = log_map(base, pose[None], skeleton, metric=metric)
        is_warned_of = bool(caught)
        found = exp_map(base, velocity, skeleton, metric=metric)
    off = pose_distances(found, pose[None], skeleton=skeleton, metric="position")[0, 0]
    return off / lengths(velocity, skeleton)[0], is_warned_of


def near_poses(skeleton, scale, n, seed=0):
    """Return a base and poses about it."""
    rng = np.random.default_rng(seed)
    base = rng.normal(scale=0.3, size=skeleton.n_dofs)
    return base, base + rng.normal(scale=scale, size=(n, skeleton.n_dofs))


@pytest.mark.parametrize("n_steps", [5, 40])
def test_more_steps_do_not_make_exp_of_log_worse(n_steps):
    """Each chord adds its error; with a bound on the gradient by angles, 40 steps missed by 1e-3 of the length."""
    skeleton = SKELETONS["humanoid"].to_rotvec()
    base, X = near_poses(skeleton, 0.3, 5)
    for pose in X:
        relative, is_warned_of = miss(base, pose, skeleton, n_steps)
        assert relative < 1e-6 or is_warned_of


@pytest.mark.slow
@pytest.mark.parametrize("n_steps", [10, 20, 40, 80])
@pytest.mark.parametrize(("scale", "in_ten"), [(0.05, 0), (0.3, 3), (1.0, 10)])
@pytest.mark.parametrize("kind", ["Euler angles", "ball joints"])
def test_what_exp_of_log_misses_is_said(kind, scale, in_ten, n_steps):
    skeleton = SKELETONS["humanoid"] if kind == "Euler angles" else SKELETONS["humanoid"].to_rotvec()
    base, X = near_poses(skeleton, scale, 10)
    found = [miss(base, pose, skeleton, n_steps) for pose in X]
    assert all(relative < 1e-3 or is_warned_of for relative, is_warned_of in found)
    assert scale == 1.0 or np.median([relative for relative, _ in found]) < 5e-7
    assert sum(is_warned_of for _, is_warned_of in found) <= in_ten


def test_exp_finds_a_next_pose_half_a_turn_away():
    """Near a straight limb the pose that the tangential part leads to is behind others that are locally nearest."""
    skeleton = SKELETONS["humanoid"].to_rotvec()
    base, X = near_poses(skeleton, 0.05, 15, seed=3)
    relative, is_warned_of = miss(base, X[9], skeleton, 10)
    assert relative < 1e-6
    assert not is_warned_of


@pytest.mark.parametrize("n_steps", [2, 10, 40])
def test_log_inverts_exp(n_steps):
    for skeleton in (Skeleton.chain(3), BALL, SKELETONS["humanoid"]):
        base, X = near_poses(skeleton, 0.1, 2, seed=1)
        velocities = 1.3 * log_map(base, X, skeleton, metric=Geodesic(n_steps))
        found = exp_map(base, velocities, skeleton, metric=Geodesic(n_steps))
        again = log_map(base, found, skeleton, metric=Geodesic(n_steps))
        off = lengths(again - velocities, skeleton) / lengths(velocities, skeleton)
        assert (off < 1e-6).all()


@pytest.mark.slow
def test_exp_inverts_log_on_any_tree_and_on_gait():
    for seed in range(3):
        skeleton = weighted(random_tree(seed, n=7, kinds=MIXED), seed)
        base, *X = poses_near(skeleton, n=3, scale=0.2, seed=seed)
        assert_same_joints(exp_map(base, log_map(base, X, skeleton), skeleton), np.array(X), skeleton, atol=1e-4)
    gait = make_gait(2, 1, random_state=0)
    X = gait.poses(frame_rate=3)[0]
    assert_same_joints(exp_map(X[0], log_map(X[0], X, gait.skeleton), gait.skeleton), X, gait.skeleton, atol=1e-4)


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


def test_what_bones_do_not_allow_is_left_out():
    up, along = [[[0.0, 1.0, 0.0]]], [[[3.0, 1.0, -2.0]]]  # the bone is along x, its hinge along z
    np.testing.assert_allclose(exp_map([0.0], along, ONE_BONE), exp_map([0.0], up, ONE_BONE), atol=1e-12)


def test_a_straight_limb_at_the_base():
    """The twist of a straight arm moves no joint, but turns the plane in which the elbow bends."""
    X = np.array([[0.3, 0.2, -0.4, 0.9], [1.2, 0.0, 0.1, 0.5], [0.0, 0.4, 0.0, -0.7]])
    for base in (np.zeros(4), np.array([0.7, 0.0, 0.0, 0.0]), np.array([0.0, 0.0, 0.0, 1e-3])):
        velocities = log_map(base, X, ARM)
        assert (np.abs(velocities[..., 0]) < (2e-3 if base[3] else 1e-9)).all()  # no bone grows
        expected = pose_distances(base[None], X, skeleton=ARM, metric="geodesic")[0]
        np.testing.assert_allclose(lengths(velocities, ARM), expected, rtol=1e-2)
        assert_same_joints(exp_map(base, velocities, ARM), X, ARM, atol=1e-5)


def test_straight_limbs_do_not_hide_each_other():
    arms = [Bone(f"{bone.name}_{side}", bone.parent and f"{bone.parent}_{side}", bone.offset, bone.dofs)
            for side in "lr" for bone in ARM.bones]  # fmt: skip
    both = Skeleton(arms)
    X = np.array([[0.3, 0.2, -0.4, 0.9, 0.1, -0.3, 0.6, -0.8]])
    velocities = log_map(np.zeros(8), X, both)
    one = np.concatenate([log_map(np.zeros(4), X[:, :4], ARM), log_map(np.zeros(4), X[:, 4:], ARM)], axis=1)
    np.testing.assert_allclose(velocities, one, atol=1e-3)  # of one geodesic of both, and of two
    assert_same_joints(exp_map(np.zeros(8), velocities, both), X, both, atol=1e-5)


@pytest.mark.parametrize("n_hinges", [2, 4])
def test_parallel_hinges_of_one_straight_limb(n_hinges):
    """They bend in one plane, which a twist turns: velocities of two planes span more than the joints can do."""
    limb = [Bone("b0", None, (0.0, -0.4, 0.0), "rotvec")]
    limb += [Bone(f"b{i + 1}", f"b{i}", (0.0, -0.3 / (i + 1), 0.0), "x") for i in range(n_hinges)]
    leg = Skeleton(limb)
    X = poses_near(leg, 6, 0.5)
    base = np.zeros(leg.n_dofs)
    assert_same_joints(exp_map(base, log_map(base, X, leg), leg), X, leg, atol=2e-3)


def test_a_stretched_limb_whose_elbow_has_no_weight():
    """A hand leaves the farthest point that it reaches along a straight line, though at first order it cannot."""
    arm = Skeleton.chain(2).with_weights([0.0, 1.0])
    X = np.array([[0.3, 0.9], [-0.4, 0.8]])
    chords = reference.forward_kinematics(X, arm)[:, 1] - [2.0, 0.0, 0.0]
    with pytest.warns(ConvergenceWarning, match="1 of the 2 logarithms do not lead back.*by up to 0.16 m"):
        velocities = log_map([0.0, 0.0], X, arm)
    np.testing.assert_allclose(velocities[:, 1], chords, atol=1e-3)
    with pytest.warns(ConvergenceWarning, match="1 of the 2 geodesics miss a step"):
        found = exp_map([0.0, 0.0], velocities, arm)
    off = pose_distances(found, X, skeleton=arm, metric="position").diagonal()
    np.testing.assert_allclose(off, [0.0, np.linalg.norm(chords[1])], atol=1e-6)  # no velocity of a joint leads inwards


@pytest.mark.slow
def test_real_walks_whose_knees_are_straight(cmu):
    for dataset in (cmu[cmu.actions == "walk"], cmu[cmu.actions == "walk"].to_rotvec()):
        X, skeleton = dataset.poses(frame_rate=12)[0], dataset.skeleton
        knees = [i for i, name in enumerate(skeleton.dof_names) if "tibia" in name]
        straight = np.flatnonzero((np.abs(X[:, knees]) < 1e-9).any(axis=1))
        assert len(straight) > 10
        for base in straight[:3]:
            ends = X[np.random.default_rng(base).choice(len(X), 2)]
            assert_same_joints(exp_map(X[base], log_map(X[base], ends, skeleton), skeleton), ends, skeleton, atol=1e-3)


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


def test_joints_without_weight_are_left_out():
    chain, short = Skeleton.chain(4).with_weights([1.0, 2.0, 0.0, 0.0]), Skeleton.chain(2).with_weights([1.0, 2.0])
    base, *X = poses_near(chain)
    velocities = log_map(base, X, chain)
    np.testing.assert_array_equal(velocities[:, 2:], 0.0)
    np.testing.assert_allclose(velocities[:, :2], log_map(base[:2], np.array(X)[:, :2], short), atol=1e-9)
    found = exp_map(base, velocities, chain)
    np.testing.assert_allclose(found[:, :2], np.array(X)[:, :2], atol=1e-5)
    np.testing.assert_array_equal(found[:, 2:], np.tile(base[2:], (5, 1)))


def test_a_carrying_joint_without_weight_has_no_velocity():
    chain = Skeleton.chain(2).with_weights([0.0, 1.0])
    base, *X = np.array([[0.3, 0.8], [0.5, 1.0], [0.1, 0.9]])
    velocities = log_map(base, X, chain)
    np.testing.assert_array_equal(velocities[:, 0], 0.0)
    assert_same_joints(exp_map(base, velocities, chain), np.array(X), chain)


def test_the_order_of_euler_angles_has_no_effect():
    balls = random_tree(2, n=4, kinds=("rotvec",))
    motion = Motion(balls, poses_near(balls, 4, 0.3), 10.0)
    velocities = []
    for order in ("xyz", "ZXY", "rotvec"):
        same = motion if order == "rotvec" else motion.to_euler(order)
        velocities.append(log_map(same.angles[0], same.angles[1:], same.skeleton))
        back = exp_map(same.angles[0], velocities[-1], same.skeleton)
        assert_same_joints(back, same.angles[1:], same.skeleton, atol=1e-5)
    np.testing.assert_allclose(velocities[0], velocities[2], atol=1e-6)
    np.testing.assert_allclose(velocities[1], velocities[2], atol=1e-6)


def test_whole_turns_have_no_effect():
    base, end = np.array([0.1, 0.2, -0.3, 0.4]), np.array([[0.4, 0.1, 0.2, 0.1]])
    turned = end.copy()
    turned[0, 3] += 2.0 * np.pi
    turned[0, :3] = Rotation.from_rotvec(end[0, :3]).as_rotvec() * (1.0 + 2.0 * np.pi / np.linalg.norm(end[0, :3]))
    np.testing.assert_allclose(log_map(base, turned, ARM), log_map(base, end, ARM), atol=1e-6)


# --- conduct ---------------------------------------------------------------------------------------------------------


def test_threads_change_no_bit():
    chain = Skeleton.chain(3)
    base, *X = poses_near(chain, 20)
    velocities = log_map(base, X, chain)
    np.testing.assert_array_equal(log_map(base, X, chain, n_jobs=2), velocities)
    np.testing.assert_array_equal(exp_map(base, velocities, chain, n_jobs=2), exp_map(base, velocities, chain))


def test_too_large_velocities_are_said_in_words():
    with pytest.warns(ConvergenceWarning, match="1 of the 2 geodesics miss a step.*for n_steps=2.*larger n_steps"):
        found = exp_map([0.0], [[[0.0, 9.0, 0.0]], [[0.0, 0.5, 0.0]]], ONE_BONE, metric=Geodesic(2))
    assert np.isfinite(found).all()
    exp_map([0.0], [[[0.0, 9.0, 0.0]]], ONE_BONE, metric=Geodesic(20))


def test_geodesics_that_did_not_converge_are_counted(monkeypatch):
    chain = Skeleton.chain(2)
    base, *X = poses_near(chain, 4)
    found = TangentSpace.logarithms
    monkeypatch.setattr(TangentSpace, "logarithms", lambda space, poses: found(space, poses)._replace(n_unconverged=2))
    with pytest.warns(ConvergenceWarning, match="2 of the 3 geodesics did not converge.*larger n_steps may help"):
        assert log_map(base, X, chain).shape == (3, 2, 3)
    monkeypatch.setattr(
        TangentSpace, "logarithms", lambda space, poses: found(space, poses)._replace(n_missed=3, farthest=0.0123)
    )
    with pytest.warns(ConvergenceWarning, match="3 of the 4 logarithms from the mean do not lead back.*up to 0.012 m"):
        PoseTangentPCA(chain, metric="geodesic").fit([base, *X])
    monkeypatch.setattr(TangentSpace, "logarithms", lambda space, poses: found(space, poses)._replace(n_unconverged=2))
    with pytest.warns(ConvergenceWarning, match="2 of the 4 geodesics from the mean did not converge.*larger n_steps"):
        PoseTangentPCA(chain, metric="geodesic").fit([base, *X])


def test_errors_are_in_the_users_words():
    with pytest.raises(ValueError, match="velocities must be an array of real numbers, got <U4"):
        exp_map([0.0], [[["fast"]]], ONE_BONE)
    with pytest.raises(ValueError, match="velocities must be finite numbers below"):
        exp_map([0.0], [[[0.0, 1e160, 0.0]]], ONE_BONE)
    chain = Skeleton.chain(2)
    for shape in ((2, 3), (1, 3, 3), (1, 6)):
        with pytest.raises(ValueError, match=re.escape("shape (n_poses, 2, 3), one velocity for each joint") + ".*got"):
            exp_map([0.0, 0.0], np.zeros(shape), chain)
    with pytest.raises(ValueError, match="velocities must be finite"):
        exp_map([0.0, 0.0], np.full((1, 2, 3), np.nan), chain)
    with pytest.raises(ValueError, match="base"):
        log_map([0.0], [[0.0, 0.0]], chain)
    with pytest.raises(ValueError, match="poses"):
        log_map([0.0, 0.0], [[0.0, 0.0, 0.0]], chain)
    for function, argument in ((log_map, [[0.0, 0.0]]), (exp_map, np.zeros((1, 2, 3)))):
        with pytest.raises(ValueError, match="n_steps must be 2 or more, got 1"):
            function([0.0, 0.0], argument, chain, metric=Geodesic(1))
        with pytest.warns(UserWarning, match="degrees"):
            function([90.0, 45.0], argument, chain)


def test_no_poses_and_no_velocities():
    chain = Skeleton.chain(2)
    assert exp_map([0.0, 0.0], np.zeros((0, 2, 3)), chain).shape == (0, 2)


def test_positions_of_the_example_are_those_of_forward_kinematics():
    velocity = log_map([0.0, 0.0], [[0.2, 0.1]], Skeleton.chain(2))
    step = forward_kinematics([[0.002, 0.001]], Skeleton.chain(2)) - forward_kinematics([[0.0, 0.0]], Skeleton.chain(2))
    np.testing.assert_allclose(velocity, 100.0 * step, atol=0.02)


@pytest.mark.parametrize("angle", [0.5, 2.0, 2.5, 2.9])
def test_two_chords_of_a_circle_are_enough(angle):
    """The first chord has its length, though its tangential part is near the largest that there is."""
    arm = Skeleton.chain(1)
    velocity = log_map([0.4], [[0.4 + angle]], arm, metric=Geodesic(2))
    np.testing.assert_allclose(exp_map([0.4], velocity, arm, metric=Geodesic(2)), [[0.4 + angle]], atol=1e-6)


def test_velocities_that_no_joint_can_have_lead_nowhere():
    arm = Skeleton.chain(1)
    np.testing.assert_array_equal(exp_map([0.0], [[[1.0, 0.0, 0.0]]], arm), [[0.0]])
