"""Copies of arrays: ``target[:] = source`` compiles for a second, since it can fail and says so in words."""

from skpose._compiled.simd.jit import internal
from skpose._compiled.simd.lanes import flat


@internal
def copy_to(target, source):
    """Copy all numbers of a contiguous array to another one of its shape."""
    numbers, out = flat(source), flat(target)
    for i in range(source.size):
        out[i] = numbers[i]
