"""Inverse kinematics by scipy's least squares, with the closed-form Jacobian of the joints and of the root.

Numbers of a frame are the position of the root, its rotation vector, and the joint angles.
"""

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from skpose import forward_kinematics, position_jacobian

N_ROOT = 6  # numbers of the root


def cross(v):
    """Return the matrices (n, 3, 3) of cross products with vectors (n, 3)."""
    x, y, z = v.T
    zero = np.zeros_like(x)
    return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)


def aligned(skeleton, positions):
    """Return the numbers of the rest pose, with the root by the best fit of all joints."""
    rest = forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton)[0]
    rotation, _ = Rotation.align_vectors(positions - positions.mean(axis=0), rest - rest.mean(axis=0))
    origin = positions.mean(axis=0) - rotation.apply(rest.mean(axis=0))
    return np.concatenate([origin, rotation.as_rotvec(), np.zeros(skeleton.n_dofs)])


class Solver:
    """One call finds one frame, and returns the positions of the joints."""

    def __init__(self, skeleton, method):
        self.skeleton, self.method, self.last = skeleton, method, None

    def positions(self, x):
        local = forward_kinematics(x[None, N_ROOT:], self.skeleton)[0]
        return local @ Rotation.from_rotvec(x[3:N_ROOT]).as_matrix().T + x[:3]

    def jacobian(self, x):
        n = self.skeleton.n_joints
        rotation = Rotation.from_rotvec(x[3:N_ROOT]).as_matrix()
        turned = forward_kinematics(x[None, N_ROOT:], self.skeleton)[0] @ rotation.T
        J = np.empty((n, 3, len(x)))
        J[:, :, :3] = np.eye(3)
        J[:, :, 3:N_ROOT] = -cross(turned) @ left_jacobian(x[3:N_ROOT])
        J[:, :, N_ROOT:] = rotation @ position_jacobian(x[None, N_ROOT:], self.skeleton)[0].reshape(n, 3, -1)
        return J.reshape(3 * n, -1)

    def __call__(self, start, given):
        found = least_squares(lambda x: (self.positions(x) - given).ravel(), start, self.jacobian, method=self.method)
        self.last = found.x
        return self.positions(found.x)


def left_jacobian(v):
    """Return the matrix that takes the rate of a rotation vector to the angular velocity in the axes of the world."""
    angle, K = np.linalg.norm(v), cross(v[None])[0]
    if angle < 1e-4:
        return np.eye(3) + K / 2 + K @ K / 6
    return np.eye(3) + (1 - np.cos(angle)) / angle**2 * K + (angle - np.sin(angle)) / angle**3 * K @ K


def solvers(skeleton):
    """Return a solver for each method, after a comparison of the Jacobian with differences."""
    one = Solver(skeleton, "lm")
    x, h = np.random.default_rng(0).normal(scale=0.5, size=N_ROOT + skeleton.n_dofs), 1e-6
    differences = [(one.positions(x + h * e) - one.positions(x - h * e)).ravel() / (2 * h) for e in np.eye(len(x))]
    np.testing.assert_allclose(one.jacobian(x), np.transpose(differences), atol=1e-8)
    return {f'scipy least_squares, "{method}"': Solver(skeleton, method) for method in ("lm", "trf")}
