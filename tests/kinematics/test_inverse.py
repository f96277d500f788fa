"""Inverse kinematics at exact positions: the joints come back, for every skeleton, alone and in sequences."""

import numpy as np
import pytest
import reference
from conftest import SKELETONS as ALL
from conftest import in_space
from placed import FIGURE, at_random, of, placed

from skpose import Bone, Motion, Skeleton, forward_kinematics, inverse_kinematics
from skpose.datasets import humanoid, make_gait
from skpose.keypoints import Keypoints
from skpose.kinematics import FittedPoses

SKELETONS = {
    "chain": ALL["chain"],
    "asf": ALL["asf"],
    "bvh": ALL["bvh"],
    "ball joints": ALL["ball joints"],
    "mixed joints": ALL["mixed joints"],
    "weights": ALL["weights"],
    "tree, offsets in the parent's frame": ALL["tree, offsets in the parent's frame"],
    "figure": FIGURE,
}
ODD = {
    "one bone": Skeleton([Bone("a", None, (0, 0.3, 0), "x")]),
    "one ball": Skeleton([Bone("a", None, (0, 0.3, 0), "rotvec")]),
    "hinges of one axis": Skeleton.chain(5),
    "length zero": Skeleton(
        [Bone("a", None, (0, 0, 0)), Bone("b", "a", (0, 1, 0), "zy"), Bone("c", "b", (0, 0, 0), "rotvec")]
    ),
    "nothing but length zero": Skeleton([Bone("a", None, (0, 0, 0), "x"), Bone("b", "a", (0, 0, 0), "rotvec")]),
    "weight zero": Skeleton([Bone("a", None, (0, 1, 0), "zx", weight=0.0), Bone("b", "a", (0, 1, 0), "x", weight=0.0)]),
    "nearly all rigid": Skeleton(
        [
            Bone("a", None, (0, 1, 0)),
            Bone("b", "a", (1, 0, 0)),
            Bone("c", "a", (0, 0, 1)),
            Bone("d", "a", (0, 1, 0), "x"),
        ]
    ),
    "offsets along the axes": Skeleton(
        [Bone("a", None, (0, 1, 0), "y"), Bone("b", "a", (0, 0, 1), "z"), Bone("c", "b", (1, 0, 0), "x")]
    ),
    "a root of its own": Motion(FIGURE, np.zeros((1, FIGURE.n_dofs)), 30.0).with_root().skeleton,
    "a joint named root": Skeleton([Bone("root", None, (0, 1, 0), "rotvec"), Bone("root_", "root", (1, 0, 0), "z")]),
}


@pytest.fixture(scope="module")
def gait():
    return make_gait(1, 1, duration=2.0, random_state=0).motions[0]


def each_alone(positions, skeleton, **options):
    return inverse_kinematics(positions, skeleton, initial=np.zeros((len(positions), skeleton.n_dofs)), **options)


@pytest.mark.parametrize("name", SKELETONS)
@pytest.mark.parametrize("fit", [inverse_kinematics, each_alone])
def test_exact_positions_are_reached(name, fit):
    skeleton = SKELETONS[name]
    positions = at_random(skeleton, 10)[1]
    fitted = fit(positions, skeleton)
    np.testing.assert_allclose(of(fitted), positions, rtol=0, atol=1e-6)
    np.testing.assert_allclose(fitted.residuals, 0, atol=1e-6)
    assert fitted.converged.all()


@pytest.mark.parametrize("name", ODD)
@pytest.mark.parametrize("fit", [inverse_kinematics, each_alone])
def test_exact_positions_of_odd_skeletons_are_reached(name, fit):
    skeleton = ODD[name]
    positions = at_random(skeleton, 5)[1]
    fitted = fit(positions, skeleton)
    np.testing.assert_allclose(of(fitted), positions, rtol=0, atol=1e-6)
    assert fitted.converged.all()


@pytest.mark.parametrize("name", ["chain", "asf", "mixed joints"])
def test_most_positions_of_wild_poses_are_reached(name):
    positions = at_random(SKELETONS[name], 40, size=2.5)[1]
    assert np.mean(each_alone(positions, SKELETONS[name]).residuals.max(axis=1) < 1e-6) > 0.8


def test_residuals_are_the_distances():
    positions = at_random(FIGURE, 5)[1] + np.random.default_rng(0).normal(0, 0.1, (5, FIGURE.n_joints, 3))
    positions[2, 3] = np.nan
    fitted = inverse_kinematics(positions, FIGURE)
    np.testing.assert_allclose(fitted.residuals, np.linalg.norm(of(fitted) - positions, axis=2), atol=1e-12)


