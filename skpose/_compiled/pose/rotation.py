"""Rotations of ball joints: quaternions (w, x, y, z), rotation vectors, and the derivatives of the one by the other.

``Exp(v)`` is the rotation by |v| about v. Its velocity is ``Jr(v)·dv`` in the rotated axes and ``Jl(v)·dv`` in the
fixed ones, with the right and the left Jacobian of SO(3). With θ = |v| and [v] the matrix of the cross product,

    Jr = 1 − a [v] + b [v]²,  Jl = 1 + a [v] + b [v]²,  a = (1 − cos θ)/θ²,  b = (θ − sin θ)/θ³,
    Jr⁻¹ = 1 + [v]/2 + c [v]²,  c = (1 − (θ/2) cot(θ/2))/θ².

G. S. Chirikjian, "Stochastic Models, Information Theory, and Lie Groups", volume 2, 2012, ch. 10.
"""

import math

from skpose._compiled.simd.jit import inlined, internal
from skpose._compiled.simd.lanes import greater, sqrt
from skpose._compiled.simd.trigonometry import cosine_sine, series

NEAR = 1.0  # θ² below which the series is used: above, the closed forms lose few digits
TERMS = 12
# Coefficients of Σ (−1)^k θ^2k / (2k + shift)! in θ², by shift.
_SERIES = tuple(tuple((-1.0) ** k / math.factorial(2 * k + shift) for k in range(TERMS)) for shift in range(6))
TIE = 1e-6  # smaller numbers of a quaternion may be rounding errors


@inlined
def product(p, q):
    """The product of two quaternions: the rotation q, then p."""
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


@inlined
def quaternion_at(quaternions, f):
    """The quaternion in row f of an array (n, 4)."""
    return quaternions[f, 0], quaternions[f, 1], quaternions[f, 2], quaternions[f, 3]


@inlined
def put_quaternion(q, quaternions, f):
    """Write a quaternion to row f of an array (n, 4)."""
    quaternions[f, 0], quaternions[f, 1], quaternions[f, 2], quaternions[f, 3] = q


@inlined
def inverse(q):
    """The inverse of a unit quaternion."""
    return q[0], -q[1], -q[2], -q[3]


@inlined
def turn_back(v, q):
    """The vector v·R, R the matrix of the quaternion q / √2: a row of an orientation, times a rotation.

    With u the vector part, v·R = v + w t + t × u with t = v × u. The factor √2 in q stands for the two twos of the
    formula for unit quaternions.
    """
    a, b, c = v
    w, x, y, z = q
    r, s, t = b * z - c * y, c * x - a * z, a * y - b * x
    return a + w * r + (s * z - t * y), b + w * s + (t * x - r * z), c + w * t + (r * y - s * x)


@inlined
def quaternion_of(x, y, z):
    """The unit quaternion of a rotation vector."""
    square = x * x + y * y + z * z
    angle, small = sqrt(square), greater(0.0 - square, -1e-30)  # there sin(θ/2)/θ is ½ to the last digit
    cos, sin = cosine_sine(0.5 * angle)
    share = sin / (angle + small) + 0.5 * small
    return cos, share * x, share * y, share * z


@inlined
def _or_next(value, following):
    """The value, or the following one where the value is zero within rounding."""
    certain = greater(value * value, TIE * TIE)
    return certain * value + (1.0 - certain) * following


@inlined
def canonical(q):
    """The one of q and −q, which are the same rotation, with a fixed sign, however they are rounded."""
    w, x, y, z = q
    sign = 1.0 - 2.0 * greater(0.0 - _or_next(w, _or_next(x, _or_next(y, z))), 0.0)
    return sign * w, sign * x, sign * y, sign * z


@inlined
def sign_towards(p, q):
    """1 or −1, whichever makes q nearer to p; 1 at half a turn, where canonical quaternions decide."""
    return 1.0 - 2.0 * greater(0.0 - (p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3]), TIE)


