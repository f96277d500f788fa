"""Positions of named points in time: keypoints of a pose estimator, markers, joints. The skeleton that fits them."""

from skpose.keypoints._keypoints import Keypoints

__all__ = ["Keypoints"]
