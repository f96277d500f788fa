"""Left and right: the joints of a skeleton as pairs, and their sides, by their names."""

import re
from collections.abc import Sequence

# Unambiguous names of a side: "LeftArm", "hand_left", "mixamorig:LeftHand"; "L_Hip", "hip.r", "Bip01 L Arm".
_WORD = re.compile(r"(?<![A-Za-z])(?:left|right)|(?:Left|Right)|(?<![A-Z])(?:LEFT|RIGHT)(?![A-Z])|[左右]")
_LETTER = re.compile(r"(?<![A-Za-z0-9])[LlRr](?![A-Za-z0-9])")
SURE = (_WORD, _LETTER)
# Names of a side if a joint has the other side: "lfemur", "LHip", "armLeft", "HipR".
MAYBE = (
    re.compile(r"left|right", re.IGNORECASE | re.ASCII),  # Turkish has letters that are an i in Unicode alone
    re.compile(r"(?<![A-Za-z0-9])[LlRr](?=[A-Za-z])"),
    re.compile(r"(?<=[a-z0-9])[LR]$"),
)
PATTERNS = (*SURE, *MAYBE)
OTHER = {"left": "right", "right": "left", "l": "r", "r": "l", "左": "右", "右": "左"}


def partners(names: Sequence[str]) -> list[int]:
    """The index of the joint on the other side for each joint; its own on the middle line."""
    index = {name: i for i, name in enumerate(names)}
    found = {name: [other for other in others(name) if other in index] for name in names}
    for name, candidates in found.items():
        if len(candidates) > 1:
            raise ValueError(f"left and right must be pairs by name, but {name!r} has several partners: {candidates}")
        if not candidates and any(pattern.search(name) for pattern in SURE):
            raise ValueError(f"left and right must be pairs by name, but {name!r} is alone")
    return [index[candidates[0]] if candidates else index[name] for name, candidates in found.items()]


def sides(names: Sequence[str]) -> list[str]:
    """The side of each joint by its name: "left", "right", or "" on the middle line.

    Letters as in "lfemur" and "LHip" state a side if a joint has the other side.
    """
    return [side for side, _ in split_sides(names)]


def split_sides(names: Sequence[str]) -> list[tuple[str, str]]:
    """The side of each joint, see `sides`, and its name without the word or letter for the side."""
    known = set(names)
    found = []
    for name in names:
        matches = [
            match
            for pattern in PATTERNS
            if (match := pattern.search(name)) and (pattern in SURE or pattern.sub(_other, name) in known)
        ]
        side = ("left" if matches[0].group()[0] in "lL左" else "right") if matches else ""
        found.append((side, name[: matches[0].start()] + name[matches[0].end() :] if matches else name))
    return found


def others(name: str) -> list[str]:
    """The name with the other side, in several readings."""
    names = dict.fromkeys(pattern.sub(_other, name) for pattern in PATTERNS)
    names.pop(name, None)
    return list(names)


def _other(match: re.Match) -> str:
    """The word for the other side, in the same case."""
    side = match.group()
    other = OTHER[side.lower()]
    return other.upper() if side.isupper() else other.capitalize() if side[0].isupper() else other
