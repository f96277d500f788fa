"""Warnings about numbers in the wrong unit: degrees for radians, centimetres for metres.

Distances between such poses look plausible and are wrong.

Angles are checked if a skeleton is known: "angle" without one is the same distance in any unit. In recordings of people
at most 7 % of the columns go beyond three turns (188 of HDM05, 47 of CMU); in degrees at least 29 % do, and 21 % in
3 s of generated gait.

Sizes are checked if a file states the unit, or lacks one. A skeleton built by hand has the unit its author chose, and
may be a robot's arm: it is not checked.
"""

import numpy as np

from skpose._utils.validation import SkeletonLike
from skpose._utils.warnings import is_called_by_user, warn

TWO_PI = 2.0 * np.pi
FAR = 3.0 * TWO_PI  # rad
SHARE = 0.15  # of the columns beyond FAR
LOOKED_AT = 4096  # poses at most, evenly spaced
SMALLEST, LARGEST = 0.3, 5.0  # m between the ends of a skeleton: a doll, a horse with its rider
TALLEST = 2.4  # m, the height of the points of a person with raised arms
HUMAN = 1.7  # m, to choose among units
UNITS = {
    "metres": 1.0,
    "decimetres": 0.1,
    "centimetres": 0.01,
    "millimetres": 0.001,
    "feet": 0.3048,
    "inches": 0.0254,
    "units of CMU": 0.0254 / 0.45,
}


def warn_of_degrees(
    remedy: str | None = None,
    skeleton: SkeletonLike | None = None,
    /,
    *,
    in_estimator: bool = False,
    **arrays: np.ndarray | None,
) -> None:
    """Warn once if an array of angles looks like degrees; silent when the library calls its own functions.

    Columns of a skeleton's slides are in m and are skipped. The remedy defaults to `np.radians` of the array.
    """
    bones = () if skeleton is None else skeleton.bones
    is_angle = ~np.repeat([bone.is_slide for bone in bones], [bone.n_dofs for bone in bones]).astype(bool)
    for name, X in arrays.items():
        if X is None or X.size == 0:
            continue
        if X.shape[1] == len(is_angle) and not is_angle.all():
            X = X[:, is_angle]
        X = X[:: -(-len(X) // LOOKED_AT)]
        farthest = max(float(X.max(initial=0.0)), -float(X.min(initial=0.0)))
        if not FAR < farthest < np.inf:
            continue
        columns = np.maximum(X.max(axis=0), -X.min(axis=0)) > FAR
        if columns.mean() >= SHARE and (in_estimator or is_called_by_user(1)):
            remedy = remedy or f"np.radians({name})"
            warn(f"values of {name} reach {farthest:.4g}, but angles are in rad: if they are in degrees, pass {remedy}")
            return


def likely_unit(size: float, taken: float) -> str:
    """The unit with which a number is nearest to a person's size, except the unit of so many metres."""
    others = [unit for unit, metres in UNITS.items() if metres != taken]
    return min(others, key=lambda unit: abs(np.log(size * UNITS[unit] / HUMAN)))


def likely_scale(size: float) -> float:
    """The metres of one unit: 1 if the size is then a person's, else those of the unit that is nearest to one."""
    return 1.0 if SMALLEST <= size <= LARGEST else UNITS[likely_unit(size, 1.0)]


def complaint_of_size(size: float, scale: float) -> str | None:
    """The warning about a file's skeleton, its size in m as of `skeleton.size_of`; None if it fits a person."""
    return _complaint(size, scale, "the skeleton is", "in the rest pose")


def complaint_of_extent(positions: np.ndarray, scale: float, up: str | None = None) -> str | None:
    """The warning about a file's points, in m; None if they fit a person.

    With an axis that points up, people must not be too tall along it, wherever they stand.
    """
    height = 0.0 if up is None else extent_of(positions[:, :, ["xyz".index(up)]])
    size, largest = (height, TALLEST) if height > TALLEST else (extent_of(positions), LARGEST)
    return _complaint(size, scale, "the points are", "in the median frame", largest)


def extent_of(positions: np.ndarray) -> float:
    """The extent of points (n, points, 3) in the median frame with two or more; zero if there is no such frame."""
    seen = positions[(~np.isnan(positions[:, :, 0])).sum(axis=1) > 1]
    if len(seen) == 0:
        return 0.0
    seen = seen[:: -(-len(seen) // LOOKED_AT)]
    return float(np.median((np.nanmax(seen, axis=1) - np.nanmin(seen, axis=1)).max(axis=1)))


def _complaint(size: float, scale: float, subject: str, when: str, largest: float = LARGEST) -> str | None:
    if SMALLEST <= size <= largest or size == 0.0:
        return None
    unit = likely_unit(size / scale, scale)
    in_metres = size / scale * UNITS[unit]
    remedy = "pass the metres of one unit as scale="
    if SMALLEST <= in_metres <= LARGEST:
        remedy = f"if the file is in {unit}, pass scale={UNITS[unit]:.4g}"
    return f"{subject} {size:.3g} m from end to end {when}, with scale={scale:.4g}: {remedy}"
