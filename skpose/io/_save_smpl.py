"""Writer of people's motions on SMPL: poses as in AMASS; joints and vectors as in HumanML3D, which are read, too."""

import os
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from skpose._utils.files import new_file
from skpose._utils.validation import check_choice, check_kind
from skpose.io._amass import AT_REST, BODY, BY_SIZE, MODELS, SMPL_H, Tree, mean_joints, read_model, smpl_skeleton
from skpose.io._bvh import at_joints
from skpose.io._conventions import check_even, quarter_turn
from skpose.io._source import PathLike
from skpose.kinematics import retarget
from skpose.kinematics._anatomy import find_anatomy
from skpose.kinematics._counterparts import counterparts
from skpose.kinematics._orientations import rotations_since_zero
from skpose.skeleton import Motion
from skpose.skeleton._rest import directions_at_zero, positions_at_zero
from skpose.skeleton._root import root_orientations
from skpose.skeleton._rotations import shortest_rotations

ROOT = -1
SPINES = {2: ("spine1", "spine3"), 3: ("spine1", "spine2", "spine3")}  # by the number of joints of a trunk
PARALLEL = np.cos(np.radians(20.0))  # of bones at angle zero in rest poses that are the model's
NEAR = 0.01  # m, of two joints at one place
N_BETAS = 16


def save_smpl(
    path: PathLike,
    motion: Motion,
    *,
    content: Literal["poses", "joints", "vectors"] = "poses",
    model: PathLike | None = None,
) -> None:
    """Write a person's motion on the body model SMPL-H, as an .npz file as in AMASS, or as an array of HumanML3D.

    Parameters
    ----------
    path : str or path-like
        The file, which must not exist yet: .npz for poses, .npy for joints and vectors.
    motion : Motion
        The motion of a person, in any rig.
    content : {"poses", "joints", "vectors"}, default="poses"
        "poses" is AMASS's format, with z up: `poses` (n_frames, 156), rotation vectors; `trans`, m; `betas`, zeros;
        `gender`, neutral; `mocap_framerate`, Hz; and `joints_at_rest`, the person's joints at angle zero.

        "joints" are HumanML3D's positions (n_frames, 22, 3), m, and "vectors" its vectors (n_frames - 1, 263), both at
        20 Hz with y up. The person's lengths are kept; HumanML3D itself gives all people the same lengths.
    model : str or path-like, default=None
        The file of the body model (.npz), on whose legs the motion stands, as programs show it that read `poses` and
        `betas` alone. By default the model has the person's lengths, which `load_amass` reads again.

    Raises
    ------
    ValueError
        If the motion is not a person's, or frames are missing, see `Motion.frame_numbers`.
    OSError
        If the file exists, or cannot be written.

    See Also
    --------
    load_amass : Read the poses again.
    load_keypoints : Read joints, with the layout "humanml22", or vectors.
    skpose.kinematics.retarget : How poses are converted.

    Notes
    -----
    A motion with the joints and the rest pose of SMPL is written as it is, also with a face. Others are retargeted by
    orientations. `trans` is the position of the pelvis minus its position in the model at rest, which only `model`
    states: without it, other programs show people shifted by one vector, in models by 0.3 m along y.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from skpose.datasets import make_gait
    >>> from skpose.io import load_motion, save_smpl
    >>> walk = make_gait(1, 1, random_state=0)[0]
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "walk.npz")
    ...     save_smpl(path, walk)
    ...     again = load_motion(path)
    >>> again.skeleton.n_joints, again.up
    (51, 'z')
    """
    check_kind(motion, Motion, "motion", "Motion(skeleton, poses, frame_rate) makes one of poses")
    check_choice("content", content, ("poses", "joints", "vectors"))
    check_even(motion, "SMPL has")
    with new_file(path) as new, new.open("wb") as file:
        if content == "poses":
            np.savez(file, **_poses(motion, model))
        else:
            joints = _joints(motion if motion.frame_rate == RATE else motion.resample(RATE), model)
            np.save(file, joints if content == "joints" else vectors_of(joints))


def _poses(motion: Motion, model: PathLike | None) -> dict[str, Any]:
    """The arrays of AMASS."""
    motion, tree, joints = _on_smpl(motion, model)
    turn = quarter_turn(motion.up, "z")
    n, at = len(motion), [list(tree).index(name) for name in motion.skeleton.joint_names]
    poses = np.zeros((n, len(tree), 3))
    poses[:, at] = motion.angles.reshape(n, -1, 3)
    if n:
        root = Rotation.from_matrix(turn) * root_orientations(motion.root_angles, motion.root_axes)
        poses[:, 0] = root.as_rotvec()
    return {
        "poses": poses.reshape(n, 3 * len(tree)),
        "trans": motion.root_positions @ turn.T - joints[0],
        "betas": np.zeros(N_BETAS),
        "gender": np.asarray("neutral"),
        "mocap_framerate": np.asarray(motion.frame_rate),
        AT_REST: joints,
    }


