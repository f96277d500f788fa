"""New files are complete or absent, and never replace an existing one."""

import pytest

from skpose._utils.files import check_new, new_file


def write(path, text, error):
    path.write_text(text)
    raise error


def test_a_file_appears_when_it_is_complete(tmp_path):
    with new_file(tmp_path / "a.txt") as new:
        new.write_text("all")
        assert (new.parent, new.suffix) == (tmp_path, ".txt")
        assert not (tmp_path / "a.txt").exists()
    assert (tmp_path / "a.txt").read_text() == "all"
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_after_an_error_nothing_is_left(tmp_path, error):
    with pytest.raises(error), new_file(tmp_path / "a.txt") as new:
        write(new, "half", error)
    assert list(tmp_path.iterdir()) == []


def test_an_existing_file_stays(tmp_path):
    path = tmp_path / "a"
    with pytest.raises(FileExistsError, match="a already exists"), new_file(path):
        path.write_text("theirs")
    assert path.read_text() == "theirs"
    with pytest.raises(FileExistsError), new_file(path):
        pytest.fail("the block must not run")
    assert len(list(tmp_path.iterdir())) == 1
    with new_file(path, replace=True) as new:
        new.write_text("after")
    assert path.read_text() == "after"


def test_folders_that_cannot_hold_a_file(tmp_path, monkeypatch):
    with pytest.raises(FileNotFoundError, match="does not exist"):
        check_new(tmp_path / "no" / "a")
    monkeypatch.setattr("os.access", lambda *_: False)
    with pytest.raises(PermissionError, match="read-only"):
        check_new(tmp_path / "a")
