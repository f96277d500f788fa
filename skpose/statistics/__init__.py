"""Statistics of poses: their principal components, regression with poses as targets, tests of two sets."""

from skpose.statistics._kernel_regressor import PoseKernelRegressor

__all__ = ["PoseKernelRegressor"]
