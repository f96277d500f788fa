"""Checks of positions in memory: lost points at the origin, units of a picture, another axis that points up."""

from collections.abc import Sequence

import numpy as np

from skpose._utils.warnings import warn
from skpose.keypoints._pictures import complaint_of_picture
from skpose.skeleton._upright import HIGH, LOW

FEW_OTHERS = 3  # other points needed to locate the person
NEAR = 0.5  # largest distance of an origin in the person from the other points, relative to their extent
N_FRAMES = 32  # checked, evenly spaced
NEARLY_ALL = 0.9  # of these
FLAT = 0.8  # height over the largest extent below which a person does not stand along an axis
# Names of the pelvis, the start of the trunk: it is upright in a person who sits on the floor.
MIDDLE = "hip", "pelvis", "asi", "psi", "sacr"
TRUNK = 0.25  # length of the trunk over the extent below which it is not used


def warn_of_positions(positions: np.ndarray, names: Sequence[str], up: str, layout: str | None = None) -> None:
    """Warn about positions (n, points, 3), NaN if not seen, of a layout by name or of none."""
    with np.errstate(over="ignore", invalid="ignore"):
        lost = find_lost(positions)
        seen = np.where(lost[:, :, None], np.nan, positions)
        found, picture = find_up(seen, names, up), complaint_of_picture(seen, names)
    if lost_words := complaint_of_origin(lost, names, "points", "Make them NaN"):
        warn(lost_words)
    if picture:
        warn(picture)
    elif found != up:
        remedy = f"dataclasses.replace(layout, up={found!r})" if layout is not None else f"up={found!r}"
        if layout is None and len(found) > 1:
            remedy = f"positions * {[-1, 1, -1] if found == '-x' else [1, -1, -1]} and up={found[-1]!r}"
        why = "by up=" if layout is None else f"as the layout {layout!r} says"
        warn(complaint_of_up(found, up, why, "points", f"{remedy}, unless the person lies or is upside down"))


def find_lost(positions: np.ndarray) -> np.ndarray:
    """Which positions (n, points, 3), NaN if not seen, are at the origin and may be lost.

    Points at the origin in every frame, amid the others, are the origin of these, such as the pelvis in positions
    relative to it. Zeros have no meaning if no point is elsewhere.
    """
    at_origin = (positions == 0.0).all(axis=2)
    if not at_origin.any():
        return at_origin
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


def complaint_of_origin(lost: np.ndarray, names: Sequence[str], what: str, remedy: str) -> str:
    """The warning about positions (n, points) at the origin; empty if there are none."""
    if not lost.any():
        return ""
    name = names[int(lost.any(axis=0).argmax())]
    return f"{np.count_nonzero(lost)} positions are exactly (0, 0, 0), such as of {name!r}: lost {what}? {remedy}"


def _is_amid(positions: np.ndarray, elsewhere: np.ndarray) -> bool:
    """Whether the origin is in or near the box of the points that are elsewhere, in the median frame."""
    shown = np.where(elsewhere[:, :, None], positions, np.nan)[elsewhere.sum(axis=1) >= FEW_OTHERS]
    if not len(shown):
        return True
    low, high = np.nanmin(shown, axis=1), np.nanmax(shown, axis=1)
    outside = np.maximum(np.maximum(low, -high), 0.0).max(axis=1)
    return bool(np.median(outside) <= NEAR * np.median((high - low).max(axis=1)))


def find_up(positions: np.ndarray, names: Sequence[str], usual: str) -> str:
    """The direction from feet to head in nearly all frames; the usual one if there is none."""
    lower = [name.lower() for name in names]
    frames = positions[:: max(1, len(positions) // N_FRAMES)]
    top, middle, bottom = (
        _mean_of_seen(frames[:, [i for i, name in enumerate(lower) if any(part in name for part in parts)]])
        for parts in (HIGH, MIDDLE, LOW)
    )
    heights, trunks = top - bottom, top - middle
    is_seen = ~np.isnan(heights).any(axis=1)
    heights, trunks = heights[is_seen], trunks[is_seen]
    extent = np.abs(heights).max(axis=1, initial=0.0)
    length = np.abs(trunks).max(axis=1, initial=0.0)
    no_trunk = ~(length > TRUNK * extent)
    if not extent.any():
        return usual
    level = heights[:, "xyz".index(usual[-1])] * (-1.0 if usual.startswith("-") else 1.0) < FLAT * extent
    for i, axis in enumerate("xyz"):
        for sign, direction in ((1.0, axis), (-1.0, f"-{axis}")):
            stands = (sign * heights[:, i] == extent) & (extent > 0.0) & level
            stands &= no_trunk | (sign * trunks[:, i] == length)
            if direction != usual and stands.mean() >= NEARLY_ALL:
                return direction
    return usual


def complaint_of_up(found: str, usual: str, why: str, points: str, remedy: str) -> str:
    """The warning about points that stand along another axis than the one taken as up, and why it is."""
    stand = f"{points} stand along {found[-1]}{', head down' if len(found) > 1 else ''}"
    return f"{usual} is taken as the axis that points up, {why}, but {stand} in nearly all frames: pass {remedy}"


def _mean_of_seen(positions: np.ndarray) -> np.ndarray:
    """The mean position (n_frames, 3) of the seen points, NaN if none is seen."""
    seen = ~np.isnan(positions).any(axis=2)
    sums = np.where(seen[:, :, None], positions, 0.0).sum(axis=1)
    n_seen = seen.sum(axis=1)[:, None]
    return np.where(n_seen, sums / np.maximum(n_seen, 1), np.nan)
