"""Contacts of the feet with the floor, and the strides that they make: of positions alone, up last.

A foot is ahead of the pelvis as far as it gets at about the time when it comes down, and behind it when it lifts off
(Zeni et al.). Between these two it stands: from the first moment to the last at which the ankle is slower than half the
speed of travel, or the front of the foot slower than 0.8 of it (Bonci et al.). In running, where the foot is that slow
in the air too, the part that is slow must also be about as low as where it is slowest.
"""

from typing import NamedTuple

import numpy as np
from scipy.signal import find_peaks

from skpose.biomechanics._feet import Feet

ANKLE, TOE = 0.5, 0.8  # of the speed of travel, below which a part of the foot stands
LOW = 0.05  # of the length of the leg, above the height at which a part of the foot stands still, below which it stands
SWING = 0.1  # of the length of the leg: a foot moves to and fro by at least this, relative to the pelvis
LEAST_SPEED = 0.06  # of √(g · leg), 0.18 m/s for a leg of 0.9 m, above which one travels
GRAVITY = 9.81  # m/s²
PHASES = (0.3, 0.7)  # of a stride, between which the other foot comes down
STRIDE_TIMES = (0.3, 3.0)  # s
SIDEWAYS = 45.0  # degrees between the direction of a stride and that in which the pelvis faces
FORWARD = 0.35  # of the length of the leg: shorter strides are steps on the spot
SLIDES = 0.33  # of the speed of travel: a foot on the floor is slower in half of its stance; 0.23 in recordings
UPRIGHT = 0.5  # of the length of the leg, by which the pelvis is above the lower ankle, at least


class Stance(NamedTuple):
    """A foot on the floor."""

    side: int
    contact: float  # row, not whole; NaN if it is on the floor when the recording begins
    off: float  # row; NaN if it is on the floor when the recording ends
    position: np.ndarray  # (3,) m, of the ankle
    slide: float  # median speed of the slower part of the foot, of the speed of travel


class Stride(NamedTuple):
    """From one contact of a foot to its next; numbers of stances."""

    first: int
    other: int  # of the other foot, between the two
    last: int


def least_speed_of(feet: Feet) -> float:
    """Return the speed above which one travels, m/s: speeds of people of all sizes compare by √(g · leg)."""
    return LEAST_SPEED * float(np.sqrt(GRAVITY * feet.leg))


def find_stances(feet: Feet) -> list[Stance]:
    """Return each time in which a foot is on the floor after a swing or before one, in order of contacts."""
    speed = np.linalg.norm(feet.travel, axis=1)
    ahead = feet.travel / np.maximum(speed, 1e-12)[:, None]
    speed = np.maximum(speed, least_speed_of(feet))
    found: dict[tuple, Stance] = {}
    for side in range(2):
        parts = feet.ankles[side], feet.toes[side]
        speeds = [_speed_of(part, feet.step) / speed for part in parts]
        slow = [own / share for own, share in zip(speeds, (ANKLE, TOE), strict=True)]
        fore, aft = (((part - feet.pelvis)[:, :2] * ahead).sum(axis=1) for part in parts)
        for rows in _supports(fore, aft, SWING * feet.leg):
            floors = [_floor(part[rows, 2], own[rows]) for part, own in zip(parts, slow, strict=True)]
            heights = [(part[:, 2] - floor) / (LOW * feet.leg) for part, floor in zip(parts, floors, strict=True)]
            # A part stands below 1, where it is slow and low; the foot stands where one of them does.
            unrest = np.minimum(*(np.maximum(*both) for both in zip(slow, heights, strict=True)))
            middle = rows.start + int(unrest[rows].argmin())
            if unrest[middle] < 1.0:
                stance = _stance(side, unrest, middle, parts[0], speeds)
                found.setdefault((side, str(stance.contact), str(stance.off)), stance)
    return sorted(found.values(), key=lambda one: one.contact if np.isfinite(one.contact) else -1.0)


