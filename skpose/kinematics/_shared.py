"""Names of `skpose.kinematics` that the other packages of skpose use, in addition to the public ones."""

from skpose.kinematics._chart import STEP, columns_around, jacobian_at, retract
from skpose.kinematics._forward import jacobians_of, weighted_positions
from skpose.kinematics._landmarks import Landmarks, common_parent, find_landmarks, path_up
from skpose.kinematics._lines import find_carriers, find_movers
from skpose.kinematics._orientations import rotations_since_zero
from skpose.kinematics._retarget import UNCHANGED, Method, retarget_and_report
from skpose.kinematics._tree import (
    counted_joints,
    from_tree_order,
    to_tree_order,
    tree_of,
    tree_of_all_joints,
    wrap_dofs,
)

__all__ = [
    "STEP",
    "UNCHANGED",
    "Landmarks",
    "Method",
    "columns_around",
    "common_parent",
    "counted_joints",
    "find_carriers",
    "find_landmarks",
    "find_movers",
    "from_tree_order",
    "jacobian_at",
    "jacobians_of",
    "path_up",
    "retarget_and_report",
    "retract",
    "rotations_since_zero",
    "to_tree_order",
    "tree_of",
    "tree_of_all_joints",
    "weighted_positions",
    "wrap_dofs",
]
