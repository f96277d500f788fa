"""What the other packages of skpose use of `skpose.skeleton` beside its public names."""

from skpose.skeleton._arguments import check_frame_rate, check_skeleton, explain_no_skeleton, limits_of
from skpose.skeleton._bone import BALL
from skpose.skeleton._chart import mean_of_joints, moved, skeleton_at, steps_from
from skpose.skeleton._columns import (
    check_column_names,
    check_dimensions,
    check_position_dimensions,
    check_position_names,
    check_position_width,
    check_width,
)
from skpose.skeleton._continuity import continuous_columns, continuous_triples, without_jumps
from skpose.skeleton._interpolation import interpolate, straight_line
from skpose.skeleton._names import near_names
from skpose.skeleton._proportions import MEAN_HEIGHT, PROPORTIONS
from skpose.skeleton._rest import LARGEST_DIFFERENCE, NO_DIRECTION, axes_at_zero, check_rest_poses, directions_at_zero
from skpose.skeleton._root import check_up, heading, root_angles_of, root_orientations, with_root_joint
from skpose.skeleton._rotations import TWO_PI, columns_of, rotations_of
from skpose.skeleton._selection import with_carriers
from skpose.skeleton._sides import others, partners, sides
from skpose.skeleton._skeleton import check_comparable, mismatch
from skpose.skeleton._units import (
    LARGEST,
    SMALLEST,
    UNITS,
    complaint_of_extent,
    complaint_of_size,
    likely_unit,
    size_of,
    warn_of_degrees,
)
from skpose.skeleton._validation import check_is_array, check_numbers, check_pose, check_poses, check_same_width

__all__ = [
    "BALL",
    "LARGEST",
    "LARGEST_DIFFERENCE",
    "MEAN_HEIGHT",
    "NO_DIRECTION",
    "PROPORTIONS",
    "SMALLEST",
    "TWO_PI",
    "UNITS",
    "axes_at_zero",
    "check_column_names",
    "check_comparable",
    "check_dimensions",
    "check_frame_rate",
    "check_is_array",
    "check_numbers",
    "check_pose",
    "check_poses",
    "check_position_dimensions",
    "check_position_names",
    "check_position_width",
    "check_rest_poses",
    "check_same_width",
    "check_skeleton",
    "check_up",
    "check_width",
    "columns_of",
    "complaint_of_extent",
    "complaint_of_size",
    "continuous_columns",
    "continuous_triples",
    "directions_at_zero",
    "explain_no_skeleton",
    "heading",
    "interpolate",
    "likely_unit",
    "limits_of",
    "mean_of_joints",
    "mismatch",
    "moved",
    "near_names",
    "others",
    "partners",
    "root_angles_of",
    "root_orientations",
    "rotations_of",
    "sides",
    "size_of",
    "skeleton_at",
    "steps_from",
    "straight_line",
    "warn_of_degrees",
    "with_carriers",
    "with_root_joint",
    "without_jumps",
]
