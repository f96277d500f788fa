"""Retargeting between skeletons that are rigged differently."""

import numpy as np
import pytest
from conftest import in_space
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton, forward_kinematics, pose_distances
from skpose.datasets import MotionDataset
from skpose.kinematics import retarget

# A person as points at angle zero, m: y up, z forward.
POINTS = {
    "spine": (None, (0, 0.15, 0)),
    "chest": ("spine", (0, 0.4, 0.02)),
    "head": ("chest", (0, 0.65, 0.04)),
    "l_shoulder": ("chest", (0.2, 0.42, 0)),
    "l_elbow": ("l_shoulder", (0.5, 0.42, 0)),
    "l_wrist": ("l_elbow", (0.75, 0.42, 0)),
    "r_shoulder": ("chest", (-0.2, 0.42, 0)),
    "r_elbow": ("r_shoulder", (-0.5, 0.42, 0)),
    "r_wrist": ("r_elbow", (-0.75, 0.42, 0)),
    "l_hip": (None, (0.1, -0.05, 0.01)),
    "l_knee": ("l_hip", (0.1, -0.45, 0.02)),
    "l_ankle": ("l_knee", (0.1, -0.85, 0)),
    "r_hip": (None, (-0.1, -0.05, 0.01)),
    "r_knee": ("r_hip", (-0.1, -0.45, 0.02)),
    "r_ankle": ("r_knee", (-0.1, -0.85, 0)),
}
# Joints without dofs, so that the same bones move together in both frames: those of the root, and those of the chest.
STILL = {
    "own": ["spine", "head", "l_shoulder", "r_shoulder", "l_hip", "r_hip"],
    "parent": ["chest", "head", "l_wrist", "r_wrist", "l_ankle", "r_ankle"],
}
DOWN = np.array([0.4, -0.9, 0.0]) / np.hypot(0.4, 0.9)
ARMS_DOWN = {
    f"{side}_{joint}": (f"{side}_{parent}", tuple(([0.2, 0.42, 0] + length * DOWN) * [sign, 1, 1]))
    for side, sign in (("l", 1), ("r", -1))
    for joint, parent, length in (("elbow", "shoulder", 0.3), ("wrist", "elbow", 0.55))
}
Z_UP = Rotation.from_euler("xz", [90, 90], degrees=True)


def rig(frame="parent", dofs="ZXY", *, points=POINTS, world=None, axes=None, names=None, leave_out=(), scale=1.0):
    """A skeleton through the points. World is a rotation of all, axes a seed of the axes of each joint at rest."""
    world = Rotation.identity() if world is None else world
    rng = np.random.default_rng(axes)
    parents = {name: parent for name, (parent, _) in points.items()}
    where = {name: scale * world.apply(point) for name, (_, point) in points.items()} | {None: np.zeros(3)}
    oriented, bones = {None: Rotation.identity()}, []
    for name in points:
        parent = parents[name]
        while parent in leave_out:
            parent = parents[parent]
        oriented[name] = Rotation.identity() if axes is None else Rotation.random(random_state=rng)
        if name in leave_out:
            continue
        rest = oriented[parent].inv() * oriented[name]
        carrier = oriented[name if frame == "own" else parent]
        offset = carrier.inv().apply(where[name] - where[parent])
        new = {None: None, **(names or dict(zip(points, points, strict=True)))}
        bones.append(Bone(new[name], new[parent], offset, "" if name in STILL[frame] else dofs, rest.as_matrix()))
    return Skeleton(bones, frame)


def random_motion(skeleton, n=9, seed=0, size=1.0, up="y"):
    rng = np.random.default_rng(seed)
    angles, root = rng.uniform(-size, size, (n, skeleton.n_dofs)), rng.uniform(-3, 3, (n, 3))
    return Motion(
        skeleton, angles, 30, root_angles=root, root_axes="ZXY", root_positions=rng.normal(size=(n, 3)), up=up
    )


def bones_in_space(motion, names):
    """Directions (n_frames, n_bones, 3) in the world of the bones that end at joints."""
    positions = np.concatenate([in_space(motion), motion.root_positions[:, None]], axis=1)
    joints = [motion.skeleton.joint_names.index(name) for name in names]
    bones = positions[:, joints] - positions[:, motion.skeleton.parents[joints]]
    return bones / np.linalg.norm(bones, axis=2, keepdims=True)


