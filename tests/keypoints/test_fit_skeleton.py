"""fit_skeleton: a joint for each point, and the rest pose of the layout."""

import warnings

import numpy as np
import pytest
import reference
from people import PEOPLE, errors, moving, person, standing, standing_in, true_lengths
from scipy.spatial.transform import Rotation

from skpose import Bone, Skeleton, forward_kinematics, inverse_kinematics
from skpose.keypoints import Keypoints, fit_skeleton, layouts
from skpose.keypoints._root_axes import Points, root_axes
from skpose.plot import PoseDisplay


@pytest.fixture(params=list(layouts))
def layout(request):
    return layouts[request.param]


def poses_at(skeleton, positions, layout):
    """Root rotations and poses that reach the positions (n, n_points, 3) of the layout's points, joint by joint."""
    rest = dict(
        zip(skeleton.joint_names, reference.forward_kinematics(np.zeros(skeleton.n_dofs), skeleton)[0], strict=True)
    )
    world = {
        name: positions[:, i] - positions[:, layout.points.index(layout.root)] for i, name in enumerate(layout.points)
    }
    children = [name for name, parent in layout.parents.items() if parent == layout.root]
    roots, poses = [], []
    for t in range(len(positions)):
        rigid = [c for c in children if c in layout.rigid] or children
        trunk = [c for c in children if not any(c in pair for pair in layout.pairs)]
        start, end = np.array([rest[c] for c in rigid + trunk]), np.array([world[c][t] for c in rigid + trunk])
        start, end = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (start, end))
        root = Rotation.align_vectors(end, start, weights=[1e6] * len(rigid) + [1.0] * len(trunk))[0]
        axes, pose = {layout.root: root}, []
        for bone in skeleton.bones[1:]:
            axes[bone.name] = axes[bone.parent]
            if bone.dofs:
                still = axes[bone.parent] * Rotation.from_matrix(np.array(bone.rest_rotation))
                fixed = [b for b in skeleton.bones if b.parent == bone.name and not b.dofs]
                local = [np.array(bone.offset)] + [np.array(b.offset) for b in fixed]
                seen = [world[bone.name][t] - world[bone.parent][t]]
                seen += [world[b.name][t] - world[bone.name][t] for b in fixed]
                if fixed:
                    turn = Rotation.align_vectors(still.inv().apply(seen), local)[0]
                else:
                    turn = shortest(local[0], still.inv().apply(seen[0]))
                pose.append(turn.as_rotvec())
                axes[bone.name] = still * turn
        roots.append(root.as_rotvec())
        poses.append(np.concatenate(pose))
    return Rotation.from_rotvec(np.array(roots)), np.array(poses)


def shortest(start, end):
    axis = np.cross(start, end)
    sine = np.linalg.norm(axis)
    return Rotation.from_rotvec(axis / max(sine, 1e-300) * np.arctan2(sine, start @ end))


def test_every_point_has_a_joint_and_bones_that_move_lie_along_x(layout):
    skeleton = fit_skeleton(moving(layout), layout)
    assert set(skeleton.joint_names) == set(layout.points)
    assert skeleton.joint_names[0] == layout.root
    assert skeleton.offset_frame == "own"
    assert skeleton.bones[0] == Bone(layout.root, None, (0.0, 0.0, 0.0))
    for bone in skeleton.bones[1:]:
        assert bone.parent == layout.parents[bone.name]
        assert bone.dofs == ("" if bone.name in layout.rigid else "rotvec")
        assert bone.offset[1:] == (0.0, 0.0) or not bone.dofs
        assert bone.offset[0] > 0.0 or not bone.dofs
        assert (bone.rest_rotation is None) <= (not bone.dofs)


def test_the_skeleton_reaches_the_positions_far_from_half_turns(layout):
    positions = moving(layout, n=60)
    skeleton = fit_skeleton(positions, layout)
    keypoints = layout.keypoints(positions, 1)
    roots, poses = poses_at(skeleton, keypoints.positions, layout)
    reached = forward_kinematics(poses, skeleton)
    reached = np.stack([roots.apply(reached[:, i]) for i in range(reached.shape[1])], axis=1)
    wanted = keypoints.select(skeleton.joint_names).positions
    wanted = wanted - wanted[:, :1]
    np.testing.assert_allclose(reached, wanted, atol=1e-6)
    vectors = poses.reshape(len(poses), -1, 3)
    assert np.linalg.norm(vectors, axis=2).max() < 2.3


