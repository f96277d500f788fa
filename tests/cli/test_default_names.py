"""Files without --out, and pages that --open shows."""

import os
import shutil
import webbrowser
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA

from skpose._cli import browser
from skpose._cli.main import main
from skpose._cli.targets import ENDINGS, default_name
from skpose._parallel.checkpoint import FileCheckpoint


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(DATA / "biped.bvh", "walk.bvh")
    return tmp_path


@pytest.mark.parametrize(
    ("command", "inputs", "name"),
    [
        ("view", ["takes/walk.bvh"], "walk.html"),
        ("view", ["takes/walk.bvh.gz"], "walk.html"),
        ("view", ["a.b.bvh", "c.bvh", "d.bvh"], "a.b_and_2_more.html"),
        ("explore", ["cmu"], "cmu_explore.html"),
        ("distances", ["-"], "stdin_distances.npy"),
        ("convert", ["walk.bvh"], "walk.npz"),
        ("reproduce", ["cmu"], "cmu_report"),
        ("reproduce", [], "report"),
    ],
)
def test_the_name_is_that_of_the_input(command, inputs, name):
    Path("cmu").mkdir()
    assert default_name(command, [Path(one) for one in inputs]) == Path(name)


def test_of_this_folder_it_is_its_own_name(folder):
    assert default_name("explore", [Path(".")]).name == f"{folder.name}_explore.html"


@pytest.mark.parametrize("command", ENDINGS)
def test_nothing_is_overwritten(command):
    first = default_name(command, [Path("walk.bvh")])
    first.touch()
    second = default_name(command, [Path("walk.bvh")])
    assert second.stem == f"{first.stem}_2"
    assert second.suffix == first.suffix
    second.symlink_to("nowhere")  # is a file too
    assert default_name(command, [Path("walk.bvh")]).stem == f"{first.stem}_3"


def test_what_is_written_is_printed(capsys):
    for name in ("walk.html", "walk_2.html"):
        assert main(["view", "walk.bvh", "--scale", "0.01"]) == 0
        assert capsys.readouterr().out.startswith(f"{name}: 1 motion")
        assert Path(name).exists()
    assert sorted(os.listdir()) == ["walk.bvh", "walk.html", "walk_2.html"]


def test_an_unfinished_matrix_is_continued():
    out = Path("walk_distances.npy")
    out.touch()
    FileCheckpoint(out).path.touch()
    assert default_name("distances", [Path("walk.bvh")]) == out
    Path("walk_neighbors.npz").touch()
    FileCheckpoint(Path("walk_neighbors.npz")).path.touch()  # of a command that continues nothing
    assert default_name("neighbors", [Path("walk.bvh")]) == Path("walk_neighbors_2.npz")


@pytest.fixture
def opened(monkeypatch):
    pages = []
    monkeypatch.setattr(browser, "has_display", lambda: True)
    monkeypatch.setattr(webbrowser, "open", lambda uri: not pages.append(uri))
    return pages


def test_open_shows_the_page(opened, folder):
    assert main(["view", "walk.bvh", "--scale", "0.01", "--open"]) == 0
    assert opened == [(folder / "walk.html").as_uri()]


def test_open_shows_a_motion_that_is_written(opened, folder):
    assert main(["convert", "walk.bvh", "--scale", "0.01", "--open", "--out", "same.csv"]) == 0
    (uri,) = opened
    assert uri.endswith("view.html")
    assert sorted(os.listdir()) == ["same.csv", "walk.bvh"]


def test_without_a_display_there_are_words(monkeypatch, capsys):
    monkeypatch.setattr(browser, "has_display", lambda: False)
    monkeypatch.setattr(webbrowser, "open", lambda uri: pytest.fail("a browser in the terminal takes it over"))
    assert main(["view", "walk.bvh", "--scale", "0.01", "--open"]) == 0
    assert capsys.readouterr().err == (
        "skpose: --open: there is no display for a browser here: open walk.html elsewhere\n"
    )
    assert main(["convert", "walk.bvh", "--scale", "0.01", "--open", "--out", "same.npz"]) == 0
    assert capsys.readouterr().err == (
        "skpose: --open: there is no display for a browser here: skpose view makes a page of the file\n"
    )
    monkeypatch.setattr(browser, "has_display", lambda: True)
    monkeypatch.setattr(webbrowser, "open", lambda uri: False)
    assert main(["convert", "walk.bvh", "--scale", "0.01", "--open"]) == 0
    assert "no browser was found: open " in capsys.readouterr().err


def test_display(monkeypatch):
    monkeypatch.setattr("sys.platform", "linux")
    for name in browser.DISPLAYS:
        monkeypatch.delenv(name, raising=False)
    assert not browser.has_display()
    for name in browser.DISPLAYS:
        with monkeypatch.context() as context:
            context.setenv(name, "x")
            assert browser.has_display()


def test_open_of_a_report_alone_is_refused(capsys):
    with pytest.raises(SystemExit):
        main(["retarget", "walk.bvh", "--onto", "walk.bvh", "--open"])
    assert "--open is of what --out writes: pass both" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["compare", "reproduce"])
def test_a_folder_that_is_not_there(command, capsys):
    Path("cmu").mkdir()
    assert main([command, "cmuu"]) == 1
    assert capsys.readouterr().err == "skpose: there is no folder cmuu: did you mean 'cmu'?\n"
    assert main([command, "no/cmu"]) == 1
    assert "there is no folder no/cmu, as there is no folder no" in capsys.readouterr().err.replace(os.sep, "/")
    assert main([command, "walk.bvh"]) == 1
    assert "walk.bvh is a file, expected a folder of motions" in capsys.readouterr().err


def test_a_missing_file_is_named_before_others_are_read(monkeypatch, capsys):
    from skpose._cli.reader import Reader

    monkeypatch.setattr(Reader, "_read", lambda *_: pytest.fail("read"))
    assert main(["explore", "walk.bvh", "wlk.bvh"]) == 1
    assert "there is no file wlk.bvh: did you mean 'walk.bvh'?; --skip-errors leaves" in capsys.readouterr().err


def test_the_matrix_is_that_of_a_file_with_a_name():
    for arguments in ([], ["--out", "D.npy"]):
        assert main(["distances", "walk.bvh", "--metric", "position", "--scale", "0.01", *arguments]) == 0
    np.testing.assert_array_equal(np.load("walk_distances.npy"), np.load("D.npy"))
