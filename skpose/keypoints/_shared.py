"""Names of `skpose.keypoints` that the other packages of skpose use, in addition to the public ones."""

from skpose.keypoints._checks import complaint_of_origin, complaint_of_up, find_lost, find_up
from skpose.keypoints._fit import is_of_layout
from skpose.keypoints._layout import name_points, remedy_without
from skpose.keypoints._layouts import check_layout, find_layout, missing_points, nearest_layout
from skpose.keypoints._names import find_names
from skpose.keypoints._pictures import REMEDY, complaint_of_flat, complaint_of_picture, is_spatial, refuse_pictures

__all__ = [
    "REMEDY",
    "check_layout",
    "complaint_of_flat",
    "complaint_of_origin",
    "complaint_of_picture",
    "complaint_of_up",
    "find_layout",
    "find_lost",
    "find_names",
    "find_up",
    "is_of_layout",
    "is_spatial",
    "missing_points",
    "name_points",
    "nearest_layout",
    "refuse_pictures",
    "remedy_without",
]
