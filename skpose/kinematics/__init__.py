"""Forward kinematics F(θ), its Jacobian, the metric tensor that they induce on angle space, and inverse kinematics."""

from skpose.kinematics._counterparts import find_counterparts
from skpose.kinematics._fitted_poses import FittedPoses
from skpose.kinematics._forward import forward_kinematics, metric_tensor, position_jacobian
from skpose.kinematics._inverse import inverse_kinematics
from skpose.kinematics._retarget import retarget

__all__ = [
    "FittedPoses",
    "find_counterparts",
    "forward_kinematics",
    "inverse_kinematics",
    "metric_tensor",
    "position_jacobian",
    "retarget",
]
