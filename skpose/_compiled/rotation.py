"""Rotations of ball joints: quaternions (w, x, y, z), rotation vectors, and the derivatives of the one by the other.

``Exp(v)`` is the rotation by |v| about v. Its velocity is ``Jr(v)·dv`` in the rotated axes and ``Jl(v)·dv`` in the
fixed ones, with the right and the left Jacobian of SO(3). With θ = |v| and [v] the matrix of the cross product,

    Jr = 1 − a [v] + b [v]²,  Jl = 1 + a [v] + b [v]²,  a = (1 − cos θ)/θ²,  b = (θ − sin θ)/θ³,
    Jr⁻¹ = 1 + [v]/2 + c [v]²,  c = (1 − (θ/2) cot(θ/2))/θ².

G. S. Chirikjian, "Stochastic Models, Information Theory, and Lie Groups", volume 2, 2012, ch. 10.
"""

import math

import numpy as np

from skpose._compiled.jit import inlined, internal
from skpose._compiled.lanes import greater, sqrt
from skpose._compiled.trigonometry import cosine_sine

NEAR = 1.0  # θ² below which the series is used: above, the closed forms lose few digits
TERMS = 12
TIE = 1e-6  # a quaternion's number below which it may be zero but for rounding


@inlined
def product(p, q):
    """Return the product of two quaternions: the rotation q, then p."""
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


@inlined
def inverse(q):
    """Return the inverse of a unit quaternion."""
    return q[0], -q[1], -q[2], -q[3]


@inlined
def turned_back(v, q):
    """Return the vector v·R, R the matrix of the quaternion q / √2: a row of an orientation, times a rotation.

    With u the vector part, v·R = v + w t + t × u with t = v × u. The factor √2 in q stands for the two twos of the
    formula for unit quaternions.
    """
    a, b, c = v
    w, x, y, z = q
    r, s, t = b * z - c * y, c * x - a * z, a * y - b * x
    return a + w * r + (s * z - t * y), b + w * s + (t * x - r * z), c + w * t + (r * y - s * x)


@inlined
def quaternion_of(x, y, z):
    """Return the unit quaternion of a rotation vector."""
    square = x * x + y * y + z * z
    angle, small = sqrt(square), greater(0.0 - square, -1e-30)  # there sin(θ/2)/θ is ½ to the last digit
    cos, sin = cosine_sine(0.5 * angle)
    share = sin / (angle + small) + 0.5 * small
    return cos, share * x, share * y, share * z


@inlined
def _or_next(value, following):
    """Return the value, or the following one where the value is zero but for rounding."""
    certain = greater(value * value, TIE * TIE)
    return certain * value + (1.0 - certain) * following


@inlined
def canonical(q):
    """Return q or −q, which are one rotation: the same for both, however they are rounded."""
    w, x, y, z = q
    sign = 1.0 - 2.0 * greater(0.0 - _or_next(w, _or_next(x, _or_next(y, z))), 0.0)
    return sign * w, sign * x, sign * y, sign * z


@inlined
def sign_towards(p, q):
    """Return 1 or −1, whichever makes q nearer to p; 1 at half a turn, where canonical quaternions decide."""
    return 1.0 - 2.0 * greater(0.0 - (p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3]), TIE)


@internal
def vector_of(q):
    """Return the rotation vector of a unit quaternion, no longer than π."""
    w, x, y, z = q
    sign = 1.0 if w >= -TIE else -1.0
    sine = math.sqrt(x * x + y * y + z * z)
    share = sign * 2.0 * math.atan2(sine, sign * w) / sine if sine > 1e-300 else 2.0
    return share * x, share * y, share * z


@internal
def _series(square, shift):
    """Return Σ (−1)^k θ^2k / (2k + shift)! with θ² = square < 1."""
    term = 1.0
    for i in range(2, shift + 1):
        term /= i
    total = term
    for k in range(1, TERMS):
        term *= -square / ((2 * k + shift) * (2 * k + shift - 1))
        total += term
    return total


@internal
def jacobian_coefficients(square):
    """Return a and b at θ²."""
    if square < NEAR:
        return _series(square, 2), _series(square, 3)
    angle = math.sqrt(square)
    return (1.0 - math.cos(angle)) / square, (angle - math.sin(angle)) / (square * angle)


@internal
def jacobian_slopes(square):
    """Return the derivatives of a and b by θ, divided by θ."""
    if square < NEAR:  # the derivative of a series by θ² is made of the next two
        return 2.0 * _series(square, 4) - _series(square, 3), 3.0 * _series(square, 5) - _series(square, 4)
    angle = math.sqrt(square)
    sin, cos = math.sin(angle), math.cos(angle)
    slope = (angle * sin - 2.0 * (1.0 - cos)) / (square * square)
    return slope, (3.0 * sin - angle * cos - 2.0 * angle) / (square * square * angle)


@internal
def right_jacobian(x, y, z):
    """Return Jr of a rotation vector, row by row."""
    square = x * x + y * y + z * z
    a, b = jacobian_coefficients(square)
    c = 1.0 - b * square
    return (
        (c + b * x * x, b * x * y + a * z, b * x * z - a * y),
        (b * x * y - a * z, c + b * y * y, b * y * z + a * x),
        (b * x * z + a * y, b * y * z - a * x, c + b * z * z),
    )


@inlined
def _cross(p, q):
    return p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]


@internal
def _inverse_jacobian(v, u, half):
    """Return Jr(v)⁻¹ u for a half of ½, Jl(v)⁻¹ u = Jr(v)⁻ᵀ u for −½."""
    square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
    h = 0.5 * math.sqrt(square)
    c = (1.0 - h / math.tan(h)) / square if square > 1e-3 else 1.0 / 12.0 + square / 720.0 + square**2 / 30240.0
    s = _cross(v, u)
    r = _cross(v, s)
    return u[0] + half * s[0] + c * r[0], u[1] + half * s[1] + c * r[1], u[2] + half * s[2] + c * r[2]


@internal
def slope_of_turn(v, slope):
    """Return the derivative by a turn in the rotated axes, given the one by the rotation vector v."""
    return _inverse_jacobian(v, slope, -0.5)


@internal
def second_derivatives(v, moment):
    """Return the nine numbers m·∂Jl(v)eᵢ/∂vⱼ, row j, column i, where the moment is Jl(v)ᵀ m.

    With [v]² = v vᵀ − θ² they are linear in m, v × m and v × (v × m), besides the derivatives of a and b.
    """
    x, y, z = v
    square = x * x + y * y + z * z
    a, b = jacobian_coefficients(square)
    slope_a, slope_b = jacobian_slopes(square)
    m = _inverse_jacobian(v, moment, 0.5)
    across = _cross(v, m)
    twice = _cross(v, across)
    along = x * m[0] + y * m[1] + z * m[2]
    out = np.empty((3, 3))
    for j in range(3):
        for i in range(3):
            out[j, i] = v[j] * (slope_b * twice[i] - slope_a * across[i]) + b * (m[j] * v[i] - 2.0 * m[i] * v[j])
        out[j, j] += b * along
        following, last = (j + 1) % 3, (j + 2) % 3
        out[j, following] += a * m[last]
        out[j, last] -= a * m[following]
    return out
