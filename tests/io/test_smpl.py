"""SMPL in and out: the files of other programs against a slow forward kinematics, and people of other rigs on SMPL."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from test_amass import PARENTS, joints_of, model_arrays, positions_of, world_positions

from skpose.biomechanics import joint_angles
from skpose.datasets import make_gait
from skpose.io import MocapFormatError, load_bvh, load_keypoints, load_motion, save_bvh, save_smpl
from skpose.keypoints import fit_skeleton, layouts
from skpose.kinematics import inverse_kinematics

N = 7
RNG = np.random.default_rng(0)
POSES = {width: RNG.normal(scale=0.5, size=(N, width)) for width in (66, 72, 156, 165)}
POSES |= {width: np.hstack([np.tile([0.1, 0.2, 0.0], (N, 1)), poses[:, 3:]]) for width, poses in POSES.items()}  # y up
TRANS = RNG.normal(size=(N, 3))
MEAN = pytest.mark.filterwarnings("ignore:bones have the lengths of a person of mean height")
POSE = POSES[66]
ROOT, BODY = POSE[:, :3], POSE[:, 3:]
X = POSES[165]
HANDS = {"left_hand_pose": X[:, 75:120], "right_hand_pose": X[:, 120:]}


def matrices(poses):
    return Rotation.from_rotvec(poses.reshape(-1, 3)).as_matrix().reshape(len(poses), -1, 3, 3)


def motion_x():
    table = np.zeros((N, 322))
    table[:, :66], table[:, 66:156], table[:, 156:159] = X[:, :66], X[:, 75:], X[:, 66:69]
    table[:, 309:312] = TRANS
    return table


def without_eyes():
    poses = X.copy()
    poses[:, 69:75] = 0.0
    return poses


EASYMOCAP = {"poses": np.hstack([np.zeros((N, 3)), POSES[72][:, 3:]]), "Rh": POSES[72][:, :3], "Th": TRANS}
# What each program writes, and the poses that it means.
FILES = {
    "GVHMR": ({"global_orient": ROOT, "body_pose": BODY, "transl": TRANS, "betas": np.zeros((N, 10))}, POSE),
    "WHAM": ({"pose": POSES[72] + 1.0, "trans": TRANS + 1.0, "pose_world": POSES[72], "trans_world": TRANS}, POSES[72]),
    "TRAM": ({"pred_rotmat": matrices(POSES[72]), "pred_trans": TRANS[:, None]}, POSES[72]),
    "4D-Humans": (
        {"global_orient": matrices(ROOT), "body_pose": matrices(POSES[72])[:, 1:], "pred_cam_t": TRANS},
        np.hstack([ROOT, POSES[72][:, 3:]]),
    ),
    "ROMP": ({"smpl_thetas": POSES[72], "cam_trans": TRANS}, POSES[72]),
    "EasyMocap": (EASYMOCAP, POSES[72]),
    "AIST++": (
        {"smpl_poses": POSES[72].reshape(N, 24, 3), "smpl_trans": 90.0 * TRANS, "smpl_scaling": np.array([90.0])},
        POSES[72],
    ),
    "smplx": (
        {"global_orient": ROOT, "body_pose": BODY, "jaw_pose": X[:, 66:69], **HANDS, "transl": TRANS},
        np.hstack([POSE, without_eyes()[:, 66:]]),
    ),
    "no hands": ({"root_orient": ROOT, "pose_body": BODY, "trans": TRANS}, POSE),
    "66 columns": ({"poses": POSE, "trans": TRANS}, POSE),
}
KIND = {66: "SMPL", 72: "SMPL", 156: "SMPL-H", 165: "SMPL-X"}


def as_frames(arrays):
    """JSON as of EasyMocap: a person in each frame, whose arrays have a row."""
    return [[{key: array[i : i + 1].tolist() for key, array in arrays.items()}] for i in range(N)]


@pytest.mark.filterwarnings("ignore:.*z as in AMASS")
@pytest.mark.parametrize("program", FILES)
def test_positions_are_those_of_the_model(program, tmp_path):
    arrays, poses = FILES[program]
    model = model_arrays(KIND[poses.shape[1]])
    np.savez(tmp_path / "model.npz", **model)
    np.savez(tmp_path / "a.npz", **({"betas": np.zeros((1, 10))} | arrays))
    motion = load_motion(tmp_path / "a.npz", model=tmp_path / "model.npz", frame_rate=30, up="y")
    joints, parents = joints_of(model, np.zeros(10)), PARENTS[KIND[poses.shape[1]]]
    whole = np.hstack([poses, np.zeros((N, 3 * len(parents) - poses.shape[1]))])
    expected = world_positions(whole, TRANS, joints, parents)
    if program == "EasyMocap":  # the model rotates about its own origin
        expected += (Rotation.from_rotvec(ROOT).apply(joints[0]) - joints[0])[:, None]
    found = positions_of(motion)
    np.testing.assert_allclose(found, expected[:, : found.shape[1]], rtol=0, atol=1e-12)


@MEAN
def test_json_and_tables_have_the_same_numbers(tmp_path):
    for name, document in {
        "frames": as_frames(EASYMOCAP),
        "annots": [{"annots": people} for people in as_frames(EASYMOCAP)],
        "arrays": {"fps": 30, "person": {key: array.tolist() for key, array in EASYMOCAP.items()}},
    }.items():
        (tmp_path / f"{name}.json").write_text(json.dumps(document))
        motion = load_motion(tmp_path / f"{name}.json", frame_rate=None if name == "arrays" else 30)
        np.testing.assert_allclose(motion.angles, POSES[72][:, 3:], atol=1e-12)
    (tmp_path / "smpl").mkdir()
    for i, frame in enumerate(as_frames(EASYMOCAP)):
        (tmp_path / "smpl" / f"{i + 5}.json").write_text(json.dumps(frame))
    np.testing.assert_allclose(load_motion(tmp_path / "smpl", frame_rate=30).angles, motion.angles, atol=1e-12)
    (tmp_path / "smpl" / "99.json").write_text(json.dumps(frame))
    with pytest.raises(MocapFormatError, match="gaps"):
        load_motion(tmp_path / "smpl", frame_rate=30)
    (tmp_path / "lost.json").write_text(json.dumps([*as_frames(EASYMOCAP), []]))
    with pytest.raises(MocapFormatError, match="person"):
        load_motion(tmp_path / "lost.json", frame_rate=30)
    np.save(tmp_path / "x.npy", motion_x())
    np.testing.assert_allclose(load_motion(tmp_path / "x.npy", frame_rate=30).angles, without_eyes()[:, 3:], atol=1e-12)


@MEAN
@pytest.mark.parametrize(
    "document",
    [
        {"1": {"poses": POSES[72].tolist(), "trans": TRANS.tolist()}, "2": {"poses": POSES[72].tolist(), "trans": []}},
        [[{"poses": [[0.1] * 72], "Th": [[0, 0, 0]]}] * 2],
        [{"poses": [[0.1] * 72], "Th": [[0, 0]]}],
        {"poses": [[0.1] * 71], "trans": [[0, 0, 0]]},
    ],
)
def test_two_people_or_other_numbers_are_refused(document, tmp_path):
    (tmp_path / "a.json").write_text(json.dumps(document))
    for load in (load_motion, load_keypoints):
        with pytest.raises(MocapFormatError):
            load(tmp_path / "a.json", frame_rate=30)


@MEAN
def test_matrices_that_are_no_rotations_are_refused(tmp_path):
    np.savez(tmp_path / "a.npz", pred_rotmat=2.0 * matrices(POSES[72]), pred_trans=TRANS)
    with pytest.raises(MocapFormatError, match="rotation"):
        load_motion(tmp_path / "a.npz", frame_rate=30)


def test_positions_and_orientations_of_kimodo(tmp_path):
    """Which hold the lengths of bones, too."""
    joints = RNG.normal(size=(22, 3))
    joints[0] = 0.0
    positions = world_positions(POSE, TRANS, joints, PARENTS["SMPL"][:22])
    world = matrices(POSE)
    for j, parent in enumerate(PARENTS["SMPL"][:22]):
        world[:, j] = world[:, parent] @ world[:, j] if parent >= 0 else world[:, j]
    np.savez(tmp_path / "a.npz", posed_joints=positions, global_rot_mats=world)
    motion = load_motion(tmp_path / "a.npz", frame_rate=30, up="y")
    np.testing.assert_allclose(positions_of(motion), positions, atol=1e-9)
    np.savez(tmp_path / "b.npz", posed_joints=np.zeros((N, 77, 3)), global_rot_mats=np.zeros((N, 77, 3, 3)))
    with pytest.raises(MocapFormatError, match="BVH"):
        load_motion(tmp_path / "b.npz", frame_rate=30)


@MEAN
def test_data_decide_which_axis_points_up(tmp_path):
    upright = np.tile(np.hstack([np.zeros((1, 3)), POSE[:1, 3:] * 0.1]), (N, 1))
    down = np.hstack([np.tile([np.pi, 0.0, 0.0], (N, 1)), upright[:, 3:]])
    np.savez(tmp_path / "a.npz", global_orient=upright[:, :3], body_pose=upright[:, 3:], transl=TRANS)
    assert load_motion(tmp_path / "a.npz", frame_rate=30).up == "y"
    np.savez(tmp_path / "b.npz", global_orient=down[:, :3], body_pose=down[:, 3:], transl=TRANS)  # of a camera
    turned = load_motion(tmp_path / "b.npz", frame_rate=30)
    np.testing.assert_allclose(turned.root_positions, TRANS * [1, -1, -1], atol=1e-12)
    np.savez(tmp_path / "c.npz", poses=upright, trans=TRANS)
    with pytest.warns(UserWarning, match="up='z'"):
        assert load_motion(tmp_path / "c.npz", frame_rate=30).up == "y"
    assert load_motion(tmp_path / "c.npz", frame_rate=30, up="z").up == "z"


JOINTS = {  # of a walk and of SMPL: one rotates the bone that ends at a joint, the other those that start there
    "left_pelvis": "left_hip",
    "left_thigh": "left_knee",
    "right_shank": "right_ankle",
    "right_clavicle": "right_shoulder",
    "left_upper_arm": "left_elbow",
    "right_forearm": "right_wrist",
    "chest": "neck",
    "neck": "head",
}
WALK = make_gait(1, 1, duration=1.0, random_state=0)[0]


def test_bvh_to_smpl_and_back(tmp_path):
    """Joints are within 1 mm, angles within 1 degree, in another rig whose pelvis is elsewhere and has no fingers."""
    save_bvh(tmp_path / "a.bvh", WALK)
    for motion in (WALK, load_bvh(tmp_path / "a.bvh")):
        (tmp_path / "b.npz").unlink(missing_ok=True)
        (tmp_path / "c.bvh").unlink(missing_ok=True)
        save_smpl(tmp_path / "b.npz", motion)
        save_bvh(tmp_path / "c.bvh", load_motion(tmp_path / "b.npz"))
        again = load_bvh(tmp_path / "c.bvh")
        for one, other in JOINTS.items():
            ours, theirs = place(WALK, one), place(again, other)
            assert np.linalg.norm(ours - theirs, axis=1).max() < 1e-3, one
        ours, theirs = (joint_angles(one).to_pandas() for one in (WALK, again))
        flexions = [name for name in ours if "flexion" in name and "wrist" not in name]
        np.testing.assert_allclose(ours[flexions], theirs[flexions], atol=1.0)


def place(motion, joint):
    return motion.positions()[:, motion.skeleton.joint_names.index(joint)]


@MEAN
def test_a_motion_on_smpl_is_written_as_it_is(tmp_path):
    upright = np.hstack([POSES[165][:, :3], 0.2 * POSES[165][:, 3:]])
    np.savez(tmp_path / "a.npz", poses=upright, trans=TRANS, mocap_framerate=30.0)
    save_smpl(tmp_path / "b.npz", load_motion(tmp_path / "a.npz", up="z"))
    with np.load(tmp_path / "b.npz") as file:
        np.testing.assert_allclose(file["poses"], upright, atol=1e-12)
        np.testing.assert_allclose(file["trans"], TRANS, atol=1e-12)
    save_bvh(
        tmp_path / "c.bvh", load_motion(tmp_path / "b.npz", up="z")
    )  # another way round, with Euler angles and y up
    save_smpl(tmp_path / "d.npz", load_bvh(tmp_path / "c.bvh", up="y"))
    with np.load(tmp_path / "d.npz") as file:
        turns = Rotation.from_rotvec(file["poses"][:, 3:].reshape(-1, 3)).inv()
        assert (turns * Rotation.from_rotvec(upright[:, 3:].reshape(-1, 3))).magnitude().max() < 1e-6


def test_a_model_stands_on_its_own_legs(tmp_path):
    """With the model's lengths other programs need nothing but poses and trans: feet stay on the floor."""
    model = model_arrays("SMPL-H")
    save_smpl(tmp_path / "own.npz", WALK)
    with np.load(tmp_path / "own.npz") as file:
        model["J_regressor"], model["v_template"] = np.eye(52), 1.3 * file["joints_at_rest"] - [0.0, 0.3, 0.0]
    model["shapedirs"] = np.zeros((52, 3, 16))
    np.savez(tmp_path / "model.npz", **model)
    save_smpl(tmp_path / "a.npz", WALK, model=tmp_path / "model.npz")
    with np.load(tmp_path / "a.npz") as file:
        world = world_positions(file["poses"], file["trans"], model["v_template"], PARENTS["SMPL-H"])
    height = min(place(WALK, f"{side}_shank")[:, 1].min() for side in ("left", "right"))
    assert abs(world[:, 7:9, 2].min() - 1.3 * height) < 0.01


