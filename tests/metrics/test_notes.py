"""Notes on the tiles of an unfinished matrix: removed, damaged, of other matrices, or none at all."""

import json
from itertools import count

import numpy as np
import pytest
import zarr
from many_tiles import X, record_tiles, use_small_tiles
from test_out import TREE, Stop, counted, reported, stopped_after

from skpose import pose_distances
from skpose._parallel.checkpoint import FileCheckpoint


@pytest.fixture(autouse=True)
def small_tiles(monkeypatch):
    use_small_tiles(monkeypatch)


@pytest.fixture
def computed(monkeypatch):
    return record_tiles(monkeypatch)


def test_notes_that_are_removed_meanwhile_are_written_again(tmp_path):
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
def test_notes_with_another_head_are_an_error(tmp_path, edge):
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
def test_an_attribute_that_is_no_notes_is_an_error(attribute):
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
def test_notes_that_are_no_tiles_of_the_matrix_are_ignored(tmp_path, computed, fields):
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
