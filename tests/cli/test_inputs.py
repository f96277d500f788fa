"""What the commands read: files, folders, pipes; and errors that name the files."""

import io
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA

from skpose import Bone, Motion, Skeleton
from skpose._cli.compare import COMPARED, compare, prepare
from skpose._cli.inputs import read_labelled
from skpose._cli.main import main
from skpose.datasets import MotionDataset, make_gait
from skpose.io import save_bvh

BVH = DATA / "biped.bvh"
RATE = "--amc-frame-rate", "60"  # without which a warning says that 120 Hz is taken


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def gait():
    return make_gait(n_subjects=2, n_sequences=2, duration=1.0, random_state=0)


def write(gait, folder="takes", **options):
    """Write motions as BVH files that are named SUBJECT_ACTION_TRIAL.bvh."""
    Path(folder).mkdir()
    for motion, *labels in zip(gait, gait.subjects, gait.actions, gait.trials, strict=True):
        save_bvh(Path(folder, f"{'_'.join(labels)}.bvh"), motion, **options)


def error_of(arguments, capsys):
    assert main(arguments) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    (line,) = captured.err.splitlines()
    return line.removeprefix("skpose: ")


# Pipes


@pytest.mark.slow
@pytest.mark.parametrize("name", ["-", "/dev/stdin"])
@pytest.mark.parametrize("file", ["biped.bvh", "arm.asf", "arm.amc"])
def test_a_pipe_on_standard_input(file, name, capsys):
    if name != "-" and not Path(name).exists():
        pytest.skip("there is no /dev/stdin")
    more = {"arm.amc": ["--asf", str(DATA / "arm.asf"), *RATE], "biped.bvh": ["--scale", "0.01"]}.get(file, [])
    assert main(["info", str(DATA / file), *more]) == 0
    expected = capsys.readouterr().out
    command = [sys.executable, "-m", "skpose", "info", name, *more]
    done = subprocess.run(command, input=(DATA / file).read_bytes(), capture_output=True, check=False)
    assert (done.stdout.decode().splitlines(), done.stderr) == (expected.splitlines(), b"")


def standard_input(monkeypatch, content):
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(content)))


def test_rows_of_standard_input(monkeypatch, capsys):
    command = ["distances", "--metric", "position", "--out"]
    standard_input(monkeypatch, BVH.read_bytes())
    assert main([*command, "P.npy", str(BVH), "-"]) == 0
    assert capsys.readouterr().out.splitlines()[1].split() == ["2", "to", "3", "standard", "input"]
    assert main([*command, "D.npy", str(BVH), str(BVH)]) == 0
    np.testing.assert_array_equal(np.load("P.npy"), np.load("D.npy"))


def test_errors_name_standard_input(monkeypatch, capsys):
    for content, message in (
        (b"", "standard input: the file is empty"),
        (b"hello", "standard input: this is not a motion file"),
        ((DATA / "arm.amc").read_bytes(), "standard input: an AMC file needs its skeleton: pass --asf"),
    ):
        standard_input(monkeypatch, content)
        assert error_of(["info", "-"], capsys).startswith(message)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_the_skeleton_of_several_files_from_a_pipe(capsys):
    shutil.copy(DATA / "arm.amc", "a.amc")
    shutil.copy(DATA / "arm.amc", "b.amc")
    os.mkfifo("asf")
    with subprocess.Popen(["cp", str(DATA / "arm.asf"), "asf"]):
        assert main(["distances", "a.amc", "b.amc", "--asf", "asf", *RATE, "--metric", "angle", "--out", "D.npy"]) == 0
    assert np.load("D.npy").shape == (6, 6)


# Folders


def test_info_of_a_folder(capsys):
    Path("takes", "below").mkdir(parents=True)
    shutil.copy(BVH, Path("takes", "below", "a.BVH"))
    shutil.copy(DATA / "arm.asf", Path("takes", "arm.asf"))
    shutil.copy(DATA / "arm.amc", Path("takes", "arm.amc"))
    for name in ("notes.txt", "._a.bvh", "G.npz"):
        Path("takes", name).write_text("not a motion")
    files = [str(Path("takes", name)) for name in ("arm.amc", "arm.asf", "below/a.BVH")]
    assert main(["info", *files, *RATE]) == 0
    expected = capsys.readouterr().out
    assert main(["info", "takes", *RATE]) == 0
    assert capsys.readouterr().out == expected
    assert main(["distances", "takes/below", "takes/below/a.BVH", "--metric", "angle", "--out", "D.npy"]) == 0
    assert np.load("D.npy").shape == (4, 4)
    capsys.readouterr()
    Path("empty").mkdir()
    message = "the folder empty holds no files named *.bvh, *.amc, *.asf, *.trc, *.c3d"
    assert error_of(["info", "empty"], capsys) == message


