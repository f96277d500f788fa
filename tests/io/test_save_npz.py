"""Motions and keypoints as .npz files of this library: what is written is read again, to the last bit."""

import io
from dataclasses import replace

import numpy as np
import pytest
from conftest import SKELETONS, random_tree, weighted

from skpose import Bone, Keypoints, Motion, Skeleton
from skpose.io import load_keypoints, load_motion, save_npz

LIMITED = Skeleton(
    [
        Bone("elbow", None, (0.3, 0, 0), "xyz", limits=((-1.0, 1.0), (-np.inf, 2.0), (0.0, np.inf))),
        Bone("wrist", "elbow", (0.25, 0, 0), "y", rest_rotation=np.eye(3), weight=0.0),
        Bone("hand “left”, 2", "wrist", (0.1, 0, 0), "rotvec", weight=2.0),
    ]
)


def moved(skeleton, n_frames=4, **more):
    """Return a motion of the skeleton in which everything moves, and frames are missing."""
    rng = np.random.default_rng(0)
    root = {"root_positions": rng.normal(size=(n_frames, 3)), "root_angles": rng.normal(size=(n_frames, 2))}
    given = {"root_axes": "ZX", "frame_numbers": [3, 4, 9, 10][:n_frames], "up": "z", "root_name": "Hips"}
    return Motion(skeleton, rng.uniform(-3, 3, (n_frames, skeleton.n_dofs)), 29.97, **root, **given | more)


def assert_same(one, other):
    """Check that two motions are equal in all that they have, to the last bit."""
    assert one.skeleton == other.skeleton
    for name in ("frame_rate", "root_axes", "up", "root_name"):
        assert getattr(one, name) == getattr(other, name)
    for name in ("angles", "root_positions", "root_angles", "frame_numbers"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize("skeleton", [SKELETONS["mixed joints"], LIMITED, weighted(random_tree(9), 1)])
def test_motions_are_read_as_they_were(skeleton, tmp_path):
    motion = moved(skeleton)
    save_npz(tmp_path / "a.npz", motion)
    assert_same(load_motion(tmp_path / "a.npz"), motion)
    assert_same(load_motion(io.BytesIO((tmp_path / "a.npz").read_bytes())), motion)


@pytest.mark.parametrize("more", [{"n_frames": 0}, {"n_frames": 1, "root_axes": "xy", "up": "x"}])
def test_few_frames(more, tmp_path):
    motion = moved(LIMITED, **more)
    save_npz(tmp_path / "a", motion)  # a name without a suffix stays as it is
    assert_same(load_motion(tmp_path / "a"), motion)
    motion = replace(motion, root_axes="", root_angles=None)
    save_npz(tmp_path / "b", motion)
    assert_same(load_motion(tmp_path / "b"), motion)


def test_keypoints_are_read_as_they_were(tmp_path):
    rng = np.random.default_rng(0)
    positions, sure = rng.normal(size=(5, 3, 3)), rng.uniform(0.2, 1.0, (5, 3))
    positions[2, 1] = np.nan
    seen = Keypoints(positions, ["hip", "left knee", "2"], 29.97, sure, up="z")
    save_npz(tmp_path / "a.npz", seen)
    again = load_keypoints(tmp_path / "a.npz")
    np.testing.assert_array_equal(again.positions, seen.positions)
    np.testing.assert_array_equal(again.confidences, seen.confidences)
    assert (again.names, again.frame_rate, again.up) == (seen.names, seen.frame_rate, seen.up)
    assert load_keypoints(tmp_path / "a.npz", up="x").up == "x"


def test_what_could_not_be_read_is_refused(tmp_path):
    chain = Skeleton.chain(1)
    with pytest.raises(ValueError, match="frame_numbers"):
        save_npz(tmp_path / "a.npz", Motion(chain, np.zeros((2, 1)), 30, frame_numbers=[0, 2**53]))
    with pytest.raises(ValueError, match="name"):
        Keypoints(np.zeros((1, 1, 3)), ["a\0"], 30)
    with pytest.raises(ValueError, match="name"):
        Skeleton([("a\0", None, (1, 0, 0), "x")])
