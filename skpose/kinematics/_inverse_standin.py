"""Slow stand-in for inverse kinematics, until the real one is merged."""

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
    n = skeleton.n_dofs
    results = []
    for p in positions:
        seen = ~np.isnan(p).any(axis=1)
        q = p[seen]
        theta = np.zeros(n)
        f = forward_kinematics(theta[None], skeleton)[0][seen]
        R = Rotation.align_vectors(q - q.mean(0), f - f.mean(0))[0]
        t = q.mean(0) - R.apply(f.mean(0))
        damping = 1e-3
        for _step in range(300):
            f = R.apply(forward_kinematics(theta[None], skeleton)[0][seen])
            r = (f + t - q).ravel()
            J = position_jacobian(theta[None], skeleton)[0].reshape(-1, 3, n)[seen]
            J = np.einsum("ab,jbn->jan", R.as_matrix(), J)
            turn = np.stack([np.cross(e, f) for e in np.eye(3)], axis=2)
            J = np.concatenate([np.tile(np.eye(3), (len(q), 1, 1)), turn, J], axis=2).reshape(-1, n + 6)
            A, g = J.T @ J, J.T @ r
            cost = r @ r
            while damping < 1e9:
                step = -np.linalg.solve(A + damping * np.eye(n + 6), g)
                new = theta + step[6:], Rotation.from_rotvec(step[3:6]) * R, t + step[:3]
                e = new[1].apply(forward_kinematics(new[0][None], skeleton)[0][seen]) + new[2] - q
                now = (e**2).sum()
                if now < cost:
                    break
                damping *= 4.0
            else:
                break
            theta, R, t = new
            damping = max(damping / 10.0, 1e-6)
            if cost - now < 1e-9 * cost or now < 1e-18:
                break
        f = R.apply(forward_kinematics(theta[None], skeleton)[0]) + t
        results.append((theta, np.linalg.norm(f - p, axis=1), t, R.as_rotvec()))
    return FittedPoses(skeleton, *(np.array(x) for x in zip(*results, strict=True)))
