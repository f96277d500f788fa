"""Rest poses belong to layouts: equal numbers are the same pose of all people, and in all of their recordings."""

from dataclasses import replace

import numpy as np
import pytest
from people import ARM, moving, standing
from scipy.spatial.transform import Rotation

from skpose import Skeleton, forward_kinematics, inverse_kinematics, pose_distances
from skpose.datasets import MotionDataset
from skpose.keypoints import Layout, fit_skeleton, layouts
from skpose.keypoints._standing import standing_directions
from skpose.skeleton._shared import directions_at_zero

LARGEST = 45.0  # degrees by which rest poses may differ in one data set
HAND = Layout(
    "hand",
    ["wrist", "thumb_cmc", "thumb_mcp", "index_finger_mcp", "index_finger_pip", "pinky_mcp"],
    {
        "wrist": None,
        "thumb_cmc": "wrist",
        "thumb_mcp": "thumb_cmc",
        "index_finger_mcp": "wrist",
        "index_finger_pip": "index_finger_mcp",
        "pinky_mcp": "wrist",
    },
    rigid=["thumb_cmc", "index_finger_mcp", "pinky_mcp"],
)


@pytest.fixture(params=list(layouts))
def layout(request):
    return layouts[request.param]


def doing(layout, lift, n=60, seed=0):
    """Positions of a person who moves about a pose that is not that of standing: arms and thighs lifted forward."""
    names, rng = list(layout.points), np.random.default_rng(seed)
    found = np.stack([[standing(name) for name in names]] * n)
    times = np.linspace(0, 6, n)
    for joint in ("shoulder", "hip", "clavicle", "hipjoint"):
        for name in names:
            if joint not in (name.split("_")[-1], name[1:]):
                continue
            below = [name]
            for one in below:
                below += [child for child in names if layout.parents[child] == one]
            angles = -lift + 0.2 * np.sin(times + rng.uniform(0, 6))
            turns, indices = Rotation.from_euler("x", angles[:, None]), [names.index(one) for one in below]
            for i in indices:
                found[:, i] = turns.apply(found[:, i] - standing(name)) + standing(name)
    found = found[:, : len(layout.names)]
    return {"y": found, "z": found[..., [2, 0, 1]], "-y": found * [1.0, -1.0, -1.0]}[layout.up]


def test_people_who_do_different_things_have_one_rest_pose(layout):
    one, other = (fit_skeleton(doing(layout, lift), layout) for lift in (0.2, 1.6))
    np.testing.assert_allclose(one.rest_rotations, other.rest_rotations, atol=1e-12)
    apart = np.degrees(np.arccos(np.clip((directions_at_zero(one) * directions_at_zero(other)).sum(axis=1), -1, 1)))
    apart[np.linalg.norm(one.offsets, axis=1) == 0.0] = 0.0
    assert apart.max() < LARGEST / 2  # rigid points in the axes of what they are rigid with


def test_poses_of_people_who_do_different_things_go_into_one_data_set():
    layout = layouts["coco17"]
    motions = []
    for lift in (0.2, 1.6):
        keypoints = layout.keypoints(doing(layout, lift), 25)
        motions.append(inverse_kinematics(keypoints, fit_skeleton(keypoints, layout), regularization=0.02).to_motion())
    dataset = MotionDataset(motions, subjects=["a", "b"]).with_root("tilt")
    poses, _ = dataset.poses()
    for motion, skeleton in zip(dataset, [motion.skeleton for motion in dataset], strict=True):
        # On the mean skeleton the poses are those of the person's own: here people have the same lengths.
        np.testing.assert_allclose(
            forward_kinematics(motion.angles, dataset.skeleton), forward_kinematics(motion.angles, skeleton), atol=0.05
        )
    distances = pose_distances(poses, skeleton=dataset.skeleton, metric="position")
    assert distances[:60, :60].max() < distances[:60, 60:].min()  # they do not do the same


