"""Writer of people's motions on SMPL: poses as in AMASS, joints and vectors as in HumanML3D."""

import os
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.files import check_new, new_file
from skpose._utils.validation import check_choice, check_kind
from skpose.io._amass import AT_REST, BY_SIZE, MODELS, SMPL_H, Tree, mean_joints, read_model, smpl_skeleton
from skpose.io._bvh import load_bvh
from skpose.io._conventions import check_even, quarter_turn
from skpose.io._humanml import NAMES, RATE, vectors_of
from skpose.io._save import save_bvh
from skpose.io._source import PathLike
from skpose.kinematics import retarget
from skpose.kinematics._anatomy import find_anatomy
from skpose.kinematics._counterparts import counterparts
from skpose.kinematics._orientations import rotations_since_zero
from skpose.skeleton import Motion
from skpose.skeleton._rest import directions_at_zero, positions_at_zero
from skpose.skeleton._root import root_orientations

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
    check_new(path)
    check_even(motion, "SMPL has")
    write: Any
    if content == "poses":
        write = partial(np.savez, **_poses(motion, model))
    else:
        joints = _joints(motion if motion.frame_rate == RATE else motion.resample(RATE), model)
        write = partial(np.save, arr=joints if content == "joints" else vectors_of(joints))
    with new_file(path) as new, new.open("wb") as file:
        write(file)


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
        joints = read_model(os.fspath(model).replace("{gender}", "neutral")).joints
        tree = MODELS[BY_SIZE[len(joints)]]
        return retarget(motion, smpl_skeleton(tree, joints), method="auto"), tree, joints
    names = {"pelvis", *motion.skeleton.joint_names}
    for tree in (MODELS[SMPL_H], *MODELS.values()):
        if names <= tree.keys() and _is_of_model(motion, tree):
            joints = mean_joints(tree)
            zero, own = positions_at_zero(motion.skeleton), motion.skeleton.joint_names
            joints = np.array(
                [zero[own.index(name)] if name in own else at for name, at in zip(tree, joints, strict=True)]
            )
            return motion.to_rotvec(), tree, joints
    if motion.skeleton.offset_frame == "own":  # in BVH joints are where they rotate, as in models
        with TemporaryDirectory() as folder:
            save_bvh(Path(folder, "a.bvh"), motion, up=motion.up)
            motion = load_bvh(Path(folder, "a.bvh"), up=motion.up)
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
