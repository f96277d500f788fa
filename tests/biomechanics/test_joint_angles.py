"""Joint angles: signs, zero, missing values, and comparison with OpenSim."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton, inverse_kinematics
from skpose.biomechanics import gait_events, joint_angles
from skpose.io import load_amass, load_trc
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


@pytest.mark.parametrize("arms", ["hanging", "T"])
@pytest.mark.parametrize("spread", [0.0, 0.3])
def test_hanging_limbs_are_at_zero_in_any_rest_pose(arms, spread):
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
def test_the_order_of_euler_angles_has_no_effect(order):
    motion = moving(person("T"))
    assert_same(joint_angles(motion), joint_angles(motion.to_euler(order)), 1e-9)


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
        (99, "zero is frame 99"),
        ("first", "got str"),
        (True, "got bool"),
        ("other", "zero must have"),
        ("lying", "not upright"),
    ],
)
def test_invalid_zero_is_refused(zero, match):
    motion = moving(person("T"))
    if zero == "other":
        zero = pose(person())
    elif zero == "lying":
        motion, zero = replace(motion, root_angles=np.full((40, 3), [np.pi / 2, 0.0, 0.0])), 0
        motion = replace(motion, angles=np.zeros_like(motion.angles))
    with pytest.raises((ValueError, TypeError), match=match):
        joint_angles(motion, zero=zero)


def test_bent_knees_in_zero_warn_or_raise():
    skeleton = person()
    for degrees in (0, 11.9, 12.1, 24.9, 25.1):
        bent = pose(skeleton, LeftLeg=about(X, degrees))
        if degrees > 25:
            with pytest.raises(ValueError, match=f"its left knee is bent by {degrees:.0f}°"):
                joint_angles(bent, zero=0)
        elif degrees > 12:
            with pytest.warns(UserWarning, match=f"its left knee is bent by {degrees:.0f}°"):
                joint_angles(bent, zero=0)
        else:
            joint_angles(bent, zero=0)


@pytest.mark.parametrize(("tilt", "left"), [(0.0, 1.0), (12.0, 1.0), (12.0, -1.0)])
def test_hips_are_flexed_from_the_plane_of_the_pelvis_markers(tilt, left):
    """As in Plug-in Gait: of a person who stands with a tilted pelvis, by the tilt. Exchanged sides keep it upright."""
    forward = Rotation.from_euler("x", tilt, degrees=True)
    pelvis = {"ASIS": (0.12, 0.0, 0.1), "PSIS": (0.05, 0.0, -0.1), "hip": (0.09, -0.08, 0.0)}
    points = {"pelvis": np.zeros(3), "thorax": np.array([0.0, 0.4, 0.0])}
    for side, sign in zip(SIDES, (left, -left), strict=True):
        points |= {f"{side}_{name}": forward.apply(place) * [sign, 1.0, 1.0] for name, place in pelvis.items()}
        knee = points[f"{side}_hip"] - [0.0, 0.42, 0.0]
        points |= {f"{side}_knee": knee, f"{side}_ankle": knee - [0.0, 0.4, 0.0]}
    parents = dict.fromkeys(points, "pelvis")
    for side in SIDES:
        parents |= {f"{side}_knee": f"{side}_hip", f"{side}_ankle": f"{side}_knee"}
    rigid = [name for name in points if name.endswith(("ASIS", "PSIS", "hip"))]
    layout = Layout("hips", points, parents | {"pelvis": None}, rigid=rigid)
    seen = layout.keypoints(np.repeat([np.stack([*points.values()])], 3, axis=0), frame_rate=30)
    motion = inverse_kinematics(seen, fit_skeleton(seen, layout)).to_motion()
    with pytest.warns(UserWarning, match="rest pose of the layout"):
        angles = joint_angles(motion)
    for side in SIDES:
        np.testing.assert_allclose(angles[f"hip_flexion_{side}"], left * tilt, atol=0.01)


def test_joints_of_unknown_names_can_be_given():
    skeleton = person()
    letters = {name: f"joint{i}" for i, name in enumerate(skeleton.joint_names)}
    bones = [bone._replace(name=letters[bone.name], parent=letters.get(bone.parent)) for bone in skeleton.bones]
    motion = replace(moving(skeleton), skeleton=Skeleton(bones, offset_frame="parent"))
    with pytest.raises(ValueError, match=r"left_hip, left_knee, .* not found"):
        joint_angles(motion)
    given = {"hip": "UpLeg", "knee": "Leg", "ankle": "Foot", "toe": "Toe", "shoulder": "Arm", "elbow": "ForeArm"}
    joints = {f"{side}_{mark}": letters[side.capitalize() + name] for side in SIDES for mark, name in given.items()}
    found = joint_angles(motion, joints=joints)
    assert_same(joint_angles(moving(skeleton)), found, names=[n for n in found.names if "wrist" not in n])
    travelling = replace(motion, root_positions=np.linspace([0, 0.9, 0], [0, 0.9, 1], len(motion)))
    assert gait_events(travelling, joints=joints).joints["left_toe"] == joints["left_toe"]  # by the same landmarks
    with pytest.raises(ValueError, match="joint999"):
        joint_angles(motion, joints=joints | {"left_knee": "joint999"})
    with pytest.raises(ValueError, match="unknown landmark 'knee'"):
        joint_angles(motion, joints={"knee": "joint1"})


@pytest.mark.parametrize(
    ("changed", "match"),
    [
        ({"left_knee": "LeftFoot", "left_ankle": "LeftLeg"}, "'LeftLeg' does not come after 'LeftFoot'"),
        ({"left_elbow": "RightForeArm", "right_elbow": "LeftForeArm"}, "'RightForeArm' does not come after 'LeftArm'"),
        ({"left_hip": "Hips"}, "comes after an arm or a leg"),
        ({"head": "LeftArm"}, "one joint"),
    ],
)
def test_impossible_joints_are_refused(changed, match):
    with pytest.raises(ValueError, match=match):
        joint_angles(moving(person()), joints=changed)


def test_tables():
    motion = moving(person())
    angles = joint_angles(motion)
    assert np.asarray(angles).shape == (40, len(angles.names))
    table = angles.to_pandas()
    assert table.index.name == "time [s]"
    assert table.attrs["zero"] == "rest pose"
    np.testing.assert_array_equal(table["knee_flexion_left [deg]"], angles["knee_flexion_left"])
    with pytest.raises(KeyError, match="there is no angle 'knee_angle_left'"):
        angles["knee_angle_left"]


def unseen(motion, frames, *names):
    """A motion that was fitted to positions, of which some joints lack in some frames."""
    seen = np.ones((len(motion), motion.skeleton.n_joints), bool)
    seen[frames, [[motion.skeleton.joint_names.index(name)] for name in names]] = False
    return replace(motion, seen=seen)


def test_unseen_segments_are_nan_in_their_frames():
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


@pytest.mark.filterwarnings("ignore:bones have the lengths of a person of mean height:UserWarning")
def test_positions_do_not_show_the_rotation_of_a_head_without_a_point_beyond_it(tmp_path):
    """SMPL's skeleton ends at the joint of the head."""
    np.savez(tmp_path / "stand.npz", poses=np.zeros((3, 72)), trans=np.zeros((3, 3)), mocap_framerate=30.0)
    standing = load_amass(tmp_path / "stand.npz", up="y")
    fitted = inverse_kinematics(standing.to_keypoints(), standing.skeleton).to_motion()
    angles = joint_angles(fitted)
    assert np.isnan(angles["neck_extension"]).all()
    assert "head" in angles.missing["neck_extension"]
    np.testing.assert_allclose(angles["knee_flexion_left"], joint_angles(standing)["knee_flexion_left"], atol=1e-3)
