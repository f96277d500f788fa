"""Mirror images, slices and concatenation of motions."""

from dataclasses import replace

import numpy as np
import pytest
import reference
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton
from skpose.datasets import humanoid

REFLECTION = np.diag([-1.0, 1.0, 1.0])


def exchanged(names):
    """The index of each joint of the other side, by the words that the test's names are made of."""
    swap = {"left_": "right_", "right_": "left_"}
    other = [next((swap[s] + n.removeprefix(s) for s in swap if n.startswith(s)), n) for n in names]
    return [names.index(n) for n in other]


def world(motion):
    """Positions of all joints with the root's movement, from scipy's rotations."""
    axes = motion.root_axes
    root = Rotation.from_euler(axes, motion.root_angles) if axes else Rotation.identity(len(motion))
    positions = reference.forward_kinematics(motion.angles, motion.skeleton)
    turned = np.einsum("nab,njb->nja", root.as_matrix(), positions)
    return motion.root_positions[:, None] + turned


def moving(skeleton, root_axes="ZXY", n_frames=20, seed=0):
    rng = np.random.default_rng(seed)
    shapes = skeleton.n_dofs, len(root_axes)
    angles, root_angles = (rng.uniform(-1.5, 1.5, (n_frames, k)).cumsum(axis=0) for k in shapes)
    return Motion(skeleton, angles, 30, rng.normal(size=(n_frames, 3)), root_angles, root_axes)


def symmetric(dofs, right_dofs=None, offset_frame="own", rests=True):
    """A skeleton that is its own mirror image across x, with rest rotations or without."""
    rng = np.random.default_rng(0)
    rest = Rotation.from_rotvec(rng.normal(size=3)).as_matrix() if rests else np.eye(3)
    spine = Rotation.from_euler("x", 0.3 if rests else 0.0).as_matrix()
    bones = [Bone("spine", None, (0, 1, 0.2), "xyz", spine)]
    bones.append(Bone("left_arm", "spine", (0.5, 0.3, 0.1), dofs, rest))
    bones.append(Bone("right_arm", "spine", (-0.5, 0.3, 0.1), right_dofs or dofs, REFLECTION @ rest @ REFLECTION))
    for side, x in (("left_", 1), ("right_", -1)):
        bones.append(Bone(f"{side}hand", f"{side}arm", (0.2 * x, 0.1, 0.05), "zy"))
        bones.append(Bone(f"{side}leg", None, (0.2 * x, -0.9, 0.05), "rotvec"))
    return Skeleton(bones, offset_frame)


def with_other_axes(dofs):
    """The symmetric skeleton with the axes of one arm turned at angle zero, so that they are no mirror image."""
    turned = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()
    bones = {bone.name: bone for bone in symmetric(dofs).bones}
    arm, hand = bones["right_arm"], bones["right_hand"]
    bones["right_arm"] = arm._replace(offset=turned.T @ arm.offset, rest_rotation=arm.rest_rotation @ turned)
    bones["right_hand"] = hand._replace(rest_rotation=turned.T)
    return Skeleton(bones.values())


SYMMETRIC = {
    "other axes on the right": with_other_axes("ZXY"),
    "humanoid": humanoid(),
    "rest rotations": symmetric("ZXY"),
    "rest rotations, offsets in the parent's axes": symmetric("YXZ", offset_frame="parent"),
    "a ball joint on the right": symmetric("xyz", "rotvec"),
}


@pytest.mark.parametrize("root_axes", ["ZXY", "zy", ""])
@pytest.mark.parametrize("skeleton", SYMMETRIC.values(), ids=SYMMETRIC)
def test_mirrored_positions_are_mirror_images_of_the_other_side(skeleton, root_axes):
    motion = moving(skeleton, root_axes)
    mirrored = motion.mirrored()
    other = exchanged(skeleton.joint_names)
    np.testing.assert_allclose(world(mirrored), world(motion)[:, other] * [-1, 1, 1], rtol=0, atol=1e-12)
    np.testing.assert_allclose(world(mirrored.mirrored()), world(motion), rtol=0, atol=1e-12)
    assert mirrored.skeleton is skeleton
    assert (mirrored.frame_rate, mirrored.root_axes) == (30, root_axes)
    np.testing.assert_array_equal(mirrored.mirrored().root_angles, motion.root_angles)
    same = all(skeleton.bones[i].dofs == bone.dofs for i, bone in zip(other, skeleton.bones, strict=True))
    if same and skeleton != SYMMETRIC["other axes on the right"]:  # its triples are computed anew
        np.testing.assert_allclose(mirrored.mirrored().angles, motion.angles, rtol=0, atol=1e-12)


