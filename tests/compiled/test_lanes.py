"""Lanes against numpy: every operation on all of them, and on one number."""

import numpy as np
import pytest
from numba import njit

from skpose._compiled.pose.encode import cosine_sine
from skpose._compiled.simd.lanes import (
    any_greater,
    full_like,
    greater,
    lanes,
    minimum,
    next_lane,
    rint,
    rows,
    sqrt,
    sum_of_lanes,
)


@njit
def compute(a, b, out, flags):
    x, y, put = rows(a, 0), rows(b, 0), rows(out, 0)
    n = a.shape[0]
    for i in range(n):
        put[i] = x[i] + y[i] * 2.0 - 0.5
        put[n + i] = sqrt(x[i] * x[i])
        put[2 * n + i] = rint(x[i])
        put[3 * n + i] = minimum(x[i], y[i])
        put[4 * n + i] = greater(x[i], 0.25)
        put[5 * n + i] = full_like(x, 3)
        flags[i] = any_greater(x[i], 1.0)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("in_lanes", [True, False])
def test_operations(dtype, in_lanes):
    width = lanes(np.dtype(dtype))
    rng = np.random.default_rng(0)
    shape = (20, width) if in_lanes else (20,)
    a, b = rng.normal(size=shape).astype(dtype), rng.normal(size=shape).astype(dtype)
    a[3], a[4] = 0.5, 1.5  # halves go to the even number
    out, flags = np.empty((6 * 20, *shape[1:]), dtype), np.empty(20, bool)
    compute(a, b, out, flags)
    expected = [a + b * 2 - 0.5, np.abs(a), np.rint(a), np.minimum(a, b), (a > 0.25).astype(dtype), np.full(shape, 3.0)]
    np.testing.assert_allclose(out, np.concatenate(expected), rtol=1e-6 if dtype is np.float32 else 1e-15, atol=1e-6)
    np.testing.assert_array_equal(flags, (a > 1).any(axis=1) if in_lanes else a > 1)


@njit
def across(a, moved, sums):
    x, put = rows(a, 0), rows(moved, 0)
    for i in range(a.shape[0]):
        put[i], sums[i] = next_lane(x[i]), sum_of_lanes(x[i])


def test_operations_across_lanes():
    a = np.random.default_rng(0).normal(size=(20, lanes(np.dtype(np.float64))))
    moved, sums = np.empty_like(a), np.empty(20)
    across(a, moved, sums)
    np.testing.assert_array_equal(moved, np.column_stack([a[:, 1:], a[:, -1]]))
    np.testing.assert_array_equal(sums, np.cumsum(a, axis=1)[:, -1])  # in order: the same on every processor


@njit
def trigonometry(angles, cosines, sines):
    x, c, s = rows(angles, 0), rows(cosines, 0), rows(sines, 0)
    for i in range(angles.shape[0]):
        c[i], s[i] = cosine_sine(x[i])


@pytest.mark.parametrize("reach", [1e-300, 4.0, 1e7])
def test_cosine_and_sine(reach):
    width = lanes(np.dtype(np.float64))
    angles = reach * np.random.default_rng(0).uniform(-1, 1, (5000, width))
    angles[:9] = np.pi / 4 * np.arange(-4, 5)[:, None]
    cosines, sines = np.empty_like(angles), np.empty_like(angles)
    trigonometry(angles, cosines, sines)
    np.testing.assert_allclose(cosines, np.cos(angles), rtol=0, atol=4e-16)
    np.testing.assert_allclose(sines, np.sin(angles), rtol=0, atol=4e-16)
    one_by_one = np.empty((2, angles.size))
    trigonometry(angles.ravel(), *one_by_one)
    np.testing.assert_array_equal(one_by_one, [cosines.ravel(), sines.ravel()])
