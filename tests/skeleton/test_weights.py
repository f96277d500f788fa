"""Weights of joints."""

import pickle
import re

import numpy as np
import pandas as pd
import pytest
import reference
from conftest import random_tree

from skpose import Bone, Motion, Skeleton, pose_distances
from skpose.datasets import humanoid
from skpose.io import load_bvh, save_bvh
from skpose.kinematics._mass import ARM_SEGMENTS as ARM, HEAD_SEGMENT as HEAD, LEG_SEGMENTS as LEG, TRUNK
from skpose.kinematics._tree import tree_of
from skpose.metrics import Geodesic, Spatial
from skpose.metrics._registry import METRICS

OF_POSITIONS = [name for name in METRICS if METRICS[name].needs_skeleton]


@pytest.fixture
def arm():
    return Skeleton(
        [
            Bone("elbow", None, (0.3, 0, 0), "xyz"),
            Bone("wrist", "elbow", (0.25, 0, 0), "y"),
            ("tip", "wrist", (0.1, 0, 0)),
        ]
    )


def random_poses(skeleton, n=6, seed=0, scale=1.0):
    return np.random.default_rng(seed).normal(scale=scale, size=(n, skeleton.n_dofs))


def test_weights_are_one_or_as_given(arm):
    np.testing.assert_array_equal(arm.weights, [1, 1, 1])
    np.testing.assert_array_equal(arm.with_weights({"wrist": 2, "tip": 0}).weights, [1, 2, 0])
    np.testing.assert_array_equal(arm.with_weights([0.5, 0, 3]).weights, [0.5, 0, 3])
    changed = arm.with_weights({"wrist": 2}).with_weights({"tip": 5})
    np.testing.assert_array_equal(changed.weights, [1, 2, 5])
    assert changed != arm
    assert changed == pickle.loads(pickle.dumps(changed))
    assert changed.to_rotvec().to_euler("ZXY").bones[1].weight == 2
    assert Skeleton.mean([changed, changed]).bones[1].weight == 2


@pytest.mark.parametrize(
    ("weights", "message"),
    [
        ({"writs": 1}, "'writs', which is not a joint"),
        ({"wrist": -1}, "'wrist': weight"),
        ([1, np.nan, 1], "'wrist': weight"),
        ([1, 1], "weights must have shape (3,)"),
        ([0, 0, 0], "positive for at least one joint"),
        ("weight", "weights must be 'mass'"),
        ("mass", "shoulder"),
    ],
)
def test_invalid_weights_are_refused(weights, message, arm):
    with pytest.raises(ValueError, match=re.escape(message)):
        arm.with_weights(weights)


@pytest.mark.parametrize("metric", OF_POSITIONS)
def test_equal_weights_scale_distances(metric):
    skeleton = random_tree(0)
    X = random_poses(skeleton, n=4, scale=0.3)
    plain, heavy = (
        pose_distances(X, skeleton=s, metric=metric)
        for s in (skeleton, skeleton.with_weights([4.0] * skeleton.n_joints))
    )
    np.testing.assert_allclose(heavy, 2 * plain, rtol=1e-6 if metric == "geodesic" else 1e-13)


@pytest.mark.parametrize("metric", [*OF_POSITIONS, Spatial(2), Geodesic(2)], ids=str)
def test_joints_without_weight_have_no_effect(metric):
    skeleton = random_tree(5, n=14)
    dropped = skeleton.joint_names[4]
    part = skeleton.select(drop=dropped)
    assert part.n_dofs < skeleton.n_dofs
    unseen = skeleton.with_weights(dict.fromkeys(set(skeleton.joint_names) - set(part.joint_names), 0))
    X = random_poses(skeleton, n=4, scale=0.4)
    expected = pose_distances(X[:, part.columns_in(skeleton)], skeleton=part, metric=metric)
    np.testing.assert_array_equal(pose_distances(X, skeleton=unseen, metric=metric), expected)
    assert len(tree_of(unseen).column) == part.n_dofs  # and it costs nothing


# --- joints in one place ----------------------------------------------------------------------------------------------


def test_joints_in_one_place_count_once(tmp_path):
    """Written as BVH, joints stand at the near ends of bones: the neck and both clavicles in one place."""
    skeleton = humanoid()
    motion = Motion(skeleton, random_poses(skeleton, n=5, scale=0.3), 60)
    save_bvh(tmp_path / "gait.bvh", motion)
    read = load_bvh(tmp_path / "gait.bvh")
    weights = dict(zip(read.skeleton.joint_names, read.skeleton.weights, strict=True))
    together = [weights[name] for name in ("neck", "left_clavicle", "right_clavicle")]
    assert sum(together) == 1.0
    np.testing.assert_array_equal(read.skeleton.weights, reference.weights(read.skeleton))
    again = read.skeleton.with_weights({"neck": 1, "left_clavicle": 1, "right_clavicle": 1})
    assert again.weights.sum() == read.skeleton.weights.sum() + 2


@pytest.mark.parametrize("offset_frame", ["own", "parent"])
@pytest.mark.parametrize("seed", range(3))
def test_places_of_trees_of_few_offsets(offset_frame, seed):
    """Few different offsets and rest rotations, so that many joints coincide, through rigid joints and back again."""
    rng = np.random.default_rng(seed)
    offsets = [(0, 0, 0), (1, 0, 0), (-1, 0, 0), (0, 1, 0)]
    turns = [None, [[0, -1, 0], [1, 0, 0], [0, 0, 1]]]
    bones = [Bone("b0", None, (1, 0, 0), "xyz")]
    for i in range(1, 14):
        parent = rng.choice([None, *(bone.name for bone in bones)])
        dofs = rng.choice(["", "", "z", "rotvec"])
        bones.append(Bone(f"b{i}", parent, offsets[rng.integers(4)], str(dofs), turns[rng.integers(2)]))
    skeleton = Skeleton(bones, offset_frame)
    np.testing.assert_array_equal(skeleton.weights, reference.weights(skeleton))


# --- the mass of a person ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("offset_frame", ["own", "parent"])
def test_mass_of_the_segments_of_a_person(offset_frame, tmp_path):
    skeleton = humanoid()
    if offset_frame == "parent":
        save_bvh(tmp_path / "still.bvh", Motion(skeleton, np.zeros((1, skeleton.n_dofs)), 60))
        skeleton = load_bvh(tmp_path / "still.bvh").skeleton
    weights = dict(zip(skeleton.joint_names, skeleton.with_weights("mass").weights, strict=True))
    for side in ("left_", "right_"):
        knee = LEG[0].mass * LEG[0].centre + LEG[1].mass * (1 - LEG[1].centre)
        name = "thigh" if offset_frame == "own" else "shank"
        np.testing.assert_allclose(weights[side + name], knee)
    total = HEAD.mass + TRUNK + 2 * sum(segment.mass for segment in (*ARM, *LEG))
    assert 0.75 * total < sum(weights.values()) <= total + 1e-12  # some of the trunk's is the root's


def test_a_series_with_names_gives_its_weights_by_name(arm):
    """In any order; as a mapping it need not have all of them. One without names is an array."""
    np.testing.assert_array_equal(arm.with_weights(pd.Series({"tip": 3, "wrist": 2, "elbow": 1})).weights, [1, 2, 3])
    np.testing.assert_array_equal(arm.with_weights(pd.Series({"tip": 3})).weights, [1, 1, 3])
    np.testing.assert_array_equal(arm.with_weights(pd.Series([4, 5, 6])).weights, [4, 5, 6])
    with pytest.raises(ValueError, match="'writs', which is not a joint"):
        arm.with_weights(pd.Series({"writs": 3}))
