"""Writers of tiles: every byte by position, notes only of what the disk has, one destination for one call at a time."""

import errno
import json
import os
import shutil
import threading
from contextlib import ExitStack
from itertools import count
from pathlib import Path

import numpy as np
import pytest
import zarr
from test_out import TREE, Stop, counted, reported, stopped_after

from skpose import pose_distances
from skpose._parallel.checkpoint import FileCheckpoint
from skpose._parallel.lock import locked
from skpose.metrics import _run, _writers, _zarr_writer
from skpose.metrics._matrix import DistanceMatrix
from skpose.metrics._tiles import Tile, Tiling
from skpose.metrics._writers import FileTarget

RNG = np.random.default_rng(0)


@pytest.fixture(scope="module")
def X():
    return np.cumsum(RNG.normal(0, 0.1, size=(150, TREE.n_dofs)), axis=0)


@pytest.fixture(autouse=True)
def small_tiles(monkeypatch):
    """Tiles of 16 × 16, each noted at once."""
    monkeypatch.setattr("skpose.metrics._matrix.ENCODED_AT_ONCE", 16)
    monkeypatch.setattr(_run, "SECONDS", -1.0)


@pytest.fixture
def computed(monkeypatch):
    """The tiles that are computed, a single one too, which `counted` does not see."""
    compute, tiles = DistanceMatrix.distances, []

    def recorded(matrix, tile, *arguments):
        tiles.append(tile)
        return compute(matrix, tile, *arguments)

    monkeypatch.setattr(DistanceMatrix, "distances", recorded)
    return tiles


def some_bytes(descriptor, content, offset):
    """Write no more than 100 bytes, as an operating system may."""
    return os.pwrite(descriptor, content[:100], offset)


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("offset", [0, 24])
@pytest.mark.parametrize("writing", ["as it is", "some bytes", "no pwrite"])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_tiles_lie_where_the_mapping_has_them(tmp_path, monkeypatch, order, offset, writing, dtype):
    if writing == "some bytes":
        pytest.importorskip("fcntl")  # there is no pwrite on Windows
        monkeypatch.setattr(_writers, "pwrite", some_bytes)
    elif writing == "no pwrite":
        monkeypatch.setattr(_writers, "pwrite", None)
        monkeypatch.setattr(_writers, "pread", None)
    monkeypatch.setattr(_writers, "MIRROR_EDGE", 8)
    array = np.memmap(tmp_path / "D", dtype, "w+", shape=(60, 60), order=order, offset=offset)
    expected = np.zeros(array.shape, dtype)
    target = FileTarget.of(array)
    target.check(array)
    tiles = Tile(0, 20, 0, 20), Tile(7, 31, 40, 53), Tile(59, 60, 0, 60), Tile(31, 40, 0, 60), Tile(10, 11, 55, 56)
    with target.opened() as writer:
        for tile in tiles:
            distances = RNG.uniform(size=tile.shape).astype(dtype)
            mirrored = tile.mirrored if tile.left in (40, 55) else None
            found = writer.write(tile, mirrored, distances)
            expected[tile.slices] = distances
            if mirrored is not None:
                expected[mirrored.slices] = distances.T
            assert (found[1] != 0) == (mirrored is not None)
            assert writer.checksums(tile, mirrored) == found
            np.testing.assert_array_equal(array, expected)
        array[10, 55] += 1
        assert writer.checksums(tile, mirrored) != found
    assert (tmp_path / "D").stat().st_size == offset + array.nbytes


def test_numbers_are_written_in_the_dtype_of_the_file(tmp_path):
    array = np.memmap(tmp_path / "D", np.float32, "w+", shape=(4, 4))
    distances = RNG.uniform(size=(8, 8))[::2, ::2]
    with FileTarget.of(array).opened() as writer:
        writer.write(Tile(0, 4, 0, 4), None, distances)
    np.testing.assert_array_equal(array, distances.astype(np.float32))