def _joints(motion: Motion, model: PathLike | None) -> np.ndarray:
    """The positions (n_frames, 22, 3), y up, of HumanML3D's joints, which the motion may have under these names."""
    if model is not None or not {motion.root_name, *motion.skeleton.joint_names}.issuperset(NAMES):
        motion, _, _ = _on_smpl(motion, model)
    at = dict(zip(motion.skeleton.joint_names, motion.positions().swapaxes(0, 1), strict=True))
    joints = np.stack([at.get(name, motion.root_positions) for name in NAMES], axis=1)
    pelvis, lower, upper = (NAMES.index(name) for name in ("pelvis", *SPINES[3][:2]))
    if np.abs(joints[:, lower] - joints[:, pelvis]).max(initial=0.0) < NEAR:  # no bone without a direction
        joints[:, lower] = (joints[:, lower] + joints[:, upper]) / 2.0
    return joints @ quarter_turn(motion.up, "y").T


def _on_smpl(motion: Motion, model: PathLike | None) -> tuple[Motion, Tree, np.ndarray]:
    """The motion on a model, the tree of the model, and its joints (n_joints, 3) at rest, m."""
    if model is not None:
        joints, _ = read_model(os.fspath(model).replace("{gender}", "neutral"))
        tree = MODELS[BY_SIZE[len(joints)]]
        return retarget(motion, smpl_skeleton(tree, joints), method="auto"), tree, joints
    names = {"pelvis", *motion.skeleton.joint_names}
    for tree in (MODELS[SMPL_H], *MODELS.values()):
        if names <= tree.keys() and _is_of_model(motion, tree):
            at = dict(
                zip(motion.skeleton.joint_names, positions_at_zero(motion.skeleton), strict=False)
            )  # then the root
            joints = np.array([at.get(name, mean) for name, mean in zip(tree, mean_joints(tree), strict=True)])
            return motion.to_rotvec(), tree, joints
    motion = at_joints(motion)
    tree = MODELS[SMPL_H]
    model_skeleton, trunk = smpl_skeleton(tree, mean_joints(tree)), find_anatomy(motion.skeleton).trunk
    given = None
    if len(trunk) in SPINES:  # one for one, also where one is at the root
        given = dict(zip(SPINES[len(trunk)], [motion.skeleton.joint_names[j] for j in trunk], strict=True))
    turned = retarget(motion, model_skeleton, method="orientations", scale=1.0, joints=given)
    joints = _own_joints(motion, turned, tree, counterparts(motion.skeleton, model_skeleton, given).there)
    return replace(turned, skeleton=smpl_skeleton(tree, joints), root_positions=motion.root_positions), tree, joints


def _is_of_model(motion: Motion, tree: Tree) -> bool:
    """Whether a skeleton has the parents and the rest pose of a model."""
    skeleton, usual = motion.skeleton, smpl_skeleton(tree, mean_joints(tree))
    parents = all(tree[bone.name] == (bone.parent or "pelvis") for bone in skeleton.bones)
    at = [usual.joint_names.index(name) for name in skeleton.joint_names]
    cosines = (directions_at_zero(skeleton) * directions_at_zero(usual)[at]).sum(axis=1)
    is_ball = all(bone.n_dofs == 3 and bone.rest_rotation is None for bone in skeleton.bones)
    return parents and is_ball and skeleton.offset_frame == "parent" and bool((cosines > PARALLEL).all())


def _own_joints(motion: Motion, on_model: Motion, tree: Tree, there: np.ndarray) -> np.ndarray:
    """The joints of a model at rest, at the places that the person's have in its poses, in the mean over the frames."""
    turned = rotations_since_zero(
        on_model.skeleton, on_model.angles, root_orientations(on_model.root_angles, on_model.root_axes)
    )
    theirs, at = motion.positions(), {ROOT: motion.root_positions}
    found = {"pelvis": np.zeros(3)}
    for j, (bone, parent) in enumerate(zip(on_model.skeleton.bones, on_model.skeleton.parents.tolist(), strict=True)):
        offset = bone.offset
        if there[j] >= 0:
            offset = turned[parent].inv().apply(theirs[:, there[j]] - at[parent]).mean(axis=0)
        at[j] = at[parent] + turned[parent].apply(offset)
        found[bone.name] = found[bone.parent or "pelvis"] + offset
    return np.array([found[name] for name in tree])


# --- vectors of HumanML3D ---------------------------------------------------------------------------------------------
# C. Guo, S. Zou, X. Zuo, S. Wang, W. Ji, X. Li, L. Cheng, "Generating diverse and natural 3D human motions from text",
# CVPR 2022, doi:10.1109/CVPR52688.2022.00509; https://github.com/EricGuo5513/HumanML3D.
#
# A vector has, of each frame but the last: half the angle of the heading to the next frame, rad; the way of the pelvis
# to the next frame along x and z; the height of the pelvis; positions of the 21 other joints, rotations of their bones,
# each as two columns of a matrix, and velocities of all joints, m a frame; whether ankles and toes stand. Positions,
# rotations and velocities are relative to the heading, which is forward along z.


