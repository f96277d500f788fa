"""What a page holds: positions rounded by a known amount, names as they are, frames that belong together."""

import html
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from conftest import SKELETONS, in_space
from pages import data_of

from skpose import Bone, Keypoints, Motion, Skeleton, forward_kinematics, geodesic, pose_distances
from skpose.datasets import make_gait
from skpose.metrics import Spatial
from skpose.motions import align_motions
from skpose.view import Page, player
from skpose.view._scene import pack, unpack


@pytest.mark.parametrize(("shape", "scale"), [((1, 7), 1e-6), ((300, 90), 1.0), ((500, 3), 1e7)], ids=str)
def test_numbers_are_off_by_half_a_step_of_the_range_at_most(shape, scale):
    values = scale * np.random.default_rng(0).normal(size=shape)
    packed = pack(values)
    assert np.abs(unpack(packed) - values).max() <= np.ptp(values) / 65535 / 2 * (1 + 1e-6)
    assert json.loads(json.dumps(packed)) == packed


def test_a_step_is_kept_over_a_larger_range():
    values = np.random.default_rng(0).uniform(-500, 500, (200, 3))
    error = np.abs(unpack(pack(values, 1e-4)) - values)
    assert 4e-5 < error.max() <= 0.5e-4 * (1 + 1e-6)


def test_whole_numbers_and_constants_are_exact():
    whole = np.random.default_rng(0).integers(0, 10**6, (300, 2)).astype(float)
    np.testing.assert_array_equal(unpack(pack(whole, 1.0)), whole)
    np.testing.assert_array_equal(unpack(pack(np.full((5, 2), 0.3))), np.full((5, 2), 0.3))


def moving(skeleton, n=40, up="y", seed=0):
    """A motion of a skeleton with a root that goes far and turns."""
    rng = np.random.default_rng(seed)
    sizes = [(skeleton.n_dofs, 0.1), (3, 0.5), (3, 0.1)]
    angles, positions, root = (rng.normal(scale=scale, size=(n, k)).cumsum(axis=0) for k, scale in sizes)
    return Motion(skeleton, angles, 30, positions, root, "ZXY", up=up)


def on_the_ground(points, axes):
    """Points (n_frames, n_points, 3) with the axes in another order, the lowest at height zero."""
    points = points[..., axes]
    return points - [0, points[..., 1].min(), 0]


@pytest.mark.parametrize(("name", "up"), [("humanoid", "y"), ("bvh", "z"), ("mixed joints", "x")])
def test_positions_are_those_of_forward_kinematics(name, up):
    motion = moving(SKELETONS[name], up=up)
    (data,) = data_of(player(motion))["motions"]
    root = unpack(data["root"])
    joints = unpack(data["joints"]).reshape(len(motion), -1, 3) + root[:, None]
    axes = ["xyz".index(axis) for axis in {"x": "zxy", "y": "xyz", "z": "yzx"}[up]]
    world = np.concatenate([motion.root_positions[:, None], in_space(motion)], axis=1)
    expected = on_the_ground(world, axes)
    error = np.linalg.norm(np.concatenate([root[:, None], joints], axis=1) - expected, axis=2).max()
    assert error == pytest.approx(data["error"] / 1e3, rel=1e-6)  # stated as it is
    extent = np.ptp(in_space(motion) - motion.root_positions[:, None])
    assert error <= 2 * np.sqrt(3) * extent / 65535 / 2 * 1.01
    assert data["axes"] == {"x": "zxy", "y": "xyz", "z": "yzx"}[up]


def test_frames_that_are_missing_keep_their_times():
    motion = moving(Skeleton.chain(2), 5)
    gaps = replace(motion, frame_numbers=[3, 4, 8, 9, 20])
    (data,) = data_of(player(gaps))["motions"]
    np.testing.assert_array_equal(unpack(data["numbers"])[:, 0], [0, 1, 5, 6, 17])
    assert data["start"] == 0.1
    assert data_of(player(motion))["motions"][0]["numbers"] is None


def test_headings_are_those_of_the_root():
    turns = np.linspace(0, 5, 11)
    motion = Motion(Skeleton.chain(1), np.zeros((11, 1)), 10, root_angles=turns[:, None], root_axes="z", up="z")
    headings = unpack(data_of(player(motion))["motions"][0]["headings"])[:, 0]
    np.testing.assert_allclose(np.exp(1j * headings), np.exp(1j * turns), atol=1e-4)


NAMES = [
    "<script>alert(1)</script>",
    "</script>",
    "<!--",
    "\"quoted\" & 'so'",
    "\u05e9\u05dc\u05d5\u05dd",  # from right to left
    "\u2028line\u2029",
    "x" * 5000,
    "\udc80",  # no UTF-8
]


def test_no_name_is_markup():
    skeleton = Skeleton(Bone(name, None, (0.1 * i, 1, 0), "z") for i, name in enumerate(NAMES))
    motion = Motion(skeleton, np.zeros((2, len(NAMES))), 30)
    page = player(motion, labels=["</title><script>"], title="</title><script> & <b>")
    assert data_of(page)["motions"][0]["names"] == NAMES
    assert data_of(page)["motions"][0]["label"] == "</title><script>"
    assert page.html.count("<script") == 2  # data and program
    assert page.html.count("</title>") == 1
    page.html.encode("utf-8")
    assert "<script" not in page._repr_html_()


@pytest.fixture(scope="module")
def walks():
    """Two walks of two people."""
    gait = make_gait(n_subjects=2, n_sequences=1, duration=1.0, frame_rate=20, random_state=0)
    walks = gait[gait.actions == "walk"].motions
    return walks[0], walks[1][:17]


