"""Numbers by the million: every parser returns the doubles that the digits stand for, or refuses the text."""

import random
from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skpose.io._numbers import parse, parse_fixed
from skpose.io._source import Chunk
from skpose.io._words import NUMBER

decimal = st.builds(
    lambda sign, whole, part: f"{sign}{whole}.{part}",
    st.sampled_from(["", "-", "+"]),
    st.integers(0, 10**12).map(str) | st.just(""),
    st.integers(0, 10**6 - 1).map("{:06}".format) | st.integers(0, 99).map("{:02}".format),
)
ODD = ["1", "-", "+", ".", "1e3", "1.5e-7", "nan", "-inf", "1_0.000000", "1.2.345678", "0.1-7.000000", "x", "1.12345"]
words = decimal | st.sampled_from(ODD) | st.text("0123456789.+-eE_ \tx", max_size=9)
blanks = st.sampled_from([" ", "  ", "\n", "\t", " \r\n"])


def expected(text):
    """Return the numbers, parsed one at a time."""
    tokens = text.split()
    return np.array([float(token) for token in tokens]) if all(map(NUMBER.fullmatch, tokens)) else None


def assert_same(found, numbers):
    """Check that all numbers are equal, and that zeros have their signs."""
    np.testing.assert_array_equal(found, numbers)
    np.testing.assert_array_equal(np.signbit(found), np.signbit(numbers))


def read(text):
    return parse(Chunk(1, 0, text.encode()))


@settings(max_examples=500, deadline=None, derandomize=True, database=None)
@given(st.lists(decimal | words, max_size=12), st.lists(blanks, min_size=12, max_size=12))
def test_words_and_numbers(tokens, between):
    text = "".join(a + b for a, b in zip(tokens, between, strict=False))
    if expected(text) is None:
        assert read(text) is None
    else:
        assert_same(read(text), expected(text))


@pytest.mark.parametrize("form", ["%.6f", "%g", "%.4f", "%d", "%.3e", "%.15g", "%.17g", "%r", "%.18f"])
def test_numbers_as_programs_write_them(form):
    rng = random.Random(0)
    tokens = [form % (rng.gauss(0, 1) * 10 ** rng.uniform(-3, 4)) for _ in range(3000)]
    assert_same(read(" ".join(tokens)), [float(token) for token in tokens])


@pytest.mark.parametrize("n_digits", [16, 17, 18])
def test_numbers_between_two_doubles(n_digits):
    """Words of so many digits that are as near as can be to the middle between two doubles."""
    rng, tokens = random.Random(2), []
    for _ in range(300):
        x = rng.uniform(1, 10) * 10.0 ** rng.randint(-3, 3)
        with localcontext() as context:
            context.prec = 60
            middle = (Decimal(x) + Decimal(float(np.nextafter(x, np.inf)))) / 2
            context.prec = n_digits
            tokens += [format(word, "f") for word in (+middle, middle.next_plus(), middle.next_minus())]
    assert_same(read(" ".join(tokens)), [float(token) for token in tokens])


def test_exponents():
    """Six digits and an exponent as of CMU's files; and past what doubles hold."""
    rng = random.Random(1)
    tokens = [f"{rng.uniform(-10, 10):.5f}e{rng.randint(-400, 400):+04}" for _ in range(3000)]
    assert_same(read(" ".join(tokens)), [float(token) for token in tokens])


@pytest.mark.parametrize("n_digits", [1, 4, 6, 9, 15])
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