@pytest.mark.parametrize("name", PEOPLE)
def test_the_rest_pose_has_x_to_the_left_y_up_and_z_forward(name):
    layout = layouts[name]
    skeleton = fit_skeleton(moving(layout), layout)
    rest = dict(zip(skeleton.joint_names, forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton)[0], strict=True))
    for left, right in layout.pairs:
        assert rest[left][0] > 0.0 > rest[right][0]
        np.testing.assert_allclose(rest[left], rest[right] * [-1, 1, 1], atol=0.03)  # as symmetric as the person
    for name, parent in layout.parents.items():
        truth = standing(name) - standing(parent) if parent else np.zeros(3)
        if abs(truth[1]) > 0.8 * np.linalg.norm(truth):  # upright in somebody who stands straight
            assert truth[1] * (rest[name] - rest[parent])[1] > 0.0, name
    for name in {"left_wrist", "lwrist", "left_hand", "nose"} & set(rest):
        assert rest[name][2] > 0.08, name


def test_a_hand_at_rest_has_its_knuckles_up_and_its_thumb_along_x():
    """Whichever way it was turned in the world; z is perpendicular to the palm."""
    layout, turn = layouts["mediapipe_hand21"], Rotation.random(random_state=3)
    for axes in (np.eye(3), turn.as_matrix()):
        skeleton = fit_skeleton(moving(layout, n=50) @ axes, layout)
        rest = dict(
            zip(skeleton.joint_names, forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton)[0], strict=True)
        )
        palm = [rest[name] for name in layout.points if name in layout.rigid]
        mean = np.mean(palm, axis=0)
        assert mean[1] > 0.05
        np.testing.assert_allclose(mean[2], 0.0, atol=1e-9)
        across = rest["thumb_cmc"] - rest["pinky_mcp"]
        assert across[0] > 0.03
        np.testing.assert_allclose(across[2], 0.0, atol=1e-9)


def test_how_the_person_stands_in_the_world_plays_no_part(layout):
    positions = moving(layout, n=50)
    rng = np.random.default_rng(0)
    rotations = Rotation.random(50, random_state=1)
    moved = np.stack([rotations.apply(positions[:, i]) for i in range(positions.shape[1])], axis=1)
    moved += rng.normal(size=(50, 1, 3))
    one, other = fit_skeleton(positions, layout), fit_skeleton(moved, layout)
    np.testing.assert_allclose(one.rest_rotations, other.rest_rotations, atol=1e-9)
    np.testing.assert_allclose(one.offsets, other.offsets, atol=1e-9)


def test_a_point_of_confidence_zero_is_not_seen(layout):
    positions = moving(layout, n=40)
    confidences = np.ones(positions.shape[:2])
    confidences[10:20, 3] = 0.0
    hidden = positions.copy()
    hidden[10:20, 3] = np.nan
    assert fit_skeleton(layout.keypoints(positions, 25, confidences), layout) == fit_skeleton(hidden, layout)


def test_frames_without_a_point_count_for_nothing(layout):
    positions = moving(layout, n=40)
    lost = np.insert(positions, [5, 5, 30], np.nan, axis=0)
    one, other = fit_skeleton(lost, layout), fit_skeleton(positions, layout)
    np.testing.assert_allclose(one.offsets, other.offsets, atol=1e-12)
    np.testing.assert_allclose(one.rest_rotations, other.rest_rotations, atol=1e-12)


def test_a_fifth_of_the_points_may_be_missing(layout):
    positions = moving(layout, n=400)
    whole = fit_skeleton(positions, layout)
    positions[np.random.default_rng(0).uniform(size=positions.shape[:2]) < 0.2] = np.nan
    skeleton = fit_skeleton(positions, layout)
    assert max(map(abs, errors(skeleton, true_lengths(layout)).values())) < 1e-12
    np.testing.assert_allclose(whole.rest_rotations, skeleton.rest_rotations, atol=1e-12)
    np.testing.assert_allclose(whole.offsets, skeleton.offsets, atol=0.02)  # rigid points by their mean directions


