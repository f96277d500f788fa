"""Retargeting between people: limbs are not twisted, and feet stand, whatever the rest pose and the size."""

import re
from dataclasses import replace

import numpy as np
import pytest
from conftest import in_space
from rigs import motion_of, person_of, random_segments
from robot_of_hinges import walk
from scipy.spatial.transform import Rotation

from skpose import Bone, Skeleton
from skpose.biomechanics import joint_angles
from skpose.datasets import make_gait
from skpose.kinematics import retarget

LIMBS = [
    f"{side}{name}" for side in ("Left", "Right") for name in ("Hip", "Knee", "Ankle", "Shoulder", "Elbow", "Wrist")
]
AXES = {"Hip": "Knee", "Knee": "Ankle", "Ankle": "Toe", "Shoulder": "Elbow", "Elbow": "Wrist", "Wrist": "Wrist_end"}


def angles_of(motion):
    """The rotations (n_frames,) of the joints of a BVH file relative to their parents, by name."""
    first, found = 0, {}
    for bone in motion.skeleton.bones:
        columns = slice(first, first + bone.n_dofs)
        found[bone.name] = Rotation.from_euler(bone.dofs, motion.angles[:, columns]) if bone.dofs else None
        first += bone.n_dofs
    return found


def collapsed(motion):
    """The same motion on a rig whose limbs all point along x at angle zero, however they are twisted about it."""
    skeleton, rng = motion.skeleton, np.random.default_rng(3)
    parents = {bone.name: bone.parent for bone in skeleton.bones}
    offsets = {bone.name: np.array(bone.offset) for bone in skeleton.bones}
    axes = {name: Rotation.identity() for name in (None, *parents)}  # of the rig, in those of the file
    for name in LIMBS:
        side = "Left" if name.startswith("Left") else "Right"
        joint = name.removeprefix(side)
        bone = offsets[side + AXES[joint]]
        twist = Rotation.from_rotvec([rng.uniform(-3, 3), 0, 0])
        axes[name] = Rotation.align_vectors([bone / np.linalg.norm(bone)], [[1.0, 0.0, 0.0]])[0] * twist
    bones, columns = [], []
    for bone, rotations in zip(skeleton.bones, angles_of(motion).values(), strict=True):
        bones.append(Bone(bone.name, bone.parent, axes[bone.parent].inv().apply(bone.offset), bone.dofs and "rotvec"))
        if rotations is not None:
            columns.append((axes[bone.parent].inv() * rotations * axes[bone.name]).as_rotvec())
    return replace(motion, skeleton=Skeleton(bones, "parent"), angles=np.concatenate(columns, axis=1), seen=None)


@pytest.fixture(scope="module")
def files():
    motion = motion_of("Xsens as BVH", random_segments(20))[0]
    return motion, collapsed(motion)


def test_limbs_are_not_twisted_from_a_rig_that_does_not_stand_at_angle_zero(files):
    """Knees and elbows bend about the same axes as in the motion that both files have."""
    motion, other = files
    np.testing.assert_allclose(in_space(other), in_space(motion), atol=1e-9)
    found, expected = (angles_of(each) for each in (retarget(other, motion.skeleton, method="orientations"), motion))
    for name in LIMBS:
        apart = np.degrees((found[name] * expected[name].inv()).magnitude().max())
        assert apart < (5.0 if name.endswith(("Ankle", "Wrist")) else 1e-4), name  # feet and hands: their mean


def test_limbs_are_not_twisted_onto_such_a_rig_if_a_motion_shows_how_they_bend(files):
    motion, other = files
    with pytest.warns(UserWarning, match="twists are arbitrary"):
        retarget(motion, other.skeleton, method="orientations")
    found = retarget(motion, other, method="orientations")
    np.testing.assert_allclose(in_space(found), in_space(motion), atol=1e-9)
    limbs = [name.split("_")[0].endswith(("Knee", "Elbow")) for name in other.skeleton.dof_names]
    np.testing.assert_allclose(found.angles[:, limbs], other.angles[:, limbs], atol=1e-6)


def smaller(skeleton, legs):
    """The skeleton with legs of other lengths, shanks most of all, and feet of another slope."""
    bones, factors = [], {"thigh": 1.05 * legs, "shank": 0.95 * legs}
    for bone in skeleton.bones:
        factor = factors.get(bone.name.rpartition("_")[2], 1.0)
        slope = Rotation.from_euler("x", 12.0 * bone.name.endswith("foot"), degrees=True)
        bones.append(bone._replace(offset=slope.apply(factor * np.array(bone.offset))))
    return Skeleton(bones, skeleton.offset_frame)


def uphill(motion, degrees):
    """The motion on a floor that slopes, as that of a recording whose axes are not level."""
    turn = Rotation.from_euler("x", -degrees, degrees=True)
    root = turn * Rotation.from_euler(motion.root_axes, motion.root_angles)
    return replace(
        motion,
        root_positions=turn.apply(motion.root_positions),
        root_angles=root.as_euler("XYZ"),
        root_axes="XYZ",
    )


