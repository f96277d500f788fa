"""Numbers in another unit than is expected are noticed: degrees for radians, files in other units than metres."""

import io
import warnings

import numpy as np
import pytest
from conftest import DATA

from skpose import (
    MedoidShift,
    Motion,
    PoseDistanceTransformer,
    PoseKNeighborsTransformer,
    Skeleton,
    SpatialMDS,
    forward_kinematics,
    geodesic,
    metric_tensor,
    pose_distances,
    pose_distances_chunked,
    position_jacobian,
    rotations_from_poses,
)
from skpose.datasets import MotionDataset, humanoid, make_gait
from skpose.geodesics import frechet_mean, geometric_median
from skpose.io import AsfFile, load_amc, load_asf, load_bvh, load_motion
from skpose.skeleton._rest import size_of

ARM = Skeleton.chain(3)
RADIANS = np.random.default_rng(0).uniform(-1.5, 1.5, (6, 3))
DEGREES = np.degrees(RADIANS)
SIGN = r"reach 8\d\.\d+, and go beyond 18\.8 in 3 of 3 columns, but angles are in rad"

CALLS = {
    "pose_distances": lambda X: pose_distances(X, skeleton=ARM),
    "pose_distances, two arrays": lambda X: pose_distances(X, X.copy(), skeleton=ARM),
    "pose_distances, angle": lambda X: pose_distances(X, skeleton=ARM, metric="angle"),
    "pose_distances_chunked": lambda X: list(pose_distances_chunked(X, skeleton=ARM, working_memory=1e-4)),
    "forward_kinematics": lambda X: forward_kinematics(X, ARM),
    "position_jacobian": lambda X: position_jacobian(X, ARM),
    "metric_tensor": lambda X: metric_tensor(X, ARM),
    "frechet_mean": lambda X: frechet_mean(X, ARM),
    "geometric_median": lambda X: geometric_median(X, ARM, metric="angle"),
    "geodesic": lambda X: geodesic(X[0], X[1], ARM),
    "rotations_from_poses": lambda X: rotations_from_poses(X, ARM, form="6d"),
    "Motion": lambda X: Motion(ARM, X, 10),
    "transformer": lambda X: PoseDistanceTransformer(ARM).fit_transform(X),
    "neighbors": lambda X: PoseKNeighborsTransformer(ARM, n_neighbors=2).fit(X),
    "mds": lambda X: SpatialMDS(skeleton=ARM).fit(X),
    "mds with landmarks": lambda X: SpatialMDS(skeleton=ARM, landmarks=3, random_state=0).fit_transform(X),
    "medoid shift": lambda X: MedoidShift(ARM, bandwidth=1.0).fit_predict(X),
}


