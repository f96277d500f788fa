"""Keypoints of pictures, in two dimensions, that are passed as positions in three.

Distances between poses that are found from them look plausible and are wrong: a bone is short that points at the
camera. Four signs are seen in the numbers alone: every point of every frame in one plane, as with z = 0; COCO's
visibility, 0, 1 or 2, in the place of z; pixels with a score in the place of z, from 0 to 1 or in percent; pixels with
a z of another unit, by which a person is a hundredth as deep as tall. No measurement of a person has them. A mechanism
may move in one plane: few of them have as many points as a person, and none has a left and a right.

x and y of nearly all points from 0 to 1 are those of a picture of width and height 1, or of a child in a corner of the
room: a warning. So are pixels of a small person with scores in percent, which may be centimetres.
"""

from collections.abc import Sequence

import numpy as np

from skpose._validation.units import LARGEST, SMALLEST
from skpose.skeleton._shared import others

POINTS, PAIRED = 8, 6  # points that a person has at least: of any names, and with left and right among them
THICKNESS = 1e-6  # of a plane, relative to its extent
LOOKED_AT = 1024  # frames at most, evenly spaced, where they show that there is no sign
PIXELS = 10.0  # points of one person are so many metres apart at most
CENTIMETRES = 250.0  # and so many centimetres
# Extent of scores and of relative depths, and over that of pixels; T-poses of rigs are less than 2 % deep.
SHALLOW, SCORES = 0.01, 2.0
PERCENT, OVERSHOOT = 100.0, 1.1  # the highest scores of estimators
NEARLY_ALL = 0.9  # of the points of a person who is partly outside the picture
UPRIGHT = 1.5  # extent along z over that along x and y, above which people stand along z, and no picture shows them
REMEDY = (
    "Lengths of bones are not known from a picture: lift them to 3-D first, by a pose estimator that gives 3-D "
    "keypoints or by several cameras"
)


def refuse_pictures(positions: np.ndarray, names: Sequence[str], what: str) -> None:
    """Refuse positions (n, points, 3), NaN where not seen, whose numbers are those of keypoints in two dimensions."""
    step = -(-len(positions) // LOOKED_AT)
    if step > 1 and is_spatial(_find_seen(positions[::step])) and not _sign(positions[::step]):
        return  # a sign of all frames is one of some
    if _is_person(positions, names) and (sign := _sign(positions)):
        raise ValueError(f"{what} look like keypoints in two dimensions: {sign}. {REMEDY}")


def complaint_of_picture(positions: np.ndarray, names: Sequence[str]) -> str:
    """Return the warning on positions (n, points, 3), NaN where not seen, that may be in units of a picture."""
    if not _is_person(positions, names):
        return ""
    points = _find_seen(positions)
    share = ((points[:, :2] >= 0.0) & (points[:, :2] <= 1.0)).all(axis=1).mean()
    wide, deep = _extents(positions)
    # What has no left and right may be a hand, and none is as large as the smallest person.
    may_be = wide > 0.0 and (deep <= UPRIGHT * wide or deep > LARGEST)
    if share >= NEARLY_ALL and may_be and (_has_pairs(names) or wide > SMALLEST):
        scores = (points[:, 2] >= 0.0).all() and (points[:, 2] <= 1.0).all()
        return (
            f"x and y of {share:.0%} of the points are from 0 to 1".replace("%", " %")
            + (", and so are all third numbers, as scores are" if scores else "")
            + ", as in MediaPipe's pose_landmarks and MoveNet's keypoints, whose unit is the picture: distances need "
            "pose_world_landmarks, in metres, with the hips at zero"
        )
    low, high = points.min(axis=0), points.max(axis=0)
    if PIXELS < wide <= CENTIMETRES and (low >= 0.0).all() and 2.0 < high[2] <= PERCENT:
        return (
            "no number is negative, and all third numbers are up to 100, as scores in percent are: if x and y are "
            f"pixels, these are keypoints in two dimensions. {REMEDY}"
        )
    return ""


def complaint_of_flat(frames: Sequence[Sequence[Sequence[float]]]) -> str:
    """Return why the third numbers of the points (n, 3) of each frame may be no z; empty where they plainly are."""
    arrays = [np.array(frame) for frame in frames]
    seen = [points[~np.isnan(points).any(axis=1) & points.any(axis=1)] for points in arrays]
    points = np.concatenate([np.empty((0, 3)), *seen])
    if not len(points):
        return ""
    low, high = points[:, 2].min(), points[:, 2].max()
    if low >= 0.0 and high <= OVERSHOOT:
        return f"the third numbers are from {low:.3g} to {high:.3g}"
    if low >= 0.0 and high <= 2.0 and not (points[:, 2] % 1.0).any():
        return "the third numbers are 0, 1 or 2"
    extents = np.array([np.ptp(one, axis=0) for one in seen if len(one)])
    wide, deep = np.median(extents[:, :2].max(axis=1)), np.median(extents[:, 2])
    may_be_percent = low >= 0.0 and high <= PERCENT and (wide > PIXELS or (wide <= UPRIGHT and high > LARGEST))
    if may_be_percent or (wide > PIXELS and deep <= min(SHALLOW * wide, SCORES)):
        return f"points are spread over {wide:.4g} in x or y, and the third numbers are from {low:.3g} to {high:.3g}"
    return ""


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
    wide, deep = _extents(positions)
    spread = f"in a frame points are spread over {wide:.4g} in x or y, as pixels are, and"
    if wide > PIXELS and low[2] >= 0.0 and 0.0 < high[2] <= 1.0:
        return f"{spread} all third numbers are between 0 and 1, as scores are"
    if wide > CENTIMETRES and low[2] >= 0.0 and 2.0 < high[2] <= PERCENT:
        return f"{spread} all third numbers are between 0 and 100, as scores in percent are"
    if _is_flat(points):
        constant = [f"{axis} is {low[i]:.4g}" for i, axis in enumerate("xyz") if low[i] == high[i]]
        return f"all points of all frames are in one plane{', where ' + constant[0] if constant else ''}"
    if wide > PIXELS and 0.0 < deep <= min(SHALLOW * wide, SCORES):
        return f"{spread} over {deep:.3g} in z, as scores and depths in other units are"
    return ""


def _extents(positions: np.ndarray) -> tuple[float, float]:
    """Return how far points are spread in x or y, and in z, in the median frame in which two are seen."""
    seen = positions[(~np.isnan(positions[:, :, 0])).sum(axis=1) > 1]
    if not len(seen):
        return 0.0, 0.0
    extents = np.nanmax(seen, axis=1) - np.nanmin(seen, axis=1)
    return float(np.median(extents[:, :2].max(axis=1))), float(np.median(extents[:, 2]))


def _is_person(positions: np.ndarray, names: Sequence[str]) -> bool:
    """Return whether as many points are seen in any frame as a person has."""
    n_points = int(np.count_nonzero((~np.isnan(positions)).all(axis=2).any(axis=0)))
    return n_points >= POINTS or (n_points >= PAIRED and _has_pairs(names))


def _has_pairs(names: Sequence[str]) -> bool:
    """Return whether a name has a partner on the other side."""
    known = set(names)
    return any(other in known for name in names for other in others(name))
