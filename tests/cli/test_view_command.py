"""`skpose view`: a page of files."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from c3d_files import c3d_file

from skpose import Bone, Motion, Skeleton
from skpose._cli.main import main
from skpose.io import load_bvh, load_trc, save_bvh
from skpose.keypoints import layouts
from skpose.motions import align_motions
from skpose.view import player


@pytest.fixture(autouse=True)
def folder(walks_in_folder):
    return walks_in_folder


def shown(page=None):
    """What the scripts of the page read, or of another one."""
    text = Path("view.html").read_text(encoding="utf-8") if page is None else page.html
    return json.loads(re.findall(r'id="data">(.*?)</script>', text, flags=re.S)[0])


def refusal(arguments, capsys):
    """Run a command that must fail and leave no page; return its line on stderr."""
    assert main(["view", *arguments, "--out", "view.html"]) == 1
    assert not Path("view.html").exists()
    captured = capsys.readouterr()
    assert captured.out == ""
    return captured.err.splitlines()[-1]


def test_page_of_one_file(capsys):
    assert main(["view", "anna.bvh", "--out", "view.html"]) == 0
    expected = player(load_bvh("anna.bvh", scale=1.0), labels=["anna.bvh"])
    assert Path("view.html").read_text(encoding="utf-8") == expected.html
    assert capsys.readouterr().out == f"view.html: {expected.note}, {expected.n_bytes / 1e6:.2g} MB\n"


def test_page_of_a_folder_at_another_rate(folder):
    assert main(["view", ".", "--frame-rate", "10", "--overlay", "--out", "view.html"]) == 0
    assert [motion["label"] for motion in shown()["motions"]] == ["anna.bvh", "ben.bvh"]
    assert [motion["rate"] for motion in shown()["motions"]] == [10, 10]
    assert [motion["joints"]["shape"][0] for motion in shown()["motions"]] == [10, 7]
    assert shown()["overlay"]
    assert shown()["alignment"] is None


def test_each_file_keeps_its_own_skeleton():
    assert main(["view", "anna.bvh", "ben.bvh", "--out", "view.html"]) == 0
    assert shown()["motions"][0]["size"] != shown()["motions"][1]["size"]


def test_files_of_equal_names_have_their_folders_in_the_labels(folder):
    (folder / "other").mkdir()
    save_bvh("other/anna.bvh", load_bvh("ben.bvh", scale=1.0), scale=1.0)
    assert main(["view", "anna.bvh", "other/anna.bvh", "--out", "view.html"]) == 0
    assert [motion["label"] for motion in shown()["motions"]] == ["anna.bvh", str(Path("other/anna.bvh"))]


def test_aligned():
    assert main(["view", "anna.bvh", "ben.bvh", "--align", "--out", "view.html"]) == 0
    motions = [load_bvh(name, scale=1.0) for name in ("anna.bvh", "ben.bvh")]
    expected = player(motions, labels=["anna.bvh", "ben.bvh"], alignment=align_motions(*motions))
    assert Path("view.html").read_text(encoding="utf-8") == expected.html


def test_what_cannot_be_aligned_is_named_by_its_file(capsys):
    assert refusal(["anna.bvh", "--align"], capsys).endswith(
        "--align is for two files, got 1: choose two, or leave --align out"
    )
    other = Skeleton([Bone("tail", None, (0, 0.4, 0), "ZXY")], "parent")
    save_bvh("cat.bvh", Motion(other, np.zeros((3, 3)), 20), scale=1.0)
    line = refusal(["anna.bvh", "cat.bvh", "--align"], capsys)
    assert line.startswith("skpose: cat.bvh has no bone-wise mean with anna.bvh: ")
    assert line.endswith("Leave --align out to see them side by side")
    save_bvh("fast.bvh", replace(load_bvh("ben.bvh", scale=1.0), frame_rate=40), scale=1.0)
    assert "resample all with --frame-rate, such as --frame-rate 20" in refusal(
        ["anna.bvh", "fast.bvh", "--align"], capsys
    )
    assert main(["view", "anna.bvh", "cat.bvh", "fast.bvh", "--out", "view.html"]) == 0  # but all can be seen


def test_too_many_files_and_files_without_frames_are_refused(capsys):
    assert "shows 1 to 12 motions at once, got 13" in refusal(["anna.bvh"] * 13, capsys)
    text = Path("anna.bvh").read_text()
    head = text[: text.index("Frames:")]
    Path("empty.bvh").write_text(f"{head}Frames: 0\nFrame Time: 0.05\n")
    assert refusal(["anna.bvh", "empty.bvh"], capsys).endswith(
        "empty.bvh has no frames; --skip-errors leaves out such files"
    )


def test_the_page_ends_in_html(capsys):
    with pytest.raises(SystemExit) as stop:
        main(["view", "anna.bvh", "--out", "view.htm"])
    assert stop.value.code == 2
    assert "'view.htm' does not end in .html, which is the format of the file" in capsys.readouterr().err


# --- points without a skeleton ----------------------------------------------------------------------------------------


def squatting(n=12):
    """Keypoints of the layout coco17, its midpoints among them, of somebody who goes down."""
    layout = layouts["coco17"]
    sides = [{"l": 0.15, "r": -0.15}.get(name[0], 0.0) for name in layout.names]
    standing = np.stack([sides, np.linspace(1.7, 0.1, 17), 0.03 * np.arange(17) % 0.1], axis=1)
    return layout.keypoints(standing * np.linspace(1, 0.8, n)[:, None, None], 30)


def write_trc(path, keypoints):
    """A TRC file with all numbers of the keypoints."""
    names = "\t\t\t".join(keypoints.names)
    rows = [
        "\t".join(map(repr, [i + 1, float(time), *map(float, frame.ravel())]))
        for i, (time, frame) in enumerate(zip(keypoints.times, keypoints.positions, strict=True))
    ]
    head = [
        f"PathFileType\t4\t(X/Y/Z)\t{path}",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"{keypoints.frame_rate:g}\t30\t{len(keypoints)}\t{len(keypoints.names)}\tm\t30\t1\t{len(keypoints)}",
        f"Frame#\tTime\t{names}",
        "\t\t" + "\t".join(f"{axis}{i + 1}" for i in range(len(keypoints.names)) for axis in "XYZ"),
        "",
    ]
    Path(path).write_text("\n".join([*head, *rows]) + "\n")


def test_page_of_markers(capsys):
    write_trc("squat.trc", squatting())
    assert main(["view", "squat.trc", "--out", "view.html"]) == 0
    expected = load_trc("squat.trc").play()
    (data,) = shown()["motions"]
    assert data["label"] == "squat.trc"
    assert data["layout"] == "coco17"
    assert data | {"label": ""} == shown(expected)["motions"][0] | {"label": ""}
    assert capsys.readouterr().out.startswith("view.html: 1 recording of points, positions within ")


@pytest.mark.filterwarnings("ignore:anna.bvh. frame_rate=30 replaces the 20 Hz:UserWarning")
def test_page_of_keypoints_of_any_format(capsys):
    keypoints = squatting()
    keypoints.to_pandas().to_csv("squat.csv")
    np.savez("squat.npz", positions=keypoints.positions[:, :17], frame_rate=30.0)
    named = {name: dict(zip("xyz", keypoints.positions[0, i], strict=True)) for i, name in enumerate(keypoints.names)}
    Path("squat.json").write_text(json.dumps({"fps": 30, "frames": [{"keypoints_3d": named}] * 2}))
    files = ["squat.csv", "squat.npz", "squat.json", "anna.bvh"]
    assert main(["view", *files, "--file-frame-rate", "30", "--layout", "coco17", "--out", "view.html"]) == 0
    data = shown()["motions"]
    assert [motion["label"] for motion in data] == files
    assert [motion.get("layout") for motion in data] == ["coco17"] * 3 + [None]
    for one in data[:2]:
        assert one["joints"] == shown(keypoints.play())["motions"][0]["joints"]
    assert ": 4 motions, " in capsys.readouterr().out


def test_page_of_a_c3d_file():
    seen = squatting(4)
    file = c3d_file(1000 * seen.positions, list(seen.names), rate=30, axis_up="+Y")
    Path("squat.c3d").write_bytes(file)
    assert main(["view", "squat.c3d", "--out", "view.html"]) == 0
    (data,) = shown()["motions"]
    assert (data["layout"], data["axes"], data["rate"]) == ("coco17", "xyz", 30)


def test_folders_have_markers_too():
    write_trc("squat.trc", squatting())
    assert main(["view", ".", "--out", "view.html"]) == 0
    assert [motion["label"] for motion in shown()["motions"]] == ["anna.bvh", "ben.bvh", "squat.trc"]


def test_of_points_whole_frames_are_left_out(capsys):
    write_trc("squat.trc", squatting())
    assert main(["view", "squat.trc", "anna.bvh", "--frame-rate", "10", "--out", "view.html"]) == 0
    assert [motion["joints"]["shape"][0] for motion in shown()["motions"]] == [4, 10]
    assert [motion["rate"] for motion in shown()["motions"]] == [10, 10]
    Path("view.html").unlink()
    capsys.readouterr()
    line = refusal(["squat.trc", "--frame-rate", "20"], capsys)
    assert "squat.trc has points at 30 Hz, of which whole frames are left out: use --frame-rate 30, 15, 10, 7.5" in line


def test_what_is_refused_of_points(capsys):
    write_trc("squat.trc", squatting())
    line = refusal(["anna.bvh", "squat.trc", "--align"], capsys)
    assert "squat.trc has points without a skeleton, which --align needs. Leave --align out" in line
    assert "--layout is for files of keypoints or markers" in refusal(["anna.bvh", "--layout", "coco17"], capsys)
    assert "layout must be one of coco17, mediapipe33" in refusal(["squat.trc", "--layout", "coco"], capsys)
    line = refusal(["squat.trc", "--layout", "h36m17"], capsys)
    assert "no point named 'spine', as the layout 'h36m17' has" in line
    squatting().to_pandas().to_csv("squat.csv")
    assert "squat.csv does not state its frame rate: pass --file-frame-rate" in refusal(["squat.csv"], capsys)
    np.savez("squat.npz", positions=squatting().positions[:, :17], frame_rate=30.0)
    assert "squat.npz does not name its points: pass --layout" in refusal(["squat.npz"], capsys)
    Path("arm.asf").write_text((Path(__file__).parents[1] / "data" / "arm.asf").read_text())
    assert "this is a skeleton (ASF or a robot), which has no motion" in refusal(["arm.asf"], capsys)
