"""Checks of positions in memory: lost points at the origin, units of a picture, another axis that points up."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from skpose.keypoints._pictures import complaint_of_picture
from skpose.skeleton._upright import HIGH, LOW

UPS = ("x", "y", "z", "-x", "-y", "-z")
FEW_OTHERS = 3  # other points needed to locate the person
NEAR = 0.5  # largest distance of an origin in the person from the other points, relative to their extent
N_FRAMES = 32  # checked, evenly spaced
NEARLY_ALL = 0.9  # of these
FLAT = 0.8  # height over the largest extent below which a person does not stand along an axis
# Names of the pelvis, the start of the trunk: it is upright in a person who sits on the floor.
MIDDLE = "hip", "pelvis", "asi", "psi", "sacr"
TRUNK = 0.25  # length of the trunk over the extent below which it is not used


def complaints_of(
    positions: np.ndarray, names: Sequence[str], up: str, why: str, remedy: str, zeros: str | None = None
) -> Iterator[str]:
    """Yield the warnings about positions (n, points, 3), NaN if not seen: lost points, a picture, another axis up.

    Lost ones become NaN if `zeros` is "missing", and are positions if it is "seen". The other arguments are those of
    `complaint_of_up`, which is left out if nothing says why.
    """
    lost = find_lost(positions)
    if zeros == "missing":
        positions[lost] = np.nan
    elif zeros is None and lost.any():
        yield complaint_of_origin(lost, names)
    seen = positions if zeros == "seen" else np.where(lost[:, :, None], np.nan, positions)
    if picture := complaint_of_picture(seen, names):
        yield picture
    elif why and (complaint := complaint_of_up(seen, names, up, why, remedy)):
        yield complaint


@np.errstate(over="ignore", invalid="ignore")
def find_lost(positions: np.ndarray) -> np.ndarray:
    """Which positions (n, points, 3), NaN if not seen, are at the origin and may be lost.

    Points at the origin in every frame, amid the others, are the origin of these, such as the pelvis in positions
    relative to it. Zeros have no meaning if no point is elsewhere.
    """
    at_origin = (positions == 0.0).all(axis=2)
    seen = ~np.isnan(positions).any(axis=2)
    elsewhere = seen & ~at_origin
    if not elsewhere.any():
        return np.zeros_like(at_origin)
    always = at_origin.any(axis=0) & (at_origin | ~seen).all(axis=0)
    if always.any() and _is_amid(positions[:, ~always], elsewhere[:, ~always]):
        # In frames of zeros alone they are lost with the others.
        nobody = ~elsewhere.any(axis=1) & at_origin[:, ~always].any(axis=1)
        at_origin[:, always] &= nobody[:, None]
    return at_origin


def complaint_of_origin(lost: np.ndarray, names: Sequence[str]) -> str:
    """The warning about some positions (n, points) at the origin."""
    return (
        f"{np.count_nonzero(lost)} positions are exactly (0, 0, 0), such as of "
        f"{names[int(lost.any(axis=0).argmax())]!r}: if points are lost, make them NaN, or read files with "
        "zeros='missing', otherwise with zeros='seen'"
    )


def _is_amid(positions: np.ndarray, elsewhere: np.ndarray) -> bool:
    """Whether the origin is in or near the box of the points that are elsewhere, in the median frame."""
    shown = np.where(elsewhere[:, :, None], positions, np.nan)[elsewhere.sum(axis=1) >= FEW_OTHERS]
    if not len(shown):
        return True
    low, high = np.nanmin(shown, axis=1), np.nanmax(shown, axis=1)
    outside = np.maximum(np.maximum(low, -high), 0.0).max(axis=1)
    return bool(np.median(outside) <= NEAR * np.median((high - low).max(axis=1)))


def complaint_of_up(positions: np.ndarray, names: Sequence[str], up: str, why: str, remedy: str) -> str:
    """The warning about points that stand along another axis than `up`; empty if they do not.

    `why` says why that is taken, and `remedy` takes the axis that is found.
    """
    found = find_up(positions, names, up)
    if found == up:
        return ""
    return (
        f"{up} is taken as the axis that points up, {why}, but points stand along {found[-1]}"
        f"{', head down,' if len(found) > 1 else ''} in nearly all frames: "
        f"pass {remedy.format(repr(found))}, unless the person lies or is upside down"
    )


@np.errstate(over="ignore", invalid="ignore")
def find_up(positions: np.ndarray, names: Sequence[str], usual: str) -> str:
    """The direction from feet to head in nearly all frames; the usual one if there is none."""
    lower = [name.lower() for name in names]
    frames = positions[:: max(1, len(positions) // N_FRAMES)]
    top, middle, bottom = (
        _mean_of_seen(frames[:, [i for i, name in enumerate(lower) if any(part in name for part in parts)]])
        for parts in (HIGH, MIDDLE, LOW)
    )
    is_seen = ~np.isnan(top - bottom).any(axis=1)
    heights, trunks = (top - bottom)[is_seen], (top - middle)[is_seen]
    extent, length = (np.abs(vectors).max(axis=1, initial=0.0) for vectors in (heights, trunks))
    if not extent.any():
        return usual
    no_trunk = ~(length > TRUNK * extent)
    level = (extent > 0.0) & (_along(heights, usual) < FLAT * extent)
    for up in UPS:
        stands = level & (_along(heights, up) == extent) & (no_trunk | (_along(trunks, up) == length))
        if stands.mean() >= NEARLY_ALL:
            return up
    return usual


def _along(vectors: np.ndarray, direction: str) -> np.ndarray:
    return vectors[:, "xyz".index(direction[-1])] * (-1.0 if direction.startswith("-") else 1.0)


def turn_up(positions: np.ndarray, up: str) -> tuple[np.ndarray, Any]:
    """Positions (..., 3) in a world in which no axis points down, and the axis that points up.

    If one does, the world is turned by half a turn: about x for y and z, about y for x.
    """
    if up.startswith("-"):
        positions = positions * ([-1.0, 1.0, -1.0] if up == "-x" else [1.0, -1.0, -1.0])
    return positions, up[-1]


def _mean_of_seen(positions: np.ndarray) -> np.ndarray:
    """The mean position (n_frames, 3) of the seen points, NaN if none is seen."""
    seen = ~np.isnan(positions).any(axis=2)
    sums = np.where(seen[:, :, None], positions, 0.0).sum(axis=1)
    n_seen = seen.sum(axis=1)[:, None]
    return np.where(n_seen, sums / np.maximum(n_seen, 1), np.nan)
