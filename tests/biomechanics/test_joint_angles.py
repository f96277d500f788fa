"""Joint angles: what they are called, where they are zero, that files' conventions play no part, what is not shown."""

from dataclasses import replace

import numpy as np
import pytest
import sklearn
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton, inverse_kinematics
from skpose.biomechanics import gait_events, joint_angles
from skpose.biomechanics._person import find_person
from skpose.biomechanics._seen import find_seen
from skpose.biomechanics._segments import find_segments
from skpose.datasets import humanoid
from skpose.io import load_bvh, load_motion, load_trc, save_bvh
from skpose.keypoints import Layout, fit_skeleton, layouts
from skpose.kinematics import forward_kinematics

SIDES = ("left", "right")
X, Y, Z = np.eye(3)
# A person who faces +z, with y up and the left at +x; each joint is where its bone begins, as in BVH.
CHAINS = {
    "Spine": ("Hips", 0.2 * Y),
    "Neck": ("Spine", 0.3 * Y),
    "Head": ("Neck", 0.1 * Y),
    "Head_end": ("Head", 0.2 * Y),
}
FOOT, TOE = -0.05 * Y + 0.12 * Z, 0.05 * Z


def person(arms="hanging", dofs="rotvec", spread=0.0, thumb=True, turned=None):
    """A symmetrical person as in a file of LAFAN1's names, at rest with arms as given, in T-pose palms down."""
    bones = [Bone("Hips", None, np.zeros(3), dofs)]
    bones += [Bone(name, parent, offset, dofs) for name, (parent, offset) in CHAINS.items()]
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        outward = np.array([sign, 0.0, 0.0])
        leg = Rotation.from_rotvec([0.0, 0.0, sign * spread])
        along = {"hanging": -Y, "T": outward}[arms]
        thumbward = Z  # palms face the thighs where arms hang, down in a T-pose
        chain = [
            ("UpLeg", "Hips", 0.1 * outward),
            ("Leg", f"{side}UpLeg", leg.apply(-0.4 * Y)),
            ("Foot", f"{side}Leg", leg.apply(-0.4 * Y)),
            ("Toe", f"{side}Foot", leg.apply(FOOT)),
            ("Toe_end", f"{side}Toe", leg.apply(TOE)),
            ("Shoulder", "Spine", 0.2 * Y + 0.05 * outward),
            ("Arm", f"{side}Shoulder", 0.12 * outward),
            ("ForeArm", f"{side}Arm", 0.3 * along),
            ("Hand", f"{side}ForeArm", 0.25 * along),
            ("Hand_end", f"{side}Hand", 0.1 * along),
        ]
        if thumb:
            chain.append(("HandThumb", f"{side}Hand", 0.05 * along + 0.04 * thumbward))
        bones += [Bone(side + name, parent, offset, dofs) for name, parent, offset in chain]
    return Skeleton(bones, offset_frame="parent")


def pose(skeleton, **rotations):
    """One frame in which joints have rotated by Rotations; as many frames as these are."""
    columns = {name: np.atleast_2d(rotation.as_rotvec()) for name, rotation in rotations.items()}
    angles = np.zeros((max(map(len, columns.values()), default=1), skeleton.n_dofs))
    for name, rotvecs in columns.items():
        first = skeleton.dof_names.index(f"{name}_rotvec_x")
        angles[:, first : first + 3] = rotvecs
    return Motion(skeleton, angles, 30.0)


def about(axis, degrees):
    return Rotation.from_rotvec(np.radians(degrees) * np.asarray(axis, dtype=float))


def value(angles, name):
    return float(angles[name][0])


# The joint of the left side that rotates, about which axis of the world by 20°, and which angle that is. The left is
# at +x and the front at +z: a rotation about -x brings what hangs forward.
MOVES = [
    ("LeftUpLeg", -X, "hip_flexion_left"),
    ("LeftUpLeg", -Z, "hip_adduction_left"),
    ("LeftUpLeg", -Y, "hip_rotation_left"),
    ("LeftLeg", X, "knee_flexion_left"),
    ("LeftLeg", -Z, "knee_adduction_left"),
    ("LeftLeg", -Y, "knee_rotation_left"),
    ("LeftFoot", -X, "ankle_dorsiflexion_left"),
    ("LeftFoot", -Z, "ankle_inversion_left"),
    ("LeftFoot", -Y, "ankle_rotation_left"),
    ("LeftArm", -X, "shoulder_flexion_left"),
    ("LeftArm", -Z, "shoulder_adduction_left"),
    ("LeftArm", -Y, "shoulder_rotation_left"),
    ("LeftForeArm", -X, "elbow_flexion_left"),
    ("LeftForeArm", -Z, "elbow_adduction_left"),
    ("Spine", -X, "trunk_extension"),
    ("Spine", Z, "trunk_bending"),
    ("Spine", Y, "trunk_rotation"),
    ("Head", -X, "neck_extension"),
    ("Head", Z, "neck_bending"),
    ("Head", Y, "neck_rotation"),
    ("Hips", -X, "pelvis_tilt"),
    ("Hips", Z, "pelvis_list"),
    ("Hips", Y, "pelvis_rotation"),
]


@pytest.mark.parametrize(("joint", "axis", "name"), MOVES)
def test_a_rotation_about_one_axis_is_one_angle_on_both_sides(joint, axis, name):
    """On the right it is mirrored: the rotations about y and z have the other sign."""
    skeleton = person()
    rest = joint_angles(pose(skeleton))
    for side in SIDES if "left" in name else ("left",):
        mirrored = np.asarray(axis) * ([1, 1, 1] if side == "left" else [1, -1, -1])
        angles = joint_angles(pose(skeleton, **{joint.replace("Left", side.capitalize()): about(mirrored, 20)}))
        expected = {name.replace("left", side): 20.0}
        if name.startswith("shoulder"):
            expected |= {f"shoulder_elevation_{side}": 20.0 if "rotation" not in name else 0.0}
        for other in angles.names:
            if "plane" in other or other.startswith(("wrist", "elbow_pronation")):
                continue  # below
            change = value(angles, other) - value(rest, other)
            assert change == pytest.approx(expected.get(other, 0.0), abs=1e-9), other


