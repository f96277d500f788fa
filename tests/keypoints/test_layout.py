"""Layouts: the tables that come with the library, those of one's own, and keypoints made by them."""

import copy
import pickle
import re
from dataclasses import replace

import numpy as np
import pytest
from people import ALONE, standing_in

from skpose.io._smpl import MODELS
from skpose.keypoints import Layout, layouts
from skpose.skeleton._sides import partners, sides

ARM = {"names": ["a", "b", "c"], "parents": {"a": None, "b": "a", "c": "b"}}


@pytest.fixture(params=list(layouts))
def layout(request):
    return layouts[request.param]


def test_there_are_layouts_with_as_many_points_as_their_names_say():
    assert {name: len(one.names) for name, one in layouts.items()} == {
        "coco17": 17,
        "mediapipe33": 33,
        "h36m17": 17,
        "body25": 25,
        "kinect25": 25,
        "smpl24": 24,
        "cmu31": 31,
        "kinect20": 20,
        "mediapipe_hand21": 21,
        "pose2sim21": 21,
        "opencap43": 43,
        "opencap_mocap55": 55,
        "plug_in_gait39": 39,
    }
    assert all(name == one.name for name, one in layouts.items())
    with pytest.raises(TypeError):
        layouts["mine"] = layouts["coco17"]
    with pytest.raises(KeyError, match="no layout 'coco'; the layouts are coco17, mediapipe33"):
        layouts["coco"]


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


def test_every_layout_states_its_source_and_can_be_copied(layout):
    assert re.search(r"https?://\S+", layout.source)
    for same in (pickle.loads(pickle.dumps(layout)), copy.deepcopy(layout), replace(layout)):
        assert same == layout
        assert hash(same) == hash(layout)
    assert replace(layout, up="x") != layout
    with pytest.raises(TypeError):
        layout.parents["nose"] = None


def test_bones_have_the_lengths_of_a_person(layout):
    at = standing_in(layout)
    for name, parent in layout.parents.items():
        if parent is not None:
            assert 0.01 < np.linalg.norm(at[name] - at[parent]) < 0.6, (name, parent)


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


def test_smpl_is_that_of_the_reader_of_amass():
    assert dict(layouts["smpl24"].parents) == MODELS["SMPL"]
    assert layouts["smpl24"].names == tuple(MODELS["SMPL"])


def test_cmu_is_that_of_the_files(cmu):
    for motion in cmu.motions:
        assert layouts["cmu31"].names == ("root", *motion.skeleton.joint_names)
        for bone in motion.skeleton.bones:
            assert layouts["cmu31"].parents[bone.name] == (bone.parent or "root")
            assert (bone.name in layouts["cmu31"].rigid) == (bone.n_dofs == 0 and bone.parent is None)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"names": ["a", "b", "b"]}, "layout 'mine': points must differ, got 'b' 2 times"),
        ({"names": ["a", "b", ""]}, "names must be non-empty strings, got ''"),
        ({"names": ["a", "b"]}, "parents has 'c', which is no point; they are a, b"),
        ({"parents": {"a": None, "b": "a"}}, "parents must have every point, but 'c' is missing"),
        ({"parents": {"a": None, "b": "a", "c": "d"}}, "the parent of 'c' is 'd', which is no point"),
        ({"parents": {"a": None, "b": None, "c": "b"}}, "one point must be the root, .* got 2: 'a', 'b'"),
        ({"parents": {"a": None, "b": "c", "c": "b"}}, "cycle of parents: b → c → b"),
        ({"parents": {"a": "c", "b": "a", "c": "b"}}, "cycle of parents: a → c → b → a"),
        ({"midpoints": {"m": ("a", "z")}}, "midpoint 'm' is the mean of 'a', 'z', but 'z' is neither"),
        ({"midpoints": {"m": ("a", "a", "b")}}, "midpoint 'm' must be the mean of two points or more, each once"),
        ({"midpoints": {"m": ("a",)}}, "midpoint 'm' must be the mean of two points or more"),
        ({"midpoints": {"a": ("b", "c")}}, "points must differ, got 'a' 2 times"),
        ({"midpoints": {"m": ("a", "b")}}, "parents must have every point, but 'm' is missing"),
        ({"rigid": ["z"]}, "rigid has 'z', which is no point"),
        ({"rigid": ["b", "c"]}, "at least one point besides the root must not be rigid"),
        ({"up": "down"}, "up must be one of x, y, z, -x, -y, -z, .* got 'down'"),
    ],
)
def test_a_layout_that_is_no_tree_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        Layout("mine", **{**ARM, **change})