def test_a_part_of_the_disk_that_cannot_be_read_is_not_intact(tmp_path, monkeypatch):
    def refuse(*_):
        raise OSError(errno.EIO, "Input/output error")

    array = np.memmap(tmp_path / "D", float, "w+", shape=(4, 4))
    with FileTarget.of(array).opened() as writer:
        monkeypatch.setattr(_writers, "_read", refuse)
        assert writer.checksums(Tile(0, 4, 0, 4), None) is None


def test_a_full_disk_is_an_error_and_no_noted_tile_is_lost(tmp_path, X, monkeypatch):
    calls, write = count(), _writers.FileWriter._put_bytes

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    def filling(writer, *arguments):
        if next(calls) == 300:
            monkeypatch.setattr(_writers, "pwrite", full)
        return write(writer, *arguments)

    out = np.memmap(tmp_path / "D", float, "w+", shape=(150, 150))
    if _writers.pwrite is None:
        pytest.skip("Windows writes otherwise")
    with monkeypatch.context() as patch:
        patch.setattr(_writers.FileWriter, "_put_bytes", filling)
        patch.setattr(_writers, "pwrite", _writers.pwrite)  # undone at the end, too
        with pytest.raises(OSError, match="D cannot be written: No space left on device"):
            pose_distances(X, skeleton=TREE, out=out)
        patch.setattr(_writers, "pwrite", os.pwrite)
    monkeypatch.setattr(_writers, "pwrite", os.pwrite)
    _, notes = FileCheckpoint(tmp_path / "D").read()
    assert 5 < len(notes) < 20
    with counted() as tiles:
        pose_distances(X, skeleton=TREE, out=out)
    assert len(tiles) == 55 - len(notes)
    np.testing.assert_array_equal(out, pose_distances(X, skeleton=TREE))


@pytest.mark.parametrize("seconds", [-1.0, 1e9])
def test_what_is_noted_survives_a_loss_of_all_that_the_disk_did_not_have(tmp_path, X, monkeypatch, seconds):
    """As after a power failure: the file is what it was when the operating system last said that it is on the disk."""
    monkeypatch.setattr(_run, "SECONDS", seconds)
    path = tmp_path / "D.npy"
    on_disk, fdatasync = [], _writers.fdatasync

    def synced(descriptor):
        fdatasync(descriptor)
        on_disk.append(path.read_bytes())

    monkeypatch.setattr(_writers, "fdatasync", synced)
    out = np.lib.format.open_memmap(path, mode="w+", shape=(150, 150))
    with stopped_after(20):
        pose_distances(X, skeleton=TREE, out=out)
    assert len(on_disk) <= (20 if seconds < 0 else 1)  # tiles share the time of waiting for the disk
    del out
    path.write_bytes(on_disk[-1])
    _, notes = FileCheckpoint(path).read()
    assert len(notes) == 20
    with counted() as tiles:
        out = pose_distances(X, skeleton=TREE, out=np.lib.format.open_memmap(path, mode="r+"))
    assert len(tiles) == 55 - 20
    np.testing.assert_array_equal(out, pose_distances(X, skeleton=TREE))


def test_notes_are_on_the_disk_when_they_have_been_added(tmp_path, monkeypatch):
    synced = []
    monkeypatch.setattr("skpose._files.os.fsync", lambda file: synced.append(os.fstat(file).st_size))
    notes = FileCheckpoint(tmp_path / "D.npy")
    notes.start({"fingerprint": 1}, [[1]])
    assert synced[0] == notes.path.stat().st_size > 0
    notes.add([[2], [3]])
    assert synced[-1] == notes.path.stat().st_size > synced[0]
    assert notes.read() == ({"fingerprint": 1}, [[1], [2], [3]])


@pytest.mark.parametrize("n_lost", [16, 4 * 150 * 8])
def test_the_end_of_a_file_that_was_cut_off_is_computed_again(tmp_path, X, computed, n_lost):
    path = tmp_path / "D.npy"
    out = np.lib.format.open_memmap(path, mode="w+", shape=(150, 150))
    with stopped_after(55):
        pose_distances(X, skeleton=TREE, out=out)
    del out
    os.truncate(path, path.stat().st_size - n_lost)
    computed.clear()
    out = pose_distances(X, skeleton=TREE, out=np.lib.format.open_memmap(path, mode="r+"))
    assert len(computed) == (1 if n_lost == 16 else 10)  # the last tile, or the last column and its mirror image
    np.testing.assert_array_equal(out, pose_distances(X, skeleton=TREE))


