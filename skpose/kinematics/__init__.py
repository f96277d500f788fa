"""Forward kinematics F(θ), its Jacobian and metric tensor, inverse kinematics, and retargeting between rigs."""

from skpose.kinematics._counterparts import find_counterparts as find_counterparts
from skpose.kinematics._forward import forward_kinematics, metric_tensor, position_jacobian
from skpose.kinematics._inverse import FittedPoses as FittedPoses, inverse_kinematics
from skpose.kinematics._retarget import retarget

__all__ = ["forward_kinematics", "inverse_kinematics", "metric_tensor", "position_jacobian", "retarget"]
