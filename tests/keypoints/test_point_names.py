"""Points of keypoints are found by name, in any order and spelling; what is missing or double is refused."""

import numpy as np
import pytest
from people import moving
from scipy.spatial.transform import Rotation

from skpose import forward_kinematics, inverse_kinematics
from skpose.keypoints import Keypoints, Layout, fit_skeleton, layouts
from skpose.keypoints._names import find_names

MARKERS = ["opencap43", "plug_in_gait39", "opencap_mocap55"]


def camel(name):
    return "".join(word.capitalize() for word in name.split("_"))


SPELLINGS = {
    "upper": str.upper,
    "title": str.title,
    "camel": camel,
    "blanks": lambda name: name.replace("_", " "),
    "openpose": lambda name: camel(name).replace("Left", "L").replace("Right", "R"),
    "kinect": lambda name: camel("_".join(sorted(name.split("_"), key=lambda word: word in ("left", "right")))),
}


@pytest.mark.parametrize("spelling", SPELLINGS)
@pytest.mark.parametrize("layout", ["coco17", "kinect25", "kinect20", "mediapipe33", "body25"])
def test_any_order_and_spelling(layout, spelling):
    layout = layouts[layout]
    positions = moving(layout, n=5)
    order = np.random.default_rng(0).permutation(len(layout.names))
    up = layout.up[-1]
    given = positions * [1, -1, -1] if layout.up == "-y" else positions
    names = [SPELLINGS[spelling](layout.names[i]) for i in order]
    keypoints = Keypoints(np.insert(given[:, order], 3, 7.0, axis=1), np.insert(names, 3, "a cap").tolist(), 30, up=up)
    found, expected = layout.keypoints(keypoints), layout.keypoints(positions, 30)
    assert (found.names, found.up, found.frame_rate) == (layout.points, up, 30)
    np.testing.assert_array_equal(found.positions, expected.positions)
    np.testing.assert_array_equal(found.confidences, expected.confidences)


def test_the_nearest_spelling_comes_first():
    assert find_names(["left_hip"], ["LHip", "Left_Hip", "left_hip"]) == {"left_hip": "left_hip"}
    assert find_names(["left_hip"], ["LHip", "Left_Hip"]) == {"left_hip": "Left_Hip"}
    assert find_names(["left_hip", "r_knee_study"], ["LHip", "R_knee_study"]) == {
        "left_hip": "LHip",
        "r_knee_study": "R_knee_study",
    }
    assert find_names(["left_hip"], ["hip", "right_hip", "lefthip2", "left_hip_study"]) == {}
    assert find_names(["head"], ["left_head", "heads"]) == {}
    for names in (["Left_Hip", "LEFT_HIP"], ["LHip", "HipLeft"]):
        with pytest.raises(ValueError, match=f"'left_hip' may be '{names[0]}' or '{names[1]}': name one of them"):
            find_names(["left_hip"], names)


def test_a_point_that_is_not_there_is_refused_with_the_remedy():
    coco = layouts["coco17"].keypoints(moving(layouts["coco17"], n=3), 30)
    with pytest.raises(ValueError, match=r"no point named 'left_heel'.*without\(\['left_heel', 'right_heel'"):
        Layout(
            "heels",
            ["left_hip", "left_knee", "left_heel", "right_heel"],
            {"left_hip": None, "left_knee": "left_hip", "left_heel": "left_knee", "right_heel": "left_knee"},
        ).keypoints(coco)
    with pytest.raises(ValueError, match=r"no point named 'hip_center'.*or make a Layout of your own for the points"):
        layouts["kinect20"].keypoints(coco)
    with pytest.raises(ValueError, match="keypoints have a frame rate and confidences: pass no others"):
        layouts["coco17"].keypoints(coco, frame_rate=30)
    with pytest.raises(ValueError, match="frame_rate must be the frames per second of the positions, in Hz, got None"):
        layouts["coco17"].keypoints(coco.positions[:, :17])


def test_keypoints_keep_a_midpoint_of_their_own():
    layout = layouts["pose2sim21"]
    positions = moving(layout, n=4)
    own = Keypoints(np.insert(positions, 0, [[0.5, 1.0, 0.2]], axis=1), ["Hip", *layout.names], 60)
    made = layout.keypoints(Keypoints(positions, layout.names, 60))
    np.testing.assert_array_equal(layout.keypoints(own).positions[:, -1], [[0.5, 1.0, 0.2]] * 4)
    hips = [layout.names.index(f"{side}_hip") for side in ("left", "right")]
    np.testing.assert_allclose(made.positions[:, -1], positions[:, hips].mean(axis=1))


