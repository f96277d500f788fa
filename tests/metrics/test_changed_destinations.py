"""Destinations that are replaced, moved, deleted or created again, before they are written or meanwhile."""

import os
import shutil
from contextlib import ExitStack, suppress
from itertools import count
from pathlib import Path

import numpy as np
import pytest
import zarr
from conftest import in_turns
from many_tiles import X, record_tiles, use_small_tiles
from test_out import TREE, reported

from skpose import pose_distances
from skpose._parallel.checkpoint import FileCheckpoint
from skpose._parallel.lock import hold_lock
from skpose.metrics import _run, _writers, _zarr_writer


@pytest.fixture(autouse=True)
def small_tiles(monkeypatch):
    use_small_tiles(monkeypatch)


@pytest.fixture
def computed(monkeypatch):
    return record_tiles(monkeypatch)


@pytest.mark.parametrize("what", ["deleted", "replaced", "shorter"])
@pytest.mark.skipif(os.name != "posix", reason="elsewhere a mapped file stays where it is")
def test_a_mapping_of_a_file_that_is_not_there_any_more_is_refused(tmp_path, what):
    path = tmp_path / "D.npy"
    out = np.lib.format.open_memmap(path, mode="w+", shape=(150, 150))
    content = path.read_bytes()
    path.unlink()
    if what != "deleted":
        path.write_bytes(content if what == "replaced" else content[:-1])
    with pytest.raises(ValueError, match=r"a file that is not .*D\.npy any more, as it was moved, deleted or replaced"):
        pose_distances(X, skeleton=TREE, out=out)
    assert not out.any()
    assert what == "deleted" or path.read_bytes() == content[: path.stat().st_size]


ARRAYS = ["npy", "zarr", "zarr in memory"]


@pytest.fixture(params=ARRAYS)
def created(request, tmp_path):
    """A function that creates an array that outlives its object, or creates it again."""
    store = zarr.storage.MemoryStore() if request.param == "zarr in memory" else tmp_path / "D.zarr"

    def create(chunks=(16, 16), **kind):
        if request.param == "npy":
            return np.lib.format.open_memmap(tmp_path / "D.npy", mode="w+", shape=(150, 150))
        return zarr.create_array(store, **{"shape": (150, 150), "dtype": "f8"} | kind, chunks=chunks, overwrite=True)

    def opened():
        if request.param == "npy":
            return np.lib.format.open_memmap(tmp_path / "D.npy", mode="r+")
        return zarr.open_array(store, mode="r+")

    create.opened = opened
    return create


@pytest.fixture
def before_write(monkeypatch):
    """A function that has something done before the tile of this number is written, from zero on."""

    def do(number, action):
        monkeypatch.setattr(_run, "SECONDS", 1e9)  # no thread is at work in the folder meanwhile
        for writer in _writers.FileWriter, _zarr_writer.ZarrWriter:
            calls, write = count(), writer.write

            def written(self, *arguments, calls=calls, write=write):
                if next(calls) == number:
                    action()
                return write(self, *arguments)

            monkeypatch.setattr(writer, "write", written)

    return do


@pytest.mark.parametrize(("created", "n_tiles"), in_turns(ARRAYS, [1, 30, 54]), indirect=["created"])
def test_an_array_that_is_created_again_while_it_is_written_is_an_error_and_can_be_continued(
    created, before_write, computed, n_tiles
):
    """As by a script with mode="w+" that is started a second time."""
    out = created()
    before_write(n_tiles, created)
    with pytest.raises(RuntimeError, match=r"out was changed by something else .*: a complete tile does not have"):
        pose_distances(X, skeleton=TREE, out=out)
    again = created.opened()
    computed.clear()
    pose_distances(X, skeleton=TREE, out=again)
    assert len(computed) == n_tiles
    np.testing.assert_array_equal(again[:], pose_distances(X, skeleton=TREE))


@pytest.mark.parametrize("what", ["deleted", "moved", "replaced"])
@pytest.mark.skipif(os.name != "posix", reason="elsewhere a mapped file stays where it is")
def test_a_file_that_is_replaced_while_it_is_written_is_an_error(tmp_path, before_write, what):
    path = tmp_path / "D.npy"

    def change():
        path.rename(tmp_path / "E.npy") if what == "moved" else path.unlink()
        if what == "replaced":
            np.save(path, np.zeros((150, 150)))

    out = np.lib.format.open_memmap(path, mode="w+", shape=(150, 150))
    before_write(54, change)
    reason = "another file now" if what == "replaced" else r"cannot be found any more \(No such file"
    with pytest.raises(RuntimeError, match=rf"out was changed by something else .*{reason}"):
        pose_distances(X, skeleton=TREE, out=out)
    assert len(FileCheckpoint(path).read()[1]) == 55
    out = np.lib.format.open_memmap(path, mode="w+", shape=(150, 150))
    pose_distances(X, skeleton=TREE, out=out)
    np.testing.assert_array_equal(out, pose_distances(X, skeleton=TREE))


