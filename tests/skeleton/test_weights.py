"""Weights of joints: those of the definition, joints in one place, the mass of a person."""

import pickle
import re

import numpy as np
import pandas as pd
import pytest
import reference
from conftest import DATA, SKELETONS, random_tree, weighted

from skpose import Bone, Motion, Skeleton, geodesic, metric_tensor, pose_distances, position_jacobian
from skpose.datasets import humanoid
from skpose.geodesics import frechet_mean
from skpose.io import load_asf, load_bvh, save_bvh
from skpose.kinematics._tree import tree_of
from skpose.metrics import Geodesic, Spatial
from skpose.metrics._registry import METRICS
from skpose.skeleton._mass import ARM, HEAD, LEG, TRUNK

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
        ({"writs": 1}, "weights names 'writs', which no joint has: did you mean 'wrist'?"),
        ({"wrist": -1}, "bone 'wrist': weight must be a finite number, zero or more, or None, got -1"),
        ({"wrist": np.inf}, "bone 'wrist': weight must be a finite number"),
        ({"wrist": "heavy"}, "bone 'wrist': weight must be a finite number"),
        ([1, np.nan, 1], "bone 'wrist': weight must be a finite number"),
        (
            [1, 1],
            "weights must have one number for each of the 3 joints in skeleton.joint_names, got an array of shape (2,)",
        ),
        ([0, 0, 0], "weights must be positive for at least one joint, but all are zero"),
        ("weight", "weights must be a mapping, an array or \"mass\", got 'weight'"),
        ("mass", "expected two joints, left and right, named shoulder, got none. Weigh the whole"),
        (2.0, "weights must have one number for each of the 3 joints in skeleton.joint_names, got 2.0"),
    ],
)
def test_weights_that_mean_nothing_are_refused(weights, message, arm):
    with pytest.raises(ValueError, match=re.escape(message)):
        arm.with_weights(weights)


def test_weights_are_shown(arm):
    """Skeletons among which a grid search chooses differ in what is printed."""
    assert repr(arm) == "Skeleton(n_joints=3, n_dofs=4)"
    assert repr(arm.with_weights({"tip": 0})) == "Skeleton(n_joints=3, n_dofs=4, weights={'tip': 0.0})"
    person = humanoid()
    assert repr(person.with_weights("mass")) == "Skeleton(n_joints=22, n_dofs=42, weights of 22 joints)"


def test_skeletons_of_different_weights_have_no_mean(arm):
    with pytest.raises(ValueError, match="bone 'wrist' has different weights in the skeletons"):
        Skeleton.mean([arm, arm.with_weights({"wrist": 2})])


@pytest.mark.parametrize("metric", OF_POSITIONS)
def test_equal_weights_scale_distances(metric):
    skeleton = random_tree(0)
    X = random_poses(skeleton, n=4, scale=0.3)
    plain, heavy = (
        pose_distances(X, skeleton=s, metric=metric)
        for s in (skeleton, skeleton.with_weights([4.0] * skeleton.n_joints))
    )
    np.testing.assert_allclose(heavy, 2 * plain, rtol=1e-6 if metric == "geodesic" else 1e-13)


@pytest.mark.parametrize("metric", OF_POSITIONS)
def test_ones_are_the_default_to_the_last_bit(metric, skeleton):
    if any(bone.weight is not None for bone in skeleton.bones):
        pytest.skip("its weights are others")
    X = random_poses(skeleton, n=3, scale=0.3)
    plain, ones = (
        pose_distances(X, skeleton=s, metric=metric)
        for s in (skeleton, skeleton.with_weights([1.0] * skeleton.n_joints))
    )
    np.testing.assert_array_equal(ones, plain)


@pytest.mark.parametrize("metric", [*OF_POSITIONS, Spatial(2), Geodesic(2)], ids=str)
def test_what_has_no_weight_is_not_there(metric):
    skeleton = random_tree(5, n=14)
    dropped = skeleton.joint_names[4]
    part = skeleton.select(drop=dropped)
    assert part.n_dofs < skeleton.n_dofs
    unseen = skeleton.with_weights(dict.fromkeys(set(skeleton.joint_names) - set(part.joint_names), 0))
    X = random_poses(skeleton, n=4, scale=0.4)
    expected = pose_distances(X[:, part.columns_in(skeleton)], skeleton=part, metric=metric)
    np.testing.assert_array_equal(pose_distances(X, skeleton=unseen, metric=metric), expected)
    assert len(tree_of(unseen).column) == part.n_dofs  # and it costs nothing


