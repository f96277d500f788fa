"""Retargeting between skeletons that are rigged differently."""

import numpy as np
import pytest
from conftest import in_space, random_tree
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton, forward_kinematics, pose_distances
from skpose.datasets import MotionDataset, make_gait
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
@pytest.mark.parametrize("here", ["other Euler order", "own, other axes"])
def test_joints_stay_where_they_are_by_orientations(here, there):
    """Lengths are the same, so that directions that stay are positions that stay; and the path back is exact."""
    one, other = rig(**RIGS[here]), rig(**RIGS[there])
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


def test_joints_have_other_names():
    names = {name: f"{name[:3]}{i}" for i, name in enumerate(POINTS)}
    motion, other = random_motion(rig()), rig("own", names=names)
    with pytest.raises(ValueError, match=r"no name of a joint in common: pass joints=, .*'spi0'"):
        retarget(motion, other, method="orientations")
    result = retarget(motion, other, method="orientations", joints={new: old for old, new in names.items()})
    np.testing.assert_allclose(in_space(result), in_space(motion), atol=1e-9)


@pytest.mark.parametrize("frame", ["own", "parent"])
def test_the_target_has_a_joint_less(frame):
    """The bone across the joint that is missing points from end to end."""
    motion, other = random_motion(rig(dofs="xyz")), rig(frame, leave_out=["l_elbow", "r_knee"])
    result = retarget(motion, other, method="orientations")
    names = [name for name in other.joint_names if other[name].parent]
    a = bones_in_space(result, names)
    positions = dict(zip(motion.skeleton.joint_names, in_space(motion).swapaxes(0, 1), strict=True))
    b = np.stack([positions[n] - positions[other[n].parent] for n in names], axis=1)
    np.testing.assert_allclose(a, b / np.linalg.norm(b, axis=2, keepdims=True), atol=1e-9)


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


def test_orders_of_euler_angles_make_no_difference():
    motion, target = random_motion(rig(dofs="rotvec")), rig("own", "ZXY", scale=1.2)
    X = [retarget(motion.to_euler(order), target, method="orientations").angles for order in ("xyz", "ZYX", "YXZ")]
    D = pose_distances(np.concatenate(X), skeleton=target, metric="position")
    np.testing.assert_allclose(D[:9, 9:18], D[:9, :9], atol=1e-7)
    np.testing.assert_allclose(D[:9, 18:], D[:9, :9], atol=1e-7)


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


def test_angles_are_continuous():
    """A slow motion has small steps after retargeting too, not jumps between triples of one rotation."""
    slow = Motion(rig(dofs="rotvec"), np.linspace(-1, 1, 200)[:, None] * np.full(rig().n_dofs, 2.0), 60)
    for dofs in ("ZXY", "rotvec"):
        result = retarget(slow, rig("own", dofs, axes=1), method="orientations")
        change = np.abs(np.diff(result.angles, axis=0))
        assert np.median(change) < 0.1
        assert (change < 3.0).all()


# --- positions -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("there", ["ball joints", "own", "other axes", "z up"])
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
    without = retarget(motion, taller, method="orientations")
    np.testing.assert_array_equal(without.root_positions, motion.root_positions)


def test_scale_leaves_out_what_only_one_has():
    """A longer head without a counterpart, and a trunk with a joint less, change nothing about the ratio."""
    long_head = Skeleton([b._replace(offset=(0, 5, 0)) if b.name == "head" else b for b in rig().bones], "parent")
    motion = random_motion(long_head, n=2)
    joints = {name: name for name in POINTS if name != "head"}
    straight = POINTS | {"chest": ("spine", (0, 0.4, 0))}
    motion = Motion(rig(points=straight), motion.angles[:2], 30, root_positions=motion.root_positions)
    del joints["spine"]
    other = rig(points=straight, leave_out=["spine"], scale=1.5)
    result = retarget(motion, other, method="orientations", joints=joints, scale="lengths")
    np.testing.assert_allclose(result.root_positions, 1.5 * motion.root_positions, rtol=1e-12)


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
    message = r'joint \'l_ankle\' has the dofs \'z\', .* cannot keep .* dofs="rotvec" can, and method="pos'
    with pytest.raises(ValueError, match=message):
        retarget(motion, target, method="orientations")
    dataset = MotionDataset([motion]).retarget(target, method="auto")
    np.testing.assert_allclose(in_space(dataset[0]), in_space(motion), atol=1e-6)
    assert dataset.retargeting == ("positions, 5 of 5 joints within 0 cm",)


