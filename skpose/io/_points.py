"""Steps that the readers of points share: the axis that points up, points at the origin, names given twice."""

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from skpose._validation.options import check_choice
from skpose.io._source import Source
from skpose.io._up import Up, check_up_of_file
from skpose.keypoints._shared import complaint_of_origin, complaint_of_picture, complaint_of_up, find_lost, find_up

Zeros = Literal["seen", "missing"]
ZEROS = "zeros='missing' reads them as not seen, zeros='seen' as they are"


def check_options(up: str | None, zeros: str | None) -> None:
    """Refuse a direction or a reading of zeros that there is not."""
    check_up_of_file(up)
    if zeros is not None:
        check_choice("zeros", zeros, ("seen", "missing"))


def number_names(source: Source, names: list[str]) -> list[str]:
    """Return a different name for each point: the first of a name keeps it, the others are numbered, with a warning."""
    taken, counts, unique, repeated = set(names), dict[str, int](), list[str](), list[str]()
    seen = set[str]()
    for name in names:
        new = name
        if name in seen:
            while new in taken:
                counts[name] = counts.get(name, 1) + 1
                new = f"{name}_{counts[name]}"
            repeated.append(f"several points are named {name!r}; the next one is {new!r} here")
        seen.add(new)
        taken.add(new)
        unique.append(new)
    if repeated:
        source.warn(repeated[0] + (f", and {len(repeated) - 1} more likewise" if len(repeated) > 1 else ""))
    return unique


def drop_origin(source: Source, positions: np.ndarray, names: Sequence[str], zeros: Zeros | None) -> None:
    """Make positions (n_frames, n_points, 3) at the origin NaN where they mean a lost marker; warn where they may."""
    drop_lost(source, positions, (positions == 0.0).all(axis=2), names, zeros, "markers")


def drop_lost(
    source: Source, positions: np.ndarray, lost: np.ndarray, names: Sequence[str], zeros: Zeros | None, what: str
) -> None:
    """Make positions (n_frames, n_points, 3) NaN where they are lost (n_frames, n_points), or warn of these."""
    if zeros == "missing":
        positions[lost] = np.nan
    elif zeros is None and (complaint := complaint_of_origin(lost, names, what, ZEROS)):
        source.warn(complaint)


def stand_points(
    source: Source, positions: np.ndarray, names: Sequence[str], up: Up | None, usual: Up, why: str, what: str
) -> tuple[np.ndarray, Literal["x", "y", "z"]]:
    """Return positions in a world whose up axis does not point down, and that axis: `up`, or the usual one.

    Where an axis points down the world is turned by half a turn: about x if y or z points down, about y if x does.
    Where `up` is None and people stand along another axis than the usual one, a warning says so, and `why` that one is
    taken.
    """
    if up is None:
        up = usual
        warn_of_up(source, positions, names, usual, why, what)
    return turn_up(positions, up)


def turn_up(positions: np.ndarray, up: Up) -> tuple[np.ndarray, Literal["x", "y", "z"]]:
    """Return positions in a world that is turned by half a turn where an axis points down, and the axis that is up."""
    if up.startswith("-"):
        positions = positions * ([-1.0, 1.0, -1.0] if up == "-x" else [1.0, -1.0, -1.0])
    axis: Any = up[-1]
    return positions, axis


def warn_of_up(source: Source, positions: np.ndarray, names: Sequence[str], usual: Up, why: str, what: str) -> None:
    """Warn if people stand along another axis than the usual one."""
    found = find_up(positions, names, usual)
    if found != usual:
        state = "is upside down" if found[-1] == usual[-1] else "lies"
        remedy = f"up={found!r}, or up={usual!r} if the person {state}"
        source.warn(complaint_of_up(found, usual, why, what, remedy))


def watch_points(
    source: Source,
    positions: np.ndarray,
    confidences: np.ndarray | None,
    names: Sequence[str],
    zeros: Zeros | None,
    up: Up | None,
    usual: tuple[Up, str],
) -> np.ndarray:
    """Return positions without the lost points that are read as such; warn of what positions may be else.

    The usual axis that points up comes with the reason why it is taken.
    """
    if len(names) != positions.shape[1]:
        return positions  # they are refused
    seen = positions.copy()
    if confidences is not None:
        seen[confidences == 0.0] = np.nan
    lost = find_lost(seen)
    drop_lost(source, positions, lost, names, zeros, "points")
    if zeros != "seen":
        seen[lost] = np.nan
    if complaint := complaint_of_picture(seen, names):
        source.warn(complaint)
    elif up is None:
        warn_of_up(source, seen, names, *usual, "points")
    return positions
