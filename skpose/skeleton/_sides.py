"""Left and right: the joints of a skeleton as pairs, and their sides, by their names."""

import re
from collections.abc import Sequence

# Names that state a side beyond dispute: "LeftArm", "hand_left", "mixamorig:LeftHand"; "L_Hip", "hip.r", "Bip01 L Arm".
_WORD = re.compile(r"(?<![A-Za-z])(?:left|right)|(?:Left|Right)|(?<![A-Z])(?:LEFT|RIGHT)(?![A-Z])")
_LETTER = re.compile(r"(?<![A-Za-z0-9])[LlRr](?![A-Za-z0-9])")
SURE = (_WORD, _LETTER)
# Names that state one if there is a joint with the other: "lfemur", "LHip", "armLeft", "HipR".
MAYBE = (
    re.compile(r"left|right", re.IGNORECASE | re.ASCII),  # Turkish has letters that are an i in Unicode alone
    re.compile(r"(?<![A-Za-z0-9])[LlRr](?=[A-Za-z])"),
    re.compile(r"(?<=[a-z0-9])[LR]$"),
)
PATTERNS = (*SURE, *MAYBE)
OTHER = {"left": "right", "right": "left", "l": "r", "r": "l"}


def partners(names: Sequence[str]) -> list[int]:
    """Return for each joint the index of the joint on the other side, its own on the middle line.

    Raises a ValueError for a name with a side and without a partner, or with several.
    """
    index = {name: i for i, name in enumerate(names)}
    found = {name: [other for other in others(name) if other in index] for name in names}
    several = [f"{name!r} ({', '.join(map(repr, others))})" for name, others in found.items() if len(others) > 1]
    if several:
        raise ValueError(
            f"joints of the left and of the right must be pairs by name, but some have several: {_list_some(several)}"
        )
    alone = [repr(name) for name in names if not found[name] and any(one.search(name) for one in SURE)]
    if alone:
        raise ValueError(
            f"joints of the left and of the right must be pairs by name, but some are alone: {_list_some(alone)}. "
            "Leave them out, such as by layout.without([...]) of markers, or name their partners"
        )
    return [index[others[0]] if others else index[name] for name, others in found.items()]


def sides(names: Sequence[str]) -> list[str]:
    """Return "left", "right" or "", on the middle line, for each joint, by its name; never an error.

    Letters such as those of "lfemur" and "LHip" state a side if there is a joint with the other one.
    """
    return [side for side, _ in split_sides(names)]


def split_sides(names: Sequence[str]) -> list[tuple[str, str]]:
    """Return for each joint "left", "right" or "", as `sides` does, and the name without the word or letter for it."""
    known = set(names)
    found = []
    for name in names:
        matches = [
            match
            for pattern in PATTERNS
            if (match := pattern.search(name)) and (pattern in SURE or pattern.sub(_other, name) in known)
        ]
        side = {"l": "left", "r": "right"}[matches[0].group()[0].lower()] if matches else ""
        found.append((side, name[: matches[0].start()] + name[matches[0].end() :] if matches else name))
    return found


def without_side(name: str) -> str:
    """Return a name without the word or the letter for its side; the name itself if it has none."""
    for pattern in PATTERNS:
        if pattern.search(name):
            return pattern.sub("", name, count=1)
    return name


def others(name: str) -> list[str]:
    """Return names that differ by the side."""
    names = dict.fromkeys(pattern.sub(_other, name) for pattern in PATTERNS)
    names.pop(name, None)
    return list(names)


def _other(match: re.Match) -> str:
    """Return the word for the other side, in the case of this one."""
    side = match.group()
    other = OTHER[side.lower()]
    return other.upper() if side.isupper() else other.capitalize() if side[0].isupper() else other


def _list_some(names: list[str]) -> str:
    return ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")
