"""Points at exactly (0, 0, 0): positions, or lost points, as some programs write them."""

from collections.abc import Sequence

import numpy as np

FEW = 3  # other points needed to locate the person
NEAR = 0.5  # largest distance of an origin in the person from the other points, relative to their extent


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
    shown = np.where(elsewhere[:, :, None], positions, np.nan)[elsewhere.sum(axis=1) >= FEW]
    if not len(shown):
        return True
    low, high = np.nanmin(shown, axis=1), np.nanmax(shown, axis=1)
    outside = np.maximum(np.maximum(low, -high), 0.0).max(axis=1)
    return bool(np.median(outside) <= NEAR * np.median((high - low).max(axis=1)))
