"""`skpose angles`: the table of joint angles of a file."""

import csv

import numpy as np
import pytest

from skpose import Motion, forward_kinematics, inverse_kinematics
from skpose._cli.main import main
from skpose.biomechanics import joint_angles
from skpose.datasets import humanoid
from skpose.io import load_trc, save_npz
from skpose.keypoints import Keypoints, fit_skeleton, layouts


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


def write_trc(path, names, points=None):
    """Frames of markers; four, anywhere in a metre, are the default."""
    points = np.random.default_rng(0).uniform(size=(4, 3 * len(names))) if points is None else points
    head = ["PathFileType\t4\t(X/Y/Z)\twalk.trc", "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits"]
    head += [f"100\t100\t{len(points)}\t{len(names)}\tm", "Frame#\tTime\t" + "\t\t\t".join(names)]
    head += ["\t\t" + "\t".join(f"{axis}{i + 1}" for i in range(len(names)) for axis in "XYZ")]
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
    assert "which are not left out, as L_KJC, L_AJC, R_KJC, R_AJC are means of them: pass --zero FILE" in error
    assert "--layout opencap_mocap55, where FILE has them and the person stands" in error


COCO = {
    "shoulder": "clavicle",
    "elbow": "upper_arm",
    "wrist": "forearm",
    "hip": "pelvis",
    "knee": "thigh",
    "ankle": "shank",
}


def write_points(path, *missing):
    """Points of "coco17" of a person who stands and sways a little; without some of them."""
    skeleton = humanoid()
    poses = 0.05 * np.sin(np.arange(40) / 5)[:, None] * np.random.default_rng(0).normal(size=skeleton.n_dofs)
    positions = forward_kinematics(poses, skeleton)
    at = {f"{side}_{mark}": f"{side}_{joint}" for mark, joint in COCO.items() for side in ("left", "right")}
    points = {name: positions[:, skeleton.joint_names.index(joint)] for name, joint in at.items()}
    points |= {name: positions[:, 3] + [0.0, 0.0, 0.1 + 0.01 * len(name)] for name in ("nose", "left_eye", "right_eye")}
    names = [name for name in points if name not in missing]
    write_trc(path, names, np.concatenate([points[name] for name in names], axis=1))


@pytest.mark.filterwarnings("ignore")
def test_points_of_the_upper_part_that_a_file_lacks_are_left_out(tmp_path, capsys):
    """The angles are those of the layout without these points, in Python."""
    write_points(tmp_path / "points.trc", "left_eye")
    files = [str(tmp_path / "points.trc"), "--layout", "coco17", "--out", str(tmp_path / "a.csv")]
    assert main(["angles", *files]) == 0
    printed = capsys.readouterr().out
    missing = ["left_eye", "left_ear", "right_ear"]
    assert f"without {', '.join(missing)} of coco17, which {files[0]} lacks: they are on trunk, arms or head" in printed
    layout = layouts["coco17"].without(missing)
    named = layout.keypoints(load_trc(tmp_path / "points.trc"), absent="unseen")
    expected = joint_angles(inverse_kinematics(named, fit_skeleton(named, layout)).to_motion())
    with (tmp_path / "a.csv").open() as file:
        header, *rows = csv.reader(file)
    for name in ("knee_flexion_left", "elbow_flexion_left"):
        assert np.isfinite(expected[name]).all()
        np.testing.assert_allclose([float(row[header.index(name)]) for row in rows], expected[name], atol=1e-4)


@pytest.mark.parametrize(
    ("missing", "reason"),
    [
        ("left_ankle", "legs are not known without them"),
        ("left_hip", "pelvis is a mean of them"),
        ("right_shoulder", "neck is a mean of them"),
    ],
)
@pytest.mark.filterwarnings("ignore")
def test_points_that_legs_need_are_not_left_out(tmp_path, capsys, missing, reason):
    write_points(tmp_path / "points.trc", missing)
    files = [str(tmp_path / "points.trc"), "--layout", "coco17", "--out", str(tmp_path / "a.csv")]
    assert main(["angles", *files]) == 1
    assert f"which are not left out, as {reason}: pass --zero FILE" in capsys.readouterr().err
    assert not (tmp_path / "a.csv").exists()


def test_a_standing_file_that_is_not_there_is_that_of_zero(walk, tmp_path, capsys):
    out = ["--out", str(tmp_path / "a.csv")]
    assert main(["angles", str(tmp_path / "walk.npz"), "--zero", str(tmp_path / "zzz"), *out]) == 1
    assert (
        f"--zero is the number of a frame or a file, and there is no file {tmp_path / 'zzz'}" in capsys.readouterr().err
    )


@pytest.mark.filterwarnings("ignore")
def test_markers_of_legs_are_not_left_out(opensim_folder, tmp_path, capsys):
    """Clusters on the thigh show how it rotates; the markers of an arm do not count here."""
    text = (opensim_folder / "static1.trc").read_text().replace("r_thigh5", "other").replace("R_forearm", "another")
    (tmp_path / "static.trc").write_text(text)
    options = ["--layout", "opencap_mocap55", "--out", str(tmp_path / "a.csv")]
    assert main(["angles", str(tmp_path / "static.trc"), *options]) == 1
    assert "but for R_forearm, R_thigh5, which are not left out, as angles of legs rest on R_thigh5: " in (
        capsys.readouterr().err
    )


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
