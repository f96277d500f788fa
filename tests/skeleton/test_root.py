"""The orientation of the root as a part of the poses."""

from dataclasses import replace

import numpy as np
import pytest
import reference
from conftest import MIXED, random_tree
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton, forward_kinematics, pose_distances
from skpose.datasets import MotionDataset
from skpose.geodesics import interpolate
from skpose.kinematics import retarget
from skpose.motions import mean_motion, segment_repetitions

UP = {"x": [1.0, 0, 0], "y": [0, 1.0, 0], "z": [0, 0, 1.0]}
TREES = {frame: random_tree(4, kinds=MIXED, offset_frame=frame) for frame in ("own", "parent")}


def random_motion(skeleton, seed=0, n=20, axes="ZXY"):
    rng = np.random.default_rng(seed)
    angles, root = rng.uniform(-3, 3, (n, skeleton.n_dofs)), rng.uniform(-3, 3, (n, len(axes)))
    return Motion(skeleton, angles, 30, rng.normal(size=(n, 3)), root, axes)


def orientations(motion):
    if not motion.root_axes:
        return Rotation.identity(len(motion))
    return Rotation.from_euler(motion.root_axes, motion.root_angles)


@pytest.mark.parametrize("frame", TREES)
@pytest.mark.parametrize("part", ["whole", "tilt"])
@pytest.mark.parametrize("up", UP)
def test_all_positions_are_rotated_by_the_joint_at_the_root(frame, part, up):
    motion = random_motion(TREES[frame])
    rooted = motion.with_root(part, up=up)
    assert rooted.skeleton.joint_names == ("root", *motion.skeleton.joint_names)
    np.testing.assert_array_equal(rooted.angles[:, 3:], motion.angles)
    R = Rotation.from_rotvec(rooted.angles[:, :3])
    before, after = (forward_kinematics(m.angles, m.skeleton) for m in (motion, rooted))
    np.testing.assert_array_equal(after[:, 0], 0.0)
    np.testing.assert_allclose(after[:, 1:], np.einsum("nab,njb->nja", R.as_matrix(), before), atol=1e-12)
    # Nothing is left out: the heading that the motion keeps, times the joint, is the orientation before.
    whole = orientations(rooted) * R
    np.testing.assert_allclose(whole.as_matrix(), orientations(motion).as_matrix(), atol=1e-12)
    np.testing.assert_array_equal(rooted.root_positions, motion.root_positions)
    if part == "whole":
        np.testing.assert_array_equal(rooted.root_angles, 0.0)


@pytest.mark.parametrize("up", UP)
@pytest.mark.parametrize("seed", range(5))
def test_the_tilt_does_not_depend_on_the_heading_in_the_world(up, seed):
    motion = random_motion(TREES["own"], seed)
    heading = np.random.default_rng(seed).uniform(-9, 9, len(motion))
    moved = Rotation.from_rotvec(heading[:, None] * UP[up]) * orientations(motion)
    other = Motion(motion.skeleton, motion.angles, 30, root_angles=moved.as_euler("xyz"))
    a, b = (m.with_root("tilt", up=up) for m in (motion, other))
    np.testing.assert_allclose(a.angles, b.angles, atol=1e-9)
    np.testing.assert_allclose(a.angles[:, "xyz".index(up)], 0.0, atol=1e-12)  # about a horizontal axis
    assert np.linalg.norm(a.angles[:, :3], axis=1).max() <= np.pi
    assert (a.root_axes, a.up) == (up, up)
    gap = np.exp(1j * (b.root_angles[:, 0] - a.root_angles[:, 0] - heading))
    np.testing.assert_allclose(gap, 1.0, atol=1e-9)
    # The tilt shows which direction of the skeleton points up: nothing else.
    for m in (a, b):
        vertical = Rotation.from_rotvec(m.angles[:, :3]).inv().apply(UP[up])
        np.testing.assert_allclose(vertical, orientations(motion).inv().apply(UP[up]), atol=1e-9)
    c, d = (m.with_root("whole", up=up) for m in (motion, other))
    assert np.abs(c.angles - d.angles).max() > 0.1


