"""Layouts and their keypoints."""

import numpy as np
import pytest
from people import ALONE
from scipy.spatial.transform import Rotation

from skpose.keypoints import Keypoints, Layout, layouts
from skpose.skeleton._sides import partners, sides

ARM = {"names": ["a", "b", "c"], "parents": {"a": None, "b": "a", "c": "b"}}


@pytest.fixture(params=["coco17", "smpl24", "opencap43"])
def layout(request):
    return layouts[request.param]


def test_left_and_right_are_pairs_and_mirror_images_in_the_tree(layout):
    layout = layout.without(ALONE.get(layout.name, []))
    points = layout.points
    other = dict(zip(points, (points[i] for i in partners(points)), strict=True))
    assert [a for a, _ in layout.pairs] == [
        name for name, side in zip(points, sides(points), strict=True) if side == "left"
    ]
    assert all(other[a] == b for a, b in layout.pairs)
    assert sum(side != "" for side in sides(points)) == 2 * len(layout.pairs)
    for name, parent in layout.parents.items():
        assert layout.parents[other[name]] == (None if parent is None else other[parent])
        assert (name in layout.rigid) == (other[name] in layout.rigid)


# Numbers that the sources name, from the pages and tables that the layouts cite.
@pytest.mark.parametrize(
    ("name", "numbers"),
    [
        (
            "coco17",
            {0: "nose", 4: "right_ear", 5: "left_shoulder", 10: "right_wrist", 11: "left_hip", 16: "right_ankle"},
        ),
        (
            "mediapipe33",
            {7: "left_ear", 12: "right_shoulder", 17: "left_pinky", 22: "right_thumb", 31: "left_foot_index"},
        ),
        ("h36m17", {0: "pelvis", 1: "right_hip", 4: "left_hip", 10: "head", 11: "left_shoulder", 16: "right_wrist"}),
        ("body25", {1: "neck", 4: "right_wrist", 8: "mid_hip", 16: "left_eye", 19: "left_big_toe", 24: "right_heel"}),
        ("kinect25", {0: "spine_base", 4: "left_shoulder", 12: "left_hip", 20: "spine_shoulder", 24: "right_thumb"}),
        ("smpl24", {1: "left_hip", 9: "spine3", 12: "neck", 15: "head", 20: "left_wrist", 23: "right_hand"}),
        ("cmu31", {0: "root", 1: "lhipjoint", 11: "lowerback", 16: "head", 17: "lclavicle", 30: "rthumb"}),
        (
            "kinect20",
            {0: "hip_center", 3: "head", 4: "left_shoulder", 11: "right_hand", 12: "left_hip", 19: "right_foot"},
        ),
        (
            "mediapipe_hand21",
            {0: "wrist", 4: "thumb_tip", 5: "index_finger_mcp", 12: "middle_finger_tip", 17: "pinky_mcp"},
        ),
        ("pose2sim21", {0: "right_hip", 3: "right_big_toe", 6: "left_hip", 12: "neck", 15: "right_shoulder"}),
        ("opencap43", {0: "R.ASIS_study", 9: "R_5meta_study", 17: "L_5meta_study", 20: "C7_study", 33: "RHJC_study"}),
        ("opencap_mocap55", {0: "C7", 2: "L.PSIS", 14: "L_knee", 24: "L_toe", 38: "R.PSIS", 47: "R_sh4", 54: "R_toe"}),
        ("plug_in_gait39", {0: "LFHD", 4: "C7", 8: "RBAK", 9: "LSHO", 22: "RFIN", 23: "LASI", 27: "LTHI", 38: "RTOE"}),
    ],
)
def test_points_have_the_numbers_of_their_sources(name, numbers):
    assert {i: layouts[name].names[i] for i in numbers} == numbers


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"names": ["a", "b", "b"]}, "points must be different"),
        ({"parents": {"a": None, "b": "a"}}, "parents must have every point"),
        ({"parents": {"a": None, "b": None, "c": "b"}}, "one point must be the root"),
        ({"parents": {"a": None, "b": "c", "c": "b"}}, "make a cycle"),
        ({"midpoints": {"m": ("a", "z")}}, "midpoint 'm'"),
        ({"rigid": ["b", "c"]}, "must not be rigid"),
        ({"up": "down"}, "up must be"),
    ],
)
def test_invalid_layouts_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        Layout("mine", **{**ARM, **change})


