"""Decimal numbers in the bytes of a text, exactly rounded, and the frames of an AMC file.

A number is w · 10^p, w its digits without the point. Doubles hold integers up to 2^53 and powers of ten up to 10^22
exactly, so that one division or multiplication gives the nearest double (W. D. Clinger, How to read floating point
numbers accurately, 1990, DOI 10.1145/93542.93557). A larger w, of up to 18 digits, is a sum of two doubles, and so is
its quotient; their sum rounds to the nearest double unless the number is too close to the middle between two.

What is left, such as 1e-300 or 25 digits, becomes NaN here, and the caller reads it. The word nan is no number.
A text ends with a blank, so that no loop has to look for its end.
"""

import numpy as np

from skpose._compiled.simd.jit import inlined, jit

EXACT = 2**53  # doubles hold all integers up to this one
POWERS = 10.0 ** np.arange(23)
UPPER = POWERS.astype(np.float32).astype(np.float64)  # the first 24 bits of each
LOWER = POWERS - UPPER
UNCERTAIN = 2.0**-70  # more than the relative error of a quotient that is a sum of two doubles

OTHER, BLANK, NEWLINE = 10, 11, 12  # kinds of bytes; those below are digits
KIND = np.full(256, OTHER)
KIND[list(b"0123456789")] = np.arange(10)
KIND[list(b" \t\v\f\r")] = BLANK
KIND[ord("\n")] = NEWLINE
PLUS, MINUS, POINT, ZERO, SMALL_E, LARGE_E = b"+-.0eE"


@inlined
def quotient(w, p):
    """Return w / 10^p as the nearest double, for w up to 10^18; NaN where rounding is uncertain."""
    high = float(w)
    low = float(w - np.int64(high))
    q = high / POWERS[p]
    # The remainder high − q · 10^p, of parts whose products are exact: it is the same where operations are fused.
    upper = float(np.float32(q))
    lower = q - upper
    remainder = high - upper * UPPER[p]
    remainder -= upper * LOWER[p]
    remainder -= lower * UPPER[p]
    remainder -= lower * LOWER[p]
    more = (remainder + low) / POWERS[p]
    nearest = q + (more + q * UNCERTAIN)
    return nearest if nearest == q + (more - q * UNCERTAIN) else np.nan


@inlined
def decimal(text, at):
    """Return the number that begins at an index, NaN where the caller has to read it, and its end, −1 if it is none."""
    negative = text[at] == MINUS
    if negative or text[at] == PLUS:
        at += 1
    begin, w, p = at, 0, 0
    while text[at] == ZERO:
        at += 1
    first = at
    while KIND[text[at]] < OTHER:
        w = w * 10 + KIND[text[at]]
        at += 1
    n_digits = at - first  # from the first that is not zero
    if text[at] == POINT:
        at += 1
        begin, p = begin + 1, at
        if n_digits == 0:
            while text[at] == ZERO:
                at += 1
        first = at
        while KIND[text[at]] < OTHER:
            w = w * 10 + KIND[text[at]]
            at += 1
        n_digits += at - first
        p -= at
    if at == begin:
        return 0.0, -1
    if text[at] == SMALL_E or text[at] == LARGE_E:
        at += 1
        down = text[at] == MINUS
        if down or text[at] == PLUS:
            at += 1
        first, exponent = at, 0
        while KIND[text[at]] < OTHER:
            exponent = exponent * 10 + KIND[text[at]]
            at += 1
        if at == first:
            return 0.0, -1
        if at > first + 9:  # it may have overflowed
            n_digits = 99
        p += -exponent if down else exponent
    if n_digits > 18 or p < -22 or p > 22 or (w > EXACT and p > 0):
        value = np.nan
    elif w > EXACT:
        value = quotient(w, -p)
    elif p > 0:
        value = w * POWERS[p]
    else:
        value = w / POWERS[-p]
    return (-value if negative else value), at


@jit
def decimals(text, numbers):
    """Write all numbers of a text to `numbers`; return how many, −1 where there are more or any other word."""
    n, at, size = 0, 0, len(text)
    while True:
        while at < size and KIND[text[at]] > OTHER:
            at += 1
        if at == size:
            return n
        if n == len(numbers):
            return -1
        numbers[n], at = decimal(text, at)
        if at < 0 or KIND[text[at]] <= OTHER:
            return -1
        n += 1


@jit
def frames(text, number, names, ends, counts, table):
    """Write the numbers of the frames of an AMC file to `table`, a row a frame, as long as nothing is unusual.

    The text begins with the line of a frame's number, and ends with a whole frame. Each frame must have a line for its
    number, the first's is `number`, and one for each bone: its name, ``names[ends[i - 1] : ends[i]]``, and `counts[i]`
    numbers. Return how many frames are read, and where they end.
    """
    n, at, begin = 0, 0, 0
    while at < len(text):
        start, found = at, 0
        while KIND[text[at]] == BLANK:
            at += 1
        first = at
        while KIND[text[at]] < OTHER:
            found = found * 10 + KIND[text[at]]
            at += 1
        n_digits = at - first
        while KIND[text[at]] == BLANK:
            at += 1
        if n == len(table) or n_digits == 0 or n_digits > 18 or found != number + n or KIND[text[at]] != NEWLINE:
            return n - (n > 0), begin  # the last frame may go on here
        begin, column, k = start, 0, 0
        for bone in range(len(ends)):
            at += 1  # past the end of the line before
            if at == len(text):
                return n, begin
            while KIND[text[at]] == BLANK:
                at += 1
            while k < ends[bone] and text[at] == names[k]:
                at += 1
                k += 1
            if k < ends[bone]:
                return n, begin
            for _ in range(counts[bone]):
                word = at
                while KIND[text[at]] == BLANK:
                    at += 1
                if at == word:
                    return n, begin
                table[n, column], at = decimal(text, at)
                if at < 0 or np.isnan(table[n, column]):
                    return n, begin
                column += 1
            while KIND[text[at]] == BLANK:
                at += 1
            if KIND[text[at]] != NEWLINE:
                return n, begin
        at += 1
        n += 1
    return n, at