def test_lying_is_not_standing():
    stick = Skeleton([Bone("head", None, (0, 0.8, 0), "xyz")])
    degrees = [[0, 0, 0], [0, 70, 0], [90, 0, 0], [90, 0, 50]]  # standing, headed elsewhere, lying, lying on the side
    motion = Motion(stick, np.zeros((4, 3)), 30, root_angles=np.radians(degrees))
    rooted = motion.with_root()
    for metric in ("position", "spatial", "geodesic"):
        D = pose_distances(rooted.angles, skeleton=rooted.skeleton, metric=metric)
        np.testing.assert_allclose(D[0, 1], 0.0, atol=1e-7)
        assert D[0, 2] > 0.8 * np.sqrt(2) - 1e-9
    assert pose_distances(motion.angles, skeleton=stick, metric="spatial")[0, 2] == 0.0


@pytest.mark.parametrize("metric", ["position", "rotation", "spatial"])
@pytest.mark.parametrize("frame", TREES)
def test_distances_agree_with_the_reference(metric, frame):
    rooted = random_motion(TREES[frame], n=4).with_root("whole")
    D = pose_distances(rooted.angles, skeleton=rooted.skeleton, metric=metric)
    expected = reference.distance(rooted.angles[0], rooted.angles[3], rooted.skeleton, metric, wrap=True)
    np.testing.assert_allclose(D[0, 3], expected, rtol=1e-9)


@pytest.mark.parametrize("axes", ["", "y", "zx", "XYZ"])
def test_a_root_with_any_axes(axes):
    motion = random_motion(TREES["own"], axes=axes)
    rooted = motion.with_root("tilt")
    if axes in ("", "y"):
        np.testing.assert_allclose(rooted.angles[:, :3], 0.0, atol=1e-12)
    assert len(motion.with_root("whole").resample(10)) == 7
    assert len(Motion(motion.skeleton, np.zeros((0, motion.skeleton.n_dofs)), 30, root_axes=axes).with_root()) == 0


def test_up_is_kept_and_checked():
    motion = Motion(Skeleton.chain(2), np.zeros((3, 2)), 30, up="z")
    assert motion.resample(10).up == retarget(motion, Skeleton.chain(2)).up == motion.unwrap().up == "z"
    assert motion.with_root().root_axes == "z"
    assert motion.with_root(up="x").up == "x"
    for up in ("w", "", 2, None):
        with pytest.raises(ValueError, match='up must be "x", "y" or "z", the axis of the world'):
            Motion(Skeleton.chain(2), np.zeros((3, 2)), 30, up=up)
    with pytest.raises(ValueError, match=r'up must be "x", "y" or "z", the axis of the world .* got .up.'):
        motion.with_root(up="up")
    with pytest.raises(ValueError, match='part must be "tilt" or "whole", got \'heading\''):
        motion.with_root("heading")


def test_names_that_are_taken():
    skeleton = Skeleton([Bone("root", None, (1, 0, 0), "z"), Bone("root_", "root", (1, 0, 0), "z")])
    rooted = random_motion(skeleton).with_root()
    assert rooted.skeleton.joint_names == ("root__", "root", "root_")


def test_collections():
    motions = [random_motion(TREES["own"], seed) for seed in range(3)]
    dataset = MotionDataset(motions, *[["a", "b", "c"]] * 3)
    X, _ = dataset.with_root("whole").poses()
    assert X.shape == (60, motions[0].skeleton.n_dofs + 3)
    assert dataset.with_root("whole").skeleton.n_dofs == X.shape[1]
    mixed = MotionDataset([motions[0], Motion(TREES["own"], motions[1].angles, 30, up="z")], *[["a", "b"]] * 3)
    with pytest.raises(ValueError, match=r'motions\[0\] has "y" up and motions\[1\] "z"'):
        mixed.with_root("tilt")
    assert mixed.with_root("tilt", up="z").motions[0].root_axes == "z"


@pytest.mark.parametrize("frame", TREES)
def test_retargeting_and_the_root_commute(frame):
    """Rest poses that differ by a rotation of the whole: positions in the world are the same in either order."""
    one = TREES[frame]
    W = Rotation.from_euler("x", 90, degrees=True)
    root = [b.parent is None for b in one.bones]
    rests = [(W * Rotation.from_matrix(r.copy())).as_matrix() for r in one.rest_rotations]
    bones = [
        b._replace(
            rest_rotation=rest if top else b.rest_rotation,
            offset=W.apply(b.offset) if top and frame == "parent" else b.offset,
        )
        for b, rest, top in zip(one.bones, rests, root, strict=True)
    ]
    other = Skeleton([b._replace(dofs="ZXY") if len(b.dofs) in (1, 2) else b for b in bones], frame)
    one = Skeleton([b._replace(dofs="ZXY") if len(b.dofs) in (1, 2) else b for b in one.bones], frame)
    motion = random_motion(one)
    there = retarget(motion, other, method="orientations").with_root("whole")
    rooted = Motion(other, np.zeros((1, other.n_dofs)), 30).with_root().skeleton
    first = retarget(motion.with_root("whole"), rooted, method="orientations")
    expected = forward_kinematics(motion.with_root("whole").angles, motion.with_root("whole").skeleton)
    for result in (there, first):
        np.testing.assert_allclose(forward_kinematics(result.angles, result.skeleton), expected, atol=1e-9)


