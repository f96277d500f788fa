"""`skpose angles`: the table of joint angles of a file."""

import csv

import numpy as np
import pytest

from skpose import Motion
from skpose._cli.main import main
from skpose.biomechanics import joint_angles
from skpose.datasets import humanoid
from skpose.io import save_npz
from skpose.keypoints import Keypoints, layouts


@pytest.fixture
def walk(tmp_path):
    skeleton = humanoid()
    rng = np.random.default_rng(0)
    poses = 0.2 * rng.normal(size=(6, skeleton.n_dofs))
    poses[0] = 0.0  # stands
    motion = Motion(skeleton, poses, 30)
    save_npz(tmp_path / "walk.npz", motion)
    return motion


def test_the_table_is_that_of_joint_angles(walk, tmp_path, capsys):
    assert main(["angles", str(tmp_path / "walk.npz"), "--out", str(tmp_path / "a.csv")]) == 0
    with (tmp_path / "a.csv").open() as file:
        header, *rows = csv.reader(file)
    expected = joint_angles(walk)
    assert header == ["time [s]", *expected.names]
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


def test_a_recording_that_does_not_stand_is_no_zero(walk, tmp_path, capsys):
    steps = np.zeros((20, walk.skeleton.n_dofs))
    for side, sign in (("left", 1), ("right", -1)):
        steps[:, walk.skeleton.dof_names.index(f"{side}_thigh_rx")] = sign * 0.5 * np.sin(np.arange(20))
    save_npz(tmp_path / "steps.npz", Motion(walk.skeleton, steps, 30))
    out = tmp_path / "b.csv"
    assert main(["angles", str(tmp_path / "walk.npz"), "--zero", str(tmp_path / "steps.npz"), "--out", str(out)]) == 1
    assert "nobody stands in zero, a recording of 20 frames: in a tenth of them at least its" in capsys.readouterr().err
    assert not out.exists()


def test_frames_are_numbered_from_zero(tmp_path, capsys):
    with pytest.raises(SystemExit):
        main(["angles", str(tmp_path / "walk.npz"), "--zero", "-1", "--out", str(tmp_path / "b.csv")])
    error = capsys.readouterr().err
    assert "argument --zero: frames are numbered from 0, got -1: pass 0 or more, or a file (./-1" in error


def write_trc(path, names):
    """Four frames of markers anywhere in a metre."""
    head = ["PathFileType\t4\t(X/Y/Z)\twalk.trc", "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits"]
    head += [f"100\t100\t4\t{len(names)}\tm", "Frame#\tTime\t" + "\t\t\t".join(names)]
    head += ["\t\t" + "\t".join(f"{axis}{i + 1}" for i in range(len(names)) for axis in "XYZ")]
    points = np.random.default_rng(0).uniform(size=(4, 3 * len(names)))
    rows = ["\t".join([str(i + 1), str(i / 100), *(f"{x:.4f}" for x in row)]) for i, row in enumerate(points)]
    path.write_text("\n".join([*head, *rows]) + "\n")


@pytest.mark.parametrize("options", [[], ["--layout", "opencap_mocap55"]])
def test_markers_that_a_file_lacks_are_named(tmp_path, capsys, options):
    """Medial markers are often in the standing trial alone."""
    names = [name for name in layouts["opencap_mocap55"].names if "mknee" not in name and "mankle" not in name]
    write_trc(tmp_path / "walk.trc", names)
    assert main(["angles", str(tmp_path / "walk.trc"), "--out", str(tmp_path / "b.csv"), *options]) == 1
    error = capsys.readouterr().err
    near = "" if options else "the nearest layout, "
    assert f"has the points of {near}opencap_mocap55, but for L_mankle, L_mknee, R_mankle, R_mknee" in error
    assert "pass --zero FILE --layout opencap_mocap55, where FILE has them and the person stands" in error


@pytest.mark.slow
@pytest.mark.filterwarnings("default:zero is how the person of the layout:UserWarning")
def test_markers_without_zero_are_a_warning(opensim_folder, tmp_path, capsys):
    options = ["--layout", "opencap_mocap55", "--out", str(tmp_path / "a.csv")]
    assert main(["angles", str(opensim_folder / "static1.trc"), *options]) == 0
    assert "zero is how the person of the layout stands" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.filterwarnings("default:in zero, mean of 517 standing frames:UserWarning")
def test_markers_with_zero_from_the_standing_trial(opensim_folder, tmp_path, capsys):
    files = (str(opensim_folder / name) for name in ("squats1.trc", "static1.trc"))
    squats, standing = files
    assert main(["angles", squats, "--zero", standing, "--out", str(tmp_path / "a.csv")]) == 0
    printed = capsys.readouterr()
    assert "mean of 517 standing frames, names of opencap_mocap55" in printed.out
    assert "its right elbow is bent by 35°" in printed.err
    assert "Where the person stands straighter, pass --zero of that" in printed.err
