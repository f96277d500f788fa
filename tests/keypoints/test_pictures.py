"""Keypoints in two dimensions passed as three."""

import io
import warnings

import numpy as np
import pytest
from people import ARM, PEOPLE, moving, person
from scipy.spatial.transform import Rotation

from skpose import forward_kinematics, inverse_kinematics
from skpose.io import MocapFormatError, load_keypoints
from skpose.keypoints import Keypoints, Layout, fit_skeleton, layouts

COCO = layouts["coco17"]
RNG = np.random.default_rng(0)
FLAT = moving(COCO, n=20)
FLAT[:, :, 2] = 0.0
# COCO's (x, y, v) in pixels, as it labels them; (0, 0, 0) where a point is not labelled.
LABELLED = np.concatenate([RNG.uniform(100, 500, (20, 17, 2)).round(), RNG.integers(1, 3, (20, 17, 1))], axis=2)
LABELLED[3, 4] = 0.0
PIXELS = moving(COCO, n=20) * [200, -200, 0] + [320, 480, 0]
SCORES = RNG.uniform(0.3, 0.9, (20, 17, 1))
SCORED = np.concatenate([RNG.uniform(100, 500, (20, 17, 2)), RNG.uniform(0, 1, (20, 17, 1))], axis=2)
PLANE, FLAGS, SCORE, DEEP = "in one plane", "COCO's visibility", "a score as third number", "depths in another unit"
PICTURES = [
    (FLAT, PLANE),
    (FLAT[:1], PLANE),
    (FLAT @ Rotation.random(random_state=1).as_matrix(), PLANE),
    (LABELLED, FLAGS),
    (SCORED, SCORE),
    (np.where(np.arange(20)[:, None, None] == 3, [1, 1, 1.2], 1) * np.add(PIXELS, [0, 0, 1] * SCORES), DEEP),
    (np.add(2 * PIXELS, [0, 0, 100] * SCORES), SCORE),
]
DOORS = {
    "Layout.keypoints": lambda array: COCO.keypoints(array, 30),
    "fit_skeleton": lambda array: fit_skeleton(array, COCO),
    "load_keypoints": lambda array: load_keypoints(npz(array), names=COCO.names, frame_rate=30),
}


def npz(array):
    file = io.BytesIO()
    np.savez(file, positions=array)
    return io.BytesIO(file.getvalue())


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize(("array", "sign"), PICTURES)
def test_pictures_are_refused_at_every_door(door, array, sign):
    with pytest.raises(ValueError, match=sign) as caught:
        DOORS[door](array)
    assert isinstance(caught.value, MocapFormatError) == door.startswith("load")


@pytest.mark.filterwarnings("ignore:.* is taken as the :UserWarning")  # whoever is turned does not stand
@pytest.mark.parametrize("name", PEOPLE)
def test_people_are_not_refused(name):
    """Nor one frame of them, in any axes; nor when they lie, or walk far in some other unit."""
    layout = layouts[name]
    positions = moving(layout, n=30)
    turned = positions @ Rotation.random(random_state=2).as_matrix()
    for array in (
        positions,
        turned,
        positions[:1],
        positions * 1000,
        np.add(positions, [30, 0, 0]),
        positions.round(3),
    ):
        layout.keypoints(array, 30)
    skeleton = person(layout)
    inverse_kinematics(forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton), skeleton)


def test_an_arm_may_move_in_one_plane():
    angles = RNG.uniform(-1, 1, (30, 2)).cumsum(axis=1)
    steps = 0.3 * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=2)
    positions = np.concatenate([np.zeros((30, 1, 3)), steps.cumsum(axis=1)], axis=1)
    fit_skeleton(ARM.keypoints(positions, 30), ARM)
    seven = np.concatenate([positions, positions[:, :2] + [1, 1, 0], positions[:, :2] - [1, 1, 0]], axis=1)
    Keypoints(seven, [f"p{i}" for i in range(7)], 30)
    sided = [f"{side}_{part}" for side in ("left", "right") for part in ("shoulder", "elbow", "wrist")]
    with pytest.raises(ValueError, match=PLANE):
        Keypoints(seven[:, :6], sided, 30)


LANDMARKS = RNG.uniform(0.2, 0.8, (5, 33, 3))


def messages(call, *arguments, **options):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call(*arguments, **options)
    return [str(one.message) for one in caught]


def test_landmarks_of_a_picture_are_named():
    layout = layouts["mediapipe33"]
    mine = Layout("mine", layout.names, dict(layout.parents), layout.midpoints, layout.rigid)
    signed = LANDMARKS - [0, 0, 0.5]
    for one in (layout, mine):
        (message,) = messages(one.keypoints, signed, 30)
        assert "pose_world_landmarks" in message
        assert messages(one.keypoints, LANDMARKS - LANDMARKS[:, 23:25].mean(axis=1, keepdims=True), 30) == []
    outside = signed.copy()
    outside[:, 4, 0] = 1.02
    assert "pose_world_landmarks" in messages(layout.keypoints, outside, 30)[0]
    outside[:, :5, 0] = 1.02
    assert messages(layout.keypoints, outside, 30) == []
