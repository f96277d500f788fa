"""New files: whole or not at all, and never over one that exists."""

import errno
import os
from pathlib import Path

import pytest

from skpose._files import check_new, new_file


def write(path, text, error):
    path.write_text(text)
    if error is not None:
        raise error


def test_what_is_written_becomes_the_file(tmp_path):
    with new_file(tmp_path / "a.txt") as new:
        new.write_text("all")
        assert new.parent == tmp_path
        assert new.suffix == ".txt"
        assert not (tmp_path / "a.txt").exists()
    assert (tmp_path / "a.txt").read_text() == "all"
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_after_an_error_nothing_is_left(tmp_path, error):
    with pytest.raises(error), new_file(tmp_path / "a.txt") as new:
        write(new, "half", error)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("kind", ["file", "folder", "link that leads nowhere"])
def test_what_exists_stays(tmp_path, kind):
    path = tmp_path / "a"
    if kind == "file":
        path.write_text("mine")
    elif kind == "folder":
        path.mkdir()
    else:
        try:
            path.symlink_to(tmp_path / "nowhere")
        except OSError:
            pytest.skip("links need a permission here")
    with pytest.raises(FileExistsError, match="a already exists: delete it or choose another file"):
        check_new(path)
    with pytest.raises(FileExistsError), new_file(path):
        pytest.fail("the block must not run")
    assert [p.name for p in tmp_path.iterdir()] == ["a"]


def write_both(new, path, monkeypatch=None):
    """Create both files; with `monkeypatch`, theirs after the last look."""
    new.write_text("ours")
    path.write_text("theirs")
    if monkeypatch is not None:
        monkeypatch.setattr(os.path, "lexists", lambda _: False)


def test_a_file_that_is_created_in_the_meantime_stays(tmp_path):
    path = tmp_path / "a"
    with pytest.raises(FileExistsError, match="a has been created by something else"), new_file(path) as new:
        write_both(new, path)
    assert path.read_text() == "theirs"
    assert len(list(tmp_path.iterdir())) == 1


def test_a_file_that_is_created_in_the_last_moment_stays(tmp_path, monkeypatch):
    path = tmp_path / "a"
    with pytest.raises(FileExistsError, match="a has been created by something else"), new_file(path) as new:
        write_both(new, path, monkeypatch)
    assert path.read_text() == "theirs"
    assert len(list(tmp_path.iterdir())) == 1


def refuse_links(*_):
    raise OSError(errno.EPERM, "Operation not permitted")


def test_file_systems_without_links(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "link", refuse_links)
    path = tmp_path / "a"
    with new_file(path) as new:
        new.write_text("all")
    with pytest.raises(FileExistsError, match="b has been created"), new_file(tmp_path / "b") as new:
        write_both(new, tmp_path / "b")
    assert (path.read_text(), (tmp_path / "b").read_text()) == ("all", "theirs")
    assert len(list(tmp_path.iterdir())) == 2


def test_a_file_of_ones_own_is_replaced_whole(tmp_path):
    path = tmp_path / "a"
    path.write_text("before")
    with pytest.raises(OSError, match="full"), new_file(path, replace=True) as new:
        write(new, "ha", OSError("full"))
    assert path.read_text() == "before"
    with new_file(path, replace=True) as new:
        new.write_text("after")
    assert path.read_text() == "after"


def test_folders_that_cannot_hold_a_file(tmp_path, monkeypatch):
    (tmp_path / "note.txt").write_text("mine")
    with pytest.raises(FileNotFoundError, match=r"there is no folder .*no; create it first"):
        check_new(tmp_path / "no" / "a")
    with pytest.raises(NotADirectoryError, match=r"note\.txt is a file, not a folder"):
        check_new(tmp_path / "note.txt" / "a")
    with monkeypatch.context() as patch:  # root may write everywhere but there
        patch.setattr(Path, "touch", lambda *_, **__: (_ for _ in ()).throw(OSError(errno.EROFS, "Read-only disk")))
        with pytest.raises(OSError, match="a cannot be written: Read-only disk; choose another folder"):
            check_new(tmp_path / "a")
    check_new(tmp_path / "a")
    assert [path.name for path in tmp_path.iterdir()] == ["note.txt"]
