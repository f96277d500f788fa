from dataclasses import replace

import numpy as np
import pytest
import reference
from conftest import SKELETONS, in_turns
from scipy.spatial.transform import Rotation

from skpose import Motion, Skeleton, motion_distances, pose_distances
from skpose.datasets import make_gait
from skpose.metrics import Angle, Geodesic, Spatial
from skpose.metrics._registry import METRICS
from skpose.motions import align_motions

ARM = Skeleton.chain(2)


def two_motions(skeleton, n=9, m=12, seed=0, dtype=np.float64):
    """Smooth motions of different lengths."""
    rng = np.random.default_rng(seed)
    ends = rng.uniform(-1, 1, size=(3, skeleton.n_dofs))
    through = [np.stack([np.interp(np.linspace(0, 2, k), range(3), c) for c in ends.T], axis=1) for k in (n, m)]
    return [(X + rng.normal(scale=0.1, size=X.shape)).astype(dtype) for X in through]


@pytest.mark.parametrize("dtype", ["float64", "float32"])
@pytest.mark.parametrize(
    ("metric", "alignment"), in_turns(["angle", "rotation", Spatial(4), Geodesic(4)], ["dtw", "subsequence"])
)
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


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("alignment", "window"), [("dtw", None), ("dtw", 0.2), ("subsequence", None)])
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


def test_a_motion_is_found_inside_another():
    dataset = make_gait(1, 1, activities=["walk"], duration=2.0, frame_rate=30, random_state=0)
    inside, whole = dataset[0][20:35], dataset[0]
    found = align_motions(inside, whole, alignment="subsequence")
    np.testing.assert_array_equal(found.path, np.stack([np.arange(15), np.arange(20, 35)], axis=1))
    assert found.distance == 0.0
    assert not found.joint_distances.any()
    np.testing.assert_allclose(found.joint_rotations, 0.0, atol=1e-7)


@pytest.mark.parametrize("name", ["mixed joints", "humanoid"])
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


def spoiled_walk():
    """A walk, and the same one at another tempo, whose left knee stays bent from 1.0 to 1.3 s."""
    walk = make_gait(1, 1, activities=["walk"], duration=2.0, frame_rate=30, random_state=0)[0]
    times = np.concatenate([np.linspace(0, 20, 31), np.linspace(20, 59, 29)[1:]])
    angles = np.stack([np.interp(times, np.arange(60), column) for column in walk.angles.T], axis=1)
    knee = walk.skeleton.dof_names.index("left_shank_rx")
    spoiled = (times >= 30) & (times <= 39)
    angles[spoiled, knee] += 0.5
    return walk, Motion(walk.skeleton, angles, 30), spoiled


@pytest.mark.parametrize("metric", ["position", "spatial"])
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
        f"{farthest[0].place} differs most: by {farthest[0].largest:.3g} m at {farthest[0].frame_a / 30:.4g} s)"
    )


def test_without_a_skeleton_there_are_no_joints():
    a, b = two_motions(ARM)
    found = align_motions(a, b, metric="angle")
    assert found.joint_distances is found.joint_rotations is found.skeleton is found.frame_rate is None
    assert found.distance == motion_distances([a], [b], metric="angle")[0, 0]
    assert repr(found) == f"Alignment(distance={found.distance:.4g} rad, {len(found.path)} pairs of 9 and 12 frames)"
    with pytest.raises(ValueError, match="skeleton"):
        found.joint_differences()
    with pytest.warns(UserWarning, match='without a skeleton means "angle"'):
        assert align_motions(a, b).metric == Angle()
    known = align_motions(a, b, metric="angle", skeleton=ARM)
    assert known.joint_distances.shape == (len(known.path), 2)


def test_a_pelvis_that_is_tilted_does_not_move_the_feet():
    """A walk, and the same with the pelvis tilted 10° about the line of the hips; trunk and legs stay in the world."""
    motion = make_gait(1, 1, activities=["walk"], duration=1.0, frame_rate=20, random_state=0)[0]
    names, angles, tilt = motion.skeleton.dof_names, motion.angles.copy(), Rotation.from_rotvec([np.radians(10), 0, 0])
    for name in ("abdomen", "left_thigh", "right_thigh"):
        i = names.index(f"{name}_rotvec_x")
        angles[:, i : i + 3] = (tilt.inv() * Rotation.from_rotvec(angles[:, i : i + 3])).as_rotvec()
    root = Rotation.from_euler("xyz", np.zeros((len(motion), 3))) * tilt
    tilted = replace(motion, angles=angles, root_angles=root.as_euler("xyz"), root_axes="xyz")
    found = align_motions(motion, tilted, metric="angle")
    assert found.joint_distances.max() < 1e-6
    positions = [reference.forward_kinematics(one.angles, one.skeleton) for one in (motion, tilted)]
    assert np.linalg.norm(positions[0] - positions[1], axis=2).max() > 0.1
