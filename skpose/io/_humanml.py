"""HumanML3D: 22 joints of SMPL at 20 Hz, and the vectors of 263 numbers that generators of motions use.

C. Guo, S. Zou, X. Zuo, S. Wang, W. Ji, X. Li, L. Cheng, "Generating diverse and natural 3D human motions from text",
CVPR 2022, doi:10.1109/CVPR52688.2022.00509; https://github.com/EricGuo5513/HumanML3D.

A vector has, of each frame but the last: half the angle of the heading to the next frame, rad; the way of the pelvis to
the next frame along x and z; the height of the pelvis; positions of the 21 other joints, rotations of their bones, each
as two columns of a matrix, and velocities of all joints, m a frame; whether ankles and toes stand. Positions, rotations
and velocities are relative to the heading, which is forward along z.
"""

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from skpose.io._amass import BODY, MODELS
from skpose.keypoints._rest_pose import shortest_rotations

RATE = 20.0  # Hz
NAMES = tuple(MODELS[BODY])
N_JOINTS = len(NAMES)
EDGES = np.cumsum([0, 1, 2, 1, 3 * (N_JOINTS - 1), 6 * (N_JOINTS - 1), 3 * N_JOINTS, 4])
N_NUMBERS = int(EDGES[-1])
SMOOTH = 20.0  # frames, standard deviation over which the heading is smoothed
STANDS = 0.002  # m², squared way from frame to frame
UP = np.array([0.0, 1.0, 0.0])
# The direction of the bone to each joint where rotations are zero: of legs and arms down, of feet and head forward.
AT_REST = {"hip": (1, 0, 0), "collar": (1, 0, 0), "foot": (0, 0, 1), "head": (0, 0, 1), "neck": (0, 1, 0)}


def joints_of(vectors: np.ndarray) -> np.ndarray:
    """The positions (n_frames, 22, 3), m, y up, of vectors (n_frames, 263)."""
    turns, ways, heights, places = np.split(vectors, EDGES[1:5], axis=1)[:4]
    before = np.concatenate([np.zeros(1), np.cumsum(turns[:-1, 0])])
    to_world = _about_up(-2.0 * before)
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
        rest = np.array(AT_REST.get(part, UP if part.startswith("spine") else -UP), dtype=float)
        bone = joints[:, NAMES.index(name)] - joints[:, NAMES.index(str(parent))]
        ends = bone / np.linalg.norm(bone, axis=1, keepdims=True)
        world[name] = shortest_rotations(rest * [-1, 1, 1] if name.startswith("right") else rest, ends)
        before = headings if part == "collar" else world[str(parent)]  # limbs begin at the heading
        found.append((before.swapaxes(1, 2) @ world[name])[:, :, :2].swapaxes(1, 2).reshape(-1, 6))
    return np.stack(found, axis=1)


def _about_up(angles: np.ndarray) -> Rotation:
    return Rotation.from_rotvec(angles[:, None] * UP)


def _turned(turns: Rotation, points: np.ndarray) -> np.ndarray:
    """Points (n_frames, n_points, 3) after the rotation of each frame, or of the only one."""
    return points @ turns.as_matrix().swapaxes(1, 2)
