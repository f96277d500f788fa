"""Inverse kinematics at exact positions: the joints come back, for every skeleton, alone and in sequences."""

import numpy as np
import pytest
import reference
from conftest import SKELETONS as ALL, in_space
from placed import FIGURE, at_random, of

from skpose import Bone, Motion, Skeleton, inverse_kinematics
from skpose.datasets import make_gait
from skpose.keypoints import Keypoints

SKELETONS = {
    "asf": ALL["asf"],
    "tree, offsets in the parent's frame": ALL["tree, offsets in the parent's frame"],
    "figure": FIGURE,
}
ODD = {
    "one bone": Skeleton([Bone("a", None, (0, 0.3, 0), "x")]),
    "one ball": Skeleton([Bone("a", None, (0, 0.3, 0), "rotvec")]),
    "length zero": Skeleton(
        [Bone("a", None, (0, 0, 0)), Bone("b", "a", (0, 1, 0), "zy"), Bone("c", "b", (0, 0, 0), "rotvec")]
    ),
    "nothing but length zero": Skeleton([Bone("a", None, (0, 0, 0), "x"), Bone("b", "a", (0, 0, 0), "rotvec")]),
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
def test_exact_positions_of_odd_skeletons_are_reached(name):
    skeleton = ODD[name]
    positions = at_random(skeleton, 5)[1]
    fitted = inverse_kinematics(positions, skeleton)
    np.testing.assert_allclose(of(fitted), positions, rtol=0, atol=1e-6)
    assert fitted.converged.all()


def test_motions_come_back(gait):
    fitted = inverse_kinematics(in_space(gait), gait.skeleton)
    np.testing.assert_allclose(of(fitted), in_space(gait), rtol=0, atol=1e-6)
    steps = np.abs(np.diff(fitted.poses, axis=0)).max()
    assert steps < 2 * np.abs(np.diff(gait.angles, axis=0)).max()
    assert fitted.n_iter.mean() < 5


def test_the_initial_pose_is_kept_where_it_fits():
    poses, _ = at_random(FIGURE, 6)
    positions = reference.forward_kinematics(poses, FIGURE)
    fitted = inverse_kinematics(positions, FIGURE, initial=poses)
    np.testing.assert_allclose(fitted.poses, poses, atol=1e-6)
    np.testing.assert_allclose(fitted.root_rotations, 0, atol=1e-6)
    first = inverse_kinematics(positions[:1], FIGURE, initial=poses[0])
    np.testing.assert_array_equal(first.poses, fitted.poses[:1])


def test_sequences_do_not_know_of_each_other():
    positions = at_random(FIGURE, 12)[1]
    positions[4:6, 3:] = np.nan
    whole = inverse_kinematics(positions, FIGURE, lengths=[4, 1, 7])
    for part in (slice(0, 4), slice(4, 5), slice(5, 12)):
        alone = inverse_kinematics(positions[part], FIGURE)
        for name in ("poses", "residuals", "converged", "root_positions", "root_rotations", "n_iter"):
            np.testing.assert_array_equal(getattr(whole, name)[part], getattr(alone, name))


def test_keypoints_are_matched_by_name(gait):
    positions = at_random(FIGURE, 4)[1]
    points = np.concatenate([np.ones((4, 1, 3)), positions], axis=1)
    confidences = np.random.default_rng(1).uniform(0, 1, points.shape[:2])
    keypoints = Keypoints(points, ["tail", *FIGURE.joint_names], 25.0, confidences, up="z")
    fitted = inverse_kinematics(keypoints, FIGURE, weights=np.arange(1.0, 9.0))
    expected = inverse_kinematics(positions, FIGURE, weights=confidences[:, 1:] * np.arange(1.0, 9.0))
    np.testing.assert_array_equal(fitted.poses, expected.poses)
    motion = fitted.to_motion()
    assert (motion.up, motion.frame_rate) == ("z", 25.0)
    with pytest.raises(ValueError, match="frame_rate"):
        expected.to_motion()
    with pytest.warns(UserWarning, match="stands along z"):
        inverse_kinematics(in_space(gait)[..., [2, 0, 1]], gait.skeleton).to_motion(60.0)


@pytest.mark.slow
@pytest.mark.parametrize("collection", ["cmu", "hdm05"])
def test_recordings_come_back(request, collection):
    for motion in request.getfixturevalue(collection).motions[::40]:
        fitted = inverse_kinematics(in_space(motion), motion.skeleton)
        np.testing.assert_allclose(fitted.residuals, 0, atol=1e-6)


@pytest.mark.parametrize(
    ("positions", "options", "message"),
    [
        (np.zeros((3, 8, 2)), {}, "positions"),
        (np.zeros((3, 5, 3)), {}, "positions"),
        (np.full((3, 8, 3), np.inf), {}, "infinite"),
        (Keypoints(np.zeros((3, 1, 3)), ["nose"], 30.0), {}, "keypoint"),
        (np.ones((3, 8, 3)), {"weights": -np.ones(8)}, "weights"),
        (np.ones((3, 8, 3)), {"initial": np.zeros(3)}, "initial"),
        (np.ones((3, 8, 3)), {"lengths": [1, 1]}, "lengths"),
        (np.ones((3, 8, 3)), {"regularization": -1.0}, "regularization"),
    ],
)
def test_wrong_arguments(positions, options, message):
    with pytest.raises(ValueError, match=message):
        inverse_kinematics(positions, FIGURE, **options)


def test_limits_need_a_skeleton_with_limits():
    with pytest.raises(ValueError, match="joint_limits"):
        inverse_kinematics(np.zeros((1, 2, 3)), Skeleton.chain(2), joint_limits="enforce")


@pytest.mark.parametrize("scale", [1e3, 1e-3])
@pytest.mark.filterwarnings("ignore:.*did not converge")
def test_other_units_are_warned_of(scale):
    with pytest.warns(UserWarning, match="not in metres"):
        inverse_kinematics(scale * at_random(FIGURE, 3)[1], FIGURE)