def test_rest_rotations_of_six_digits_are_mirrored_exactly():
    exact = symmetric("ZXY")
    rests = np.round(exact.rest_rotations, 6)
    bones = [bone._replace(rest_rotation=rest) for bone, rest in zip(exact.bones, rests, strict=True)]
    motion = moving(Skeleton(bones))
    np.testing.assert_allclose(motion.mirrored().mirrored().angles, motion.angles, rtol=0, atol=1e-12)


def named(left, right, **more):
    """A pair of arms of these names."""
    return Skeleton([Bone(left, None, (1, 0, 0), "xyz"), Bone(right, None, (-1, 0, 0), "xyz"), *more.values()])


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("LeftArm", "RightArm"),
        ("mixamorig:LeftArm", "mixamorig:RightArm"),
        ("lfemur", "rfemur"),
        ("L_Hip", "R_Hip"),
        ("hip.L", "hip.R"),
        ("Bip01 L Thigh", "Bip01 R Thigh"),
    ],
)
def test_pairs_by_name(left, right):
    spine = Bone("lowerback", None, (0, 1, 0), "xyz")  # begins with l and has no side
    neck = Bone("L5", "lowerback", (0, 1, 0), "xyz")  # a vertebra
    motion = moving(named(left, right, spine=spine, neck=neck))
    mirrored = motion.mirrored().angles
    signs = np.array([1, -1, -1])
    np.testing.assert_array_equal(mirrored[:, :3], motion.angles[:, 3:6] * signs)
    np.testing.assert_array_equal(mirrored[:, 3:6], motion.angles[:, :3] * signs)
    np.testing.assert_array_equal(mirrored[:, 6:], motion.angles[:, 6:] * [*signs, *signs])


TOWARDS = (0, 1, 0)


@pytest.mark.parametrize(
    ("skeleton", "message"),
    [
        (named("LeftArm", "Arm"), "'LeftArm' is alone"),
        (
            named("l_left", "r_left", a=Bone("l_right", None, (1, 0, 0), "x"), b=Bone("r_right", None, (1, 0, 0), "x")),
            "'l_left' has several",
        ),
        (
            named("L_arm", "R_arm", a=Bone("L_hand", "L_arm", TOWARDS, "x"), b=Bone("R_hand", None, TOWARDS, "x")),
            "'L_hand' and 'R_hand' differ in parents",
        ),
    ],
)
def test_asymmetric_skeletons_are_refused(skeleton, message):
    with pytest.raises(ValueError, match=message):
        moving(skeleton).mirrored()


def all_along_x(seed=0, flip=(-1.0, -1.0, 1.0)):
    """A person of bones along x at angle zero, as in files of which a rotation of each joint makes the pose.

    The signs are those of the axes of the right relative to those of the left, in a person who stands with arms out.
    """
    left, flip = flip[0], np.diag(flip)
    bones = [Bone("Spine", None, (0.16, 0, 0), "ZXY"), Bone("Head", "Spine", (0.3, 0, 0), "ZXY")]
    poses = {"Spine": np.eye(3), "Head": np.eye(3)}
    for side, sign in (("_L", 1), ("_R", left)):
        x = 1 if side == "_L" else -1
        bones.append(Bone(f"Shoulder{side}", "Spine", (0.25, 0, 0.05 * x), "ZXY"))
        bones.append(Bone(f"Arm{side}", f"Shoulder{side}", (0.3 * sign, 0, 0), "ZXY"))
        bones.append(Bone(f"Leg{side}", None, (-0.02, 0, 0.1 * x), "ZXY"))
        bones.append(Bone(f"Foot{side}", f"Leg{side}", (0.4 * sign, 0, 0), "rotvec"))
        outward = np.array([[0, 0, 0], [0, 1, 0], [x, 0, 0]], dtype=float)  # the arm to the side: x to ±z
        outward[:, 2] = np.cross(outward[:, 0], outward[:, 1])
        down = np.diag([-1.0, -1.0, 1.0])
        turned = flip if side == "_R" else np.eye(3)
        poses |= {f"Shoulder{side}": outward @ turned, f"Arm{side}": np.eye(3), f"Leg{side}": down @ turned}
        poses |= {f"Foot{side}": np.eye(3)}
    skeleton = Skeleton(bones, "parent")
    rng = np.random.default_rng(seed)
    upright = Rotation.from_euler("z", 90, degrees=True)  # the spine, along x, points up
    roots = upright * Rotation.from_rotvec(0.2 * rng.normal(size=(30, 3)))
    columns = []
    for bone in skeleton.bones:
        turns = Rotation.from_matrix(poses[bone.name]) * Rotation.from_rotvec(0.3 * rng.normal(size=(30, 3)))
        columns.append(turns.as_rotvec() if bone.is_ball else turns.as_euler(bone.dofs))
    return Motion(skeleton, np.concatenate(columns, axis=1), 30, rng.normal(size=(30, 3)), roots.as_euler("ZXY"), "ZXY")


