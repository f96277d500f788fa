"""Points at exactly (0, 0, 0): a position, or a point that is lost, as some programs write it."""

from collections.abc import Sequence

import numpy as np

FEW = 3  # other points, fewer of which do not show where the person is
NEAR = 0.5  # distance of the origin from the other points, relative to their extent, up to which it is in the person


def find_lost(positions: np.ndarray) -> np.ndarray:
    """Return where positions (n, points, 3), NaN where not seen, are at the origin and may be lost.

    Points that are there in every frame, amid the others, are the origin of these, such as the pelvis of positions
    relative to it. If no point is elsewhere, nothing is known of what zeros mean.
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
    """Return the warning on positions (n, points) that are at the origin; empty if there are none."""
    if not lost.any():
        return ""
    of = [names[i] for i in np.flatnonzero(lost.any(axis=0)).tolist()]
    shown = ", ".join(map(repr, of[:3])) + (f" and {len(of) - 3} more" if len(of) > 3 else "")
    share = f"{lost.mean():.2g}" if lost.mean() < 0.001 else f"{lost.mean():.1%}".replace("%", " %")
    return (
        f"{np.count_nonzero(lost)} positions ({share} of all) are exactly (0, 0, 0), of {shown}: some programs write "
        f"lost {what} so. {remedy}"
    )


def _is_amid(positions: np.ndarray, elsewhere: np.ndarray) -> bool:
    """Return whether the origin is in or near the box of the points that are elsewhere, in the median frame."""
    shown = np.where(elsewhere[:, :, None], positions, np.nan)[elsewhere.sum(axis=1) >= FEW]
    if not len(shown):
        return True
    low, high = np.nanmin(shown, axis=1), np.nanmax(shown, axis=1)
    outside = np.maximum(np.maximum(low, -high), 0.0).max(axis=1)
    return bool(np.median(outside) <= NEAR * np.median((high - low).max(axis=1)))
