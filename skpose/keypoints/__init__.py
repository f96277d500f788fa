"""Positions of named points in time: keypoints of a pose estimator, markers, joints. The skeleton that fits them."""

from skpose.keypoints._fit import fit_skeleton
from skpose.keypoints._keypoints import Keypoints
from skpose.keypoints._layout import Layout
from skpose.keypoints._layouts import layouts

__all__ = ["Keypoints", "Layout", "fit_skeleton", "layouts"]
