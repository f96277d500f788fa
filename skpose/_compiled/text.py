"""Decimal numbers in the bytes of a text, exactly rounded, and the frames of an AMC file.

A number is w · 10^p, w its digits without the point. Doubles hold integers up to 2^53 and powers of ten up to 10^22
exactly, so that one division or multiplication gives the nearest double (W. D. Clinger, How to read floating point
numbers accurately, 1990, DOI 10.1145/93542.93557). A larger w, of up to 18 digits, is a sum of two doubles, and so is
its quotient; their sum rounds to the nearest double unless the number is too close to the middle between two.

What is left, such as 1e-300 or 25 digits, becomes NaN here, and the caller reads it. The word nan is no number.
"""

import numpy as np

from skpose._compiled.jit import inlined, internal

EXACT = 2**53  # doubles hold all integers up to this one
POWERS = 10.0 ** np.arange(23)
UPPER = POWERS.astype(np.float32).astype(np.float64)  # the first 24 bits of each
LOWER = POWERS - UPPER
UNCERTAIN = 2.0**-70  # more than the relative error of a quotient that is a sum of two doubles

DIGIT = np.full(256, -1)  # what each byte stands for
DIGIT[list(b"0123456789")] = np.arange(10)
TAB, NEWLINE, RETURN, BLANK, PLUS, MINUS, POINT, ZERO, SMALL_E = b"\t\n\r +-.0e"


@inlined
def quotient(w, p):
    """Return w / 10^p as the nearest double, for w up to 10^18; NaN where rounding is uncertain."""
    high = float(w)
    low = float(w - int(high))
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
def past_zeros(text, at):
    """Return the index after zeros."""
    while at < len(text) and text[at] == ZERO:
        at += 1
    return at


@inlined
def decimal(text, at):
    """Return the number that begins at an index, NaN where the caller has to read it, and its end, −1 if it is none."""
    size = len(text)
    negative = text[at] == MINUS
    if negative or text[at] == PLUS:
        at += 1
    begin, w, p = at, 0, 0
    at = past_zeros(text, at)
    first = at
    while at < size and DIGIT[text[at]] >= 0:
        w = w * 10 + int(DIGIT[text[at]])
        at += 1
    n_digits = at - first  # from the first that is not zero
    if at < size and text[at] == POINT:
        at += 1
        begin, p = begin + 1, at
        at = past_zeros(text, at) if n_digits == 0 else at
        first = at
        while at < size and DIGIT[text[at]] >= 0:
            w = w * 10 + int(DIGIT[text[at]])
            at += 1
        n_digits += at - first
        p -= at
    if at == begin:
        return 0.0, -1
    if at < size and text[at] | 32 == SMALL_E:
        at += 1
        down = at < size and text[at] == MINUS
        if down or (at < size and text[at] == PLUS):
            at += 1
        first, exponent = at, 0
        while at < size and DIGIT[text[at]] >= 0:
            exponent = exponent * 10 + int(DIGIT[text[at]])
            at += 1
        if at == first:
            return 0.0, -1
        p += -exponent if down else exponent
        n_digits += 99 * (at > first + 9)  # exponent may have overflowed
    if n_digits > 18 or p < -22 or p > 22 or (w > EXACT and p > 0):
        value = np.nan
    elif w > EXACT:
        value = quotient(w, -p)
    else:
        value = float(w) * POWERS[p] if p > 0 else float(w) / POWERS[-p]
    return (-value if negative else value), at


@internal
def decimals(text, numbers):
    """Write all numbers of a text to `numbers`; return how many, −1 where there are more or any other word."""
    n, at, size = 0, 0, len(text)
    while True:
        while at < size and (text[at] == BLANK or TAB <= text[at] <= RETURN):
            at += 1
        if at == size:
            return n
        if n == len(numbers):
            return -1
        numbers[n], at = decimal(text, at)
        if at < 0 or (at < size and text[at] != BLANK and not TAB <= text[at] <= RETURN):
            return -1
        n += 1


@inlined
def past_blanks(text, at):
    """Return the index after blanks inside a line."""
    while at < len(text) and (text[at] == BLANK or text[at] == TAB or text[at] == RETURN):
        at += 1
    return at


@inlined
def past_line(text, at):
    """Return the index after the end of the line, −1 unless only blanks come before it."""
    at = past_blanks(text, at)
    if at == len(text):
        return at
    return at + 1 if text[at] == NEWLINE else -1


@internal
def frames(text, number, names, ends, counts, table):
    """Write the numbers of the frames of an AMC file to `table`, a row a frame, as long as nothing is unusual.

    The text begins with the line of a frame's number, and ends with a whole frame. Each frame must have a line for its
    number, the first's is `number`, and one for each bone: its name, ``names[ends[i - 1] : ends[i]]``, and `counts[i]`
    numbers. Return how many frames are read, and where they end.
    """
    n, at, begin, size = 0, 0, 0, len(text)
    while at < size:
        start = at
        first = at = past_blanks(text, start)
        found = 0
        while at < size and DIGIT[text[at]] >= 0:
            found = found * 10 + int(DIGIT[text[at]])
            at += 1
        line = past_line(text, at)
        if n == len(table) or not 1 <= at - first <= 18 or found != number + n or line < 0:
            return n - (n > 0), begin  # the last frame may go on here
        begin, at, column, k = start, line, 0, 0
        for bone in range(len(ends)):
            at = past_blanks(text, at)
            while k < ends[bone] and at < size and text[at] == names[k]:
                at += 1
                k += 1
            if k < ends[bone]:
                return n, begin
            for _ in range(counts[bone]):
                word = past_blanks(text, at)
                if not at < word < size:
                    return n, begin
                table[n, column], at = decimal(text, word)
                if at < 0 or np.isnan(table[n, column]):
                    return n, begin
                column += 1
            at = past_line(text, at)
            if at < 0:
                return n, begin
        n += 1
    return n, at