def _speed_of(positions: np.ndarray, step: float) -> np.ndarray:
    return np.linalg.norm(np.gradient(positions, step, axis=0), axis=1)


def _floor(heights: np.ndarray, slow: np.ndarray) -> float:
    """Return the height at which a part of a foot stands: the median of the half of the rows in which it is slowest."""
    return float(np.median(heights[slow <= np.median(slow)]))


def _supports(fore: np.ndarray, aft: np.ndarray, least: float) -> list[slice]:
    """Return rows from where a foot is foremost, relative to the pelvis, to where it is hindmost."""
    peaks = find_peaks(fore, prominence=least)[0].tolist()
    troughs = find_peaks(-aft, prominence=least)[0].tolist()
    supports = []
    for start, end in zip([0, *peaks], [*peaks, len(fore)], strict=True):
        inside = [trough for trough in troughs if start < trough < end]
        supports.append(slice(start, inside[-1] + 1 if inside else end))
    return supports


def _stance(side: int, unrest: np.ndarray, middle: int, ankle: np.ndarray, speeds: list[np.ndarray]) -> Stance:
    """Return the time around a moment in which a foot stands; between frames by a line."""
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
    """Return the strides of walking or running; where there are none, in words why."""
    fastest = np.linalg.norm(feet.travel, axis=1).max()
    if fastest < least_speed_of(feet):
        return [], (
            f"the pelvis moves along the floor by at most {fastest:.2g} m/s, averaged over a step, and gait begins at "
            f"{least_speed_of(feet):.2g} m/s. On a treadmill add what the belt moves to root_positions"
        )
    numbers = [i for i, stance in enumerate(stances) if np.isfinite(stance.contact)]
    triples = list(zip(numbers, numbers[1:], numbers[2:], strict=False))
    complaints = [_complaint(feet, *(stances[i] for i in triple)) for triple in triples]
    strides = [Stride(*triple) for triple, complaint in zip(triples, complaints, strict=True) if not complaint]
    if strides:
        return strides, ""
    if not complaints:
        return [], (
            f"in {feet.times[-1] - feet.times[0]:.2g} s the feet come down {len(numbers)} times after a swing, and a "
            "stride needs three: of one foot, of the other, of the first again"
        )
    return [], max(complaints, key=complaints.count)


def _complaint(feet: Feet, first: Stance, other: Stance, last: Stance) -> str:
    """Return in words why three contacts are no stride; empty if they are one."""
    if not first.side == last.side != other.side:
        return "left and right foot do not come down in turn"
    duration = last.contact - first.contact
    if not STRIDE_TIMES[0] <= duration * feet.step <= STRIDE_TIMES[1]:
        return f"a foot comes down after {duration * feet.step:.2g} s, and strides take {STRIDE_TIMES[0]:g} to 3 s"
    if not PHASES[0] <= (other.contact - first.contact) / duration <= PHASES[1]:
        return "left and right foot do not come down half a stride apart, but nearly together, as in jumps"
    along = (last.position - first.position)[:2]
    length = float(np.linalg.norm(along))
    if length < max(least_speed_of(feet) * duration * feet.step, FORWARD * feet.leg):
        return f"the feet come down within {length:.2g} m of where they were, as in steps on the spot"
    slide = max(one.slide for one in (first, other, last) if np.isfinite(one.off))
    if slide > SLIDES:
        return f"the feet slide, at {slide:.2g} of the speed of travel, while they should stand"
    rows = slice(int(first.contact), int(last.contact) + 1)
    if (feet.pelvis[rows, 2] - feet.ankles[:, rows, 2].min(axis=0)).min() < UPRIGHT * feet.leg:
        return "the pelvis comes down to less than half the length of the legs above the feet, as in sitting and lying"
    facing = feet.facing[rows].mean(axis=0)
    angle = np.degrees(np.arctan2(abs(facing[0] * along[1] - facing[1] * along[0]), facing @ along))
    if angle > SIDEWAYS:
        return f"the feet move in a direction {angle:.0f}° away from that in which the pelvis faces"
    return ""
