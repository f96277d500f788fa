"""Writers of tiles: every byte by position, notes only of what the disk has, one destination for one call at a time."""

import errno
import os
import threading
from itertools import count

import numpy as np
import pytest
import zarr
from many_tiles import X, record_tiles, use_small_tiles
from test_out import TREE, Stop, counted, reported, stopped_after

from skpose import pose_distances
from skpose._parallel.checkpoint import FileCheckpoint
from skpose.metrics import _run, _writers, _zarr_writer
from skpose.metrics._matrix import DistanceMatrix
from skpose.metrics._tiles import Tile, Tiling
from skpose.metrics._writers import FileTarget

RNG = np.random.default_rng(0)


@pytest.fixture(autouse=True)
def small_tiles(monkeypatch):
    use_small_tiles(monkeypatch)


@pytest.fixture
def computed(monkeypatch):
    return record_tiles(monkeypatch)


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
    with target.open_writer() as writer:
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
    with FileTarget.of(array).open_writer() as writer:
        writer.write(Tile(0, 4, 0, 4), None, distances)
    np.testing.assert_array_equal(array, distances.astype(np.float32))


def test_a_part_of_the_disk_that_cannot_be_read_is_not_intact(tmp_path, monkeypatch):
    def refuse(*_):
        raise OSError(errno.EIO, "Input/output error")

    array = np.memmap(tmp_path / "D", float, "w+", shape=(4, 4))
    with FileTarget.of(array).open_writer() as writer:
        monkeypatch.setattr(_writers, "_read", refuse)
        assert writer.checksums(Tile(0, 4, 0, 4), None) is None


def test_a_full_disk_is_an_error_and_no_noted_tile_is_lost(tmp_path, monkeypatch):
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
def test_what_is_noted_survives_a_loss_of_all_that_the_disk_did_not_have(tmp_path, monkeypatch, seconds):
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
def test_the_end_of_a_file_that_was_cut_off_is_computed_again(tmp_path, computed, n_lost):
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
def test_chunks_of_zarr_that_are_damaged_are_computed_again(tmp_path, computed, damage):
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
def test_chunks_of_zarr_are_on_the_disk_before_they_are_noted(tmp_path, monkeypatch, shards, group):
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


@pytest.mark.parametrize("kind", ["npy", pytest.param("zarr", marks=pytest.mark.slow)])
@pytest.mark.parametrize("thread", ["the same", "another"])
def test_two_calls_do_not_write_into_one_destination_at_once(tmp_path, kind, thread):
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


def test_the_next_tile_is_computed_while_one_is_written(tmp_path, monkeypatch):
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


def test_an_error_while_a_tile_is_written_is_raised(tmp_path, monkeypatch):
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