@pytest.mark.parametrize("damage", ["truncated", "other bytes", "removed"])
def test_chunks_of_zarr_that_are_damaged_are_computed_again(tmp_path, X, computed, damage):
    out = zarr.create_array(tmp_path / "D.zarr", shape=(150, 150), dtype="f8", chunks=(16, 16))
    with stopped_after(55):
        pose_distances(X, skeleton=TREE, out=out)
    chunk = tmp_path / "D.zarr" / "c" / "8" / "2"  # of the mirror image of a tile
    content = chunk.read_bytes()
    if damage == "removed":
        chunk.unlink()
    else:
        chunk.write_bytes(content[:-7] if damage == "truncated" else b"\xff" * len(content))
    computed.clear()
    pose_distances(X, skeleton=TREE, out=zarr.open_array(tmp_path / "D.zarr", mode="r+"))
    assert computed == [Tile(32, 48, 128, 144)]
    np.testing.assert_array_equal(out[:], pose_distances(X, skeleton=TREE))
    assert sorted(path.name for path in (tmp_path / "D.zarr").iterdir()) == ["c", "zarr.json"]


@pytest.mark.parametrize("shards", [None, (32, 32)])
@pytest.mark.parametrize("group", ["", "group/of/matrices"])
def test_chunks_of_zarr_are_on_the_disk_before_they_are_noted(tmp_path, X, monkeypatch, shards, group):
    synced, noted, sync, add = set(), [], _zarr_writer.sync, FileCheckpoint.add

    def recorded(path):
        sync(path)
        synced.add(path)

    def checked(checkpoint, notes):
        height, width = shards or (16, 16)
        for top, _, left, *_ in notes:
            for i, j in (top // height, left // width), (left // height, top // width):
                chunk = folder / "c" / str(i) / str(j)
                assert {chunk, chunk.parent, folder / "c", folder} <= synced
        noted.extend(notes)
        add(checkpoint, notes)

    monkeypatch.setattr(_zarr_writer, "sync", recorded)
    monkeypatch.setattr(FileCheckpoint, "add", checked)
    folder = tmp_path / "D.zarr" / group
    kind = {"shape": (150, 150), "dtype": "f8", "chunks": (16, 16), "shards": shards}
    out = zarr.create_array(tmp_path / "D.zarr", name=group or None, **kind)
    pose_distances(X, skeleton=TREE, out=out)
    assert len(noted) == 55
    np.testing.assert_array_equal(out[:], pose_distances(X, skeleton=TREE))


@pytest.mark.parametrize("kind", ["npy", "zarr"])
@pytest.mark.parametrize("thread", ["the same", "another"])
def test_two_calls_do_not_write_into_one_destination_at_once(tmp_path, X, kind, thread):
    if kind == "npy":
        out = np.lib.format.open_memmap(tmp_path / "D.npy", mode="w+", shape=(150, 150))
        again = np.lib.format.open_memmap(tmp_path / "D.npy", mode="r+")
    else:
        out = zarr.create_array(tmp_path / "D.zarr", shape=(150, 150), dtype="f8", chunks=(16, 16))
        again = zarr.open_array(tmp_path / "D.zarr", mode="r+")
    errors, before = [], []

    def second():
        try:
            pose_distances(X, skeleton=TREE, out=again)
        except RuntimeError as error:
            errors.append(str(error))

    def try_it():
        before.append(out[:].copy())
        if thread == "the same":
            second()
        else:
            other = threading.Thread(target=second)
            other.start()
            other.join()

    with reported(try_it):
        pose_distances(X, skeleton=TREE, out=out)
    assert len(errors) == len(before) == 55
    assert all(f"is being written by another thread of this process ({os.getpid()})" in error for error in errors)
    np.testing.assert_array_equal(out[:], pose_distances(X, skeleton=TREE))
    second()  # nobody writes any more
    assert len(errors) == 55
    assert not list(tmp_path.rglob("*lock"))


@pytest.mark.parametrize("what", ["deleted", "replaced", "shorter"])
@pytest.mark.skipif(os.name != "posix", reason="elsewhere a mapped file stays where it is")
def test_a_mapping_of_a_file_that_is_not_there_any_more_is_refused(tmp_path, X, what):
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


@pytest.fixture(params=["npy", "zarr", "zarr in memory"])
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


@pytest.mark.parametrize("n_tiles", [1, 30, 54])
def test_an_array_that_is_created_again_while_it_is_written_is_an_error_and_can_be_continued(
    created, X, before_write, computed, n_tiles
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
def test_a_file_that_is_replaced_while_it_is_written_is_an_error(tmp_path, X, before_write, what):
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
def test_a_zarr_array_that_was_created_again_otherwise_is_refused(created, X, before_write, kind, when):
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


def test_a_zarr_array_without_its_folder_is_refused(tmp_path, X, monkeypatch):
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


def test_a_second_call_after_the_folder_was_emptied_stops_the_first(tmp_path, X, monkeypatch):
    """The lock goes with the folder, so that another call can begin: it keeps its lock and its notes."""
    kind = {"shape": (150, 150), "dtype": "f8", "chunks": (16, 16)}
    out, calls = zarr.create_array(tmp_path / "D.zarr", **kind), count(1)
    monkeypatch.setattr("skpose._parallel.checkpoint.SECONDS", -1.0)

    def begin_again():
        if next(calls) == 20:
            zarr.create_array(tmp_path / "D.zarr", **kind, overwrite=True)
            stack.enter_context(locked(tmp_path / "D.zarr"))

    with ExitStack() as stack:
        with reported(begin_again), pytest.raises(RuntimeError, match=r"skpose.lock was removed, and is the lock of"):
            pose_distances(X, skeleton=TREE, out=out)
        assert next(calls) < 30
        assert (tmp_path / "D.zarr" / "skpose.lock").exists()
        assert not (tmp_path / "D.zarr" / "skpose.progress").exists()


def test_notes_that_are_removed_meanwhile_are_written_again(tmp_path, X):
    path, calls = tmp_path / "D.npy", count(1)
    out = np.lib.format.open_memmap(path, mode="w+", shape=(150, 150))

    def advance():
        n_tiles = next(calls)
        if n_tiles == 10:
            FileCheckpoint(path).path.unlink()
        elif n_tiles == 20:
            raise Stop

    with reported(advance), pytest.raises(Stop):
        pose_distances(X, skeleton=TREE, out=out)
    assert len({tuple(note) for note in FileCheckpoint(path).read()[1]}) == 20
    with counted() as tiles:
        pose_distances(X, skeleton=TREE, out=out)
    assert len(tiles) == 35


@pytest.mark.parametrize("edge", [-16, 0, "16", 16.0, 16.5, True, None, [16], 10**30, "missing"])
def test_notes_with_another_head_are_an_error(tmp_path, X, edge):
    path = tmp_path / "D.npy"
    out = np.lib.format.open_memmap(path, mode="w+", shape=(150, 150))
    with stopped_after(5):
        pose_distances(X, skeleton=TREE, out=out)
    head, *notes = FileCheckpoint(path).path.read_text().splitlines()
    head = {**json.loads(head), "edge": edge}
    if edge == "missing":
        del head["edge"]
    content = "\n".join([json.dumps(head), *notes])
    FileCheckpoint(path).path.write_text(content)
    with pytest.raises(ValueError, match=r"D\.npy\.progress is where skpose keeps its notes, but it holds something"):
        pose_distances(X, skeleton=TREE, out=out)
    assert FileCheckpoint(path).path.read_text() == content


@pytest.mark.parametrize("attribute", ["x", {}, [], 0, {"head": 1, "notes": 2}, {"head": {}, "notes": []}], ids=str)
def test_an_attribute_that_is_no_notes_is_an_error(X, attribute):
    out = zarr.create_array({}, shape=(150, 150), dtype="f8", chunks=(16, 16))
    out.attrs["skpose.unfinished"] = attribute
    with pytest.raises(ValueError, match=r"the attribute 'skpose\.unfinished' of out is where .* delete it"):
        pose_distances(X, skeleton=TREE, out=out)


DAMAGED = {
    "words": ["a"] * 8,
    "null": [None] * 8,
    "nested": [[1]] * 8,
    "objects": [{}] * 8,
    "true": [False, 16, False, 16, True, True, False, 0.0],
    "below": [-16, 0, -16, 0, 0, 0, 0, 0.0],
    "far rows": [0, 10**15, 0, 16, 0, 0, 0, 0.0],
    "far away": [160, 176, 160, 176, 0, 0, 0, 0.0],
    "between": [1, 17, 16, 32, 0, 0, 0, 0.0],
    "lower triangle": [16, 32, 0, 16, 0, 0, 0, 0.0],
    "empty": [0, 0, 0, 0, 0, 0, 0, 0.0],
    "short": [0, 16, 0, 16, 0, 0, 0],
}


@pytest.mark.parametrize("fields", [*DAMAGED, "floats", "count", "gap", "negative count", "twice", "brackets"])
def test_notes_that_are_no_tiles_of_the_matrix_are_ignored(tmp_path, X, computed, fields):
    path = tmp_path / "D.npy"
    out = np.lib.format.open_memmap(path, mode="w+", shape=(150, 150))
    with stopped_after(5):
        pose_distances(X, skeleton=TREE, out=out)
    head, *notes = FileCheckpoint(path).path.read_text().splitlines()
    note = json.loads(notes[1])
    changed = {
        "floats": [float(number) for number in note],
        "count": [*note[:6], "x", 0.0],
        "gap": [*note[:7], "x"],
        "negative count": [*note[:6], -1, 0.0],
        "twice": note,
    } | DAMAGED
    notes[1] = "[" * 100_000 if fields == "brackets" else json.dumps(changed[fields])
    FileCheckpoint(path).path.write_text("\n".join([head, *notes, notes[1], ""]))
    computed.clear()
    pose_distances(X, skeleton=TREE, out=out)
    assert len(computed) == (50 if fields == "twice" else 51)
    np.testing.assert_array_equal(out, pose_distances(X, skeleton=TREE))


def test_the_next_tile_is_computed_while_one_is_written(tmp_path, X, monkeypatch):
    """The first write ends only when the second tile is being computed."""
    computing, calls = threading.Event(), count()
    compute, write = DistanceMatrix.distances, _writers.FileWriter.write

    def computed(*arguments):
        if next(calls) == 1:
            computing.set()
        return compute(*arguments)

    def written(*arguments):
        assert computing.wait(60)
        return write(*arguments)

    monkeypatch.setattr(DistanceMatrix, "distances", computed)
    monkeypatch.setattr(_writers.FileWriter, "write", written)
    out = np.memmap(tmp_path / "D", float, "w+", shape=(150, 150))
    pose_distances(X, skeleton=TREE, out=out)
    monkeypatch.undo()
    np.testing.assert_array_equal(out, pose_distances(X, skeleton=TREE))


def test_an_error_while_a_tile_is_written_is_raised(tmp_path, X, monkeypatch):
    def fail(*_):
        raise Stop

    monkeypatch.setattr(_writers.FileWriter, "write", fail)
    with pytest.raises(Stop):
        pose_distances(X, skeleton=TREE, out=np.memmap(tmp_path / "D", float, "w+", shape=(150, 150)))
    assert not (tmp_path / "D.lock").exists()


@pytest.mark.parametrize(
    ("edge", "chunk", "longest", "found"),
    [(64, 1, 64, 64), (64, 16, 64, 64), (64, 20, 64, 60), (16, 20, 64, 20), (64, 64, 64, 64), (64, 65, 64, 64)],
)
def test_tiles_are_made_of_whole_chunks_where_these_are_short_enough(edge, chunk, longest, found):
    tiling = Tiling((1000, 1000), edge, True).in_chunks(chunk, longest)
    assert tiling.edge == found
    assert tiling.is_in_chunks(chunk) == (found % chunk == 0)
    assert tiling._replace(shape=(found, found - 1)).is_in_chunks(chunk)  # a single tile
