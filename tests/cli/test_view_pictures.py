"""`skpose view --png` and `--gif`: pictures of files."""

import warnings
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageSequence

from skpose import Motion, Skeleton, forward_kinematics
from skpose._cli.main import main
from skpose.datasets import make_gait
from skpose.io import save_bvh

pytestmark = pytest.mark.usefixtures("walks_in_folder")


def refusal(arguments, capsys, status=1):
    """Run a command that must fail and leave no picture; return what it prints on stderr."""
    before = sorted(Path().iterdir())
    if status == 2:
        with pytest.raises(SystemExit) as stop:
            main(["view", *arguments])
        assert stop.value.code == 2
    else:
        assert main(["view", *arguments]) == status
    assert sorted(Path().iterdir()) == before
    return capsys.readouterr().err


def opened(name):
    return Image.open(BytesIO(Path(name).read_bytes()))


def has_colours(picture):
    """Return whether the colours of left and right are in a picture."""
    return all((np.abs(picture - colour).max(axis=2) < 40).sum() > 30 for colour in ([0, 114, 178], [213, 94, 0]))


def test_all_pictures_are_seen_from_one_side():
    """Each side of the person is one line, through its joints as the view has them."""
    from skpose._cli.moving_picture import Recording
    from skpose.io import load_bvh

    recording = Recording([load_bvh("anna.bvh")], ["anna"])
    (panel,) = recording.panels
    for frame, time in enumerate(panel.times):
        recording.draw(time)
        drawn = np.concatenate([line.get_xydata() for line in recording.axes[0].lines])
        for joint in panel.seen[frame][:, :2]:
            assert np.nanmin(np.abs(drawn - joint).max(axis=1)) < 1e-9


def test_a_motion_that_stands_still_for_too_long(capsys):
    save_bvh("still.bvh", Motion(Skeleton.chain(2), np.zeros((3, 2)), 0.001), scale=1.0)  # a frame in 1,000 s
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        message = refusal(["still.bvh", "--gif", "still.gif", "--fps", "0.1"], capsys)
    assert "nothing moves for longer" in message


def test_picture_of_a_moment(capsys):
    assert main(["view", "anna.bvh", "--png", "first.png"]) == 0
    assert main(["view", "anna.bvh", "--png", "later.png", "--at", "0.4"]) == 0
    first, later = (np.asarray(opened(name).convert("RGB")).astype(int) for name in ("first.png", "later.png"))
    assert first.shape == later.shape
    assert has_colours(first)
    assert (np.abs(first - later).max(axis=2) > 30).sum() > 500
    assert capsys.readouterr().out.splitlines()[0].startswith("first.png: 0.0")
    assert (
        main(["view", "anna.bvh", "--png", "same.png", "--at", "0.44"]) == 0
    )  # the frame of 0.40 s is the last before
    np.testing.assert_array_equal(np.asarray(opened("same.png").convert("RGB")), later)


def test_moving_picture(capsys):
    command = ["view", "anna.bvh", "--gif", "walk.gif", "--from", "0.2", "--to", "0.7", "--fps", "10"]
    assert main(command) == 0
    image = opened("walk.gif")
    pictures = [np.asarray(frame.convert("RGB")).astype(int) for frame in ImageSequence.Iterator(image)]
    assert len(pictures) == 6
    assert image.info["duration"] == 100
    assert image.info["loop"] == 0
    assert all(map(has_colours, pictures))
    assert capsys.readouterr().out.startswith("walk.gif: 6 pictures, ")


def test_durations_do_not_drift():
    """Of 30 pictures a second each takes 3 or 4 hundredths."""
    assert main(["view", "anna.bvh", "--gif", "walk.gif", "--fps", "30"]) == 0
    durations = [frame.info["duration"] for frame in ImageSequence.Iterator(opened("walk.gif"))]
    assert set(durations) == {30, 70}  # two pictures of one frame of the file are one
    assert sum(durations) == pytest.approx(29 * 1000 / 30, abs=5)  # 29 pictures


def test_page_and_pictures_of_several_files_at_once(capsys):
    command = [
        "view",
        "anna.bvh",
        "ben.bvh",
        "--out",
        "view.html",
        "--png",
        "two.png",
        "--gif",
        "two.gif",
        "--fps",
        "5",
    ]
    assert main(command) == 0
    assert all(Path(name).exists() for name in ("view.html", "two.png", "two.gif"))
    wide, high = opened("two.png").size
    assert wide > 1.5 * high
    assert len(capsys.readouterr().out.splitlines()) == 3


