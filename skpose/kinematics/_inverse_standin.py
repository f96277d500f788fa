"""Slow stand-in for inverse kinematics, until the real one is merged."""

from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from skpose.kinematics._forward import forward_kinematics
from skpose.skeleton import Motion


class FittedPoses(NamedTuple):
    skeleton: object
    poses: np.ndarray
    residuals: np.ndarray
    root_positions: np.ndarray
    root_rotations: np.ndarray

    def to_motion(self, frame_rate, up="y"):
        return Motion(
            self.skeleton,
            self.poses,
            frame_rate,
            self.root_positions,
            Rotation.from_rotvec(self.root_rotations).as_euler("xyz"),
            "xyz",
            up=up,
        )


def inverse_kinematics(positions, skeleton, *, n_jobs=None, verbose=0, regularization=1e-9):
    n = skeleton.n_dofs
    out, res = np.zeros((len(positions), n + 6)), np.full(positions.shape[:2], np.nan)
    x = np.zeros(n + 6)
    x[:3] = np.nanmean(positions[0], axis=0)
    for i, p in enumerate(positions):
        seen = ~np.isnan(p).any(axis=1)
        if i == 0:
            f = forward_kinematics(np.zeros((1, n)), skeleton)[0][seen]
            q = p[seen]
            R, _ = Rotation.align_vectors(q - q.mean(0), f - f.mean(0)) if seen.sum() > 1 else (Rotation.identity(), 0)
            x[3:6] = R.as_rotvec()
            x[:3] = q.mean(0) - R.apply(f.mean(0))
        x0 = x.copy()

        def function(x):
            f = Rotation.from_rotvec(x[3:6]).apply(forward_kinematics(x[None, 6:], skeleton)[0]) + x[:3]
            return np.concatenate([(f - p)[seen].ravel(), np.sqrt(regularization) * (x[6:] - x0[6:])])

        x = least_squares(function, x0, method="trf", xtol=1e-14, ftol=1e-14, gtol=1e-14).x
        f = Rotation.from_rotvec(x[3:6]).apply(forward_kinematics(x[None, 6:], skeleton)[0]) + x[:3]
        out[i], res[i] = x, np.where(seen, np.linalg.norm(f - p, axis=1), np.nan)
    return FittedPoses(skeleton, out[:, 6:], res, out[:, :3], out[:, 3:6])
