"""The joints of the body models SMPL, SMPL-H and SMPL-X, and where they are on a person.

M. Loper, N. Mahmood, J. Romero, G. Pons-Moll, M. J. Black, "SMPL: a skinned multi-person linear model", ACM Trans.
Graphics 34, 2015, doi:10.1145/2816795.2818013. At rest a model stands as a T, with x to its left, y up and z forward.
"""

import os
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from skpose._utils.warnings import warn
from skpose.io._arrays import Archive
from skpose.io._source import PathLike, Source
from skpose.skeleton._proportions import MEAN_HEIGHT, PROPORTIONS

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


class Body(NamedTuple):
    """The joints at rest as functions of the shape: those of the mean shape, and how each number of it moves them."""

    joints: np.ndarray  # (n_joints, 3), m
    directions: np.ndarray  # (n_joints, 3, n_betas), m


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
    body = read_model(path)
    name, found = BY_SIZE[n_joints], BY_SIZE[len(body.joints)]
    if name not in (found, BODY):
        raise file.source.error(f"its poses are of {name}, and the model in {path} is {found}; pass the one of {name}")
    betas = file.numbers(betas_key, (None,), (None, None), (None, 1, None))
    betas = betas.reshape(-1, betas.shape[-1]).mean(axis=0)  # programs estimate them in each frame
    n = min(len(betas), body.directions.shape[2])
    if betas[n:].any():
        warn(f"betas: the model in {path} has {n} directions of shape, so that only the first {n} betas are used")
    return (body.joints + body.directions[:, :, :n] @ betas[:n])[:n_joints]


def read_model(path: str) -> Body:
    """Read the file of a model, once for the many motions that use it, until it changes."""
    status = os.stat(path)
    return _read_model(path, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=8)
def _read_model(path: str, _modified: int, _size: int) -> Body:
    source = Source(path, "the file of an SMPL model (.npz)", binary=True)
    model = Archive(source)
    sizes = [(size, None) for size in BY_SIZE]
    # Where it is a pickled sparse matrix, docs/formats.md has the lines that make it a plain array.
    regressor = model.numbers("J_regressor", *sizes)
    n_joints, n_vertices = regressor.shape
    vertices = model.numbers("v_template", (n_vertices, 3))
    directions = model.numbers("shapedirs", (n_vertices, 3, None))
    if BY_SIZE[n_joints] == "SMPL-X" and directions.shape[2] < EXPRESSIONS:
        directions = directions[:, :, :SHAPES_BEFORE_EXPRESSIONS]
    return Body(regressor @ vertices, np.tensordot(regressor, directions, axes=1))
