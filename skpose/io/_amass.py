"""Motions of the body models SMPL, SMPL-H and SMPL-X, as in AMASS and as programs find them in videos.

N. Mahmood, N. Ghorbani, N. F. Troje, G. Pons-Moll, M. J. Black, "AMASS: archive of motion capture as surface shapes",
ICCV 2019, doi:10.1109/ICCV.2019.00554.

AMASS, GVHMR, WHAM, TRAM, 4D-Humans, ROMP, EasyMocap, AIST++, Motion-X and Kimodo have the same numbers under other
keys, as rotation vectors or matrices, as arrays or JSON. EasyMocap's Rh rotates a body about the origin of the model,
the others about its pelvis.

M. Loper, N. Mahmood, J. Romero, G. Pons-Moll, M. J. Black, "SMPL: a skinned multi-person linear model", ACM Trans.
Graphics 34, 2015, doi:10.1145/2816795.2818013. At rest a model stands as a T, with x to its left, y up and z forward.
"""

import os
import re
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.warnings import warn
from skpose.io._conventions import Up, check_options, choose_rate, stand
from skpose.io._keypoints_json import is_json, parse_json
from skpose.io._source import ARRAY, Archive, PathLike, Readable, Source, drop_not_finite, last_number, open_source
from skpose.skeleton import Bone, Motion, Skeleton
from skpose.skeleton._proportions import MEAN_HEIGHT, PROPORTIONS
from skpose.skeleton._rotations import continuous_triples
from skpose.skeleton._upright import describe_up, find_up

# --- models -----------------------------------------------------------------------------------------------------------
# The joints of the body models, and where they are on a person.


Tree = dict[str, str | None]  # the parent of each joint, in the order of the model

FINGERS = "index", "middle", "pinky", "ring", "thumb"
GENDERS = "female", "male", "neutral"
EXPRESSIONS = 300  # a model SMPL-X with fewer shapedirs has only ten of shape, then those of the face
SHAPES_BEFORE_EXPRESSIONS = 10


def _fingers(side: str) -> Tree:
    parents: Tree = {f"{side}_{finger}{i}": f"{side}_{finger}{i - 1}" for finger in FINGERS for i in (1, 2, 3)}
    parents.update({f"{side}_{finger}1": f"{side}_wrist" for finger in FINGERS})
    return parents


_BODY: Tree = {
    "pelvis": None,
    "left_hip": "pelvis",
    "right_hip": "pelvis",
    "spine1": "pelvis",
    "left_knee": "left_hip",
    "right_knee": "right_hip",
    "spine2": "spine1",
    "left_ankle": "left_knee",
    "right_ankle": "right_knee",
    "spine3": "spine2",
    "left_foot": "left_ankle",
    "right_foot": "right_ankle",
    "neck": "spine3",
    "left_collar": "spine3",
    "right_collar": "spine3",
    "head": "neck",
    "left_shoulder": "left_collar",
    "right_shoulder": "right_collar",
    "left_elbow": "left_shoulder",
    "right_elbow": "right_shoulder",
    "left_wrist": "left_elbow",
    "right_wrist": "right_elbow",
}
_FACE: Tree = {"jaw": "head", "left_eye": "head", "right_eye": "head"}
_PALMS: Tree = {"left_hand": "left_wrist", "right_hand": "right_wrist"}
HANDS = {*_PALMS, *_fingers("left"), *_fingers("right")}
BODY, SMPL_H = "the body", "SMPL-H"  # the first is a part of all models
MODELS: dict[str, Tree] = {
    BODY: _BODY,
    "SMPL": _BODY | _PALMS,
    SMPL_H: _BODY | _fingers("left") | _fingers("right"),
    "SMPL-X": _BODY | _FACE | _fingers("left") | _fingers("right"),
}
BY_SIZE = {len(tree): name for name, tree in MODELS.items()}  # 22, 24, 52, 55 joints

