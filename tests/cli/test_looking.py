"""`skpose info`, `view` and `explore`."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from skpose._cli.main import main
from skpose.datasets import MotionDataset
from skpose.io import load_bvh, save_npz
from skpose.keypoints import layouts
from skpose.motions import align_motions
from skpose.view import explorer, player

pytestmark = pytest.mark.usefixtures("walks_in_folder")
SIDES = [0, 114, 178], [213, 94, 0]  # colours of left and right


def data_of(html):
    """What the scripts of a page read."""
    return json.loads(re.findall(r'id="data">(.*?)</script>', html, flags=re.S)[0])


def shown(path):
    return data_of(Path(path).read_text(encoding="utf-8"))


@pytest.fixture
def squat():
    """A file of keypoints, squat.npz, the last two frames of which are not seen."""
    layout = layouts["coco17"]
    sides = [{"l": 0.15, "r": -0.15}.get(name[0], 0.0) for name in layout.names]
    standing = np.stack([sides, np.linspace(1.7, 0.1, 17), 0.03 * np.arange(17) % 0.1], axis=1)
    positions = standing * np.linspace(1, 0.8, 13)[:, None, None]
    positions[-2:] = np.nan
    points = layout.keypoints(positions, 30)
    save_npz("squat.npz", points)
    return points


def test_info_of_motions(capsys):
    assert main(["info", "anna.bvh", "ben.bvh"]) == 0
    lines = capsys.readouterr().out.splitlines()
    motion = load_bvh("anna.bvh")
    assert lines[:2] == ["anna.bvh", "20 frames at 20 Hz, 1.00 s, y up"]
    assert "ben.bvh" in lines
    for bone in motion.skeleton.bones:
        (line,) = (line for line in lines[4 : lines.index("ben.bvh")] if line.split()[:1] == [bone.name])
        parent, length = line.split()[1:3]
        assert parent == (bone.parent or motion.root_name)
        assert float(length) == pytest.approx(np.linalg.norm(bone.offset), abs=1e-3)


def test_info_of_points(squat, capsys):
    assert main(["info", "squat.npz"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "13 frames at 30 Hz, 0.43 s"
    assert lines[-1].split() == [squat.names[-1], "15.4%"]


def test_page_of_motions_and_points(squat, capsys):
    assert main(["view", "anna.bvh", "squat.npz", "--overlay", "--out", "view.html"]) == 0
    expected = player([load_bvh("anna.bvh"), squat], labels=["anna.bvh", "squat.npz"], overlay=True)
    assert shown("view.html") == data_of(expected.html)
    assert capsys.readouterr().out.startswith(f"view.html: {expected.note}")
    assert main(["view", "squat.npz", "--frame-rate", "10", "--out", "slow.html"]) == 0  # every third frame
    assert shown("slow.html")["motions"][0]["rate"] == 10
    assert main(["view", "squat.npz", "--frame-rate", "20", "--out", "other.html"]) == 1
    assert "--frame-rate" in capsys.readouterr().err


def test_aligned():
    assert main(["view", "anna.bvh", "ben.bvh", "--align", "--out", "view.html"]) == 0
    motions = [load_bvh("anna.bvh"), load_bvh("ben.bvh")]
    expected = player(motions, labels=["anna.bvh", "ben.bvh"], alignment=align_motions(*motions))
    assert shown("view.html") == data_of(expected.html)


@pytest.mark.parametrize("command", ["view", "explore"])
def test_open(command, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    assert main([command, "anna.bvh"]) == 1  # nothing to do
    more = ["--metric", "position"] if command == "explore" else []
    assert main([command, "anna.bvh", "--open", *more]) == 0
    assert len(opened) == 1
    assert not list(Path().glob("*.html"))


def test_picture_of_motions(squat, capsys):
    assert main(["view", "anna.bvh", "ben.bvh", "--png", "both.png"]) == 0
    with Image.open("both.png") as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    for half in np.array_split(pixels, 2):
        assert all((np.abs(half - colour).max(axis=2) < 40).sum() > 30 for colour in SIDES)
    assert main(["view", "squat.npz", "--png", "points.png"]) == 1
    assert "keypoints" in capsys.readouterr().err


def test_explorer_with_labels_of_the_names():
    motions = []
    for old, new in (("anna", "anna_walk_1"), ("ben", "ben_walk_1")):
        Path(f"{old}.bvh").rename(f"{new}.bvh")
        motions.append(load_bvh(f"{new}.bvh"))
    options = ["--metric", "position", "angle", "--frame-rate", "10"]
    assert main(["explore", "anna_walk_1.bvh", "ben_walk_1.bvh", *options, "--out", "e.html"]) == 0
    dataset = MotionDataset(motions, ["anna", "ben"], ["1", "1"], ["walk", "walk"])
    expected = explorer(dataset, metrics=["position", "angle"], frame_rate=10)
    assert shown("e.html") == json.loads(json.dumps(data_of(expected.html)))


def test_explorer_without_labels():
    assert main(["explore", "anna.bvh", "ben.bvh", "--metric", "position", "--out", "e.html"]) == 0
    dataset = MotionDataset([load_bvh("anna.bvh"), load_bvh("ben.bvh")])
    expected = explorer(dataset, metrics=["position"], labels=["anna.bvh", "ben.bvh"])
    assert shown("e.html") == json.loads(json.dumps(data_of(expected.html)))