def test_alignment_is_the_one_given(walks):
    alignment = align_motions(*walks)
    data = data_of(player(walks, alignment=alignment))["alignment"]
    np.testing.assert_array_equal(unpack(data["path"]), alignment.path)
    half = np.ptp(alignment.joint_distances) / 65535 / 2 * 1.01
    np.testing.assert_allclose(unpack(data["distances"]), alignment.joint_distances, atol=half)
    assert data["columns"] == [list(range(walks[0].skeleton.n_joints))] * 2


def test_joints_in_another_order_find_their_columns():
    left, right = Bone("left", None, (1, 0, 0), "z"), Bone("right", None, (0, 2, 0), "z")
    a = Motion(Skeleton([left, right]), np.zeros((3, 2)), 30)
    b = Motion(Skeleton([right, left]), [[0.5, 0.0]] * 3, 30)  # the right arm is off
    alignment = data_of(player([a, b], alignment=align_motions(a, b)))["alignment"]
    distances = unpack(alignment["distances"])
    for names, columns in zip((["left", "right"], ["right", "left"]), alignment["columns"], strict=True):
        off = dict(zip(names, distances[0, columns], strict=True))
        assert off == pytest.approx({"left": 0, "right": 2 * 2 * np.sin(0.25)}, abs=1e-4)


@pytest.mark.slow
def test_paths_have_the_lengths_of_their_labels():
    skeleton = SKELETONS["humanoid"]
    rng = np.random.default_rng(3)
    start, end = rng.uniform(-0.8, 0.8, (2, skeleton.n_dofs))
    page = player(geodesic(start, end, skeleton))
    first, second = data_of(page)["motions"]
    shortest = geodesic(start, end, skeleton).curve_length
    line = pose_distances([start], [end], skeleton=skeleton, metric=Spatial(2000))[0, 0]
    assert first["label"] == f"shortest path, {shortest:.3g} m"
    assert second["label"] == f"straight line, {line:.3g} m"
    for motion in (first, second):
        positions = unpack(motion["joints"]).reshape(61, -1, 3)
        steps = np.linalg.norm(np.diff(positions, axis=0), axis=(1, 2))
        assert steps.max() < 1.1 * steps.min()  # constant speed, but for the corners of the path
        for at, pose in ((0, start), (-1, end)):
            np.testing.assert_allclose(positions[at], forward_kinematics([pose], skeleton)[0], atol=1e-4)
    apart = np.linalg.norm(
        unpack(first["joints"]).reshape(61, -1, 3) - unpack(second["joints"]).reshape(61, -1, 3), axis=2
    )
    np.testing.assert_allclose(unpack(data_of(page)["alignment"]["distances"]), apart, atol=2e-4)


def test_paths_within_limits_do_not_pass_half_a_turn():
    bones = [Bone("a", None, (0, 0.1, 0.3), "z", limits=[(-3.0, 3.0)]), Bone("b", "a", (0.2, 0, 0), "y")]
    arm, start, end = Skeleton(bones), np.array([2.8, 0.1]), np.array([-2.8, 0.4])
    lengths = {}
    for joint_limits in ("ignore", "enforce"):
        page = player(geodesic(start, end, arm, joint_limits=joint_limits), up="z")
        first, second = data_of(page)["motions"]
        assert first["axes"] == second["axes"] == "yzx"
        lengths[joint_limits] = [float(motion["label"].split()[-2]) for motion in (first, second)]
    line = pose_distances([start], [end], skeleton=arm, metric=Spatial(2000, wrap=False))[0, 0]
    shortest = geodesic(start, end, arm, joint_limits="enforce").curve_length
    assert lengths["enforce"] == [float(f"{length:.3g}") for length in (shortest, line)]
    assert max(lengths["ignore"]) < 0.2 * min(lengths["enforce"])


ARM = Motion(Skeleton.chain(2), np.zeros((3, 2)), 30)


def test_page_is_written_whole_and_never_over_another_file(tmp_path):
    page = player(ARM, labels=["ça"])
    path = tmp_path / "view.html"
    page.save(path)
    assert path.read_bytes().decode("utf-8") == page.html
    assert len(path.read_bytes()) == page.n_bytes
    with pytest.raises(FileExistsError, match="exists"):
        page.save(path)
    assert repr(page) == f"Page('ça', {page.n_bytes / 1e3:.0f} kB, {page.note})"


def test_page_opens_in_the_browser(monkeypatch, tmp_path):
    opened = []
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr("webbrowser.open", opened.append)
    path = player(ARM).open()
    assert opened == [path.as_uri()]
    assert path.read_text(encoding="utf-8") == player(ARM).html


def test_notebook_shows_the_page_in_a_frame_of_its_own():
    page = ARM.play()
    assert isinstance(page, Page)
    assert page.html == player(ARM).html
    (source,) = re.findall(r'srcdoc="([^"]*)"', page._repr_html_())
    assert html.unescape(source) == page.html
    assert 'sandbox="allow-scripts allow-downloads"' in page._repr_html_()


ARM_AND_POINTS = [ARM, Keypoints(np.full((3, 1, 3), np.nan), ["a"], 30)]


@pytest.mark.parametrize(
    ("arguments", "options", "name"),
    [
        ([], {}, "motions"),
        ([ARM[:0]], {}, "motions"),
        (ARM_AND_POINTS, {}, "motions"),
        ([ARM, np.zeros((3, 2))], {}, "motions"),
        ([ARM, ARM], {"labels": ["a"]}, "labels"),
        ([ARM, ARM[:2]], {"alignment": align_motions(ARM, ARM)}, "alignment"),
        ([ARM], {"layout": "coco17"}, "layout"),
    ],
)
def test_wrong_arguments_are_refused(arguments, options, name):
    with pytest.raises((TypeError, ValueError), match=name):
        player(arguments, **options)