def test_signs_are_anatomical():
    """What moves where, without a word of axes; each angle is positive."""
    skeleton = person()
    names = skeleton.joint_names
    at_rest = forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton)[0]

    def moves(name, end, direction, **rotations):
        motion = pose(skeleton, **rotations)
        step = forward_kinematics(motion.angles, skeleton)[0, names.index(end)] - at_rest[names.index(end)]
        assert step @ direction > 0.0
        assert value(joint_angles(motion), name) > value(joint_angles(pose(skeleton)), name)

    for side, outward in (("Left", X), ("Right", -X)):
        low = side.lower()
        inward, s = -outward, outward[0]
        moves(f"hip_flexion_{low}", f"{side}Leg", Z, **{f"{side}UpLeg": about(-X, 30)})
        moves(f"hip_adduction_{low}", f"{side}Leg", inward, **{f"{side}UpLeg": about(-Z * s, 10)})
        moves(f"hip_rotation_{low}", f"{side}Toe", inward, **{f"{side}UpLeg": about(-Y * s, 30)})
        moves(f"knee_flexion_{low}", f"{side}Foot", -Z, **{f"{side}Leg": about(X, 30)})
        moves(f"ankle_dorsiflexion_{low}", f"{side}Toe", Y, **{f"{side}Foot": about(-X, 20)})
        moves(f"shoulder_flexion_{low}", f"{side}ForeArm", Z, **{f"{side}Arm": about(-X, 30)})
        moves(f"elbow_flexion_{low}", f"{side}Hand", Z, **{f"{side}ForeArm": about(-X, 30)})
        # The palms face the thighs: the thumb moves inward in pronation, the hand inward in flexion and backward in
        # ulnar deviation.
        moves(f"elbow_pronation_{low}", f"{side}HandThumb", inward, **{f"{side}ForeArm": about(-Y * s, 20)})
        moves(f"wrist_flexion_{low}", f"{side}Hand_end", inward, **{f"{side}Hand": about(-Z * s, 20)})
        moves(f"wrist_ulnar_deviation_{low}", f"{side}Hand_end", -Z, **{f"{side}Hand": about(X, 20)})


@pytest.mark.parametrize("arms", ["hanging", "T"])
@pytest.mark.parametrize("spread", [0.0, 0.3])
def test_a_hanging_limb_is_at_zero_however_the_rest_pose_holds_it(arms, spread):
    """Arms lowered from a T-pose, with palms to the thighs, and legs brought together; feet go with their legs."""
    skeleton = person(arms, spread=spread)
    rotations = {}
    for side, s in (("Left", 1.0), ("Right", -1.0)):
        rotations[f"{side}UpLeg"] = about(-Z * s, np.degrees(spread))
        if arms == "T":
            rotations[f"{side}Arm"] = about(-Z * s, 90)
    angles = joint_angles(pose(skeleton, **rotations))
    for name in angles.names:
        expected = 90.0 if name.startswith("elbow_pronation") else 0.0
        assert "plane" in name or value(angles, name) == pytest.approx(expected, abs=1e-9), name
    if arms == "T":
        raised = joint_angles(pose(skeleton))
        assert value(raised, "shoulder_elevation_left") == pytest.approx(90.0)
        assert value(raised, "shoulder_adduction_left") == pytest.approx(-90.0)
        assert value(raised, "shoulder_plane_left") == pytest.approx(0.0, abs=1e-9)
        assert np.isnan(value(raised, "shoulder_flexion_left"))
        assert "one" in raised.missing["shoulder_flexion_left"]


@pytest.mark.parametrize("name", ["UpLeg", "Leg", "Arm", "ForeArm", "Foot"])
def test_three_angles_are_those_of_grood_and_suntay(name):
    """scipy's intrinsic rotations about z, x and y, with x forward, y up and z to the right."""
    joint, sign, last = {
        "UpLeg": ("hip", 1, "rotation"),
        "Leg": ("knee", -1, "rotation"),
        "Arm": ("shoulder", 1, "rotation"),
        "ForeArm": ("elbow", 1, None),
        "Foot": ("ankle", 1, "rotation"),
    }[name]
    second = "inversion" if joint == "ankle" else "adduction"
    first = "dorsiflexion" if joint == "ankle" else "flexion"
    isb = np.stack([Z, Y, -X], axis=1)
    rotations = Rotation.random(20, rng=np.random.default_rng(0))
    for side in SIDES:
        angles = joint_angles(pose(person(), **{side.capitalize() + name: rotations}))
        mirror = 1.0 if side == "right" else -1.0
        about_isb = Rotation.from_matrix(isb.T @ rotations.as_matrix() @ isb)
        z, x, y = (about_isb.as_euler("ZXY", degrees=True) * [sign, mirror, mirror]).T
        np.testing.assert_allclose(angles[f"{joint}_{first}_{side}"], z, atol=1e-8)
        np.testing.assert_allclose(angles[f"{joint}_{second}_{side}"], x, atol=1e-8)
        if last:
            np.testing.assert_allclose(angles[f"{joint}_{last}_{side}"], y, atol=1e-8)
        if joint == "shoulder":
            down = rotations.apply(-Y) * ([1, 1, 1] if side == "left" else [-1, 1, 1])
            elevation = np.degrees(np.arccos(-down[:, 1]))
            np.testing.assert_allclose(angles[f"shoulder_elevation_{side}"], elevation)
            plane = np.degrees(np.arctan2(down[:, 2], down[:, 0]))
            np.testing.assert_allclose(angles[f"shoulder_plane_{side}"], plane)


def test_tilt_and_list_do_not_depend_on_the_heading():
    lean = about(-X, 12) * about(Z, 5)
    for heading in (0, 60, 150, -100):
        angles = joint_angles(pose(person(), Hips=about(Y, heading) * lean))
        assert value(angles, "pelvis_rotation") == pytest.approx(heading + value_of_lean("rotation"))
        assert value(angles, "pelvis_tilt") == pytest.approx(value_of_lean("tilt"))
        assert value(angles, "pelvis_list") == pytest.approx(value_of_lean("list"))


def value_of_lean(name):
    """scipy's intrinsic rotations about y, x and z (Baker 2001) of the leaning pelvis."""
    isb = np.stack([Z, Y, -X], axis=1)
    lean = (about(-X, 12) * about(Z, 5)).as_matrix()
    y, x, z = Rotation.from_matrix(isb.T @ lean @ isb).as_euler("YXZ", degrees=True)
    return {"rotation": y, "list": x, "tilt": z}[name]


def moving(skeleton, n_frames=40, size=0.4, seed=0):
    """Random smooth movements of all joints."""
    rng = np.random.default_rng(seed)
    phase, speed = rng.uniform(0, 6, skeleton.n_dofs), rng.uniform(0.1, 0.3, skeleton.n_dofs)
    angles = size * np.sin(phase + speed * np.arange(n_frames)[:, None])
    root = np.cumsum(rng.normal(size=(n_frames, 3)), axis=0) * 0.02
    return Motion(skeleton, angles, 30.0, root_positions=root, root_angles=rng.normal(size=(n_frames, 3)) * 0.2)


def assert_same(one, other, atol=1e-8, names=None):
    for name in names or one.names:
        np.testing.assert_allclose(other[name], one[name], atol=atol, err_msg=name)