def test_keypoints_have_midpoints_where_both_ends_are_seen():
    layout = layouts["coco17"]
    positions = np.random.default_rng(0).normal(size=(4, 17, 3))
    confidences = np.random.default_rng(1).uniform(0.1, 1, size=(4, 17))
    left, right = layout.names.index("left_hip"), layout.names.index("right_hip")
    positions[1, left, 0] = np.nan
    confidences[2, right] = 0.0
    made = layout.keypoints(positions, 25, confidences)
    assert made.names == layout.points
    assert made.up == "y"
    pelvis = made.names.index("pelvis")
    np.testing.assert_allclose(made.positions[[0, 3], pelvis], positions[[0, 3]][:, [left, right]].mean(axis=1))
    np.testing.assert_array_equal(
        made.confidences[:, pelvis], [confidences[0, [left, right]].min(), 0, 0, confidences[3, [left, right]].min()]
    )
    assert np.isnan(made.positions[[1, 2], pelvis]).all()


@pytest.mark.parametrize("up", ["x", "z", "-y"])
def test_the_world_is_rotated_not_mirrored(up):
    layout = Layout("mine", **ARM, up=up)
    axes = np.stack([np.full((3, 3), np.nan), np.eye(3), -np.eye(3)])
    axes[0, 0] = 0.0
    axes[0, 0, "xyz".index(up[-1])] = -1.0 if up[0] == "-" else 1.0  # one point that is 1 m above the origin
    made = layout.keypoints(axes, 1)
    assert made.up == up[-1]
    assert made.positions[0, 0, "xyz".index(made.up)] == 1.0
    np.testing.assert_allclose(np.linalg.det(made.positions[1]), 1.0)
    np.testing.assert_allclose(made.positions[1] @ made.positions[1].T, np.eye(3))


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ((5, 17, 2), "three coordinates"),
        ((5, 33, 3), "must have shape"),
        ((5, 51), "must have shape"),
    ],
)
def test_positions_of_other_shapes_are_refused(shape, message):
    with pytest.raises(ValueError, match=message):
        layouts["coco17"].keypoints(np.ones(shape), 25)


def test_without_some_points():
    layout = layouts["mediapipe33"]
    smaller = layout.without(["left_index", "left_pinky", "right_index", "mouth_left"])
    assert smaller.points == tuple(
        name for name in layout.points if name not in {"left_index", "left_pinky", "right_index", "mouth_left"}
    )
    assert smaller.parents["left_thumb"] == "left_wrist"
    assert "left_thumb" not in smaller.rigid  # it was rigid with a bone that has a joint
    assert smaller.parents["left_heel"] == "left_foot_index"
    assert smaller.without("neck").midpoints == {"pelvis": ("left_hip", "right_hip")}
    assert smaller.without("neck").parents["left_shoulder"] == "pelvis"


@pytest.mark.parametrize(("name", "joints"), [("coco17", ["left_knee"]), ("opencap_mocap55", ["L_EJC"])])
def test_an_ankle_never_hangs_on_a_hip(name, joints):
    layout = layouts[name]
    parts = [part for joint in joints for part in (*layout.midpoints.get(joint, ()), joint)]
    with pytest.raises(ValueError, match="bends"):
        layout.without(parts)
    below = [point for point in layout.points if layout.parents[point] in joints and point not in layout.rigid]
    ends = [point for point in layout.points if layout.parents[point] in below]
    assert set(layout.points) - {*parts, *below, *ends} == set(layout.without([*parts, *below, *ends]).points)


