"""Names of `skpose.preprocessing` that the other packages of skpose use, in addition to the public ones."""

from skpose.preprocessing._kernels import KERNEL_CONSTRAINTS, Kernel, KernelMixin, repair_kernel

__all__ = ["KERNEL_CONSTRAINTS", "Kernel", "KernelMixin", "repair_kernel"]
