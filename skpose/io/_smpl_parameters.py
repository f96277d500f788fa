"""Parameters of the body models as programs write them: rotations of the joints and positions of the body.

AMASS, GVHMR, WHAM, TRAM, 4D-Humans, ROMP, EasyMocap, AIST++, Motion-X and Kimodo have the same numbers under other
keys, as rotation vectors or matrices, as arrays or JSON. EasyMocap's Rh rotates a body about the origin of the model,
the others about its pelvis.
"""

import re
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.io._arrays import Archive, Shape, read_array
from skpose.io._keypoints_json import is_json, parse_json
from skpose.io._smpl import BODY, BY_SIZE, MODELS, Tree
from skpose.io._source import Source

# Keys with the same meaning, the best first: in the world before in the camera's axes.
WHOLE = ("pose_world", "poses", "pose", "smpl_poses", "smpl_thetas", "thetas", "theta", "pred_rotmat")
ROOT, BODIES = ("root_orient", "global_orient"), ("pose_body", "body_pose")
ABOUT_ORIGIN = "Rh"
POSITION = ("trans_world", "trans", "transl", "Th", "smpl_trans", "pred_trans", "cam_trans", "pred_cam_t")
BETAS = ("betas", "shapes", "smpl_betas", "pred_shape")
RATES = ("mocap_framerate", "mocap_frame_rate", "frame_rate", "framerate", "fps")
HANDS = (("pose_hand",), ("left_hand_pose", "right_hand_pose"))
JAW, EYES = ("pose_jaw", "jaw_pose"), (("pose_eye",), ("leye_pose", "reye_pose"))
KEYS = {*WHOLE, *ROOT, *BODIES, ABOUT_ORIGIN}
AT_REST = "joints_at_rest"  # (n_joints, 3), m: the key of `save_smpl`
# A document with such numbers, and not with points: poses have many numbers in one list.
DOCUMENT = re.compile(
    r'\s*[\[{].*"(?:smpl_(?:poses|thetas)|pred_rotmat|body_pose|pose_body|global_orient|root_orient'
    r'|(?:poses?|pose_world|thetas?)"\s*:[\s\[]*(?:[-+.\deE]+\s*,\s*){5})',
    re.DOTALL,
)
COLUMNS = {"root_orient": 0, "pose_body": 3, "pose_hand": 66, "pose_jaw": 156, "transl": 309, "betas": 312}
ENDS = (3, 66, 156, 159, 312, 322)  # of these columns of Motion-X
N_COLUMNS = ENDS[-1]
PCA = 78, 87  # numbers of EasyMocap's poses whose hands, after 22 joints, are principal components
SHAPES: tuple[Shape, ...] = ((None, None), (None, None, None), (None, None, 3, 3))
ROTATION = 0.01  # largest difference of M·Mᵀ from the identity


class Parameters(NamedTuple):
    """The motion of a body model."""

    tree: Tree
    rotations: np.ndarray  # (n_frames, 3 n_joints), rotation vectors
    position: np.ndarray  # (n_frames, 3), m
    position_key: str
    joints: np.ndarray | None  # (n_joints, 3) at rest, m, if the file states them
    is_about_origin: bool


def is_smpl(source: Source) -> bool:
    """Whether a file has parameters of a body model; any archive that has no other format counts as one."""
    if source.kind == "npy":
        return f"{N_COLUMNS})" in source.data[:200].decode(errors="replace")
    return source.kind == "zip" or (is_json(source) and DOCUMENT.match(source.head) is not None)


def open_arrays(source: Source) -> Archive:
    """The arrays of a file by their keys."""
    if source.kind == "npy":
        table = read_array(source, (None, N_COLUMNS))
        return Archive(source, {key: table[:, i:j] for (key, i), j in zip(COLUMNS.items(), ENDS, strict=True)})
    return Archive(source, None if source.kind == "zip" else _of_document(source))


def _of_document(source: Source) -> dict[str, np.ndarray]:
    """The arrays of a JSON file: an object has them, or each frame of a list has its own."""
    document = parse_json(source)
    frames = list(_frames(source, document))
    stated = {key: document[key] for key in RATES if isinstance(document, dict) and key in document}
    keys = {*POSITION, *BETAS, *KEYS, *RATES, "gender", *JAW, *sum((*HANDS, *EYES), ())}
    with source.format_errors():
        if len(frames) == 1:
            return {key: np.array(value) for key, value in (stated | frames[0]).items() if key in keys}
        common = keys.intersection(*frames)
        return {key: np.array(value) for key, value in stated.items()} | {
            key: np.array([frame[key] for frame in frames]) for key in common
        }


def _frames(source: Source, document: Any) -> Iterator[dict[str, Any]]:
    """Yield the objects with parameters: one, or one of each frame of a list."""
    if isinstance(document, dict) and not document.keys() & KEYS:
        values = [value for key, value in document.items() if isinstance(value, dict | list) and "incam" not in key]
        inside = [value for value in values if any(_frames(source, value))]
        if len(inside) > 1:
            raise source.error(f"expected one person, found {len(inside)}")
        document = next(iter(inside), [])
    if isinstance(document, dict):
        yield document
    for frame in document if isinstance(document, list) else ():
        people = list(_frames(source, frame))
        if len(people) > 1:
            raise source.error(f"expected one person in each frame, found {len(people)}")
        yield from people


