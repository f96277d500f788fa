"""Keypoints of pictures, in two dimensions, that are passed as positions in three.

Distances between poses that are found from them look plausible and are wrong: a bone is short that points at the
camera. Three signs are seen in the numbers alone: every point of every frame in one plane, as with z = 0; COCO's
visibility, 0, 1 or 2, in the place of z; pixels with a score from 0 to 1 in the place of z. No measurement of a person
has them. A mechanism may move in one plane: few of them have as many points as a person, and none has a left and a
right.
"""

from collections.abc import Sequence

import numpy as np

from skpose._warnings import warn
from skpose.skeleton._shared import others

POINTS, PAIRED = 8, 6  # points that a person has at least: of any names, and with left and right among them
THICKNESS = 1e-6  # of a plane, relative to its extent
LOOKED_AT = 1024  # frames at most, evenly spaced, where they show that there is no sign
PIXELS = 10.0  # points of one person are so many metres apart at most
REMEDY = (
    "Lengths of bones are not known from a picture: lift them to 3-D first, by a pose estimator that gives 3-D "
    "keypoints or by several cameras"
)


def refuse_pictures(positions: np.ndarray, names: Sequence[str], what: str) -> None:
    """Refuse positions (n, points, 3), NaN where not seen, whose numbers are those of keypoints in two dimensions."""
    step = -(-len(positions) // LOOKED_AT)
    if step > 1 and is_spatial(_find_seen(positions[::step])) and not _sign(positions[::step]):
        return  # a sign of all frames is one of some
    n_points = np.count_nonzero((~np.isnan(positions)).all(axis=2).any(axis=0))
    if n_points < PAIRED or (n_points < POINTS and not _has_pairs(names)):
        return
    if sign := _sign(positions):
        raise ValueError(f"{what} look like keypoints in two dimensions: {sign}. {REMEDY}")


def warn_of_landmarks(positions: np.ndarray) -> None:
    """Warn if x and y of MediaPipe's landmarks (n, points, 3) are within a picture of width and height 1."""
    seen = _find_seen(positions)[:, :2]
    if len(seen) and 0.0 <= seen.min() < seen.max() <= 1.0:
        warn(
            "x and y of all landmarks are from 0 to 1, as in MediaPipe's pose_landmarks, whose unit is the picture: "
            "distances need pose_world_landmarks, in metres, with the hips at zero"
        )


def is_spatial(points: np.ndarray) -> bool:
    """Return whether points (n, 3) are not in one plane; False for none."""
    if not len(points):
        return False
    least, _, most = _spread(points)
    return bool(least > THICKNESS**2 * most)


def _is_flat(points: np.ndarray) -> bool:
    """Return whether points (n, 3) are in one plane, but not on one line or in one place."""
    least, middle, most = _spread(points)
    return bool(least <= THICKNESS**2 * most and middle > THICKNESS * most)


def _spread(points: np.ndarray) -> np.ndarray:
    """Return the squares (3,) of the extents along the principal axes, the least first, in any unit."""
    scaled = points / max(float(np.abs(points).max()), 1e-300)  # squares of large numbers are infinite
    centred = scaled - scaled.mean(axis=0)
    return np.linalg.eigvalsh(centred.T @ centred)


def _find_seen(positions: np.ndarray) -> np.ndarray:
    """Return the points (n, 3) that are seen in any frame."""
    return positions[~np.isnan(positions).any(axis=2)]


def _sign(positions: np.ndarray) -> str:
    """Return in words what shows that positions, of which some are seen, are in two dimensions; nothing if not."""
    points = _find_seen(positions)
    low, high = points.min(axis=0), points.max(axis=0)
    others_are_flags = high.max() <= 2.0 and not (points % 1.0).any()
    if 0.0 <= low[2] < high[2] <= 2.0 and not (points[:, 2] % 1.0).any() and not others_are_flags:
        return "all third numbers are 0, 1 or 2, as COCO says whether a point is visible"
    if low[2] >= 0.0 and 0.0 < high[2] <= 1.0 and _extent(positions) > PIXELS:
        return (
            f"in a frame points are spread over {_extent(positions):.4g} in x or y, as pixels are, and all third "
            "numbers are between 0 and 1, as scores are"
        )
    if _is_flat(points):
        constant = [f"{axis} is {low[i]:.4g}" for i, axis in enumerate("xyz") if low[i] == high[i]]
        return f"all points of all frames are in one plane{', where ' + constant[0] if constant else ''}"
    return ""


def _extent(positions: np.ndarray) -> float:
    """Return how far points are spread in x or y, in the median frame in which two are seen."""
    seen = positions[(~np.isnan(positions[:, :, 0])).sum(axis=1) > 1][:, :, :2]
    if not len(seen):
        return 0.0
    return float(np.median((np.nanmax(seen, axis=1) - np.nanmin(seen, axis=1)).max(axis=1)))


def _has_pairs(names: Sequence[str]) -> bool:
    """Return whether a name has a partner on the other side."""
    known = set(names)
    return any(other in known for name in names for other in others(name))
