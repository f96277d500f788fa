"""Poses placed in the world, and the sum that inverse kinematics makes least, from their definitions."""

import numpy as np
import reference
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from skpose import Bone, Skeleton

# Limits, ball joints, hinges, a joint of two dofs and a rigid one.
FIGURE = Skeleton(
    [
        Bone("spine", None, (0, 0.5, 0), "rotvec"),
        Bone("collar", "spine", (0.2, 0, 0)),
        Bone("elbow", "collar", (0.3, 0, 0), "zyx", limits=[(-1.5, 1.5), (-0.5, 0.5), (-0.3, 0.3)]),
        Bone("wrist", "elbow", (0.25, 0, 0), "z", limits=[(0.0, 2.5)]),
        Bone("finger", "wrist", (0.1, 0, 0), "yz"),
        Bone("knee", None, (0, -0.4, 0), "rotvec"),
        Bone("foot", "knee", (0, -0.4, 0), "x", limits=[(-2.5, 0.0)]),
        Bone("toe", "foot", (0, 0, 0.2), "rotvec"),
    ]
)


def placed(skeleton, poses, root_rotations, root_positions):
    """Return positions (n_frames, n_joints, 3) of joints in the world."""
    turned = [Rotation.from_rotvec(r) for r in root_rotations]
    here = reference.forward_kinematics(poses, skeleton)
    return np.stack([turn.apply(joints) for turn, joints in zip(turned, here, strict=True)]) + root_positions[:, None]


def of(fitted):
    """Return the positions in the world of what has been fitted."""
    return placed(fitted.skeleton, fitted.poses, fitted.root_rotations, fitted.root_positions)


def at_random(skeleton, n, size=0.6, seed=0):
    """Return random poses, and positions of them in the world, with a root that moves."""
    rng = np.random.default_rng(seed)
    poses = rng.uniform(-size, size, (n, skeleton.n_dofs))
    return poses, placed(skeleton, poses, rng.normal(size=(n, 3)), 3.0 * rng.normal(size=(n, 3)))


def residuals(x, positions, skeleton, weights, rho, initial, free):
    """Return the terms whose squares are summed (n, …) at vectors x: the root's rotation, its position, the pose.

    `free`: joints of three angles turn as balls do, so that their distance is that of rotations.
    """
    poses = x[:, 6:]
    off = (placed(skeleton, poses, x[:, :3], x[:, 3:6]) - positions) * np.sqrt(weights)[:, None]
    terms, column = [np.where(weights[:, None] > 0, off, 0).reshape(len(x), -1)], 0
    for bone in skeleton.bones:
        here = slice(column, column + bone.n_dofs)
        column = here.stop
        if bone.is_ball or (free and bone.n_dofs == 3):
            before, now = (reference.joint_rotation(bone, p[..., here]) for p in (initial, poses))
            terms.append(rho * (before.inv() * now).as_rotvec())
        else:
            terms.append(rho * (poses[:, here] - initial[here]))
    return np.concatenate(terms, axis=1)


def least_cost(fitted, i, positions, weights=None, rho=0.0, initial=None, enforce=False):
    """Return the cost of frame i, and the least one that scipy finds from there."""
    skeleton = fitted.skeleton
    weights = np.ones(skeleton.n_joints) if weights is None else weights
    initial = np.zeros(skeleton.n_dofs) if initial is None else initial
    arguments = np.nan_to_num(positions), skeleton, weights, rho, initial, not enforce

    def value(x):
        return residuals(x[None], *arguments)[0]

    def jacobian(x, step=1e-6):
        moved = step * np.eye(len(x))
        return (residuals(x + moved, *arguments) - residuals(x - moved, *arguments)).T / (2 * step)

    start = np.concatenate([fitted.root_rotations[i], fitted.root_positions[i], fitted.poses[i]])
    bounds = np.array([-np.inf, np.inf])[:, None] * np.ones(len(start))
    if enforce:
        bounds[:, 6:] = skeleton.limits.T
    cost = 0.5 * np.sum(value(start) ** 2)
    return cost, least_squares(value, start, jacobian, bounds=bounds, xtol=1e-15, ftol=1e-15, gtol=1e-15).cost
