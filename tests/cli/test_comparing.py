"""`skpose distances` and `find`."""

import csv

import numpy as np
import pytest

from skpose import pose_distances
from skpose._cli.main import main
from skpose.datasets import MotionDataset
from skpose.io import load_bvh
from skpose.motions import find_motion

pytestmark = pytest.mark.usefixtures("walks_in_folder")
FILES = ["anna.bvh", "ben.bvh"]
RATE = 20


@pytest.fixture
def dataset():
    """The motions as the commands compare them: on the mean skeleton."""
    dataset = MotionDataset([load_bvh(name) for name in FILES])
    return dataset.retarget(dataset.skeleton)


@pytest.mark.parametrize(("metric", "dtype"), [("spatial", "float64"), ("angle", "float64"), ("position", "float32")])
def test_distances(metric, dtype, dataset, capsys):
    assert main(["distances", *FILES, "--metric", metric, "--dtype", dtype, "--out", "D.npy"]) == 0
    D, (X, _) = np.load("D.npy"), dataset.poses()
    assert D.dtype == dtype
    np.testing.assert_array_equal(D, pose_distances(X.astype(dtype), skeleton=dataset.skeleton, metric=metric))
    lines = capsys.readouterr().out.splitlines()
    assert [line.split() for line in lines[:2]] == [["0", "to", "19", "anna.bvh"], ["20", "to", "33", "ben.bvh"]]


def test_distances_with_names(dataset):
    X, _ = dataset.poses()
    expected = pose_distances(X, skeleton=dataset.skeleton, metric="angle")
    for name in ("D.csv", "D.npz"):
        assert main(["distances", *FILES, "--metric", "angle", "--out", name]) == 0
    with np.load("D.npz") as file:
        np.testing.assert_array_equal(file["distances"], expected)
        assert file["files"].tolist() == ["anna.bvh"] * 20 + ["ben.bvh"] * 14
        np.testing.assert_allclose(file["times"][20:], np.arange(14) / RATE)
        names = file["names"].tolist()
        assert (str(file["metric"]), str(file["unit"])) == ("angle", "rad")
    with open("D.csv", newline="", encoding="utf-8") as file:
        (corner, *columns), *rows = csv.reader(file)
    assert corner == "angle, rad"
    assert names == columns == [row[0] for row in rows]
    assert names[1] == "anna.bvh 0.0500 s"
    np.testing.assert_array_equal([[float(cell) for cell in row[1:]] for row in rows], expected)


def places(arguments, capsys):
    """Run `skpose find`; return file, numbers of each place."""
    assert main(["find", *arguments]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()[1:]]
    assert [int(row[0]) for row in rows] == list(range(1, len(rows) + 1))
    return [(row[1], *map(float, row[2:])) for row in rows]


def test_find_a_part_of_a_motion(dataset, capsys):
    a, b = dataset.motions
    found = places([*FILES, "--from", "0.2", "--to", "0.6", "--k", "2"], capsys)
    for place, match in zip(found, find_motion(a[4:12], [b], k=2, metric="spatial"), strict=True):
        expected = match.start / RATE, match.stop / RATE, match.distance
        assert place == ("ben.bvh", *(pytest.approx(value, abs=1e-2) for value in expected))
    assert main(["find", *FILES, "--from", "3"]) == 1
    assert "no frame" in capsys.readouterr().err


def test_find_without_the_query_itself(dataset, capsys):
    a, b = dataset.motions
    command = ["anna.bvh", *FILES, "--from", "0.2", "--to", "0.6"]
    assert places(command, capsys)[0] == ("anna.bvh", 0.2, 0.6, 0.0)
    best = find_motion(a[4:12], [a[:4], a[12:], b], k=1, metric="spatial")[0]
    name, start, _, distance = places([*command, "--exclude-query"], capsys)[0]
    assert (name, start) == (
        ["anna.bvh", "anna.bvh", "ben.bvh"][best.motion],
        (best.start + [0, 12, 0][best.motion]) / RATE,
    )
    assert distance == pytest.approx(best.distance, abs=1e-4)