def test_rigid_points_keep_their_shape_where_points_are_missing(layout):
    positions = moving(layout, n=400)
    positions[np.random.default_rng(0).uniform(size=positions.shape[:2]) < 0.2] = np.nan
    skeleton = fit_skeleton(positions, layout)
    rest = dict(zip(skeleton.joint_names, forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton)[0], strict=True))
    for name in layout.rigid:
        parent = layout.parents[name]
        siblings = [other for other in layout.rigid if layout.parents[other] == parent]
        for other in {*siblings, parent, layout.parents[parent] or parent}:
            found, truth = (np.linalg.norm(at[name] - at[other]) for at in (rest, standing_in(layout)))
            np.testing.assert_allclose(found, truth, atol=1e-8)


def test_the_root_follows_the_hips_and_not_the_trunk():
    layout = layouts["coco17"]
    positions = np.stack([[standing(name) for name in layout.names]] * 100)
    lean = Rotation.from_euler("z", 0.5 * np.sin(np.linspace(0, 20, 100))[:, None])  # to the left and to the right
    legs = {"hip", "knee", "ankle"}
    for i, name in enumerate(layout.names):
        if name.split("_")[-1] not in legs:
            positions[:, i] = lean.apply(positions[:, i] - standing("pelvis")) + standing("pelvis")
    keypoints = layout.keypoints(positions, 25)
    points = Points(
        {name: keypoints.positions[:, i] for i, name in enumerate(layout.points)},
        {name: keypoints.confidences[:, i] for i, name in enumerate(layout.points)},
    )
    axes = Rotation.from_matrix(root_axes(points, layout, "y"))
    assert axes.magnitude().max() < 0.05


def test_points_of_keypoints_are_found_by_name():
    layout = layouts["coco17"]
    keypoints = layout.keypoints(moving(layout), 25)
    shuffled = keypoints.select(sorted(keypoints.names, reverse=True))
    more = Keypoints(
        np.insert(shuffled.positions, 0, 7.0, axis=1),
        ("hat", *shuffled.names),
        25,
        np.insert(shuffled.confidences, 0, 1, 1),
    )
    assert fit_skeleton(more, layout) == fit_skeleton(keypoints, layout)


def test_a_single_frame_is_enough(layout):
    keypoints = layout.keypoints(moving(layout, n=1), 1)
    fitted = inverse_kinematics(keypoints, fit_skeleton(keypoints, layout))
    assert fitted.residuals.max() < 1e-6


def test_two_frames_are_enough(layout):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # lengths from two frames are uncertain
        noise = 0.01 * np.random.default_rng(0).normal(size=(2, len(layout.names), 3))
        skeleton = fit_skeleton(moving(layout, n=300)[[0, 150]] + noise, layout)
    assert np.isfinite(skeleton.offsets).all()


@pytest.mark.parametrize("name", PEOPLE)
def test_skeletons_of_two_people_have_a_mean(name):
    layout = layouts[name]
    noise = 0.01 * np.random.default_rng(0).normal(size=(400, len(layout.names), 3))
    one = fit_skeleton(moving(layout, n=400, seed=0), layout)
    other = fit_skeleton(1.1 * moving(layout, n=400, seed=1) + noise, layout)
    mean = Skeleton.mean([one, other])
    assert mean.dof_names == one.dof_names


@pytest.mark.parametrize("name", ["h36m17", "kinect25", "smpl24", "cmu31"])
def test_weights_of_mass_find_the_segments(name):
    skeleton = fit_skeleton(moving(layouts[name]), layouts[name])
    by_hand = person(layouts[name]).with_weights("mass")
    np.testing.assert_allclose(skeleton.with_weights("mass").weights.sum(), by_hand.weights.sum())


@pytest.mark.parametrize("name", ["coco17", "mediapipe33", "body25"])
def test_weights_of_mass_need_a_head(name):
    with pytest.raises(ValueError, match="expected a head"):
        fit_skeleton(moving(layouts[name]), layouts[name]).with_weights("mass")


@pytest.mark.parametrize("name", PEOPLE)
def test_it_can_be_drawn(name):
    layout = layouts[name]
    skeleton = fit_skeleton(moving(layout, n=20), layout)
    display = PoseDisplay.from_pose(np.zeros(skeleton.n_dofs), skeleton)
    assert len(display.ax_.lines) == 3  # the middle, the left, the right