@internal
def vector_of(q):
    """The rotation vector of a unit quaternion, no longer than π."""
    w, x, y, z = q
    sign = 1.0 if w >= -TIE else -1.0
    sine = math.sqrt(x * x + y * y + z * z)
    share = sign * 2.0 * math.atan2(sine, sign * w) / sine if sine > 1e-300 else 2.0
    return share * x, share * y, share * z


@inlined
def _near_and_far(square):
    """1 for θ² below NEAR, else 0, θ² there, else 0, and θ² elsewhere, but 1 there."""
    far = greater(square, NEAR)
    near = 1.0 - far
    return near, near * square, far * square + near


@inlined
def jacobian_coefficients(square):
    """The coefficients a and b at θ²: series where θ is near zero, the closed forms elsewhere."""
    near, t, far = _near_and_far(square)
    angle = sqrt(far)
    cos, sin = cosine_sine(angle)
    a, b = (1.0 - cos) / far, (angle - sin) / (far * angle)
    zero = 0.0 * t
    return near * series(_SERIES[2], t, zero) + (1.0 - near) * a, near * series(_SERIES[3], t, zero) + (1.0 - near) * b


@inlined
def jacobian_slopes(square):
    """The derivatives of a and b by θ, divided by θ."""
    near, t, far = _near_and_far(square)
    angle = sqrt(far)
    cos, sin = cosine_sine(angle)
    a = (angle * sin - 2.0 * (1.0 - cos)) / (far * far)
    b = (3.0 * sin - angle * cos - 2.0 * angle) / (far * far * angle)
    zero = 0.0 * t
    third, fourth, fifth = series(_SERIES[3], t, zero), series(_SERIES[4], t, zero), series(_SERIES[5], t, zero)
    # The derivative of a series by θ² is made of the next two.
    return near * (2.0 * fourth - third) + (1.0 - near) * a, near * (3.0 * fifth - fourth) + (1.0 - near) * b


@inlined
def right_jacobian(x, y, z):
    """Jr of a rotation vector, row by row."""
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


@inlined
def inverse_jacobian(v, u, half):
    """Jr(v)⁻¹ u for a half of ½, Jl(v)⁻¹ u = Jr(v)⁻ᵀ u for −½.

    The latter is the derivative by a turn in the rotated axes, where u is the one by the rotation vector v.
    """
    square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
    far = greater(square, 1e-3)
    divisor = far * square + (1.0 - far)
    h = 0.5 * sqrt(divisor)
    cos, sin = cosine_sine(h)
    t = (1.0 - far) * square
    c = far * ((1.0 - h * cos / sin) / divisor) + (1.0 - far) * (1.0 / 12.0 + t * (1.0 / 720.0 + t * (1.0 / 30240.0)))
    s = _cross(v, u)
    r = _cross(v, s)
    return u[0] + half * s[0] + c * r[0], u[1] + half * s[1] + c * r[1], u[2] + half * s[2] + c * r[2]


@inlined
def second_derivatives(v, moment):
    """The numbers m·∂Jl(v)eᵢ/∂vⱼ for i ≤ j, where the moment is Jl(v)ᵀ m: of row 0, of row 1, of row 2.

    With [v]² = v vᵀ − θ² they are linear in m, v × m and v × (v × m), besides the derivatives of a and b.
    """
    x, y, z = v
    square = x * x + y * y + z * z
    a, b = jacobian_coefficients(square)
    slope_a, slope_b = jacobian_slopes(square)
    m = inverse_jacobian(v, moment, 0.5)
    across = _cross(v, m)
    twice = _cross(v, across)
    p = slope_b * twice[0] - slope_a * across[0]
    q = slope_b * twice[1] - slope_a * across[1]
    r = slope_b * twice[2] - slope_a * across[2]
    along = b * (x * m[0] + y * m[1] + z * m[2])
    return (
        (x * p - b * m[0] * x + along,),
        (y * p + b * (m[1] * x - 2.0 * m[0] * y) - a * m[2], y * q - b * m[1] * y + along),
        (
            z * p + b * (m[2] * x - 2.0 * m[0] * z) + a * m[1],
            z * q + b * (m[2] * y - 2.0 * m[1] * z) - a * m[0],
            z * r - b * m[2] * z + along,
        ),
    )
