"""Names of `skpose.preprocessing` that the other packages of skpose use, in addition to the public ones."""

from skpose.preprocessing._kernels import Kernel, repaired

__all__ = [
    "Kernel",
    "repaired",
]
