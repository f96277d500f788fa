"""Forward kinematics F(θ), its Jacobian, the metric tensor that they induce on angle space; retargeting."""

from skpose.kinematics._forward import forward_kinematics, metric_tensor, position_jacobian
from skpose.kinematics._retarget import retarget

__all__ = ["forward_kinematics", "metric_tensor", "position_jacobian", "retarget"]