def test_weights_of_joints_that_nothing_moves_make_all_distances_zero():
    skeleton = Skeleton([("still", None, (1, 0, 0)), ("moving", "still", (1, 0, 0), "z")]).with_weights({"moving": 0})
    for metric in OF_POSITIONS:
        np.testing.assert_array_equal(
            pose_distances([[0.0], [1.0]], skeleton=skeleton, metric=metric), np.zeros((2, 2))
        )
    assert geodesic([0.0], [1.0], skeleton).length == 0


def test_the_metric_tensor_is_weighted_and_the_jacobian_is_not(skeleton):
    poses = random_poses(skeleton, n=2)
    J, weights = position_jacobian(poses, skeleton), np.repeat(reference.weights(skeleton), 3)
    np.testing.assert_allclose(
        metric_tensor(poses, skeleton), np.einsum("nri,r,nrj->nij", J, weights, J), atol=1e-11 * np.abs(J).max() ** 2
    )


def test_unseen_columns_of_a_geodesic_follow_the_line(arm):
    seen = arm.with_weights({"elbow": 1, "wrist": 0, "tip": 0})
    start, end = np.array([0.1, 0.2, 0.3, 1.0]), np.array([0.5, -0.2, 0.8, 2.0])
    for wrap in (True, False):
        found = geodesic(start, end, seen, metric=Geodesic(wrap=wrap))
        np.testing.assert_allclose(found.path[:, 3], np.linspace(1.0, 2.0, len(found.path)), rtol=1e-14)
        np.testing.assert_allclose(found.path[[0, -1]], [start, end], atol=1e-12)
        np.testing.assert_allclose(found.length, reference.path_length(found.path, seen), rtol=1e-12)
    bound = Skeleton([arm.bones[0]._replace(limits=((-1, 1),) * 3), *arm.bones[1:]]).with_weights(
        {"wrist": 0, "tip": 0}
    )
    assert geodesic(start, end, bound, joint_limits="enforce").path.shape[1] == 4


@pytest.mark.parametrize("metric", ["position", "geodesic"])
def test_a_mean_minimises_weighted_distances(metric):
    skeleton = weighted(random_tree(6, n=8), 1)
    X = random_poses(skeleton, n=4, scale=0.15)
    mean = frechet_mean(X, skeleton, metric=metric)
    variance = np.square(pose_distances(mean.pose[None], X, skeleton=skeleton, metric=metric)).mean()
    np.testing.assert_allclose(mean.variance, variance, rtol=1e-4)
    for seed in range(6):
        near = mean.pose[None] + random_poses(skeleton, n=1, seed=seed, scale=0.02)
        assert np.square(pose_distances(near, X, skeleton=skeleton, metric=metric)).mean() > variance * (1 - 1e-6)


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


@pytest.mark.parametrize("name", SKELETONS)
def test_weights_by_the_places_in_random_poses(name):
    np.testing.assert_array_equal(SKELETONS[name].weights, reference.weights(SKELETONS[name]))


@pytest.mark.parametrize("offset_frame", ["own", "parent"])
@pytest.mark.parametrize("seed", range(20))
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

NAMES = {
    "ASF": (
        "lowerneck upperneck head lclavicle lhumerus lradius lwrist lhand lhipjoint lfemur ltibia lfoot ltoes",
        "own",
    ),
    "ours": ("", "own"),
    "SMPL": (
        "neck head left_collar left_shoulder left_elbow left_wrist left_hip left_knee left_ankle left_foot",
        "parent",
    ),
    "Mixamo": (
        "mixamorig:Neck mixamorig:Head mixamorig:LeftShoulder mixamorig:LeftArm mixamorig:LeftForeArm "
        "mixamorig:LeftHand mixamorig:LeftUpLeg mixamorig:LeftLeg mixamorig:LeftFoot mixamorig:LeftToeBase",
        "parent",
    ),
}


def test_mass_is_that_of_the_table():
    """Both sides of the table's sums, and the centre of mass of a person who stands."""
    np.testing.assert_allclose(HEAD.mass, 0.0681)
    np.testing.assert_allclose(TRUNK, 0.31195)
    limbs = 2 * sum(segment.mass for segment in (*ARM, *LEG))
    pelvis = (12.47 + 11.17) / 200
    np.testing.assert_allclose(HEAD.mass + TRUNK + limbs + pelvis, 1.0, atol=2e-3)  # the table is rounded


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


