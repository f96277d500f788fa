"""Folders of motions: which files are read, their labels, their units, and files that cannot be read."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from skpose.datasets import load_motions, make_gait
from skpose.io import MocapFormatError, load_bvh, save_bvh, save_npz

GAIT = make_gait(2, 1, duration=0.2, random_state=0)
UNITS = {"centimetres": 0.01, "inches": 0.0254, "metres": 1.0, "millimetres": 0.001}


@pytest.fixture
def folder(tmp_path):
    """Each file in another unit, in two folders."""
    for motion, subject, action, unit in zip(GAIT, GAIT.subjects, GAIT.actions, UNITS.values(), strict=True):
        (tmp_path / "takes" / action).mkdir(parents=True, exist_ok=True)
        save_bvh(tmp_path / "takes" / action / f"p{subject}_{action}_1.bvh", motion, scale=unit)
    return tmp_path / "takes"


def test_names_state_labels_and_sizes_state_units(folder):
    dataset = load_motions(folder)
    assert list(zip(dataset.subjects, dataset.actions, dataset.trials, strict=True)) == [
        ("p01", "run", "1"), ("p02", "run", "1"), ("p01", "walk", "1"), ("p02", "walk", "1"),
    ]  # fmt: skip
    lengths = [np.linalg.norm(motion.skeleton.offsets, axis=1).sum() for motion in dataset]
    assert max(lengths) < 1.2 * min(lengths)
    with pytest.raises(ValueError, match="unit"), pytest.warns(UserWarning, match="scale"):
        load_motions(folder, scale=1.0)


def test_patterns_and_tables(folder):
    dataset = load_motions(str(folder / "walk" / "*.bvh"), pattern="{action}/p{subject}_{kind}_{trial}")
    assert (list(dataset.subjects), list(dataset.actions)) == (["01", "02"], ["walk", "walk"])
    (folder / "table.csv").write_text("file,action\nrun/p02_run_1.bvh,jog\nwalk/p01_walk_1.bvh,stroll\n")
    dataset = load_motions(folder, table=folder / "table.csv")
    assert list(dataset.actions) == ["jog", "stroll"]
    assert not hasattr(dataset, "subjects")
    (folder / "table.csv").write_text("path\na.bvh\n")
    with pytest.raises(MocapFormatError, match="file"):
        load_motions(folder, table=folder / "table.csv")
    with pytest.raises(FileNotFoundError):
        load_motions(folder / "*.c3d")


def test_files_that_cannot_be_read_or_have_other_names(folder):
    (folder / "walk" / "p03_walk_1.bvh").write_text("HIERARCHY")
    with pytest.warns(UserWarning, match=r"1 of 5 .*p03_walk_1.bvh"):
        assert len(load_motions(folder)) == 4
    with pytest.raises(MocapFormatError):
        load_motions(folder, on_error="raise")
    shutil.move(folder / "walk" / "p02_walk_1.bvh", folder / "walk" / "p03_walk_1.bvh")
    shutil.move(folder / "walk" / "p03_walk_1.bvh", folder / "walk" / "walk.bvh")
    with pytest.warns(UserWarning, match=r"SUBJECT_ACTION_TRIAL.bvh.*walk.bvh"):
        assert list(load_motions(folder).subjects) == ["p01", "p02", "p01", ""]


def test_other_formats_and_options(folder):
    save_npz(folder.parent / "a_b_c.npz", GAIT.motions[0])
    files = [folder.parent / "a_b_c.npz", *Path(folder).rglob("p01_walk_1.bvh")]
    dataset = load_motions(files, rotations="file", up="z")
    assert {motion.up for motion in dataset} == {"z"}
    assert dataset.motions[1].skeleton == load_bvh(files[1], scale="auto").skeleton


@pytest.mark.filterwarnings("ignore:expected names such as")
def test_folders_are_no_parts_of_names(folder, tmp_path):
    one = next(folder.rglob("*.bvh"))
    (tmp_path / "my_data").mkdir()
    shutil.copy(one, tmp_path / "my_data" / "clip_2.bvh")
    shutil.copy(one, tmp_path / "my_data" / "anna_walk_2.bvh")
    dataset = load_motions(tmp_path / "my_data")
    assert (dataset.subjects.tolist(), dataset.actions.tolist()) == (["anna", ""], ["walk", ""])
