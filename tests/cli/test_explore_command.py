"""`skpose explore`: a page of the poses of files."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from skpose._cli.main import main
from skpose.datasets import MotionDataset, load_cmu, load_hdm05, make_gait
from skpose.io import load_bvh, save_bvh
from skpose.view import explorer


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Files of walks and runs of two people, with their labels in their names."""
    monkeypatch.chdir(tmp_path)
    Path("gait").mkdir()
    gait = make_gait(n_subjects=2, n_sequences=1, duration=1.0, frame_rate=24, random_state=0)
    for motion, *labels in zip(gait, gait.subjects, gait.actions, gait.trials, strict=True):
        save_bvh(f"gait/{'_'.join(labels)}.bvh", motion, scale=1.0)
    return tmp_path


def shown(path="explore.html"):
    """What the page's scripts read."""
    text = Path(path).read_text(encoding="utf-8")
    return json.loads(re.findall(r'id="data">(.*?)</script>', text, flags=re.S)[0])


def groups(data):
    """The label of each motion by kind."""
    return {group["by"]: np.array(group["names"])[group["of"]].tolist() for group in data["groups"]}


def explore(*arguments):
    return main(["explore", *arguments, "--out", "explore.html"])


def read():
    """The motions of the folder, as `load_bvh` reads them."""
    files = sorted(Path("gait").glob("*.bvh"))
    subjects, actions, trials = zip(*(file.stem.split("_") for file in files), strict=True)
    return MotionDataset([load_bvh(file, scale=1.0) for file in files], subjects, trials, actions)


def test_page_of_a_folder_with_labels_in_the_names(capsys):
    assert explore("gait", "--metric", "spatial", "angle") == 0
    expected = explorer(read(), metrics=["spatial", "angle"])
    assert shown() == json.loads(json.dumps(shown_of(expected)))
    line = capsys.readouterr().out.splitlines()[-1]
    assert line == f"explore.html: {expected.note}, {expected.n_bytes / 1e6:.2g} MB"


def shown_of(page):
    return json.loads(re.findall(r'id="data">(.*?)</script>', page.html, flags=re.S)[0])


def test_all_metrics_but_the_geodesic_at_12_hz():
    assert explore("gait") == 0
    data = shown()
    assert [one["metric"] for one in data["embeddings"]] == ["spatial", "position", "rotation", "angle"]
    assert (data["rate"], data["counts"]) == (12.0, [12] * 4)
    Path("explore.html").unlink()
    assert explore("gait", "--frame-rate", "24", "--metric", "position") == 0
    assert (shown()["rate"], shown()["counts"]) == (24.0, [24] * 4)


def test_files_without_labels_have_their_names():
    files = sorted(Path("gait").glob("*.bvh"))[:2]
    for name, file in zip(("slow.bvh", "quick.bvh"), files, strict=True):
        shutil.copy(file, name)
    assert explore("slow.bvh", "quick.bvh", "--metric", "angle") == 0
    assert shown()["labels"] == ["slow.bvh", "quick.bvh"]
    assert shown()["groups"] == []


def test_some_files_with_labels():
    shutil.copy(sorted(Path("gait").glob("*.bvh"))[0], "some.bvh")
    assert explore("gait", "some.bvh", "--metric", "angle") == 0
    data = shown()
    assert data["labels"] == [*(file.name for file in sorted(Path("gait").glob("*.bvh"))), "some.bvh"]
    assert groups(data)["action"] == [*read().actions, ""]


def test_preparing_the_poses():
    """--rotations, --with-root and the like are those of the other commands."""
    assert explore("gait", "--rotations", "rotvec", "--with-root", "tilt", "--metric", "spatial") == 0
    prepared = read().to_rotvec().with_root("tilt")
    expected = shown_of(explorer(prepared, metrics=["spatial"]))
    assert shown()["skeleton"] == expected["skeleton"]
    assert shown()["poses"] == expected["poses"]


def test_an_index_has_labels_and_rates(tmp_path):
    """Of AMC files, whose rates no file states."""
    data = Path(__file__).parent.parent / "data"
    for name in ("a", "b"):
        Path("cmu", name).mkdir(parents=True)
        shutil.copy(data / "arm.asf", f"cmu/{name}/arm.asf")
        shutil.copy(data / "arm.amc", f"cmu/{name}/arm.amc")
    rows = ["subject,trial,action,frames_per_second,file", "Anna,1,wave,60,a/arm.amc", "Ben,2,point,30,b/arm.amc"]
    Path("cmu/index.csv").write_text("\n".join(rows))
    assert explore("cmu", "--metric", "position", "--frame-rate", "30") == 0
    found = shown()
    assert groups(found) == {"subject": ["Anna", "Ben"], "action": ["wave", "point"]}
    assert found["labels"] == ["Anna · wave · 1", "Ben · point · 2"]
    expected = shown_of(explorer(load_cmu("cmu"), metrics=["position"], frame_rate=30))
    assert found["counts"] == expected["counts"]
    assert found["counts"][0] < found["counts"][1]  # the first lasts half as long


@pytest.mark.slow
def test_folders_of_databases(cmu_folder, hdm05_folder, tmp_path):
    for folder, load in ((cmu_folder, load_cmu), (hdm05_folder, load_hdm05)):
        Path("explore.html").unlink(missing_ok=True)
        assert explore(str(folder), "--metric", "position") == 0
        dataset, found = load(folder), shown()
        assert sorted(groups(found)["subject"]) == sorted(dataset.subjects)
        assert sorted(groups(found)["action"]) == sorted(dataset.actions)
        assert sum(found["counts"]) == len(dataset.poses(12)[0])


def test_names_as_those_of_the_databases():
    from skpose._cli.labels import labels_of

    names = ["02_01.amc", "HDM_bd_squat1Reps_001_120.amc", "anna_run_fast_2.bvh", "anna_run_3.bvh.gz", "other.bvh"]
    found = labels_of([Path("x") / name for name in names])
    assert found.subjects == ["02", "bd", "anna", "anna", ""]
    assert found.actions == ["", "squat1Reps", "run fast", "run", ""]
    assert found.trials == ["01", "squat1Reps 001", "2", "3", ""]


def test_what_is_refused_leaves_no_page(capsys):
    Path("empty").mkdir()
    assert explore("empty") == 1
    assert "the folder empty holds no files named *.bvh, *.amc" in capsys.readouterr().err
    assert not Path("explore.html").exists()
    Path("explore.html").write_text("mine")
    assert explore("gait") == 1
    assert "explore.html already exists" in capsys.readouterr().err
    assert Path("explore.html").read_text() == "mine"
    for arguments in (["--metric", "euclidean"], ["--out", "explore.htm"]):
        with pytest.raises(SystemExit) as stop:
            main(["explore", "gait", "--out", "new.html", *arguments])
        assert stop.value.code == 2
