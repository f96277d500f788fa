import copy
import pickle

import numpy as np
import pytest

from skpose import Bone, Skeleton


def test_attributes_describe_the_bones():
    skeleton = Skeleton(
        [
            Bone("wrist", "elbow", (0.25, 0, 0), "YX", limits=((0, 1), (-2, 2))),
            Bone("elbow", None, (0.3, 0, 0), "xyz"),
            Bone("tip", "wrist", (0.1, 0, 0), rest_rotation=np.diag([-1.0, -1.0, 1.0])),
        ]
    )
    assert skeleton.joint_names == ("elbow", "wrist", "tip")  # a parent before its children
    assert skeleton.dof_names == ("elbow_rx", "elbow_ry", "elbow_rz", "wrist_ry", "wrist_rx")
    assert (skeleton.n_joints, skeleton.n_dofs) == (3, 5)
    np.testing.assert_array_equal(skeleton.parents, [-1, 0, 1])
    np.testing.assert_array_equal(skeleton.offsets[1], [0.25, 0, 0])
    np.testing.assert_array_equal(skeleton.rest_rotations[2], np.diag([-1, -1, 1]))
    np.testing.assert_array_equal(skeleton.limits[:3], [[-np.inf, np.inf]] * 3)
    np.testing.assert_array_equal(skeleton.limits[3:], [[0, 1], [-2, 2]])
    assert Skeleton.chain(2).limits is None


def test_is_immutable_hashable_and_equal_by_value(skeleton):
    again = Skeleton(skeleton.bones, skeleton.offset_frame)
    assert again == skeleton
    assert hash(again) == hash(skeleton)
    assert again != Skeleton.chain(7)
    with pytest.raises(AttributeError):
        skeleton.bones = ()
    with pytest.raises(ValueError, match="read-only"):
        skeleton.offsets[0] = 1.0
    assert copy.deepcopy(skeleton) == skeleton
    restored = pickle.loads(pickle.dumps(skeleton))
    assert restored == skeleton
    assert not restored.offsets.flags.writeable


@pytest.mark.parametrize(
    ("bones", "message"),
    [
        ([("a", "b", (1, 0, 0), "x"), ("b", "a", (1, 0, 0))], "'a' is a child of itself"),
        ([("a", "hip", (1, 0, 0), "x")], "'hip' of bone 'a'"),
        ([("a", None, (1, 0, 0), "x"), ("a", None, (1, 0, 0))], "its own name"),
        ([("a", None, (1, np.nan, 0), "x")], "'a': offset"),
        ([("a", None, (1, 0, 0), "xY")], "'a': dofs"),
        ([("a", None, (1, 0, 0), "x", np.diag([1, 1, -1]))], "'a': rest_rotation"),
        ([("a", None, (1, 0, 0), "x", None, [(1, 0)])], "'a': limits"),
        ([("a", None, (1, 0, 0))], "at least one bone with dofs"),
    ],
)
def test_error_names_the_bone(bones, message):
    with pytest.raises(ValueError, match=message):
        Skeleton(bones)


def test_mean_has_mean_lengths_and_mean_directions():
    a = Skeleton([Bone("a", None, (1, 0, 0), "xyz", limits=[(-1, 1)] * 3), Bone("b", "a", (0, 2, 0))])
    b = Skeleton([Bone("b", "a", (0, 4, 0)), Bone("a", None, (2.4, 1.8, 0), "xyz", limits=[(-2, 0.5)] * 3)])
    mean = Skeleton.mean([a, b])
    assert mean.joint_names == a.joint_names
    np.testing.assert_allclose(np.linalg.norm(mean.offsets, axis=1), [2, 3])
    np.testing.assert_allclose(mean.offsets[0], 2 * np.array([3, 1, 0]) / np.sqrt(10))
    np.testing.assert_array_equal(mean.limits, [[-2, 1]] * 3)
    assert Skeleton.mean([a]) == a
    assert Skeleton.mean([a, a, a]) == a


@pytest.mark.parametrize(
    ("other", "message"),
    [
        (Skeleton([Bone("a", None, (1, 0, 0), "y")]), "joint 'a' has dofs"),
        (Skeleton([Bone("a", None, (1, 0, 0), "x"), Bone("b", "a", (1, 0, 0))]), "only one of them has a joint 'b'"),
        (Skeleton([Bone("a", None, (1, 0, 0), "x")], "parent"), "offset frames"),
        (Skeleton([Bone("a", None, (-1, 0, 0), "x")]), "bone of 'a' by 180°"),
    ],
)
def test_error_for_skeletons_without_a_mean(other, message):
    with pytest.raises(ValueError, match=message):
        Skeleton.mean([Skeleton([Bone("a", None, (1, 0, 0), "x")]), other])