def test_one_string_is_no_sequence_of_names():
    with pytest.raises(TypeError, match="names must be a sequence of names, got one string, 'abc'"):
        Layout("mine", **{**ARM, "names": "abc"})


def test_parents_are_found_by_name_and_not_by_number():
    with pytest.raises(TypeError, match=r"parents must be a mapping by name, .* got list"):
        Layout("mine", **{**ARM, "parents": [-1, 0, 1]})


def test_a_side_without_a_partner_makes_no_pair():
    arm = Layout("arm", ["left_elbow", "left_wrist"], {"left_elbow": None, "left_wrist": "left_elbow"})
    assert arm.pairs == ()


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


def test_a_midpoint_may_be_between_midpoints():
    parents = {"a": "m", "b": "m", "c": "n", "m": "n", "n": None}
    layout = Layout("mine", ["a", "b", "c"], parents, midpoints={"m": ("a", "b"), "n": ("m", "c")})
    made = layout.keypoints([[[0.0, 0, 0], [4, 0, 0], [6, 0, 2]]], 1)
    np.testing.assert_array_equal(made.positions[0, 3:], [[2, 0, 0], [4, 0, 1]])


@pytest.mark.parametrize("up", ["x", "y", "z", "-x", "-y", "-z"])
def test_the_world_is_turned_and_not_mirrored(up):
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
        ((5, 17, 2), "two coordinates for each point.*Lift them to 3-D"),
        ((5, 33, 3), r"33 points, and the layout 'coco17' has 17: is it layouts\['mediapipe33'\]\?"),
        ((5, 25, 3), r"25 points.*is it layouts\['body25'\] or layouts\['kinect25'\]\?"),
        ((5, 19, 3), "19 points.*makes pelvis, neck itself, so leave them out"),
        ((5, 18, 3), "18 points.*make a Layout of your own"),
        ((5, 51), r"pass positions.reshape\(-1, 17, 3\)"),
        ((5, 17, 4), r"pass positions\[..., :3\] and confidences=positions\[..., 3\]"),
        ((17, 3), r"must have shape \(n_frames, 17, 3\), got \(17, 3\)"),
    ],
)
def test_positions_of_other_shapes_are_refused_with_a_remedy(shape, message):
    with pytest.raises(ValueError, match=message):
        layouts["coco17"].keypoints(np.ones(shape), 25)


def test_pixels_with_scores_are_refused():
    rng = np.random.default_rng(0)
    picture = np.concatenate([rng.uniform(0, 640, size=(5, 17, 2)), rng.uniform(size=(5, 17, 1))], axis=2)
    with pytest.raises(ValueError, match=r"in two dimensions: in a frame points are spread over 607\.4"):
        layouts["coco17"].keypoints(picture, 25)
    with pytest.warns(UserWarning, match="from 0 to 1, and so are all third numbers, as scores are"):
        layouts["coco17"].keypoints(picture / [640, 640, 1], 25)


def test_confidences_of_another_shape_are_refused():
    with pytest.raises(ValueError, match=r"confidences must have shape \(5, 17\), one a position, got \(17,\)"):
        layouts["coco17"].keypoints(np.ones((5, 17, 3)), 25, np.ones(17))


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


def test_points_that_others_need_cannot_be_left_out():
    with pytest.raises(ValueError, match="'pelvis' is the root"):
        layouts["coco17"].without(["pelvis"])
    with pytest.raises(ValueError, match=r"midpoint 'neck' is the mean of .* 'left_shoulder' is neither"):
        layouts["coco17"].without(["left_shoulder"])
    with pytest.raises(KeyError, match="has no point 'hat'"):
        layouts["coco17"].without(["hat"])