CHANGES_SIGN = "pelvis_list", "pelvis_rotation", "trunk_bending", "trunk_rotation", "neck_bending", "neck_rotation"


@pytest.mark.parametrize("arms", ["hanging", "T"])
def test_mirrored_motions_have_the_angles_of_the_other_side(arms):
    motion = moving(person(arms))
    one, other = joint_angles(motion), joint_angles(motion.mirrored())
    for name in one.names:
        partner = name.replace("left", "?").replace("right", "left").replace("?", "right")
        sign = -1.0 if name in CHANGES_SIGN else 1.0
        np.testing.assert_allclose(sign * other[partner], one[name], atol=1e-9, err_msg=name)


@pytest.mark.parametrize("order", ["XYZ", "xyz", "ZXY", "YXZ", "ZYX"])
def test_the_order_of_euler_angles_plays_no_part(order):
    motion = moving(person("T"))
    assert_same(joint_angles(motion), joint_angles(motion.to_euler(order)), 1e-9)


def test_the_axes_of_a_file_play_no_part(tmp_path):
    """Written as BVH and read back; and with joints whose axes at rest are any."""
    motion = moving(person("T"))
    angles = joint_angles(motion)
    save_bvh(tmp_path / "m.bvh", motion)
    read = load_bvh(tmp_path / "m.bvh")
    assert_same(angles, joint_angles(read), 1e-5)
    skeleton, rng = motion.skeleton, np.random.default_rng(1)
    axes = [Rotation.identity(), *Rotation.random(skeleton.n_joints, rng=rng)]
    bones, columns = [], []
    for j, bone in enumerate(skeleton.bones):
        before, own = axes[skeleton.parents[j] + 1], axes[j + 1]
        rest = (before.inv() * own).as_matrix()
        bones.append(Bone(bone.name, bone.parent, before.inv().apply(bone.offset), "rotvec", rest))
        turned = Rotation.from_rotvec(motion.angles[:, 3 * j : 3 * j + 3])
        columns.append((own.inv() * turned * own).as_rotvec())
    other = replace(motion, skeleton=Skeleton(bones, offset_frame="parent"), angles=np.concatenate(columns, axis=1))
    assert_same(angles, joint_angles(other), 1e-9)


@pytest.mark.parametrize("up", ["x", "z"])
def test_another_axis_up_changes_nothing(up):
    """The whole world is turned with the person: root, positions, and the skeleton at rest."""
    motion = moving(person("T"))
    turn = Rotation.from_matrix(np.roll(np.eye(3), {"x": -1, "z": 1}[up], axis=0))
    assert turn.apply(Y) @ np.eye(3)["xyz".index(up)] == pytest.approx(1.0)
    bones = [bone._replace(offset=tuple(turn.apply(bone.offset))) for bone in motion.skeleton.bones]
    columns = [turn.apply(motion.angles[:, i : i + 3]) for i in range(0, motion.skeleton.n_dofs, 3)]
    root = turn * Rotation.from_euler("xyz", motion.root_angles) * turn.inv()
    other = Motion(
        Skeleton(bones, offset_frame="parent"),
        np.concatenate(columns, axis=1),
        30.0,
        root_angles=root.as_euler("xyz"),
        up=up,
    )
    assert_same(joint_angles(motion), joint_angles(other), 1e-9)


def refitted(motion):
    """The poses that inverse kinematics finds at the positions of all joints."""
    positions = forward_kinematics(motion.angles, motion.skeleton)
    root = Rotation.from_euler(motion.root_axes, motion.root_angles)
    world = np.stack([root.apply(positions[:, j]) for j in range(positions.shape[1])], axis=1)
    return inverse_kinematics(world + motion.root_positions[:, None], motion.skeleton).to_motion(30.0, motion.up)


def hinged(seed=0):
    """A motion whose knees and elbows are hinges, as far bent as people bend them."""
    motion = moving(person("T"), seed=seed)
    angles = motion.angles.copy()
    t = np.arange(len(motion))
    for side, s in (("Left", 1.0), ("Right", -1.0)):
        for name, axis in (("Leg", X), ("ForeArm", -Y * s)):
            i = motion.skeleton.dof_names.index(f"{side}{name}_rotvec_x")
            angles[:, i : i + 3] = (0.9 + 0.5 * np.sin(0.2 * t))[:, None] * axis
    return replace(motion, angles=angles)


def test_poses_fitted_to_positions_have_the_angles_that_positions_show():
    motion = hinged()
    recorded, found = joint_angles(motion), joint_angles(refitted(motion))
    assert not recorded.missing
    shown = [name for name in found.names if name not in found.missing]
    assert_same(recorded, found, 1e-4, [name for name in shown if "ankle" not in name])
    assert {name for name in found.missing if "hip" in name or "shoulder" in name} == set()
    expected = {f"{joint}_{angle}" for joint in ("knee", "elbow") for angle in ("adduction",)}
    expected |= {"knee_rotation", "elbow_pronation", "wrist_flexion", "wrist_ulnar_deviation", "wrist_rotation"}
    expected |= {"ankle_inversion", "ankle_rotation"}
    lacking = {name.rpartition("_")[0] for name in found.missing if name.endswith(("left", "right"))}
    assert lacking == expected
    assert "neck_rotation" in found.missing


def test_a_straight_limb_does_not_show_how_it_is_rotated():
    """Inverse kinematics makes something up; flexion and adduction are there."""
    skeleton = person()
    straight = pose(skeleton, LeftUpLeg=about(-X, 30) * about(Y, 25), RightUpLeg=about(-X, 30))
    bent = pose(skeleton, LeftUpLeg=about(-X, 30) * about(Y, 25), LeftLeg=about(X, 40))
    found = joint_angles(refitted(straight))
    assert np.isnan(value(found, "hip_rotation_left"))
    assert "bent by 15° and more" in found.missing["hip_rotation_left"]
    assert value(found, "hip_flexion_left") == pytest.approx(value(joint_angles(straight), "hip_flexion_left"))
    assert value(found, "knee_flexion_left") == pytest.approx(0.0, abs=1e-5)
    assert value(joint_angles(refitted(bent)), "hip_rotation_left") == pytest.approx(-25.0, abs=1e-5)
    assert value(joint_angles(refitted(bent)), "knee_flexion_left") == pytest.approx(40.0, abs=1e-5)


def test_hyperextended_knees_are_negative():
    found = joint_angles(refitted(pose(person(), LeftLeg=about(X, -4))))
    assert value(found, "knee_flexion_left") == pytest.approx(-4.0, abs=1e-5)