# Offsets from the parent joint, in fractions of the height; of the left side, the right mirrors it. Trunk and limbs are
# as in skpose.datasets.humanoid, which has two bones where SMPL has four from the pelvis to the neck. Face and fingers
# are round figures of our own.
_OFFSETS = {
    "pelvis": (0.0, 0.0, 0.0),
    "hip": (PROPORTIONS["hip"], 0.0, 0.0),
    "knee": (0.0, -PROPORTIONS["thigh"], 0.0),
    "ankle": (0.0, -PROPORTIONS["shank"], 0.0),
    "foot": (0.0, -PROPORTIONS["ankle"], PROPORTIONS["foot"]),
    "spine1": (0.0, PROPORTIONS["abdomen"] / 2, 0.0),
    "spine2": (0.0, PROPORTIONS["abdomen"] / 2, 0.0),
    "spine3": (0.0, PROPORTIONS["chest"] / 2, 0.0),
    "neck": (0.0, PROPORTIONS["chest"] / 2, 0.0),
    "head": (0.0, PROPORTIONS["neck"], 0.0),
    "jaw": (0.0, 0.01, 0.01),
    "eye": (0.02, 0.06, 0.05),
    "collar": (0.0, PROPORTIONS["chest"] / 2, 0.0),
    "shoulder": (PROPORTIONS["shoulder"], 0.0, 0.0),
    "elbow": (PROPORTIONS["upper_arm"], 0.0, 0.0),
    "wrist": (PROPORTIONS["forearm"], 0.0, 0.0),
    "hand": (PROPORTIONS["hand"] / 2, 0.0, 0.0),
    "index1": (0.054, 0.0, 0.012),
    "middle1": (0.054, 0.0, 0.0),
    "ring1": (0.05, 0.0, -0.012),
    "pinky1": (0.044, 0.0, -0.024),
    "thumb1": (0.012, -0.006, 0.016),
}
_JOINT_2, _JOINT_3 = (0.022, 0.0, 0.0), (0.014, 0.0, 0.0)  # of every finger


def mean_joints(tree: Tree) -> np.ndarray:
    """The joints of a model at rest (n_joints, 3), m, on a person of mean height and proportions."""
    joints: dict[str | None, np.ndarray] = {None: np.zeros(3)}
    for joint, parent in tree.items():
        part = joint.removeprefix("left_").removeprefix("right_")
        x, y, z = _OFFSETS.get(part) or (_JOINT_2 if part.endswith("2") else _JOINT_3)
        joints[joint] = joints[parent] + MEAN_HEIGHT * np.array([-x if joint.startswith("right_") else x, y, z])
    return np.array(list(joints.values())[1:])


def shaped_joints(file: Archive, n_joints: int, model: PathLike, betas_key: str) -> np.ndarray:
    """The joints at rest (n_joints, 3), m, of the person of a file, from the file of a model."""
    path = os.fspath(model)
    if "{gender}" in path:
        gender = file.texts("gender", (), (1,))[0].lower().removeprefix("b'").removesuffix("'")
        if gender not in GENDERS:
            raise file.source.error(f"gender: expected {', '.join(GENDERS)}, found {gender[:40]!r}")
        path = path.replace("{gender}", gender)
    at_rest, directions = read_model(path)
    name, found = BY_SIZE[n_joints], BY_SIZE[len(at_rest)]
    if name not in (found, BODY):
        raise file.source.error(f"its poses are of {name}, and the model in {path} is {found}; pass the one of {name}")
    betas = file.numbers(betas_key, (None,), (None, None), (None, 1, None))
    betas = betas.reshape(-1, betas.shape[-1]).mean(axis=0)  # programs estimate them in each frame
    n = min(len(betas), directions.shape[2])
    if betas[n:].any():
        warn(f"betas: the model in {path} has {n} directions of shape, so that only the first {n} betas are used")
    return (at_rest + directions[:, :, :n] @ betas[:n])[:n_joints]


def read_model(path: str) -> tuple[np.ndarray, np.ndarray]:
    """The joints (n_joints, 3) of the mean shape at rest, and how each number moves them (n_joints, 3, n_betas), m.

    The file of a model is read once for the many motions that use it, until it changes.
    """
    status = os.stat(path)
    return _read_model(path, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=8)
def _read_model(path: str, _modified: int, _size: int) -> tuple[np.ndarray, np.ndarray]:
    model = Archive(Source(path, "the file of an SMPL model (.npz)", binary=True))
    # Where it is a pickled sparse matrix, docs/formats.md has the lines that make it a plain array.
    regressor = model.numbers("J_regressor", *((size, None) for size in BY_SIZE))
    n_joints, n_vertices = regressor.shape
    vertices = model.numbers("v_template", (n_vertices, 3))
    directions = model.numbers("shapedirs", (n_vertices, 3, None))
    if BY_SIZE[n_joints] == "SMPL-X" and directions.shape[2] < EXPRESSIONS:
        directions = directions[:, :, :SHAPES_BEFORE_EXPRESSIONS]
    return regressor @ vertices, np.tensordot(regressor, directions, axes=1)


