"""Findings, the registry of checks, and their thresholds.

Thresholds are of a person with legs of 0.9 m, and are tuned on every second of 235 recordings of CMU and HDM05 at 30
and 120 Hz: the largest values of recordings without the fault are in brackets.
"""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

SEVERITIES = ("error", "warning", "note")

# name: (value, unit, where it comes from)
THRESHOLDS: dict[str, tuple[float, str, str]] = {
    "leg": (0.35, "m", "from hip to ankle: shorter legs are a toddler's, legs of more than 1.25 m nobody's"),
    "jump": (0.03, "m", "a step that differs from those around it, plus `jerk` · step³ [0.02]"),
    "jerk": (4500.0, "m/s³", "of hands and feet between frames of 30 Hz [4,000]"),
    "sudden": (10.0, "", "times the median of the same within 0.15 s [6]"),
    "noise": (0.0004, "m", "standard deviation of white noise with the same third differences, plus `rough` · step"),
    "rough": (0.024, "m/s", "real accelerations are as large at 30 Hz [0.018]"),
    "fast": (3.0, "1/s", "of a joint, times the step and its median movement, likewise [2.5]"),
    "linear": (0.002, "", "change of the velocity of the root, or of all angles, as a share of it [0.004]"),
    "made up": (5.0, "frames", "in which it is so small [3]"),
    "flip": (1.0, "rad", "a step of an angle without a rotation"),
    "horizontal": (15.0, "°", "of upper arms and forearms from the line of the shoulders: a T-pose"),
    "floor": (0.08, "m", "height of standing feet above 0 beyond that of the joints above the sole [0.04]"),
    "float": (0.05, "m", "of the lowest joint above the floor while it stands still for 0.25 s"),
    "sink": (0.06, "m", "of a standing foot below the floor for 0.1 s"),
    "slide": (0.35, "m/s", "of the slowest point near the floor for 0.25 s"),
    "travel": (0.25, "", "of the root, relative to what the standing foot shows"),
    "knee": (25.0, "°", "of a knee that bends towards the toes for 0.1 s"),
    "hinge": (3.0, "°", "of a robot's hinge beyond its limit"),
    "same": (0.005, "m", "distance of poses of one motion in two files"),
    "near": (0.02, "m", "distance of poses of near duplicates: two takes of one action differ by [0.03]"),
    "unlike": (4.0, "", "times the median distance of a motion to the nearest other one"),
}


def limit(name: str) -> float:
    return THRESHOLDS[name][0]


class Finding(NamedTuple):
    """One fault that `check_motion` has found.

    Attributes
    ----------
    severity : {"error", "warning", "note"}
        "error": something is wrong in the motion or its header; "warning": its quality is low; "note": a convention
        that some programs stumble over.
    kind : str
        Kind of the finding, such as "root jump".
    motion : int
        Index of the motion.
    frames : tuple of two ints
        The first frame and the one after the last, as of a slice of the motion.
    joints : tuple of str
        The joints concerned; empty for all.
    size : float
        How much, in the unit.
    unit : str
        Unit of the size.
    what : str
        What was found.
    remedy : str
        What can be done.
    """

    severity: str
    kind: str
    motion: int
    frames: tuple[int, int]
    joints: tuple[str, ...]
    size: float
    unit: str
    what: str
    remedy: str

    def __str__(self) -> str:
        first, end = self.frames
        where = f"motion {self.motion}, frames {first} to {end - 1}"
        return f"{self.severity}: {self.kind}, {where}: {self.what}; {self.remedy}"


class Found(NamedTuple):
    """What a check reports of a recording."""

    size: float
    unit: str
    what: str
    frames: tuple[int, int] | None = None  # None is the whole motion
    joints: tuple[str, ...] = ()
    remedy: str = ""  # of this one, instead of that of its kind


class Check(NamedTuple):
    """A kind of finding."""

    severity: str
    remedy: str
    find: Callable[[Any], Iterator[Found]]


CHECKS: dict[str, Check] = {}


def check(kind: str, severity: str, remedy: str) -> Callable[[Callable], Callable]:
    """Register the function that finds a kind of fault in a `Recording`."""

    def register(find: Callable) -> Callable:
        CHECKS[kind] = Check(severity, remedy, find)
        return find

    return register
