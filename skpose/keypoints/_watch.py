"""Warnings on positions in memory: lost points at the origin, units of a picture, another axis that points up."""

from collections.abc import Sequence

import numpy as np

from skpose._warnings import warn
from skpose.keypoints._origin import complaint_of_origin, find_lost
from skpose.keypoints._pictures import complaint_of_picture
from skpose.keypoints._upright import complaint_of_up, find_up

LOST = "If they are lost, make them NaN: positions[(positions == 0).all(axis=2)] = np.nan"


def warn_of_positions(positions: np.ndarray, names: Sequence[str], up: str, layout: str | None = None) -> None:
    """Warn of positions (n, points, 3), NaN where not seen, that may not be what they are taken for.

    They are those of a layout of this name, which states which axis points up, or of none.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        lost = find_lost(positions)
        seen = np.where(lost[:, :, None], np.nan, positions)
        found, picture = find_up(seen, names, up), complaint_of_picture(seen, names)
    remedy, why = f"up={found!r}", f"as the layout {layout!r} says"
    if layout is not None:
        remedy = f"dataclasses.replace(layout, {remedy})"
    else:
        why = "by up="
        if len(found) > 1:
            remedy = f"positions * {[-1, 1, -1] if found == '-x' else [1, -1, -1]} and up={found[-1]!r}"
    state = "is upside down" if found[-1] == up[-1] else "lies"
    for complaint in (
        complaint_of_origin(lost, names, "points", LOST),
        picture,
        complaint_of_up(found, up, why, "points", f"{remedy}, unless the person {state}")
        if found != up and not picture
        else "",
    ):
        if complaint:
            warn(complaint)
