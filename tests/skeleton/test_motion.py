import numpy as np
import pytest
from sklearn.base import clone

from skpose import (
    Bone,
    MedoidShift,
    Motion,
    PoseDistanceTransformer,
    PoseKNeighborsTransformer,
    PoseRadiusNeighborsTransformer,
    Skeleton,
    SpatialMDS,
)
from skpose.kinematics import retarget
from skpose.skeleton._interpolation import interpolate_poses

ARM = Skeleton.chain(2)


def test_defaults_and_repr():
    motion = Motion(ARM, [[0, 1], [2, 3]], 2)
    np.testing.assert_array_equal(motion.root_positions, np.zeros((2, 3)))
    np.testing.assert_array_equal(motion.root_angles, np.zeros((2, 3)))
    assert len(motion) == 2
    assert repr(motion) == "Motion(2 frames at 2 Hz, 1.0 s, y up, Skeleton(n_joints=2, n_dofs=2))"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"angles": np.zeros((3, 5))}, r"angles must have shape \(3, 2\), got \(3, 5\)"),
        ({"angles": [[0, 1], [np.nan, 0]]}, "angles holds nan at frame 1, column 0"),
        ({"angles": 0.0}, "angles must have shape"),
        ({"root_positions": np.zeros((2, 3))}, r"root_positions must have shape \(3, 3\), got \(2, 3\)"),
        ({"root_angles": np.zeros((3, 2))}, r"root_angles must have shape \(3, 3\), got \(3, 2\)"),
        ({"root_angles": np.full((3, 3), np.inf)}, "root_angles holds inf at frame 0, column 0"),
        ({"frame_rate": 0}, "frame_rate must be a positive number of Hz, got 0"),
        ({"frame_rate": np.nan}, "frame_rate must be a positive number of Hz, got nan"),
        ({"frame_rate": "30"}, "frame_rate must be a positive number of Hz, got '30'"),
        ({"frame_rate": None}, "frame_rate must be a positive number of Hz, got None"),
        ({"root_axes": "q"}, "root_axes must be at most one each of the letters x, y and z in one case, .* got 'q'"),
        ({"root_axes": "xX"}, "root_axes must be at most one each of the letters x, y and z in one case, .* got 'xX'"),
        ({"root_axes": 3}, "root_axes must be at most one each of the letters x, y and z in one case, .* got 3"),
    ],
)
def test_error_for_arguments_that_do_not_fit(arguments, message):
    with pytest.raises(ValueError, match=message):
        Motion(**({"skeleton": ARM, "angles": np.zeros((3, 2)), "frame_rate": 10.0} | arguments))


@pytest.mark.filterwarnings("ignore:values of angles reach:UserWarning")
def test_frames_may_be_missing():
    """Frames keep their numbers and times; resampling makes none up between two that do not follow each other."""
    angles = np.arange(40.0).reshape(20, 2)
    whole, kept = Motion(ARM, angles, 10), np.array([2, 3, 4, 5, 9, 12, 13, 14, 15, 19])
    motion = Motion(ARM, angles[kept], 10, whole.root_positions[kept], frame_numbers=kept)
    np.testing.assert_array_equal(motion.times, kept / 10)
    np.testing.assert_array_equal(whole.times, np.arange(20) / 10)
    for change in (motion.unwrap(), retarget(motion, ARM)):
        np.testing.assert_array_equal(change.frame_numbers, kept)
    for rate in (5, 10, 20, 7, 3):
        expected, found = whole.resample(rate), motion.resample(rate)
        known = np.isin(np.floor(found.times * 10 + 1e-9), kept)
        assert known.all()
        np.testing.assert_allclose(found.angles, expected.angles[found.frame_numbers], rtol=1e-12)
        at = expected.times * 10
        both = np.isin(np.floor(at + 1e-9), kept) & np.isin(np.ceil(at - 1e-9), kept)
        np.testing.assert_array_equal(found.frame_numbers, expected.frame_numbers[both])
    assert motion.resample(10).frame_numbers.tolist() == kept.tolist()


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ([0, 1], r"frame_numbers must be 3 whole numbers, got int64 of \(2,\)"),
        ([0.0, 1.5, 2.0], "frame_numbers must be 3 whole numbers, got float64"),
        ([0, 2, 2], "frame_numbers must increase, got 2 and then 2"),
    ],
)
def test_frame_numbers_that_do_not_fit(numbers, message):
    with pytest.raises(ValueError, match=message):
        Motion(ARM, np.zeros((3, 2)), 10, frame_numbers=numbers)


