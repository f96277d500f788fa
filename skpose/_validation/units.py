"""Signs that numbers have another unit than is expected: degrees for radians, centimetres for metres.

Distances between such poses look plausible and are wrong, so that a warning names the sign and the remedy.

Angles are watched where a skeleton is known: "angle" without one is the same distance in any unit. In a recording of
people no more than 7 % of the columns go beyond three turns, continuous in time or not (188 recordings of HDM05, the
farthest column at 32 rad, and 47 of CMU); in degrees at least 29 % do, and 21 % in 3 s of generated gait.

Sizes are watched where a file states the unit, or has none. A skeleton that is built by hand has the unit that its
author chose, and may be a robot's arm: it is not watched.
"""

import numpy as np

from skpose._validation.skeletons import SkeletonLike
from skpose._warnings import is_called_by_user, warn

TWO_PI = 2.0 * np.pi
FAR = 3.0 * TWO_PI  # rad
SHARE = 0.15  # of the columns that go so far
LOOKED_AT = 4096  # poses at most, evenly spaced: a unit is that of all, and forward kinematics takes 0.5 µs a pose
SMALLEST, LARGEST = 0.3, 5.0  # m between the ends of a skeleton: a doll, a horse with its rider
HUMAN = 1.7  # m, to choose among units
UNITS = {"metres": 1.0, "centimetres": 0.01, "millimetres": 0.001, "inches": 0.0254, "units of CMU": 0.0254 / 0.45}


def warn_of_degrees(
    remedy: str | None = None,
    skeleton: SkeletonLike | None = None,
    /,
    *,
    in_estimator: bool = False,
    **arrays: np.ndarray | None,
) -> None:
    """Warn if one of the arrays of angles looks like degrees: once for a call by the user.

    The columns of a skeleton's slides are in m, and not looked at.

    Calls of the library's functions by the library are silent, as what the user called has looked at the same numbers.
    The remedy is `np.radians` of the array, or what is to be passed instead.
    """
    bones = () if skeleton is None else skeleton.bones
    slides = np.repeat([bone.is_slide for bone in bones], [bone.n_dofs for bone in bones]).astype(bool)
    for name, X in arrays.items():
        if X is None or X.size == 0:
            continue
        if slides.any() and X.shape[1] == len(slides):
            X = X[:, ~slides]
            if X.size == 0:
                continue
        X = X[:: -(-len(X) // LOOKED_AT)]
        farthest = max(float(X.max()), -float(X.min()))
        if not FAR < farthest < np.inf:
            continue
        columns = np.maximum(X.max(axis=0), -X.min(axis=0)) > FAR
        if columns.mean() < SHARE or not (in_estimator or is_called_by_user(1)):
            continue
        warn(
            f"values of {name} reach {farthest:.4g}, and go beyond {FAR:.3g} in {columns.sum()} of {columns.size} "
            f"columns, but angles are in rad, where {TWO_PI:.3g} is a whole turn: if they are in degrees, pass "
            f"{remedy or f'np.radians({name})'}"
        )
        return


def likely_unit(size: float) -> str:
    """Return the unit in which a person's size is nearest to this number."""
    return min(UNITS, key=lambda unit: abs(np.log(size * UNITS[unit] / HUMAN)))


def complaint_of_size(size: float, scale: float) -> str | None:
    """Return the warning on a file's skeleton of a size in m, read at so many metres a unit; None if it is a person's.

    The size is that of `skpose.skeleton._shared.size_of`.
    """
    return _complaint(size, scale, "the skeleton is", "at angle zero")


def complaint_of_extent(positions: np.ndarray, scale: float) -> str | None:
    """Return the warning on a file's points, read at so many metres a unit; None if they have the size of a person.

    The size is `extent_of` the positions.
    """
    return _complaint(extent_of(positions), scale, "the points are", "in the median frame")


def extent_of(positions: np.ndarray) -> float:
    """Return how far apart points (n, points, 3) are in the median frame that has two or more; zero where none has."""
    seen = positions[(~np.isnan(positions[:, :, 0])).sum(axis=1) > 1]
    if len(seen) == 0:
        return 0.0
    seen = seen[:: -(-len(seen) // LOOKED_AT)]
    return float(np.median((np.nanmax(seen, axis=1) - np.nanmin(seen, axis=1)).max(axis=1)))


def _complaint(size: float, scale: float, what: str, when: str) -> str | None:
    if SMALLEST <= size <= LARGEST or size == 0.0:
        return None
    unit = likely_unit(size / scale)
    in_metres = size / scale * UNITS[unit]
    remedy = "pass the metres of one unit as scale="
    if SMALLEST <= in_metres <= LARGEST:
        remedy = f"if the file is in {unit}, pass scale={UNITS[unit]:.4g}, which makes that {in_metres:.3g} m"
    return (
        f"{what} {size:.3g} m from end to end {when}, with scale={scale:.4g} metres a unit, and people "
        f"are between {SMALLEST} and {LARGEST:g} m: {remedy}"
    )
