"""Names of `skpose.keypoints` that the other packages of skpose use, in addition to the public ones."""

from skpose.keypoints._layout import remedy_without
from skpose.keypoints._layouts import check_layout, find_layout
from skpose.keypoints._names import find_names
from skpose.keypoints._pictures import REMEDY, is_spatial, refuse_pictures

__all__ = ["REMEDY", "check_layout", "find_layout", "find_names", "is_spatial", "refuse_pictures", "remedy_without"]
