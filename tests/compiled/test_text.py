"""Numbers in text against Python's float, to the last bit; frames of AMC files against their words."""

import random
from decimal import Decimal, localcontext

import numpy as np
import pytest

from skpose._compiled.text import decimals, frames

N = 3000
# Plain Python warns where more than 18 digits do not fit 64 bits.
pytestmark = pytest.mark.filterwarnings("ignore:overflow encountered:RuntimeWarning")


def read(words):
    """Return the numbers of some words, NaN where they are left to the caller; None if the text is refused."""
    text = np.frombuffer((" ".join(words) + "\n").encode(), np.uint8)
    numbers = np.empty(len(words))
    n = decimals(text, numbers)
    return None if n < 0 else numbers[:n]


def check(words, most_left=0):
    found, expected = read(words), np.array([float(word) for word in words])
    left = np.isnan(found)
    assert np.count_nonzero(left) <= most_left
    np.testing.assert_array_equal(found[~left], expected[~left])
    np.testing.assert_array_equal(np.signbit(found[~left]), np.signbit(expected[~left]))


@pytest.mark.parametrize("form", ["%.6f", "%g", "%.4f", "%d", "%.3e", "%.15g", "%.17g", "%r", "%.18f"])
def test_numbers_as_programs_write_them(form):
    rng = random.Random(0)
    values = [rng.gauss(0, 1) * 10 ** rng.uniform(-3, 4) for _ in range(N)]
    check([form % x for x in values], most_left=N if form == "%.18f" else N // 200)


def test_exponents():
    """Six digits and an exponent as of CMU's files; and past what doubles hold."""
    rng = random.Random(1)
    check([f"{rng.uniform(-10, 10):.5f}e{rng.randint(-17, 17):+04}" for _ in range(N)])
    check([f"{rng.uniform(-10, 10):.12f}E{rng.randint(-400, 400)}" for _ in range(N)], most_left=N)
    check([f"{rng.randint(10**16, 10**18)}e{rng.randint(-30, 30)}" for _ in range(N)], most_left=N)


def near_middles(rng, n_digits):
    """Yield words of so many digits that are as near as can be to the middle between two doubles, and their like."""
    for _ in range(N // 10):
        x = rng.uniform(1, 10) * 10.0 ** rng.randint(-3, 3)
        with localcontext() as context:
            context.prec = 60
            middle = (Decimal(x) + Decimal(float(np.nextafter(x, np.inf)))) / 2
            context.prec = n_digits
            yield from (format(word, "f") for word in (+middle, middle.next_plus(), middle.next_minus()))


@pytest.mark.parametrize("n_digits", [16, 17, 18])
def test_numbers_between_two_doubles(n_digits):
    check(list(near_middles(random.Random(2), n_digits)), most_left=N // 100)


def test_what_is_half_between_two_doubles_is_left_to_the_caller():
    words = [
        "9007199254740993",
        "-9007199254740995.0",
        "4503599627370497.5",
        "1e23",
        "1e-300",
        "1" * 40,
        "1e999",
        "0e99",
    ]
    assert np.isnan(read(words)).all()


def test_every_form_of_a_number():
    check(
        ["1", "+1", "-1", "-0", "0.", ".5", "-.5", "+5.e3", "1E5", "00012", "1e+00", "-0.0e-5", "1e-00022", "000.0001"]
    )
    assert read([" ", "\t1\r\n2\v\f3", "\n"]).tolist() == [1, 2, 3]
    assert read([]).size == 0


@pytest.mark.parametrize(
    "word",
    ["", ".", "-", "+", "-.", ".e5", "1e", "1e+", "1-2", "1..2", "1.2.3", "1_0", "1,5", "0x1", "nan", "inf", "--1",
     "\x1c", "1\x00", "é", "1e5.0", "1e5e5"],
)  # fmt: skip
@pytest.mark.parametrize("before", ["", "1.5 "])
def test_words_that_are_no_numbers(word, before):
    assert (read([before + word]) is None) == bool(word)


def test_more_numbers_than_fit():
    assert decimals(np.frombuffer(b"1 2 3\n", np.uint8), np.empty(2)) == -1
    assert decimals(np.frombuffer(b"1 2 ", np.uint8), np.empty(2)) == 2


WHOLE = "7\nroot 1 -2.5\narm 3e-1\n8\n root  4 5\r\narm\t6 \n009 \nroot 7 8\narm 9\n"
BROKEN = [  # the same with something else, and how many frames come before it
    ("\nroot 7", "\nRoot 7", 2),
    ("\nroot 7", "\nroots 7", 2),
    ("\nroot 7 8", "\nroot 7", 2),
    ("\nroot 7 8", "\nroot 7 8 9", 2),
    ("\nroot 7 8", "\nroot 7 nan", 2),
    ("\nroot 7 8", "\nroot 7 1e-300", 2),
    ("arm 9\n", "ar\n", 2),
    ("arm 9\n", "", 2),
    ("root 7 8\narm 9\n", "", 2),
    ("arm 9", "arm", 2),
    ("arm 9", "arm ", 2),
    ("arm 9", "arm9", 2),
    ("\n009 ", " 9 ", 1),
    ("\n009 ", "\n10 ", 1),
    ("\n009 ", "\n9.0 ", 1),
    ("\n009 ", "\nleg 1", 1),
    ("\n009 ", "\n\n9 ", 1),
    ("\n009 ", "\n# a comment\n9", 1),
    ("\n009 ", "\n9 # the last", 1),
    ("\n009 ", "\n" + "0" * 18 + "9", 1),
    ("arm 3e-1", "arm 3e-1 # bent", 0),
    ("7\n", "6\n", 0),
]


def read_frames(text, n_most=9):
    table = np.zeros((n_most, 3))
    names = np.frombuffer(b"rootarm", np.uint8)
    n, end = frames(np.frombuffer(text.encode(), np.uint8), 7, names, np.array([4, 7]), np.array([2, 1]), table)
    return table[:n].tolist(), text[end:]


def test_frames():
    rows = [[1, -2.5, 0.3], [4, 5, 6], [7, 8, 9]]
    assert read_frames(WHOLE) == (rows, "")
    assert read_frames(WHOLE, n_most=2) == (rows[:1], WHOLE[WHOLE.index("8\n") :])


@pytest.mark.parametrize(("old", "new", "n_before"), BROKEN)
def test_frames_up_to_what_is_unusual(old, new, n_before):
    assert old in WHOLE
    text = WHOLE.replace(old, new, 1)
    rows, rest = read_frames(text)
    assert len(rows) == n_before
    assert rest == text[[0, text.find("8\n"), text.find("009")][n_before] :]
