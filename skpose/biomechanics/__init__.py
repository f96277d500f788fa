"""Movements of people in the words of those who measure them: angles of joints, symmetry, gait."""

from skpose.biomechanics._joint_angles import JointAngles, joint_angles

__all__ = ["JointAngles", "joint_angles"]
