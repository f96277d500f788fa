"""The skeleton and its poses."""

from skpose.skeleton._bone import Bone
from skpose.skeleton._motion import Motion
from skpose.skeleton._rotation_forms import poses_from_rotations, rotations_from_poses
from skpose.skeleton._skeleton import Skeleton

__all__ = ["Bone", "Motion", "Skeleton", "poses_from_rotations", "rotations_from_poses"]
