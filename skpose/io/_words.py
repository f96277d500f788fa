"""Words of a file with their positions, and which of them are numbers."""

import re
from typing import Self

REAL = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
NUMBER = re.compile(rf"{REAL}|[+-]?(?:nan|inf(?:inity)?)", re.ASCII | re.IGNORECASE)
WHOLE = re.compile(r"\d{1,18}", re.ASCII)  # fits 64 bits; Python's int() refuses more than 4,300 digits
GLUED = re.compile(rf"{REAL}(?:[+-](?:\d|\.)[\d.eE+-]*)+", re.ASCII)
DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?", re.ASCII)


class Token(str):
    """A word of a file with its line and column, both from 1."""

    line: int
    column: int

    def __new__(cls, word: str, line: int, column: int) -> Self:
        token = super().__new__(cls, word)
        token.line, token.column = line, column
        return token

    def __getnewargs__(self) -> tuple[str, int, int]:  # type: ignore[override]  # for pickle
        return str(self), self.line, self.column


def complaint(token: str) -> str:
    """Return why a word is not accepted as a number, with the likely cause."""
    shown = repr(str(token[:40]))
    if NUMBER.fullmatch(token):
        return f"expected a finite number, found {shown}"
    if DECIMAL_COMMA.fullmatch(token):
        return f"expected a number, found {shown}, which has a decimal comma: write it with a point"
    if GLUED.fullmatch(token):
        return f"expected a number, found {shown}: numbers without a blank between them"
    return f"expected a number, found {shown}"
