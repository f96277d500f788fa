"""Files that the commands write: refused before anything is read, never over others, whole or not at all."""

import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA
from scipy.sparse import load_npz

from skpose import Skeleton
from skpose._cli import report, reproduce
from skpose._cli.main import main
from skpose._cli.targets import REPORT
from skpose._parallel.checkpoint import FileCheckpoint
from skpose.datasets import make_gait
from skpose.io import load_bvh, save_bvh
from skpose.metrics import pose_distances

# Nothing is read if the target is refused: this file is missing, which would be the error.
COMMANDS = {
    "distances": (["distances", "none.bvh"], "D.npy"),
    "neighbors": (["neighbors", "none.bvh"], "G.npz"),
    "motions": (["motions", "none.bvh"], "D.npy"),
    "view": (["view", "none.bvh"], "view.html"),
    "names": (["distances", "none.bvh"], "D.csv"),
    "mean": (["mean", "none.bvh"], "mean.bvh"),
    "between": (["between", "none.bvh", "--frames", "0,1"], "between.npz"),
    "retarget": (["retarget", "none.bvh", "--onto", "none.asf"], "there.bvh"),
    "convert": (["convert", "none.bvh"], "none.csv"),
    "reproduce": (["reproduce", "nowhere"], "out"),
}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(DATA / "biped.bvh", "a.bvh")
    return tmp_path


def refusal(arguments, capsys, status=1):
    """Run a command that must fail and print nothing but one line on stderr; return that."""
    if status == 2:
        with pytest.raises(SystemExit) as stop:
            main(arguments)
        assert stop.value.code == 2
    else:
        assert main(arguments) == status
    captured = capsys.readouterr()
    assert captured.out == ""
    *usage, line = captured.err.splitlines()
    assert bool(usage) == (status == 2)
    return line


@pytest.mark.parametrize("command", COMMANDS)
def test_existing_files_are_refused_before_anything_is_read(command, capsys):
    arguments, out = COMMANDS[command]
    Path(out).write_text("mine")
    line = refusal([*arguments, "--out", out], capsys)
    expected = f"{out} is a file: choose a folder" if command == "reproduce" else f"{out} already exists: delete it"
    assert line.startswith(f"skpose: {expected}")
    assert Path(out).read_text() == "mine"


@pytest.mark.parametrize("name", REPORT)
def test_a_report_is_never_overwritten(name, capsys):
    Path("out").mkdir()
    Path("out", name).write_text("mine")
    line = refusal(["reproduce", "--out", "out"], capsys)
    assert line == f"skpose: {Path('out', name)} already exists: delete it or choose another file"
    assert os.listdir("out") == [name]
    assert Path("out", name).read_text() == "mine"


@pytest.mark.parametrize("command", COMMANDS)
def test_folders_that_do_not_exist_are_refused_before_anything_is_read(command, capsys):
    arguments, out = COMMANDS[command]
    assert "there is no folder no; create it first" in refusal([*arguments, "--out", f"no/{out}"], capsys)
    assert os.listdir() == ["a.bvh"]


@pytest.mark.parametrize("command", COMMANDS)
def test_folders_that_cannot_be_written_to_are_refused_before_anything_is_read(command, capsys, monkeypatch):
    def touch(path, *_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "touch", touch)
    arguments, out = COMMANDS[command]
    assert f"{out} cannot be written: Permission denied" in refusal([*arguments, "--out", out], capsys)


@pytest.mark.parametrize(
    ("command", "out", "suffix"),
    [("distances", "D.txt", ".npy, .npz or .csv, the formats"), ("motions", "D", ".npy, .npz or .csv, the formats"),
     ("neighbors", "G.npy", ".npz or .csv, the formats"), ("neighbors", "G.npz.gz", ".npz or .csv, the formats"),
     ("neighbors", "", ".npz or .csv, the formats"), ("mean", "m.amc", ".bvh, .npz or .csv, the formats"),
     ("explore", "e.htm", ".html, which is the format")],
)  # fmt: skip
def test_the_name_has_the_suffix_of_the_format(command, out, suffix, capsys):
    line = refusal([command, "a.bvh", "--out", out], capsys, status=2)
    assert line.endswith(f"argument --out: {out!r} does not end in {suffix} of the file")
    assert os.listdir() == ["a.bvh"]