def test_motions_come_back(gait):
    fitted = inverse_kinematics(in_space(gait), gait.skeleton)
    np.testing.assert_allclose(of(fitted), in_space(gait), rtol=0, atol=1e-6)
    steps = np.abs(np.diff(fitted.poses, axis=0)).max()
    assert steps < 2 * np.abs(np.diff(gait.angles, axis=0)).max()
    assert fitted.n_iter.mean() < 5


def test_a_sequence_and_its_frames_alone_have_the_same_positions(gait):
    positions = in_space(gait)[::20]
    np.testing.assert_allclose(of(each_alone(positions, gait.skeleton)), positions, rtol=0, atol=1e-6)


@pytest.mark.parametrize("up", ["y", "z"])
def test_the_motion_has_the_positions(gait, up):
    motion = inverse_kinematics(in_space(gait), gait.skeleton).to_motion(60.0, up)
    np.testing.assert_allclose(in_space(motion), in_space(gait), rtol=0, atol=1e-6)
    assert (motion.up, motion.frame_rate, motion.skeleton) == (up, 60.0, gait.skeleton)


@pytest.mark.parametrize("up", ["y", "z"])
def test_the_motion_of_keypoints_has_their_frame_rate_and_axis(gait, up):
    """Up is not y by itself: tilts would be those of another world."""
    positions = in_space(gait) if up == "y" else in_space(gait)[..., [2, 0, 1]]
    seen = Keypoints(positions, gait.skeleton.joint_names, 25.0, up=up)
    fitted = inverse_kinematics(seen, gait.skeleton)
    assert (fitted.up, fitted.frame_rate) == (up, 25.0)
    motion = fitted.to_motion()
    assert (motion.up, motion.frame_rate) == (up, 25.0)
    assert fitted.to_motion(50.0, "x").up == "x"


def test_the_motion_of_an_array_needs_a_frame_rate_and_warns_of_people_who_lie(gait):
    fitted = inverse_kinematics(in_space(gait), gait.skeleton)
    with pytest.raises(ValueError, match="the frame rate is not known, as the positions came as an array"):
        fitted.to_motion()
    assert fitted.to_motion(60.0).up == "y"
    with_z_up = inverse_kinematics(in_space(gait)[..., [2, 0, 1]], gait.skeleton)
    with pytest.warns(UserWarning, match="stands along z: pass up='z', or up='y' if the person lies"):
        with_z_up.to_motion(60.0)
    assert with_z_up.to_motion(60.0, "z").up == "z"


def test_no_frames_are_no_poses():
    fitted = inverse_kinematics(np.zeros((0, FIGURE.n_joints, 3)), FIGURE)
    assert fitted.poses.shape == (0, FIGURE.n_dofs)
    assert fitted.residuals.shape == (0, FIGURE.n_joints)
    assert len(fitted.to_motion(30.0)) == 0
    assert repr(fitted) == "FittedPoses(0 frames, 0 of 8 joints seen, nan mm off in the mean, all converged)"


def test_the_initial_pose_is_kept_where_it_fits():
    poses, _ = at_random(FIGURE, 6)
    positions = reference.forward_kinematics(poses, FIGURE)
    fitted = inverse_kinematics(positions, FIGURE, initial=poses)
    np.testing.assert_allclose(fitted.poses, poses, atol=1e-6)
    np.testing.assert_allclose(fitted.root_rotations, 0, atol=1e-6)
    first = inverse_kinematics(positions[:1], FIGURE, initial=poses[0])
    np.testing.assert_array_equal(first.poses, fitted.poses[:1])


def test_single_precision_and_lists_are_read():
    positions = at_random(FIGURE, 3)[1].astype(np.float32)
    exact = inverse_kinematics(positions.astype(np.float64), FIGURE)
    for given in (positions, positions.tolist(), list(positions), np.asfortranarray(positions)):
        np.testing.assert_array_equal(inverse_kinematics(given, FIGURE).poses, exact.poses)


def test_arguments_are_left_as_they_are():
    positions = at_random(FIGURE, 3)[1]
    positions[0, 0, 0] = np.nan
    arguments = [positions, np.ones(FIGURE.n_joints), np.full(FIGURE.n_dofs, 7.0)]
    copies = [a.copy() for a in arguments]
    inverse_kinematics(arguments[0], FIGURE, weights=arguments[1], initial=arguments[2])
    for argument, copy in zip(arguments, copies, strict=True):
        np.testing.assert_array_equal(argument, copy)


def test_far_from_the_origin_the_pose_is_the_same():
    positions = at_random(FIGURE, 4)[1]
    far = inverse_kinematics(positions + 1e6, FIGURE)
    assert far.converged.all()
    np.testing.assert_allclose(far.residuals, 0, atol=1e-6)


