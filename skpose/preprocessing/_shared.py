"""What the other packages of skpose use of `skpose.preprocessing` beside its public names."""

from skpose.preprocessing._kernels import Kernel, repaired

__all__ = [
    "Kernel",
    "repaired",
]