def caught(call, *arguments):
    """Warnings of a call."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        call(*arguments)
    return found


@pytest.mark.parametrize("name", CALLS)
def test_degrees_are_noticed_once_in_a_call_at_the_users_line(name):
    (warning,) = caught(CALLS[name], DEGREES)
    assert warning.category is UserWarning
    assert warning.filename == __file__
    message = str(warning.message)
    assert "reach" in message
    assert "if they are in degrees, pass np.radians(" in message
    assert caught(CALLS[name], RADIANS) == []


def test_the_sign_is_named():
    with pytest.warns(UserWarning, match=f"^values of X {SIGN}, where 6.28 is a whole turn: .*pass np.radians"):
        pose_distances(DEGREES, skeleton=ARM)
    with pytest.warns(UserWarning, match=f"^values of Y {SIGN}"):
        pose_distances(RADIANS, DEGREES, skeleton=ARM)
    with pytest.warns(UserWarning, match=f"^values of angles {SIGN}"):
        Motion(ARM, DEGREES, 10)
    with pytest.warns(UserWarning, match="^values of end reach"):
        geodesic(RADIANS[0], DEGREES[1], ARM)


def test_later_poses_of_an_estimator_are_watched():
    transformer = PoseDistanceTransformer(ARM).fit(RADIANS)
    assert len(caught(transformer.transform, DEGREES)) == 1
    shift = MedoidShift(ARM, bandwidth=1.0).fit(RADIANS)
    assert len(caught(shift.predict, DEGREES)) == 1


def test_the_motions_that_are_made_of_a_motion_are_not_watched_again():
    """The user hears of it where the numbers come in: not again for each motion that the library makes of it."""
    with pytest.warns(UserWarning, match="^values of angles reach"):
        motion = Motion(ARM, DEGREES, 10)
    for call in (motion.resample, MotionDataset([motion, motion[1:]]).poses):
        assert caught(call, 5.0) == []


def test_without_a_skeleton_any_unit_is_right():
    """The metric "angle" of degrees is that of radians, in degrees."""
    degrees, radians = (pose_distances(X, metric="angle") for X in (DEGREES, RADIANS))
    np.testing.assert_allclose(degrees, np.degrees(radians))


def test_unwrapped_recordings_are_no_degrees():
    """Some turns of every joint, and many of few joints, are those of real movements."""
    some = RADIANS + 2 * np.pi * np.random.default_rng(0).integers(-2, 3, RADIANS.shape)
    assert caught(forward_kinematics, some, ARM) == []
    person = humanoid()
    spinning = np.random.default_rng(0).uniform(-1, 1, (50, person.n_dofs))
    spinning[:, :3] += np.linspace(0, 200, 50)[:, None]
    assert caught(forward_kinematics, spinning, person) == []


@pytest.mark.parametrize("random_state", range(5))
def test_generated_gait_in_degrees_is_noticed(random_state):
    gait = make_gait(2, 1, random_state=random_state)
    X, _ = gait.poses(12)
    assert caught(forward_kinematics, X, gait.skeleton) == []
    assert len(caught(forward_kinematics, np.degrees(X), gait.skeleton)) == 1


def test_long_recordings_are_noticed_too():
    """Not every pose is looked at."""
    long = np.tile(DEGREES, (5000, 1))
    with pytest.warns(UserWarning, match=f"^values of angles {SIGN}"):
        forward_kinematics(long, ARM)


def test_real_recordings(cmu):
    for motion in cmu:
        for angles in (motion.angles, motion.unwrap().angles, motion.to_rotvec().angles):
            assert caught(Motion, motion.skeleton, angles[:, : motion.skeleton.n_dofs], 120) == []
        assert len(caught(Motion, motion.skeleton, np.degrees(motion.angles), 120)) == 1


def test_empty_and_single_poses():
    assert caught(Motion, ARM, np.zeros((0, 3)), 10) == []
    assert caught(forward_kinematics, np.zeros((1, 3)), ARM) == []


def bvh(scale=1.0):
    """The person of the test data, whose file is in centimetres, in another unit: numbers times the scale."""
    lines = []
    for line in (DATA / "biped.bvh").read_text().splitlines(keepends=True):
        words = line.split()
        if words and words[0] == "OFFSET":
            line = "OFFSET " + " ".join(str(float(word) * scale) for word in words[1:]) + "\n"
        lines.append(line)
    return io.StringIO("".join(lines))


@pytest.mark.parametrize(
    ("factor", "unit", "scale"),
    [(1.0, "centimetres", "0.01"), (10.0, "millimetres", "0.001"), (0.01 / 0.0254, "inches", "0.0254")],
)
def test_a_file_in_another_unit_than_metres_is_noticed(factor, unit, scale):
    with pytest.warns(UserWarning, match=f"if the file is in {unit}, pass scale={scale}, which makes that 1.") as found:
        skeleton = load_bvh(bvh(factor)).skeleton
    assert len(found) == 1
    assert found[0].filename == __file__
    assert f"the skeleton is {size_of(skeleton):.3g} m from end to end at angle zero" in str(found[0].message)
    assert caught(lambda: load_bvh(bvh(factor), scale=float(scale))) == []


def test_a_scale_that_is_given_to_a_file_in_metres_is_noticed():
    with pytest.warns(UserWarning, match="if the file is in metres, pass scale=1, which makes"):
        load_bvh(bvh(0.01), scale=0.01)


def test_a_size_that_no_unit_explains():
    with pytest.warns(UserWarning, match="pass the metres of one unit as scale=$"):
        load_bvh(bvh(1e6))


def test_all_readers_watch_the_size():
    for read in (
        lambda: load_motion(DATA / "biped.bvh"),
        lambda: load_asf(DATA / "arm.asf", scale=100.0),
        lambda: AsfFile(DATA / "arm.asf", scale=100.0),
        lambda: load_amc(DATA / "arm.amc", DATA / "arm.asf", scale=100.0, frame_rate=60),
    ):
        (warning,) = caught(read)
        assert "from end to end at angle zero" in str(warning.message)
        assert warning.filename == __file__
    assert caught(load_asf, DATA / "arm.asf") == []


def test_a_skeleton_that_is_built_by_hand_may_have_any_size():
    assert caught(Skeleton.chain, 10) == []
    assert caught(humanoid, 20.0) == []


def test_the_size_is_that_of_the_joints_at_angle_zero():
    for skeleton in (humanoid(1.8), load_asf(DATA / "arm.asf"), load_bvh(bvh(), scale=0.01).skeleton):
        F = forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton)[0]
        edges = np.ptp(np.concatenate([F, np.zeros((1, 3))]), axis=0)
        np.testing.assert_allclose(size_of(skeleton), edges.max(), rtol=1e-12)
