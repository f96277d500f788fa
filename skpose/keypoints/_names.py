"""Names of points as different programs write them: Nose and nose, RBigToe and right_big_toe, ShoulderLeft."""

import re
from collections.abc import Iterable, Sequence

WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
SIDES = {"l": "left", "left": "left", "r": "right", "right": "right"}


def find_names(wanted: Iterable[str], names: Sequence[str]) -> dict[str, str]:
    """The name that matches each wanted name in another spelling; wanted names without a match are left out.

    An equal name comes first, then one that differs in case, then one with the same words: case and separators are
    ignored, L is left and R is right, and a side may be anywhere. Several matches raise a ValueError.
    """
    found = {}
    for name in wanted:
        if name in names:
            found[name] = name
            continue
        for spelling in (str.casefold, _words):
            same = [other for other in names if spelling(other) == spelling(name)]
            if len(same) > 1:
                raise ValueError(f"the point {name!r} may be {' or '.join(map(repr, same))}: rename one of them")
            if same:
                found[name] = same[0]
                break
    return found


def _words(name: str) -> tuple[str, str]:
    """The side and the other words of a name; no side if it has several."""
    words = [word.lower() for word in WORD.findall(name)]
    sides = [SIDES[word] for word in words if word in SIDES]
    if len(sides) != 1:
        return "", "".join(words)
    return sides[0], "".join(word for word in words if word not in SIDES)
