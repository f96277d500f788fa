"""`skpose info` on files of keypoints: what they state, and which arguments their reader needs."""

import io
import json
import sys
from pathlib import Path

import numpy as np
import pytest

from skpose._cli.main import main

POINTS = np.random.default_rng(2).uniform(0.2, 1.7, (4, 3, 3))


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def printed(capsys, *arguments):
    assert main(["info", *map(str, arguments)]) == 0
    out, err = capsys.readouterr()
    assert not err
    return out.splitlines()


def test_json_that_states_its_rate_and_no_names(capsys):
    frames = [{"keypoints_3d": [[*point, 1.0 if (i, j) != (1, 2) else 0.0] for j, point in enumerate(points)]}
              for i, points in enumerate(POINTS.tolist())]  # fmt: skip
    Path("a.json").write_text(json.dumps({"fps": 25, "frames": frames}))
    assert printed(capsys, "a.json") == [
        "4 frames at 25 Hz, 0.16 s",
        "3 keypoints, which it does not name",
        "skpose.io.load_keypoints reads it with names= or layout=",
        "",
        "point  not seen",
        "0          0.0%",
        "1          0.0%",
        "2         25.0%",
    ]


def test_csv_that_states_names_and_no_rate(capsys, monkeypatch):
    text = "frame,nose_x,nose_y,nose_z,left_wrist_x,left_wrist_y,left_wrist_z\n0,1,2,3,1,1.2,1.4\n2,1,1.5,1,,,\n"
    Path("a.csv").write_text(text)
    expected = [
        "3 frames, whose rate it does not state",
        "2 points",
        "skpose.io.load_keypoints reads it with frame_rate=",
        "",
        "point       not seen",
        "nose           33.3%",
        "left_wrist     66.7%",
    ]
    assert printed(capsys, "a.csv") == expected
    monkeypatch.setattr(sys, "stdin", type("Stdin", (), {"buffer": io.BytesIO(text.encode())}))
    assert printed(capsys, "-") == expected


def test_arrays(capsys):
    np.save("a.npy", POINTS)
    assert printed(capsys, "a.npy")[1:3] == [
        "3 keypoints, which it does not name",
        "skpose.io.load_keypoints reads it with frame_rate= and names= or layout=",
    ]
    np.savez("a.npz", positions=POINTS, fps=30, names=["a", "b", "c"])
    assert printed(capsys, "a.npz")[:4] == ["4 frames at 30 Hz, 0.13 s", "3 points", "", "point  not seen"]


def test_what_is_no_keypoints_has_the_errors_of_its_reader(capsys):
    Path("flat.json").write_text(json.dumps([{"pose_keypoints_2d": [1, 2, 1]}]))
    Path("cut.json").write_text('{"frames": [')
    np.savez("other.npz", heights=POINTS)
    for name, said in (("flat.json", "two dimensions|three"), ("cut.json", "JSON"), ("other.npz", "it has no poses")):
        assert main(["info", name]) == 1
        err = capsys.readouterr().err
        assert any(part in err for part in said.split("|")), err
