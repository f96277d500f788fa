"""Contacts of the feet with the floor and strides, from positions with up last.

A foot is farthest ahead of the pelvis about when it comes down, and farthest behind when it lifts off (Zeni et al.).
In between it stands: from the first to the last moment at which the ankle is slower than half the speed of travel, or
the front of the foot slower than 0.8 of it (Bonci et al.). A runner's foot is that slow in the air too, so the slow
part must also be about as low as at its slowest moment.
"""

from typing import NamedTuple

import numpy as np
from scipy.signal import find_peaks

from skpose.biomechanics._feet import Feet

ANKLE, TOE = 0.5, 0.8  # of the speed of travel; slower parts of the foot stand
LOW = 0.05  # of the length of the leg; parts of the foot that are lower above their floor stand
SWING = 0.1  # of the length of the leg: a foot moves to and fro by at least this, relative to the pelvis
LEAST_SPEED = 0.06  # of √(g · leg), 0.18 m/s for a leg of 0.9 m
GRAVITY = 9.81  # m/s²
PHASES = (0.3, 0.7)  # of a stride, between which the other foot comes down
STRIDE_TIMES = (0.3, 3.0)  # s
SIDEWAYS = 45.0  # degrees between the direction of a stride and that in which the pelvis faces
FORWARD = 0.35  # of the length of the leg: shorter strides are steps on the spot
SLIDES = 0.33  # of the speed of travel: a foot on the floor is slower in half of its stance; 0.23 in recordings
UPRIGHT = 0.5  # of the length of the leg, least height of the pelvis above the lower ankle


class Stance(NamedTuple):
    """A foot on the floor."""

    side: int
    contact: float  # row, not whole; NaN if it is on the floor when the recording begins
    off: float  # row; NaN if it is on the floor when the recording ends
    position: np.ndarray  # (3,) m, of the ankle
    slide: float  # median speed of the slower part of the foot, of the speed of travel


Stride = tuple[int, int, int]  # from one contact of a foot to its next, with the other foot's in between


def least_speed_of(feet: Feet) -> float:
    """The least speed of gait, m/s, proportional to √(g · leg) for people of all sizes."""
    return LEAST_SPEED * float(np.sqrt(GRAVITY * feet.leg))


def find_stances(feet: Feet) -> list[Stance]:
    """All stances after a swing or before one, in order of contacts."""
    speed = np.linalg.norm(feet.travel, axis=1)
    ahead = feet.travel / np.maximum(speed, 1e-12)[:, None]
    speed = np.maximum(speed, least_speed_of(feet))
    found: dict[tuple, Stance] = {}
    for side in range(2):
        parts = feet.ankles[side], feet.toes[side]
        speeds = [np.linalg.norm(np.gradient(part, feet.step, axis=0), axis=1) / speed for part in parts]
        slow = [own / share for own, share in zip(speeds, (ANKLE, TOE), strict=True)]
        fore, aft = (((part - feet.pelvis)[:, :2] * ahead).sum(axis=1) for part in parts)
        for rows in _supports(fore, aft, SWING * feet.leg):
            floors = [_floor(part[rows, 2], own[rows]) for part, own in zip(parts, slow, strict=True)]
            heights = [(part[:, 2] - floor) / (LOW * feet.leg) for part, floor in zip(parts, floors, strict=True)]
            # A part stands below 1, if it is slow and low; the foot stands if one of them does.
            unrest = np.minimum(*(np.maximum(*both) for both in zip(slow, heights, strict=True)))
            middle = rows.start + int(unrest[rows].argmin())
            if unrest[middle] < 1.0:
                stance = _stance(side, unrest, middle, parts[0], speeds)
                found.setdefault((side, str(stance.contact), str(stance.off)), stance)
    return sorted(found.values(), key=lambda one: one.contact if np.isfinite(one.contact) else -1.0)


def _floor(heights: np.ndarray, slow: np.ndarray) -> float:
    """The height at which a part of a foot stands: the median of the slower half of the rows."""
    return float(np.median(heights[slow <= np.median(slow)]))