def find_key(file: Archive, keys: Sequence[str]) -> str:
    """The first of the keys that a file has; empty if it has none."""
    return next((key for key in keys if key in file.keys), "")


def read_parameters(file: Archive, finite: bool) -> Parameters:
    """Read the parameters of a file, which must be finite or not."""
    if "posed_joints" in file.keys:
        return _of_kimodo(file)
    key = find_key(file, POSITION)
    if not key:
        raise file.source.error(f"expected the key 'trans', zeros (n, 3) if it is not known, found {file.list_keys()}")
    position = file.numbers(key, (None, 3), (None, 1, 3), finite=finite).reshape(-1, 3)
    if "smpl_scaling" in file.keys:
        position = position / file.numbers("smpl_scaling", (), (1,))
    rotations = _rotations(file, len(position), finite)
    name = BY_SIZE[rotations.shape[1] // 3]
    joints = file.numbers(AT_REST, (len(MODELS[name]), 3)) if AT_REST in file.keys else None
    return Parameters(MODELS[name], rotations, position, key, joints, ABOUT_ORIGIN in file.keys)


def _rotations(file: Archive, n: int, finite: bool) -> np.ndarray:
    """The rotation vectors (n, 3 n_joints) of all joints of a model."""
    root = find_key(file, (*ROOT, ABOUT_ORIGIN))
    if whole := find_key(file, WHOLE):
        found = _vectors(file, whole, n, finite)
        if found.shape[1] in PCA:
            file.source.warn(f"{whole}: hands are principal components, and are left out")
            found = found[:, : 3 * len(MODELS[BODY])]
        if root == ABOUT_ORIGIN:
            turns = _vectors(file, root, n, finite)
            found = np.hstack([turns, found[:, 3:] if found.shape[1] // 3 in BY_SIZE else found])
    else:
        whole = find_key(file, BODIES)
        if not root or not whole:
            raise file.source.error(f"expected poses, or global_orient and body_pose, found {file.list_keys()}")
        found = np.hstack([_vectors(file, key, n, finite) for key in (root, whole)])
        if found.shape[1] == 3 * len(MODELS[BODY]):
            found = np.hstack([found, *_face_and_hands(file, n, finite)])
    if found.shape[1] not in [3 * size for size in BY_SIZE]:
        widths = " or ".join(str(3 * size) for size in BY_SIZE)
        raise file.source.error(f"{whole}: expected {widths} numbers with those of the root, found {found.shape[1]}")
    return found


def _face_and_hands(file: Archive, n: int, finite: bool) -> list[np.ndarray]:
    """The rotation vectors of face and fingers; none without fingers."""

    def read(choices: Sequence[Sequence[str]]) -> np.ndarray:
        keys = next((keys for keys in choices if file.keys.issuperset(keys)), ())
        return np.hstack([np.zeros((n, 0)), *(_vectors(file, key, n, finite) for key in keys)])

    hands, eyes = read(HANDS), read(EYES)
    if hands.shape[1] != 90:  # principal components
        return []
    jaw = find_key(file, JAW)
    if not jaw:
        return [hands]
    return [_vectors(file, jaw, n, finite), eyes if eyes.shape[1] else np.zeros((n, 6)), hands]


def _vectors(file: Archive, key: str, n: int, finite: bool) -> np.ndarray:
    """Rotations (n, ...) under a key as rotation vectors (n, 3 n_joints)."""
    shapes = [(n, *shape[1:]) for shape in SHAPES]
    array = file.numbers(key, *shapes, finite=finite)
    if array.shape[-2:] != (3, 3) or array.ndim < 3:
        return array.reshape(n, -1)
    return _from_matrices(file, key, array).reshape(n, -1)


def _from_matrices(file: Archive, key: str, array: np.ndarray) -> np.ndarray:
    """Rotation vectors (n, 3) of matrices (..., 3, 3), NaN where these are not finite."""
    matrices = array.reshape(-1, 3, 3)
    known = np.isfinite(matrices).all(axis=(1, 2))
    given = matrices[known]
    off = np.abs(given @ given.transpose(0, 2, 1) - np.eye(3)).max(initial=0.0)
    if off > ROTATION or (np.linalg.det(given) < 0.0).any():
        raise file.source.error(f"{key}: expected rotation matrices, found others")
    found = np.full((len(matrices), 3), np.nan)
    found[known] = Rotation.from_matrix(given).as_rotvec() if len(given) else given[:, 0]
    return found


def _of_kimodo(file: Archive) -> Parameters:
    """The parameters of Kimodo's positions and orientations in the world."""
    tree = MODELS[BODY]
    parents = [list(tree).index(parent) for parent in tree.values() if parent]
    positions = file.numbers("posed_joints", (None, None, 3))
    n = positions.shape[1]
    if n != len(tree) or not len(positions):
        raise file.source.error(f"expected the 22 joints of SMPL-X, found {n}: kimodo_convert writes BVH of others")
    world = file.numbers("global_rot_mats", (len(positions), n, 3, 3))
    local = np.concatenate([world[:, :1], world[:, parents].swapaxes(-1, -2) @ world[:, 1:]], axis=1)
    rotations = _from_matrices(file, "global_rot_mats", local).reshape(len(positions), -1)
    joints = np.zeros((n, 3))
    for j, parent in enumerate(parents, start=1):
        joints[j] = joints[parent] + world[0, parent].T @ (positions[0, j] - positions[0, parent])
    return Parameters(tree, rotations, positions[:, 0], "posed_joints", joints, False)
