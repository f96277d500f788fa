"""Hip joint centres by regression from markers of the pelvis, where no recording of movements shows them."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

HARRINGTON, DAVIS = RULES = "harrington", "davis"
BETA, THETA = np.radians(18.0), np.radians(28.4)  # Davis: angles of the hip in the sagittal and the frontal plane
RADIUS = 0.007  # m, of a marker


def hip_center(rule: str, side: str, markers: Sequence[np.ndarray]) -> np.ndarray:
    """The centre (n, 3) of a hip, m.

    Markers (n, 3) are the ASIS and the other side's, the PSIS and the other side's, and for Davis those of knee and
    ankle, up to which the leg is measured from the ASIS. Axes are ahead, up and outward from the middle of the ASIS.
    """
    asis, other, psis, other_psis, *leg = markers
    origin = (asis + other) / 2.0
    ahead, outward = origin - (psis + other_psis) / 2.0, asis - other
    depth, width = (np.linalg.norm(line, axis=1, keepdims=True) for line in (ahead, outward))
    outward = outward / width
    ahead = ahead - (ahead * outward).sum(axis=1, keepdims=True) * outward
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    up = np.cross(ahead, outward) if side == "left" else np.cross(outward, ahead)
    place = -0.24 * depth - 0.0099, -0.30 * width - 0.0109, 0.33 * width + 0.0073
    if rule == DAVIS:
        lengths = sum(np.linalg.norm(b - a, axis=1) for a, b in pairwise([asis, *leg]))
        length = np.ma.median(np.ma.masked_invalid(lengths))
        c, trochanter = 0.115 * length - 0.0153, 0.1288 * length - 0.04856 + RADIUS
        place = (
            c * np.cos(THETA) * np.sin(BETA) - trochanter * np.cos(BETA),
            -c * np.cos(THETA) * np.cos(BETA) - trochanter * np.sin(BETA),
            width / 2.0 - c * np.sin(THETA),
        )
    return np.ma.filled(origin + place[0] * ahead + place[1] * up + place[2] * outward, np.nan)
