"""Commands that write motions: `skpose mean`, `between`, `retarget` and `convert`."""

import io
import os
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import damaged
import numpy as np
import pandas
import pytest
import robot_of_hinges
from conftest import DATA, in_space

from skpose import Bone, Motion, Skeleton
from skpose._cli.main import main
from skpose.datasets import MotionDataset, make_gait
from skpose.geodesics import interpolate
from skpose.io import load_amc, load_bvh, load_c3d, load_keypoints, load_motion, load_trc, save_bvh, save_npz
from skpose.kinematics import retarget
from skpose.motions import mean_motion
from skpose.robots import retarget_to_robot

FILES = ["a.bvh", "b.bvh", "c.bvh"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Files of three motions of different lengths, of two people."""
    monkeypatch.chdir(tmp_path)
    gait = make_gait(n_subjects=2, n_sequences=1, duration=1.0, frame_rate=20, random_state=0)
    for name, motion, n_frames in zip(FILES, gait.motions[1:], (20, 14, 17), strict=True):
        there = np.linspace([0, 1, 0], [1, 1, 2], n_frames)
        save_bvh(name, replace(motion[:n_frames], root_positions=there), scale=1.0)
    return tmp_path


@pytest.fixture
def motions():
    return [load_bvh(name, scale=1.0) for name in FILES]


def refusal(arguments, capsys, status=1):
    """Run a command that must fail and write nothing; return its last line on stderr."""
    before = sorted(os.listdir())
    if status == 2:
        with pytest.raises(SystemExit) as stop:
            main(arguments)
        assert stop.value.code == 2
    else:
        assert main(arguments) == status
    assert sorted(os.listdir()) == before
    return capsys.readouterr().err.splitlines()[-1]


def assert_close(one, other, atol=1e-12):
    np.testing.assert_allclose(in_space(one), in_space(other), rtol=0, atol=atol)
    assert (one.frame_rate, one.up) == (pytest.approx(other.frame_rate), other.up)


# --- skpose mean -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "parameters"),
    [
        ([], {}),
        (["--frames", "12", "--window", "0.3"], {"n_frames": 12, "window": 0.3}),
        (["--jobs", "1", "--metric", "position"], {}),
    ],
    ids=str,
)
def test_mean(motions, options, parameters, capsys):
    assert main(["mean", *FILES, "--out", "mean.npz", *options]) == 0
    expected = mean_motion(MotionDataset(motions), **parameters)
    found = load_motion("mean.npz")
    np.testing.assert_array_equal(found.angles, expected.poses)
    assert_close(found, expected.to_motion())
    counted, deviation, written = capsys.readouterr().out.splitlines()
    assert counted.startswith("mean of 3 motions, converged in ")
    joints = np.sqrt(np.mean(expected.joint_std**2, axis=0))
    worst = expected.skeleton.joint_names[joints.argmax()]
    assert deviation.endswith(f"by position; of a joint at most {joints.max():.3g} m, of {worst}")
    rate = expected.frame_rate
    assert written == (
        f"mean.npz: {len(expected)} frames at {rate:g} Hz, {len(expected) / rate:.2f} s, y up, 27 joints besides the "
        "root, 66 degrees of freedom"
    )


@pytest.mark.filterwarnings("ignore:the cycle ends:UserWarning")
@pytest.mark.filterwarnings("ignore:the joints jump:UserWarning")
def test_a_mean_as_a_cycle(motions, capsys):
    mean = mean_motion(MotionDataset(motions)).to_motion()
    for options, endpoint in (([], False), (["--endpoint"], True)):
        out = f"{endpoint}.npz"
        assert main(["mean", *FILES, "--cycle", *options, "--out", out]) == 0
        assert_close(load_motion(out), mean.to_cycle(endpoint=endpoint))
    assert refusal(["mean", *FILES, "--endpoint", "--out", "m.bvh"], capsys, 2).endswith("is of --cycle: pass both")


def test_a_mean_with_the_root_in_the_poses_gives_it_back(motions):
    assert main(["mean", *FILES, "--with-root", "tilt", "--out", "mean.npz"]) == 0
    expected = mean_motion(MotionDataset(motions).with_root("tilt")).to_motion().without_root()
    found = load_motion("mean.npz")
    assert found.skeleton.joint_names == motions[0].skeleton.joint_names
    assert_close(found, expected)


def test_errors_of_mean(motions, capsys):
    assert refusal(["mean", "a.bvh", "--out", "m.bvh"], capsys).startswith(
        "skpose: a mean is of two motions or more, and a.bvh is one"
    )
    save_bvh("fast.bvh", replace(motions[0], frame_rate=40.0), scale=1.0)
    assert "resample all with --frame-rate, such as --frame-rate 20" in refusal(
        ["mean", *FILES, "fast.bvh", "--out", "m.bvh"], capsys
    )
    save_npz("z.npz", replace(motions[0], up="z"))
    line = refusal(["mean", *FILES, "z.npz", "--out", "m.bvh"], capsys)
    assert "z.npz" in line
    assert "motions[" not in line
    assert main(["mean", *FILES, "none.bvh", "--skip-errors", "--out", "m.bvh"]) == 3
    assert "none.bvh" in capsys.readouterr().err


# --- skpose between --------------------------------------------------------------------------------------------------


def keys_of(motion, rows, seconds=None):
    times = motion.times[rows] if seconds is None else np.arange(len(rows)) * seconds
    fields = {name: getattr(motion, name)[rows] for name in ("angles", "root_positions", "root_angles")}
    return replace(motion, **fields, frame_numbers=None), times


@pytest.mark.parametrize("chosen", [["--frames", "2,9,-1"], ["--times", "0.11,0.44,0.95"]])
@pytest.mark.parametrize("method", ["spline", "geodesic"])
def test_between_frames_of_a_file(chosen, method, motions, capsys):
    assert main(["between", "a.bvh", *chosen, "--method", method, "--out", "m.npz"]) == 0
    keys, times = keys_of(motions[0], [2, 9, 19])
    expected = interpolate(keys, times, frame_rate=20, method=method)
    found = load_motion("m.npz")
    assert len(found) == 18
    assert_close(found, expected)
    np.testing.assert_array_equal(found.root_positions[[0, 7, 17]], keys.root_positions)
    title, *rows, _ = capsys.readouterr().out.splitlines()
    assert title.split() == ["key", "file", "frame", "its", "time,", "s", "time,", "s"]
    assert [row.split() for row in rows] == [
        ["0", "a.bvh", "2", "0.100", "0.000"],
        ["1", "a.bvh", "9", "0.450", "0.350"],
        ["2", "a.bvh", "19", "0.950", "0.850"],
    ]


def test_between_in_any_order_at_another_pace_and_rate(motions):
    command = ["between", "a.bvh", "--frames", "9,2,9", "--seconds", "0.5", "--frame-rate", "40", "--out", "m.npz"]
    assert main(command) == 0
    keys, times = keys_of(motions[0], [9, 2, 9], seconds=0.5)
    assert_close(load_motion("m.npz"), interpolate(keys, times, frame_rate=40))


def test_between_files(motions):
    assert main(["between", "a.bvh", "c.bvh", "--frames", "3,5", "--seconds", "1", "--out", "m.npz"]) == 0
    dataset = MotionDataset([motions[0], motions[2]])
    one, other = dataset.retarget(dataset.skeleton)
    expected = interpolate(Motion.concatenate([one[3], other[5]]), [0.0, 1.0], frame_rate=20)
    assert_close(load_motion("m.npz"), expected)
    assert len(expected) == 21


def test_between_files_whose_roots_have_other_axes(motions):
    motion = motions[0]
    angles = np.random.default_rng(0).uniform(-1, 1, (len(motion), 3))
    save_npz("x.npz", replace(motion, root_angles=angles, root_axes="ZYX"))
    save_npz("y.npz", replace(motion, root_angles=angles[:, :1], root_axes="y"))
    assert main(["between", "x.npz", "y.npz", "--frames", "3,5", "--seconds", "1", "--out", "m.npz"]) == 0
    found = load_motion("m.npz")
    np.testing.assert_allclose(in_space(found)[0], in_space(load_motion("x.npz"))[3], rtol=0, atol=1e-9)
    np.testing.assert_allclose(in_space(found)[-1], in_space(load_motion("y.npz"))[5], rtol=0, atol=1e-9)


def test_between_with_the_root_in_the_poses_gives_it_back(motions):
    assert main(["between", "a.bvh", "--frames", "0,9", "--with-root", "tilt", "--out", "m.npz"]) == 0
    found = load_motion("m.npz")
    assert found.skeleton.joint_names == motions[0].skeleton.joint_names
    np.testing.assert_allclose(in_space(found)[[0, -1]], in_space(motions[0])[[0, 9]], rtol=0, atol=1e-9)


@pytest.mark.filterwarnings("ignore:gap.bvh. 1 of 20 frames:UserWarning")
def test_frames_that_are_left_out_are_no_keys(capsys):
    lines = Path("a.bvh").read_text().splitlines()
    lines[-17] = lines[-17].replace(lines[-17].split()[0], "nan", 1)  # frame 3 of 20
    Path("gap.bvh").write_text("\n".join(lines))
    command = ["between", "gap.bvh", "--on-nan", "drop", "--out", "m.npz"]
    assert refusal([*command, "--frames", "0,3"], capsys).endswith(
        "gap.bvh has frames 0 to 19 without some that are left out, and no frame 3"
    )
    assert main([*command, "--frames", "0,4"]) == 0
    assert len(load_motion("m.npz")) == 5


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["a.bvh", "--frames", "3"], 1, "--frames has 1 key pose: pass two or more, with commas between them"),
        (["a.bvh", "--frames", "3,20"], 1, "a.bvh has frames 0 to 19, and no frame 20"),
        (["a.bvh", "--frames", "3,-21"], 1, "a.bvh has frames 0 to 19, and no frame -21"),
        (["a.bvh", "--frames", "9,3"], 1, "must follow each other in time: sort them, or pass --seconds"),
        (["a.bvh", "--times", "0,1.2"], 1, "a.bvh has its last frame at 0.95 s, and no pose at 1.2 s"),
        (["a.bvh", "b.bvh", "--frames", "3,4"], 1, "of several files have no times that go together: pass --seconds"),
        (["a.bvh", "b.bvh", "--times", "0", "--seconds", "1"], 1, "--times has 1 key pose"),
        (["a.bvh", "b.bvh", "--frames", "1,2,3", "--seconds", "1"], 1, "3 key poses for 2 files: pass one for each"),
        ([".", "--frames", "1,2", "--seconds", "1"], 1, "2 key poses for 3 files"),
        (["none.bvh", "--frames", "1,2"], 1, "none.bvh"),
        (["a.bvh", "--frames", "1,x"], 2, "argument --frames: expected frames, such as 10,50,90, got '1,x'"),
        (["a.bvh", "--times", "1,-2"], 2, "argument --times: expected times, such as 0.5,1.2,3, got '1,-2'"),
        (["a.bvh"], 2, "one of the arguments --frames --times is required"),
    ],
    ids=str,
)
def test_errors_of_between(arguments, status, message, capsys):
    assert message in refusal(["between", *arguments, "--out", "m.bvh"], capsys, status)


def test_poses_of_different_worlds_are_refused(motions, capsys):
    save_npz("z.npz", replace(motions[0], up="z"))
    line = refusal(["between", "a.bvh", "z.npz", "--frames", "0,0", "--seconds", "1", "--out", "m.npz"], capsys)
    assert "a.bvh has y up and z.npz z: pass --up if both are in one world" in line


# --- skpose retarget -------------------------------------------------------------------------------------------------


def save_arm(name, names=("elbow", "wrist"), dofs="xyz", n_frames=5):
    """Write a motion of an arm of two bones along x."""
    upper, lower = names
    skeleton = Skeleton([Bone(upper, None, (0.3, 0, 0), dofs), Bone(lower, upper, (0.25, 0, 0), dofs)])
    angles = np.random.default_rng(0).uniform(-1, 1, (n_frames, skeleton.n_dofs))
    motion = Motion(skeleton, angles, 20, np.ones((n_frames, 3)))
    save_npz(name, motion)
    return motion


@pytest.mark.filterwarnings("ignore")
def test_retarget_prints_the_report_and_writes_the_motion(motions, capsys):
    motion, other = save_arm("arm.npz"), save_arm("other.npz", dofs="rotvec")
    assert main(["retarget", "arm.npz", "--onto", "other.npz"]) == 0
    assert capsys.readouterr().out.splitlines() == ["arm.npz: by orientations, 2 of 2 joints, directions within 0°"]
    assert sorted(os.listdir()) == sorted([*FILES, "arm.npz", "other.npz"])
    assert main(["retarget", "arm.npz", "--onto", "other.npz", "--out", "there.npz", "--factor", "2"]) == 0
    found = load_motion("there.npz")
    assert found.skeleton == other.skeleton
    assert_close(found, retarget(motion, other.skeleton, method="orientations", scale=2.0))
    assert main(["retarget", *FILES, "--onto", "a.bvh"]) == 0
    assert capsys.readouterr().out.splitlines()[2:] == [f"{name}: by same numbers" for name in FILES]


@pytest.mark.filterwarnings("ignore")
def test_counterparts_are_given_or_refused(capsys):
    motion, other = save_arm("arm.npz"), save_arm("other.npz", ("upper", "lower"), "rotvec")
    command = ["retarget", "arm.npz", "--onto", "other.npz"]
    line = refusal(command, capsys)
    assert "have no name of a joint in common: pass --joints, a mapping of joints of OTHER" in line
    assert main([*command, "--joints", "upper=elbow", "lower=wrist", "--out", "there.npz"]) == 0
    pairs = {"upper": "elbow", "lower": "wrist"}
    assert_close(load_motion("there.npz"), retarget(motion, other.skeleton, method="auto", joints=pairs))
    capsys.readouterr()
    assert main([*command, "--joints", "upper=elbow"]) == 0
    assert capsys.readouterr().out.splitlines()[1] == "    without a counterpart: lower"
    line = refusal([*command, "--joints", "upper=elbow", "lower=hand"], capsys)
    assert "--joints maps 'lower' to 'hand', but FILE has no 'hand': skpose info prints its joints" in line
    assert "arm.npz: " in line
    line = refusal([*command, "--joints", "arm=elbow", "lower=hand"], capsys)
    assert "--joints maps 'arm' to 'elbow', but OTHER has no 'arm': skpose info prints its joints" in line
    line = refusal([*command, "--joints", "upper=elbow", "--method", "numbers"], capsys, 2)
    assert line.endswith("--joints is for --method auto, orientations or positions, not numbers")
    line = refusal([*command, "--joints", "upper"], capsys, 2)
    assert line.endswith("expected a joint of OTHER and its joint in FILE, such as a=b, got 'upper'")


@pytest.mark.filterwarnings("ignore")
def test_the_remedies_of_retarget_are_its_options(capsys):
    save_arm("arm.npz")
    save_arm("other.npz", dofs="x")
    line = refusal(["retarget", "arm.npz", "--onto", "other.npz", "--method", "numbers"], capsys)
    assert "--method orientations converts between rigs" in line
    assert "--retarget" not in line
    assert "--factor: invalid positive number or lengths value: 'x'" in refusal(
        ["retarget", "arm.npz", "--onto", "other.npz", "--factor", "x"], capsys, 2
    )


def test_files_of_retarget(capsys):
    assert refusal(["retarget", *FILES, "--onto", "a.bvh", "--out", "m.bvh"], capsys, 2).endswith(
        "--out is for one motion, got 3 files: leave --out out to compare the reports"
    )
    assert "OTHER must be one file, and . is a folder" in refusal(["retarget", "a.bvh", "--onto", "."], capsys)
    assert "none.asf" in refusal(["retarget", "a.bvh", "--onto", "none.asf", "--skip-errors"], capsys)
    assert "none.bvh" in refusal(["retarget", "none.bvh", "--onto", "a.bvh"], capsys)
    assert main(["retarget", "none.bvh", "b.bvh", "--onto", "a.bvh", "--skip-errors"]) == 3
    assert capsys.readouterr().out.splitlines() == ["b.bvh: by same numbers"]
    Path("walk.trc").write_bytes(damaged.FILES["TRC"][0])
    assert "walk.trc has positions of points, and no skeleton" in refusal(
        ["retarget", "a.bvh", "--onto", "walk.trc"], capsys
    )
    amc, asf = str(DATA / "arm.amc"), str(DATA / "arm.asf")
    assert main(["retarget", amc, "--onto", asf, "--amc-frame-rate", "60"]) == 0
    assert capsys.readouterr().out == f"{amc}: by same numbers\n"


def test_retarget_onto_a_robot(capsys):
    skeleton, (motion, _) = robot_of_hinges.robot(), robot_of_hinges.walk()
    save_npz("walk.npz", motion)
    save_npz("robot.npz", Motion(skeleton, np.zeros((1, skeleton.n_dofs)), 30.0, up="z"))
    joints = robot_of_hinges.counterparts(skeleton)
    pairs = [f"{ours}={theirs}" for ours, theirs in joints.items()]
    command = ["retarget", "walk.npz", "--onto", "robot.npz", "--method", "limbs", "--joints", *pairs]
    assert main([*command, "--out", "there.npz"]) == 0
    line, _ = capsys.readouterr().out.splitlines()
    assert line.startswith("walk.npz: by limbs, ")
    assert_close(load_motion("there.npz"), retarget_to_robot(motion, skeleton, joints=joints))


# --- skpose convert --------------------------------------------------------------------------------------------------


def test_convert_from_format_to_format(motions, capsys):
    assert main(["convert", "a.bvh", "--out", "a.npz"]) == 0
    found = load_motion("a.npz")
    assert found.skeleton == motions[0].skeleton
    np.testing.assert_array_equal(found.angles, motions[0].angles)
    assert main(["convert", "a.npz", "--out", "again.bvh"]) == 0
    save_bvh("expected.bvh", motions[0])
    assert Path("again.bvh").read_text() == Path("expected.bvh").read_text()
    assert main(["convert", "a.npz", "--out", "a.csv", "--rotations", "rotvec", "--frame-rate", "10"]) == 0
    expected = motions[0].to_rotvec().resample(10)
    np.testing.assert_array_equal(pandas.read_csv("a.csv")[list(expected.skeleton.dof_names)], expected.angles)
    assert [line.partition(",")[0] for line in capsys.readouterr().out.splitlines()] == [
        "a.npz: 20 frames at 20 Hz",
        "again.bvh: 20 frames at 20 Hz",
        "a.csv: 10 frames at 10 Hz",
    ]


def test_convert_says_which_units_a_table_has_and_what_a_bvh_file_does_not_state(motions, capsys):
    save_npz("fitted.npz", replace(motions[0], seen=True))
    assert main(["convert", "fitted.npz", "--out", "m.csv"]) == 0
    assert capsys.readouterr().out.endswith("; positions in m, angles in rad\n")
    assert main(["convert", "fitted.npz", "--out", "m.bvh"]) == 0
    assert "do not state that poses were fitted to positions" in capsys.readouterr().out
    assert main(["convert", "m.bvh", "--out", "again.bvh"]) == 0
    assert "fitted" not in capsys.readouterr().out


def test_a_bvh_file_says_how_it_is_read_again(motions, capsys):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        save_npz("m.npz", motions[0])
        assert main(["convert", "m.npz", "--out-scale", "0.01", "--out", "m.bvh"]) == 0
        line = capsys.readouterr().out.splitlines()[-1]
        assert line.endswith("BVH files do not state their unit; to read it again pass --scale 0.01")
        assert main(["convert", "m.bvh", *line.split()[-2:], "--out", "again.npz"]) == 0
    assert_close(load_motion("again.npz"), load_motion("m.npz"), atol=1e-8)


def test_convert_an_amc_file():
    amc = str(DATA / "arm.amc")
    assert main(["convert", amc, "--amc-frame-rate", "60", "--out", "a.npz"]) == 0
    motion = load_amc(amc, DATA / "arm.asf", frame_rate=60)
    found = load_motion("a.npz")
    assert found.skeleton == motion.skeleton
    np.testing.assert_array_equal(found.angles, motion.angles)


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
@pytest.mark.parametrize("kind", ["TRC", "C3D"])
def test_convert_markers(kind, suffix, capsys):
    name = f"walk.{kind.lower()}"
    Path(name).write_bytes(damaged.FILES[kind][0])
    assert main(["convert", name, "--out", f"m{suffix}"]) == 0
    expected = {"TRC": load_trc, "C3D": load_c3d}[kind](name)
    found = load_keypoints(f"m{suffix}")
    np.testing.assert_array_equal(found.positions, expected.positions)
    assert (found.names, found.frame_rate, found.up) == (expected.names, expected.frame_rate, expected.up)
    unit = "; positions in m" if suffix == ".csv" else ""
    assert f"m{suffix}: 20 frames at 100 Hz, 0.20 s, {expected.up} up, 3 points{unit}\n" in capsys.readouterr().out
    assert main(["info", f"m{suffix}"]) == 0
    assert f"3 points, {expected.up} is up" in capsys.readouterr().out
    other = {".npz": ".csv", ".csv": ".npz"}[suffix]
    assert main(["convert", f"m{suffix}", "--out", f"n{other}"]) == 0
    np.testing.assert_array_equal(load_keypoints(f"n{other}").positions, expected.positions)


@pytest.mark.filterwarnings("ignore:.* m from end to end in the median frame:UserWarning")
@pytest.mark.filterwarnings("ignore:.* are exactly .0, 0, 0.:UserWarning")
@pytest.mark.parametrize("kind", ["JSON", "CSV", "NPY"])
def test_convert_keypoints(kind, capsys):
    Path("k").write_bytes(damaged.FILES[kind][0])
    command = ["convert", "k", "--scale", "0.001", "--out", "m.npz"]
    assert "does not state its frame rate: pass --file-frame-rate, in Hz" in refusal(command, capsys)
    command += ["--file-frame-rate", "25"]
    if kind != "CSV":
        assert "does not name its points: pass --layout, or --names, one for each" in refusal(command, capsys)
        command += ["--names", "hip, knee,ankle"]
    assert main(command) == 0
    names = None if kind == "CSV" else damaged.NAMES
    expected = load_keypoints("k", names=names, frame_rate=25, scale=0.001)
    np.testing.assert_array_equal(load_keypoints("m.npz").positions, expected.positions)
    assert load_keypoints("m.npz").names == ("hip", "knee", "ankle")


def test_convert_standard_input(monkeypatch, capsys):
    for content, out in ((Path("a.bvh").read_bytes(), "a.npz"), (damaged.FILES["C3D"][0], "m.npz")):
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(content)))
        assert main(["convert", "-", "--out", out]) == 0
    assert capsys.readouterr().out.count("frames at") == 2
    np.testing.assert_array_equal(load_motion("a.npz").angles, load_bvh("a.bvh").angles)


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["none.bvh", "--out", "m.npz"], 1, "none.bvh"),
        ([".", "--out", "m.npz"], 1, "FILE must be one file, and . is a folder: choose a file in it"),
        (
            [str(DATA / "arm.asf"), "--out", "m.npz"],
            1,
            "is a skeleton (ASF or a robot), which has no motion: pass a motion, such as its AMC file",
        ),
        (["walk.trc", "--out", "m.bvh"], 1, "m.bvh: these are positions of points without a skeleton"),
        (["walk.trc", "--frame-rate", "9", "--out", "m.npz"], 1, "--frame-rate is for motions, and walk.trc has pos"),
        (["walk.trc", "--rotations", "rotvec", "--out", "m.csv"], 1, "--rotations is for motions, and walk.trc has p"),
        (["a.bvh", "--out", "a.bvh"], 1, "a.bvh already exists: delete it or choose another file"),
        (["a.bvh", "b.bvh", "--out", "m.npz"], 2, "unrecognized arguments: b.bvh"),
        (["--out", "m.npz"], 2, "the following arguments are required: FILE"),
        (["a.bvh", "--out", "m.json"], 2, "'m.json' does not end in .bvh, .npz or .csv, the formats of the file"),
    ],
    ids=str,
)
def test_errors_of_convert(arguments, status, message, capsys):
    Path("walk.trc").write_bytes(damaged.FILES["TRC"][0])
    assert message in refusal(["convert", *arguments], capsys, status)


def test_a_table_of_angles_is_no_motion(capsys):
    assert main(["convert", "a.bvh", "--out", "a.csv"]) == 0
    for command in (["info", "a.csv"], ["convert", "a.csv", "--out", "m.npz"], ["mean", "a.csv", "--out", "m.npz"]):
        assert "a.csv: this is a table of joint angles, as save_csv writes them" in refusal(command, capsys)