# --- files ----------------------------------------------------------------------------------------------------------


# By the axis that points up: the heading first; degenerate only where a person, with y up at zero, lies on the side.
ROOT_AXES = {"x": "XYZ", "y": "YZX", "z": "ZYX"}
FASTEST, FARTHEST = 15.0, 30.0  # m/s, which no person reaches, and m
# Keys with the same meaning, the best first: in the world before in the camera's axes.
WHOLE = ("pose_world", "poses", "pose", "smpl_poses", "smpl_thetas", "thetas", "theta", "pred_rotmat")
ABOUT_ORIGIN = "Rh"
ROOT, BODIES, JAW = ("root_orient", "global_orient", ABOUT_ORIGIN), ("pose_body", "body_pose"), ("pose_jaw", "jaw_pose")
FINGER_POSES, EYES = ("pose_hand", ("left_hand_pose", "right_hand_pose")), ("pose_eye", ("leye_pose", "reye_pose"))
POSITION = ("trans_world", "trans", "transl", "Th", "smpl_trans", "pred_trans", "cam_trans", "pred_cam_t")
BETAS = ("betas", "shapes", "smpl_betas", "pred_shape")
RATES = ("mocap_framerate", "mocap_frame_rate", "frame_rate", "framerate", "fps")
AT_REST = "joints_at_rest"  # (n_joints, 3), m: the key of `save_smpl`
# A document with such numbers, and not with points: poses have many numbers in one list.
DOCUMENT = re.compile(
    r'\s*[\[{].*"(?:smpl_(?:poses|thetas)|pred_rotmat|body_pose|pose_body|global_orient|root_orient'
    r'|(?:poses?|pose_world|thetas?)"\s*:[\s\[]*(?:[-+.\deE]+\s*,\s*){5})',
    re.DOTALL,
)
N_COLUMNS = 322  # of Motion-X; the columns of each part
COLUMNS = {
    "root_orient": slice(0, 3),
    "pose_body": slice(3, 66),
    "pose_hand": slice(66, 156),
    "pose_jaw": slice(156, 159),
    "transl": slice(309, 312),
    "betas": slice(312, 322),
}
PCA = 78, 87  # numbers of EasyMocap's poses whose hands, after 22 joints, are principal components
N_HANDS, N_FACE = 90, 9  # numbers
ROTATION = 0.01  # largest difference of M·Mᵀ from the identity


