"""Names of `skpose.preprocessing` that the other packages of skpose use, in addition to the public ones."""

from skpose.preprocessing._kernels import Kernel, repair_kernel

__all__ = [
    "Kernel",
    "repair_kernel",
]