def test_positions_that_cannot_be_reached_are_reported():
    motion = random_motion(hinged(), n=3, size=0.4)
    dataset = MotionDataset([motion]).retarget(hinged("x", "x"), method="auto")
    apart = 100 * np.linalg.norm(in_space(dataset[0]) - in_space(motion), axis=2).max()
    assert dataset.retargeting == (f"positions, 5 of 5 joints within {round(apart, 2):g} cm",)
    assert 1.0 < apart < 20.0


def test_ball_joints_and_back_to_hinges():
    source = hinged()
    motion = random_motion(source, n=3, size=0.4)
    ball = Skeleton([b._replace(dofs="rotvec") if b.dofs == "x" else b for b in source.bones])
    exact = retarget(motion, ball, method="orientations")
    np.testing.assert_allclose(in_space(exact), in_space(motion), atol=1e-9)
    np.testing.assert_allclose(in_space(retarget(exact, source, method="orientations")), in_space(motion), atol=1e-9)


# --- what is refused, and collections --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        ({"knee": "l_knee"}, r"joints maps 'knee' to 'l_knee', but the given skeleton has no 'knee': did you mean"),
        ({"l_knee": "LeftLeg"}, r"joints maps 'l_knee' to 'LeftLeg', but the motion's has no 'LeftLeg': skeleton\."),
        ({"l_knee": "l_knee", "r_knee": "l_knee"}, r"maps 'l_knee' and 'r_knee' to one joint, 'l_knee'"),
        ({"l_knee": "l_ankle", "l_ankle": "l_knee"}, r"but 'l_ankle' comes after 'l_knee' and .*: exchange the two"),
        ({}, r"joints has no counterparts: name at least one joint"),
        ({"l_knee": 3}, r"maps 'l_knee' to 3, but the motion's has no 3: names are strings"),
    ],
)
@pytest.mark.parametrize("method", ["orientations", "positions", "auto"])
def test_mappings_that_are_refused(joints, message, method):
    with pytest.raises(ValueError, match=message):
        retarget(random_motion(rig()), rig("own"), method=method, joints=joints)


def test_arguments_that_are_refused():
    motion = random_motion(rig())
    with pytest.raises(TypeError, match=r"joints must be a mapping of .*, got list"):
        retarget(motion, rig("own"), method="orientations", joints=["l_knee"])
    with pytest.raises(ValueError, match=r'method="numbers" matches dofs by name, and joints= is for other methods'):
        retarget(motion, rig(), joints={"l_knee": "l_knee"})
    for scale in (0, -1.0, np.inf, np.nan, "size", True):
        with pytest.raises(ValueError, match='scale must be a positive number, or "lengths", got'):
            retarget(motion, rig(), scale=scale)
    with pytest.raises(TypeError, match=r"motion must be a skpose\.Motion, got ndarray"):
        retarget(motion.angles, rig())
    only_far = Skeleton([Bone("spine", None, (0, 0, 0), "xyz")])
    with pytest.raises(ValueError, match='scale="lengths" needs bones that both skeletons have'):
        retarget(motion, only_far, method="orientations", scale="lengths")
    with pytest.raises(ValueError, match=r"their offset frames are .* method=\"orientations\"\) converts between rigs"):
        retarget(motion, rig("own"))
    swapped = rig(names={name: name.upper() for name in POINTS})
    with pytest.raises(ValueError, match="its keys are joints of the given skeleton, its values those of the motion's"):
        retarget(motion, swapped, method="orientations", joints={"l_knee": "L_KNEE"})