ALL = list(POINTS)
RIGS = {
    "other Euler order": {"dofs": "xyz"},
    "ball joints": {"dofs": "rotvec"},
    "own": {"frame": "own"},
    "other axes": {"axes": 3, "dofs": "YXZ"},
    "own, other axes": {"axes": 4, "frame": "own", "dofs": "rotvec"},
    "arms down": {"points": POINTS | ARMS_DOWN},
    "z up": {"world": Z_UP, "dofs": "rotvec"},
    "own, z up, arms down, other axes": {
        "frame": "own",
        "world": Z_UP,
        "axes": 5,
        "points": POINTS | ARMS_DOWN,
    },
}


@pytest.mark.parametrize("there", RIGS)
def test_joints_stay_where_they_are_by_orientations(there):
    """Lengths are the same, so that directions that stay are positions that stay; and the path back is exact."""
    one, other = rig(**RIGS["own, other axes"]), rig(**RIGS[there])
    motion = random_motion(one)
    result = retarget(motion, other, method="orientations")
    assert result.skeleton is other
    np.testing.assert_allclose(in_space(result), in_space(motion), atol=1e-9)
    np.testing.assert_array_equal(result.root_positions, motion.root_positions)
    back = retarget(result, one, method="orientations")
    np.testing.assert_allclose(in_space(back), in_space(motion), atol=1e-9)
    np.testing.assert_allclose(forward_kinematics(back.angles, one), forward_kinematics(motion.angles, one), atol=1e-9)


def test_two_files_of_one_motion_have_no_distance():
    """The poses in the axes of the root are the same from files of any rig, up axis and rest pose."""
    target = rig(dofs="rotvec", axes=7, scale=1.1)
    motion = random_motion(rig())
    X = [
        retarget(retarget(motion, rig(**there), method="orientations"), target, method="orientations").angles
        for there in RIGS.values()
    ]
    D = pose_distances(np.concatenate(X), skeleton=target, metric="position").reshape(len(X), 9, len(X), 9)
    assert np.abs(D[:, range(9), :, range(9)]).max() < 1e-6
    assert D[0, 0, 0, 1] > 0.1


@pytest.mark.parametrize("frame", ["own", "parent"])
def test_the_target_has_a_joint_more(frame):
    """It keeps its rest pose relative to its parent, and the others point where they did."""
    motion, other = random_motion(rig(leave_out=["l_elbow"])), rig(frame)
    result = retarget(motion, other, method="orientations")
    names = ["head", "r_elbow", "r_wrist", "l_knee", "l_ankle", "r_knee", "r_ankle"]
    np.testing.assert_allclose(bones_in_space(result, names), bones_in_space(motion, names), atol=1e-9)
    np.testing.assert_allclose(result.angles[:, [n.startswith("l_elbow") for n in other.dof_names]], 0.0, atol=1e-9)
    ends = bones_in_space(motion, ["l_wrist"])
    np.testing.assert_allclose(bones_in_space(result, ["l_wrist"]), ends, atol=1e-9)
    if frame == "parent":  # the shoulder follows the motion's, so that the arm is straight
        np.testing.assert_allclose(bones_in_space(result, ["l_elbow"]), ends, atol=1e-9)


def test_a_root_that_carries_no_bone_is_that_of_the_motion():
    """Its axes are those of the target: from a file with another axis up, too, and the poses are the same."""
    free = Skeleton((b._replace(dofs="rotvec") for b in rig("own").bones), "own")
    motion = random_motion(rig())
    poses = [
        retarget(m, free, method="orientations").angles
        for m in (motion, retarget(motion, rig(world=Z_UP), method="orientations"))
    ]
    expected = forward_kinematics(motion.angles, motion.skeleton)
    for X in poses:
        np.testing.assert_allclose(forward_kinematics(X, free), expected, atol=1e-9)


