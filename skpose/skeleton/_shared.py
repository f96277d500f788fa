"""Names of `skpose.skeleton` that the other packages of skpose use, in addition to the public ones."""

from skpose.skeleton._bone import BALL, HINGE, SLIDE, are_slides, axes_of, is_axes, with_columns
from skpose.skeleton._chart import mean_of_joints, move, skeleton_at, steps_from
from skpose.skeleton._comparison import LARGEST_DIFFERENCE, check_comparable, check_rest_poses, mismatch
from skpose.skeleton._continuity import continuous_columns, continuous_triples, remove_jumps
from skpose.skeleton._html import foldable_table
from skpose.skeleton._interpolation import interpolate_poses, straight_line
from skpose.skeleton._limits import limited_dofs
from skpose.skeleton._proportions import MEAN_HEIGHT, PROPORTIONS
from skpose.skeleton._rest import NO_DIRECTION, axes_at_zero, directions_at_zero, positions_at_zero, size_of
from skpose.skeleton._root import (
    continuous_root_angles,
    find_root_joint,
    heading,
    root_angles_of,
    root_orientations,
    with_root_joint,
)
from skpose.skeleton._rotation_forms import FORMS, RotationForm
from skpose.skeleton._rotations import TWO_PI, columns_of, rotations_of
from skpose.skeleton._sampling import join_seen, seen_of
from skpose.skeleton._selection import with_carriers
from skpose.skeleton._sides import others, partners, sides, split_sides, without_side
from skpose.skeleton._upright import HIGH, LOW, complaint_of_up, describe_up, find_up

__all__ = [
    "BALL",
    "FORMS",
    "HIGH",
    "HINGE",
    "LARGEST_DIFFERENCE",
    "LOW",
    "MEAN_HEIGHT",
    "NO_DIRECTION",
    "PROPORTIONS",
    "SLIDE",
    "TWO_PI",
    "RotationForm",
    "are_slides",
    "axes_at_zero",
    "axes_of",
    "check_comparable",
    "check_rest_poses",
    "columns_of",
    "complaint_of_up",
    "continuous_columns",
    "continuous_root_angles",
    "continuous_triples",
    "describe_up",
    "directions_at_zero",
    "find_root_joint",
    "find_up",
    "foldable_table",
    "heading",
    "interpolate_poses",
    "is_axes",
    "join_seen",
    "limited_dofs",
    "mean_of_joints",
    "mismatch",
    "move",
    "others",
    "partners",
    "positions_at_zero",
    "remove_jumps",
    "root_angles_of",
    "root_orientations",
    "rotations_of",
    "seen_of",
    "sides",
    "size_of",
    "skeleton_at",
    "split_sides",
    "steps_from",
    "straight_line",
    "with_carriers",
    "with_columns",
    "with_root_joint",
    "without_side",
]