def test_collections_of_mixed_sources():
    """An Euler file, one of another rig with other names, and a hinge that only positions can serve."""
    target = hinged()
    names = {name: f"{name[:3]}{i}" for i, name in enumerate(POINTS)}
    lower = target.joint_names
    motions = [
        random_motion(target, n=3, size=0.3),
        retarget(
            random_motion(target, n=3, size=0.3, seed=1),
            rig("own", "rotvec", names=names),
            method="orientations",
            joints={names[n]: n for n in lower},
        ),
        random_motion(hinged("z"), n=3, size=0.3, seed=2),
    ]
    dataset = MotionDataset(motions, actions=["walk", "walk", "run"])
    with pytest.raises(
        ValueError, match=r'motions\[1\] has no .* motions\[0\]: .* dataset\.retarget\(skeleton, method="auto"'
    ):
        dataset.poses()
    joints = [None, {n: names[n] for n in lower}, None]
    there = dataset.retarget(target, method="auto", joints=joints)
    assert [report.partition(",")[0] for report in there.retargeting] == ["same numbers", "orientations", "positions"]
    assert repr(there) == (
        "MotionDataset(3 motions: 1 run, 2 walk; retargeted by 1 orientations, 1 positions, 1 same numbers)"
    )
    assert repr(there[:1]) == "MotionDataset(1 motions: 1 walk)"
    assert there[[2, 0]].retargeting == (there.retargeting[2], "same numbers")
    assert there.to_rotvec().retargeting == there.retargeting
    X, sequence = there.poses()
    assert (X.shape, len(sequence)) == ((9, target.n_dofs), 9)
    again = retarget(random_motion(target, n=3, size=0.3, seed=1), target)
    np.testing.assert_allclose(forward_kinematics(X[3:6], target), forward_kinematics(again.angles, target), atol=1e-9)
    assert dataset.retargeting == ("", "", "")
    with pytest.raises(ValueError, match=r"motions\[1\]: the motion's skeleton and the given one have no name"):
        dataset.retarget(target, method="auto")
    with pytest.raises(ValueError, match="one for each of the 3 motions, got 2"):
        dataset.retarget(target, method="auto", joints=[None, None])


def test_generated_people_are_retargeted_by_orientations():
    """Of one rig, and hinges whose axes agree: every bone points in the same direction."""
    gait = make_gait(2, 1, random_state=0)
    there = gait.retarget(gait.motions[0].skeleton, method="orientations")
    assert there.retargeting == ("orientations, 22 of 22 joints, directions within 0°",) * len(gait)


def test_motions_without_frames():
    empty = Motion(rig(), np.zeros((0, rig().n_dofs)), 30)
    for method in ("orientations", "positions", "auto"):
        assert len(retarget(empty, rig("own"), method=method)) == 0


def test_a_motion_with_missing_frames_keeps_its_times():
    motion = random_motion(rig(), n=3, size=0.3)
    motion = Motion(motion.skeleton, motion.angles, 30, frame_numbers=[0, 5, 6], up="z")
    for method in ("orientations", "positions"):
        result = retarget(motion, rig("own"), method=method)
        np.testing.assert_array_equal(result.frame_numbers, [0, 5, 6])
        assert (result.up, result.frame_rate) == ("z", 30)


def test_random_trees_of_two_frames():
    """Every joint of the one frame that carries a single bone does as the other's does."""
    chain = [Bone(f"b{i}", f"b{i - 1}" if i else None, (0.1 * i + 0.1, 0.2, 0), "xyz") for i in range(5)]
    motion = random_motion(Skeleton(chain), size=3.0)
    tips = [*(b._replace(dofs="") if b.name == "b4" else b._replace(dofs="rotvec") for b in chain)]
    result = retarget(motion, Skeleton(tips, "parent"), method="orientations")
    np.testing.assert_allclose(in_space(result), in_space(motion), atol=1e-9)
    tree = random_tree(0, kinds=["rotvec"])
    same = retarget(random_motion(tree), tree.to_euler("ZXY"), method="orientations")
    np.testing.assert_allclose(in_space(same), in_space(random_motion(tree)), atol=1e-9)


