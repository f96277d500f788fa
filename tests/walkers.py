"""People whose steps are known: feet are put where they stand, and the legs follow, without the library."""

import numpy as np
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton

THIGH, SHANK, HIP = 0.45, 0.45, 0.09  # m
FOOT = 0.15  # m, from the ankle to where the toes begin
HEIGHT, ANKLE = 0.84, 0.08  # m, of hips and ankles above the floor
UP = np.array([0.0, HEIGHT, 0.0])

BONES = [
    Bone("left_hip", None, (HIP, 0.0, 0.0)),
    Bone("left_knee", "left_hip", (0.0, -THIGH, 0.0), "rotvec"),
    Bone("left_ankle", "left_knee", (0.0, -SHANK, 0.0), "rotvec"),
    Bone("left_foot", "left_ankle", (0.0, 0.0, FOOT), "rotvec"),
    Bone("right_hip", None, (-HIP, 0.0, 0.0)),
    Bone("right_knee", "right_hip", (0.0, -THIGH, 0.0), "rotvec"),
    Bone("right_ankle", "right_knee", (0.0, -SHANK, 0.0), "rotvec"),
    Bone("right_foot", "right_ankle", (0.0, 0.0, FOOT), "rotvec"),
    Bone("spine1", None, (0.0, 0.15, 0.0)),
    Bone("neck", "spine1", (0.0, 0.4, 0.0)),
    Bone("head", "neck", (0.0, 0.1, 0.0)),
]
SKELETON = Skeleton(BONES)
ORDERS = {"x": "xzy", "y": "xzy", "z": "xyz"}  # that are far from gimbal lock


def rotation_to(start, ends):
    """The smallest rotations of one direction to others (n, 3)."""
    ends = ends / np.linalg.norm(ends, axis=1, keepdims=True)
    axis = np.cross(start, ends)
    sine = np.linalg.norm(axis, axis=1)
    angle = np.arctan2(sine, ends @ start)
    return Rotation.from_rotvec(axis / np.maximum(sine, 1e-12)[:, None] * angle[:, None])


def rotation_about(axis, angles):
    return Rotation.from_rotvec(np.outer(angles, axis))


def walk(
    step=0.6,
    cadence=110.0,
    stance=0.62,
    width=0.12,
    duration=6.0,
    rate=100.0,
    turn=0.0,
    phase=0.5,
    up="y",
    heading=0.0,
    facing=0.0,
):
    """Return a motion of walking with steps (m), cadence (steps/min), share of stance, width (m) and turn (rad/s).

    `phase` is where in the stride of the left foot the right one comes down, and the left one comes down at time 0.
    `facing` is by how much the person faces to the left of the path (rad): by π, one walks backwards.
    A foot is in the air with a constant velocity. The path begins at an angle `heading` (rad).
    """
    stride = 120.0 / cadence
    speed = 2.0 * step / stride
    times = np.arange(round(duration * rate) + 1) / rate

    def path(t):
        """Positions (n, 3) along the floor and headings, with y up, at first along z."""
        angle = heading + turn * t
        radius = 1e9 if turn == 0.0 else speed / turn
        if turn == 0.0:
            place = np.multiply.outer(speed * t, [np.sin(heading), 0.0, np.cos(heading)])
        else:
            z, x = np.sin(angle) - np.sin(heading), -np.cos(angle) + np.cos(heading)
            place = radius * np.stack([x, 0.0 * t, z], axis=-1)
        return place, angle

    pelvis, yaw = path(times)
    root = rotation_about([0.0, 1.0, 0.0], yaw + facing)
    columns = []
    for sign, lag in ((1.0, 0.0), (-1.0, phase)):
        number = np.floor(times / stride - lag)
        since = times / stride - lag - number  # of the stride since the contact

        def stand(n, sign=sign, lag=lag):
            """Positions and headings of the foot in its stance n: where the path is in the middle of it."""
            place, angle = path((n + lag + stance / 2.0) * stride)
            angle = angle + facing
            return place + rotation_about([0.0, 1.0, 0.0], angle).apply([sign * width / 2.0, ANKLE, 0.0]), angle

        here, there = stand(number), stand(number + 1.0)
        swing = np.clip((since - stance) / (1.0 - stance), 0.0, 1.0)
        ankle = here[0] + swing[:, None] * (there[0] - here[0])
        ankle[:, 1] += 0.12 * np.sin(np.pi * swing)
        foot = rotation_about([0.0, 1.0, 0.0], here[1] + swing * (there[1] - here[1]))
        columns += leg(root, pelvis, ankle, foot, sign)
    turned = Rotation.from_matrix(np.roll(np.eye(3), "xyz".index(up) - 1, axis=0))
    return Motion(
        SKELETON,
        np.concatenate(columns, axis=1),
        rate,
        turned.apply(pelvis + UP),
        (turned * root).as_euler(ORDERS[up]),
        ORDERS[up],
        up=up,
    )


def leg(root, pelvis, ankle, foot, sign):
    """Return the rotation vectors of thigh, shank and foot, the knee in front."""
    hip = pelvis + UP + root.apply([sign * HIP, 0.0, 0.0])
    line = root.inv().apply(ankle - hip)
    length = np.linalg.norm(line, axis=1, keepdims=True)
    assert (length < THIGH + SHANK).all()
    along = line / length
    ahead = np.array([0.0, 0.0, 1.0]) - along * along[:, 2:]
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    reach = (THIGH**2 - SHANK**2 + length**2) / (2.0 * length)
    knee = along * reach + ahead * np.sqrt(THIGH**2 - reach**2)
    down = np.array([0.0, -1.0, 0.0])
    thigh, shank = rotation_to(down, knee), rotation_to(down, line - knee)
    return [thigh.as_rotvec(), (thigh.inv() * shank).as_rotvec(), (shank.inv() * root.inv() * foot).as_rotvec()]
