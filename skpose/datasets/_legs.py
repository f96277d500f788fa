"""Inverse kinematics of the humanoid's legs in closed form."""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton import Skeleton

STRAIGHT = 0.9985  # longest reach in lengths of the leg: the knee keeps 6°


class Leg(NamedTuple):
    """Lengths of a leg, m."""

    hip: np.ndarray  # (3,) from the root
    thigh: float
    shank: float
    foot: np.ndarray  # (3,) from the ankle to the ball

    @classmethod
    def of(cls, skeleton: Skeleton, side: str) -> "Leg":
        offset = dict(zip(skeleton.joint_names, skeleton.offsets.copy(), strict=True))  # writable for scipy
        thigh, shank = (float(np.linalg.norm(offset[f"{side}_{name}"])) for name in ("thigh", "shank"))
        return cls(offset[f"{side}_pelvis"], thigh, shank, offset[f"{side}_foot"])

    @property
    def length(self) -> float:
        """From hip to ankle."""
        return self.thigh + self.shank


def knee_of(leg: Leg, distance: np.ndarray) -> np.ndarray:
    """The flexion of the knee, rad, at a distance from hip to ankle."""
    cosine = (leg.thigh**2 + leg.shank**2 - distance**2) / (2.0 * leg.thigh * leg.shank)
    return np.pi - np.arccos(np.clip(cosine, -1.0, 1.0))


def reach_of(leg: Leg, knee: np.ndarray) -> np.ndarray:
    """The distance from hip to ankle at a flexion of the knee."""
    return np.sqrt(leg.thigh**2 + leg.shank**2 + 2.0 * leg.thigh * leg.shank * np.cos(knee))


def solve_leg(
    leg: Leg, root: np.ndarray, pelvis: Rotation, ball: np.ndarray, foot: Rotation
) -> dict[str, Rotation | np.ndarray]:
    """The joints of a leg with the ball of the foot at `ball` (n, 3) and the foot rotated as `foot`.

    A leg has six dofs, as the foot has: the knee gives the distance from hip to ankle, the hip its direction and the
    rotation of the leg about it, which follows from the foot because the ankle does not rotate about the shank. A
    straight leg reaches for a foot too far away. Of two solutions, the knee points less to the side.
    """
    to_ankle = pelvis.inv().apply(ball - foot.apply(leg.foot) - root) - leg.hip
    distance = np.linalg.norm(to_ankle, axis=1, keepdims=True)
    direction = to_ankle / distance
    knee = knee_of(leg, np.minimum(distance[:, 0], STRAIGHT * leg.length))
    bent = Rotation.from_rotvec(np.outer(knee, [1.0, 0.0, 0.0]))
    # The leg with its hip at zero, in the plane of y and z, and with its knee in front.
    zero = np.array([0.0, -leg.thigh, 0.0]) + bent.apply([0.0, -leg.shank, 0.0])
    before = _frames(zero / np.linalg.norm(zero, axis=1, keepdims=True))
    in_front = _frames(direction) * before.inv()
    # Rotate it about the line from hip to ankle until the foot's x and the shank's z are perpendicular.
    z, across = (in_front * bent).apply([0.0, 0.0, 1.0]), (pelvis.inv() * foot).apply([1.0, 0.0, 0.0])
    along = np.sum(z * direction, axis=1, keepdims=True) * direction
    constant, cosines, sines = (
        np.sum(part * across, axis=1) for part in (along, z - along, np.cross(direction, z - along))
    )
    phase, size = np.arctan2(sines, cosines), np.hypot(cosines, sines)
    opening = np.arccos(np.clip(-constant / np.maximum(size, 1e-12), -1.0, 1.0))
    both = np.angle(np.exp(1j * np.stack([phase + opening, phase - opening])))
    about = np.take_along_axis(both, np.abs(both).argmin(axis=0)[None], axis=0)[0]
    hip = Rotation.from_rotvec(about[:, None] * direction) * in_front
    R = ((hip * bent).inv() * pelvis.inv() * foot).as_matrix()
    ankle = np.stack([np.arctan2(R[:, 2, 1], R[:, 2, 2]), np.arctan2(R[:, 1, 0], R[:, 0, 0])], axis=1)
    return {"thigh": hip, "shank": knee[:, None], "foot": ankle}


def _frames(along: np.ndarray) -> Rotation:
    """Rotations of -y to unit vectors (n, 3) that keep x as near as possible."""
    x = np.array([1.0, 0.0, 0.0]) - along[:, :1] * along
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return Rotation.from_matrix(np.stack([x, -along, np.cross(x, -along)], axis=2))
