"""Keypoints in two dimensions that are passed as positions in three.

Distances between poses found from them look plausible and are wrong: a bone that points at the camera is short. Four
signs are refused: all points of all frames in one plane, as with z = 0; COCO's visibility, 0, 1 or 2, instead of z;
pixels with a score instead of z, from 0 to 1 or in percent; pixels with a depth in another unit, so that a person is a
hundredth as deep as tall. No measurement of a person has them. A mechanism may move in one plane, but few have as many
points as a person, and none has left and right.

If x and y of nearly all points are from 0 to 1, they may be relative to the size of a picture, or a child in a corner
of the room: this gives a warning. So do pixels of a small person with scores in percent, which may be centimetres.
"""

from collections.abc import Sequence

import numpy as np

from skpose._utils.units import LARGEST, SMALLEST
from skpose.skeleton._sides import others

POINTS, PAIRED = 8, 6  # points that a person has at least: of any names, and with left and right among them
THICKNESS = 1e-6  # of a plane, relative to its extent
LOOKED_AT = 1024  # frames at most, evenly spaced, for a first look
PIXELS = 10.0  # points of one person are so many metres apart at most
CENTIMETRES = 250.0  # and so many centimetres
# Extent of scores and relative depths, and its ratio to the extent of pixels; T-poses of rigs are less than 2 % deep.
SHALLOW, SCORES = 0.01, 2.0
PERCENT = 100.0  # the highest score of some estimators
NEARLY_ALL = 0.9  # of the points of a person who is partly outside the picture
UPRIGHT = 1.5  # extent along z over x and y; with more, people stand along z, unlike in pictures
REMEDY = "Lift keypoints to 3-D first: a picture does not show lengths of bones"


def refuse_pictures(positions: np.ndarray, names: Sequence[str], what: str) -> None:
    """Refuse positions (n, points, 3), NaN if not seen, that are keypoints in two dimensions."""
    step = -(-len(positions) // LOOKED_AT)
    if step > 1 and is_spatial(_find_seen(positions[::step])) and not _sign(positions[::step]):
        return  # a sign in all frames is one in some
    if _is_person(positions, names) and (sign := _sign(positions)):
        raise ValueError(f"{what} look like keypoints in two dimensions, {sign}: lift them to 3-D first")


@np.errstate(over="ignore", invalid="ignore")
def complaint_of_picture(positions: np.ndarray, names: Sequence[str]) -> str:
    """The warning about positions (n, points, 3), NaN if not seen, that may be in units of a picture."""
    if not _is_person(positions, names):
        return ""
    points = _find_seen(positions)
    share = ((points[:, :2] >= 0.0) & (points[:, :2] <= 1.0)).all(axis=1).mean()
    wide, deep = _extents(positions)
    # Without left and right it may be a hand, which is smaller than the smallest person.
    may_be = wide > 0.0 and (deep <= UPRIGHT * wide or deep > LARGEST)
    if share >= NEARLY_ALL and may_be and (_has_pairs(names) or wide > SMALLEST):
        return (
            "x and y are from 0 to 1, as in units of a picture: use world coordinates (pose_world_landmarks), in metres"
        )
    low, high = points.min(axis=0), points.max(axis=0)
    if PIXELS < wide <= CENTIMETRES and (low >= 0.0).all() and 2.0 < high[2] <= PERCENT:
        return "x and y may be pixels and the third numbers scores in percent, which are not positions"
    return ""


def is_spatial(points: np.ndarray) -> bool:
    """Whether points (n, 3) are not in one plane; False without points."""
    if not len(points):
        return False
    least, _, most = _spread(points)
    return bool(least > THICKNESS**2 * most)


def _spread(points: np.ndarray) -> np.ndarray:
    """The squares (3,) of the extents along the principal axes, the least first, in any unit."""
    scaled = points / max(float(np.abs(points).max()), 1e-300)  # squares of large numbers are infinite
    centred = scaled - scaled.mean(axis=0)
    return np.linalg.eigvalsh(centred.T @ centred)


def _find_seen(positions: np.ndarray) -> np.ndarray:
    """The points (n, 3) that are seen in any frame."""
    return positions[~np.isnan(positions).any(axis=2)]


def _sign(positions: np.ndarray) -> str:
    """The sign that positions are in two dimensions; empty if there is none."""
    points = _find_seen(positions)
    low, high = points.min(axis=0), points.max(axis=0)
    others_are_flags = high.max() <= 2.0 and not (points % 1.0).any()
    if 0.0 <= low[2] < high[2] <= 2.0 and not (points[:, 2] % 1.0).any() and not others_are_flags:
        return "with COCO's visibility as third number"
    wide, deep = _extents(positions)
    if low[2] >= 0.0 and (
        (wide > PIXELS and 0.0 < high[2] <= 1.0) or (wide > CENTIMETRES and 2.0 < high[2] <= PERCENT)
    ):
        return "in pixels with a score as third number"
    least, middle, most = _spread(points)
    if least <= THICKNESS**2 * most and middle > THICKNESS * most:
        return "with all points of all frames in one plane"
    if wide > PIXELS and 0.0 < deep <= min(SHALLOW * wide, SCORES):
        return "in pixels with depths in another unit"
    return ""


def _extents(positions: np.ndarray) -> tuple[float, float]:
    """The extents in x or y, and in z, in the median frame with two points."""
    seen = positions[(~np.isnan(positions[:, :, 0])).sum(axis=1) > 1]
    if not len(seen):
        return 0.0, 0.0
    extents = np.nanmax(seen, axis=1) - np.nanmin(seen, axis=1)
    return float(np.median(extents[:, :2].max(axis=1))), float(np.median(extents[:, 2]))


def _is_person(positions: np.ndarray, names: Sequence[str]) -> bool:
    """Whether a person's number of points is seen in any frame."""
    n_points = int(np.count_nonzero((~np.isnan(positions)).all(axis=2).any(axis=0)))
    return n_points >= POINTS or (n_points >= PAIRED and _has_pairs(names))


def _has_pairs(names: Sequence[str]) -> bool:
    """Whether a name has a partner on the other side."""
    known = set(names)
    return any(other in known for name in names for other in others(name))
