"""fit_skeleton: lengths without the bias of noise, a rest pose in the middle, data that have no skeleton."""

import warnings

import numpy as np
import pytest
import reference
from conftest import in_space
from people import moving, person, standing
from scipy.spatial.transform import Rotation

from skpose import Skeleton, forward_kinematics
from skpose.keypoints import Keypoints, Layout, fit_skeleton, layouts
from skpose.plot import PoseDisplay

ARM = Layout("arm", ["shoulder", "elbow", "wrist"], {"shoulder": None, "elbow": "shoulder", "wrist": "elbow"})


@pytest.fixture(params=list(layouts))
def layout(request):
    return layouts[request.param]


def lengths(skeleton):
    return dict(zip(skeleton.joint_names, np.linalg.norm(skeleton.offsets, axis=1), strict=True))


def true_lengths(layout):
    return {n: np.linalg.norm(standing(n) - standing(p)) for n, p in layout.parents.items() if p is not None}


def errors(skeleton, truth):
    found = lengths(skeleton)
    return {name: found[name] / length - 1.0 for name, length in truth.items()}


def one_bone(length, n, noise, seed, change=None):
    """Positions of a rigid bone in all directions, with noise at both ends and a second bone without noise."""
    rng = np.random.default_rng(seed)
    unit = rng.normal(size=(n, 3))
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    length = length if change is None else length * (1.0 + change[:, None])
    joints = np.stack([np.zeros((n, 3)), length * unit, length * unit + [0.0, 1.0, 0.0]], axis=1)
    joints[:, :2] += noise * rng.normal(size=(n, 2, 3))
    return joints


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
            still = axes[bone.parent] * Rotation.from_matrix(np.array(bone.rest_rotation))
            axes[bone.name] = still
            if bone.dofs:
                fixed = [b for b in skeleton.bones if b.parent == bone.name and not b.dofs]
                local = [np.array(bone.offset)] + [np.array(b.rest_rotation) @ b.offset for b in fixed]
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


def test_every_point_has_a_joint_and_bones_lie_along_x(layout):
    skeleton = fit_skeleton(moving(layout), layout)
    assert set(skeleton.joint_names) == set(layout.points)
    assert skeleton.joint_names[0] == layout.root
    assert skeleton.offset_frame == "own"
    assert skeleton.bones[0] == (layout.root, None, (0.0, 0.0, 0.0), "", None, None, None)
    for bone in skeleton.bones[1:]:
        assert bone.parent == layout.parents[bone.name]
        assert bone.dofs == ("" if bone.name in layout.rigid else "rotvec")
        assert bone.offset[0] > 0.0
        assert bone.offset[1:] == (0.0, 0.0)


def test_lengths_without_noise_are_exact(layout):
    assert max(map(abs, errors(fit_skeleton(moving(layout), layout), true_lengths(layout)).values())) < 1e-12


def test_the_skeleton_reaches_the_positions_with_rotations_about_zero(layout):
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
    assert np.linalg.norm(vectors, axis=2).max() < 2.0
    assert np.linalg.norm(vectors.mean(axis=0), axis=1).max() < 0.12


def test_the_rest_pose_stands_with_x_to_the_left_y_up_and_z_forward(layout):
    skeleton = fit_skeleton(moving(layout), layout)
    rest = dict(zip(skeleton.joint_names, forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton)[0], strict=True))
    for name, point in rest.items():
        assert np.linalg.norm(point - (standing(name) - standing(layout.root))) < 0.2, name


def test_how_the_person_stands_in_the_world_plays_no_part(layout):
    positions = moving(layout, n=50)
    rng = np.random.default_rng(0)
    rotations = Rotation.random(50, random_state=1)
    moved = np.stack([rotations.apply(positions[:, i]) for i in range(positions.shape[1])], axis=1)
    moved += rng.normal(size=(50, 1, 3))
    one, other = fit_skeleton(positions, layout), fit_skeleton(moved, layout)
    np.testing.assert_allclose(one.rest_rotations, other.rest_rotations, atol=1e-9)
    np.testing.assert_allclose(one.offsets, other.offsets, atol=1e-9)


