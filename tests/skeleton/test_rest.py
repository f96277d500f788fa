"""Rest poses: skeletons whose bones point elsewhere at angle zero."""

import numpy as np
import pytest
from conftest import MIXED, random_tree
from reference import forward_kinematics
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton, pose_distances
from skpose.datasets import MotionDataset, make_gait
from skpose.kinematics import retarget

THREE = ["rotvec", "ZXY", "xyz"]


def person(dofs="ZXY", frame="parent", arm=(1, 0, 0)):
    """A trunk with a head, two legs and one arm, which points in a given direction."""
    arm = np.array(arm) / np.linalg.norm(arm)
    bones = [
        Bone("spine", None, (0, 0.2, 0), dofs),
        Bone("shoulder", "spine", (0.2, 0.3, 0), dofs),
        Bone("elbow", "shoulder", 0.3 * arm, dofs),
        Bone("wrist", "elbow", 0.25 * arm, dofs),
        Bone("tip", "wrist", 0.1 * arm),
        Bone("head", "spine", (0, 0.5, 0.02), dofs),
        Bone("left_hip", None, (0.1, -0.05, 0), dofs),
        Bone("right_hip", None, (-0.1, -0.05, 0), dofs),
        Bone("left_knee", "left_hip", (0, -0.4, 0), dofs),
        Bone("right_knee", "right_hip", (0, -0.4, 0), dofs),
    ]
    return Skeleton(bones, frame)


T_POSE, A_POSE = person(), person(arm=(1, -1.3, 0))


def world(motion):
    """Positions of the joints relative to the root, in the axes of the world."""
    R = Rotation.from_euler(motion.root_axes, motion.root_angles)
    positions = forward_kinematics(motion.angles, motion.skeleton)
    order = [motion.skeleton.joint_names.index(name) for name in sorted(motion.skeleton.joint_names)]
    return np.stack([R.apply(positions[:, j]) for j in order], axis=1)


def random_motion(skeleton, seed=0, n=7):
    rng = np.random.default_rng(seed)
    angles, root = rng.uniform(-3, 3, (n, skeleton.n_dofs)), rng.uniform(-3, 3, (n, 3))
    return Motion(skeleton, angles, 30, root_angles=root, root_axes="ZXY", root_positions=rng.normal(size=(n, 3)))


def test_a_t_pose_and_an_a_pose_are_not_mixed():
    """All zeros on both are different poses; the distance after conversion is that of the positions in the world."""
    t, a = (Motion(skeleton, np.zeros((2, skeleton.n_dofs)), 30) for skeleton in (T_POSE, A_POSE))
    wrong = r"bone 'elbow' points in directions that are 52° apart at angle zero"
    with pytest.raises(ValueError, match=rf"skeletons\[0\] and skeletons\[1\] have different rest poses: {wrong}"):
        Skeleton.mean([T_POSE, A_POSE])
    with pytest.raises(ValueError, match=rf'the given one have .*{wrong}.*method="orientations" keeps'):
        retarget(a, T_POSE)
    dataset = MotionDataset([t, t, a], *[["0", "1", "2"]] * 3)
    with pytest.raises(ValueError, match=rf"motions\[0\] and motions\[2\] have .*{wrong}.*dataset\.retarget\("):
        dataset.poses()
    with pytest.raises(ValueError, match=rf"motions\[2\]: the motion's skeleton and the given one .*{wrong}"):
        dataset.poses(skeleton=T_POSE)

    X, _ = dataset.retarget(T_POSE, method="orientations").poses()
    gap = forward_kinematics(np.zeros(T_POSE.n_dofs), T_POSE) - forward_kinematics(np.zeros(A_POSE.n_dofs), A_POSE)
    distance = pose_distances(X, skeleton=T_POSE, metric="position")[0, 4]
    np.testing.assert_allclose(distance, np.linalg.norm(gap), atol=1e-9)
    assert distance > 0.5
    X, _ = dataset.retarget(T_POSE, method="unchecked").poses()
    np.testing.assert_array_equal(X, 0.0)


@pytest.mark.parametrize("frame", ["own", "parent"])
@pytest.mark.parametrize("dofs", THREE)
@pytest.mark.parametrize("lean", [0.4, 1.3, 50.0])
def test_directions_of_the_world_stay(frame, dofs, lean):
    one, other = person(dofs, frame), person(dofs, frame, arm=(1, -lean, 0.2))
    motion = random_motion(one)
    there = retarget(motion, other, method="orientations")
    assert there.skeleton is other
    np.testing.assert_allclose(world(there), world(motion), atol=1e-9)
    np.testing.assert_array_equal(there.root_positions, motion.root_positions)
    np.testing.assert_array_equal(there.root_angles, motion.root_angles)
    back = retarget(there, one, method="orientations")
    np.testing.assert_allclose(world(back), world(motion), atol=1e-9)


