"""Distances with names, as CSV and .npz, and the graphs of neighbours that `skpose neighbors` finds in them."""

import os
import re
import shutil
from pathlib import Path

import numpy as np
import pandas
import pytest
from scipy.sparse import csr_matrix, load_npz

from skpose import motion_distances, pose_distances
from skpose._cli.main import main
from skpose._cli.matrices import write_graph
from skpose._parallel.checkpoint import IDENTITY, FileCheckpoint
from skpose.datasets import MotionDataset, make_gait
from skpose.io import load_bvh, save_bvh

FILES = ["a.bvh", "b, c.bvh"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Files of two walks of two people."""
    monkeypatch.chdir(tmp_path)
    gait = make_gait(n_subjects=2, n_sequences=1, duration=1.0, frame_rate=8, random_state=0)
    for name, motion, n_frames in zip(FILES, gait.motions[1:], (8, 6), strict=False):
        save_bvh(name, motion[:n_frames], scale=1.0)
    return tmp_path


@pytest.fixture
def dataset():
    return MotionDataset([load_bvh(name, scale=1.0) for name in FILES])


def refusal(arguments, capsys, status=1):
    if status == 2:
        with pytest.raises(SystemExit) as stop:
            main(arguments)
        assert stop.value.code == 2
    else:
        assert main(arguments) == status
    return capsys.readouterr().err.splitlines()[-1]


NAMES = [f"a.bvh {i / 8:.3f} s" for i in range(8)] + [f"b, c.bvh {i / 8:.3f} s" for i in range(6)]


@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_distances_with_names(dtype, dataset, capsys):
    expected = pose_distances(dataset.poses()[0].astype(dtype), skeleton=dataset.skeleton, metric="spatial")
    for out in ("D.csv", "D.npz"):
        assert main(["distances", *FILES, "--out", out, "--dtype", dtype]) == 0
        assert capsys.readouterr().out.splitlines()[-1] == f"{out}: 14 × 14 distances with names, {dtype}"
    table = pandas.read_csv("D.csv", index_col=0)
    assert table.index.name == "spatial, m"
    assert list(table.index) == list(table.columns) == NAMES
    np.testing.assert_array_equal(table.to_numpy().astype(dtype), expected)
    with np.load("D.npz") as file:
        np.testing.assert_array_equal(file["distances"], expected)
        assert file["distances"].dtype == dtype
        assert list(file["names"]) == NAMES
        assert list(file["files"]) == ["a.bvh"] * 8 + ["b, c.bvh"] * 6
        np.testing.assert_allclose(file["times"], [*np.arange(8) / 8, *np.arange(6) / 8])
        assert (file["metric"], file["unit"]) == ("spatial", "m")
    assert sorted(os.listdir()) == ["D.csv", "D.npz", *FILES]


def test_motions_with_names(dataset):
    command = ["motions", *FILES, "a.bvh", "--metric", "angle", "--window", "0.5"]
    assert main([*command, "--out", "M.csv"]) == 0
    table = pandas.read_csv("M.csv", index_col=0)
    assert list(table.columns) == ["a.bvh", "b, c.bvh", "a.bvh (2)"]
    assert table.index.name == "angle, dtw within 0.5, rad"
    motions = [*dataset.retarget(dataset.skeleton), dataset.motions[0]]
    arrays = [motion.angles for motion in motions]
    D = motion_distances(arrays, skeleton=dataset.skeleton, metric="angle", window=0.5)
    np.testing.assert_array_equal(table, D)
    assert main([*command, "--out", "M.npz"]) == 0
    with np.load("M.npz") as file:
        assert "times" not in file
        assert list(file["files"]) == ["a.bvh", "b, c.bvh", "a.bvh"]


@pytest.mark.parametrize("suffix", [".csv", ".npz", ".npy"])
@pytest.mark.parametrize("which", [["--neighbors", "3"], ["--radius", "1.0"]])
def test_neighbors_in_a_file_of_distances_are_those_of_the_poses(suffix, which, dataset, capsys):
    assert main(["distances", *FILES, "--out", f"D{suffix}"]) == 0
    capsys.readouterr()
    assert main(["neighbors", f"D{suffix}", *which, "--out", "G.npz"]) == 0
    metric = "" if suffix == ".npy" else " by spatial, m"
    assert capsys.readouterr().out.splitlines()[0] == f"D{suffix}: 14 × 14 distances{metric}"
    assert main(["neighbors", *FILES, *which, "--out", "E.npz"]) == 0
    np.testing.assert_allclose(load_npz("G.npz").toarray(), load_npz("E.npz").toarray(), rtol=0, atol=1e-12)
    names = NAMES if suffix != ".npy" else [str(i) for i in range(14)]
    assert list(np.load("G.npz")["names"]) == names
    assert list(np.load("E.npz")["names"]) == NAMES
    D = pose_distances(dataset.poses()[0], skeleton=dataset.skeleton, metric="spatial")
    assert main(["neighbors", f"D{suffix}", *which, "--out", "G.csv"]) == 0
    table = pandas.read_csv("G.csv", dtype={"row": str, "neighbor": str})
    for i, name in enumerate(names):
        order = [j for j in np.argsort(D[i], kind="stable") if j != i]
        order = order[:3] if "--neighbors" in which else [j for j in order if D[i, j] <= 1.0]
        here = table[table["row"] == name]
        assert list(here["neighbor"]) == [names[j] for j in order]
        assert list(here["rank"]) == list(range(1, len(order) + 1))
        np.testing.assert_allclose(here["distance"], D[i, order], atol=1e-12)


def test_a_table_of_pandas_is_read():
    D = np.abs(np.subtract.outer(np.arange(4.0), np.arange(4.0) ** 2)) * (1 - np.eye(4))
    pandas.DataFrame(D, list("wxyz"), list("wxyz")).to_csv("D.csv")
    assert main(["neighbors", "D.csv", "--neighbors", "1", "--out", "G.csv"]) == 0
    nearest = np.argmin(D + 100 * np.eye(4), axis=1)
    assert list(pandas.read_csv("G.csv")["neighbor"]) == ["wxyz"[i] for i in nearest]


HEAD, ROWS = '"spatial, m",a,b', ["a,0,1", "b,1,0"]
WRONG = {
    "a row is missing": ([HEAD, ROWS[0]], "expected a row for each of the 2 columns, found 1"),
    "another name": ([HEAD, ROWS[0], "c,1,0"], r"D\.csv, line 3: expected 'b' and 2 numbers, found 'c' and 2 cells"),
    "short": ([HEAD, ROWS[0], "b,1"], "line 3: expected 'b' and 2 numbers, found 'b' and 1 cells"),
    "long": ([HEAD, *ROWS, "c,1,1"], "line 4: expected the end of the table, found 'c'"),
    "words": ([HEAD, ROWS[0], "b,x,0"], "line 3: expected distances: could not convert string to float: 'x'"),
    "negative": ([HEAD, "a,0,-1", "b,1,0"], r"zero or more, found -1\.0 of 'a' and 'b'"),
    "not a number": ([HEAD, "a,0,nan", "b,1,0"], "finite and zero or more, found nan of 'a' and 'b'"),
    "similarities": ([HEAD, "a,1,0.5", "b,0.5,1"], r"found 1\.0 of 'a'; are these similarities\?"),
}


@pytest.mark.parametrize("name", WRONG)
def test_tables_that_are_no_distances(name, capsys):
    lines, message = WRONG[name]
    Path("D.csv").write_text("\n".join(lines) + "\n")
    assert re.search(message, refusal(["neighbors", "D.csv", "--out", "G.npz"], capsys))
    assert not Path("G.npz").exists()


def test_arrays_that_are_no_distances(capsys):
    np.save("D.npy", np.zeros((2, 3)))
    assert "as many rows as columns, found 2 × 3" in refusal(["neighbors", "D.npy", "--out", "G.npz"], capsys)
    np.savez("D.npz", distances=np.zeros((2, 2)), names=["a"])
    assert "names: expected shape (2,), found (1,)" in refusal(["neighbors", "D.npz", "--out", "G.npz"], capsys)
    np.savez("E.npz", poses=np.zeros((2, 2)))  # no matrix, so that the reader of motions reports it
    assert "E.npz: poses: expected shape" in refusal(["neighbors", "E.npz", "--out", "G.npz"], capsys)


def test_an_unfinished_matrix_has_no_neighbors(capsys):
    np.save("D.npy", np.zeros((2, 2)))
    FileCheckpoint(Path("D.npy")).start({IDENTITY: "of some poses"}, [])
    assert "D.npy is unfinished: run the command that started it" in refusal(
        ["neighbors", "D.npy", "--out", "G.npz"], capsys
    )


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--metric", "angle"], "D.csv holds distances, and --metric is for files of motions: leave one of them out"),
        (["--frame-rate", "3"], "--frame-rate is for files of motions"),
        (["--amc-frame-rate", "3"], "--amc-frame-rate is for files of motions"),
        (["--retarget", "auto"], "--retarget is for files of motions"),
        (["--no-hands"], "--no-hands is for files of motions"),
        (["a.bvh"], "D.csv holds distances, and needs no other file: pass it alone"),
    ],
    ids=str,
)
def test_options_that_have_no_effect_on_distances_are_refused(options, message, capsys):
    Path("D.csv").write_text("\n".join([HEAD, *ROWS]))
    assert message in refusal(["neighbors", "D.csv", *options, "--out", "G.npz"], capsys)


def test_matrices_with_names_are_not_continued(capsys, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("skpose._cli.commands.pose_distances", interrupted)
        assert main(["distances", *FILES, "--out", "D.csv"]) == 130
    assert capsys.readouterr().err.splitlines()[-1] == "skpose: interrupted"
    assert sorted(os.listdir()) == FILES
    monkeypatch.setattr(shutil, "disk_usage", lambda _: shutil._ntuple_diskusage(10**9, 10**9, 100))
    assert "the disk has 0.0 GB free" in refusal(["distances", *FILES, "--out", "D.csv"], capsys)


@pytest.mark.filterwarnings("ignore:fast.bvh. Frame Time is:UserWarning")
def test_times_of_poses_have_digits_enough(dataset):
    save_bvh("fast.bvh", dataset.motions[0].resample(3000)[:3], scale=1.0)
    assert main(["distances", "fast.bvh", "--metric", "position", "--out", "D.csv"]) == 0
    assert len(set(pandas.read_csv("D.csv", index_col=0).columns)) == 3


def test_neighbors_in_a_table_are_sorted_by_their_distance(tmp_path):
    graph = csr_matrix(([3.0, 1.0, 2.0], [0, 1, 2], [0, 3, 3, 3]), shape=(3, 3))
    write_graph(tmp_path / "G.csv", graph, ["a", "b", "c"])
    assert (tmp_path / "G.csv").read_text() == "row,neighbor,rank,distance\na,b,1,1.0\na,c,2,2.0\na,a,3,3.0\n"