def test_lengths_with_noise_of_1_cm_are_within_1_percent(layout):
    truth = true_lengths(layout)
    positions = moving(layout, n=3000)
    noise = 0.01 * np.random.default_rng(0).normal(size=positions.shape)
    found = errors(fit_skeleton(positions + noise, layout), truth)
    assert max(abs(error) for name, error in found.items() if truth[name] > 0.06) < 0.01
    assert max(map(abs, found.values())) < 0.06  # bones that are as short as the noise


def test_the_length_of_a_short_bone_is_unbiased_where_the_mean_is_not():
    found, means = [], []
    for seed in range(30):
        positions = one_bone(0.05, 300, 0.01, seed)
        found.append(lengths(fit_skeleton(positions, ARM))["elbow"])
        means.append(np.linalg.norm(positions[:, 1] - positions[:, 0], axis=1).mean())
    assert abs(np.mean(found) / 0.05 - 1.0) < 0.01
    assert np.mean(means) / 0.05 - 1.0 > 0.07


def test_outliers_do_not_change_a_length():
    positions = one_bone(0.3, 500, 0.01, seed=0)
    positions[::10, 1] += np.random.default_rng(1).normal(size=(50, 3))
    assert abs(lengths(fit_skeleton(positions, ARM))["elbow"] / 0.3 - 1.0) < 0.01


def test_confidences_weigh_the_frames():
    positions = np.concatenate([one_bone(0.3, 100, 0.0, 0), one_bone(0.33, 100, 0.0, 1)])
    confidences = np.ones((200, 3))
    confidences[100:] = 0.1
    rng = np.random.default_rng(0).permutation(200)  # in no order of time, so that nothing changes slowly
    keypoints = ARM.keypoints(positions[rng], 25, confidences[rng])
    plain, weighted = fit_skeleton(positions[rng], ARM), fit_skeleton(keypoints, ARM)
    assert abs(lengths(plain)["elbow"] - 0.315) < 0.002
    assert abs(lengths(weighted)["elbow"] - 0.3) < 0.002


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
    for one, other in zip(whole.bones[1:], skeleton.bones[1:], strict=True):
        turn = np.array(one.rest_rotation).T @ np.array(other.rest_rotation)
        assert Rotation.from_matrix(turn).magnitude() < 0.25


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


def test_a_bone_that_stretches_slowly_is_named_with_its_spread():
    change = 0.2 * np.sin(np.linspace(0, 20, 400))
    with pytest.warns(UserWarning, match="bones stretch slowly.*elbow by 14 % ") as caught:
        skeleton = fit_skeleton(one_bone(0.3, 400, 0.005, 0, change), ARM)
    assert len(caught) == 1
    assert "wrist" not in str(caught[0].message)
    assert abs(lengths(skeleton)["elbow"] / 0.3 - 1.0) < 0.02


def test_noise_of_the_same_spread_is_no_stretch():
    for seed in range(20):  # warnings are errors
        fit_skeleton(one_bone(0.3, 400, 0.03, seed), ARM)


def test_a_length_that_is_lost_in_noise_is_named():
    with pytest.warns(UserWarning, match=r"lengths of bones are uncertain.*: elbow ±.* \(standard error\)"):
        fit_skeleton(one_bone(0.02, 300, 0.02, seed=0), ARM)
    with pytest.warns(UserWarning, match="lengths of bones are uncertain"):
        fit_skeleton(one_bone(0.1, 5, 0.02, seed=0), ARM)  # few frames