@pytest.mark.parametrize("frame", ["own", "parent"])
def test_lengths_and_the_order_of_the_bones_may_differ(frame):
    one, other = person("ZXY", frame), person("ZXY", frame, arm=(1, -1.3, 0))
    taller = Skeleton([b._replace(offset=1.5 * np.array(b.offset)) for b in other.bones[::-1]], frame)
    motion = random_motion(one)
    there = retarget(motion, taller, method="orientations")
    assert taller.joint_names != one.joint_names
    np.testing.assert_allclose(world(there), 1.5 * world(motion), atol=1e-9)


@pytest.mark.parametrize("frame", ["own", "parent"])
@pytest.mark.parametrize("seed", range(4))
def test_rest_rotations_of_any_kind(frame, seed):
    """Other axes of every joint, and the whole skeleton rotated, as z up for y up: positions stay."""
    rng = np.random.default_rng(seed)
    one = random_tree(seed, kinds=["rotvec", "ZXY", "yxz", ""], offset_frame=frame)
    # Every joint's axes are rotated by Q, all of the skeleton by W: H' = W·H·Q.
    W = Rotation.random(random_state=rng)
    Q = {name: Rotation.random(random_state=rng) for name in one.joint_names} | {None: W.inv()}
    bones = []
    for bone, rest in zip(one.bones, one.rest_rotations, strict=True):
        carrier = bone.name if frame == "own" else bone.parent
        offset = Q[carrier].inv().apply(bone.offset)
        rest = (Q[bone.parent].inv() * Rotation.from_matrix(rest.copy()) * Q[bone.name]).as_matrix()
        bones.append(bone._replace(offset=offset, rest_rotation=rest))
    other = Skeleton(bones, frame)
    motion = random_motion(one, seed)
    there = retarget(motion, other, method="orientations")
    np.testing.assert_allclose(world(there), world(motion), atol=1e-9)
    zero = forward_kinematics(np.zeros(one.n_dofs), one) @ W.as_matrix().T
    np.testing.assert_allclose(forward_kinematics(np.zeros(one.n_dofs), other), zero, atol=1e-12)


@pytest.mark.parametrize("frame", ["own", "parent"])
def test_bones_that_move_together_are_fitted(frame):
    """The two hips of a wider pelvis cannot both keep their direction; the spine, rigid too, has its share."""
    one = person("ZXY", frame)
    bones = [b._replace(offset=(b.offset[0], -0.2, 0.01)) if "hip" in b.name else b for b in one.bones]
    if frame == "own":  # in the other frame they move with the root as they are
        one, bones = ([b._replace(dofs="") if b.parent is None else b for b in each] for each in (one.bones, bones))
        one = Skeleton(one, frame)
    other = Skeleton(bones, frame)
    motion = random_motion(one)
    there = retarget(motion, other, method="orientations")
    a, b = (np.array([s.offsets[j] for j, x in enumerate(s.bones) if x.parent is None]) for s in (other, one))
    a, b = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (a, b))
    fit, _ = Rotation.align_vectors(b, a)  # takes the target's directions to the source's
    assert np.degrees(fit.magnitude()) > 0.5
    roots = [Rotation.from_euler(m.root_axes, m.root_angles) for m in (there, motion)]
    np.testing.assert_allclose((roots[1].inv() * roots[0]).as_matrix(), [fit.as_matrix()] * len(motion), atol=1e-9)
    single = [sorted(one.joint_names).index(name) for name in ("elbow", "wrist", "tip")]
    parent = [sorted(one.joint_names).index(name) for name in ("shoulder", "elbow", "wrist")]
    bones = [world(m)[:, single] - world(m)[:, parent] for m in (there, motion)]
    np.testing.assert_allclose(*bones, atol=1e-9)


@pytest.mark.parametrize("frame", ["own", "parent"])
def test_equal_rest_poses_keep_their_numbers(frame):
    skeleton = random_tree(3, kinds=MIXED, offset_frame=frame)
    motion = random_motion(skeleton)
    there = retarget(motion, skeleton, method="orientations")
    np.testing.assert_allclose(there.angles, motion.angles, atol=1e-8)
    np.testing.assert_array_equal(there.root_angles, motion.root_angles)
    assert len(retarget(motion.resample(1000), skeleton, method="orientations")) > 100
    empty = Motion(T_POSE, np.zeros((0, T_POSE.n_dofs)), 30)
    assert len(retarget(empty, A_POSE, method="orientations")) == 0