@pytest.mark.parametrize(("method", "slope"), [("orientations", 0.0), ("orientations", 5.0), ("numbers", 0.0)])
def test_feet_stand_on_the_floor_in_another_size(method, slope):
    motion = uphill(walk()[0], slope)
    small, up = smaller(motion.skeleton, 0.8), "xyz".index(motion.up)
    found = retarget(motion, small, method=method)
    toes = [
        motion.skeleton.joint_names.index(f"{side}_{part}") for side in ("left", "right") for part in ("foot", "toes")
    ]
    heights = [in_space(each)[:, toes, up].min(axis=1) for each in (motion, found)]
    assert np.median(heights[1]) == pytest.approx(0.8 * np.median(heights[0]), abs=0.02)
    scaled = retarget(motion, small, method=method, scale=0.8)  # the control
    before, after, control = (
        np.linalg.norm(np.diff(in_space(each)[:, toes[::2]], axis=0), axis=2) for each in (motion, found, scaled)
    )
    stands = before * motion.frame_rate < 0.1
    assert stands.sum() > 10
    slides, more = ((after - before)[stands].mean() * motion.frame_rate for after in (after, control))
    assert slides < {"orientations": 0.005, "numbers": more}[method]  # numbers keep the angles: the root alone moves
    assert more > 0.015
    kept = retarget(motion, small, method=method, scale=1.0)
    np.testing.assert_array_equal(kept.root_positions, motion.root_positions)


def test_the_report_states_how_far_directions_are_off(capsys):
    """Legs move so that feet stand."""
    motion = walk()[0]
    found = retarget(motion, smaller(motion.skeleton, 0.8), method="orientations", verbose=1)
    degrees = float(re.search(r"directions within ([\d.]+)°", capsys.readouterr().out)[1])
    apart = []
    for side in ("left", "right"):
        joints = [motion.skeleton.joint_names.index(f"{side}_{part}") for part in ("pelvis", "thigh", "shank")]
        a, b = (np.diff(in_space(each)[:, joints], axis=1) for each in (motion, found))
        a, b = (bone / np.linalg.norm(bone, axis=2, keepdims=True) for bone in (a, b))
        apart.append(np.degrees(2.0 * np.arcsin(np.linalg.norm(a - b, axis=2) / 2.0)).max())
    assert degrees == pytest.approx(max(apart), abs=0.006)
    assert 0.1 < degrees < 5.0


def test_joint_angles_of_a_copy_on_another_rig_agree():
    """The rest poses differ: T-pose and hanging arms, and feet of another slope."""
    motion = make_gait(1, 1, random_state=0).motions[0][:40]
    angles = joint_angles(motion)
    copy = joint_angles(retarget(motion, smaller(motion.skeleton, 0.9), method="orientations"))
    for name in angles.names:
        if "flexion" in name and "wrist" not in name:
            np.testing.assert_allclose(copy[name], angles[name], atol=2.0)


def test_a_joint_that_is_left_out_changes_neither_size_nor_floor():
    motion = walk()[0]
    small = smaller(motion.skeleton, 0.8)
    expected = retarget(motion, small, method="orientations").root_positions
    for joint in ("left_foot", "left_toes", "right_shank"):
        found = retarget(motion, small, method="orientations", joints={joint: None})
        assert np.abs(found.root_positions - expected).max() < 0.05


@pytest.mark.parametrize("joints", [{"LeftLeg": "RightKnee"}, {"LeftUpLeg": "LeftToe"}])
def test_joints_that_do_not_follow_each_other_are_refused(files, joints):
    with pytest.raises(ValueError, match="does not come after"):
        retarget(files[0], person_of("LAFAN1")[0], method="orientations", joints=joints)


def test_rigs_whose_bones_all_point_along_one_axis_are_no_crash(files):
    """Hips and shoulders of both sides are at one place at angle zero, which shows no left and right."""
    with pytest.warns(UserWarning, match="twists"):
        found = retarget(files[0], person_of("SOMA", collapsed=True)[0], method="orientations")
    assert np.isfinite(found.angles).all()


@pytest.mark.parametrize("turn", [90.0, 180.0])
def test_the_motion_counts_where_the_rest_pose_shows_other_axes(files, turn):
    """The arms of the rest pose are rotated about themselves, as with palms that face forward or up."""
    motion, _ = files
    bones, columns = [], []
    axes = {name: Rotation.identity() for name in (None, *motion.skeleton.joint_names)}
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        rotation = Rotation.from_rotvec([sign * np.radians(turn), 0, 0])
        axes |= {f"{side}{name}": rotation for name in ("Shoulder", "Elbow", "Wrist")}
    for bone, rotations in zip(motion.skeleton.bones, angles_of(motion).values(), strict=True):
        bones.append(bone._replace(offset=axes[bone.parent].inv().apply(bone.offset), dofs=bone.dofs and "rotvec"))
        if rotations is not None:
            columns.append((axes[bone.parent].inv() * rotations * axes[bone.name]).as_rotvec())
    other = replace(motion, skeleton=Skeleton(bones, "parent"), angles=np.concatenate(columns, axis=1), seen=None)
    np.testing.assert_allclose(in_space(other), in_space(motion), atol=1e-9)
    found, expected = (angles_of(each) for each in (retarget(other, motion.skeleton, method="orientations"), motion))
    for name in LIMBS:
        apart = np.degrees((found[name] * expected[name].inv()).magnitude().max())
        assert apart < (5.0 if name.endswith("Wrist") else 1e-4), name  # hands: their mean