def test_twists_are_those_of_the_joint_that_carries_the_bone():
    """The elbow of the file rotates the bone that ends at the wrist, as the wrist of the target does."""
    source = Skeleton([Bone("elbow", None, (0.3, 0, 0), "xyz"), Bone("wrist", "elbow", (0.25, 0, 0), "xyz")], "parent")
    target = Skeleton([Bone("elbow", None, (0.3, 0, 0)), Bone("wrist", "elbow", (0.25, 0, 0), "xyz")])
    motion = random_motion(source)
    there = retarget(motion, target, method="orientations")
    np.testing.assert_allclose(there.angles, motion.angles[:, :3], atol=1e-9)


# --- positions -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("there", ["ball joints", "other axes", "z up"])
def test_joints_stay_where_they_are_by_positions(there):
    motion = random_motion(rig(dofs="xyz"), n=4, size=0.5)
    result = retarget(motion, rig(**RIGS[there]), method="positions")
    np.testing.assert_allclose(in_space(result), in_space(motion), atol=1e-6)
    assert result.frame_rate == 30


def test_scale_by_the_lengths_of_bones():
    motion, taller = random_motion(rig(), n=3, size=0.5), rig("own", "rotvec", scale=1.25)
    by_positions = retarget(motion, taller, method="positions", scale="lengths")
    by_orientations = retarget(motion, taller, method="orientations", scale="lengths")
    for result in (by_positions, by_orientations, retarget(motion, taller, method="orientations", scale=1.25)):
        np.testing.assert_allclose(in_space(result), 1.25 * in_space(motion), atol=1e-6)
    same_rig = retarget(motion, rig(scale=1.25), scale="lengths")
    np.testing.assert_allclose(in_space(same_rig), 1.25 * in_space(motion), atol=1e-9)
    by_legs = retarget(motion, taller, method="orientations")  # the default of people
    np.testing.assert_allclose(in_space(by_legs), 1.25 * in_space(motion), atol=1e-6)
    in_metres = retarget(motion, taller, method="orientations", scale=1.0)
    np.testing.assert_array_equal(in_metres.root_positions, motion.root_positions)


def hinged(knee="x", hip="ZXY"):
    """A leg whose knee is a hinge."""
    return Skeleton(
        [
            Bone("l_hip", None, (0.1, -0.05, 0.01)),
            Bone("r_hip", None, (-0.1, -0.05, 0.01)),
            Bone("chest", None, (0, 0.5, 0)),
            Bone("l_knee", "l_hip", (0, -0.4, 0), hip),
            Bone("l_ankle", "l_knee", (0, -0.4, 0), knee),
        ]
    )


def test_hinges_that_cannot_are_refused_and_positions_can():
    """The hip rotates about the thigh, so that a knee of another axis bends to the same side."""
    motion, target = random_motion(hinged(), n=3, size=0.4), hinged("z")
    with pytest.raises(ValueError, match="'l_ankle'"):
        retarget(motion, target, method="orientations")
    dataset = MotionDataset([motion]).retarget(target, method="auto")
    np.testing.assert_allclose(in_space(dataset[0]), in_space(motion), atol=1e-6)
    assert dataset.retargeting == ("positions, 5 of 5 joints within 0 cm",)


# --- what is refused, and collections --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        ({"knee": "l_knee"}, "'knee'"),
        ({"l_knee": "l_knee", "r_knee": "l_knee"}, "once"),
        ({"l_knee": "l_ankle", "l_ankle": "l_knee"}, "does not come after"),
    ],
)
def test_mappings_that_are_refused(joints, message):
    with pytest.raises(ValueError, match=message):
        retarget(random_motion(rig()), rig("own"), method="auto", joints=joints)


def test_arguments_that_are_refused():
    motion = random_motion(rig())
    for target, options, message in (
        (rig(), {"joints": {"l_knee": "l_knee"}}, "joints="),
        (rig(), {"scale": -1.0}, "scale"),
        (rig("own"), {}, "offset frames"),
        (rig(dofs="rotvec"), {"method": "angles"}, "method"),
    ):
        with pytest.raises(ValueError, match=message):
            retarget(motion, target, **options)
    lift = Skeleton([Bone("spine", None, (0, 0, 1), "slide", axis=(0, 0, 1))])
    with pytest.raises(ValueError, match="'spine' slides"):
        retarget(motion, lift, method="orientations")
    hinge = Skeleton([Bone("spine", None, (0, 0, 1), "hinge", axis=(0, 0, 1))])
    with pytest.raises(ValueError, match="retarget_to_robot"):
        retarget(motion, hinge, method="auto")