def _supports(fore: np.ndarray, aft: np.ndarray, least: float) -> list[slice]:
    """Rows from the foremost position of a foot, relative to the pelvis, to the hindmost."""
    peaks = find_peaks(fore, prominence=least)[0].tolist()
    troughs = find_peaks(-aft, prominence=least)[0].tolist()
    supports = []
    for start, end in zip([0, *peaks], [*peaks, len(fore)], strict=True):
        inside = [trough for trough in troughs if start < trough < end]
        supports.append(slice(start, inside[-1] + 1 if inside else end))
    return supports


def _stance(side: int, unrest: np.ndarray, middle: int, ankle: np.ndarray, speeds: list[np.ndarray]) -> Stance:
    """The stance around a moment; its ends are interpolated between frames."""
    moving = np.flatnonzero(unrest >= 1.0)
    before, after = moving[moving < middle], moving[moving > middle]
    contact, off = np.nan, np.nan
    first, last = 0, len(unrest) - 1
    if len(before):
        first = int(before[-1]) + 1
        contact = first - (1.0 - unrest[first]) / (unrest[first - 1] - unrest[first])
    if len(after):
        last = int(after[0]) - 1
        off = last + (1.0 - unrest[last]) / (unrest[last + 1] - unrest[last])
    rows = slice(first, last + 1)
    slower = np.minimum(*speeds)[rows]
    still = speeds[0][rows] <= np.median(speeds[0][rows])
    return Stance(side, contact, off, ankle[rows][still].mean(axis=0), float(np.median(slower)))


def find_strides(feet: Feet, stances: list[Stance]) -> tuple[list[Stride], str]:
    """The strides of walking or running, or why there are none."""
    fastest = np.linalg.norm(feet.travel, axis=1).max()
    if fastest < least_speed_of(feet):
        return [], f"the pelvis travels at most {fastest:.2g} m/s, and gait begins at {least_speed_of(feet):.2g} m/s"
    numbers = [i for i, stance in enumerate(stances) if np.isfinite(stance.contact)]
    triples = list(zip(numbers, numbers[1:], numbers[2:], strict=False))
    complaints = [_complaint(feet, *(stances[i] for i in triple)) for triple in triples]
    strides = [triple for triple, complaint in zip(triples, complaints, strict=True) if not complaint]
    if strides:
        return strides, ""
    if not complaints:
        return [], f"a stride needs three contacts after a swing, and there are {len(numbers)}"
    return [], max(complaints, key=complaints.count)


def _complaint(feet: Feet, first: Stance, other: Stance, last: Stance) -> str:
    """Why three contacts are not a stride; empty if they are."""
    if not first.side == last.side != other.side:
        return "left and right foot do not come down in turn"
    duration = last.contact - first.contact
    if not STRIDE_TIMES[0] <= duration * feet.step <= STRIDE_TIMES[1]:
        return f"a foot comes down again after {duration * feet.step:.2g} s, and strides take 0.3 to 3 s"
    if not PHASES[0] <= (other.contact - first.contact) / duration <= PHASES[1]:
        return "left and right foot come down nearly together, as in jumps"
    along = (last.position - first.position)[:2]
    length = float(np.linalg.norm(along))
    if length < max(least_speed_of(feet) * duration * feet.step, FORWARD * feet.leg):
        return f"the feet move by {length:.2g} m only, as in steps on the spot"
    slide = max(one.slide for one in (first, other, last) if np.isfinite(one.off))
    if slide > SLIDES:
        return f"the feet slide at {slide:.2g} of the speed of travel while they should stand"
    rows = slice(int(first.contact), int(last.contact) + 1)
    if (feet.pelvis[rows, 2] - feet.ankles[:, rows, 2].min(axis=0)).min() < UPRIGHT * feet.leg:
        return "the pelvis is less than half the length of the legs above the feet, as in sitting"
    facing = feet.facing[rows].mean(axis=0)
    angle = np.degrees(np.arctan2(abs(facing[0] * along[1] - facing[1] * along[0]), facing @ along))
    if angle > SIDEWAYS:
        return f"the feet move {angle:.0f}° away from the direction that the pelvis faces"
    return ""