@pytest.mark.parametrize("frame", TREES)
@pytest.mark.parametrize("part", ["whole", "tilt"])
@pytest.mark.parametrize("up", UP)
@pytest.mark.parametrize("axes", ["ZXY", "xyz", "y", "zx", ""])
def test_without_root_is_the_inverse(frame, part, up, axes):
    motion = random_motion(TREES[frame], axes=axes)
    motion = replace(motion, up=up, root_name="Hips", frame_numbers=np.arange(len(motion)) * 2 + 5)
    there = motion.with_root(part).without_root()
    assert there.skeleton == motion.skeleton
    np.testing.assert_array_equal(there.angles, motion.angles)
    np.testing.assert_array_equal(there.root_positions, motion.root_positions)
    np.testing.assert_array_equal(there.frame_numbers, motion.frame_numbers)
    assert (there.up, there.root_name, there.frame_rate) == (up, "Hips", motion.frame_rate)
    np.testing.assert_allclose((orientations(there).inv() * orientations(motion)).magnitude(), 0.0, atol=1e-12)
    if len(axes) == 3 and part == "whole":
        assert there.root_axes == axes
    # And of poses that with_root did not make: the joint at the root may have become something else.
    rooted = motion.with_root(part).to_euler("ZXY")
    np.testing.assert_allclose(
        (orientations(rooted.without_root()).inv() * orientations(motion)).magnitude(), 0.0, atol=1e-9
    )


def test_without_root_gives_numbers_that_do_not_jump():
    turning = np.linspace(0, 9, 200)[:, None] * [0.0, 1.0, 0.0] + [0.2, 0.0, 0.1]
    motion = Motion(Skeleton.chain(2), np.zeros((200, 2)), 30, root_angles=turning, root_axes="YXZ")
    there = motion.with_root("whole").without_root()
    assert np.abs(np.diff(there.root_angles, axis=0)).max() < 0.1
    empty = Motion(motion.skeleton, np.zeros((0, 2)), 30).with_root().without_root()
    assert (len(empty), empty.skeleton) == (0, motion.skeleton)


def test_without_root_needs_a_joint_at_the_root():
    motion = random_motion(Skeleton.chain(2))
    with pytest.raises(
        ValueError, match=r"without_root needs a motion of with_root.*at the root of this one are joint_1"
    ):
        motion.without_root()
    assert motion.with_root().with_root().without_root().without_root().skeleton == motion.skeleton
    two = Skeleton([Bone("a", None, (0, 0, 0), "xyz"), Bone("b", None, (1, 0, 0), "xyz")])
    with pytest.raises(ValueError, match="are a, b"):
        random_motion(two).without_root()
    dataset = MotionDataset([motion.with_root(), motion], subjects=["a", "b"])
    with pytest.raises(ValueError, match=r"motions\[1\]: without_root needs"):
        dataset.without_root()
    both = MotionDataset([motion, motion], subjects=["a", "b"])
    assert both.with_root("whole").without_root().skeleton == both.skeleton
    assert both.with_root().without_root().subjects.tolist() == ["a", "b"]


TREE = random_tree(4, kinds=["xyz", "ZXY", "rotvec"])
KEPT = {
    "resample": lambda m: m.resample(10),
    "slice": lambda m: m[3:17:2],
    "frame": lambda m: m[4],
    "unwrap": lambda m: m.unwrap(),
    "to_rotvec": lambda m: m.to_rotvec(),
    "to_euler": lambda m: m.to_euler("ZXY"),
    "select": lambda m: m.select(m.skeleton.joint_names[0]),
    "with_root": lambda m: m.with_root("tilt"),
    "concatenate": lambda m: Motion.concatenate([m, m]),
    "numbers": lambda m: retarget(m, m.skeleton),
    "positions": lambda m: retarget(m, m.skeleton, method="positions"),
    "orientations": lambda m: retarget(m, m.to_rotvec().skeleton, method="orientations"),
    "cycle": lambda m: Motion.concatenate([m, m[-2::-1]]).to_cycle(endpoint=True).repeat(2),
    "dataset": lambda m: MotionDataset([m]).to_rotvec().motions[0],
    "interpolate": lambda m: interpolate(m[::5], frame_rate=30, method="geodesic"),
    "mean": lambda m: mean_motion([m, m[:-1]]).to_motion(),
    "segments": lambda m: segment_repetitions(Motion.concatenate([m] * 5), metric="position").motions[0],
}


