"""HDM05: hand-written files under its names, and real files if SKPOSE_HDM05 names their folder."""

import shutil

import numpy as np
import pytest
from conftest import DATA

from skpose.datasets import load_hdm05


@pytest.fixture
def folder(tmp_path):
    """The hand-written arm as two people, in folders of actions."""
    for action, names in {
        "squat": ["bd_squat1Reps_001_120", "bk_squat1Reps_012_60"],
        "walk": ["bd_01-02_03_120"],
    }.items():
        (tmp_path / action).mkdir()
        for name in names:
            shutil.copy(DATA / "arm.amc", tmp_path / action / f"HDM_{name}.amc")
            shutil.copy(DATA / "arm.asf", tmp_path / action / f"HDM_{name.split('_')[0]}.asf")
    return tmp_path


def test_names_of_files_state_everything(folder):
    dataset = load_hdm05(str(folder))
    assert list(zip(dataset.subjects, dataset.actions, dataset.trials, strict=True)) == [
        ("bd", "squat1Reps", "squat1Reps_001"), ("bk", "squat1Reps", "squat1Reps_012"), ("bd", "01-02", "01-02_03"),
    ]  # fmt: skip
    assert [motion.frame_rate for motion in dataset] == [120, 60, 120]


def test_a_folder_without_such_files(tmp_path):
    shutil.copy(DATA / "arm.amc", tmp_path / "walk.amc")
    with pytest.raises(FileNotFoundError, match="neither"):
        load_hdm05(tmp_path)


def test_the_real_files(hdm05, hdm05_folder):
    """People lie down and stand: the tilt of the trunk shows it."""
    paths = list(hdm05_folder.rglob("HDM_*.amc"))
    assert len(hdm05) == len(paths)
    assert len({motion.skeleton for motion in hdm05}) == len(set(hdm05.subjects)) < len(hdm05)
    rooted = hdm05.with_root("tilt")
    tilts = [np.degrees(np.linalg.norm(motion.angles[:, :3], axis=1)) for motion in rooted]
    lies = np.array([np.max(tilt) for tilt in tilts]) > 60
    lying = np.char.startswith(hdm05.actions, "lie")
    if lying.any():
        assert lies[lying].all()
    standing = np.char.startswith(hdm05.actions, "grab")
    assert not lies[standing].any()
