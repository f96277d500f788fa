"""AMASS files against a slow forward kinematics of SMPL, and files that are not what they should be."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from skpose import forward_kinematics
from skpose.io import MocapFormatError, load_amass, load_motion

# As the models' authors number the joints: the body, then hands or face and fingers.
BODY = [-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19]


def fingers(wrist, first):
    return [parent for f in range(5) for parent in (wrist, first + 3 * f, first + 3 * f + 1)]


PARENTS = {
    "SMPL": [*BODY, 20, 21],
    "SMPL-H": [*BODY, *fingers(20, 22), *fingers(21, 37)],
    "SMPL-X": [*BODY, 15, 15, 15, *fingers(20, 25), *fingers(21, 40)],
}
N_FRAMES, N_VERTICES = 9, 200
NO_MODEL = pytest.mark.filterwarnings("ignore:bones have the lengths of a person of mean height")


def motion_arrays(kind, seed=0, n_frames=N_FRAMES):
    """The arrays of a file, with the keys, shapes and dtypes of real ones."""
    rng = np.random.default_rng(seed)
    poses = rng.normal(size=(n_frames, 3 * len(PARENTS[kind])))
    arrays = {"poses": poses, "trans": rng.normal(size=(n_frames, 3)), "betas": rng.normal(size=16)}
    if kind == "SMPL-X":
        edges = np.cumsum([0, 3, 63, 3, 6, 90])
        names = "root_orient", "pose_body", "pose_jaw", "pose_eye", "pose_hand"
        arrays |= {name: poses[:, a:b] for name, a, b in zip(names, edges, edges[1:], strict=False)}
        arrays |= {"gender": np.array("neutral"), "mocap_frame_rate": np.array(59.94), "surface_model_type": "smplx"}
        return arrays | {"markers_latent_vids": np.array({"ARIEL": 411}, dtype=object)}
    return arrays | {"dmpls": rng.normal(size=(n_frames, 8)), "gender": b"female", "mocap_framerate": 120.00004577}


def model_arrays(kind, seed=1, n_directions=16):
    """A small body model of random numbers, about as large as a person."""
    rng = np.random.default_rng(seed)
    regressor = rng.dirichlet(np.ones(N_VERTICES), size=len(PARENTS[kind]))
    return {
        "J_regressor": regressor,
        "v_template": rng.normal(size=(N_VERTICES, 3)),
        "shapedirs": rng.normal(scale=0.1, size=(N_VERTICES, 3, n_directions)),
        "weights_prior": np.array(3),
    }


@pytest.fixture
def write(tmp_path):
    """Write the arrays of a motion or of a model, with changes; None leaves one out."""

    def write(arrays, name="a.npz", save=np.savez, **changed):
        arrays = {key: value for key, value in (arrays | changed).items() if value is not None}
        save(tmp_path / name, **arrays)
        return tmp_path / name

    return write


def joints_of(model, betas):
    vertices = model["v_template"] + model["shapedirs"][:, :, : len(betas)] @ betas
    return model["J_regressor"] @ vertices


def world_positions(poses, trans, joints, parents):
    """All joints in the world, the slow way: rotation vectors from the root outwards."""
    world = np.zeros((len(poses), len(parents), 3))
    for frame, (pose, shift) in enumerate(zip(poses, trans, strict=True)):
        local = Rotation.from_rotvec(pose.reshape(-1, 3)).as_matrix()
        turned = []
        for j, parent in enumerate(parents):
            turned.append(local[j] if parent < 0 else turned[parent] @ local[j])
            if parent < 0:
                world[frame, j] = joints[j] + shift
            else:
                world[frame, j] = world[frame, parent] + turned[parent] @ (joints[j] - joints[parent])
    return world


def positions_of(motion):
    """All joints in the world as skpose has them, the root first."""
    root = Rotation.from_euler(motion.root_axes, motion.root_angles).as_matrix()
    joints = forward_kinematics(motion.angles, motion.skeleton)
    joints = np.einsum("fij,fkj->fki", root, joints) + motion.root_positions[:, None]
    return np.concatenate([motion.root_positions[:, None], joints], axis=1)


@pytest.mark.parametrize("kind", PARENTS)
def test_positions_are_those_of_the_model(kind, write):
    save = np.savez_compressed
    arrays, model = motion_arrays(kind), model_arrays(kind, n_directions=400)
    motion = load_amass(write(arrays, save=save), model=write(model, "model.npz", save=save))
    expected = world_positions(arrays["poses"], arrays["trans"], joints_of(model, arrays["betas"]), PARENTS[kind])
    np.testing.assert_allclose(positions_of(motion), expected, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(motion.angles, arrays["poses"][:, 3:])
    np.testing.assert_array_equal(motion.skeleton.parents, np.array(PARENTS[kind][1:]) - 1)
    assert motion.frame_rate == (59.94 if kind == "SMPL-X" else 120.00004577)


def test_without_hands(write):
    kind = "SMPL-X"
    arrays, model = motion_arrays(kind), model_arrays(kind, n_directions=300)
    motion = load_amass(write(arrays), model=write(model, "model.npz"), hands=False)
    n_joints = 25
    assert motion.skeleton.n_joints == n_joints - 1
    np.testing.assert_array_equal(motion.angles, arrays["poses"][:, 3 : 3 * n_joints])
    expected = world_positions(arrays["poses"], arrays["trans"], joints_of(model, arrays["betas"]), PARENTS[kind])
    np.testing.assert_allclose(positions_of(motion), expected[:, :n_joints], rtol=0, atol=1e-12)


def test_directions_of_shape(write):
    """SMPL-X with fewer than 300 shapedirs has ten of shape; what follows moves the face."""
    arrays, model = motion_arrays("SMPL-X"), model_arrays("SMPL-X", n_directions=20)
    with pytest.warns(UserWarning, match=r"has 10 directions of shape, so that only the first 10 betas are used"):
        motion = load_amass(write(arrays), model=write(model, "model.npz"))
    joints = joints_of(model, arrays["betas"][:10])
    np.testing.assert_allclose(motion.root_positions, arrays["trans"] + joints[0], atol=1e-14)
    np.testing.assert_allclose(motion.skeleton.offsets[0], joints[1] - joints[0], atol=1e-14)
    betas = np.concatenate([arrays["betas"][:10], np.zeros(6)])  # nothing is left out
    assert load_amass(write(arrays, betas=betas), model=write(model, "model.npz")).skeleton == motion.skeleton
    assert (
        load_amass(write(arrays, betas=betas[None, :10]), model=write(model, "model.npz")).skeleton == motion.skeleton
    )


def test_parts_of_poses(write):
    """Files may have the parts of a pose alone."""
    arrays, model = motion_arrays("SMPL-X"), write(model_arrays("SMPL-X", n_directions=300), "model.npz")
    whole, parts = (load_amass(write(arrays, **change), model=model) for change in ({}, {"poses": None}))
    np.testing.assert_array_equal(parts.angles, whole.angles)
    np.testing.assert_array_equal(parts.root_angles, whole.root_angles)
    without_face = {"poses": None, "pose_jaw": None, "pose_eye": None}
    parts = load_amass(write(arrays, **without_face), model=write(model_arrays("SMPL-H"), "h.npz"))
    np.testing.assert_array_equal(parts.angles, np.delete(whole.angles, np.s_[63:72], axis=1))


@NO_MODEL
def test_the_roots_angles_are_continuous(write):
    """Also where a person rolls over the side, at which the axes are degenerate."""
    t = np.linspace(0, 4 * np.pi, 400)
    upright = Rotation.from_euler("x", 90, degrees=True)
    roots = Rotation.from_euler("ZYX", np.stack([0.3 * t, 1.7 * np.sin(t), 0.2 * t], axis=1)) * upright
    arrays = motion_arrays("SMPL", n_frames=400)
    arrays["poses"][:, :3] = roots.as_rotvec()
    motion = load_amass(write(arrays))
    assert np.abs(np.diff(motion.root_angles, axis=0)).max() < 0.1
    found = Rotation.from_euler(motion.root_axes, motion.root_angles)
    assert (found.inv() * roots).magnitude().max() < 1e-12


@pytest.mark.parametrize("gender", ["female", b"female", np.array(["female"])])
def test_the_model_of_a_gender(gender, write, tmp_path):
    (tmp_path / "female").mkdir()
    write(model_arrays("SMPL-H"), "female/model.npz")
    path = write(motion_arrays("SMPL-H"), gender=gender)
    motion = load_amass(path, model=tmp_path / "{gender}" / "model.npz")
    assert motion.skeleton == load_amass(path, model=str(tmp_path / "female" / "model.npz")).skeleton


class Bomb:
    """An object whose pickle creates a file when it is loaded."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)