def test_a_standing_pose_is_zero():
    motion = moving(person("T"), size=0.3)
    standing = pose(motion.skeleton, LeftArm=about(-Z, 80), RightArm=about(Z, 80), LeftLeg=about(X, 8))
    still = Motion.concatenate([standing] * 3)
    found = joint_angles(Motion.concatenate([still, replace(motion, root_angles=None)]), zero=0)
    assert found.zero == "frame 0"
    at_zero = {name: found[name][0] for name in found.names if not name.startswith("shoulder_plane")}
    np.testing.assert_allclose(list(at_zero.values()), 0.0, atol=1e-9)
    same = joint_angles(motion, zero=still)
    assert same.zero == "mean of 3 standing frames"
    bent = joint_angles(pose(motion.skeleton, LeftLeg=about(X, 30)), zero=still)
    assert value(bent, "knee_flexion_left") == pytest.approx(22.0)
    # Relative rotations do not depend on the rest pose: the same from a skeleton that hangs its arms.
    last = joint_angles(standing, zero=pose(motion.skeleton, LeftArm=about(-Z, 90), RightArm=about(Z, 90)))
    assert value(last, "shoulder_adduction_left") == pytest.approx(-10.0)


@pytest.mark.parametrize(
    ("zero", "match"),
    [
        (99, r"zero is frame 99 of a motion of 40 frames, 0 to 39"),
        ("first", r"zero must be the number of a frame, a Motion or None, got str"),
        (True, r"got bool"),
        ("other", r"another skeleton than the motion: fit one to both recordings"),
        ("lying", r"nobody stands in zero, frame 0: its .* is away from down by 90°"),
        ("z", r"zero has up='z', but the motion up='y'"),
        ("empty", r"zero has no frames"),
    ],
)
def test_what_is_no_zero_is_refused(zero, match):
    motion = moving(person("T"))
    if zero == "other":
        zero = pose(person())
    elif zero == "lying":
        motion, zero = replace(motion, root_angles=np.full((40, 3), [np.pi / 2, 0.0, 0.0])), 0
        motion = replace(motion, angles=np.zeros_like(motion.angles))
    elif zero == "z":
        zero = replace(pose(person("T")), up="z")
    elif zero == "empty":
        zero = motion[:0]
    with pytest.raises((ValueError, TypeError), match=match):
        joint_angles(motion, zero=zero)


def test_a_recording_that_moves_is_no_standing_pose():
    skeleton = person("hanging")
    nodding = pose(skeleton, Head=Rotation.from_rotvec(np.outer(np.linspace(-0.4, 0.4, 20), X)))
    with pytest.warns(UserWarning, match="the recording zero is no standing person: its head rotates by"):
        joint_angles(nodding, zero=nodding)


def squat(knees):
    """Rotations of both legs that bend the knees by so many degrees and keep the ankles below the hips."""
    return {
        f"{side}{name}": about(X, by)
        for side in ("Left", "Right")
        for name, by in (("UpLeg", -knees / 2), ("Leg", knees))
    }


LEGS_THAT_DO_NOT_STAND = {
    "squat": (squat(100), "its left knee is bent by 100°"),
    "a shallow squat": (squat(30), "its left knee is bent by 30°"),
    "lunge": ({"LeftUpLeg": about(X, -20), "RightUpLeg": about(X, 20)}, "its thighs are apart by 40°"),
    "spread": ({"LeftUpLeg": about(Z, 14), "RightUpLeg": about(-Z, 14)}, "its thighs are apart by 28°"),
    "a raised knee": ({"RightUpLeg": about(X, -40), "RightLeg": about(X, 40)}, "its right thigh is .* by 40°"),
    "bowing": ({"Spine": about(X, 60)}, "its trunk leans by 30°"),
    "leaning": ({"Hips": about(X, 30)}, "its left thigh is away from down by 30°"),
}


@pytest.mark.parametrize("name", LEGS_THAT_DO_NOT_STAND)
@pytest.mark.parametrize("arms", ["hanging", "T"])
def test_legs_and_trunk_that_do_not_stand_are_no_zero(name, arms):
    rotations, words = LEGS_THAT_DO_NOT_STAND[name]
    bent = pose(person(arms), **rotations)
    with pytest.raises(ValueError, match=rf"nobody stands in zero, frame 0: .*{words}.*; expected at most 25°\."):
        joint_angles(bent, zero=0)
    with pytest.raises(
        ValueError, match=r"upright with hanging arms.*; or leave zero out, as somebody stands in the rest"
    ):
        joint_angles(bent, zero=bent)


def test_a_bend_of_legs_is_an_error_from_25_degrees_and_a_warning_from_12():
    skeleton = person()
    for degrees in (0, 5, 11.9, 12.1, 24.9, 25.1, 60):
        bent = pose(skeleton, LeftLeg=about(X, degrees))
        if degrees > 25:
            with pytest.raises(ValueError, match=f"its left knee is bent by {degrees:.0f}°"):
                joint_angles(bent, zero=0)
        elif degrees > 12:
            with pytest.warns(
                UserWarning, match=f"in zero, frame 0, .*its left knee is bent by {degrees:.0f}°.*lack as"
            ):
                joint_angles(bent, zero=0)
        else:
            joint_angles(bent, zero=0)


@pytest.mark.parametrize(
    ("dof", "words"),
    [
        ("left_foot_rx", "left foot"),
        ("left_foot_rz", "left foot"),
        ("abdomen_ry", "trunk"),
        ("neck_ry", "head"),
        ("right_thigh_ry", "right thigh"),
    ],
)
def test_feet_and_twists_that_differ_from_the_rest_pose_are_a_warning(dof, words):
    """Lines of limbs do not show them, and all angles of the joint would lack as much."""
    person = humanoid()
    poses = np.zeros((2, person.n_dofs))
    poses[:, person.dof_names.index(dof)] = np.radians([20, 40])
    joint_angles(Motion(person, poses, 30), zero=0)
    with pytest.warns(UserWarning, match=rf"in zero, frame 1, its {words} is rotated by 40° from the rest pose"):
        found = joint_angles(Motion(person, poses, 30), zero=1)
    assert np.nanmax(np.abs(found.degrees[0])) == pytest.approx(20.0, abs=0.5)


def test_a_walk_whose_mean_stands_is_no_zero():
    """The mean of legs that swing is straight; in no frame does anybody stand."""
    skeleton = person()
    swing = np.degrees(0.6) * np.sin(np.linspace(0, 4 * np.pi, 60, endpoint=False))
    legs = {"LeftUpLeg": swing, "RightUpLeg": -swing}
    walking = pose(skeleton, **{name: Rotation.from_rotvec(np.outer(np.radians(by), X)) for name, by in legs.items()})
    with pytest.raises(
        ValueError, match=r"in zero, a recording of 60 frames: in a tenth of them at least its thighs are"
    ):
        joint_angles(walking, zero=walking)
    turning = pose(skeleton, Hips=Rotation.from_rotvec(np.outer(np.linspace(0, 2, 60), Y)))
    with pytest.raises(ValueError, match=r"at least the line of its hips is rotated by 5\d°"):
        joint_angles(turning, zero=turning)


