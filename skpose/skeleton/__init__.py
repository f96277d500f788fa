"""The skeleton and its poses."""

from skpose.skeleton._bone import Bone
from skpose.skeleton._motion import Motion
from skpose.skeleton._skeleton import Skeleton

__all__ = ["Bone", "Motion", "Skeleton"]