def test_limits_are_enforced_by_positions():
    source = hinged()
    narrow = Skeleton(b._replace(limits=[(0.0, 0.1)]) if b.name == "l_ankle" else b for b in source.bones)
    motion = random_motion(source, n=3, size=0.4)
    for method in ("numbers", "orientations"):
        assert retarget(motion, narrow, method=method).angles[:, -1].max() > 0.1
        with pytest.raises(ValueError, match="l_ankle_rx"):
            retarget(motion, narrow, method=method, joint_limits="enforce")
    dataset = MotionDataset([motion]).retarget(narrow, method="auto", joint_limits="enforce")
    assert dataset.retargeting[0].startswith("positions")
    assert dataset[0].angles[:, -1].max() <= 0.1


def test_collections_of_mixed_sources():
    """The same numbers, another rig with other names, and a hinge that only positions can serve."""
    target = hinged()
    names = {name: f"{name[:3]}{i}" for i, name in enumerate(POINTS)}
    known = {names[n]: n for n in target.joint_names}
    other = retarget(
        random_motion(target, n=3, size=0.3), rig("own", "rotvec", names=names), method="orientations", joints=known
    )
    motions = [random_motion(target, n=3, size=0.3), other, random_motion(hinged("z"), n=3, size=0.3, seed=2)]
    there = MotionDataset(motions, rotations="file").retarget(
        target, method="auto", joints=[None, {n: o for o, n in known.items()}, None]
    )
    assert [report.partition(",")[0] for report in there.retargeting] == ["same numbers", "orientations", "positions"]
    X = there.poses()[0]
    np.testing.assert_allclose(forward_kinematics(X[3:6], target), forward_kinematics(X[:3], target), atol=1e-9)


@pytest.mark.slow
def test_people_of_two_collections(cmu, hdm05):
    """Both are ASF files with the same names of joints; hinges have other axes, bones other lengths."""
    motion = hdm05.motions[0].to_rotvec().resample(2)
    balls = (b._replace(dofs="rotvec" if b.dofs else "", limits=None) for b in cmu.motions[0].skeleton.bones)
    target = Skeleton(balls, "own")
    there = retarget(motion, target, method="orientations", scale=1.0)
    single = ["lfemur", "ltibia", "rhumerus", "rradius", "lowerback"]
    np.testing.assert_allclose(bones_in_space(there, single), bones_in_space(motion, single), atol=1e-9)


def test_a_motion_with_missing_frames_keeps_its_times():
    motion = random_motion(rig(), n=3, size=0.3)
    motion = Motion(motion.skeleton, motion.angles, 30, frame_numbers=[0, 5, 6], up="z")
    for method in ("orientations", "positions"):
        result = retarget(motion, rig("own"), method=method)
        np.testing.assert_array_equal(result.frame_numbers, [0, 5, 6])
        assert (result.up, result.frame_rate) == ("z", 30)


def test_hips_that_are_bent_a_little_do_not_turn_the_pelvis_over():
    # A few degrees, as by noise in keypoints, bent forward on one skeleton and backward on the other.
    def pelvis(angle):
        c, s = 0.1 * np.cos(np.radians(angle)), 0.1 * np.sin(np.radians(angle))
        thighs = [Bone(f"{side}_knee", f"{side}_hip", (0.0, -0.4, 0.0), "rotvec") for side in ("left", "right")]
        hips = [Bone("left_hip", None, (c, 0.0, s)), Bone("right_hip", None, (-c, 0.0, s))]
        return Skeleton([*hips, *thighs, Bone("neck", None, (0.0, 0.5, 0.0), "rotvec")])

    motion = Motion(pelvis(6.0), np.zeros((3, 9)), 30)
    found = retarget(motion, pelvis(-6.0), method="orientations")
    np.testing.assert_allclose(found.root_angles, 0.0, atol=1e-9)
    np.testing.assert_allclose(found.angles, 0.0, atol=1e-9)
