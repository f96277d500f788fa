"""Steps that the readers of markers share: the axis that points up, markers at the origin, names given twice."""

from typing import Any, Literal

import numpy as np

from skpose._validation.options import check_choice
from skpose.io._source import Source
from skpose.io._up import Up, check_up_of_file

Zeros = Literal["seen", "missing"]

N_FRAMES = 32  # that are looked at for the axis that points up, evenly spaced
NEARLY_ALL = 0.9  # of these
FLAT = 0.8  # height over the largest extent below which a person does not stand along an axis
# Parts of the names of markers on the head, the neck and the shoulders, and of those on ankles and feet.
HIGH = "head", "hd", "nose", "neck", "c7", "clav", "acr", "shoulder"
LOW = "foot", "toe", "heel", "hee", "ank", "mal", "cal"


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


def drop_origin(source: Source, positions: np.ndarray, names: list[str], zeros: Zeros | None) -> None:
    """Make positions (n_frames, n_points, 3) at the origin NaN where they mean a lost marker; warn where they may."""
    if zeros == "seen":
        return
    at_origin = (positions == 0.0).all(axis=2)
    if not at_origin.any():
        return
    if zeros == "missing":
        positions[at_origin] = np.nan
        return
    of = [name for name, some in zip(names, at_origin.any(axis=0), strict=True) if some]
    shown = ", ".join(map(repr, of[:3])) + (f" and {len(of) - 3} more" if len(of) > 3 else "")
    share = f"{at_origin.mean():.2g}" if at_origin.mean() < 0.001 else f"{at_origin.mean():.1%}".replace("%", " %")
    source.warn(
        f"{np.count_nonzero(at_origin)} positions ({share} of all) are exactly (0, 0, 0), of {shown}: some programs "
        "write lost markers so. zeros='missing' reads them as not seen, zeros='seen' as they are"
    )


def stand_points(
    source: Source, positions: np.ndarray, names: list[str], up: Up | None, usual: Up, why: str
) -> tuple[np.ndarray, Literal["x", "y", "z"]]:
    """Return positions in a world whose up axis does not point down, and that axis: `up`, or the usual one.

    Where an axis points down the world is turned by half a turn: about x if y or z points down, about y if x does.
    Where `up` is None and people stand along another axis than the usual one, a warning says so, and `why` that one is
    taken.
    """
    if up is None:
        up, found = usual, _find_up(positions, names, usual)
        if found != usual:
            source.warn(
                f"{usual} is taken as the axis that points up, {why}, but in nearly all frames the markers stand along "
                f"{found[-1]}{', head down' if len(found) > 1 else ''}: pass up={found!r}, or up={usual!r} if the "
                "person lies"
            )
    if up.startswith("-"):
        positions = positions * ([-1.0, 1.0, -1.0] if up == "-x" else [1.0, -1.0, -1.0])
    axis: Any = up[-1]
    return positions, axis


def _find_up(positions: np.ndarray, names: list[str], usual: Up) -> str:
    """Return the direction from feet to head in nearly all frames; the usual one where there is none."""
    lower = [name.lower() for name in names]
    high, low = ([i for i, name in enumerate(lower) if any(part in name for part in parts)] for parts in (HIGH, LOW))
    ends = (_mean_of_seen(positions[:: max(1, len(positions) // N_FRAMES)][:, chosen]) for chosen in (high, low))
    top, bottom = ends
    heights = top - bottom
    heights = heights[~np.isnan(heights).any(axis=1)]
    extent = np.abs(heights).max(axis=1, initial=0.0)
    if not extent.any():
        return usual
    level = heights[:, "xyz".index(usual[-1])] * (-1.0 if usual.startswith("-") else 1.0) < FLAT * extent
    for i, axis in enumerate("xyz"):
        for sign, direction in ((1.0, axis), (-1.0, f"-{axis}")):
            stands = (sign * heights[:, i] == extent) & (extent > 0.0) & level
            if direction != usual and stands.mean() >= NEARLY_ALL:
                return direction
    return usual


def _mean_of_seen(positions: np.ndarray) -> np.ndarray:
    """Return the mean position (n_frames, 3) of the points that are seen, NaN where none is."""
    seen = ~np.isnan(positions).any(axis=2)
    sums = np.where(seen[:, :, None], positions, 0.0).sum(axis=1)
    n_seen = seen.sum(axis=1)[:, None]
    return np.where(n_seen, sums / np.maximum(n_seen, 1), np.nan)
