"""What commands read: folders, standard input, frame rates, units, labels, files that cannot be read."""

import io
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA

from skpose import pose_distances
from skpose._cli.main import main
from skpose.datasets import MotionDataset, load_cmu
from skpose.io import load_bvh, load_motion, save_npz

pytestmark = pytest.mark.usefixtures("walks_in_folder")
INDEX = "subject,trial,action,frames_per_second,file\n35,01,wave,30,subjects/35/35_01.amc\n"


@pytest.fixture
def index():
    """A file like CMU's, with an index.csv two folders above."""
    folder = Path("cmu/subjects/35")
    folder.mkdir(parents=True)
    shutil.copy(DATA / "arm.asf", folder / "35.asf")
    shutil.copy(DATA / "arm.amc", folder / "35_01.amc")
    Path("cmu/index.csv").write_text(INDEX)
    return str(folder / "35_01.amc")


def positions(*arguments):
    """Run `skpose distances` by position; return the matrix."""
    assert main(["distances", *arguments, "--metric", "position", "--out", "D.npy"]) == 0
    D = np.load("D.npy")
    Path("D.npy").unlink()
    return D


def test_a_folder_is_its_files_sorted(capsys):
    Path("takes/below").mkdir(parents=True)
    shutil.move("ben.bvh", "takes/b.BVH")
    shutil.move("anna.bvh", "takes/below/a.bvh")
    Path("takes/notes.txt").write_text("no motion")
    positions("takes")
    rows = [line.split() for line in capsys.readouterr().out.splitlines()[:2]]
    assert [Path(row[3]).name for row in rows] == ["b.BVH", "a.bvh"]
    assert [row[:3] for row in rows] == [["0", "to", "13"], ["14", "to", "33"]]
    assert main(["info", "takes/below/../below", "DATA"]) == 1
    Path("empty").mkdir()
    assert main(["info", "empty"]) == 1


def test_standard_input(monkeypatch, capsys):
    expected = positions("anna.bvh", "ben.bvh")
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(Path("ben.bvh").read_bytes())))
    np.testing.assert_array_equal(positions("anna.bvh", "-"), expected)
    assert "standard input" in capsys.readouterr().out


@pytest.mark.filterwarnings("default:--file-frame-rate")
def test_frame_rates_of_amc_files(index, capsys):
    """By the option, by an index above the file, or by a name as in HDM05."""
    shutil.copy(DATA / "arm.asf", "HDM_bd.asf")
    shutil.copy(DATA / "arm.amc", "HDM_bd_wave_001_060.amc")
    assert main(["info", index, "HDM_bd_wave_001_060.amc"]) == 0
    assert main(["info", index, "--file-frame-rate", "50"]) == 0
    printed = capsys.readouterr()
    assert "--file-frame-rate" in printed.err
    lines = [line for line in printed.out.splitlines() if "frames at" in line]
    assert [line.split()[3] for line in lines] == ["30", "60", "50"]


def test_only_an_index_near_the_file_counts_and_is_named(capsys):
    Path("a/b/c").mkdir(parents=True)
    shutil.copy(DATA / "arm.asf", "a/b/c/35.asf")
    shutil.copy(DATA / "arm.amc", "a/b/c/35_01.amc")
    text = INDEX.replace("subjects/35/", "")
    for folder, is_read in (("a", False), ("a/b", True), ("a/b/c", True)):
        path = Path(folder, "index.csv")
        path.write_text(text.replace("35_01.amc", Path("a/b/c/35_01.amc").relative_to(folder).as_posix()))
        assert main(["info", "a/b/c/35_01.amc", *(() if is_read else ("--file-frame-rate", "50"))]) == 0
        assert (str(path) in capsys.readouterr().err) == is_read
        path.unlink()


def test_distances_of_an_index_are_those_of_load_cmu(index):
    dataset = load_cmu("cmu")
    X, _ = dataset.poses(60)
    D = pose_distances(X, skeleton=dataset.skeleton, metric="position")
    np.testing.assert_allclose(positions("cmu", "--frame-rate", "60"), D, atol=1e-12)


def test_options_reach_the_loader(index, capsys):
    assert main(["info", "anna.bvh", "--scale", "2", "--up", "z", "--root-offset", "add"]) == 0
    out = capsys.readouterr().out
    assert "z up" in out
    length = 2 * np.linalg.norm(load_bvh("anna.bvh").skeleton.offsets[0])
    assert f"{length:.3f}" in out
    assert main(["info", "anna.bvh", "--root", "nobody"]) == 1
    assert "nobody" in capsys.readouterr().err


def test_files_that_cannot_be_read_are_left_out(capsys):
    Path("bad.bvh").write_text("HIERARCHY")
    assert main(["info", "bad.bvh", "ben.bvh", "--skip-errors"]) == 3
    captured = capsys.readouterr()
    assert captured.err.startswith("skpose: left out: bad.bvh")
    assert captured.out.splitlines()[0].startswith("14 frames")
    assert main(["find", "bad.bvh", "ben.bvh", "--skip-errors"]) == 1  # the query is needed
    assert main(["info", "bad.bvh", "--skip-errors"]) == 1


def test_preparing():
    """Ball joints, the tilt of the root, another rate, and the skeleton of the first file."""
    dataset = MotionDataset([load_bvh("anna.bvh"), load_bvh("ben.bvh")])
    dataset = dataset.retarget(dataset.motions[0].skeleton, method="orientations").with_root("tilt")
    X = np.concatenate([motion.resample(10).angles for motion in dataset])
    expected = pose_distances(X, skeleton=dataset.motions[0].skeleton, metric="position")
    options = ["--retarget", "orientations", "--with-root", "tilt", "--frame-rate", "10"]
    np.testing.assert_allclose(positions("anna.bvh", "ben.bvh", *options), expected, atol=1e-12)


def test_a_folder_of_npz_files_and_a_scale_for_the_other_file(capsys):
    """The scale of a BVH file in centimetres is not for motions in metres."""
    Path("saved").mkdir()
    save_npz("saved/a.npz", load_bvh("anna.bvh"))
    np.savez("saved/shape.npz", betas=np.zeros(16))  # as in AMASS
    assert main(["info", "saved"]) == 0
    assert "degrees of freedom" in capsys.readouterr().out
    assert main(["retarget", "anna.bvh", "--scale", "1.1", "--onto", "saved/a.npz", "--out", "there.npz"]) == 0
    assert load_motion("there.npz").skeleton == load_motion("saved/a.npz").skeleton