@pytest.mark.parametrize("what", KEPT)
def test_what_returns_motions_keeps_the_root(what):
    motion = replace(random_motion(TREE), up="z", root_name="Hips", frame_numbers=np.arange(20) + 3)
    smooth = replace(motion, angles=0.5 * np.sin(np.arange(20)[:, None] / 3 + np.arange(TREE.n_dofs)))
    there = KEPT[what](smooth)
    assert (there.up, there.root_name) == ("z", "Hips")
    assert np.ptp(there.root_positions, axis=0).max() > 0.1 or len(there) == 1
    assert there.root_angles.any()
    assert len(there.frame_numbers) == len(there)


@pytest.mark.parametrize("frame", TREES)
def test_a_joint_at_the_root_may_have_a_rest_rotation(frame):
    """All other joints stay where they are in the world."""
    rooted = random_motion(TREES[frame]).with_root("tilt")
    rest = Rotation.from_euler("xyz", [0.4, -1.0, 2.0]).as_matrix()
    bones = [b._replace(rest_rotation=rest) if b.name == "root" else b for b in rooted.skeleton.bones]
    motion = replace(rooted, skeleton=Skeleton(bones, frame))
    there = motion.without_root()
    before, after = (
        np.einsum("nab,njb->nja", orientations(m).as_matrix(), reference.forward_kinematics(m.angles, m.skeleton))
        for m in (motion, there)
    )
    np.testing.assert_allclose(after, before[:, 1:], atol=1e-12)


@pytest.mark.parametrize("turned", ["z up", "head down", "along x"])
def test_tilt_is_the_same_however_the_skeleton_stands_at_angle_zero(turned):
    """Leans to the side by 10 and 40°, of people headed anywhere, are as far apart as those of one that stands."""
    # The skeleton at angle zero relative to one that stands along y, and the axis of the world that points up.
    rest, up = {
        "z up": (Rotation.identity(), "z"),
        "head down": (Rotation.from_euler("x", 180, degrees=True), "y"),
        "along x": (Rotation.from_euler("z", -90, degrees=True), "y"),
    }[turned]
    offsets = {
        "spine": [0, 0.5, 0],
        "head": [0, 0.3, 0.02],
        "left_foot": [0.1, -0.9, 0.1],
        "right_foot": [-0.1, -0.9, 0.1],
    }
    world = Rotation.from_euler("x", 90, degrees=True) if up == "z" else Rotation.identity()

    def motion(rest, up, world):
        bones = [
            Bone(name, "spine" if name == "head" else None, rest.apply(offset), "rotvec")
            for name, offset in offsets.items()
        ]
        skeleton = Skeleton(bones)
        headings = Rotation.from_euler("y", [[0], [50], [170], [-100]], degrees=True)
        leans = Rotation.from_euler("z", [[10], [40], [10], [40]], degrees=True)
        root = world * headings * leans * rest.inv()
        return Motion(skeleton, np.zeros((4, 12)), 30, root_angles=root.as_euler("xyz"), up=up).with_root("tilt")

    usual, other = motion(Rotation.identity(), "y", Rotation.identity()), motion(rest, up, world)
    expected, found = (pose_distances(one.angles, skeleton=one.skeleton, metric="position") for one in (usual, other))
    assert expected[0, 2] == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(found, expected, atol=1e-9)
    angle, other_angle = (
        (Rotation.from_rotvec(one.angles[0, :3]).inv() * Rotation.from_rotvec(one.angles[1, :3])).magnitude()
        for one in (usual, other)
    )
    assert np.degrees(angle) == pytest.approx(30.0)
    assert np.degrees(other_angle) == pytest.approx(30.0)
    assert rotations_of_root(other.without_root()) == pytest.approx(rotations_of_root(other), abs=1e-9)


def rotations_of_root(motion):
    """The world orientation of the skeleton in each frame, as matrices."""
    root = Rotation.from_euler(motion.root_axes, motion.root_angles).as_matrix()
    if "root_rotvec_x" in motion.skeleton.dof_names:
        root = root @ Rotation.from_rotvec(motion.angles[:, :3]).as_matrix()
    return root
