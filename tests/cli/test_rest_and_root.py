"""The command line on files with different rest poses, and with the orientation of the root."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton, forward_kinematics
from skpose._cli.main import main
from skpose.io import load_bvh, save_bvh


@pytest.fixture
def files(tmp_path, monkeypatch):
    """An arm that is stretched to the side, from a rest pose that is the same, and from one with the arm down."""
    monkeypatch.chdir(tmp_path)
    for name, angle in (("t", 0), ("a", -60)):
        arm = [0.3 * np.cos(np.radians(angle)), 0.3 * np.sin(np.radians(angle)), 0]
        bones = [
            Bone("spine", None, (0, 0.5, 0), "ZXY"),
            Bone("arm", "spine", (0.2, 0, 0), "ZXY"),
            Bone("hand", "arm", arm),
        ]
        angles = np.zeros((2, 6))
        angles[1, 3] = np.radians(-angle)
        root_angles = np.radians([[0, 0, 0], [0, 90, 0]])  # standing, then lying
        motion = Motion(Skeleton(bones, "parent"), angles, 30, root_angles=root_angles, root_axes="ZXY")
        save_bvh(f"{name}.bvh", motion)
    return ["distances", "t.bvh", "a.bvh", "--metric", "position", "--out", "D.npy"]


def test_files_with_different_rest_poses(files, capsys):
    assert main(files) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "t.bvh and a.bvh have different rest poses: bone 'hand' points in directions that are 60°" in line
    assert "--retarget orientations keeps the directions" in line
    assert "--retarget unchecked the numbers" in line
    assert "motions[" not in line
    assert "dataset" not in line
    assert main([*files, "--retarget", "orientations"]) == 0
    expected = np.zeros((4, 4))
    expected[2, [0, 1, 3]] = expected[[0, 1, 3], 2] = 0.3  # all but one have the arm stretched, 60° away
    np.testing.assert_allclose(np.load("D.npy"), expected, atol=1e-8)


def test_the_orientation_of_the_root(files):
    for options, up in (
        (["--with-root", "tilt"], "y"),
        (["--with-root", "tilt", "--up", "z"], "z"),
        (["--with-root", "whole"], None),
    ):
        out = f"{up}.npy"
        assert main([*files[:-1], out, "--retarget", "unchecked", *options]) == 0
        positions = []
        for name in ("t", "a"):
            motion = load_bvh(f"{name}.bvh")
            R = Rotation.from_euler(motion.root_axes, motion.root_angles)
            if up == "z":  # the orientation is a rotation about x, horizontal in both
                np.testing.assert_allclose(R.as_rotvec()[:, 1:], 0.0, atol=1e-9)
            P = forward_kinematics(motion.angles, load_bvh("t.bvh").skeleton)
            positions.append(np.stack([R.apply(P[:, j]) for j in range(P.shape[1])], axis=1))
        P = np.concatenate(positions).reshape(4, -1)
        np.testing.assert_allclose(np.load(out), np.linalg.norm(P[:, None] - P, axis=-1), atol=1e-7)
