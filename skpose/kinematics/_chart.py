"""Derivatives at a pose and steps from it, in the chart at the pose: rotations of ball joints about their own axes."""

import numpy as np

from skpose._compiled.pose.chart import chart_at, pose_of
from skpose._compiled.pose.jacobian import position_jacobians
from skpose._compiled.pose.tree import Tree
from skpose.kinematics._tree import from_tree_order

STEP = 1e-5  # of differences, rad: their error is some 1e-10 relative to the derivative


def jacobian_at(tree: Tree, pose: np.ndarray, frees_angles: bool) -> np.ndarray:
    """The derivative (3 n_joints, n_dofs) of scaled positions in the chart at a pose."""
    free, coordinates = chart_at(tree, pose, frees_angles)
    jacobians = np.empty((1, 3 * len(tree.offset) - 3, len(pose)))
    position_jacobians(coordinates[None], free, jacobians)
    return jacobians[0]


def retract(tree: Tree, pose: np.ndarray, step: np.ndarray, frees_angles: bool) -> np.ndarray:
    """Move a pose by a step in the chart at the pose."""
    free, coordinates = chart_at(tree, pose, frees_angles)
    return pose_of(tree, free, coordinates + step, pose)


def columns_around(
    tree: Tree, pose: np.ndarray, step: np.ndarray, shifts: np.ndarray, others: np.ndarray, frees_angles: bool
) -> np.ndarray:
    """The columns of the pose a step away, and of those shifts (n, n_dofs) further and shifts back.

    Dofs that move no joint are those of `others`.
    """
    near = np.stack([retract(tree, pose, one, frees_angles) for one in (step, *(step + shifts), *(step - shifts))])
    return from_tree_order(tree, near, np.repeat(others[None], len(near), axis=0))