def joints_from(vectors):
    """The slow way, as the data set's own: each frame's heading and way are added up."""
    heading, place, found = 0.0, np.zeros(3), []
    for i, vector in enumerate(vectors):
        if i:
            heading += 2.0 * vectors[i - 1][0]
            place = place + Rotation.from_euler("y", -heading).apply([vectors[i - 1][1], 0.0, vectors[i - 1][2]])
        others = Rotation.from_euler("y", -heading).apply(vector[4:67].reshape(21, 3)) + place
        found.append([[place[0], vector[3], place[2]], *others])
    return np.array(found)


def rotated_bones(vectors):
    """Directions of bones by the rotations of the vectors, relative to the heading, from the pelvis outwards."""
    down, up, left, forward = [0, -1, 0], [0, 1, 0], [1, 0, 0], [0, 0, 1]
    right = [-1, 0, 0]
    rest = [left, right, up, down, down, up, down, down, up, forward, forward, up, left, right, forward, *[down] * 6]
    columns = vectors[:, 67:193].reshape(len(vectors), 21, 2, 3)
    third = np.cross(columns[:, :, 0], columns[:, :, 1])
    local = np.stack([columns[:, :, 0], columns[:, :, 1], third], axis=-1)
    world, found = [np.tile(np.eye(3), (len(vectors), 1, 1))], []
    for j, parent in enumerate(PARENTS["SMPL"][1:22], start=1):
        world.append(world[0 if j in (13, 14) else parent] @ local[:, j - 1])
        found.append(world[-1] @ rest[j - 1])
    return np.stack(found, axis=1)