RATE = 20.0  # Hz
NAMES = tuple(MODELS[BODY])
N_JOINTS = len(NAMES)
EDGES = np.cumsum([0, 1, 2, 1, 3 * (N_JOINTS - 1), 6 * (N_JOINTS - 1), 3 * N_JOINTS, 4])
N_NUMBERS = int(EDGES[-1])
SMOOTH = 20.0  # frames, standard deviation over which the heading is smoothed
STANDS = 0.002  # m², squared way from frame to frame
UP = np.array([0.0, 1.0, 0.0])
# The direction of the bone to each joint where rotations are zero: of legs and arms down, of feet and head forward.
DIRECTIONS = {"hip": (1, 0, 0), "collar": (1, 0, 0), "foot": (0, 0, 1), "head": (0, 0, 1), "neck": (0, 1, 0)}


def joints_of(vectors: np.ndarray) -> np.ndarray:
    """The positions (n_frames, 22, 3), m, y up, of vectors (n_frames, 263)."""
    turns, ways, heights, places = np.split(vectors, EDGES[1:5], axis=1)[:4]
    to_world = _about_up(-2.0 * np.concatenate([np.zeros(1), np.cumsum(turns[:-1, 0])]))
    steps = np.zeros((len(vectors), 3))
    steps[1:, [0, 2]] = ways[:-1]
    root = np.cumsum(to_world.apply(steps), axis=0)
    others = _turned(to_world, places.reshape(-1, N_JOINTS - 1, 3)) + root[:, None]
    root[:, 1] = heights[:, 0]
    return np.concatenate([root[:, None], others], axis=1)


def vectors_of(joints: np.ndarray) -> np.ndarray:
    """The vectors (n_frames - 1, 263) of positions (n_frames, 22, 3), m, y up, at 20 Hz.

    The motion begins at the origin, forward along z, and its lowest point is at height zero.
    """
    joints = joints - [1.0, 0.0, 1.0] * joints[0, 0] - [0.0, joints[..., 1].min(), 0.0]
    joints = _turned(_headings(joints[:1], 0.0), joints)
    headings = _headings(joints, SMOOTH)
    headings = Rotation.concatenate([Rotation.identity(1), headings[1:]])
    n, steps = len(joints) - 1, np.diff(joints, axis=0)
    ways = headings[1:].apply(steps[:, 0])[:, [0, 2]]
    angles = (headings[1:] * headings[:-1].inv()).as_rotvec()[:, 1:2] / 2.0
    places = _turned(headings, joints - joints[:, :1] * [1.0, 0.0, 1.0])[:-1, 1:]
    feet = [NAMES.index(f"{side}_{name}") for side in ("left", "right") for name in ("ankle", "foot")]
    stands = (np.square(steps[:, feet]).sum(axis=2) < STANDS).astype(np.float64)
    velocities = _turned(headings[:-1], steps)
    parts = places, _rotations(headings.as_matrix(), joints)[:-1], velocities
    return np.hstack([angles, ways, joints[:-1, 0, 1:2], *(part.reshape(n, -1) for part in parts), stands])


def _headings(joints: np.ndarray, smooth: float) -> Rotation:
    """The rotations (n_frames,) about y that take forward, by hips and shoulders, to z."""
    across = sum(
        joints[:, NAMES.index(f"right_{name}")] - joints[:, NAMES.index(f"left_{name}")] for name in ("hip", "shoulder")
    )
    forward = np.cross(UP, across / np.linalg.norm(across, axis=1, keepdims=True))
    if smooth:
        forward = gaussian_filter1d(forward, smooth, axis=0, mode="nearest")
    return _about_up(-np.arctan2(forward[:, 0], forward[:, 2]))


def _rotations(headings: np.ndarray, joints: np.ndarray) -> np.ndarray:
    """Two columns (n_frames, 21, 6) of the rotation of each bone relative to the one before it, or to the heading."""
    world, found = {"pelvis": headings}, []
    for name, parent in list(MODELS[BODY].items())[1:]:
        part = name.split("_")[-1]
        rest = np.array(DIRECTIONS.get(part, UP if part.startswith("spine") else -UP), dtype=float)
        rest = rest * [-1, 1, 1] if name.startswith("right") else rest
        bone = joints[:, NAMES.index(name)] - joints[:, NAMES.index(str(parent))]
        size = np.linalg.norm(bone, axis=1, keepdims=True)
        # A bone without a length is at rest.
        ends = np.where(size > 0.0, bone, rest) / np.where(size > 0.0, size, 1.0)
        world[name] = shortest_rotations(rest, ends).as_matrix()
        before = headings if part == "collar" else world[str(parent)]  # limbs begin at the heading
        found.append((before.swapaxes(1, 2) @ world[name])[:, :, :2].swapaxes(1, 2).reshape(-1, 6))
    return np.stack(found, axis=1)


def _about_up(angles: np.ndarray) -> Rotation:
    return Rotation.from_rotvec(angles[:, None] * UP)


def _turned(turns: Rotation, points: np.ndarray) -> np.ndarray:
    """Points (n_frames, n_points, 3) after the rotation of each frame, or of the only one."""
    return points @ turns.as_matrix().swapaxes(1, 2)