def load_amass(
    path: Readable,
    *,
    frame_rate: float | None = None,
    model: PathLike | None = None,
    hands: bool = True,
    on_nan: Literal["raise", "drop"] = "raise",
    up: Up | None = None,
) -> Motion:
    """Read a motion of SMPL, SMPL-H or SMPL-X: of AMASS, or as programs find it in videos or make it from texts.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one: .npz, .json, or .npy of Motion-X; or a folder with a JSON file for each frame.
    frame_rate : float, default=None
        Frames per second, Hz. By default the file's own, which only AMASS has; a number replaces it, with a warning if
        the two differ by more than 1 %.
    model : str or path-like, default=None
        The file of the body model (.npz), from which the lengths of the bones follow with the `betas` of the motion;
        "{gender}" in it becomes female, male or neutral, as the motion states. By default a person of mean height and
        proportions, with a warning.
    hands : bool, default=True
        Whether to read the joints beyond the wrists. Without them motions of SMPL and of SMPL-H have one skeleton.
    on_nan : {"raise", "drop"}, default="raise"
        Refuse a file with NaN or infinite numbers in the poses or `trans`, or leave these frames out. The other frames
        keep their numbers and times, see `Motion.frame_numbers`.
    up : {"x", "y", "z", "-x", "-y", "-z"}, default=None
        The axis of the file's world that points up, as in `load_bvh`. By default the one along which people stand in
        nearly all frames, or else z in files with the key `trans`, as in AMASS, and y in others.

    Returns
    -------
    Motion
        Motion whose skeleton has a ball joint for every joint of the model except the pelvis, which is the root. Its
        columns are rotation vectors, rad, in the order of the model: the file's numbers, unless it has matrices.

    Raises
    ------
    MocapFormatError
        If the file, or the model's, is damaged or of another kind; with its name and the key.
    OSError
        If it cannot be read.

    Warns
    -----
    UserWarning
        If no model is given, the model has fewer directions of shape than the file has `betas`, frames are left out,
        the frame rate is replaced, positions are faster than people, as in centimetres, or an AMASS file has not z up.

    See Also
    --------
    load_motion : Read a motion of any format.
    save_smpl : Write a person's motion in the format of AMASS.
    skpose.datasets.humanoid : The proportions without a model, as a skeleton of its own.

    Notes
    -----
    Poses have 66, 72, 156 or 165 numbers a frame: the body alone, SMPL, SMPL-H or SMPL-X. AMASS, GVHMR, WHAM, TRAM,
    4D-Humans, ROMP, EasyMocap, AIST++ and Kimodo have different keys, and a table of Motion-X has 322 columns. One
    person is read, in the world's axes rather than the camera's. EasyMocap's `Rh` rotates the model about its origin.

    The joints at rest are J = J_regressor · (v_template + shapedirs · betas), all from the model except `betas`. Bones
    are the differences of J, and the root moves along `trans` + J of the pelvis. The models are not free and not part
    of this library: https://smpl.is.tue.mpg.de, https://mano.is.tue.mpg.de and https://smpl-x.is.tue.mpg.de have them.
    Without one, J of the pelvis is unknown as well, so that positions of the root are shifted by one vector (in the
    models by 0.3 m). Files of Kimodo and of `save_smpl` have the joints of their person.

    The root's rotation vectors become angles: the heading, then the lean to a side, then forward, where 90° is upright
    if z is up, since a model's own y axis points up.

    Nothing is unpickled. Models are read once and kept while their file does not change.

    References
    ----------
    .. [1] N. Mahmood, N. Ghorbani, N. F. Troje, G. Pons-Moll, M. J. Black, "AMASS: archive of motion capture as surface
       shapes", ICCV 2019, :doi:`10.1109/ICCV.2019.00554`.
    .. [2] M. Loper, N. Mahmood, J. Romero, G. Pons-Moll, M. J. Black, "SMPL: a skinned multi-person linear model", ACM
       Trans. Graphics 34, 2015, :doi:`10.1145/2816795.2818013`.

    Examples
    --------
    >>> from skpose.io import load_amass
    >>> load_amass("ACCAD/Female1Walking_c3d/B3_-_walk1_poses.npz", model="smplh/{gender}/model.npz")  # doctest: +SKIP
    Motion(415 frames at 120 Hz, 3.5 s, z up, Skeleton(n_joints=51, n_dofs=153))
    """
    check_options(frame_rate=frame_rate, on_nan=on_nan, up=up)
    source = open_source(path, "a file of SMPL parameters", binary=True)
    file = _open(source)
    position_key = find_key(file, POSITION)
    if not position_key:
        raise source.error(f"expected the key 'trans', zeros (n, 3) if it is not known, found {file.list_keys()}")
    rows = _read(file, position_key, on_nan == "raise")
    tree, rate = MODELS[BY_SIZE[rows.shape[1] // 3 - 1]], _frame_rate(file, frame_rate)
    rows, frames = drop_not_finite(rows, np.arange(len(rows)), source)
    position, poses = rows[:, :3], rows[:, 3:]
    if model is not None:
        joints = shaped_joints(file, len(tree), model, find_key(file, BETAS) or BETAS[0])
    elif AT_REST in file.keys:
        joints = file.numbers(AT_REST, (len(tree), 3))
    else:
        warn(
            "bones have the lengths of a person of mean height and proportions, as AMASS files have no skeleton: "
            "model= takes them from the file of an SMPL model and the betas of the motion"
        )
        joints = mean_joints(tree)
    skeleton = smpl_skeleton(tree, joints, hands)
    turns = Rotation.from_rotvec(poses[:, :3].reshape(-1, 3)) if len(poses) else None
    shift = joints[0] if turns is None or ABOUT_ORIGIN not in file.keys else turns.apply(joints[0])
    kept = np.isin([*tree], ["pelvis", *skeleton.joint_names])
    with source.format_errors():
        motion = Motion(
            skeleton,
            poses[:, np.repeat(kept, 3)][:, 3:],
            rate,
            position + shift,
            np.zeros((0, 3)) if turns is None else turns.as_euler("ZYX"),
            "ZYX",
            frames,
            root_name="pelvis",
        )
    speeds = np.linalg.norm(np.diff(position, axis=0), axis=1) * rate
    if len(speeds) and np.median(speeds) > FASTEST and np.ptp(position, axis=0).max() > FARTHEST:
        source.warn(f"{position_key} moves by {np.median(speeds):.3g} m/s in the median frame: is it in metres?")
    axis: Any = up
    if up is None:
        usual = "z" if position_key == "trans" else "y"  # as in AMASS
        axis = find_up(motion, usual)
        if axis != usual == "z":
            source.warn(f"{axis} is taken as up, not z as in AMASS, as {describe_up(axis)}: up='z' keeps that")
    if turns is not None:
        axes = ROOT_AXES[axis[-1]]
        motion = replace(motion, root_angles=continuous_triples(axes, turns), root_axes=axes)
    return stand(motion, axis, source)


def smpl_skeleton(tree: Tree, joints: np.ndarray, hands: bool = True) -> Skeleton:
    """The skeleton of a model with its joints (n_joints, 3) at rest; the pelvis is the root."""
    at_rest: dict[Any, np.ndarray] = dict(zip(tree, joints, strict=True))
    bones = [
        Bone(joint, None if parent == "pelvis" else parent, at_rest[joint] - at_rest[parent], "rotvec")
        for joint, parent in tree.items()
        if parent and (hands or joint not in HANDS)
    ]
    return Skeleton(bones, offset_frame="parent")


def _frame_rate(file: Archive, given: float | None) -> float:
    """The frames per second, Hz, which files have under different keys."""
    key = find_key(file, RATES)
    rate = float(file.numbers(key, (), (1,), finite=given is None).item()) if key else np.nan
    if given is None and not (rate > 0.0 and np.isfinite(1.0 / rate)):
        found = f"{key} of {rate:g}" if key else file.list_keys()
        raise file.source.error(f"expected {RATES[0]}, a positive number, found {found}: pass frame_rate=")
    return choose_rate(file.source, given, rate, key)


def is_smpl(source: Source) -> bool:
    """Whether a file has parameters of a body model; any archive that has no other format counts as one."""
    if source.kind == "npy":
        return f", {N_COLUMNS})" in source.data[:200].decode(errors="replace")
    return source.kind == "zip" or (is_json(source) and DOCUMENT.match(source.head) is not None)


def find_key(file: Archive, keys: Sequence[str]) -> str:
    """The first of the keys that a file has; empty if it has none."""
    return next((key for key in keys if key in file.keys), "")


def _open(source: Source) -> Archive:
    """The arrays of a file by their keys."""
    if source.kind == "npy":
        table = Archive(source).numbers(ARRAY, (None, N_COLUMNS), finite=False)
        return Archive(source, {key: table[:, columns] for key, columns in COLUMNS.items()})
    if source.kind == "text":
        document = parse_json(source)
        if len({*np.diff([last_number(part.name) for part in source.parts])}) > 1:
            raise source.error("expected a file for each frame, found gaps in their numbers")
        stated = {key: document[key] for key in RATES if isinstance(document, dict) and key in document}
        frames = _frames(source, document)
        common = set(frames[0]).intersection(*frames) if frames else set()
        whole = {key: [frame[key] for frame in frames] if len(frames) > 1 else frames[0][key] for key in common}
        return Archive(source, stated | whole)
    file = Archive(source)
    return _of_kimodo(file) if "posed_joints" in file.keys else file


def _frames(source: Source, document: Any) -> list[dict[str, Any]]:
    """The objects with parameters: one, or one of each frame of a list."""
    if isinstance(document, dict) and document.keys() & {*WHOLE, *ROOT}:
        return [document]
    values = {key: value for key, value in document.items() if "incam" not in key} if isinstance(document, dict) else {}
    listed = document if isinstance(document, list) else []
    inside = [found for value in [*values.values(), *listed] if (found := _frames(source, value))]
    counts = [len(found) for found in inside]  # of people
    if (values and len(counts) > 1) or (listed and counts and counts != [1] * len(listed)):
        raise source.error(f"expected one person in each frame, found {sum(counts)} in {len(listed) or 1} frames")
    return [frame for found in inside for frame in found]


def _read(file: Archive, position_key: str, finite: bool) -> np.ndarray:
    """The positions, m, and the rotation vectors of all joints of a model, (n_frames, 3 + 3 n_joints)."""
    position = file.numbers(position_key, (None, 3), (None, 1, 3), finite=finite).reshape(-1, 3)
    if "smpl_scaling" in file.keys:
        position = position / file.numbers("smpl_scaling", (), (1,))

    def read(choices: Sequence[str | tuple[str, str]]) -> np.ndarray:
        for choice in choices:
            keys = (choice,) if isinstance(choice, str) else choice
            if file.keys.issuperset(keys):
                return np.hstack([_vectors(file, key, len(position), finite) for key in keys])
        return np.zeros((len(position), 0))

    found, n_body = read(WHOLE), 3 * len(MODELS[BODY])
    if not found.shape[1]:
        found, hands, face = np.hstack([read(ROOT), read(BODIES)]), read(FINGER_POSES), read(JAW)
        if found.shape[1] == n_body and hands.shape[1] == N_HANDS:  # else principal components
            face = np.hstack([face, read(EYES), np.zeros((len(face), N_FACE))])[:, : N_FACE * bool(face.shape[1])]
            found = np.hstack([found, face, hands])
        elif hands.shape[1]:
            file.source.warn(f"hands of {hands.shape[1]} numbers are principal components, and are left out")
    elif ABOUT_ORIGIN in file.keys:
        if found.shape[1] in PCA:
            file.source.warn("poses: hands are principal components, and are left out")
            found = found[:, :n_body]
        found = np.hstack([read([ABOUT_ORIGIN]), found[:, 3:] if found.shape[1] // 3 in BY_SIZE else found])
    if found.shape[1] not in [3 * size for size in BY_SIZE]:
        widths = " or ".join(str(3 * size) for size in BY_SIZE)
        raise file.source.error(f"expected {widths} numbers a frame, found {found.shape[1]} in {file.list_keys()}")
    return np.hstack([position, found])


def _vectors(file: Archive, key: str, n: int, finite: bool) -> np.ndarray:
    """Rotations under a key, as vectors or matrices, as rotation vectors (n, 3 n_joints)."""
    array = file.numbers(key, (n, None), (n, None, None), (n, None, 3, 3), finite=finite)
    if array.ndim < 3 or array.shape[-2:] != (3, 3):
        return array.reshape(n, -1)
    matrices = array.reshape(-1, 3, 3)
    known = np.isfinite(matrices).all(axis=(1, 2))
    given, found = matrices[known], np.full((len(matrices), 3), np.nan)
    off = np.abs(given @ given.transpose(0, 2, 1) - np.eye(3)).max(initial=0.0)
    if off > ROTATION or (np.linalg.det(given) < 0.0).any():
        raise file.source.error(f"{key}: expected rotation matrices, found others")
    found[known] = Rotation.from_matrix(given).as_rotvec() if len(given) else given[:, 0]
    return found.reshape(n, -1)


def _of_kimodo(file: Archive) -> Archive:
    """The parameters of Kimodo's positions and orientations in the world, which show the joints at rest, too."""
    parents = [list(MODELS[BODY]).index(parent) for parent in MODELS[BODY].values() if parent]
    positions = file.numbers("posed_joints", (None, None, 3))
    n_frames, n, _ = positions.shape
    if n != len(MODELS[BODY]) or not n_frames:
        raise file.source.error(f"expected the 22 joints of SMPL-X, found {n}: kimodo_convert writes BVH of others")
    world, joints = file.numbers("global_rot_mats", (n_frames, n, 3, 3)), np.zeros((n, 3))
    local = np.concatenate([world[:, :1], world[:, parents].swapaxes(-1, -2) @ world[:, 1:]], axis=1)
    for j, parent in enumerate(parents, start=1):
        joints[j] = joints[parent] + world[0, parent].T @ (positions[0, j] - positions[0, parent])
    stated = {key: file.numbers(key, (), (1,)) for key in RATES if key in file.keys}
    return Archive(file.source, stated | {"pred_rotmat": local, "transl": positions[:, 0], AT_REST: joints})