@pytest.mark.parametrize(("names", "offset_frame"), [pytest.param(*NAMES[k], id=k) for k in NAMES if k != "ours"])
def test_mass_finds_segments_by_the_names_in_use(names, offset_frame):
    *spine, collar = names.split()[: 3 + (offset_frame == "own")]
    arm, leg = (
        names.split()[len(spine) + 1 :][: 4 - (offset_frame == "parent")],
        names.split()[-4 - (offset_frame == "own") :],
    )
    bones = [Bone("spine", None, (0, 0.4, 0), "xyz")]
    for chain in (spine, [collar, *arm], leg):
        for side in ("left", "right") if chain is not spine else ("",):
            parent = None if chain is leg else "spine"
            for name in chain:
                if side == "right":
                    name = name.replace("left", "right").replace("Left", "Right")
                    name = "r" + name[1:] if name.startswith("l") and offset_frame == "own" else name
                bones.append(Bone(name, parent, (0.1, 0.2, 0), "xyz"))
                parent = name
    weights = Skeleton(bones, offset_frame).with_weights("mass").weights
    assert 0.7 < weights.sum() < 1.0


def test_mass_of_real_skeletons(cmu, hdm05):
    for dataset in (cmu, hdm05):
        weights = dict(zip(dataset.skeleton.joint_names, dataset.skeleton.with_weights("mass").weights, strict=True))
        assert weights["lfemur"] == weights["rfemur"] > weights["ltibia"] > weights["lfoot"] > weights["ltoes"] == 0
        assert weights["lthumb"] == weights["rfingers"] == 0


def test_two_heads_are_refused():
    skeleton = humanoid()
    two = Skeleton([*skeleton.bones, Bone("Head", "neck", (0, 0.1, 0))])
    with pytest.raises(
        ValueError, match=r"expected a head named head, got 'head', 'Head'\. Weigh the whole skeleton before"
    ):
        two.with_weights("mass")


def test_weights_of_files_are_those_of_their_skeleton():
    assert load_asf(DATA / "arm.asf").weights.min() == 1.0


def test_a_series_with_names_gives_its_weights_by_name(arm):
    """In any order; as a mapping it need not have all of them. One without names is an array."""
    np.testing.assert_array_equal(arm.with_weights(pd.Series({"tip": 3, "wrist": 2, "elbow": 1})).weights, [1, 2, 3])
    np.testing.assert_array_equal(arm.with_weights(pd.Series({"tip": 3})).weights, [1, 1, 3])
    np.testing.assert_array_equal(arm.with_weights(pd.Series([4, 5, 6])).weights, [4, 5, 6])
    with pytest.raises(ValueError, match="'writs', which no joint has"):
        arm.with_weights(pd.Series({"writs": 3}))


def test_a_bone_between_forearm_and_hand_belongs_to_the_forearm(tmp_path):
    """The hand begins where its own bone does, not where that of the forearm ends; in ASF files and in BVH."""
    bones = [
        bone._replace(parent=bone.parent.replace("forearm", "wrist")) if bone.name.endswith("_hand") else bone
        for bone in humanoid().bones
    ]
    skeleton = Skeleton([*bones, *((f"{s}_wrist", f"{s}_forearm", (0, -0.1, 0), "x") for s in ("left", "right"))])
    weight = dict(zip(skeleton.joint_names, skeleton.with_weights("mass").weights, strict=True))
    forearm, hand = ARM[1:]
    assert weight["left_forearm"] == 0
    assert weight["left_wrist"] == pytest.approx(forearm.mass * forearm.centre + hand.mass * (1 - hand.centre))
    motion = Motion(skeleton, random_poses(skeleton, scale=0.5), 30)
    save_bvh(tmp_path / "a.bvh", motion)
    read = load_bvh(tmp_path / "a.bvh")
    before, after = (
        pose_distances(one.angles, skeleton=one.skeleton.with_weights("mass"), metric="position")
        for one in (motion, read)
    )
    np.testing.assert_allclose(before, after, atol=1e-6)


@pytest.mark.parametrize("z", [0.5, 0.5000000005])
def test_joints_in_one_place_but_for_rounding_count_once(z):
    """Coordinates half-way between two that nine digits can write are no exception."""
    ends = [
        ("end_1", "arm", (0.1, 0.3, z)),
        ("end_2", "arm", (0.1, 0.3, z + 1e-12)),
        ("end_3", "arm", (0.1, 0.3, z - 1e-12)),
    ]
    skeleton = Skeleton([("arm", None, (1, 0, 0), "xyz"), *ends])
    np.testing.assert_array_equal(skeleton.weights, [1, 1, 0, 0])
    np.testing.assert_array_equal(skeleton.weights, reference.weights(skeleton))
