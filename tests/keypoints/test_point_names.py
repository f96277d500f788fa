"""Points found by name in any order and spelling."""

import numpy as np
import pytest
from people import moving
from scipy.spatial.transform import Rotation

from skpose import forward_kinematics, inverse_kinematics
from skpose.keypoints import Keypoints, fit_skeleton, layouts


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
@pytest.mark.parametrize("layout", ["coco17", "kinect25", "mediapipe33"])
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


def test_points_of_the_standing_trial_only():
    """Medial markers are taken off before a person moves: knees and ankles are where the others show them."""
    layout = layouts["opencap_mocap55"]
    positions = moving(layout, n=60)
    whole, off = Keypoints(positions, layout.names, 100), ["L_mknee", "R_mknee", "L_mankle", "R_mankle"]
    less = whole.select([name for name in layout.names if name not in off])
    with pytest.raises(ValueError, match=r"no 'L_mankle'.*unseen"):
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


def forward_kinematics_in_space(motion):
    """Positions (n_frames, n_joints, 3) in the world."""
    root = Rotation.from_euler(motion.root_axes, motion.root_angles).as_matrix()
    return (
        np.einsum("nij,nkj->nki", root, forward_kinematics(motion.angles, motion.skeleton))
        + (motion.root_positions[:, None])
    )
