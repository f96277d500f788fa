import joblib
import numpy as np
import pytest
import reference
from conftest import SKELETONS
from scipy.spatial.transform import Rotation
from sklearn.exceptions import ConvergenceWarning

from skpose import Bone, Motion, Skeleton, forward_kinematics, motion_distances, pose_distances
from skpose.datasets import MotionDataset, humanoid, make_gait
from skpose.metrics import Angle, Geodesic, Spatial
from skpose.metrics._registry import METRICS
from skpose.motions import JointDifference, MotionIndex, align_motions, find_motion

ARM = Skeleton.chain(2)


def two_motions(skeleton, n=9, m=12, seed=0, dtype=np.float64):
    """Smooth motions of different lengths."""
    rng = np.random.default_rng(seed)
    ends = rng.uniform(-1, 1, size=(3, skeleton.n_dofs))
    through = [np.stack([np.interp(np.linspace(0, 2, k), range(3), c) for c in ends.T], axis=1) for k in (n, m)]
    return [(X + rng.normal(scale=0.1, size=X.shape)).astype(dtype) for X in through]


@pytest.mark.parametrize("dtype", ["float64", "float32"])
@pytest.mark.parametrize("alignment", ["dtw", "subsequence"])
@pytest.mark.parametrize("metric", ["angle", "position", "rotation", Spatial(4), Geodesic(4)])
def test_the_distance_is_that_of_motion_distances_to_the_last_bit(metric, alignment, dtype):
    a, b = two_motions(SKELETONS["mixed joints"], 7, 10, dtype=dtype)
    parameters = {"skeleton": SKELETONS["mixed joints"], "metric": metric, "alignment": alignment}
    found = align_motions(a, b, **parameters)
    expected = motion_distances([a], [b], **parameters)[0, 0]
    assert expected.dtype == dtype
    assert found.distance == float(expected)  # else numpy would compare in float32
    n_counted = len(a) if alignment == "subsequence" else len(a) + len(b)
    rounding = 1e-6 if dtype == "float32" else 1e-13
    np.testing.assert_allclose(found.distances.sum(dtype=float) / n_counted, found.distance, rtol=rounding)
    assert found.metric == (METRICS[metric]() if isinstance(metric, str) else metric)


def test_geodesics_are_added_before_they_are_rounded():
    """They are computed in float64 in any case; rounded to float32 first, some of these sums would differ."""
    for seed in range(20):
        a, b = two_motions(ARM, 3, 4, seed=seed, dtype="float32")
        found = align_motions(a, b, skeleton=ARM, metric=Geodesic(2))
        assert found.distance == float(motion_distances([a], [b], skeleton=ARM, metric=Geodesic(2))[0, 0])


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(
    ("alignment", "window"),
    [("dtw", None), ("dtw", 0.4), ("dtw", 0.2), ("dtw", 0.0), ("subsequence", None)],
)
def test_the_path_is_the_best_of_all_paths(alignment, window, seed):
    rng = np.random.default_rng(seed)
    n, m = rng.integers(1, 7, size=2)
    a, b = rng.normal(size=(n, 2)), rng.normal(size=(m, 2))
    found = align_motions(a, b, skeleton=ARM, alignment=alignment, window=window)
    costs = pose_distances(a, b, skeleton=ARM)
    least, path = reference.dtw(costs, window, alignment)
    np.testing.assert_allclose(found.distances.sum(), least, rtol=1e-13)
    np.testing.assert_array_equal(found.path, path)  # no two paths have the same sum
    np.testing.assert_array_equal(found.distances, costs[tuple(found.path.T)])


def test_a_window_limits_the_path():
    a, b = two_motions(ARM, 40, 60)
    b[:40] = a[0]  # waits
    free, narrow = (align_motions(a, b, skeleton=ARM, window=window) for window in (None, 0.1))

    def apart(found):
        return np.abs(found.path[:, 0] / 39 - found.path[:, 1] / 59).max()

    assert apart(free) > 0.5
    assert apart(narrow) <= 0.1
    assert narrow.distance > free.distance
    assert narrow.distance == motion_distances([a], [b], skeleton=ARM, window=0.1)[0, 0]


