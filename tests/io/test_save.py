"""Motions written as BVH, and read again by this library and by another reader."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA, SKELETONS, in_space, random_tree
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton
from skpose.io import load_bvh, save_bvh

MILLIONTH = {"rtol": 0, "atol": 1e-6}


def moved(skeleton, n_frames=5, seed=0, **more):
    """Return a motion of the skeleton in which everything moves."""
    rng = np.random.default_rng(seed)
    angles = rng.uniform(-np.pi, np.pi, (n_frames, skeleton.n_dofs))
    root = {"root_positions": rng.normal(size=(n_frames, 3)), "root_angles": rng.normal(size=(n_frames, 3))}
    return Motion(skeleton, angles, 120, **(root | more))


def again(motion, tmp_path, **options):
    path = tmp_path / f"{len(list(tmp_path.iterdir()))}.bvh"
    save_bvh(path, motion, **options)
    return load_bvh(path, **options)


@pytest.mark.parametrize("scale", [1.0, 0.01])
@pytest.mark.parametrize("axes", ["ZXY", "xyz"])
def test_motions_with_bvh_axes_are_unchanged(axes, scale, tmp_path):
    motion = moved(load_bvh(DATA / "biped.bvh", scale=0.01).skeleton, root_axes=axes)
    back = again(motion, tmp_path, scale=scale)
    for bone, was in zip(back.skeleton.bones, motion.skeleton.bones, strict=True):
        assert (bone.name, bone.parent) == (was.name, was.parent)
        assert bone.dofs.startswith(was.dofs)
        assert len(bone.dofs) == (3 if was.dofs else 0)  # as Blender requires
    angles = back.to_pandas()
    columns = list(motion.skeleton.dof_names)
    np.testing.assert_allclose(np.degrees(angles[columns]), np.degrees(motion.angles), **MILLIONTH)
    assert not angles.drop(columns=columns).to_numpy().any()
    np.testing.assert_allclose(back.skeleton.offsets, motion.skeleton.offsets, **MILLIONTH)
    np.testing.assert_allclose(back.root_positions, motion.root_positions, **MILLIONTH)
    np.testing.assert_allclose(back.frame_rate, 120, rtol=1e-12)
    np.testing.assert_allclose(in_space(back), in_space(motion), **MILLIONTH)


@pytest.mark.parametrize("name", [name for name in SKELETONS if SKELETONS[name].offset_frame == "parent"])
def test_every_skeleton_with_the_parents_frame(name, tmp_path):
    """Joints of the same names at the same positions; tilted axes are written about the root's."""
    motion = moved(SKELETONS[name])
    back = again(motion, tmp_path)
    order = [motion.skeleton.joint_names.index(joint) for joint in back.skeleton.joint_names]
    np.testing.assert_allclose(in_space(back), in_space(motion)[:, order], **MILLIONTH)


@pytest.mark.parametrize("name", [name for name in SKELETONS if SKELETONS[name].offset_frame == "own"])
def test_every_skeleton_with_its_own_frame(name, tmp_path):
    assert_far_ends_are_kept(moved(SKELETONS[name]), tmp_path)


def assert_far_ends_are_kept(motion, tmp_path):
    """Check that the far end of a bone is the position of its children, or of its End Site."""
    back = again(motion, tmp_path)
    expected = dict(zip(motion.skeleton.joint_names, np.moveaxis(in_space(motion), 1, 0), strict=True))
    found = dict(zip(back.skeleton.joint_names, np.moveaxis(in_space(back), 1, 0), strict=True))
    for bone in motion.skeleton.bones:
        children = [child.name for child in motion.skeleton.bones if child.parent == bone.name]
        for name in children or [f"{bone.name}_end"]:
            np.testing.assert_allclose(found.pop(name), expected[bone.name], **MILLIONTH)
        if bone.parent is None:
            np.testing.assert_allclose(found.pop(bone.name), motion.root_positions, **MILLIONTH)
    assert not found