def test_a_recording_may_have_some_frames_that_do_not_stand():
    skeleton = person()
    step = pose(skeleton, LeftUpLeg=about(X, -40))
    still = pose(skeleton)
    with pytest.warns(UserWarning, match="its left_thigh rotates by"):
        joint_angles(still, zero=Motion.concatenate([still] * 19 + [step]))
    with pytest.raises(ValueError, match="nobody stands"):
        joint_angles(still, zero=Motion.concatenate([still] * 8 + [step] * 2))


@pytest.mark.parametrize("refit", [False, True])
@pytest.mark.parametrize(
    ("rotations", "joints", "words"),
    [
        ({"LeftArm": about(Z, 90), "RightArm": about(-Z, 90)}, ("shoulder", "elbow"), "left upper arm .* by 90°"),
        ({"LeftArm": about(Z, 40), "RightArm": about(-Z, 40)}, ("shoulder", "elbow"), "left upper arm .* by 40°"),
        ({"LeftArm": about(-X, 170), "RightArm": about(-X, 170)}, ("shoulder", "elbow"), "left upper arm .* by 170°"),
        ({"LeftForeArm": about(-X, 90), "RightForeArm": about(-X, 90)}, ("elbow",), "left elbow is bent by 90°"),
    ],
)
def test_arms_that_do_not_hang_have_no_zero_and_legs_have(rotations, joints, words, refit):
    """In a T-pose the line of an arm is parallel to the axis of its flexion: nothing is divided by zero."""
    motion = hinged()
    zero = pose(motion.skeleton, **{side + "Arm": about(-Z * s, 90) for side, s in (("Left", 1), ("Right", -1))})
    hanging = joint_angles(motion, zero=zero)
    arms = {
        name: rotation * about(-Z * (1 if "Left" in name else -1), 90 * ("Fore" not in name))
        for name, rotation in rotations.items()
    }
    if joints == ("elbow",):
        arms = {f"{side}Arm": about(-Z * s, 90) for side, s in (("Left", 1), ("Right", -1))}
        arms |= {f"{side}ForeArm": about(-Y * s, 90) for side, s in (("Left", 1), ("Right", -1))}
    off = pose(motion.skeleton, **arms)
    if refit:
        motion, off = refitted(motion), refitted(off)
        hanging = joint_angles(motion, zero=refitted(zero))
    with pytest.warns(UserWarning, match=rf"arms do not hang in zero, .*{words}.* are NaN: pass zero=") as caught:
        found = joint_angles(motion, zero=off)
    assert len(caught) == 1
    for name in hanging.names:
        joint = name.partition("_")[0]
        if joint in joints:
            assert np.isnan(found[name]).all(), name
            assert found.missing[name].startswith("in zero its ")
        elif joint not in ("shoulder", "elbow", "wrist"):
            np.testing.assert_allclose(found[name], hanging[name], atol=1e-9 if not refit else 1e-4, err_msg=name)
    assert joints != ("elbow",) or np.isfinite(found["shoulder_elevation_left"]).all()


def test_one_arm_that_does_not_hang_leaves_the_other():
    skeleton = person()
    raised = pose(skeleton, RightArm=about(-Z, 90))
    with pytest.warns(UserWarning, match=r"angles of right elbow, right shoulder are NaN"):
        found = joint_angles(raised, zero=0)
    assert value(found, "shoulder_flexion_left") == pytest.approx(0.0)
    assert np.isnan(value(found, "shoulder_flexion_right"))
    assert value(found, "wrist_flexion_right") == pytest.approx(0.0)


def test_a_rest_pose_with_raised_arms_does_not_show_how_they_are_rotated():
    """Lowered to the side or to the front, the elbow would bend backward or forward."""
    skeleton = person()
    bones = [
        bone._replace(offset=-np.asarray(bone.offset))
        if bone.name[4:].strip("t") in ("ForeArm", "Hand", "Hand_end")
        else bone
        for bone in skeleton.bones
    ]
    found = joint_angles(moving(Skeleton(bones, offset_frame="parent")))
    for side in SIDES:
        for name in ("shoulder_rotation", "elbow_flexion", "elbow_adduction", "elbow_pronation"):
            assert f"in which the {side} arm points up" in found.missing[f"{name}_{side}"]
        assert np.isfinite(found[f"shoulder_elevation_{side}"]).all()


def test_another_axis_up_than_the_person_stands_along_is_noticed():
    wrong = replace(moving(person(), size=0.1), up="z")
    words = r"motion\.up is 'z', but in nearly all frames the pose stands along y; if y points up, read the file with"
    with pytest.warns(
        UserWarning, match=rf"{words} up='y'. Else the person lies .* tilt, list and rotation of the pelvis"
    ):
        joint_angles(wrong)
    with pytest.raises(ValueError, match=rf"is away from down by 90°.* And {words}"):
        joint_angles(wrong, zero=replace(pose(person()), up="z"))


def test_a_rest_pose_that_does_not_stand_is_refused():
    """All bones but those to the hips along x, as in some files."""
    skeleton = person("T")
    along = [
        bone._replace(offset=(float(np.linalg.norm(bone.offset)), 0.0, 0.0))
        if bone.parent and "UpLeg" not in bone.name
        else bone
        for bone in skeleton.bones
    ]
    with pytest.raises(ValueError, match=r"nobody stands in the rest pose .* pass zero=, a frame of the motion"):
        joint_angles(moving(Skeleton(along, offset_frame="parent")))
    one = [bone._replace(offset=np.zeros(3)) if "UpLeg" in bone.name else bone for bone in skeleton.bones]
    with pytest.raises(ValueError, match=r"the pelvis of this skeleton has no length at angle zero: expected hips"):
        joint_angles(moving(Skeleton(one, offset_frame="parent")), zero=0)


def test_a_motion_without_frames_is_refused():
    motion = Motion(humanoid(), np.zeros((3, 42)), 30)
    with pytest.raises(ValueError, match="at least one frame, got a motion of 0 frames"):
        joint_angles(motion[:0])


def test_exchanged_sides_are_noticed():
    skeleton = person("T")

    def other(name):
        if name is None:
            return None
        return name.replace("Left", "?").replace("Right", "Left").replace("?", "Right")

    bones = [bone._replace(name=other(bone.name), parent=other(bone.parent)) for bone in skeleton.bones]
    words = "its toes point backward, so that left and right are exchanged, .*So exchange left and right in joints=; "
    with pytest.raises(ValueError, match=words):
        joint_angles(moving(Skeleton(bones, offset_frame="parent")))


