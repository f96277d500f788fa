"""Robots: their skeletons from MJCF and URDF files, MuJoCo's ``qpos``, and people's motions within their joint limits.

`load_robot` needs MuJoCo, as do `qpos_from_motion` and `motion_from_qpos`: ``pip install 'skpose[robot]'``.
"""

from skpose.robots._load import load_robot
from skpose.robots._qpos import motion_from_qpos, qpos_from_motion
from skpose.robots._retarget import retarget_to_robot

__all__ = ["load_robot", "motion_from_qpos", "qpos_from_motion", "retarget_to_robot"]
