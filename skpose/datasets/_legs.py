"""The legs of the humanoid: its joint angles for a pelvis and a foot that are somewhere, in closed form."""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton import Skeleton

STRAIGHT = 0.9985  # of the leg's length, as far as it stretches: the knee keeps 6°


class Leg(NamedTuple):
    """Lengths of a leg, m."""

    hip: np.ndarray  # (3,) from the root
    thigh: float
    shank: float
    foot: np.ndarray  # (3,) from the ankle to the ball

    @classmethod
    def of(cls, skeleton: Skeleton, side: str) -> "Leg":
        """Return the leg of a humanoid."""
        offset = dict(zip(skeleton.joint_names, skeleton.offsets.copy(), strict=True))  # writeable, as scipy asks
        thigh, shank = (float(np.linalg.norm(offset[f"{side}_{name}"])) for name in ("thigh", "shank"))
        return cls(offset[f"{side}_pelvis"], thigh, shank, offset[f"{side}_foot"])

    @property
    def length(self) -> float:
        """From hip to ankle."""
        return self.thigh + self.shank


class LegAngles(NamedTuple):
    """Rotations of a leg's joints; angles in rad."""

    hip: Rotation
    knee: np.ndarray  # flexion, not negative
    ankle: np.ndarray  # (n, 2): about x, then about z


def solve_leg(leg: Leg, root: np.ndarray, pelvis: Rotation, ball: np.ndarray, foot: Rotation) -> LegAngles:
    """Return the angles at which the ball of the foot is at `ball` (n, 3), and the foot is rotated as `foot`.

    A leg has six dofs, as the foot has: the knee gives the distance from hip to ankle, the hip its direction and the
    rotation of the leg about it, which follows from the foot, as the ankle has no rotation about the shank. A foot too
    far away is reached for by a straight leg. Of two solutions it is the one whose knee is less to the side.
    """
    to_ankle = pelvis.inv().apply(ball - foot.apply(leg.foot) - root) - leg.hip
    distance = np.linalg.norm(to_ankle, axis=1, keepdims=True)
    direction = to_ankle / distance
    reached = np.minimum(distance[:, 0], STRAIGHT * leg.length)
    cosine = (leg.thigh**2 + leg.shank**2 - reached**2) / (2.0 * leg.thigh * leg.shank)
    knee = np.pi - np.arccos(np.clip(cosine, -1.0, 1.0))
    bent = Rotation.from_rotvec(np.outer(knee, [1.0, 0.0, 0.0]))
    # The leg with its hip at zero, in the plane of y and z, and the same with its knee in front.
    zero = np.array([0.0, -leg.thigh, 0.0]) + bent.apply([0.0, -leg.shank, 0.0])
    before = _frames(zero / np.linalg.norm(zero, axis=1, keepdims=True))
    in_front = _frames(direction) * before.inv()
    # Rotate it about the line from hip to ankle until the foot's x, and z of the shank, are perpendicular.
    z, across = (in_front * bent).apply([0.0, 0.0, 1.0]), (pelvis.inv() * foot).apply([1.0, 0.0, 0.0])
    along = np.sum(z * direction, axis=1, keepdims=True) * direction
    constant, cosines, sines = (
        np.sum(part * across, axis=1) for part in (along, z - along, np.cross(direction, z - along))
    )
    phase, size = np.arctan2(sines, cosines), np.hypot(cosines, sines)
    opening = np.arccos(np.clip(-constant / np.maximum(size, 1e-12), -1.0, 1.0))
    both = np.stack([phase + opening, phase - opening])
    both = np.angle(np.exp(1j * both))
    about = np.take_along_axis(both, np.abs(both).argmin(axis=0)[None], axis=0)[0]
    hip = Rotation.from_rotvec(about[:, None] * direction) * in_front
    R = ((hip * bent).inv() * pelvis.inv() * foot).as_matrix()
    return LegAngles(hip, knee, np.stack([np.arctan2(R[:, 2, 1], R[:, 2, 2]), np.arctan2(R[:, 1, 0], R[:, 0, 0])], 1))


def _frames(along: np.ndarray) -> Rotation:
    """Return rotations of -y to unit vectors (n, 3), with x as near to x as it can be."""
    x = np.array([1.0, 0.0, 0.0]) - along[:, :1] * along
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return Rotation.from_matrix(np.stack([x, -along, np.cross(x, -along)], axis=2))


def place_foot(leg: Leg, angles: LegAngles) -> tuple[np.ndarray, Rotation]:
    """Return where the ball (n, 3) of the foot is from the root, in the axes of the pelvis, and the foot's rotation."""
    shank = angles.hip * Rotation.from_rotvec(np.outer(angles.knee, [1.0, 0.0, 0.0]))
    foot = shank * Rotation.from_euler("xz", angles.ankle)
    ball = leg.hip + angles.hip.apply([0.0, -leg.thigh, 0.0]) + shank.apply([0.0, -leg.shank, 0.0])
    return ball + foot.apply(leg.foot), foot