def test_sequences_do_not_know_of_each_other():
    positions = at_random(FIGURE, 12)[1]
    positions[4:6, 3:] = np.nan
    whole = inverse_kinematics(positions, FIGURE, lengths=[4, 1, 7])
    for part in (slice(0, 4), slice(4, 5), slice(5, 12)):
        alone = inverse_kinematics(positions[part], FIGURE)
        for name in ("poses", "residuals", "converged", "root_positions", "root_rotations", "n_iter"):
            np.testing.assert_array_equal(getattr(whole, name)[part], getattr(alone, name))


def test_frames_alone_do_not_know_of_each_other():
    positions = at_random(FIGURE, 6)[1]
    whole = each_alone(positions, FIGURE)
    np.testing.assert_array_equal(each_alone(positions[::-1], FIGURE).poses[::-1], whole.poses)


def test_keypoints_are_matched_by_name():
    positions = at_random(FIGURE, 4)[1]
    names = [*FIGURE.joint_names, "tail"]
    order = np.random.default_rng(0).permutation(len(names))
    points = np.concatenate([positions, np.ones((4, 1, 3))], axis=1)
    confidences = np.random.default_rng(1).uniform(0, 1, points.shape[:2])
    keypoints = Keypoints(points[:, order], [names[i] for i in order], 30.0, confidences[:, order])
    noisy = positions + np.random.default_rng(2).normal(0, 0.05, positions.shape)
    fitted = inverse_kinematics(keypoints, FIGURE, weights=np.arange(1.0, 9.0))
    expected = inverse_kinematics(positions, FIGURE, weights=confidences[:, :-1] * np.arange(1.0, 9.0))
    np.testing.assert_array_equal(fitted.poses, expected.poses)
    less = inverse_kinematics(keypoints.select(["elbow", "wrist", "foot"]), FIGURE)
    assert (~np.isnan(less.residuals)).sum(axis=0).tolist() == [0, 0, 4, 4, 0, 0, 4, 0]
    assert not np.array_equal(
        inverse_kinematics(noisy, FIGURE, weights=confidences[:, :-1]).poses, inverse_kinematics(noisy, FIGURE).poses
    )


def test_the_weights_of_the_skeleton_have_no_effect():
    positions = at_random(FIGURE, 3)[1] + np.random.default_rng(0).normal(0, 0.1, (3, FIGURE.n_joints, 3))
    weighted = FIGURE.with_weights([0.0, 2.0, 3.0, 1.0, 0.0, 0.5, 1.0, 1.0])
    np.testing.assert_array_equal(
        inverse_kinematics(positions, weighted).poses, inverse_kinematics(positions, FIGURE).poses
    )


def test_what_is_shown_counts_frames_and_joints():
    positions = at_random(FIGURE, 3)[1]
    positions[:, 2] = np.nan
    fitted = inverse_kinematics(positions, FIGURE)
    assert isinstance(fitted, FittedPoses)
    assert repr(fitted) == "FittedPoses(3 frames, 7 of 8 joints seen, 0 mm off in the mean, all converged)"


def test_forward_kinematics_of_the_poses_is_as_far_apart():
    """Distances between joints need no root."""
    positions = at_random(humanoid(), 2)[1]
    here = forward_kinematics(inverse_kinematics(positions, humanoid()).poses, humanoid())
    apart, expected = (np.linalg.norm(p[:, :, None] - p[:, None], axis=3) for p in (here, positions))
    np.testing.assert_allclose(apart, expected, atol=1e-6)


@pytest.mark.slow
def test_recordings_of_cmu_come_back(cmu):
    for motion in cmu.motions[::12]:
        fitted = inverse_kinematics(in_space(motion), motion.skeleton)
        np.testing.assert_allclose(fitted.residuals, 0, atol=1e-6)
        assert fitted.converged.all()


@pytest.mark.slow
def test_recordings_of_hdm05_come_back(hdm05):
    for motion in hdm05.motions[::4]:
        fitted = inverse_kinematics(in_space(motion), motion.skeleton)
        np.testing.assert_allclose(fitted.residuals, 0, atol=1e-6)
        assert fitted.converged.all()


@pytest.mark.slow
def test_single_frames_of_hdm05_come_near(hdm05):
    """A few stay in a local minimum."""
    for motion in hdm05.motions[::4]:
        positions = in_space(motion)[::20]
        assert each_alone(positions, motion.skeleton).residuals.max() < 1e-3


def test_the_root_moves_as_given():
    poses, rotations, origins = at_random(FIGURE, 5)[0], np.full((5, 3), 0.5), np.arange(15.0).reshape(5, 3)
    fitted = inverse_kinematics(placed(FIGURE, poses, rotations, origins), FIGURE, initial=poses)
    np.testing.assert_allclose(fitted.root_rotations, rotations, atol=1e-4)
    np.testing.assert_allclose(fitted.root_positions, origins, atol=1e-4)