def test_joints_of_unknown_names_can_be_given():
    skeleton = person()
    letters = {name: f"joint{i}" for i, name in enumerate(skeleton.joint_names)}
    bones = [bone._replace(name=letters[bone.name], parent=letters.get(bone.parent)) for bone in skeleton.bones]
    motion = replace(moving(skeleton), skeleton=Skeleton(bones, offset_frame="parent"))
    with pytest.raises(ValueError, match=r"left_hip, left_knee, .* not known by their names; its joints are joint0"):
        joint_angles(motion)
    given = {"hip": "UpLeg", "knee": "Leg", "ankle": "Foot", "toe": "Toe", "shoulder": "Arm", "elbow": "ForeArm"}
    joints = {f"{side}_{mark}": letters[side.capitalize() + name] for side in SIDES for mark, name in given.items()}
    found = joint_angles(motion, joints=joints)
    assert "the given joints" in repr(found)
    assert_same(joint_angles(moving(skeleton)), found, names=[n for n in found.names if "wrist" not in n])
    with pytest.raises(ValueError, match=r"joints\['left_knee'\] is 'joint999', which is no joint of the skeleton"):
        joint_angles(motion, joints=joints | {"left_knee": "joint999"})
    with pytest.raises(ValueError, match=r"joints has the landmark 'knee'; expected one of left_hip"):
        joint_angles(motion, joints={"knee": "joint1"})


@pytest.mark.parametrize(
    ("changed", "match"),
    [
        ({"left_knee": "LeftFoot", "left_ankle": "LeftLeg"}, "'LeftLeg', which does not come after it in the skeleton"),
        (
            {"left_knee": "LeftFoot"},
            "left_knee is 'LeftFoot' and left_ankle is 'LeftFoot' by its name: expected two joints",
        ),
        ({"left_knee": "RightLeg", "right_knee": "LeftLeg"}, "left_knee is 'RightLeg', which does not come after it"),
        ({"left_elbow": "RightForeArm", "right_elbow": "LeftForeArm"}, "'RightForeArm', which does not come after it"),
        ({"left_hip": "Hips"}, "left_hip is 'Hips' and right_hip is 'RightUpLeg' by its name, which comes after it"),
        (
            {"head": "LeftHandThumb"},
            "left_shoulder is 'LeftArm' by its name and head is 'LeftHandThumb', which comes after it",
        ),
    ],
)
def test_joints_that_cannot_be_those_of_a_person_are_refused(changed, match):
    with pytest.raises(ValueError, match=match):
        joint_angles(moving(person()), joints=changed)


LEG = {"hip": "UpLeg", "knee": "Leg", "ankle": "Foot", "toe": "Toe_end", "ball": "Toe"}
ARM = {"shoulder": "Arm", "elbow": "ForeArm", "wrist": "Hand", "hand": "Hand_end"}


def exchanged(names):
    """Joints whose left is the right."""
    other = {"left": "Right", "right": "Left"}
    return {f"{side}_{mark}": other[side] + name for side in SIDES for mark, name in names.items()}


def test_left_and_right_that_are_exchanged_by_hand_are_refused():
    skeleton = person()
    with pytest.raises(ValueError, match="the joints of the left arm are on the side of the right leg"):
        joint_angles(moving(skeleton), joints=exchanged(ARM))
    words = "toes point backward, so that left and right are exchanged, .*So exchange left and right in joints=; "
    with pytest.raises(ValueError, match=words) as caught:
        joint_angles(moving(skeleton), joints=exchanged(LEG | ARM))
    assert "zero=" not in str(caught.value)
    # Without feet names decide.
    no_feet = [bone for bone in skeleton.bones if "Toe" not in bone.name]
    both = {mark: name for mark, name in (LEG | ARM).items() if "Toe" not in name}
    with pytest.raises(ValueError, match=r"joints\['left_hip'\] is 'RightUpLeg', which by its name is on the right"):
        joint_angles(moving(Skeleton(no_feet, offset_frame="parent")), joints=exchanged(both))


def test_right_joints_by_hand_change_nothing():
    motion = moving(person())
    joints = {f"{side}_{mark}": side.capitalize() + name for side in SIDES for mark, name in (LEG | ARM).items()}
    assert_same(joint_angles(motion), joint_angles(motion, joints=joints))
    feet = {f"{side}_toe": f"{side.capitalize()}Toe" for side in SIDES}  # the ball, by its name
    assert_same(joint_angles(motion), joint_angles(motion, joints=feet))
    with pytest.raises(TypeError, match=r"joints must be a mapping of landmarks to names of joints.*, got list"):
        joint_angles(motion, joints=["LeftLeg"])


def test_what_is_no_motion_is_refused():
    with pytest.raises(TypeError, match=r"joint_angles needs a skpose\.Motion, got ndarray"):
        joint_angles(np.zeros((3, 42)))


def test_tables():
    pandas, polars = pytest.importorskip("pandas"), pytest.importorskip("polars")
    motion = moving(person())
    angles = joint_angles(motion)
    assert np.asarray(angles).shape == (40, len(angles.names))
    table = angles.to_pandas()
    assert isinstance(table, pandas.DataFrame)
    assert table.index.name == "time [s]"
    assert table.attrs["unit"] == "degrees"
    assert table.attrs["zero"] == "rest pose"
    np.testing.assert_array_equal(table["knee_flexion_left"], angles["knee_flexion_left"])
    with sklearn.config_context(transform_output="pandas"):
        pandas.testing.assert_frame_equal(joint_angles(motion), table)
    with sklearn.config_context(transform_output="polars"):
        frame = joint_angles(motion)
    assert isinstance(frame, polars.DataFrame)
    assert frame.columns == ["time [s]", *angles.names]
    np.testing.assert_array_equal(frame["time [s]"], motion.times)
    with pytest.raises(KeyError, match="there is no angle 'knee_angle_left'"):
        angles["knee_angle_left"]


def test_without_a_thumb_nobody_knows_where_the_palm_is():
    found = joint_angles(moving(person("T", thumb=False)))
    assert "no thumb" in found.missing["wrist_flexion_left"]
    assert "no thumb" in found.missing["elbow_pronation_left"]
    relative = joint_angles(moving(person("hanging", thumb=False)), zero=pose(person("hanging", thumb=False)))
    assert "elbow_pronation_left" not in relative.missing
    assert "wrist_flexion_left" in relative.missing


def test_segments_without_a_length_have_no_angles():
    """Such as a hand whose End Site is at the wrist."""
    skeleton = person()
    bones = [bone._replace(offset=np.zeros(3)) if bone.name == "LeftHand_end" else bone for bone in skeleton.bones]
    names = joint_angles(moving(Skeleton(bones, offset_frame="parent"))).names
    assert "wrist_flexion_right" in names
    assert "wrist_flexion_left" not in names