def test_hinges_convert_where_they_can():
    """An elbow that is a hinge about the arm's own axis may be bent at angle zero; about another axis it is refused."""

    def arm(forearm, upper=(0.3, 0, 0), dofs="y"):
        return Skeleton([Bone("elbow", None, upper, "xyz"), Bone("hand", "elbow", forearm, dofs)])

    straight, bent = arm((0.2, 0, 0)), arm(0.2 * np.array([np.cos(1), 0, np.sin(1)]))
    motion = Motion(straight, np.random.default_rng(0).uniform(-3, 3, (9, 4)), 30)
    there = retarget(motion, bent, method="orientations")
    np.testing.assert_allclose(world(there), world(motion), atol=1e-9)
    np.testing.assert_allclose(np.exp(1j * there.angles[:, 3]), np.exp(1j * (motion.angles[:, 3] + 1)), atol=1e-9)
    aside = arm(0.2 * np.array([np.cos(1), np.sin(1), 0]))
    with pytest.raises(ValueError, match="'hand' with dofs 'y'"):
        retarget(motion, aside, method="orientations")
    two = [arm((0.2, 0, 0), dofs="yz"), arm((0, 0.2, 0), dofs="yz")]
    motion = Motion(two[0], np.random.default_rng(0).uniform(-3, 3, (99, 5)), 30)
    with pytest.raises(ValueError, match="'hand' with dofs 'yz'"):
        retarget(motion, two[1], method="orientations")
    for dofs in ("yz", "ZX", "xz", "YX", "z"):  # a skeleton that is rotated as a whole, as two bones of its root show
        one = Skeleton([*arm((0.2, 0.1, 0), dofs=dofs).bones, Bone("a", None, (0, 1, 0)), Bone("b", None, (0, 0, 1))])
        turn = Rotation.from_rotvec([0.3, -1, 0.6]).as_matrix()
        other = Skeleton([b._replace(rest_rotation=None if b.parent else turn) for b in one.bones])
        motion = Motion(one, np.random.default_rng(1).uniform(-6, 6, (99, one.n_dofs)), 30)
        np.testing.assert_allclose(world(retarget(motion, other, method="orientations")), world(motion), atol=1e-9)


def test_rigid_bones_that_no_joint_can_move_are_refused():
    def fork(angle):
        tip = 0.2 * np.array([np.cos(angle), np.sin(angle), 0])
        return Skeleton([Bone("arm", None, (0.2, 0, 0), "xyz"), Bone("thumb", "arm", tip)])

    motion = Motion(fork(0.1), np.zeros((1, 3)), 30)
    with pytest.raises(ValueError, match=r"bone 'arm' is 7\d° apart from its counterpart after the best fit"):
        retarget(motion, fork(1.8 + 0.9), method="orientations")


def test_rest_rotations_count_too():
    def joint(angle, dofs="x"):
        rest = Rotation.from_euler("x", angle, degrees=True).as_matrix()
        return Skeleton([Bone("a", None, (1, 0, 0), "z"), Bone("b", "a", (1, 0, 0), dofs, rest)])

    assert Skeleton.mean([joint(0), joint(44)]).n_joints == 2
    with pytest.raises(ValueError, match="joint 'b' has rest rotations that are 46° apart"):
        Skeleton.mean([joint(0), joint(46)])
    assert Skeleton.mean([joint(0, ""), joint(46, "")]).n_joints == 2  # its axes move nothing


def test_the_pair_that_differs_most_is_named():
    """Two may be too far apart although both are near the first."""

    def bone(angle):
        return Skeleton([Bone("a", None, (np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0), "z")])

    with pytest.raises(ValueError, match=r"skeletons\[1\] and skeletons\[3\] .* bone 'a' .* 80° apart"):
        Skeleton.mean([bone(0), bone(40), bone(-38), bone(-40)])
    Skeleton.mean([bone(0), bone(22), bone(-22)])
    short = Skeleton([*bone(0).bones, Bone("b", "a", (0.0005, 0, 0))])
    Skeleton.mean([short, Skeleton([*bone(0).bones, Bone("b", "a", (0, 0, 0.0005))])])  # too short for a direction


def test_generated_people_have_one_rest_pose():
    gait = make_gait(3, 1, random_state=0)
    X, _ = gait.poses(frame_rate=10)
    Y, _ = gait.retarget(gait.skeleton, method="orientations").poses(frame_rate=10)
    assert X.shape == Y.shape
    with pytest.raises(ValueError, match="method"):
        retarget(gait.motions[0], gait.skeleton, method=None)


@pytest.mark.parametrize("collection", ["cmu", "hdm05"])
def test_people_of_one_collection_have_one_rest_pose(collection, request):
    dataset = request.getfixturevalue(collection)
    assert dataset.skeleton.n_dofs == dataset.poses(frame_rate=1)[0].shape[1]


def test_error_for_a_target_that_is_no_skeleton():
    motion = Motion(Skeleton.chain(2), [[0, 0]], 30)
    with pytest.raises(TypeError, match=r"must be a skpose\.Skeleton, got Motion: pass its skeleton, motion\.skeleton"):
        retarget(motion, motion)
    with pytest.raises(TypeError, match=r"must be a skpose\.Skeleton, got NoneType$"):
        retarget(motion, None)


def test_the_remedy_for_different_orders_of_angles_works():
    motions = [Motion(Skeleton([Bone("a", None, (1, 0, 0), order)]), np.ones((2, 3)), 30) for order in ("ZXY", "xyz")]
    with pytest.raises(ValueError, match=r"they compare: to_rotvec\(\) of both, or rotations=\"rotvec\""):
        retarget(motions[0], motions[1].skeleton)
    assert len(retarget(motions[0].to_rotvec(), motions[1].to_rotvec().skeleton)) == 2
    hinge = Skeleton([Bone("a", None, (1, 0, 0), "z")])
    with pytest.raises(ValueError, match="in the other"):
        retarget(motions[0], hinge)