@pytest.mark.parametrize("key", ["poses", "gender", "root_orient"])
def test_nothing_is_unpickled(key, write, tmp_path):
    created = tmp_path / "created"
    bomb = np.array([Bomb(created)], dtype=object)
    write(model_arrays("SMPL-H"), "female.npz")
    path = write(motion_arrays("SMPL-H"), **{key: bomb})
    if key == "root_orient":  # not needed
        load_amass(path, model=tmp_path / "female.npz")
    else:
        with pytest.raises(MocapFormatError, match=key):
            load_amass(path, model=tmp_path / "{gender}.npz")
    assert not created.exists()


@NO_MODEL
@pytest.mark.parametrize(
    "change",
    [
        {"poses": np.zeros((9, 150))},
        {"poses": np.zeros((8, 156))},
        {"trans": None},
        {"poses": np.full((9, 156), "a")},
        {"trans": np.where(np.arange(27) == 10, np.nan, 1.0).reshape(9, 3)},
        {"mocap_framerate": None},
        {"poses": None, "root_orient": np.zeros((9, 3))},
    ],
)
def test_wrong_files(change, write):
    with pytest.raises(MocapFormatError):
        load_amass(write(motion_arrays("SMPL-H"), **change))


@NO_MODEL
def test_a_way_in_centimetres_warns(write):
    way = np.linspace([0.0, 0.0, 0.9], [3.0, 0.0, 0.9], 9)
    with pytest.warns(UserWarning, match="metres"):
        load_amass(write(motion_arrays("SMPL"), trans=100 * way, mocap_framerate=30.0))
    load_amass(write(motion_arrays("SMPL"), trans=way, mocap_framerate=30.0))


@NO_MODEL
def test_frames_with_nan_can_be_left_out(write):
    """Of the position, of the pose, or of both; the others keep their numbers and their times."""
    arrays = motion_arrays("SMPL-X")
    whole = load_amass(write(arrays))
    poses, trans = arrays["poses"].copy(), arrays["trans"].copy()
    trans[2, 1], trans[7, 0], poses[5, 80], poses[7, 3] = np.nan, np.inf, -np.inf, np.nan
    kept = [0, 1, 3, 4, 6, 8]
    with pytest.warns(UserWarning, match="3 of 9 frames"):
        motion = load_motion(write(arrays, trans=trans, poses=poses), on_nan="drop")
    np.testing.assert_array_equal(motion.frame_numbers, kept)
    np.testing.assert_array_equal(motion.angles, whole.angles[kept])
    np.testing.assert_array_equal(motion.root_positions, whole.root_positions[kept])
