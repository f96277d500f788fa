"""Skeletons fitted to positions."""

import numpy as np
import pytest
import reference
from people import PEOPLE, errors, moving, standing, true_lengths
from scipy.spatial.transform import Rotation

from skpose import Bone, forward_kinematics
from skpose.keypoints import fit_skeleton, layouts


@pytest.fixture(params=["coco17", "smpl24", "opencap43"])
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


def test_the_skeleton_reaches_the_positions_far_from_half_turns():
    layout = layouts["coco17"]
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


def test_a_fifth_of_the_points_may_be_missing(layout):
    positions = moving(layout, n=400)
    whole = fit_skeleton(positions, layout)
    positions[np.random.default_rng(0).uniform(size=positions.shape[:2]) < 0.2] = np.nan
    skeleton = fit_skeleton(positions, layout)
    assert max(map(abs, errors(skeleton, true_lengths(layout)).values())) < 1e-12
    np.testing.assert_allclose(whole.rest_rotations, skeleton.rest_rotations, atol=1e-12)
    np.testing.assert_allclose(whole.offsets, skeleton.offsets, atol=0.02)  # rigid points by their mean directions