@pytest.mark.parametrize("offset_frame", ["own", "parent"])
def test_ball_joints_have_continuous_angles(offset_frame, tmp_path):
    """Rotation vectors past 2π, through gimbal lock: three angles each, that change as slowly as the rotation."""
    rest = Rotation.from_rotvec([0.3, -1, 0.5]).as_matrix()
    bones = [Bone("a", None, (1, 0.2, 0), "rotvec"), Bone("b", "a", (0.3, 0.4, 0.5), "rotvec", rest)]
    skeleton = Skeleton([*bones, Bone("c", "b", (0, 1, 0), "rotvec")], offset_frame)
    t = np.linspace(0, 1, 2000)[:, None]
    motion = Motion(skeleton, t * [9, 2, -3, -4, 0, 5, 0, 8, 0.1], 100)
    back = again(motion, tmp_path)
    joints = dict(zip(back.skeleton.joint_names, back.skeleton.bones, strict=True))
    assert [joints[name].dofs for name in "abc"] == ["ZYX"] * 3
    turned = Rotation.from_rotvec(motion.angles[1:, :3]) * Rotation.from_rotvec(motion.angles[:-1, :3]).inv()
    assert np.abs(np.diff(back.angles, axis=0)).max() < 1.0 < np.abs(back.angles).max() / np.pi
    assert turned.magnitude().max() < 0.01
    if offset_frame == "own":
        assert_far_ends_are_kept(motion, tmp_path)
    else:
        np.testing.assert_allclose(in_space(back), in_space(motion), **MILLIONTH)


def test_missing_frames_have_no_times_in_bvh(tmp_path):
    motion = Motion(Skeleton.chain(2), np.zeros((3, 2)), 10, frame_numbers=[0, 1, 5])
    with pytest.raises(ValueError, match="frame_numbers"):
        save_bvh(tmp_path / "a.bvh", motion)
    assert len(again(replace(motion, frame_numbers=None), tmp_path)) == 3


def test_names(tmp_path):
    """Names with blanks are kept; the root has another; names that the format cannot hold are refused."""
    bones = [Bone("left  arm", None, (1, 0, 0), "X"), Bone("root", "left  arm", (1, 0, 0), "Y")]
    bones += [
        Bone("root_end", "root", (1, 0, 0)),
        Bone("root_end_2", "root", (2, 0, 0)),
        Bone("tip", "root", (3, 0, 0)),
    ]
    back = again(moved(Skeleton(bones, "parent")), tmp_path)
    assert back.skeleton.joint_names == tuple(bone[0] for bone in bones)
    for name in ("a{", "a\nb", " a"):
        with pytest.raises(ValueError, match="cannot be written: BVH has names of one line"):
            save_bvh(tmp_path / "b.bvh", moved(Skeleton([Bone(name, None, (1, 0, 0), "X")])))
    assert not (tmp_path / "b.bvh").exists()
    with pytest.raises(ValueError, match="scale must be a positive number, got 0"):
        save_bvh(tmp_path / "b.bvh", moved(Skeleton.chain(2)), scale=0)


def test_a_file_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    def full_disk(file, *_, **__):
        file.write("0 0 0")
        raise OSError("no space left on device")

    monkeypatch.setattr(np, "savetxt", full_disk)
    with pytest.raises(OSError, match="no space left"):
        save_bvh(tmp_path / "a.bvh", moved(Skeleton.chain(2)))
    assert list(tmp_path.iterdir()) == []


# Another reader


def pybvh_positions(path):
    """Return joint positions by name, (n_frames, 3) each, from pybvh 0.9, in the file's unit; and the frame time."""
    pybvh = pytest.importorskip("pybvh")
    bvh = pybvh.read_bvh_file(path, world_up="+y")
    positions = bvh.node_positions(centered="world")
    return {node.name: positions[:, i] for i, node in enumerate(bvh.nodes)}, bvh.frame_time


REGULAR = {
    "orders of axes": Skeleton(
        [Bone("a", None, (0, 1, 0), "ZXY"), Bone("b", "a", (0.2, 0.7, 0.1), "XYZ"),
         Bone("c", "b", (0, 0.5, -0.2), "YZX"), Bone("c_end", "c", (0, 0.2, 0)),
         Bone("d", "a", (-0.3, 0.1, 0.4), "ZYX"), Bone("d_end", "d", (0.1, 0, 0))],
        "parent",
    ),
    "Acclaim": SKELETONS["asf"],
    "every kind of joint": random_tree(3),
}  # fmt: skip


@pytest.mark.parametrize("name", REGULAR)
def test_another_reader_finds_the_same_positions(name, tmp_path):
    motion = moved(REGULAR[name], root_axes="ZXY")
    save_bvh(tmp_path / "a.bvh", motion)
    assert_agree(load_bvh(tmp_path / "a.bvh"), tmp_path / "a.bvh")


def assert_agree(motion, path):
    positions, frame_time = pybvh_positions(path)
    np.testing.assert_allclose(motion.frame_rate, 1 / frame_time, rtol=1e-4)
    ours = dict(zip(motion.skeleton.joint_names, np.moveaxis(in_space(motion), 1, 0), strict=True))
    _, *theirs = positions.items()  # the first is the root
    for ours_at, (name, theirs_at) in zip(ours.values(), theirs, strict=True):
        np.testing.assert_allclose(ours_at, theirs_at, rtol=0, atol=1e-9, err_msg=name)
