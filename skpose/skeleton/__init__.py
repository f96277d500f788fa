"""The skeleton and its poses."""

from skpose.skeleton._bone import Bone
from skpose.skeleton._motion import Motion
from skpose.skeleton._skeleton import Skeleton

for _class in (Bone, Motion, Skeleton):  # messages and pickles name the package, not a private file
    _class.__module__ = __name__

__all__ = ["Bone", "Motion", "Skeleton"]