@pytest.mark.parametrize("alignment", ["dtw", "subsequence"])
@pytest.mark.parametrize("lengths", [(1, 1), (1, 5), (5, 1), (2, 30), (30, 2), (20, 20)])
def test_the_path_is_monotone_and_goes_from_end_to_end(lengths, alignment):
    a, b = two_motions(ARM, *lengths)
    path = align_motions(a, b, skeleton=ARM, alignment=alignment).path
    assert path.dtype.kind == "i"
    steps = {tuple(step) for step in np.diff(path, axis=0).tolist()}
    assert steps <= {(1, 0), (0, 1), (1, 1)}
    assert (path[0, 0], path[-1, 0]) == (0, lengths[0] - 1)
    if alignment == "dtw":
        assert (path[0, 1], path[-1, 1]) == (0, lengths[1] - 1)


def test_a_motion_is_found_inside_another():
    dataset = make_gait(1, 1, activities=["walk"], duration=2.0, frame_rate=30, random_state=0)
    inside, whole = dataset[0][20:35], dataset[0]
    found = align_motions(inside, whole, alignment="subsequence")
    np.testing.assert_array_equal(found.path, np.stack([np.arange(15), np.arange(20, 35)], axis=1))
    assert found.distance == 0.0
    assert not found.joint_distances.any()
    np.testing.assert_allclose(found.joint_rotations, 0.0, atol=1e-7)


@pytest.mark.parametrize("name", SKELETONS)
def test_differences_of_joints_are_those_of_positions_and_of_rotations(name):
    skeleton = SKELETONS[name]
    a, b = two_motions(skeleton, 6, 8)
    found = align_motions(a, b, skeleton=skeleton, metric="position")
    assert found.joint_distances.shape == found.joint_rotations.shape == (len(found.path), skeleton.n_joints)
    orientations = [reference.orientations_and_positions(poses, skeleton)[0] for poses in (a, b)]
    positions = [reference.forward_kinematics(poses, skeleton) for poses in (a, b)]
    for k, (i, j) in enumerate(found.path):
        for joint, parent in enumerate(skeleton.parents):
            gap = positions[0][i, joint] - positions[1][j, joint]
            np.testing.assert_allclose(found.joint_distances[k, joint], np.sqrt(gap @ gap), rtol=1e-9, atol=1e-12)
            of_a, of_b = (
                (one[parent][f].inv() if parent >= 0 else Rotation.identity()) * one[joint][f]
                for one, f in zip(orientations, (i, j), strict=True)
            )
            angle = (of_a.inv() * of_b).magnitude()
            np.testing.assert_allclose(found.joint_rotations[k, joint], angle, rtol=1e-9, atol=1e-7)


def test_rotations_do_not_depend_on_the_numbers_of_a_rotation():
    skeleton = SKELETONS["humanoid"]
    a, b = two_motions(skeleton, 6, 8)
    euler = align_motions(a, b, skeleton=skeleton, metric="rotation")
    one, two = (Motion(skeleton, X, 10).to_rotvec() for X in (a, b))
    ball = align_motions(one, two, metric="rotation")
    np.testing.assert_array_equal(ball.path, euler.path)
    np.testing.assert_allclose(ball.joint_rotations, euler.joint_rotations, atol=1e-7)
    turned = align_motions(a, b + 2 * np.pi, skeleton=skeleton, metric="rotation")
    np.testing.assert_allclose(turned.joint_rotations, euler.joint_rotations, atol=1e-7)


def test_weights_of_joints_change_the_path_and_not_the_differences():
    a, b = two_motions(ARM, 6, 6)
    plain = align_motions(a, b, skeleton=ARM, metric="position")
    weighted = align_motions(a, b, skeleton=ARM.with_weights({"joint_1": 0.0}), metric="position")
    assert weighted.distance < plain.distance
    distances = np.linalg.norm(forward_kinematics(a, ARM)[:, None] - forward_kinematics(b, ARM), axis=-1)
    np.testing.assert_allclose(weighted.joint_distances, distances[tuple(weighted.path.T)], atol=1e-12)