def test_standard_errors_are_those_of_repetition():
    from skpose.keypoints._lengths import bone_length

    for length, noise in ((0.3, 0.01), (0.05, 0.01)):
        distances = [
            np.linalg.norm(np.diff(one_bone(length, 200, noise, s)[:, :2], axis=1)[:, 0], axis=1) for s in range(300)
        ]
        found = [bone_length(d, np.ones(200)) for d in distances]
        spread = np.std([one.value for one in found])
        assert 0.8 < np.mean([one.error for one in found]) / spread < 1.2


def test_a_single_frame_is_the_rest_pose(layout):
    positions = moving(layout, n=1)
    skeleton = fit_skeleton(positions, layout)
    rest = forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton)[0]
    found = layout.keypoints(positions, 1).select(skeleton.joint_names).positions[0]
    _, distance = Rotation.align_vectors(found - found[0], rest)
    np.testing.assert_allclose(distance, 0.0, atol=1e-6)


def test_two_frames_are_enough(layout):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # lengths from two frames are uncertain
        noise = 0.01 * np.random.default_rng(0).normal(size=(2, len(layout.names), 3))
        skeleton = fit_skeleton(moving(layout, n=300)[[0, 150]] + noise, layout)
    assert np.isfinite(skeleton.offsets).all()


def test_hips_and_trunk_on_one_line_are_refused():
    layout = layouts["coco17"]
    positions = moving(layout, n=10)
    names = list(layout.names)
    line = {"left_hip": 0.1, "right_hip": -0.1, "left_shoulder": 0.7, "right_shoulder": 0.3}
    for name, x in line.items():
        positions[:, names.index(name)] = [x, 1.0, 0.0]
    with pytest.raises(
        ValueError, match=r"axes of 'pelvis' cannot be found.*'left_hip', 'right_hip', 'neck' .* one line"
    ):
        fit_skeleton(positions, layout)


def test_a_straight_arm_has_a_rest_pose():
    skeleton = fit_skeleton([[[0.0, 0, 0], [0, 0.3, 0], [0, 0.55, 0]]] * 4, ARM)
    np.testing.assert_allclose(
        forward_kinematics(np.zeros((1, 6)), skeleton)[0, 1:], [[0, 0.3, 0], [0, 0.55, 0]], atol=1e-12
    )


def test_directions_that_cancel_each_other_have_no_mean_and_one_is_taken():
    positions = [[[0.0, 0, 0], [0, 0.3, 0], [0, 0.55, 0]], [[0.0, 0, 0], [0, -0.3, 0], [0, -0.55, 0]]]
    skeleton = fit_skeleton(positions, ARM)
    assert np.isfinite(skeleton.rest_rotations).all()
    np.testing.assert_allclose(list(lengths(skeleton).values()), [0, 0.3, 0.25])


def test_all_points_in_one_place_are_refused(layout):
    with pytest.raises(ValueError, match="all points are in one place"):
        fit_skeleton(np.ones((5, len(layout.names), 3)), layout)


def test_a_bone_of_length_zero_is_kept():
    positions = np.zeros((5, 3, 3))
    positions[:, 2] = [0.0, 0.5, 0.0]
    assert lengths(fit_skeleton(positions, ARM)) == {"shoulder": 0.0, "elbow": 0.0, "wrist": 0.5}


def test_positions_that_are_all_nan_are_refused(layout):
    with pytest.raises(ValueError, match="no point is seen in any frame"):
        fit_skeleton(np.full((5, len(layout.names), 3), np.nan), layout)


def test_no_frames_are_refused(layout):
    with pytest.raises(ValueError, match="no frames"):
        fit_skeleton(np.zeros((0, len(layout.names), 3)), layout)