def test_means_of_any_number_of_points():
    layout = layouts["plug_in_gait39"]
    positions = moving(layout, n=6)
    confidences = np.random.default_rng(0).uniform(0.1, 1, positions.shape[:2])
    positions[2, layout.names.index("RPSI")] = np.nan
    made = layout.keypoints(positions, 100, confidences)
    for name, parts in layout.midpoints.items():
        columns = [layout.names.index(part) for part in parts]
        mean = positions[:, columns].mean(axis=1)
        sure = np.where(np.isnan(mean[:, 0]), 0.0, confidences[:, columns].min(axis=1))
        np.testing.assert_allclose(made.positions[:, made.names.index(name)], mean, atol=1e-15)
        np.testing.assert_array_equal(made.confidences[:, made.names.index(name)], sure)
    assert np.isnan(made.positions[2, made.names.index("pelvis")]).all()
    three = Layout("three", ["a", "b", "c"], {"m": None, "a": "m", "b": "m", "c": "m"}, {"m": ["a", "b", "c"]})
    np.testing.assert_array_equal(three.keypoints([[[3.0, 0, 0], [0, 3, 0], [0, 0, 6]]], 1).positions[0, 3], [1, 1, 2])
    with pytest.raises(TypeError, match="midpoint 'm' must be a sequence of names, got one string, 'abc'"):
        Layout("three", ["a", "b", "c"], {"m": None, "a": "m", "b": "m", "c": "m"}, {"m": "abc"})


@pytest.mark.parametrize("name", ["kinect20", "mediapipe_hand21", "pose2sim21", *MARKERS])
def test_poses_of_the_new_layouts_reach_all_points(name):
    layout = layouts[name]
    keypoints = layout.keypoints(moving(layout, n=40), 30)
    skeleton = fit_skeleton(keypoints, layout)
    fitted = inverse_kinematics(keypoints, skeleton)
    assert np.nanmax(fitted.residuals) < 1e-4


def test_points_that_only_the_standing_trial_has():
    """Medial markers are taken off before a person moves: knees and ankles are where the others show them."""
    layout = layouts["opencap_mocap55"]
    positions = moving(layout, n=60)
    whole, off = Keypoints(positions, layout.names, 100), ["L_mknee", "R_mknee", "L_mankle", "R_mankle"]
    less = whole.select([name for name in layout.names if name not in off])
    with pytest.raises(
        ValueError, match=r"no point named 'L_mankle'.*or absent=\"unseen\", if other recordings of the"
    ):
        layout.keypoints(less)
    walk = layout.keypoints(less, absent="unseen")
    truth = layout.keypoints(whole)
    unseen = [*off, "L_KJC", "R_KJC", "L_AJC", "R_AJC"]
    for i, name in enumerate(layout.points):
        if name in unseen:
            assert np.isnan(walk.positions[:, i]).all(), name
            assert not walk.confidences[:, i].any()
        else:
            np.testing.assert_array_equal(walk.positions[:, i], truth.positions[:, i])
    skeleton = fit_skeleton([truth[:20], walk], layout)
    found = forward_kinematics_in_space(inverse_kinematics(walk, skeleton).to_motion())
    # Of hips, knees and ankles; not a mean of the markers that are left, which are at the outside.
    columns = [skeleton.joint_names.index(name) for name in unseen]
    expected = truth.positions[:, [layout.points.index(name) for name in unseen]]
    assert np.linalg.norm(found[:, columns] - expected, axis=2).max() < 1e-4


def test_absent_points_are_refused_where_nothing_is_there():
    layout = layouts["coco17"]
    with pytest.raises(ValueError, match="absent must be 'refuse' or 'unseen', got 'nan'"):
        layout.keypoints(moving(layout, n=3), 30, absent="nan")
    with pytest.raises(ValueError, match="the keypoints have no point named 'nose'"):
        layout.keypoints(Keypoints(np.random.default_rng(0).normal(size=(3, 2, 3)), ["a", "b"], 30), absent="unseen")


@pytest.mark.parametrize("name", MARKERS)
def test_names_of_means_are_those_of_no_marker(name):
    """Names are found in any spelling: L_knee, a marker, must not pass as left_knee, the mean of two."""
    layout = layouts[name]
    assert find_names(layout.midpoints, layout.names) == {}


def forward_kinematics_in_space(motion):
    """Positions (n_frames, n_joints, 3) in the world."""
    root = Rotation.from_euler(motion.root_axes, motion.root_angles).as_matrix()
    return (
        np.einsum("nij,nkj->nki", root, forward_kinematics(motion.angles, motion.skeleton))
        + (motion.root_positions[:, None])
    )
