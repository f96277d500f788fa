"""Polynomials, cosines and sines: in lanes, or of one number."""

import math

from skpose._compiled.simd.jit import inlined
from skpose._compiled.simd.lanes import minimum, rint

# π in three parts, the first two of so few bits that their multiples by less than 2²² are exact.
_PI_PARTS = 3.1415926534682512, 1.2154201018028943e-10, -5.016557612668332e-20
_SINE = tuple((-1.0) ** k / math.factorial(2 * k + 1) for k in range(11))
_COSINE = tuple((-1.0) ** k / math.factorial(2 * k) for k in range(12))


@inlined
def series(coefficients, t, value):
    """Evaluate a polynomial by Horner's rule; `value` is a zero of the right kind."""
    for k in range(len(coefficients) - 1, -1, -1):
        value = value * t + coefficients[k]
    return value


@inlined
def cosine_sine(angle):
    """Cosine and sine of an angle, to 2e-16 up to a million turns.

    Multiples of π are subtracted, and the rest goes into Taylor's series. numba has neither function in lanes; one by
    one, by the C library, they take twenty times as long.
    """
    half_turns = rint(angle * (1.0 / math.pi))
    rest = ((angle - half_turns * _PI_PARTS[0]) - half_turns * _PI_PARTS[1]) - half_turns * _PI_PARTS[2]
    bound = 0.0 * rest + 1.6  # more than π/2: an angle so large that no digit is left stays within
    rest = 0.0 - minimum(0.0 - minimum(rest, bound), bound)
    odd = half_turns - 2.0 * rint(half_turns * 0.5)
    sign = 1.0 - 2.0 * (odd * odd)
    t = rest * rest
    return sign * series(_COSINE, t, 0.0 * t), sign * (rest * series(_SINE, t, 0.0 * t))