@pytest.mark.filterwarnings("ignore:values of angles reach:UserWarning")
def test_resampling_by_a_whole_factor_takes_frames_as_they_are():
    angles = np.random.default_rng(0).normal(size=(101, 2)) * 10
    motion = Motion(ARM, angles, 120, root_positions=np.ones((101, 3)), root_angles=np.ones((101, 1)), root_axes="z")
    down = motion.resample(12)
    np.testing.assert_array_equal(down.angles, angles[::10])
    assert (down.frame_rate, down.root_axes) == (12, "z")
    np.testing.assert_array_equal(motion.resample(120).angles, angles)
    np.testing.assert_array_equal(motion.resample(240).angles[::2], angles)


def test_resampling_between_frames_is_linear():
    motion = Motion(ARM, np.linspace([0, 1], [3, -1], 31), 30)
    up = motion.resample(12)
    times = np.arange(len(up)) / 12
    assert len(up) == 13
    np.testing.assert_allclose(up.angles, np.stack([3 * times, 1 - 2 * times], axis=1), atol=1e-12)


def test_resampling_wraps_differences():
    """A file's jump by 360° between two frames is no rotation."""
    degrees = np.array([[179.0, 0], [-179, 0], [-177, 0]])
    between = np.degrees(Motion(ARM, np.radians(degrees), 10).resample(20).angles[:, 0])
    np.testing.assert_allclose(between, [179, 180, -179, -178, -177])


def hinges_of(limits):
    """One hinge with limits, and one without."""
    return Skeleton([Bone("a", None, (1, 0, 0), "z", limits=(limits,)), Bone("b", "a", (1, 0, 0), "z")])


def test_resampling_keeps_hinges_out_of_the_gap_of_their_limits():
    """From −170° to 160° the wrapped difference is −30°, which is closed to the first hinge; it rotates by 330°."""
    start, end = np.radians([-170.0, 160.0])
    motion = Motion(hinges_of((-3.0, 2.8)), [[start, start], [end, end]], 1).resample(10)
    np.testing.assert_allclose(motion.angles[:, 0], np.linspace(start, end, 11), atol=1e-12)
    np.testing.assert_allclose(motion.angles[:10, 1], np.linspace(start, end - 2 * np.pi, 11)[:10], atol=1e-12)
    assert motion.angles[-1, 1] == end


@pytest.mark.parametrize("limits", [(-np.pi, np.pi), (-7, 7), (-np.inf, 3.0), (-2.9, 3.0), (-3.0, 2.7)])
def test_resampling_wraps_hinges_without_a_gap_and_those_that_break_their_limits(limits):
    start, end = np.radians([-170.0, 160.0])
    motion = Motion(hinges_of(limits), [[start, start], [end, end]], 1).resample(10)
    np.testing.assert_array_equal(motion.angles[:, 0], motion.angles[:, 1])


def test_joints_with_three_angles_rotate_by_slerp_with_any_limits():
    angles, limits = [[-2.9, 0.3, 0.5], [2.7, -0.4, 0.2]], ((-3.0, 2.8),) * 3
    limited, free = (
        Motion(Skeleton([Bone("a", None, (1, 0, 0), "xyz", None, pairs)]), angles, 1) for pairs in (limits, None)
    )
    np.testing.assert_array_equal(limited.resample(7).angles, free.resample(7).angles)
    np.testing.assert_array_equal(limited.unwrap().angles, free.unwrap().angles)


def test_unwrapping_leaves_hinges_that_stay_inside_limits_with_a_gap():
    jump = np.array([-2.9, 2.7, 2.5])
    for limits, kept in (((-3.0, 2.8), True), ((-2.8, 2.8), False), ((-np.pi, np.pi), False)):
        found = Motion(hinges_of(limits), np.stack([jump, jump], axis=1), 1).unwrap().angles
        np.testing.assert_array_equal(found[:, 0], jump if kept else np.unwrap(jump))
        np.testing.assert_array_equal(found[:, 1], np.unwrap(jump))


def test_what_is_between_literal_numbers_is_so_after_rounding():
    ends = np.random.default_rng(0).uniform(-3, 3, (1000, 2)) * [1.0, 1e-3]
    bones, literal = [Bone(str(i), None, (1, 0, 0), "z") for i in range(1000)], np.ones(1000, bool)
    for part in (np.nextafter(1.0, 0.0), np.nextafter(0.0, 1.0), 1 / 3):
        between = interpolate_poses(bones, ends.T, np.array([part]), literal)[0]
        assert (between >= ends.min(axis=1)).all()
        assert (between <= ends.max(axis=1)).all()
    rounded = ends[:, 0] + (ends[:, 1] - ends[:, 0])  # a part of one would pass the end, and is taken as it is
    assert ((rounded > ends.max(axis=1)) | (rounded < ends.min(axis=1))).any()
    np.testing.assert_array_equal(interpolate_poses(bones, ends.T, np.array([1.0]), literal)[0], ends[:, 1])