def test_compare_reads_the_labels_of_bvh_files_from_their_names(gait, capsys):
    actions = [f"{action}_fast" for action in gait.actions]
    write(MotionDataset(gait.motions, gait.subjects, gait.trials, actions), scale=0.01)
    read = read_labelled(Path("takes"), 0.01)
    labels = [f"{s} {a} {t}" for s, a, t in zip(read.subjects, read.actions, read.trials, strict=True)]
    expected = [f"{s} {a} fast {t}" for s, a, t in zip(gait.subjects, gait.actions, gait.trials, strict=True)]
    assert labels == sorted(expected)
    assert main(["compare", "takes", "--scale", "0.01", "--jobs", "1"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].startswith("8 motions of 2 actions by 2 people")
    for row in compare(prepare(read)):
        (printed,) = (line.split() for line in lines if line.startswith(row.metric))
        assert printed[1:6] == [f"{share:.1%}" for share in row[1:6]]


def test_one_person_cannot_be_left_out(gait, capsys):
    write(gait[gait.subjects == gait.subjects[0]])
    assert main(["compare", "takes"]) == 0
    out = capsys.readouterr().out
    assert "nan" not in out
    assert "-: all motions are of one person, so that there are no others." in out.splitlines()
    for metric in COMPARED:
        (row,) = (line.split() for line in out.splitlines() if line.startswith(metric))
        assert row[1:3] == ["-", "-"]
        assert row[3:5] == ["100.0%", "100.0%"]


def test_folders_without_labels_are_refused_before_they_are_read(capsys):
    Path("takes").mkdir()
    for command in (["compare", "takes"], ["compare", "takes", "--paper"], ["reproduce", "takes", "--out", "out"]):
        line = error_of(command, capsys)
        assert line.startswith(
            "takes holds neither an index.csv, see skpose.datasets.load_cmu, nor BVH files named SUB"
        )
    Path("takes", "anna_walk_1.bvh").write_text("not read")
    line = error_of(["compare", "takes", "--paper"], capsys)
    assert "takes has no file whose action is 'run', but walk: expected" in line
    Path("takes", "walk1.bvh").write_text("not read")
    line = error_of(["compare", "takes"], capsys)
    assert line.startswith(f"{Path('takes', 'walk1.bvh')} has no labels in its name: expected SUBJECT_ACTION_TRIAL.bvh")
    assert not Path("out").exists()


def test_the_scale_is_for_bvh_files(capsys):
    Path("index.csv").write_text("subject,trial,action,frames_per_second,file\n")
    assert error_of(["compare", ".", "--scale", "0.01"], capsys).startswith("--scale is for folders of BVH files")


# Skeletons that do not fit together


def lame(motion):
    """Return the motion on a skeleton whose last joint has another name."""
    *bones, last = motion.skeleton.bones
    return replace(motion, skeleton=Skeleton([*bones, last._replace(name="stump")], motion.skeleton.offset_frame))


@pytest.mark.parametrize("method", ["numbers", "unchecked"])
def test_mixed_skeletons_are_named_by_file(gait, capsys, method):
    write(gait[[0, 1]])
    save_bvh("lame.bvh", lame(gait.motions[0]))
    first, second = sorted(Path("takes").iterdir())
    line = error_of(["distances", str(first), str(second), "lame.bvh", "--retarget", method, "--out", "D.npy"], capsys)
    assert "lame.bvh" in line
    assert str(first) in line
    assert "only one of them has a joint" in line
    assert "--retarget auto" in line
    assert "motions[" not in line
    assert "dataset" not in line


@pytest.mark.parametrize("command", [["compare"], ["compare", "--paper"], ["reproduce", "--out", "out"]])
def test_mixed_skeletons_of_a_folder_are_named_by_file(gait, capsys, command):
    motions = [*gait.motions[:5], lame(gait.motions[5]), *gait.motions[6:]]
    dataset = MotionDataset(motions, gait.subjects, gait.trials, gait.actions)
    jump = MotionDataset(motions[:1], ["00"], ["1"], ["jump"])  # which is no walk or run, and first
    write(dataset)
    write(jump, "jump")
    shutil.move("jump/00_jump_1.bvh", "takes")
    of_lame = f"{gait.subjects[5]}_{gait.actions[5]}_{gait.trials[5]}.bvh"
    line = error_of([command[0], "takes", *command[1:]], capsys)
    assert str(Path("takes", of_lame)) in line
    assert "motions[" not in line


def test_the_remedy_is_an_option_only_where_the_command_has_it(capsys):
    """`skpose compare` has no --retarget."""
    Path("takes").mkdir()
    for name, x in (("anna_walk_1", 1.0), ("anna_run_2", -1.0)):
        skeleton = Skeleton([Bone("arm", None, (0, 1, 0), "ZXY"), Bone("hand", "arm", (x, 0, 0))], "parent")
        save_bvh(f"takes/{name}.bvh", Motion(skeleton, np.zeros((3, 3)), 30))
    line = error_of(["compare", "takes", "--paper"], capsys)
    assert f"{Path('takes', 'anna_run_2.bvh')} and {Path('takes', 'anna_walk_1.bvh')} have different rest poses" in line
    assert "--retarget" not in line
    assert "--retarget orientations" in error_of(["distances", "takes", "--out", "D.npy"], capsys)
