"""What formats leave open, and files may state wrongly: the unit of length, the frame rate, the axis that points up,
names given twice, and whether a point at the origin is a lost one.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.units import complaint_of_extent
from skpose._utils.validation import check_choice, check_frame_rate, check_positive
from skpose.io._source import Source
from skpose.keypoints import Keypoints
from skpose.keypoints._checks import UPS, complaint_of_origin, settle_up, turn_up
from skpose.skeleton import Motion
from skpose.skeleton._root import root_angles_of, root_orientations
from skpose.skeleton._upright import complaint_of_up

Axis = Literal["x", "y", "z"]
Up = Literal["x", "y", "z", "-x", "-y", "-z"]
# Half a turn that makes an axis point up that points down.
HALF_TURNS = {up: Rotation.from_rotvec(np.pi * about) for up, about in zip(UPS[3:], np.eye(3)[[1, 0, 0]], strict=True)}
Zeros = Literal["seen", "missing"]
CHOICES: dict[str, tuple] = {
    "on_nan": ("raise", "drop"),
    "trust": ("header", "rows"),
    "stretch": ("raise", "mean"),
    "missing": ("raise", "rest"),
    "root_offset": ("replace", "add"),
    "up": (None, *UPS),
    "zeros": (None, "seen", "missing"),
}

METRES = {
    "m": 1.0, "meter": 1.0, "metre": 1.0, "meters": 1.0, "metres": 1.0,
    "cm": 0.01, "centimeter": 0.01, "centimetre": 0.01, "centimeters": 0.01, "centimetres": 0.01,
    "mm": 0.001, "millimeter": 0.001, "millimetre": 0.001, "millimeters": 0.001, "millimetres": 0.001,
    "in": 0.0254, "inch": 0.0254, "inches": 0.0254,
    "ft": 0.3048, "foot": 0.3048, "feet": 0.3048,
}  # fmt: skip
ANGLES = ("rad", "rads", "radian", "radians", "deg", "degs", "degree", "degrees", "°")
FEWEST = 4  # letters of a name that is cut short, as in C3D files without room for more

SAME = 0.01  # relative difference between two roundings of one rate
SLOWEST, FASTEST = 2.0, 2000.0  # Hz, of recordings of people


def check_options(**options: Any) -> None:
    """Check the options that several readers have, by their names."""
    for name, value in options.items():
        if name in CHOICES:
            check_choice(name, value, CHOICES[name])
        elif value is not None and (name, value) != ("scale", "auto"):
            check_frame_rate(value) if name == "frame_rate" else check_positive(name, value)


def read_unit(source: Source, where: str, unit: str, scale: float | None, at: Any = None) -> float:
    """The metres of one unit: the scale, or else by the name of the unit in any case, also if it is cut off."""
    word = unit.strip().lower()
    names = [name for name in (*METRES, *ANGLES) if name == word or (len(word) >= FEWEST and name.startswith(word))]
    if any(name in ANGLES for name in names):
        raise source.error(f"{where}: expected a unit of length, found {unit[:40]!r}: these are angles", at)
    metres = {METRES[name] for name in names}
    if scale is not None:
        return choose_scale(source, scale, metres.pop() if len(metres) == 1 else scale, where)
    if len(metres) != 1:
        raise source.error(f"{where}: expected a unit such as mm, cm or m, found {unit[:40]!r}: pass scale=", at)
    return metres.pop()


def choose_scale(source: Source, given: float, stated: float, where: str) -> float:
    """The given scale, with a warning if the file states another unit."""
    if not agree(given, stated):
        source.warn(f"scale={given:g} replaces the unit of {where}, {stated:.4g} m")
    return given


def choose_rate(source: Source, given: float | None, stated: float, where: str) -> float:
    """The frame rate, Hz: `given`, with a warning if the file states another, or the file's own."""
    if given is None:
        return stated
    if SLOWEST <= stated <= FASTEST and not agree(given, stated):
        source.warn(
            f"frame_rate={given:g} replaces the {stated:g} Hz of {where}, so that it lasts {stated / given:.3g} times "
            "as long; Motion.resample changes the rate"
        )
    return given


def agree(one: float, other: float) -> bool:
    """Whether two rates or scales differ by no more than rounding."""
    return abs(one - other) <= SAME * other


def stand(motion: Motion, up: str | None, source: Source, default: Axis = "y") -> Motion:
    """A motion with its up axis: `up`, or the default, with a warning if people stand along another axis.

    If the axis points down the world is turned by half a turn: about x for y and z, about y for x.
    """
    if up is None:
        source.warn(complaint_of_up(motion, default))
        up = default
    if up in HALF_TURNS:
        turn = HALF_TURNS[up]
        angles, axes = motion.root_angles, motion.root_axes
        if len(motion):
            turned = turn * root_orientations(motion.root_angles, motion.root_axes)
            angles, axes = root_angles_of(turned, np.zeros(3), motion.root_axes)
        motion = replace(motion, root_positions=turn.apply(motion.root_positions), root_angles=angles, root_axes=axes)
    axis: Any = up[-1]
    return replace(motion, up=axis)


def quarter_turn(before: str, after: str) -> np.ndarray:
    """The rotation matrix (3, 3) of the world that takes one axis to another; zeros and ones."""
    if before == after:
        return np.eye(3)
    axes = [np.eye(3)["xyz".index(axis)] for axis in (before, after)]
    return np.round(Rotation.from_rotvec(np.pi / 2 * np.cross(*axes)).as_matrix()) + 0.0


def check_even(motion: Motion, format_has: str) -> None:
    """Refuse a motion with frames left out for a format with one time between all frames."""
    if (np.diff(motion.frame_numbers) > 1).any():
        raise ValueError(
            f"some frame_numbers are left out, and {format_has} one time between all frames: "
            "dataclasses.replace(motion, frame_numbers=None) writes the frames without regard to their times"
        )


def keypoints_of_markers(
    source: Source,
    positions: np.ndarray,
    names: Sequence[str],
    frame_rate: float,
    scale: float,
    zeros: Zeros | None,
    up: Any,
    usual: tuple[Up, str],
) -> Keypoints:
    """Markers in m, without lost ones, with the axis that points up; `usual` has a reason with it."""
    lost = (positions == 0.0).all(axis=2)
    if zeros == "missing":
        positions[lost] = np.nan
    elif zeros is None and lost.any():
        source.warn(complaint_of_origin(lost, names))
    positions = positions * scale
    if up is None:
        up, complaint = settle_up(positions, names, *usual)
        source.warn(complaint)
    positions, axis = turn_up(positions, up)
    found = Keypoints(positions, names, frame_rate, up=axis)
    source.warn(complaint_of_extent(found.positions, scale))
    return found


def number_names(source: Source, names: list[str]) -> list[str]:
    """A different name for each point: the first of a name keeps it, the others are numbered, with a warning."""
    unique: dict[str, str] = {}
    for name in names:
        unique[unused_name(name, unique, names)] = name
    warn_of_renamed(source, "points", unique)
    return list(unique)


def unused_name(name: str, used: Collection[str], reserved: Collection[str]) -> str:
    """The name, numbered if it is used; numbered names are never reserved ones."""
    new, count = name, 1
    while new in used or (count > 1 and new in reserved):
        count += 1
        new = f"{name}_{count}"
    return new


def warn_of_renamed(source: Source, what: str, names: dict[str, str]) -> None:
    """Warn if new names, the keys, differ from those in the file."""
    renamed = [(new, name) for new, name in names.items() if name != new]
    if renamed:
        source.warn(f"several {what} are named {renamed[0][1]!r}; the next one is {renamed[0][0]!r} here")
