"""Warnings about positions in memory: lost points at the origin, units of a picture, another axis that points up."""

from collections.abc import Sequence

import numpy as np

from skpose._warnings import warn
from skpose.keypoints._origin import complaint_of_origin, find_lost
from skpose.keypoints._pictures import complaint_of_picture
from skpose.keypoints._upright import complaint_of_up, find_up


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