@pytest.mark.parametrize("rule", ["harrington", "davis"])
def test_hip_joint_centres_are_those_of_the_published_regressions(rule):
    """A pelvis 240 mm wide and 150 mm deep, legs of 900 mm; Harrington et al. (2007), table 3, Davis et al. (1991)."""
    markers = {
        "LASI": (0.0, 0.12, 0.0),
        "LPSI": (-0.15, 0.05, 0.0),
        "LKNE": (0.0, 0.12, -0.5),
        "LANK": (0.0, 0.12, -0.9),
    }
    markers |= {"R" + name[1:]: np.array(at) * [1, -1, 1] for name, at in markers.items()}
    parts = {}
    for side, (near, far) in {"left_hip": "LR", "right_hip": "RL"}.items():
        leg = (near + "KNE", near + "ANK") if rule == "davis" else ()
        parts[side] = (rule, near + "ASI", far + "ASI", near + "PSI", far + "PSI", *leg)
    layout = Layout("hips", markers, dict.fromkeys([*markers, *parts], "LASI") | {"LASI": None}, parts, up="z")
    turned = Rotation.from_rotvec([0.3, -1.0, 2.0])
    found = layout.keypoints(Keypoints(turned.apply([*markers.values()])[None] + 2.0, markers, 100, up="z"))
    if rule == "harrington":
        x, y, z = -0.24 * 150 - 9.9, 0.33 * 240 + 7.3, -0.30 * 240 - 10.9
    else:
        c, d = 0.115 * 900 - 15.3, 0.1288 * 900 - 48.56 + 7.0
        cos_b, sin_b, cos_t, sin_t = (f(np.radians(a)) for a in (18.0, 28.4) for f in (np.cos, np.sin))
        x, y, z = c * cos_t * sin_b - d * cos_b, 120 - c * sin_t, -c * cos_t * cos_b - d * sin_b
    expected = turned.apply(np.array([[x, y, z], [x, -y, z]]) / 1000.0) + 2.0
    np.testing.assert_allclose(found.positions[0, -2:], expected, atol=1e-9)


def test_centres_of_knees_and_ankles_are_half_a_width_inward():
    """At a right angle to the thigh or shank, in the plane of the wand; 6 and 4.2 cm for segments of 42 cm."""
    knee, ankle = np.zeros(3), np.array([0.0, 0.0, -0.42])
    markers = {"hip": [0.0, 0.0, 0.42], "KNE": [0.0, 0.06, 0.0], "THI": [0.0, 0.09, 0.2]}
    markers |= {"ANK": [0.042, 0.0, -0.42], "TIB": [0.1, 0.0, -0.2]}
    parts = {"left_knee": ("davis_knee", "hip", "KNE", "THI"), "left_ankle": ("davis_ankle", "left_knee", "ANK", "TIB")}
    layout = Layout("leg", markers, dict.fromkeys([*markers, *parts], "hip") | {"hip": None}, parts, up="z")
    turned = Rotation.from_rotvec([0.3, -1.0, 2.0])
    found = layout.keypoints(Keypoints(turned.apply([*markers.values()])[None] + 2.0, markers, 100, up="z"))
    np.testing.assert_allclose(found.positions[0, -2:], turned.apply([knee, ankle]) + 2.0, atol=1e-3)
    without = layout.without(["THI"]).keypoints(found.select(markers))
    np.testing.assert_array_equal(without.positions[:, -2:], found.positions[:, [1, 3]])  # the markers


def test_a_lost_marker_of_the_pelvis_loses_the_hips():
    layout = layouts["plug_in_gait39"]
    positions = np.random.default_rng(0).normal(size=(3, 39, 3))
    positions[1, layout.names.index("LPSI")] = np.nan
    found = layout.keypoints(positions, frame_rate=100)
    hips = found.positions[:, [found.names.index(f"{side}_hip") for side in ("left", "right")]]
    np.testing.assert_array_equal(np.isnan(hips).any(axis=(1, 2)), [False, True, False])