def test_nothing_is_written_over(capsys):
    Path("there.png").write_text("mine")
    err = refusal(["anna.bvh", "--png", "there.png", "--out", "view.html"], capsys)
    assert "there.png already exists: delete it or choose another file" in err
    assert Path("there.png").read_text() == "mine"


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--png", "a.gif"], "'a.gif' does not end in .png, which is the format of the file"),
        (["--gif", "a.gif", "--overlay"], "--align and --overlay are for a page"),
        (["--gif", "a.gif", "--at", "1"], "--at is the time of --png: pass both"),
        (["--png", "a.png", "--to", "1"], "--from, --to and --fps are for --gif: pass it too"),
        (["--gif", "a.gif", "--fps", "60"], "--fps must be from 0.1 to 50"),
        (["--gif", "a.gif", "--fps", "0.001"], "--fps must be from 0.1 to 50"),
        (["--png", "a.png", "--at", "-1"], "expected a time in seconds, zero or more, got '-1'"),
        (["--gif", "a.gif", "--from", "0.5", "--to", "0.2"], "--to 0.2 must be after --from 0.5"),
    ],
)
def test_options_that_do_not_go_together(arguments, expected, capsys):
    assert expected in refusal(["anna.bvh", *arguments], capsys, status=2)


def test_times_that_the_files_do_not_have(capsys):
    assert "--at 2 is after the end: the files end at 0.95 s" in refusal(
        ["anna.bvh", "--png", "a.png", "--at", "2"], capsys
    )
    assert "--from 2 is after the end" in refusal(["anna.bvh", "--gif", "a.gif", "--from", "2"], capsys)


@pytest.fixture
def points():
    """Two seconds of a person as keypoints, whose right wrist is not seen in the second one."""
    from skpose.keypoints import layouts

    walk = make_gait(n_subjects=1, n_sequences=1, duration=2.0, frame_rate=10, random_state=0).motions[0]
    joints = forward_kinematics(walk.angles, walk.skeleton) + walk.root_positions[:, None]
    names = list(layouts["coco17"].names)
    place = {name: i for i, name in enumerate(walk.skeleton.joint_names)}
    near = {"wrist": "hand", "shoulder": "elbow", "hip": "knee", "ankle": "foot"}
    found = [place.get(name) or next((j for k, j in place.items() if k == swap(name, near)), 0) for name in names]
    positions = joints[:, found] + 1e-3 * np.arange(len(names))[:, None]
    positions[10:, names.index("right_wrist")] = np.nan
    np.savez("points.npz", positions=positions, frame_rate=10.0)
    return layouts["coco17"].keypoints(positions, frame_rate=10.0)


def swap(name, near):
    side, _, part = name.partition("_")
    return f"{side}_{near.get(part, part)}"


def test_keypoints_are_drawn_as_the_page_has_them(points):
    """Points where they are, in the view of the page; bones of the layout; none of what is not seen."""
    from skpose._cli.moving_picture import Recording
    from skpose.keypoints import layouts
    from skpose.view._shared import points_scene

    recording = Recording([points], ["points"], layouts["coco17"])
    (panel,) = recording.panels
    figure, scene, is_seen, _ = points_scene(points, layouts["coco17"])
    wrist = figure.names.index("right_wrist")
    for frame in (3, 15):
        recording.draw(frame / 10)
        marks = np.concatenate([line.get_xydata() for line in recording.axes[0].lines if line.get_marker() == "o"])
        bones = np.concatenate(
            [
                line.get_xydata()
                for line in recording.axes[0].lines
                if line.get_marker() == "None" and len(line.get_xydata()) > 2
            ]
        )
        for i in range(len(figure.names)):
            assert is_seen[frame, i] == (i != wrist or frame < 10)
            if is_seen[frame, i]:
                for drawn in (marks, bones) if figure.parents[i] >= 0 else (marks,):
                    assert np.nanmin(np.abs(drawn - panel.seen[frame, i, :2]).max(axis=1)) < 1e-9
        assert np.isfinite(marks).all(axis=1).sum() == is_seen[frame].sum()
        # The view keeps distances: those in the picture and towards the viewer are those in space.
        both = is_seen[frame]
        far = [np.linalg.norm(at[both][:, None] - at[both], axis=2) for at in (panel.seen[frame], scene.joints[frame])]
        np.testing.assert_allclose(far[0], far[1], atol=1e-12)


def test_pictures_of_keypoints(points):
    assert main(["view", "points.npz", "--layout", "coco17", "--png", "a.png", "--at", "0.5", "--gif", "a.gif"]) == 0
    assert has_colours(np.asarray(opened("a.png").convert("RGB")).astype(int))
    frames = [np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(opened("a.gif"))]
    assert len(frames) > 10
    assert (frames[0] != frames[-1]).any()


def test_points_without_names_are_drawn_as_points():
    from skpose._cli.moving_picture import Recording
    from skpose.keypoints import Keypoints

    positions = np.random.default_rng(0).normal(size=(3, 4, 3))
    positions[1] = np.nan
    recording = Recording([Keypoints(positions, ["a", "b", "c", "d"], 10.0)], ["some"])
    counts = []
    for time in (0.0, 0.1, 0.2):
        recording.draw(time)
        marks = [line.get_xydata() for line in recording.axes[0].lines if line.get_marker() == "o"]
        counts.append(int(np.isfinite(np.concatenate(marks)).all(axis=1).sum()))
    assert counts == [4, 0, 4]