# --- recordings ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("direction", ["CMU to HDM05", "HDM05 to CMU"])
def test_people_of_two_collections(cmu, hdm05, direction):
    """Both are ASF files with the same names of joints; their hinges have other axes, their bones other lengths."""
    motion, target = cmu.motions[0], hdm05.motions[0].skeleton
    if direction == "HDM05 to CMU":
        motion, target = hdm05.motions[0], cmu.motions[0].skeleton
    motion = motion.resample(3)
    with pytest.raises(ValueError, match="has the dofs 'x', with which bone"):
        retarget(motion, target, method="orientations")
    balls = Skeleton((b._replace(dofs="rotvec", limits=None) if b.dofs else b for b in target.bones), "own")
    there = retarget(motion, balls, method="orientations")
    back = Skeleton((b._replace(dofs="rotvec", limits=None) if b.dofs else b for b in motion.skeleton.bones), "own")
    single = ["lfemur", "ltibia", "rfemur", "rtibia", "lhumerus", "lradius", "rhumerus", "rradius", "head", "lowerback"]
    directions = bones_in_space(motion, single)
    np.testing.assert_allclose(bones_in_space(there, single), directions, atol=1e-9)
    there = retarget(there, back, method="orientations")
    np.testing.assert_allclose(bones_in_space(there, single), directions, atol=1e-9)
    dataset = MotionDataset([motion]).retarget(target, method="auto", scale="lengths")
    # The numbers carry over too, as for people of one collection.
    assert dataset.retargeting == ("same numbers",)
    by_positions = MotionDataset([motion]).retarget(target, method="positions", scale="lengths")
    reported = float(by_positions.retargeting[0].split()[-2])
    assert 0.5 < reported < 8.0, by_positions.retargeting
    by_numbers = np.degrees(np.arccos(np.clip((bones_in_space(dataset[0], single) * directions).sum(2), -1, 1)))
    by_joints = np.degrees(np.arccos(np.clip((bones_in_space(by_positions[0], single) * directions).sum(2), -1, 1)))
    assert by_joints.mean() < 4.0
    assert by_numbers.mean() < 10.0


def test_a_person_on_their_own_skeleton_in_another_rig(cmu):
    """Poses whose hinges become ball joints, with positions as of a file without angles: the joints stay."""
    motion = cmu.motions[0].resample(2)
    balls = Skeleton((b._replace(dofs="rotvec", limits=None) if b.dofs else b for b in motion.skeleton.bones), "own")
    result = retarget(motion, balls, method="positions")
    np.testing.assert_allclose(in_space(result), in_space(motion), atol=1e-6)


@pytest.mark.parametrize("bent", [4.0, 12.0])
def test_hips_that_are_bent_a_little_do_not_turn_the_pelvis_over(bent):
    # A few degrees, as by noise in keypoints, bent forward on one skeleton and backward on the other.
    def pelvis(angle):
        c, s = 0.1 * np.cos(np.radians(angle)), 0.1 * np.sin(np.radians(angle))
        thighs = [Bone(f"{side}_knee", f"{side}_hip", (0.0, -0.4, 0.0), "rotvec") for side in ("left", "right")]
        hips = [Bone("left_hip", None, (c, 0.0, s)), Bone("right_hip", None, (-c, 0.0, s))]
        return Skeleton([*hips, *thighs, Bone("neck", None, (0.0, 0.5, 0.0), "rotvec")])

    motion = Motion(pelvis(bent / 2), np.zeros((3, 9)), 30)
    found = retarget(motion, pelvis(-bent / 2), method="orientations")
    np.testing.assert_allclose(found.root_angles, 0.0, atol=1e-9)
    np.testing.assert_allclose(found.angles, 0.0, atol=1e-9)