def test_vectors_of_humanml3d(tmp_path):
    """Vectors hold the joints, up to where the motion begins and where it faces, and the directions of bones."""
    save_smpl(tmp_path / "j.npy", WALK, content="joints")
    save_smpl(tmp_path / "v.npy", WALK, content="vectors")
    joints, vectors = np.load(tmp_path / "j.npy"), np.load(tmp_path / "v.npy")
    assert (joints.shape, vectors.shape) == ((20, 22, 3), (19, 263))
    found = joints_from(vectors)
    ours, theirs = (points[:19] - points[0, 0] for points in (found, joints))
    turn, _ = Rotation.align_vectors(ours.reshape(-1, 3), theirs.reshape(-1, 3))
    np.testing.assert_allclose(ours, turn.apply(theirs.reshape(-1, 3)).reshape(ours.shape), atol=1e-9)
    assert abs(turn.apply([0, 1, 0])[1] - 1.0) < 1e-9
    np.testing.assert_allclose([found[..., 1].min(), *found[0, 0, [0, 2]]], 0.0, atol=1e-6)
    bones = found[0, 1:] - found[0, PARENTS["SMPL"][1:22]]
    np.testing.assert_allclose(
        rotated_bones(vectors)[0], bones / np.linalg.norm(bones, axis=1, keepdims=True), atol=1e-9
    )
    seen = load_keypoints(tmp_path / "v.npy")
    np.testing.assert_allclose(seen.positions, found, atol=1e-12)
    assert (seen.frame_rate, seen.names) == (20.0, layouts["humanml22"].names)
    np.save(tmp_path / "z.npy", (vectors - vectors.mean(axis=0)) / 0.1)
    with pytest.warns(UserWarning, match="standardised"):
        load_keypoints(tmp_path / "z.npy", zeros="seen")


@pytest.mark.slow
def test_vectors_of_humanml3d_by_poses(tmp_path):
    """Vectors → joints → poses → vectors: the same joints within 1 cm, as skeletons have constant lengths."""
    save_smpl(tmp_path / "v.npy", WALK, content="vectors")
    seen = load_keypoints(tmp_path / "v.npy")
    poses = inverse_kinematics(seen, fit_skeleton(seen, layouts["humanml22"])).to_motion()
    save_smpl(tmp_path / "again.npy", poses, content="vectors")
    np.testing.assert_allclose(joints_from(np.load(tmp_path / "again.npy")), seen.positions[:-1], atol=0.01)