def test_a_layout_of_a_motion_is_refused(capsys):
    assert "--layout is for files of keypoints or markers" in refusal(
        ["anna.bvh", "--layout", "coco17", "--png", "a.png"], capsys
    )


def test_people_who_face_one_direction_are_seen_from_one_side():
    """Strides and arms that swing turn no view: shapes are seen as they are turned, and nothing else counts."""
    from skpose._cli.moving_picture import ASIDE, Recording
    from skpose.io import load_bvh
    from skpose.view._shared import scene_of

    gait = make_gait(n_subjects=3, n_sequences=1, duration=1.0, frame_rate=20, random_state=0).motions
    turns = np.radians([0.0, 0.0, 0.0, 40.0, 150.0, -90.0])
    for i, (motion, turn) in enumerate(zip(gait, turns, strict=True)):
        save_bvh(f"{i}.bvh", replace(motion, root_angles=[[turn, 0, 0]] * len(motion), root_axes="YXZ"), scale=1.0)
    shown = [load_bvh(f"{i}.bvh") for i in range(len(gait))]
    for motion, panel, turn in zip(shown, Recording(shown, list("abcdef")).panels, turns, strict=True):
        scene = scene_of(motion)
        assert abs(scene.headings[0] - turn) < 1e-6
        # `seen` is the scene rotated about y: by which angle, and where that leaves the heading.
        (x, _, z), (to_x, _, to_z) = scene.joints[0][-1], panel.seen[0][-1]
        turned = np.arctan2(to_x, to_z) - np.arctan2(x, z)
        assert abs((turned + turn - ASIDE + np.pi) % (2 * np.pi) - np.pi) < np.radians(1.0)


def test_keypoints_are_seen_from_where_their_hips_are(points):
    """A hand far to the side turns no view, nor does a hip that is never seen: shoulders do then."""
    from skpose._cli.moving_picture import _panel
    from skpose.keypoints import layouts

    expected = _panel(points, "", layouts["coco17"]).seen
    for names, parts in (((), ("left_wrist",)), (("left_hip",), ("left_wrist", "right_hip"))):
        seen = []
        for shift in (0.0, 0.5):
            positions = points.positions.copy()
            positions[:, [points.names.index(name) for name in parts]] += [0.0, 0.0, shift]
            positions[:, [points.names.index(name) for name in names]] = np.nan
            seen.append(_panel(replace(points, positions=positions), "", layouts["coco17"]).seen)
        knees = [points.names.index(f"{side}_knee") for side in ("left", "right")]
        bones = [np.diff(one[:, knees], axis=1) for one in (*seen, expected)]
        np.testing.assert_allclose(bones[0], bones[1], atol=1e-12)
        if not names:
            np.testing.assert_allclose(bones[0], bones[2], atol=1e-12)


def test_moments_at_which_no_point_is_seen(points, capsys):
    positions = points.positions[:, :17].copy()
    positions[[0, 1, 6, 7, 8]] = np.nan
    np.savez("gaps.npz", positions=positions, frame_rate=30.0)
    command = ["gaps.npz", "--layout", "coco17", "--png", "a.png"]
    for options, time, frame, nearest, at in (([], 0, 0, 2, 0.067), (["--at", "0.21"], 0.2, 6, 5, 0.167)):
        message = refusal([*command, *options], capsys)
        assert f"gaps.npz has no point that is seen at {time:.2f} s, frame {frame} from zero, and a pict" in message
        assert f"the nearest frame with points is {nearest}, pass --at {at:g}" in message
        assert main(["view", *command, "--at", f"{at:g}"]) == 0
        Path("a.png").unlink()
    assert main(["view", *command[:-2], "--gif", "a.gif"]) == 0  # shows the gaps as they are


@pytest.mark.parametrize("option", [["--png", "a.png"], ["--gif", "a.gif"]])
def test_keypoints_that_cannot_be_drawn(points, option, capsys):
    positions = points.positions[:, :17].copy()
    positions[2, 3, 0] = np.inf
    np.savez("infinite.npz", positions=positions, frame_rate=10.0)
    np.savez("lost.npz", positions=np.full_like(positions, np.nan), frame_rate=10.0)
    message = refusal(["infinite.npz", "--layout", "coco17", *option], capsys)
    assert "infinite.npz: positions are infinite at frame 2, point 3: use NaN for a point that is not seen" in message
    message = refusal(["lost.npz", "--layout", "coco17", *option], capsys)
    assert message == "skpose: lost.npz has no point that is seen, and there is nothing to draw: leave it out\n"
