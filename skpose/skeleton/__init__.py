"""The skeleton and its poses: what a pose is."""

from skpose.skeleton._motion import Motion
from skpose.skeleton._skeleton import Bone, Skeleton

__all__ = ["Bone", "Motion", "Skeleton"]
