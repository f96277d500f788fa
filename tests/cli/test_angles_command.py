"""`skpose angles`: the table of joint angles of a file."""

import csv

import numpy as np
import pytest

from skpose import Motion
from skpose._cli.main import main
from skpose.biomechanics import joint_angles
from skpose.datasets import humanoid
from skpose.io import save_npz
from skpose.keypoints import Keypoints


@pytest.fixture
def walk(tmp_path):
    skeleton = humanoid()
    rng = np.random.default_rng(0)
    motion = Motion(skeleton, 0.2 * rng.normal(size=(6, skeleton.n_dofs)), 30)
    save_npz(tmp_path / "walk.npz", motion)
    return motion


def test_the_table_is_that_of_joint_angles(walk, tmp_path, capsys):
    assert main(["angles", str(tmp_path / "walk.npz"), "--out", str(tmp_path / "a.csv")]) == 0
    with (tmp_path / "a.csv").open() as file:
        header, *rows = csv.reader(file)
    expected = joint_angles(walk)
    assert header == ["time", *expected.names]
    numbers = np.array([[float(cell or "nan") for cell in row] for row in rows])
    np.testing.assert_allclose(numbers[:, 0], walk.times, atol=1e-5)
    np.testing.assert_allclose(numbers[:, 1:], expected.degrees, atol=1e-4)
    printed = capsys.readouterr().out
    assert f"{len(expected.names)} angles in degrees, 6 frames, zero: rest pose, names of humanoid" in printed
    assert "as no thumb next to the line of the hand shows where the palm is: elbow_pronation_left" in printed


def test_zero_is_a_frame_or_a_file(walk, tmp_path, capsys):
    save_npz(tmp_path / "still.npz", Motion(walk.skeleton, np.zeros((3, walk.skeleton.n_dofs)), 30))
    for zero, words in (("0", "frame 0"), (str(tmp_path / "still.npz"), "mean of 3 standing frames")):
        out = tmp_path / f"{words[:4].strip()}.csv"
        assert main(["angles", str(tmp_path / "walk.npz"), "--zero", zero, "--out", str(out)]) == 0
        assert words in capsys.readouterr().out
    assert main(["angles", str(tmp_path / "walk.npz"), "--zero", "9", "--out", str(tmp_path / "b.csv")]) == 1
    assert "zero is frame 9 of a motion of 6 frames" in capsys.readouterr().err
    assert not (tmp_path / "b.csv").exists()


def test_points_of_no_layout_and_mixed_files_are_refused(walk, tmp_path, capsys):
    points = Keypoints(np.random.default_rng(0).normal(size=(4, 3, 3)), ["a", "b", "c"], 30)
    save_npz(tmp_path / "points.npz", points)
    out = ["--out", str(tmp_path / "c.csv")]
    assert main(["angles", str(tmp_path / "points.npz"), *out]) == 1
    assert "are those of no layout that the library knows: pass --layout" in capsys.readouterr().err
    assert main(["angles", str(tmp_path / "walk.npz"), "--zero", str(tmp_path / "points.npz"), *out]) == 1
    assert "one is a motion, and the other has markers or keypoints" in capsys.readouterr().err


@pytest.mark.slow
def test_markers_with_zero_from_the_standing_trial(opensim_folder, tmp_path, capsys):
    files = (str(opensim_folder / name) for name in ("squats1.trc", "static1.trc"))
    squats, standing = files
    assert main(["angles", squats, "--zero", standing, "--out", str(tmp_path / "a.csv")]) == 0
    assert "mean of 517 standing frames, names of opencap_mocap55" in capsys.readouterr().out