def spoiled_walk():
    """A walk, and the same one at another tempo, whose left knee stays bent from 1.0 to 1.3 s."""
    walk = make_gait(1, 1, activities=["walk"], duration=2.0, frame_rate=30, random_state=0)[0]
    times = np.concatenate([np.linspace(0, 20, 31), np.linspace(20, 59, 29)[1:]])
    angles = np.stack([np.interp(times, np.arange(60), column) for column in walk.angles.T], axis=1)
    knee = walk.skeleton.dof_names.index("left_shank_rx")
    spoiled = (times >= 30) & (times <= 39)
    angles[spoiled, knee] += 0.5
    return walk, Motion(walk.skeleton, angles, 30), spoiled


@pytest.mark.parametrize("metric", ["position", "rotation", "spatial", "angle"])
def test_a_spoiled_joint_is_found(metric):
    walk, other, spoiled = spoiled_walk()
    found = align_motions(walk, other, metric=metric)
    first, second, *_ = found.joint_differences("rotation")
    assert first.joint == "left_shank"
    np.testing.assert_allclose(first.largest, 0.5, atol=0.2)  # the path evades a part of it
    assert second.largest < 0.6 * first.largest
    assert spoiled[first.frame_b]
    assert 1.0 <= first.frame_a / found.frame_rate <= 1.3
    farthest = found.joint_differences()
    assert {one.joint for one in farthest[:3]} == {"left_shank", "left_foot", "left_toes"}
    assert repr(found).endswith(
        f"{farthest[0].joint} differs most: by {farthest[0].largest:.3g} m at {farthest[0].frame_a / 30:.4g} s)"
    )


def test_the_list_of_joints_is_what_the_arrays_hold():
    skeleton = SKELETONS["tree"]
    a, b = two_motions(skeleton, 7, 9)
    found = align_motions(a, b, skeleton=skeleton)
    rotating = [bone.name for bone in skeleton.bones if bone.dofs]
    assert len(rotating) < skeleton.n_joints
    for quantity, array, names in (
        ("distance", found.joint_distances, skeleton.joint_names),
        ("rotation", found.joint_rotations, rotating),
    ):
        listed = found.joint_differences(quantity)
        assert sorted(one.joint for one in listed) == sorted(names)
        assert all(isinstance(one, JointDifference) for one in listed)
        assert [one.largest for one in listed] == sorted((one.largest for one in listed), reverse=True)
        for one in listed:
            values = array[:, skeleton.joint_names.index(one.joint)]
            pair = found.path.tolist().index([one.frame_a, one.frame_b])
            assert one.largest == values[pair] == values.max()
            np.testing.assert_allclose(one.mean, values.mean())
    assert not np.delete(found.joint_rotations, [skeleton.joint_names.index(name) for name in rotating], axis=1).any()


@pytest.mark.parametrize("alignment", ["dtw", "subsequence"])
@pytest.mark.parametrize("name", ["mixed joints", "humanoid"])
def test_the_table_has_a_row_for_each_pair_and_joint(name, alignment):
    skeleton = SKELETONS[name]
    a, b = (Motion(skeleton, poses, 25) for poses in two_motions(skeleton, 7, 10))
    found = align_motions(a, b, alignment=alignment)
    table = found.to_pandas()
    rows = iter(table.to_dict("records"))
    positions = [forward_kinematics(motion.angles, skeleton) for motion in (a, b)]
    for pair, (i, j) in enumerate(found.path.tolist()):
        for k, bone in enumerate(skeleton.bones):
            row = next(rows)
            assert (row["pair"], row["joint"], row["frame_a"], row["frame_b"]) == (pair, bone.name, i, j)
            times = [row["time_a [s]"], row["time_b [s]"], row["phase_a [%]"], row["phase_b [%]"]]
            np.testing.assert_allclose(times, [i / 25, j / 25, 100 * i / 6, 100 * j / 9])
            difference = positions[1][j, k] - positions[0][i, k]
            np.testing.assert_allclose([row[f"{axis} [m]"] for axis in "xyz"], difference, atol=1e-12)
            assert row["deviation [m]"] == pytest.approx(np.linalg.norm(difference), abs=1e-12)
            expected = np.degrees(found.joint_rotations[pair, k]) if bone.dofs else np.nan
            np.testing.assert_array_equal(row["rotation [deg]"], expected)
    assert next(rows, None) is None
    assert table.attrs == {"distance": found.distance, "metric": repr(found.metric)}
    most = table.loc[table["deviation [m]"].idxmax()]
    first = found.joint_differences()[0]
    assert (most["joint"], most["deviation [m]"], most["frame_a"]) == (first.joint, first.largest, first.frame_a)


