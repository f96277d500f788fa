"""The command ``skpose`` as a whole: help, errors, exit statuses, new files."""

import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import skpose
from skpose._cli.main import main

pytestmark = pytest.mark.usefixtures("walks_in_folder")
# Of each command that writes a file: what it needs, and a name for it.
WRITERS = {
    "view": (["anna.bvh"], "page.html"),
    "explore": (["anna.bvh"], "page.html"),
    "distances": (["anna.bvh"], "D.npy"),
    "retarget": (["anna.bvh", "--onto", "ben.bvh"], "motion.bvh"),
    "convert": (["anna.bvh"], "motion.npz"),
    "angles": (["anna.bvh"], "angles.csv"),
}


def status_of(arguments):
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    return stop.value.code


def test_help_and_version(capsys):
    assert main([]) == 0
    out = capsys.readouterr().out
    for command in (*WRITERS, "info", "find", "compare", "reproduce"):
        assert command in out
        assert status_of([command, "--help"]) == 0
        assert f"usage: skpose {command}" in capsys.readouterr().out


def test_as_a_module():
    done = subprocess.run([sys.executable, "-m", "skpose", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == f"skpose {skpose.__version__}"


@pytest.mark.parametrize("command", WRITERS)
def test_no_file_is_overwritten(command, capsys):
    arguments, out = WRITERS[command]
    Path(out).write_text("mine")
    assert main([command, *arguments, "--out", out]) == 1
    assert "already exists" in capsys.readouterr().err
    assert Path(out).read_text() == "mine"
    assert main([command, *arguments, "--out", f"nowhere/{out}"]) == 1
    assert "nowhere" in capsys.readouterr().err
    assert status_of([command, *arguments, "--out", "motion.xyz"]) == 2


@pytest.mark.parametrize(
    "arguments",
    [
        ["walk"],
        ["distances", "anna.bvh"],  # without --out
        ["distances", "anna.bvh", "--out", "D.npy", "--metric", "euclidean"],
        ["info", "anna.bvh", "--scale", "0"],
        ["find", ".", "anna.bvh"],  # a folder is not a query
        ["convert", "anna.bvh", "--out", "a.bvh", "--from", "x"],
        ["retarget", "anna.bvh", "--onto", "ben.bvh", "--joints", "knee"],
        ["retarget", "anna.bvh", "--onto", "ben.bvh", "--factor", "x"],
    ],
    ids=" ".join,
)
def test_wrong_options(arguments):
    assert status_of(arguments) == 2


def test_errors_of_the_library_are_printed_as_they_are(capsys):
    Path("bad.bvh").write_text("HIERARCHY\nROOT hips\n{\n  OFFSET 0 0\n")
    with pytest.raises(skpose.io.MocapFormatError) as found:
        skpose.io.load_bvh("bad.bvh")
    for arguments in (["info", "bad.bvh"], ["distances", "anna.bvh", "bad.bvh", "--out", "D.npy"]):
        assert main(arguments) == 1
        assert capsys.readouterr().err == f"skpose: {found.value}\n"
    assert not Path("D.npy").exists()
    assert main(["info", "nowhere.bvh"]) == 1
    assert "nowhere.bvh" in capsys.readouterr().err


def test_an_error_in_a_computation_leaves_no_file(monkeypatch, capsys):
    def fail(*_, **__):
        raise MemoryError("too little memory")

    monkeypatch.setattr("skpose.pose_distances", fail)
    assert main(["distances", "anna.bvh", "--out", "D.npy"]) == 1
    assert capsys.readouterr().err == "skpose: too little memory\n"
    assert sorted(path.name for path in Path().iterdir()) == ["anna.bvh", "ben.bvh"]


def test_warnings_are_one_line(capsys):
    text = Path("anna.bvh").read_text().splitlines()
    Path("nan.bvh").write_text("\n".join([*text[:-1], text[-1].replace(text[-1].split()[0], "nan", 1)]))
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        assert main(["info", "nan.bvh", "--on-nan", "drop"]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("skpose: warning: nan.bvh")


def test_control_characters_of_names_are_escaped(capsys):
    text = Path("anna.bvh").read_text()
    name = next(line.split()[1] for line in text.splitlines() if line.strip().startswith("JOINT"))
    Path("\x1b[2Jred.bvh").write_text(text.replace(f"JOINT {name}", "JOINT \x1b[31mred"))
    assert main(["info", "\x1b[2Jred.bvh"]) == 0
    assert main(["info", "\x1b[2Jred.bvh", "\x1b[2Jnowhere.bvh"]) == 1
    printed = capsys.readouterr()
    assert r"\x1b[31mred" in printed.out
    assert r"\x1b[2Jnowhere" in printed.err
    assert "\x1b" not in printed.out + printed.err


@pytest.mark.slow
def test_a_closed_output_is_not_an_error():
    """As of `skpose info file | head -0`."""
    command = f"{sys.executable} -m skpose info anna.bvh"
    done = subprocess.run(["bash", "-c", f"{command} | true"], capture_output=True, text=True, check=False)
    assert done.stderr == ""


def test_interrupted(monkeypatch):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(np, "concatenate", interrupt)
    assert main(["distances", "anna.bvh", "--out", "D.npy"]) == 130