def test_joints_that_do_not_bend_have_no_angles():
    skeleton = person()
    bones = [bone._replace(dofs="") if bone.name.endswith("Hand") else bone for bone in skeleton.bones]
    found = joint_angles(Motion(rigid := Skeleton(bones, offset_frame="parent"), np.zeros((2, rigid.n_dofs)), 30.0))
    assert not [name for name in found.names if name.startswith("wrist")]


def test_the_humanoid_and_its_file_agree(tmp_path):
    """One is a skeleton of bones with names and own axes, the other of joints."""
    skeleton = humanoid()
    rng = np.random.default_rng(0)
    motion = Motion(skeleton, 0.2 * rng.normal(size=(5, skeleton.n_dofs)), 30.0)
    angles = joint_angles(motion)
    assert angles.rig == "humanoid"
    save_bvh(tmp_path / "m.bvh", motion)
    read = joint_angles(load_motion(tmp_path / "m.bvh"))
    assert_same(angles, read, 1e-5, [name for name in angles.names if name in read.names])


def unseen(motion, frames, *names):
    """A motion that was fitted to positions, of which some joints lack in some frames."""
    seen = np.ones((len(motion), motion.skeleton.n_joints), bool)
    seen[frames, [[motion.skeleton.joint_names.index(name)] for name in names]] = False
    return replace(motion, seen=seen)


def test_what_is_not_seen_is_nan_in_these_frames_alone():
    """A fit gives every joint an angle, also those without a position: they keep the pose of the frame before."""
    motion = refitted(moving(person()))
    whole, part = joint_angles(motion), joint_angles(unseen(motion, np.arange(10, 25), "LeftLeg", "LeftFoot"))
    lost = {f"{name}_left" for name in ("hip_flexion", "knee_flexion", "ankle_dorsiflexion")}
    assert whole.names == part.names
    for name in whole.names:
        new = np.isnan(part[name]) & ~np.isnan(whole[name])
        if name in lost:
            assert new[10:25].all()
            assert part.missing[name].endswith("positions of its points are not seen")
        elif not name.endswith("_left"):
            assert not new.any()
        assert not new[:10].any()
        assert not new[25:].any()
        known = ~np.isnan(part[name])
        np.testing.assert_array_equal(part[name][known], whole[name][known])


def test_frames_of_zero_that_do_not_show_all_have_no_part_in_it():
    motion = refitted(moving(person()))
    standing = refitted(pose(person()))
    zero = Motion.concatenate([standing] * 4)
    squat = zero.angles.copy()
    squat[2:] = motion.angles[20]
    wrong = unseen(replace(zero, angles=squat), np.arange(2, 4), "LeftLeg", "RightLeg")
    assert_same(joint_angles(motion, zero=zero[:2]), joint_angles(motion, zero=wrong))
    with pytest.raises(
        ValueError, match="does not show all of a person who stands: points of its left shank are in non"
    ):
        joint_angles(motion, zero=unseen(zero, np.arange(4), "LeftFoot"))
    hidden = joint_angles(motion, zero=unseen(zero, np.arange(4), "LeftForeArm"))
    assert np.isnan(hidden["elbow_flexion_left"]).all()
    assert "not seen in zero" in hidden.missing["elbow_flexion_left"]
    assert not np.isnan(hidden["elbow_flexion_right"]).any()


KINECT = {
    "spine": "lowerback",
    "shoulder_center": "thorax",
    "head": "head",
    **{f"{side}_{mark}": side[0] + name for side in SIDES for mark, name in {
        "shoulder": "clavicle", "elbow": "humerus", "wrist": "radius", "hand": "hand",
        "hip": "hipjoint", "knee": "femur", "ankle": "tibia", "foot": "foot",
    }.items()},
}  # fmt: skip


@pytest.mark.filterwarnings("ignore:zero is how the person of the layout:UserWarning")
def test_the_line_of_the_shoulders_shows_how_a_trunk_is_rotated_that_no_fixed_points_show(cmu):
    """Each shoulder of Kinect has a joint of its own: the spine that carries them rotates about itself as it likes."""
    motion = cmu.motions[0].resample(30)
    root = Rotation.from_euler(motion.root_axes, motion.root_angles)
    there = forward_kinematics(motion.angles, motion.skeleton)
    places = dict(zip(motion.skeleton.joint_names, there.transpose(1, 0, 2), strict=True))
    layout = layouts["kinect20"]
    places = [root.apply(places[KINECT[name]]) if name in KINECT else 0.0 * there[:, 0] for name in layout.names]
    positions = np.stack(places, axis=1) + motion.root_positions[:, None]
    skeleton = fit_skeleton(layout.keypoints(positions, 30), layout)
    whole = joint_angles(inverse_kinematics(layout.keypoints(positions, 30), skeleton).to_motion())
    recorded = joint_angles(motion)
    for name, most in {"trunk_rotation": 0.5, "trunk_bending": 1.0, "hip_flexion_left": 0.2}.items():
        assert (whole[name] - recorded[name]).std() < most
    positions[10:20, layout.names.index("left_hand")] = np.nan
    part = joint_angles(inverse_kinematics(layout.keypoints(positions, 30), skeleton).to_motion())
    for name in ("trunk_rotation", "trunk_bending", "neck_bending", "shoulder_flexion_left", "shoulder_flexion_right"):
        np.testing.assert_allclose(part[name], whole[name], atol=0.1, err_msg=name)


def test_zero_that_does_not_show_the_trunk_gives_none_to_shoulders_and_trunk():
    motion, standing = refitted(moving(person())), refitted(pose(person()))
    upper = [name for name in motion.skeleton.joint_names if any(part in name for part in ("Spine", "Neck", "Arm"))]
    hidden = joint_angles(motion, zero=unseen(standing, np.arange(1), *upper))
    for name in ("trunk_rotation", "shoulder_flexion_left", "shoulder_flexion_right", "elbow_flexion_left"):
        assert np.isnan(hidden[name]).all()
        assert "not seen in zero" in hidden.missing[name]
    assert not np.isnan(hidden["knee_flexion_left"]).any()


def test_a_zero_that_shows_only_the_line_of_a_limb_has_no_zero_of_its_rotation():
    """The motion shows how the pelvis is rotated about the line of the hips, by the spine, and zero does not.

    Where the trunk alone lacks the spine, it shows where it is, by three other points.
    """
    motion, standing = refitted(moving(person())), refitted(pose(person()))
    lines = find_seen(standing, find_segments(standing.skeleton, find_person(standing.skeleton, None))).lines
    assert "pelvis" not in lines
    by_trunk = joint_angles(motion, zero=unseen(standing, np.arange(1), "Spine", "Hips"))
    assert_same(joint_angles(motion, zero=standing), by_trunk, names=["hip_flexion_left"])
    hidden = joint_angles(motion, zero=unseen(standing, np.arange(1), "Spine", "Hips", "Neck"))
    assert np.isnan(hidden["hip_flexion_left"]).all()
    assert "not seen in zero" in hidden.missing["hip_flexion_left"]