@pytest.mark.parametrize("command", ["distances", "neighbors"])
def test_an_error_in_the_computation_leaves_no_file(command, capsys, monkeypatch):
    def fails(*_, **__):
        raise RuntimeError("the cluster has failed")

    monkeypatch.setattr("skpose._cli.commands.pose_distances", fails)
    monkeypatch.setattr("skpose._cli.commands.motion_distances", fails)
    monkeypatch.setattr("skpose._cli.matrices.save_npz", fails)
    out = COMMANDS[command][1]
    options = ["--neighbors", "1"] if command == "neighbors" else []
    assert main([command, "a.bvh", *options, "--metric", "position", "--out", out]) == 1
    assert "the cluster has failed" in capsys.readouterr().err
    assert os.listdir() == ["a.bvh"]


def test_a_suffix_in_capitals_is_the_name_of_the_file():
    assert main(["neighbors", "a.bvh", "--neighbors", "1", "--metric", "position", "--out", "G.NPZ"]) == 0
    assert sorted(os.listdir()) == ["G.NPZ", "a.bvh"]
    assert load_npz("G.NPZ").shape == (2, 2)


def test_a_matrix_for_which_there_is_no_room_leaves_no_file(capsys, monkeypatch):
    def truncated(out, **_):
        Path(out).write_bytes(b"the header")
        raise OSError(27, "File too large")

    monkeypatch.setattr(np.lib.format, "open_memmap", truncated)
    assert main(["distances", "a.bvh", "--metric", "position", "--out", "D.npy"]) == 1
    assert "File too large" in capsys.readouterr().err
    assert os.listdir() == ["a.bvh"]


def test_a_matrix_never_replaces_a_file_that_is_created_in_the_meantime(capsys, monkeypatch):
    monkeypatch.setattr("skpose._cli.commands.check_new", lambda out: Path(out).write_text("theirs"))
    assert main(["distances", "a.bvh", "--metric", "position", "--out", "D.npy"]) == 1
    assert "D.npy has been created by something else" in capsys.readouterr().err
    assert Path("D.npy").read_text() == "theirs"


@pytest.mark.parametrize("command", ["distances", "neighbors"])
def test_a_file_in_the_place_of_a_folder_is_refused_in_words(command, capsys):
    arguments, out = COMMANDS[command]
    assert "a.bvh is a file, not a folder; choose another folder" in refusal(
        [*arguments, "--out", f"a.bvh/{out}"], capsys
    )


@pytest.fixture
def small_study(monkeypatch):
    gait = make_gait(n_subjects=2, n_sequences=1, duration=1, random_state=0)
    monkeypatch.setattr("skpose._cli.commands.make_gait", lambda random_state: gait)
    for name, value in {"N_DRAWS": 2, "N_PAIRS": 2, "N_SEQUENCES": 1}.items():
        monkeypatch.setattr(reproduce, name, value)


@pytest.mark.usefixtures("small_study")
@pytest.mark.slow
def test_a_report_is_written_whole_or_not_at_all(capsys, monkeypatch):
    Path("README.md").write_text("mine")
    with monkeypatch.context() as patch:
        patch.setattr(report, "draw", lambda *_: (_ for _ in ()).throw(OSError("no space left on device")))
        assert main(["reproduce", "--out", "."]) == 1
    assert "no space left on device" in capsys.readouterr().err
    assert sorted(os.listdir()) == ["README.md", "a.bvh"]
    assert main(["reproduce", "--out", "."]) == 0
    assert sorted(os.listdir()) == sorted(["README.md", "a.bvh", *REPORT])
    assert Path("README.md").read_text() == "mine"


def test_an_unfinished_matrix_of_other_files_is_refused_in_words(capsys):
    motion = load_bvh("a.bvh")
    save_bvh("b.bvh", motion[:1])
    out = np.lib.format.open_memmap("D.npy", mode="w+", shape=(2, 2))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(FileCheckpoint, "remove", lambda self: None)  # as if it had been stopped
        pose_distances(motion.angles, skeleton=Skeleton.mean([motion.skeleton]), metric="position", out=out)
    before = Path("D.npy").read_bytes()
    command = ["distances", "--metric", "position", "--out", "D.npy"]
    assert main([*command, "b.bvh"]) == 1
    assert "D.npy is an unfinished matrix of 2 × 2 float64, expected 1 × 1 float64: fini" in capsys.readouterr().err
    assert main([*command, "a.bvh", "--scale", "0.5"]) == 1
    line = capsys.readouterr().err
    assert "other distances, with another skeleton: finish those with the call that started them" in line
    assert "D.npy.progress to write over them" in line
    assert Path("D.npy").read_bytes() == before
    assert main([*command, "a.bvh"]) == 0
    assert not Path("D.npy.progress").exists()