def test_an_arm_that_is_raised_and_a_squat_are_far_from_half_a_turn():
    layout = layouts["kinect25"]
    for lift in (0.0, 2.9):  # hanging, and overhead
        keypoints = layout.keypoints(doing(layout, lift), 25)
        fitted = inverse_kinematics(keypoints, fit_skeleton(keypoints, layout), regularization=0.02)
        elbow = fitted.skeleton.dof_names.index("left_elbow_rotvec_x")
        assert np.linalg.norm(fitted.poses[:, elbow : elbow + 3], axis=1).max() < 2.5


def test_all_bones_that_move_in_layouts_of_the_library_have_a_rest_pose_of_the_layout(layout):
    moving_bones = {name for name in layout.points if layout.parents[name] is not None} - layout.rigid
    assert moving_bones - set(standing_directions(layout)) == set()


def test_a_hand_has_one_rest_pose_however_it_is_held():
    rng = np.random.default_rng(0)
    hand = np.array(
        [[0, 0, 0], [0.03, 0.03, 0.01], [0.06, 0.05, 0.02], [0.03, 0.09, 0], [0.03, 0.12, -0.02], [-0.03, 0.08, 0]]
    )
    skeletons = []
    for seed in (0, 1):
        turns = Rotation.random(40, random_state=seed)
        positions = np.stack([turns.apply(np.tile(point, (40, 1))) for point in hand], axis=1)
        positions[:, 4] += 0.005 * rng.normal(size=(40, 3))
        skeletons.append(fit_skeleton(positions, HAND))
    np.testing.assert_allclose(skeletons[0].rest_rotations, skeletons[1].rest_rotations, atol=1e-12)
    rest = forward_kinematics(np.zeros((1, skeletons[0].n_dofs)), skeletons[0])[0]
    for i in (1, 3, 5):  # the palm, with x to the thumb
        found, truth = (
            np.linalg.norm(rest[i] - rest[[0, 1, 3, 5]], axis=1),
            np.linalg.norm(hand[i] - hand[[0, 1, 3, 5]], axis=1),
        )
        np.testing.assert_allclose(found, truth, atol=1e-9)
    assert rest[1, 0] > 0.0 > rest[5, 0]


def test_bones_between_other_points_have_their_mean_direction():
    rng = np.random.default_rng(0)
    positions = np.zeros((50, 3, 3))
    positions[:, 1] = [0.0, -0.3, 0.0] + 0.02 * rng.normal(size=(50, 3))
    positions[:, 2] = positions[:, 1] + [0.25, 0.0, 0.0]
    rest = forward_kinematics(np.zeros((1, 6)), fit_skeleton(positions, ARM))[0]
    assert rest[1][1] < -0.29
    assert rest[2][0] - rest[1][0] > 0.24


def test_left_and_right_exchanged_are_named_in_a_warning():
    for name in ("coco17", "kinect25", "cmu31"):
        layout = layouts[name]
        positions = moving(layout)
        with pytest.warns(UserWarning, match="point backward, where those of people point forward: left and right"):
            fit_skeleton(positions * [-1, 1, 1], layout)
        swapped = {a: b for pair in layout.pairs for a, b in (pair, pair[::-1])}
        names = [swapped.get(point, point) for point in layout.names]
        with pytest.warns(UserWarning, match="point backward"):
            fit_skeleton(positions, replace(layout, names=names))


@pytest.mark.filterwarnings("ignore:.* is taken as the :UserWarning")  # some layouts are lifted at the pelvis
def test_people_of_one_layout_have_a_mean(layout):
    one, other = fit_skeleton(doing(layout, 0.2), layout), fit_skeleton(1.2 * doing(layout, 1.2), layout)
    mean = Skeleton.mean([one, other])
    np.testing.assert_allclose(mean.rest_rotations, one.rest_rotations, atol=1e-12)
