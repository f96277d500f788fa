"""Forward kinematics F(θ), its Jacobian, and the metric tensor that they induce on angle space."""

from skpose.kinematics._forward import forward_kinematics, metric_tensor, position_jacobian

__all__ = ["forward_kinematics", "metric_tensor", "position_jacobian"]