def test_the_table_has_no_times_of_arrays_and_no_phase_of_one_frame():
    table = align_motions([[0.1, 0.0]], [[0.0, 0.0], [0.2, 0.0]], skeleton=ARM).to_pandas()
    assert table[["time_a [s]", "time_b [s]", "phase_a [%]"]].isna().all(axis=None)
    assert table["phase_b [%]"].tolist() == [0, 0, 100, 100]


def test_without_a_skeleton_there_are_no_joints():
    a, b = two_motions(ARM)
    found = align_motions(a, b, metric="angle")
    assert found.joint_distances is found.joint_rotations is found.skeleton is found.frame_rate is None
    assert found.distance == motion_distances([a], [b], metric="angle")[0, 0]
    assert repr(found) == f"Alignment(distance={found.distance:.4g} rad, {len(found.path)} pairs of 9 and 12 frames)"
    with pytest.raises(ValueError, match="no skeleton and so no joints: pass skeleton= to align_motions"):
        found.joint_differences()
    with pytest.raises(ValueError, match="no skeleton and so no joints: pass skeleton= to align_motions"):
        found.to_pandas()
    with pytest.warns(UserWarning, match='without a skeleton means "angle"'):
        assert align_motions(a, b).metric == Angle()
    known = align_motions(a, b, metric="angle", skeleton=ARM)
    assert known.joint_distances.shape == (len(known.path), 2)


def test_motions_are_compared_on_their_mean_skeleton():
    first, second = make_gait(2, 1, activities=["walk"], duration=0.5, frame_rate=20, random_state=0)
    found = align_motions(first, second)
    assert found.skeleton == Skeleton.mean([first.skeleton, second.skeleton])
    assert found.frame_rate == 20
    np.testing.assert_array_equal(found.a, first.angles)
    np.testing.assert_array_equal(found.b, second.angles)
    assert found.distance == motion_distances([first], [second])[0, 0]
    assert found.metric == Spatial()
    other = align_motions(first, second, skeleton=humanoid())
    assert other.skeleton == humanoid()


def test_two_equal_motions_differ_nowhere():
    a, _ = two_motions(ARM)
    found = align_motions(a, a, skeleton=ARM)
    np.testing.assert_array_equal(found.path, np.stack([np.arange(9)] * 2, axis=1))
    assert repr(found) == "Alignment(distance=0 m, 9 pairs of 9 and 9 frames)"


def test_threads_of_a_joblib_context_give_the_same():
    a, b = two_motions(SKELETONS["humanoid"], 40, 50)
    one = align_motions(a, b, skeleton=SKELETONS["humanoid"])
    with joblib.parallel_config(n_jobs=2):
        two = align_motions(a, b, skeleton=SKELETONS["humanoid"])
    np.testing.assert_array_equal(one.path, two.path)
    assert one.distance == two.distance


def test_unconverged_geodesics_are_counted():
    skeleton = Skeleton([Bone("arm", None, (1, 0, 0), "xyz"), Bone("hand", "arm", (1, 0, 0), "xyz")])
    rng = np.random.default_rng(0)
    a, b = rng.uniform(-3, 3, size=(2, 12, 6))
    with pytest.warns(ConvergenceWarning) as expected:
        motion_distances([a], [b], skeleton=skeleton, metric=Geodesic(2))
    with pytest.warns(ConvergenceWarning) as found:
        align_motions(a, b, skeleton=skeleton, metric=Geodesic(2))
    assert str(found[0].message) == str(expected[0].message)


