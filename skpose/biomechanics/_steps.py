"""Contacts of the feet with the floor and strides, from positions with up last.

A foot is farthest ahead of the pelvis about when it comes down, and farthest behind when it lifts off (Zeni et al.).
In between it stands: from the first to the last moment at which the ankle is slower than half the speed of travel, or
the front of the foot slower than 0.8 of it (Bonci et al.). A runner's foot is that slow in the air too, so the slow
part must also be about as low as at its slowest moment.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.signal import find_peaks

from skpose.biomechanics._feet import Feet, runs_of

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
    contact: float  # row, not whole; NaN if it is on the floor when the foot begins to be seen
    off: float  # row; NaN if it is on the floor when the foot stops being seen
    position: np.ndarray  # (3,) m, of the ankle
    slide: float  # median speed of the slower part of the foot, of the speed of travel

    def start(self) -> float:
        """The row of its first event."""
        return float(np.nan_to_num(np.fmin(self.contact, self.off), nan=-1.0))


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
    runs = [(side, run) for side, seen in enumerate(feet.seen) for run in runs_of(seen) if run.stop - run.start > 3]
    for side, run in runs:
        parts = feet.ankles[side, run], feet.toes[side, run]
        speeds = [np.linalg.norm(np.gradient(part, feet.step, axis=0), axis=1) / speed[run] for part in parts]
        slow = [own / share for own, share in zip(speeds, (ANKLE, TOE), strict=True)]
        fore, aft = (((part - feet.pelvis[run])[:, :2] * ahead[run]).sum(axis=1) for part in parts)
        for rows in _supports(fore, aft, SWING * feet.leg):
            # The floor is the median height in the slower half of the rows.
            floors = [
                np.median(part[rows, 2][own[rows] <= np.median(own[rows])])
                for part, own in zip(parts, slow, strict=True)
            ]
            heights = [(part[:, 2] - floor) / (LOW * feet.leg) for part, floor in zip(parts, floors, strict=True)]
            # A part stands below 1, if it is slow and low; the foot stands if one of them does.
            unrest = np.minimum(*(np.maximum(*both) for both in zip(slow, heights, strict=True)))
            middle = rows.start + int(unrest[rows].argmin())
            if unrest[middle] < 1.0:
                stance = _stance(side, unrest, middle, parts[0], speeds, run.start)
                found.setdefault((side, str(stance.contact), str(stance.off)), stance)
    return sorted(found.values(), key=Stance.start)


def _supports(fore: np.ndarray, aft: np.ndarray, least: float) -> list[slice]:
    """Rows from the foremost position of a foot, relative to the pelvis, to the hindmost."""
    peaks = find_peaks(fore, prominence=least)[0].tolist()
    troughs = find_peaks(-aft, prominence=least)[0].tolist()
    supports = []
    for start, end in zip([0, *peaks], [*peaks, len(fore)], strict=True):
        inside = [trough for trough in troughs if start < trough < end]
        supports.append(slice(start, inside[-1] + 1 if inside else end))
    return supports


def _stance(
    side: int, unrest: np.ndarray, middle: int, ankle: np.ndarray, speeds: list[np.ndarray], start: int
) -> Stance:
    """The stance around a moment, of rows that start later; its ends are interpolated between frames."""
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
    position = ankle[rows][still].mean(axis=0)
    return Stance(side, start + contact, start + off, position, float(np.median(slower)))


def stances_at(feet: Feet, side: int, contacts: list[float], offs: list[float]) -> list[Stance]:
    """The stances of a foot between known contacts and offs, rows; NaN for the ends that are not known."""
    order = sorted([*((row, True) for row in contacts), *((row, False) for row in offs)])
    found = []
    for i, (row, is_contact) in enumerate(order):
        if is_contact or not i or not order[i - 1][1]:
            off = next((other for other, begins in order[i : i + 2] if not begins), np.nan)
            ends = (row if is_contact else np.nan), off
            rows = slice(*(int(np.clip(np.nan_to_num(end, nan=row), 0, len(feet.pelvis) - 1)) for end in ends))
            ankle = feet.ankles[side, rows.start : rows.stop + 1]
            found.append(Stance(side, *ends, np.median(ankle, axis=0), 0.0))
    return found


def find_strides(feet: Feet, stances: list[Stance], are_known: bool = False) -> tuple[list[Stride], set[int], str]:
    """The strides of walking or running, the numbers of their stances, or of a single step's, and why none are.

    Of known stances nothing is asked but that left and right come down in turn.
    """
    fastest = np.linalg.norm(feet.travel, axis=1).max()
    if fastest < least_speed_of(feet) and not are_known:
        why = f"the pelvis travels at most {fastest:.2g} m/s, and gait begins at {least_speed_of(feet):.2g} m/s"
        return [], set(), why
    numbers = [i for i, stance in enumerate(stances) if np.isfinite(stance.contact)]
    triples = list(zip(numbers, numbers[1:], numbers[2:], strict=False))
    complaints = [_complaint(feet, [stances[i] for i in triple], are_known) for triple in triples]
    strides = [triple for triple, complaint in zip(triples, complaints, strict=True) if not complaint]
    used = set(numbers) if are_known else {i for stride in strides for i in stride}
    if complaints:
        return strides, used, "" if strides else max(complaints, key=complaints.count)
    is_step = are_known or (len(numbers) == 2 and not _complaint(feet, [stances[i] for i in numbers], False))
    why = f"a stride needs three contacts after a swing, and there are {len(numbers)}"
    return [], set(numbers) if is_step else set(), why


def _complaint(feet: Feet, contacts: list[Stance], are_known: bool) -> str:
    """Why three contacts are not a stride, or two not a half of one; empty if they are."""
    first, other, last = contacts[0], contacts[1], contacts[-1]
    if any(one.side == following.side for one, following in pairwise(contacts)):
        return "left and right foot do not come down in turn"
    if are_known:
        return ""
    share = 2.0 / (len(contacts) - 1)
    duration = share * (last.contact - first.contact)
    if not STRIDE_TIMES[0] <= duration * feet.step <= STRIDE_TIMES[1]:
        return f"a foot comes down again after {duration * feet.step:.2g} s, and strides take 0.3 to 3 s"
    if not PHASES[0] <= (other.contact - first.contact) / duration <= PHASES[1]:
        return "left and right foot come down nearly together, as in jumps"
    along = share * (last.position - first.position)[:2]
    length = float(np.linalg.norm(along))
    if length < max(least_speed_of(feet) * duration * feet.step, FORWARD * feet.leg):
        return f"the feet move by {length:.2g} m only, as in steps on the spot"
    slide = max((one.slide for one in contacts if np.isfinite(one.off)), default=0.0)
    if slide > SLIDES:
        return f"the feet slide at {slide:.2g} of the speed of travel while they should stand"
    rows = slice(int(first.contact), int(last.contact) + 1)
    if (feet.pelvis[rows, 2] - np.fmin.reduce(feet.ankles[:, rows, 2])).min() < UPRIGHT * feet.leg:
        return "the pelvis is less than half the length of the legs above the feet, as in sitting"
    facing = feet.facing[rows].mean(axis=0)
    angle = np.degrees(np.arctan2(abs(facing[0] * along[1] - facing[1] * along[0]), facing @ along))
    if angle > SIDEWAYS:
        return f"the feet move {angle:.0f}° away from the direction that the pelvis faces"
    return ""
