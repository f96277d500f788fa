"""AMASS files against a slow forward kinematics of SMPL, and files that are not what they should be."""

import gzip
import io
import pickle
import struct
import tracemalloc
import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csc_matrix
from scipy.spatial.transform import Rotation

from skpose import forward_kinematics
from skpose._cli.main import main
from skpose.datasets import MotionDataset, humanoid
from skpose.io import MocapFormatError, file_format, load_amass, load_bvh, load_keypoints, load_motion

# As the models' authors number the joints: the body, then hands or face and fingers.
BODY = [-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19]


def fingers(wrist, first):
    return [parent for f in range(5) for parent in (wrist, first + 3 * f, first + 3 * f + 1)]


PARENTS = {
    "SMPL": [*BODY, 20, 21],
    "SMPL-H": [*BODY, *fingers(20, 22), *fingers(21, 37)],
    "SMPL-X": [*BODY, 15, 15, 15, *fingers(20, 25), *fingers(21, 40)],
}
FINGERS = "index", "middle", "pinky", "ring", "thumb"
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


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
@pytest.mark.parametrize("kind", PARENTS)
def test_positions_are_those_of_the_model(kind, save, write):
    arrays, model = motion_arrays(kind), model_arrays(kind, n_directions=400)
    motion = load_amass(write(arrays, save=save), model=write(model, "model.npz", save=save))
    expected = world_positions(arrays["poses"], arrays["trans"], joints_of(model, arrays["betas"]), PARENTS[kind])
    np.testing.assert_allclose(positions_of(motion), expected, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(motion.angles, arrays["poses"][:, 3:])
    np.testing.assert_array_equal(motion.skeleton.parents, np.array(PARENTS[kind][1:]) - 1)
    assert motion.frame_rate == (59.94 if kind == "SMPL-X" else 120.00004577)


def test_joint_names(write):
    with pytest.warns(UserWarning, match="mean height"):
        names = {kind: load_amass(write(motion_arrays(kind))).skeleton.joint_names for kind in PARENTS}
    assert {len(names[kind]) for kind in PARENTS} == {23, 51, 54}
    body = names["SMPL"][:21]
    assert body == names["SMPL-H"][:21] == names["SMPL-X"][:21]
    assert body[:6] == ("left_hip", "right_hip", "spine1", "left_knee", "right_knee", "spine2")
    assert body[11:] == (
        "neck", "left_collar", "right_collar", "head", "left_shoulder", "right_shoulder", "left_elbow", "right_elbow",
        "left_wrist", "right_wrist",
    )  # fmt: skip
    assert names["SMPL"][21:] == ("left_hand", "right_hand")
    assert names["SMPL-X"][21:24] == ("jaw", "left_eye", "right_eye")
    hands = [f"{side}_{f}{i}" for side in ("left", "right") for f in FINGERS for i in "123"]
    assert list(names["SMPL-H"][21:]) == list(names["SMPL-X"][24:]) == hands


@pytest.mark.parametrize("kind", PARENTS)
def test_without_hands(kind, write):
    arrays, model = motion_arrays(kind), model_arrays(kind, n_directions=300)
    motion = load_amass(write(arrays), model=write(model, "model.npz"), hands=False)
    n_joints = 25 if kind == "SMPL-X" else 22
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
@pytest.mark.parametrize("dtype", [np.float32, ">f8", np.float16])
def test_any_kind_of_numbers(dtype, write):
    arrays = motion_arrays("SMPL-H")
    poses = np.asfortranarray(arrays["poses"].astype(dtype))
    motion = load_amass(write(arrays, poses=poses, mocap_framerate=np.array([120])))
    np.testing.assert_array_equal(motion.angles, poses[:, 3:])
    assert (motion.frame_rate, motion.angles.dtype) == (120, np.float64)


@NO_MODEL
@pytest.mark.parametrize("n_frames", [0, 1])
def test_few_frames(n_frames, write):
    motion = load_amass(write(motion_arrays("SMPL-H", n_frames=n_frames)), up="z")
    assert len(motion) == n_frames
    assert motion.root_angles.shape == (n_frames, 3)


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


def test_mean_proportions(write):
    """Bones are those of humanoid, with the arms to the sides."""
    with pytest.warns(UserWarning, match="model= takes them from the file of an SMPL model") as caught:
        motion = load_amass(write(motion_arrays("SMPL-H")))
    assert [Path(warning.filename) for warning in caught] == [Path(__file__)]
    person = humanoid()
    length = dict(zip(person.joint_names, np.linalg.norm(person.offsets, axis=1), strict=True))
    offset = dict(zip(motion.skeleton.joint_names, motion.skeleton.offsets, strict=True))
    pairs = {
        "hip": "pelvis",
        "knee": "thigh",
        "ankle": "shank",
        "foot": "foot",
        "elbow": "upper_arm",
        "wrist": "forearm",
    }
    for joint, bone in pairs.items():
        assert np.linalg.norm(offset[f"left_{joint}"]) == pytest.approx(length[f"left_{bone}"], rel=1e-12)
        np.testing.assert_array_equal(offset[f"right_{joint}"], offset[f"left_{joint}"] * [-1, 1, 1])
    trunk = sum(offset[joint] for joint in ("spine1", "spine2", "spine3", "neck"))
    np.testing.assert_allclose(trunk, [0, length["abdomen"] + length["chest"], 0])
    assert offset["left_wrist"][0] > 0.2  # x is to the left
    np.testing.assert_array_equal(motion.root_positions, motion_arrays("SMPL-H")["trans"])


@pytest.mark.parametrize("gender", ["female", b"female", np.array(["female"]), np.array(b"female"), "b'female'"])
def test_the_model_of_a_gender(gender, write, tmp_path):
    (tmp_path / "female").mkdir()
    write(model_arrays("SMPL-H"), "female/model.npz")
    path = write(motion_arrays("SMPL-H"), gender=gender)
    motion = load_amass(path, model=tmp_path / "{gender}" / "model.npz")
    assert motion.skeleton == load_amass(path, model=str(tmp_path / "female" / "model.npz")).skeleton


def test_a_model_is_read_again_when_its_file_changes(write):
    path = write(motion_arrays("SMPL"))
    first = load_amass(path, model=write(model_arrays("SMPL"), "model.npz")).skeleton
    second = load_amass(path, model=write(model_arrays("SMPL", seed=2, n_directions=20), "model.npz")).skeleton
    assert first != second


@NO_MODEL
def test_the_content_decides_on_the_format(write, capsys):
    path = write(motion_arrays("SMPL-X"), "a.npz")
    renamed = path.rename(path.with_suffix(".bvh"))
    assert file_format(renamed) == "AMASS"
    expected = load_amass(renamed)
    with renamed.open("rb") as file:
        motions = [load_motion(renamed), load_motion(file), load_amass(io.BytesIO(renamed.read_bytes()))]
        assert not file.closed
    for motion in motions:
        np.testing.assert_array_equal(motion.angles, expected.angles)
        assert motion.skeleton == expected.skeleton
    assert load_motion(renamed, hands=False).skeleton.n_joints == 24
    with pytest.raises(ValueError, match=r"a\.bvh is an AMASS file, in metres: scale must be None, got 0\.01"):
        load_motion(renamed, scale=0.01)
    with pytest.raises(ValueError, match=r"root='Hips' is for BVH files; .*a\.bvh is an AMASS file, whose root is the"):
        load_motion(renamed, root="Hips")
    with pytest.raises(MocapFormatError, match=r"a\.bvh: this is a zip archive, not a BVH file"):
        load_bvh(renamed)
    model = write(model_arrays("SMPL-X", n_directions=300), "model.npz")
    assert main(["info", str(renamed), "--model", str(model)]) == 0
    out = capsys.readouterr().out
    assert "9 frames at 59.94 Hz" in out
    length = np.linalg.norm(load_amass(renamed, model=model).skeleton.offsets[0])
    assert f"{length:.3f}  rotvec" in out


class Bomb:
    """An object whose pickle creates a file when it is loaded."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)


@pytest.mark.parametrize("key", ["poses", "trans", "mocap_framerate", "betas", "gender", "root_orient"])
def test_nothing_is_unpickled(key, write, tmp_path):
    created = tmp_path / "created"
    bomb = np.array([Bomb(created)], dtype=object)
    model = write(model_arrays("SMPL-H"), "female.npz")
    path = write(motion_arrays("SMPL-H"), **{key: bomb})
    if key == "root_orient":  # not needed
        load_amass(path, model=model)
    else:
        message = rf"a\.npz: {key}: expected numbers, found a pickled object, which could run any program and is never"
        with pytest.raises(MocapFormatError, match=message):
            load_amass(path, model=tmp_path / "{gender}.npz")
    assert not created.exists()
    with np.load(path, allow_pickle=True) as archive:
        archive[key]
    assert created.exists()  # as it would have been


def test_pickles_in_place_of_files(write, tmp_path):
    created = tmp_path / "created"
    (tmp_path / "a.pkl").write_bytes(pickle.dumps(Bomb(created)))
    with pytest.raises(MocapFormatError, match=r"a\.pkl: this is a pickle, .* never read, not an AMASS file"):
        load_amass(tmp_path / "a.pkl")
    with pytest.raises(MocapFormatError, match=r"a\.pkl: this is a pickle"):
        load_motion(tmp_path / "a.pkl")
    path = write(motion_arrays("SMPL"))
    with pytest.raises(MocapFormatError, match=r"a\.pkl: this is a pickle, .* not the file of an SMPL model"):
        load_amass(path, model=tmp_path / "a.pkl")
    sparse = np.array(csc_matrix(model_arrays("SMPL")["J_regressor"]), dtype=object)
    model = write(model_arrays("SMPL"), "model.npz", J_regressor=sparse)
    with pytest.raises(
        MocapFormatError, match=r"model\.npz: J_regressor: .* pickled .* J_regressor=m\['J_reg"
    ) as caught:
        load_amass(path, model=model)
    # The remedy in the message works.
    names = {"numpy": np, "path": model, "new": tmp_path / "new.npz"}
    exec(caught.value.message.partition("trust the file: ")[2], names)
    names["m"].close()
    plain = load_amass(path, model=write(model_arrays("SMPL"), "plain.npz"))
    new = load_amass(path, model=tmp_path / "new.npz")
    np.testing.assert_allclose(new.skeleton.offsets, plain.skeleton.offsets, rtol=0, atol=1e-14)
    assert not created.exists()


@NO_MODEL
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"poses": np.zeros((9, 150))},
            r"poses: expected shape \(n, k\) with k one of 72 \(SMPL\), 156 \(SMPL-H\), 165",
        ),
        ({"poses": np.zeros((9, 52, 3))}, r"poses: expected shape .* found \(9, 52, 3\)"),
        ({"poses": np.zeros((8, 156))}, r"poses: expected shape \(9, 156\), found \(8, 156\)"),
        ({"trans": np.zeros((9, 4))}, r"trans: expected shape \(n, 3\), found \(9, 4\)"),
        ({"trans": None}, "it has no trans; its keys are betas, dmpls, gender, mocap_framerate, poses"),
        (
            {"poses": None},
            "it has no poses, so it is no motion .*; load_keypoints reads .* its keys are betas, dmpls",
        ),
        ({"poses": np.full((9, 156), "a")}, "poses: expected numbers, found an array of dtype <U1"),
        ({"poses": np.zeros((9, 156), complex)}, "poses: expected numbers, found an array of dtype complex128"),
        ({"poses": np.zeros((9, 156), "f8,i4")}, r"poses: expected .*shape|poses: expected the header of an array"),
        ({"trans": np.where(np.arange(27) == 10, np.nan, 1.0).reshape(9, 3)}, r"trans: .* found nan at index \(3, 1\)"),
        ({"mocap_framerate": None}, "it has no mocap_framerate; its keys are .*; frame_rate= chooses the rate"),
        ({"mocap_framerate": 0.0}, r"mocap_framerate: expected a positive number, found 0\.0"),
        ({"mocap_framerate": np.zeros(2)}, r"mocap_framerate: expected shape \(\) or \(1,\), found \(2,\)"),
        ({"poses": None, "root_orient": np.zeros((9, 3))}, "it has no pose_body"),
    ],
)
def test_wrong_files(change, message, write):
    with pytest.raises(MocapFormatError, match=rf"a\.npz: {message}"):
        load_amass(write(motion_arrays("SMPL-H"), **change))


@NO_MODEL
@pytest.mark.parametrize("parts", [False, True], ids=["poses", "parts of poses"])
def test_frames_with_nan_can_be_left_out(write, parts):
    """Of the position, of the pose, or of both; the others keep their numbers and their times."""
    arrays = motion_arrays("SMPL-X")
    whole = load_amass(write(arrays))
    poses, trans = arrays["poses"].copy(), arrays["trans"].copy()
    trans[2, 1], trans[7, 0], poses[5, 80], poses[7, 3] = np.nan, np.inf, -np.inf, np.nan
    edges = np.cumsum([0, 3, 63, 3, 6, 90])
    names = "root_orient", "pose_body", "pose_jaw", "pose_eye", "pose_hand"
    changed = {name: poses[:, a:b] for name, a, b in zip(names, edges, edges[1:], strict=False)}
    path = write(arrays, trans=trans, **({"poses": None, **changed} if parts else {"poses": poses}))
    kept = [0, 1, 3, 4, 6, 8]
    for load in (load_amass, load_motion):
        with pytest.warns(UserWarning, match=r"a\.npz: 3 of 9 frames have a number that is NaN or infinite"):
            motion = load(path, on_nan="drop")
        np.testing.assert_array_equal(motion.frame_numbers, kept)
        np.testing.assert_allclose(motion.times, whole.times[kept])
        np.testing.assert_array_equal(motion.angles, whole.angles[kept])
        np.testing.assert_array_equal(motion.root_positions, whole.root_positions[kept])
        found, expected = (Rotation.from_euler("ZYX", a) for a in (motion.root_angles, whole.root_angles[kept]))
        assert (found.inv() * expected).magnitude().max() < 1e-12  # whose angles may differ by whole turns
        with pytest.raises(
            MocapFormatError, match=r"trans: .* nan at index \(2, 1\); on_nan='drop' leaves such frames"
        ):
            load(path)
    only_poses = write(arrays, poses=poses)
    with pytest.raises(MocapFormatError, match=r"poses: .* at index \(5, 80\); on_nan='drop' leaves such frames out"):
        load_amass(only_poses)
    with pytest.raises(ValueError, match="on_nan must be"):
        load_amass(only_poses, on_nan="keep")


@NO_MODEL
def test_nothing_else_may_be_nan(write):
    for key, value in (("mocap_framerate", np.nan), ("betas", np.full(16, np.nan))):
        path = write(motion_arrays("SMPL-H"), **{key: value})
        with pytest.raises(MocapFormatError, match=key) as caught:
            load_amass(path, on_nan="drop", model=write(model_arrays("SMPL-H"), "model.npz"))
        assert "on_nan" not in str(caught.value)


@NO_MODEL
def test_all_frames_may_be_left_out(write):
    with pytest.warns(UserWarning, match="9 of 9 frames"):
        assert len(load_amass(write(motion_arrays("SMPL"), trans=np.full((9, 3), np.nan)), on_nan="drop")) == 0


def test_on_nan_on_the_command_line(write, capsys):
    arrays = motion_arrays("SMPL")
    path = str(write(arrays, trans=np.where(np.arange(9)[:, None] == 4, np.nan, arrays["trans"])))
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        assert main(["info", path]) == 1
        assert "on_nan" in capsys.readouterr().err
        assert main(["info", path, "--on-nan", "drop"]) == 0
    assert capsys.readouterr().out.startswith("8 frames at 120 Hz")


@pytest.mark.parametrize("key", ["positions", "keypoints"])
def test_a_file_of_keypoints_names_its_reader(write, key):
    path = write({key: np.zeros((5, 3, 3)), "fps": 25, "names": list("abc")})
    with pytest.raises(MocapFormatError, match=f"it has {key}, positions of points .*: load_keypoints reads them"):
        load_motion(path)
    assert len(load_keypoints(path)) == 5


def test_of_a_hundred_keys_some_are_listed(write):
    path = write({f"joint_{i:03}": np.zeros(3) for i in range(100)})
    message = (
        r"a\.npz: it has no poses, so .* load_keypoints reads positions of points, under the key positions or "
        r"keypoints; .* Keypoints\(array, names, frame_rate\), .* Motion\(skeleton, angles, frame_rate\); its keys are "
        r"joint_000, .*, joint_011 and 88 more$"
    )
    with pytest.raises(MocapFormatError, match=message):
        load_motion(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"J_regressor": np.zeros((25, 200))}, r"J_regressor: .* 24 \(SMPL\), 52 \(SMPL-H\), 55 \(SMPL-X\), found 25"),
        ({"J_regressor": np.zeros(24)}, r"J_regressor: expected shape \(24, 0\), found \(24,\)"),
        ({"J_regressor": None}, "it has no J_regressor; its keys are shapedirs"),
        ({"v_template": np.zeros((199, 3))}, r"v_template: expected shape \(200, 3\), found \(199, 3\)"),
        ({"shapedirs": np.zeros((200, 3))}, r"shapedirs: expected shape \(200, 3, n\), found \(200, 3\)"),
    ],
)
def test_wrong_models(change, message, write):
    path = write(motion_arrays("SMPL"))
    with pytest.raises(MocapFormatError, match=rf"model\.npz: {message}"):
        load_amass(path, model=write(model_arrays("SMPL"), "model.npz", **change))


def test_a_model_that_does_not_fit_the_motion(write, tmp_path):
    model = write(model_arrays("SMPL"), "model.npz")
    with pytest.raises(MocapFormatError, match=r"a\.npz: its poses are of SMPL-H, and the model in .* is SMPL; pass"):
        load_amass(write(motion_arrays("SMPL-H")), model=model)
    with pytest.raises(MocapFormatError, match=r"a\.npz: it has no betas"):
        load_amass(write(motion_arrays("SMPL"), betas=None), model=model)
    with pytest.raises(MocapFormatError, match=r"a\.npz: gender: expected female, male, neutral, found '\.\./x'"):
        load_amass(write(motion_arrays("SMPL"), gender="../x"), model=tmp_path / "{gender}.npz")
    with pytest.raises(MocapFormatError, match=r"a\.npz: gender: expected texts, found an array of dtype int64"):
        load_amass(write(motion_arrays("SMPL"), gender=np.int64(1)), model=tmp_path / "{gender}.npz")
    with pytest.raises(FileNotFoundError, match=r"none\.npz"):
        load_amass(write(motion_arrays("SMPL")), model=tmp_path / "none.npz")


def entry(shape, data, descr="'<f8'"):
    """An array in numpy's format with a header of choice."""
    header = f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n".encode()
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + data


@NO_MODEL
@pytest.mark.parametrize(
    ("poses", "message"),
    [
        (entry("(9, 156)", b"\0" * 80), "its header states 11232 bytes of data, .* and there are 80; is the file cut"),
        (entry("(9, 156)", b"\0" * 11240), "its header states 11232 bytes of data, .* and there are 11240"),
        (entry("(9000000000000, 156)", b""), "its header states 11232000000000000 bytes"),
        (entry("(-9, 156)", b""), "expected the header of an array of numbers, found"),
        (entry("(9, 156)", b"", "__import__('os').abort()"), "expected the header of an array of numbers, found"),
        (entry("(9, 156)", b"", "'<f3'"), "expected numbers, found an array of the unknown dtype '<f3'"),
        (entry("(" + "9" * 5000 + ", 156)", b""), "expected the header of an array of numbers, found"),
        (b"\x93NUMPY\x01\x00\xff", "expected the header of an array of numbers, found b''"),
        (b"\x93NUMPY\x03\x00\xff\xff", "expected an array in numpy's format, version 1 or 2, found"),
        (b"", "expected an array in numpy's format, version 1 or 2, found b''"),
    ],
)
def test_headers_are_checked_before_data_are_read(poses, message, write):
    path = write(motion_arrays("SMPL-H"), poses=None)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("poses.npy", poses)
    with pytest.raises(MocapFormatError, match=rf"a\.npz: poses: {message}"):
        load_amass(path)


@NO_MODEL
def test_an_archive_that_states_more_than_it_holds(write):
    """Nothing is allocated for data that an archive's table of contents claims and does not hold."""
    poses = entry("(1000000000, 156)", b"\0" * 5000)
    path = write(motion_arrays("SMPL-H"), poses=None, trans=None)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("poses.npy", poses)
        archive.writestr("trans.npy", entry("(1000000000, 3)", b"\0" * 5000))
        for info in archive.infolist():
            if info.filename in ("poses.npy", "trans.npy"):
                width = 156 if info.filename == "poses.npy" else 3
                info.file_size = info.file_size - 5000 + 8 * 10**9 * width
    tracemalloc.start()
    try:
        with pytest.raises(MocapFormatError, match=r"a\.npz: trans: "):
            load_amass(path)
        assert tracemalloc.get_traced_memory()[1] < 10**7
    finally:
        tracemalloc.stop()


@NO_MODEL
def test_an_archive_that_holds_more_than_it_states(write):
    path = write(motion_arrays("SMPL-H"), poses=None)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("poses.npy", entry("(9, 156)", bytes(5 * 10**7)))
        archive.getinfo("poses.npy").file_size -= 5 * 10**7 - 9 * 156 * 8
    tracemalloc.start()
    try:
        with pytest.raises(MocapFormatError, match=r"a\.npz: poses: damaged"):
            load_amass(path)
        assert tracemalloc.get_traced_memory()[1] < 10**7
    finally:
        tracemalloc.stop()


def test_other_archives(write, tmp_path):
    path = write({"hello": np.zeros(3)})
    with pytest.raises(MocapFormatError, match=r"a\.npz: it has no poses, .* its keys are hello"):
        load_motion(path)
    with zipfile.ZipFile(tmp_path / "empty.npz", "w"):
        pass
    with pytest.raises(MocapFormatError, match=r"empty\.npz: it has no poses, .* its keys are none"):
        load_motion(tmp_path / "empty.npz")
    (tmp_path / "a.npz.gz").write_bytes(gzip.compress(path.read_bytes()))
    with pytest.raises(MocapFormatError, match=r"a\.npz\.gz: a zip archive compressed by gzip once more"):
        load_motion(tmp_path / "a.npz.gz")
    with zipfile.ZipFile(tmp_path / "lzma.npz", "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("poses.npy", entry("(9, 156)", b"\0" * 11232))
    with pytest.raises(MocapFormatError, match=r"lzma\.npz"):
        load_amass(tmp_path / "lzma.npz")
    (tmp_path / "text.npz").write_text("HIERARCHY\n")
    with pytest.raises(MocapFormatError, match=r"text\.npz: expected an \.npz file, a zip archive"):
        load_amass(tmp_path / "text.npz")


WHOLE = {}
for _save in (np.savez, np.savez_compressed):
    _buffer = io.BytesIO()
    _save(_buffer, **motion_arrays("SMPL", n_frames=2))
    WHOLE[_save.__name__] = _buffer.getvalue()


def read_or_refuse(data):
    """Read bytes as a file; every error but MocapFormatError passes through."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "bones have the lengths")
        try:
            return load_amass(io.BytesIO(data))
        except MocapFormatError as error:
            return error


@pytest.mark.parametrize("save", WHOLE)
def test_truncated_anywhere(save):
    whole = WHOLE[save]
    for length in range(0, len(whole), 7):
        assert isinstance(read_or_refuse(whole[:length]), MocapFormatError)


@settings(max_examples=400, deadline=None, derandomize=True, database=None)
@given(
    st.sampled_from(sorted(WHOLE)), st.lists(st.tuples(st.floats(0, 1), st.integers(0, 255)), min_size=1, max_size=4)
)
def test_damaged_anywhere(save, changes):
    """A changed byte is an error of one type, or in what nobody reads."""
    data = bytearray(WHOLE[save])
    for where, byte in changes:
        data[int(where * (len(data) - 1))] = byte
    found = read_or_refuse(bytes(data))
    assert isinstance(found, MocapFormatError) or len(found) == 2


@pytest.mark.parametrize("kind", [zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_data_that_do_not_decompress(kind):
    """Each library has an error of its own; bzip2's is the operating system's."""
    file = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(WHOLE["savez"])) as whole, zipfile.ZipFile(file, "w", kind) as other:
        for name in whole.namelist():
            other.writestr(name, whole.read(name))
        middle = other.getinfo("poses.npy").header_offset + 200
    assert len(read_or_refuse(file.getvalue())) == 2
    file.seek(middle)
    file.write(b"no such code" * 9)
    assert "damaged or cut short" in str(read_or_refuse(file.getvalue()))


@pytest.mark.parametrize("number", [1e16, -1e155, 1e300])
def test_numbers_that_are_no_angles_are_refused(number, write):
    """A rotation vector of 1e155 rad has no unit quaternion in float64."""
    arrays = motion_arrays("SMPL")
    arrays["poses"][2, 9] = number
    with pytest.raises(MocapFormatError, match=r"poses: expected angles in rad, found .*, which is no angle"):
        load_amass(write(arrays))


@NO_MODEL
def test_motions_of_two_models_compare_without_their_hands(write):
    """The message that refuses them names the remedy, which works."""
    smpl, smplh = (write(motion_arrays(kind), f"{kind}.npz") for kind in ("SMPL", "SMPL-H"))
    remedy = (
        r"only one of them has a joint 'left_hand' \(and 31 more\); without their hands, load_motion\(\.\.\., hands="
    )
    with pytest.raises(ValueError, match=remedy):
        MotionDataset([load_motion(path) for path in (smpl, smplh)]).poses()
    X, _ = MotionDataset([load_motion(path, hands=False) for path in (smpl, smplh)]).poses()
    assert X.shape[1] == 63