def test_degrees_are_noticed_at_the_users_line():
    a, b = (np.degrees(X) for X in two_motions(ARM))
    with pytest.warns(UserWarning, match=r"^values of a reach .* np\.radians\(a\)") as found:
        align_motions(a, b, skeleton=ARM)
    assert [warning.filename for warning in found] == [__file__]
    with pytest.warns(UserWarning, match="^values of X reach") as found:
        motion_distances([a], [b], skeleton=ARM)
    assert [warning.filename for warning in found] == [__file__]
    with pytest.warns(UserWarning, match="^values of motions reach") as found:
        index = MotionIndex([b], skeleton=ARM)
    assert [warning.filename for warning in found] == [__file__]
    with pytest.warns(UserWarning, match="^values of query reach") as found:
        find_motion(a, index, k=1)
    assert [warning.filename for warning in found] == [__file__]


A, B = two_motions(ARM)
MOTION = Motion(ARM, A, 10)
DATASET = MotionDataset([MOTION, MOTION])


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (
            lambda: align_motions([A, B], B, skeleton=ARM),
            TypeError,
            "^a must be one motion, .* got a list of ndarray: pass one of them",
        ),
        (
            lambda: align_motions(A, [MOTION]),
            TypeError,
            r"^b must be one motion, .* got a list of Motion: pass one",
        ),
        (
            lambda: align_motions(DATASET, B),
            TypeError,
            r"^a must be one motion, .* a MotionDataset of 2: .* such as",
        ),
        (
            lambda: align_motions(A, B[None], skeleton=ARM),
            TypeError,
            r"^b must be .* array of shape \(1, 12, 2\)",
        ),
        (lambda: align_motions(A[0], B, skeleton=ARM), TypeError, r"^a must be one motion, .* of shape \(2,\)$"),
        (lambda: align_motions(A, None, skeleton=ARM), TypeError, "^b must be one motion, .* got None"),
        (
            lambda: align_motions(A, ARM),
            TypeError,
            "^b must be one motion, .* got a Skeleton: pass it as skeleton=",
        ),
        (lambda: align_motions(A, MOTION), TypeError, "^a and b must be all .* 1 Motion, and 1 other, a among them"),
        (lambda: align_motions(MOTION, MOTION[:0]), ValueError, "^b has no frames: leave it out"),
        (
            lambda: align_motions(MOTION, Motion(ARM, B, 20)),
            ValueError,
            r"one frame rate, .* but a has 10 Hz and b 20 Hz",
        ),
        (lambda: align_motions(A, B[:, :1], metric="angle"), ValueError, "^a has 2 columns and b has 1"),
        (lambda: align_motions(A, B[:, :1], skeleton=ARM), ValueError, "^b has 1 columns, but the skeleton has 2"),
        (lambda: align_motions(A, B, metric="spatial"), ValueError, "the metric 'spatial' needs a skeleton"),
        (lambda: align_motions(A, B * np.nan, skeleton=ARM), ValueError, "^Input b contains NaN"),
        (
            lambda: align_motions(A, B, skeleton=ARM, alignment="subsequence", window=0.5),
            ValueError,
            'window is the band of alignment="dtw"',
        ),
        (
            lambda: align_motions(A, B, skeleton=ARM, alignment="frames"),
            ValueError,
            "'alignment' parameter of",
        ),
        (lambda: align_motions(A, B, skeleton=ARM, window=2.0), ValueError, "'window' parameter of align_motions"),
        (
            lambda: align_motions(A, B, skeleton=ARM).joint_differences("angle"),
            ValueError,
            'quantity must be "distance" or "rotation", got \'angle\'',
        ),
    ],
)
def test_errors_say_what_was_expected(call, error, message):
    with pytest.raises(error, match=message):
        call()