KINDS = [{"chunks": (30, 30)}, {"dtype": "f4"}, {"shape": (140, 150)}, {"compressors": None}]


@pytest.mark.parametrize("kind", KINDS, ids=str)
@pytest.mark.parametrize("when", ["before", "meanwhile"])
def test_a_zarr_array_that_was_created_again_otherwise_is_refused(created, before_write, kind, when):
    out = created()
    if isinstance(out, np.ndarray):
        pytest.skip("has no chunks")
    if when == "before":
        created(**kind)
        with pytest.raises(ValueError, match=r"a zarr array that is not in its store any more: .* another .*Open it"):
            pose_distances(X, skeleton=TREE, out=out)
        assert not created.opened()[:].any()
        return
    before_write(50, lambda: created(**kind))
    # In memory the notes have the first kind written back.
    with pytest.raises(RuntimeError, match=r"out was changed by something else .*(with another|does not have)"):
        pose_distances(X, skeleton=TREE, out=out)


def test_a_zarr_array_without_its_folder_is_refused(tmp_path, monkeypatch):
    kind = {"shape": (150, 150), "dtype": "f8", "chunks": (16, 16)}
    monkeypatch.chdir(tmp_path)
    out = zarr.create_array("D.zarr", **kind)
    (tmp_path / "other").mkdir()
    with monkeypatch.context() as patch:
        patch.chdir(tmp_path / "other")
        with pytest.raises(ValueError, match=r"other.D\.zarr cannot be opened .* by its absolute path"):
            pose_distances(X, skeleton=TREE, out=out)
    assert list((tmp_path / "other").iterdir()) == []
    with reported(lambda: os.chdir("other") if Path.cwd() == tmp_path else None):  # which changes nothing any more
        pose_distances(X, skeleton=TREE, out=out)
    assert list((tmp_path / "other").iterdir()) == []
    np.testing.assert_array_equal(zarr.open_array(tmp_path / "D.zarr")[:], pose_distances(X, skeleton=TREE))
    os.chdir(tmp_path)
    shutil.rmtree("D.zarr")
    with pytest.raises(ValueError, match="a zarr array that is not in its store any more"):
        pose_distances(X, skeleton=TREE, out=out)


def test_a_folder_that_is_deleted_while_it_is_written_is_an_error(tmp_path, monkeypatch):
    """After the last tile: before, zarr makes the folder again."""
    out, add = zarr.create_array(tmp_path / "D.zarr", shape=(16, 16), dtype="f8", chunks=(16, 16)), FileCheckpoint.add

    def add_late(*arguments):
        shutil.rmtree(tmp_path / "D.zarr")
        add(*arguments)

    monkeypatch.setattr(FileCheckpoint, "add", add_late)
    with pytest.raises(RuntimeError, match=r"out was changed by something else .*cannot be opened as an array"):
        pose_distances(X[:16], skeleton=TREE, out=out)


def test_a_second_call_after_the_folder_was_emptied_stops_the_first(tmp_path, monkeypatch):
    """The lock goes with the folder, so that another call can begin: it keeps its lock and its notes."""
    kind = {"shape": (150, 150), "dtype": "f8", "chunks": (16, 16)}
    out, calls = zarr.create_array(tmp_path / "D.zarr", **kind), count(1)
    monkeypatch.setattr("skpose._parallel.checkpoint.SECONDS", -1.0)

    def begin_again():
        if next(calls) == 20:
            for _ in range(100):
                with suppress(OSError):  # a tile was written while the folder was removed
                    zarr.create_array(tmp_path / "D.zarr", **kind, overwrite=True)
                    break
            stack.enter_context(hold_lock(tmp_path / "D.zarr"))

    with ExitStack() as stack:
        with reported(begin_again), pytest.raises(RuntimeError, match=r"skpose.lock was removed, and is the lock of"):
            pose_distances(X, skeleton=TREE, out=out)
        assert next(calls) < 30
        assert (tmp_path / "D.zarr" / "skpose.lock").exists()
        assert not (tmp_path / "D.zarr" / "skpose.progress").exists()
