"""Slow stand-in for inverse kinematics: to be deleted when the real one is merged (one import in `_retarget`)."""

from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.kinematics._forward import forward_kinematics, position_jacobian
from skpose.skeleton import Motion, Skeleton


class FittedPoses(NamedTuple):
    skeleton: Skeleton
    poses: np.ndarray
    residuals: np.ndarray
    root_positions: np.ndarray
    root_rotations: np.ndarray

    def to_motion(self, frame_rate: float, up: Any = "y") -> Motion:
        angles = Rotation.from_rotvec(self.root_rotations).as_euler("xyz")
        return Motion(self.skeleton, self.poses, frame_rate, self.root_positions, angles, "xyz", up=up)


def inverse_kinematics(positions: np.ndarray, skeleton: Skeleton, **_: Any) -> FittedPoses:
    results: list[tuple] = []
    for p in positions:
        starts = [_aligned(p, skeleton), *(result[:3] for result in results[-1:])]
        results.append(min((_descended(p, skeleton, *start) for start in starts), key=lambda x: max(x[3], 1e-12)))
    poses, rotations, places, _costs, residuals = zip(*results, strict=True)
    turns = np.array([r.as_rotvec() for r in rotations])
    return FittedPoses(skeleton, np.array(poses), np.array(residuals), np.array(places), turns)


def _aligned(p: np.ndarray, skeleton: Skeleton) -> tuple[np.ndarray, Rotation, np.ndarray]:
    theta, seen = np.zeros(skeleton.n_dofs), ~np.isnan(p).any(axis=1)
    f, q = forward_kinematics(theta[None], skeleton)[0][seen], p[seen]
    R = Rotation.align_vectors(q - q.mean(0), f - f.mean(0))[0]
    return theta, R, q.mean(0) - R.apply(f.mean(0))


def _descended(p: np.ndarray, skeleton: Skeleton, theta: np.ndarray, R: Rotation, t: np.ndarray) -> tuple:
    seen, n = ~np.isnan(p).any(axis=1), skeleton.n_dofs
    q, damping, cost = p[seen], 1e-3, np.inf
    for _ in range(300):
        f = R.apply(forward_kinematics(theta[None], skeleton)[0][seen])
        r = (f + t - q).ravel()
        J = np.einsum("ab,jbn->jan", R.as_matrix(), position_jacobian(theta[None], skeleton)[0].reshape(-1, 3, n)[seen])
        turn = np.stack([np.cross(e, f) for e in np.eye(3)], axis=2)
        J = np.concatenate([np.tile(np.eye(3), (len(q), 1, 1)), turn, J], axis=2).reshape(-1, n + 6)
        A, g, cost = J.T @ J, J.T @ r, r @ r
        while damping < 1e9:
            step = -np.linalg.solve(A + damping * np.eye(n + 6), g)
            new = theta + step[6:], Rotation.from_rotvec(step[3:6]) * R, t + step[:3]
            e = new[1].apply(forward_kinematics(new[0][None], skeleton)[0][seen]) + new[2] - q
            if (e**2).sum() < cost:
                break
            damping *= 4.0
        else:
            break
        theta, R, t = new
        damping, now = max(damping / 10.0, 1e-6), (e**2).sum()
        if cost - now < 1e-9 * cost or now < 1e-18:
            break
    f = R.apply(forward_kinematics(theta[None], skeleton)[0]) + t
    return theta, R, t, cost, np.linalg.norm(f - p, axis=1)