def test_a_point_that_is_never_seen_is_refused_and_the_remedy_works():
    layout = layouts["coco17"]
    positions = moving(layout)
    positions[:, layout.names.index("left_ear")] = np.nan
    keypoints = layout.keypoints(positions, 25)
    with pytest.raises(ValueError, match=r"'left_ear' is never seen.*layout.without\(\['left_ear'\]\)"):
        fit_skeleton(keypoints, layout)
    assert "left_ear" not in fit_skeleton(keypoints, layout.without(["left_ear"]))
    positions[:, layout.names.index("left_hip")] = np.nan
    with pytest.raises(ValueError, match=r"'left_ear', 'left_hip', 'pelvis' .*a Layout of your own"):
        fit_skeleton(positions, layout)


def test_a_point_that_is_never_seen_with_its_parent_is_refused():
    positions = one_bone(0.3, 10, 0.0, 0)
    positions[:5, 2], positions[5:, 1] = np.nan, np.nan
    with pytest.raises(ValueError, match="'wrist' and its parent 'elbow' are never seen in one frame"):
        fit_skeleton(positions, ARM)


def test_a_limb_that_is_never_seen_with_the_root_is_refused():
    layout = layouts["coco17"]
    positions = moving(layout, n=20)
    names = list(layout.names)
    positions[:10, [names.index("left_wrist")]] = np.nan
    positions[10:, [names.index("left_hip")]] = np.nan
    with pytest.raises(ValueError, match="'left_elbow' to 'left_wrist' is seen in no frame that shows how the root"):
        fit_skeleton(positions, layout)


@pytest.mark.parametrize(("unit", "scale"), [("millimetres", 1e3), ("centimetres", 1e2)])
def test_other_units_are_named(layout, unit, scale):
    factor = 1 / scale
    with pytest.warns(UserWarning, match=f"if positions are in {unit}, pass {factor:g} \\* positions"):
        fit_skeleton(scale * moving(layout), layout)


def test_a_hand_in_metres_has_no_warning():
    fit_skeleton(one_bone(0.05, 50, 0.0, 0) * [1, 0.1, 1], ARM)


def test_keypoints_of_another_layout_are_refused():
    keypoints = layouts["coco17"].keypoints(moving(layouts["coco17"]), 25)
    with pytest.raises(ValueError, match="the keypoints have no point named 'spine', as the layout 'h36m17' has"):
        fit_skeleton(keypoints, layouts["h36m17"])
    with pytest.raises(ValueError, match="no 'pelvis' and no 'neck', which the layout 'coco17' makes"):
        fit_skeleton(keypoints.select(layouts["coco17"].names), layouts["coco17"])


def test_a_name_is_no_layout():
    with pytest.raises(TypeError, match=r"got str: pass skpose.keypoints.layouts\['coco17'\]"):
        fit_skeleton(moving(layouts["coco17"]), "coco17")


def test_skeletons_of_two_people_have_a_mean(layout):
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


@pytest.mark.parametrize("database", ["cmu", "hdm05"])
def test_bones_of_recorded_people(database, request):
    layout, rng = layouts["cmu31"], np.random.default_rng(0)
    motions = {}
    for motion in request.getfixturevalue(database).motions:
        motions.setdefault(motion.skeleton, []).append(motion)
    for skeleton, theirs in motions.items():
        positions = np.concatenate([np.insert(in_space(m), 0, m.root_positions, axis=1) for m in theirs])
        truth = lengths(skeleton)
        assert max(map(abs, errors(fit_skeleton(positions, layout), truth).values())) < 1e-12
        noisy = np.concatenate(
            [positions + 0.01 * rng.normal(size=positions.shape) for _ in range(-(-5000 // len(positions)))]
        )
        found = errors(fit_skeleton(noisy, layout), truth)
        assert np.median(np.abs(list(found.values()))) < 0.003
        assert max(abs(error) for name, error in found.items() if truth[name] > 0.05) < 0.01


def test_it_can_be_drawn(layout):
    skeleton = fit_skeleton(moving(layout, n=20), layout)
    display = PoseDisplay.from_pose(np.zeros(skeleton.n_dofs), skeleton)
    assert len(display.ax_.lines) == 3  # the middle, the left, the right