def partners_of(names):
    swap = {"_L": "_R", "_R": "_L"}
    return [names.index(name[:-2] + swap[name[-2:]] if name[-2:] in swap else name) for name in names]


OPPOSITE_BONES = [(-1.0, -1.0, 1.0), (-1.0, 1.0, -1.0)]


@pytest.mark.parametrize("flip", OPPOSITE_BONES)
@pytest.mark.parametrize("up", ["y", "x"])
def test_asymmetric_rest_poses_are_mirrored_by_bones(up, flip):
    motion = replace(all_along_x(flip=flip), up=up)
    other = partners_of(motion.skeleton.joint_names)
    across = [-1, 1, 1] if up != "x" else [1, -1, 1]
    image = motion.mirrored()
    np.testing.assert_allclose(world(image), world(motion)[:, other] * across, atol=1e-12)
    np.testing.assert_allclose(world(image.mirrored()), world(motion), atol=1e-12)
    assert image.skeleton is motion.skeleton
    steps = np.abs(np.diff(image.root_angles, axis=0)).max()
    assert steps < 3.0  # no jumps


def test_slices_are_motions():
    motion = moving(humanoid(), n_frames=60)
    for chosen, rate in [
        (slice(10, 50), 30),
        (slice(None, None, 2), 15),
        (slice(None, None, -3), 10),
        (slice(70, 80), 30),
    ]:
        part = motion[chosen]
        for name in ("angles", "root_positions", "root_angles"):
            np.testing.assert_array_equal(getattr(part, name), getattr(motion, name)[chosen])
        assert (part.skeleton, part.frame_rate, part.root_axes) == (motion.skeleton, rate, "ZXY")


def test_one_frame_is_a_motion():
    motion = moving(humanoid(), n_frames=6)
    for frame in (3, -3, np.int64(3)):
        assert len(motion[frame]) == 1
        np.testing.assert_array_equal(motion[frame].angles, motion.angles[[frame]])
        assert motion[frame].frame_rate == 30
    assert [len(frame) for frame in motion] == [1] * 6
    for frame in (6, -7):
        with pytest.raises(IndexError):
            motion[frame]


def test_concatenate():
    motion = moving(humanoid(), n_frames=20)
    again = Motion.concatenate([motion[:5], motion[5:5], motion[5:]])
    for name in ("angles", "root_positions", "root_angles"):
        np.testing.assert_array_equal(getattr(again, name), getattr(motion, name))
    assert (again.skeleton, again.frame_rate, again.root_axes) == (motion.skeleton, 30, "ZXY")


@pytest.mark.parametrize(
    ("motions", "message"),
    [
        ([], "at least one motion"),
        ([moving(humanoid()), moving(humanoid())[::2]], r"motions\[1\] has frame_rate"),
        ([moving(humanoid()), moving(humanoid(), "xyz")], r"motions\[1\] has root_axes"),
        ([moving(humanoid()), moving(humanoid(1.8))], r"motions\[1\] has another skeleton"),
    ],
)
def test_concatenate_refuses_different_motions(motions, message):
    with pytest.raises(ValueError, match=message):
        Motion.concatenate(motions)