def test_resampling_short_motions():
    assert len(Motion(ARM, np.zeros((0, 2)), 10).resample(3)) == 0
    assert len(Motion(ARM, np.zeros((1, 2)), 10).resample(3)) == 1
    with pytest.raises(ValueError, match="frame_rate must be a positive"):
        Motion(ARM, np.zeros((1, 2)), 10).resample(-1)


def test_retargeting_matches_columns_by_name():
    skeleton = Skeleton(
        [Bone("a", None, (1, 0, 0), "xy"), Bone("b", "a", (1, 0, 0), "z"), Bone("c", None, (1, 0, 0), "x")]
    )
    taller = Skeleton(
        [Bone("c", None, (2, 0, 0), "x"), Bone("a", None, (2, 0, 0), "xy"), Bone("b", "a", (2, 0, 0), "z")]
    )
    motion = Motion(skeleton, [[1, 2, 3, 4]], 10, root_positions=[[5, 6, 7]])
    moved = retarget(motion, taller)
    np.testing.assert_array_equal(moved.angles, [[4, 1, 2, 3]])
    np.testing.assert_array_equal(moved.root_positions, [[5, 6, 7]])
    assert moved.skeleton is taller
    np.testing.assert_array_equal(retarget(moved, skeleton).angles, motion.angles)
    with pytest.raises(ValueError, match="do not carry over to this skeleton: only one of them has a joint 'a'"):
        retarget(motion, ARM)


def test_unwrapping_removes_jumps_by_whole_turns():
    angles = np.cumsum(np.random.default_rng(0).uniform(-1, 1, size=(50, 2)), axis=0)
    jumped = (angles + np.pi) % (2 * np.pi) - np.pi
    motion = Motion(ARM, jumped, 10, root_positions=np.ones((50, 3)), root_angles=jumped[:, :1], root_axes="z").unwrap()
    np.testing.assert_allclose(motion.angles - motion.angles[0], angles - angles[0], atol=1e-12)
    np.testing.assert_allclose(motion.root_angles - motion.root_angles[0], (angles - angles[0])[:, :1], atol=1e-12)
    np.testing.assert_array_equal(motion.root_positions, np.ones((50, 3)))
    assert (motion.frame_rate, motion.root_axes) == (10, "z")


def test_data_frame_of_the_angles():
    frame = Motion(ARM, [[0, 1], [2, 3]], 4).to_pandas()
    assert list(frame.columns) == ["joint_1_rz", "joint_2_rz"]
    assert (list(frame.index), frame.index.name) == ([0, 0.25], "time")
    np.testing.assert_array_equal(frame, [[0, 1], [2, 3]])


def test_a_motion_checks_the_columns_of_a_data_frame():
    """As estimators do: the order is that of the skeleton, by name; other names are taken by position."""
    frame = Motion(ARM, [[0, 1], [2, 3]], 4).to_pandas()
    np.testing.assert_array_equal(Motion(ARM, frame, 4).angles, [[0, 1], [2, 3]])
    wrong = r"the columns of angles are named .*\(column 0 is 'joint_2_rz' and should be 'joint_1_rz'\); select them "
    with pytest.raises(ValueError, match=wrong):
        Motion(ARM, frame[frame.columns[::-1]], 4)
    with pytest.raises(ValueError, match="missing: 'joint_2_rz'; not a dof of it: 'time'"):
        Motion(ARM, frame[["joint_1_rz"]].reset_index(), 4)
    np.testing.assert_array_equal(Motion(ARM, frame.set_axis(["a", "b"], axis=1), 4).angles, [[0, 1], [2, 3]])


ESTIMATORS = [
    PoseDistanceTransformer, PoseKNeighborsTransformer, PoseRadiusNeighborsTransformer, SpatialMDS, MedoidShift,
]  # fmt: skip


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_estimators_check_the_columns_of_a_data_frame(estimator):
    """A wrong order is refused by name, in fit and after it; so are the dofs of another skeleton."""
    motion = Motion(Skeleton.chain(3), np.random.default_rng(0).uniform(-1, 1, (20, 3)), 10)
    frame = motion.to_pandas()
    options = {"n_clusters": 2} if estimator is MedoidShift else {}
    fitted = estimator(skeleton=motion.skeleton, **options).fit(frame)
    assert list(fitted.feature_names_in_) == list(motion.skeleton.dof_names)
    reversed_frame = frame[frame.columns[::-1]]
    wrong = r"column 0 is 'joint_3_rz' and should be 'joint_1_rz'\); select them with X\[list\(skeleton.dof_names\)\]"
    with pytest.raises(ValueError, match=wrong):
        clone(fitted).fit(reversed_frame)
    use = getattr(fitted, "transform", None) or fitted.predict
    use(frame)
    with pytest.raises(ValueError, match=wrong):
        use(reversed_frame)
    with pytest.raises(ValueError, match="missing: 'joint_3_rz'"):
        clone(fitted).fit(frame.rename(columns={"joint_3_rz": "tail_rz"}))
