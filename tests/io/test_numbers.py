"""Numbers by the million: every parser returns the doubles that the digits stand for, or refuses the text."""

import random

import numpy as np
import pytest

from skpose.io._source import NUMBER, parse, parse_fixed


def expected(text):
    """Return the numbers, parsed one at a time."""
    tokens = text.split()
    return np.array([float(token) for token in tokens]) if all(map(NUMBER.fullmatch, tokens)) else None


def assert_same(found, numbers):
    """Check that all numbers are equal, and that zeros have their signs."""
    np.testing.assert_array_equal(found, numbers)
    np.testing.assert_array_equal(np.signbit(found), np.signbit(numbers))


def read(text):
    return parse(text.encode())


@pytest.mark.parametrize("form", ["%.6f", "%g", "%d", "%.17g"])
def test_numbers_as_programs_write_them(form):
    rng = random.Random(0)
    tokens = [form % (rng.gauss(0, 1) * 10 ** rng.uniform(-3, 4)) for _ in range(3000)]
    assert_same(read(" ".join(tokens)), [float(token) for token in tokens])


@pytest.mark.parametrize("n_digits", [1, 6, 15])
def test_equally_many_digits_are_read_as_integers_exactly(n_digits):
    rng = np.random.default_rng(n_digits)
    values = rng.normal(scale=[1e-6, 1, 100, 1e5], size=(5000, 4)).ravel()
    tokens = [f"{x:.{n_digits}f}".replace("-0.", "-.") for x in values] + ["-0." + n_digits * "0"]
    found = parse_fixed(" ".join(tokens).encode())
    if n_digits == 15:  # some integers are past what a double holds exactly: the parser of floats
        assert found is None
        found = read(" ".join(tokens))
    assert_same(found, [float(token) for token in tokens])


@pytest.mark.parametrize(
    "text",
    [
        "9007199254740993.0",
        "-9223372036854775808.",
        "0." + "1" * 23,
        "1.5 2",
        "1.2 3 4.567",
        "5.",
        ".",
        "-.",
        ".-",
        "x",
    ],
)
def test_numbers_that_are_not_read_as_integers(text):
    assert parse_fixed(text.encode()) is None
    found = read(text)
    assert np.array_equal(found, expected(text)) if expected(text) is not None else found is None
