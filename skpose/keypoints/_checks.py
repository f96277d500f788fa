"""Checks of positions in memory: lost points at the origin, units of a picture, the axis that points up.

Up is along the floor's normal if the points show a floor: points that stand still while others move are in one plane,
and all others above it. In 235 motions of CMU and HDM05 188 show a floor, always the true one. Otherwise names show up,
as heads are above feet, and without known names the axis along which a person is tallest.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from skpose._utils.units import LARGEST, SMALLEST
from skpose.skeleton._sides import others
from skpose.skeleton._upright import HIGH, LOW

POINTS, PAIRED = 8, 6  # points that a person has at least: of any names, and with left and right among them
THICKNESS = 1e-6  # of a plane, relative to its extent
LOOKED_AT = 1024  # frames at most, evenly spaced, for a first look
PIXELS = 10.0  # points of one person are so many metres apart at most
CENTIMETRES = 250.0  # and so many centimetres
# Extent of scores and relative depths, and its ratio to the extent of pixels; T-poses of rigs are less than 2 % deep.
SHALLOW, SCORES = 0.01, 2.0
PERCENT = 100.0  # the highest score of some estimators
MOST_POINTS = 0.9  # of the points of a person who is partly outside the picture
UPRIGHT = 1.5  # extent along z over x and y; with more, people stand along z, unlike in pictures
REMEDY = "Lift keypoints to 3-D first: a picture does not show lengths of bones"


def refuse_pictures(positions: np.ndarray, names: Sequence[str], what: str) -> None:
    """Refuse positions (n, points, 3), NaN if not seen, that are keypoints in two dimensions."""
    few = positions[:: max(1, len(positions) // LOOKED_AT)]  # a sign in all frames is one in some
    if _is_person(few, names) and _sign(few) and (sign := _sign(positions)):
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
    if share >= MOST_POINTS and may_be and (_has_pairs(names) or wide > SMALLEST):
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


# --- checks -----------------------------------------------------------------------------------------------------------


UPS = ("x", "y", "z", "-x", "-y", "-z")
FEW_OTHERS = 3  # other points needed to locate the person
NEAR = 0.5  # largest distance of an origin in the person from the other points, relative to their extent
N_FRAMES = 32  # checked, evenly spaced
NEARLY_ALL = 0.9  # of these
FLAT = 0.8  # height over the largest extent below which a person does not stand along an axis
# Names of the pelvis, the start of the trunk: it is upright in a person who sits on the floor.
MIDDLE = "hip", "pelvis", "asi", "psi", "sacr"
TRUNK = 0.25  # length of the trunk over the extent below which it is not used
FEW, SHORTEST, TALLEST = 6, 0.8, 2.4  # points, and m: extents of people, of whom a file may have the legs alone
N_PAIRS = 256  # of frames that show which points stand still, evenly spaced
MOVES, STILL = 0.02, 0.15  # of the extent, that points move between frames; and of the median point, one that is still
FEWEST, SHARE = 20, 0.2  # still points in all, and share of the frames with one
# Of the extent: thickness of the floor, its width, height of the median point above it, and depth of a few below.
THICK, WIDE, ABOVE, BELOW = 0.15, 0.1, 0.15, 0.1


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


def settle_up(positions: np.ndarray, names: Sequence[str], up: Any, why: str) -> tuple[Any, str]:
    """The direction that points up in the points of a file, m, and a warning if that is not sure.

    It is `up`, for the reason `why`, unless the points show a floor.
    """
    found, by_floor = find_up(positions, names, up)
    if not by_floor or found == up:
        return up, complaint_of_up(positions, names, up, why, "up={}")
    return found, f"{found} is taken as up, by the floor that points stand on, not {up}, {why}: up={up!r} keeps that"


def complaint_of_up(positions: np.ndarray, names: Sequence[str], up: str, why: str, remedy: str) -> str:
    """The warning about points, m, that stand along another axis than `up`; empty if they do not.

    `why` says why that is taken, and `remedy` takes the axis that is found.
    """
    found, _ = find_up(positions, names, up)
    if found == up:
        return ""
    return (
        f"{up} is taken as the axis that points up, {why}, but points stand along {found[-1]}"
        f"{', head down,' if len(found) > 1 else ''} in nearly all frames: "
        f"pass {remedy.format(repr(found))}, unless the person lies or is upside down"
    )


@np.errstate(over="ignore", invalid="ignore")
def find_up(positions: np.ndarray, names: Sequence[str], usual: str) -> tuple[str, bool]:
    """The direction that points up, the usual one if nothing shows another, and whether a floor shows it."""
    lost = (positions == 0.0).all(axis=2) | np.isnan(positions).any(axis=2)
    positions = np.where(lost[:, :, None], np.nan, positions)
    frames = positions[(~np.isnan(positions[:, :, 0])).sum(axis=1) > 1]
    extents = np.nanmax(frames, axis=1) - np.nanmin(frames, axis=1) if len(frames) else np.zeros((1, 3))
    tallest = extents.max(axis=1)
    has_size = len(names) >= FEW and SHORTEST <= np.median(tallest) <= TALLEST
    floor = _find_floor(frames, np.median(extents, axis=0)) if has_size else ""
    few = positions[:: max(1, len(positions) // N_FRAMES)]
    top, middle, bottom = (
        np.ma.masked_invalid(few[:, [any(part in name.lower() for part in parts) for name in names]])
        .mean(axis=1)
        .filled(np.nan)
        for parts in (HIGH, MIDDLE, LOW)
    )
    is_seen = ~np.isnan(top - bottom).any(axis=1)
    if floor and (_along(top - bottom, floor) <= 0.0).mean() < 1.0 - NEARLY_ALL:  # unless names contradict it
        return floor, True
    if is_seen.any():
        return _find_by_names((top - bottom)[is_seen], (top - middle)[is_seen], usual), False
    if has_size and usual.startswith("-") and not (_along(frames, usual) >= 0.0).any():
        return usual[-1], True  # all points of all frames are below the floor
    level = extents[:, "xyz".index(usual[-1])] < FLAT * tallest
    for i, axis in enumerate("xyz"):
        if has_size and (level & (extents[:, i] == tallest)).mean() >= NEARLY_ALL:
            return axis if (frames[:, :, i] > 0.0).any() else f"-{axis}", False
    return usual, False


def _find_floor(frames: np.ndarray, extents: np.ndarray) -> str:
    """The direction that points up from the floor; empty if points that stand still while others move show none.

    `extents` (3,) is the size in the median frame. A person who sits keeps the back still, and is taller than deep.
    """
    lag, size = 1, extents.max()
    while lag < len(frames):
        starts = np.arange(0, len(frames) - lag, 1 + (len(frames) - lag) // N_PAIRS)
        steps = np.linalg.norm(frames[starts + lag] - frames[starts], axis=2)
        usual = np.array([np.median(step[~np.isnan(step)]) if np.isfinite(step).sum() > 1 else 0.0 for step in steps])
        if np.percentile(usual, 75.0) > MOVES * size:
            break
        lag *= 2
    else:
        return ""
    moving = (usual[:, None] > MOVES * size / 4.0) & ~np.isnan(steps)
    still = moving & (steps < STILL * usual[:, None])
    if still.sum() < FEWEST or still.any(axis=1).sum() <= SHARE * moving.any(axis=1).sum():
        return ""
    floor, others = frames[starts][still], frames[starts][moving & ~still]
    low, high = np.percentile(floor, [10.0, 90.0], axis=0)
    least, middle, most = np.percentile(others, [2.0, 50.0, 98.0], axis=0)
    found = []
    for i, axis in enumerate("xyz"):
        if extents[i] > FLAT * size and high[i] - low[i] < THICK * size and (high - low).max() > WIDE * size:
            if middle[i] - high[i] > ABOVE * size and low[i] - least[i] < BELOW * size:
                found.append(axis)
            if low[i] - middle[i] > ABOVE * size and most[i] - high[i] < BELOW * size:
                found.append(f"-{axis}")
    return found[0] if len(found) == 1 else ""


def _find_by_names(heights: np.ndarray, trunks: np.ndarray, usual: str) -> str:
    """The direction from feet to head, and along the trunk, of nearly all frames; the usual one if there is none."""
    extent, length = (np.abs(vectors).max(axis=1, initial=0.0) for vectors in (heights, trunks))
    no_trunk = ~(length > TRUNK * extent)
    level = (extent > 0.0) & (_along(heights, usual) < FLAT * extent)
    for up in UPS:
        stands = level & (_along(heights, up) == extent) & (no_trunk | (_along(trunks, up) == length))
        if stands.mean() >= NEARLY_ALL:
            return up
    return usual


def _along(vectors: np.ndarray, direction: str) -> np.ndarray:
    return vectors[..., "xyz".index(direction[-1])] * (-1.0 if direction.startswith("-") else 1.0)


def turn_up(positions: np.ndarray, up: str) -> tuple[np.ndarray, Any]:
    """Positions (..., 3) in a world in which no axis points down, and the axis that points up.

    If one does, the world is turned by half a turn: about x for y and z, about y for x.
    """
    if up.startswith("-"):
        positions = positions * ([-1.0, 1.0, -1.0] if up == "-x" else [1.0, -1.0, -1.0])
    return positions, up[-1]