def test_legs_alone_have_knees_and_no_hips():
    """Without shoulders positions do not show how a pelvis leans that is a line."""
    points = ["left_hip", "right_hip", *(f"{side}_{name}" for side in SIDES for name in ("knee", "ankle"))]
    parents = {"left_hip": None, "right_hip": "left_hip"}
    parents |= {f"{side}_{b}": f"{side}_{a}" for side in SIDES for a, b in (("hip", "knee"), ("knee", "ankle"))}
    layout = Layout("legs", names=points, parents=parents, rigid={"right_hip"})
    places = {"left_hip": (0.1, 0.9, 0), "right_hip": (-0.1, 0.9, 0)}
    for side, x in (("left", 0.1), ("right", -0.1)):
        places |= {f"{side}_knee": (x, 0.5, 0.0), f"{side}_ankle": (x, 0.1, 0.0)}
    standing = np.array([places[name] for name in points])
    bent = standing.copy()
    bent[points.index("left_ankle")] = (0.1, 0.5 - 0.4 * np.cos(1.0), -0.4 * np.sin(1.0))
    motion = inverse_kinematics(layout.keypoints([standing, bent], 10), fit_skeleton([[standing, bent]], layout))
    with pytest.warns(UserWarning, match="positions show of the pelvis only the line of the hips"):
        angles = joint_angles(motion.to_motion(), zero=0)
    assert angles["knee_flexion_left"] == pytest.approx([0.0, np.degrees(1.0)], abs=1e-4)
    assert angles["knee_flexion_right"] == pytest.approx([0.0, 0.0], abs=1e-4)
    assert np.isnan(angles["hip_flexion_left"]).all()
    assert np.isnan(angles["pelvis_list"]).all()


def test_the_rest_pose_of_a_layout_is_not_how_a_person_stands():
    """A skeleton that is fitted to points has the lengths of a person, and the rest pose of its layout."""
    middle = {"hip_center": (0, 1.0, 0), "spine": (0, 1.1, 0), "shoulder_center": (0, 1.45, 0), "head": (0, 1.65, 0)}
    left = {"shoulder": (0.18, 1.4), "elbow": (0.2, 1.1), "wrist": (0.22, 0.85), "hand": (0.22, 0.78)}
    left |= {"hip": (0.1, 0.95), "knee": (0.1, 0.52), "ankle": (0.1, 0.1), "foot": (0.11, 0.09, 0.14)}
    points = {name: np.array(place) for name, place in middle.items()}
    for name, (x, y, *z) in left.items():
        points |= {f"left_{name}": np.array([x, y, *(z or [0])]), f"right_{name}": np.array([-x, y, *(z or [0])])}
    layout = layouts["kinect20"]
    standing = layout.keypoints([[points[name] for name in layout.names]] * 3, frame_rate=10)
    skeleton = fit_skeleton(standing, layout)
    motion = inverse_kinematics(standing, skeleton).to_motion()
    with pytest.warns(UserWarning, match="zero is how the person of the layout stands, to which the skeleton was fit"):
        angles = joint_angles(motion)
    assert angles.zero == "rest pose of the layout"
    assert abs(angles["ankle_dorsiflexion_left"]).min() > 5.0
    angles = joint_angles(motion, zero=0)  # no warning
    assert angles["ankle_dorsiflexion_left"] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.slow
def test_markers_give_the_angles_of_opensim(opensim_folder):
    """Hips and knees of a person who walks and squats; the knee as well as the plain angle between three markers."""
    layout = layouts["opencap_mocap55"]

    def keypoints(name):
        return layout.keypoints(load_trc(opensim_folder / f"{name}.trc"), absent="unseen")

    standing = keypoints("static1")
    skeleton = fit_skeleton(standing, layout)
    zero = inverse_kinematics(standing, skeleton).to_motion()
    for name in ("walking1", "squats1"):
        given = keypoints(name)
        with pytest.warns(UserWarning, match="its right elbow is bent by 35°"):
            angles = joint_angles(inverse_kinematics(given, skeleton).to_motion(), zero=zero)
        text = (opensim_folder / f"{name}_ik.mot").read_text().partition("endheader")[2].strip().splitlines()
        columns = text[0].split()
        reference = np.degrees(np.loadtxt(text[1:]))
        for side in SIDES:
            letter = side[0]
            hip, knee, ankle = (
                given.positions[:, given.names.index(f"{letter.upper()}_{mark}")] for mark in ("HJC", "knee", "ankle")
            )
            thigh, shank = hip - knee, ankle - knee
            thigh, shank = (each / np.linalg.norm(each, axis=1, keepdims=True) for each in (thigh, shank))
            plain = 180.0 - np.degrees(np.arccos((thigh * shank).sum(axis=1)))
            hip_theirs, knee_theirs = (
                reference[:, columns.index(f"{mark}_{letter}")] for mark in ("hip_flexion", "knee_angle")
            )
            assert np.corrcoef(angles[f"hip_flexion_{side}"], hip_theirs)[0, 1] > 0.998
            assert (angles[f"hip_flexion_{side}"] - hip_theirs).std() < 2.0
            ours, seen = np.corrcoef(angles[f"knee_flexion_{side}"], knee_theirs)[0, 1], np.isfinite(plain)
            assert ours > np.corrcoef(plain[seen], knee_theirs[seen])[0, 1] > 0.99
            assert (angles[f"knee_flexion_{side}"] - knee_theirs).std() < 3.5
        assert np.corrcoef(angles["pelvis_rotation"], reference[:, columns.index("pelvis_rotation")])[0, 1] > 0.8


def test_walks_are_within_the_norm(cmu):
    """Perry (1992): the knee bends to about 60° in swing, at about 70 % of the cycle, and the hip moves through 40°."""
    for motion in cmu[cmu.actions == "walk"].motions[:3]:
        angles, events = joint_angles(motion), gait_events(motion)
        assert len(events.strides)
        for first, _, last in events.strides:
            side, start, stop = events.feet[first], events.frames[first], events.frames[last]
            knee, hip = (angles[f"{name}_{side}"][start : stop + 1] for name in ("knee_flexion", "hip_flexion"))
            assert 50.0 < knee.max() < 80.0
            assert 0.6 < knee.argmax() / (stop - start) < 0.85
            assert 35.0 < np.ptp(hip) < 80.0
            assert hip.argmin() / (stop - start) == pytest.approx(0.55, abs=0.12)
