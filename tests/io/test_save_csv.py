"""Tables of angles and of positions: pandas, numpy and the library read what was written."""

import numpy as np
import pandas
import pytest
from conftest import SKELETONS

from skpose import Keypoints, Motion
from skpose.io import load_keypoints, save_csv


def moved(skeleton, **more):
    rng = np.random.default_rng(0)
    root = {"root_positions": rng.normal(size=(4, 3)), "root_angles": rng.normal(size=(4, 3)), "root_axes": "ZXY"}
    given = {"frame_numbers": [0, 1, 5, 6], "up": "z"}
    return Motion(skeleton, rng.uniform(-3, 3, (4, skeleton.n_dofs)), 29.97, **root | given | more)


@pytest.mark.parametrize("name", ["bvh", "mixed joints"])
def test_pandas_reads_the_angles(name, tmp_path):
    motion = moved(SKELETONS[name])
    save_csv(tmp_path / "a.csv", motion)
    table = pandas.read_csv(tmp_path / "a.csv")
    heads = ["frame", "time", "frame_rate", "up", "root_axes", "root_x", "root_y", "root_z"]
    assert list(table.columns) == [*heads, "root_rz", "root_rx", "root_ry", *motion.skeleton.dof_names]
    np.testing.assert_array_equal(table["frame"], motion.frame_numbers)
    np.testing.assert_array_equal(table["time"], motion.times)
    again = Motion(
        motion.skeleton,
        table[list(motion.skeleton.dof_names)],
        table["frame_rate"][0],
        table[["root_x", "root_y", "root_z"]],
        table[["root_rz", "root_rx", "root_ry"]],
        table["root_axes"][0],
        table["frame"],
        table["up"][0],
    )
    for field in ("angles", "root_positions", "root_angles", "frame_numbers"):
        np.testing.assert_array_equal(getattr(again, field), getattr(motion, field))
    assert (again.frame_rate, again.up, again.root_axes) == (29.97, "z", "ZXY")


def seen(names=("hip", "left knee", "toe.L"), sure=None, **more):
    positions = np.random.default_rng(0).normal(size=(5, len(names), 3))
    positions[2, 1] = np.nan
    return Keypoints(positions, names, 29.97, sure, **more)


@pytest.mark.parametrize("sure", [None, np.linspace(0.1, 1, 15).reshape(5, 3)])
def test_keypoints_are_read_as_they_were(sure, tmp_path):
    points = seen(sure=sure, up="z")
    save_csv(tmp_path / "a.csv", points)
    again = load_keypoints(tmp_path / "a.csv")
    np.testing.assert_array_equal(again.positions, points.positions)
    np.testing.assert_array_equal(again.confidences, points.confidences)
    assert (again.names, again.frame_rate, again.up) == (points.names, points.frame_rate, "z")
    table = pandas.read_csv(tmp_path / "a.csv")
    np.testing.assert_array_equal(table[["hip_x", "hip_y", "hip_z"]], points.positions[:, 0])
    assert ("hip_confidence" in table) == (sure is not None)
    with pytest.warns(UserWarning, match="frames are at .* Hz by 'time', but 10 Hz is taken"):
        assert load_keypoints(tmp_path / "a.csv", frame_rate=10, up="y").frame_rate == 10


@pytest.mark.parametrize("name", ["hip.", "n" * 120])
def test_names_of_points_that_would_be_others_are_refused(name, tmp_path):
    with pytest.raises(ValueError, match=name[:9]):
        save_csv(tmp_path / "a.csv", seen((name, "knee")))


def test_no_cell_is_a_formula(tmp_path):
    names = ("=1+1", "-a", "+a", "@a", "'=a", "'a")
    save_csv(tmp_path / "a.csv", seen(names))
    header = (tmp_path / "a.csv").read_text().splitlines()[0].split(",")
    assert not any(cell.startswith(("=", "+", "-", "@")) for cell in header)
    assert load_keypoints(tmp_path / "a.csv").names == names
    with pytest.raises(ValueError, match="frame"):
        save_csv(tmp_path / "b.csv", seen(names)[:0])


def test_no_file_is_replaced_and_nothing_else_is_written(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("mine")
    with pytest.raises(FileExistsError):
        save_csv(path, seen())
    assert path.read_text() == "mine"
    with pytest.raises(TypeError, match="content"):
        save_csv(tmp_path / "b.csv", [1])
