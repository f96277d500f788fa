"""Feet that stand: when they do, and how a foot is held still meanwhile.

A foot stands on its toes while the point that touches the floor is slow, near the floor and stays in one place. It is
flat while the ankle is slow too. Positions have the vertical as their last axis.
"""

from typing import NamedTuple

import numpy as np

from skpose.kinematics._ground import WINDOW, runs, speeds_of

# Largest speeds of standing toes and a standing ankle, legs a second. Toes of a swing move at 2 and more, toes of a
# runner's standing foot at 0.1 in the middle of a tenth of a second.
SLOW, SLOW_ANKLE = 0.6, 0.35
NEAR = 0.35  # legs above the lowest place where a foot stands; steps of stairs are lower
SHORT, GAP = 0.05, 0.05  # s; shorter contacts and gaps are ignored
STAYS = 0.05  # legs, the largest distance of a standing point from its mean; a slow slide exceeds it
# Toes that slide in between stand below this speed, legs a second, over a window, s; if they drift on even so, in each
# place for the last time, s.
STILL, STILL_WINDOW, DRIFT = 0.15, 0.1, 1.0
RATE, SHARE = 0.5, 0.5  # legs a second, and share of the path of the toes: the speed of a foot between two places
BLEND = 0.15  # s before and after a contact, to blend to the held foot
FLAT = 0.4  # sine of the tilt up to which a foot that stands is laid flat
PIVOT = 0.3  # rad, the smallest turn on the floor that is a pivot
LEVEL = 0.06  # legs, the largest difference in height of places on one floor


class Contact(NamedTuple):
    """Frames in which the toes of a foot stand, and the part of them in which the whole foot does."""

    first: int
    end: int  # the one after the last
    flat_first: int
    flat_end: int  # not after the first if the foot is never flat


def find_contacts(
    toes: np.ndarray, ankles: np.ndarray, times: np.ndarray, leg: float, may: np.ndarray
) -> list[Contact]:
    """Find when a foot stands, from the positions (n_frames, 3) of a point at the toes and of the ankle, m.

    Times (n_frames,) are in s; speeds are relative to the length of the legs. `may` (n_frames,) are
    the frames in which the foot may stand.
    """
    slow_toes = (speeds_of(toes, times, WINDOW) < SLOW * leg) & may
    slow_ankle = speeds_of(ankles, times, WINDOW) < SLOW_ANKLE * leg
    heights = toes[:, 2]
    if slow_toes.any():
        slow_toes &= heights < np.percentile(heights[slow_toes], 5) + NEAR * leg
    still = slow_toes & (speeds_of(toes, times, STILL_WINDOW) < STILL * leg)
    found = []
    for first, end in _phases(slow_toes, times):
        for start, stop in _stays(toes, first, end, still, times, STAYS * leg):
            flat = max(
                _phases(slow_ankle[start:stop], times[start:stop]),
                key=lambda phase: phase[1] - phase[0],
                default=(0, 0),
            )
            found.append(Contact(start, stop, start + flat[0], start + flat[1]))
    return found


def _phases(stands: np.ndarray, times: np.ndarray) -> list[tuple[int, int]]:
    """The first frame and the one after the last of each phase in which a point is slow, without short gaps."""
    merged: list[list[int]] = []
    for first, end in runs(stands):
        if merged and times[first] - times[merged[-1][1] - 1] < GAP:
            merged[-1][1] = end
        else:
            merged.append([first, end])
    return [(first, end) for first, end in merged if times[end - 1] - times[first] >= SHORT]


def _stays(
    points: np.ndarray, first: int, end: int, still: np.ndarray, times: np.ndarray, away: float
) -> list[tuple[int, int]]:
    """The parts of a slow movement in which a point stays within a distance of its mean.

    That is all of it, or else the parts in which it is still: one that slides on does not stay.
    """
    if _is_near(points[first:end], away):
        return [(first, end)]
    found = []
    for start, stop in _phases(still[first:end], times[first:end]):
        part = slice(first + start, first + stop)
        if _is_near(points[part], away):
            if times[part.stop - 1] - times[part.start] >= 2.0 * STILL_WINDOW:
                found.append((part.start, part.stop))
            continue
        cut = part.start
        while cut < part.stop:  # a drift over seconds is an error of the recording, or of shoes
            stays = cut + _count_near(points[cut : part.stop], away)
            if times[stays - 1] - times[cut] >= DRIFT:
                found.append((cut, stays))
            cut = stays
    return found


def _is_near(points: np.ndarray, away: float) -> bool:
    """Whether points stay within a distance of their mean."""
    return bool(np.linalg.norm(points - points.mean(axis=0), axis=1).max() <= away)


def _count_near(points: np.ndarray, away: float) -> int:
    """Count the first points, at least one, within a distance of the mean of those before."""
    means = np.cumsum(points, axis=0) / np.arange(1, len(points) + 1)[:, None]
    left = np.linalg.norm(points - means, axis=1) > away
    return int(left.argmax()) if left.any() else len(points)


def find_floor(heights: np.ndarray, leg: float) -> float:
    """The median height of the places where feet stand; on uneven ground, of the lowest."""
    return float(np.median(heights[heights < heights.min() + LEVEL * leg]))


class Sole(NamedTuple):
    """The sole of a foot, from the ankle in the axes of the foot, m."""

    heel: np.ndarray  # (3,) the middle of its end
    tip: np.ndarray
    half: float  # of its width

    def corners(self) -> np.ndarray:
        """The corners (4, 3), heel first."""
        across = np.array([0.0, self.half, 0.0])
        return np.stack([end + side * across for end in (self.heel, self.tip) for side in (1.0, -1.0)])


class Held(NamedTuple):
    """The ankle and the axes of a foot that is held while it stands."""

    ankles: np.ndarray  # (n_frames, 3)
    frames: np.ndarray  # (n_frames, 3, 3) axes of the foot: forward, left and up
    stands: np.ndarray  # (n_frames,) how much it is held, from 0 to 1
    contacts: list[Contact]  # in which it is held all the time


def hold_foot(
    ankles: np.ndarray,
    frames: np.ndarray,
    sole: Sole,
    contacts: list[Contact],
    times: np.ndarray,
    leg: float,
) -> Held:
    """Hold a foot still while it stands.

    Frames (n_frames, 3, 3) have the axes forward, left and up in their columns. The floor is at zero. Contacts become
    shorter where the foot would have no time to go from one place to the next, as where it slides in between.
    """
    while True:  # contacts become fewer or shorter each time
        laid, stands = _lay_flat(frames, contacts, times)
        tips = ankles + laid @ sole.tip
        moves = []
        for contact in contacts:
            is_flat = contact.flat_end > contact.flat_first
            best = slice(contact.flat_first, contact.flat_end) if is_flat else slice(contact.first, contact.end)
            place = tips[best].mean(axis=0)
            if abs(place[2]) < LEVEL * leg:
                place[2] = 0.0
            moves.append(place - tips[contact.first : contact.end])
        shorter = _leave_time(contacts, moves, tips, times, leg)
        if shorter == contacts:
            break
        contacts = shorter
    ankles = ankles + blend_between([(contact.first, contact.end) for contact in contacts], moves, times, 3)
    lowest = (ankles[:, None] + sole.corners() @ laid.transpose(0, 2, 1))[:, :, 2].min(axis=1)
    ankles[:, 2] += np.maximum(-lowest, 0.0)
    return Held(ankles, laid, stands, contacts)


def _lay_flat(frames: np.ndarray, contacts: list[Contact], times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The axes of a foot, level where it stands flat, and how much it is held, from 0 to 1."""
    n = len(frames)
    ahead = frames[:, :, 0] + np.cross(frames[:, :, 1], [0.0, 0.0, 1.0])  # of a foot that points down, its instep
    yaws = np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0]))
    turns, phases = [], []
    for contact in contacts:
        part = slice(contact.flat_first, contact.flat_end)
        if contact.flat_end <= contact.flat_first or np.abs(frames[part, 2, 2]).min() < np.sqrt(1.0 - FLAT**2):
            continue
        phases.append((part.start, part.stop))
        kept = np.full(part.stop - part.start, np.median(yaws[part]))
        turns.append((kept if np.ptp(yaws[part]) < PIVOT else yaws[part]) - yaws[part])
    flat = blend_between(phases, [np.ones(end - first) for first, end in phases], times)
    yaws = yaws + blend_between(phases, turns, times)
    level = np.zeros((n, 3, 3))
    level[:, 0, 0], level[:, 1, 0], level[:, 2, 2] = np.cos(yaws), np.sin(yaws), 1.0
    level[:, 0, 1], level[:, 1, 1] = -level[:, 1, 0], level[:, 0, 0]
    laid = _orthonormal((1.0 - flat)[:, None, None] * frames + flat[:, None, None] * level)
    standing = [(contact.first, contact.end) for contact in contacts]
    stands = blend_between(standing, [np.ones(end - first) for first, end in standing], times)
    # On its toes a foot has the heel up, not below the floor, and both corners of the sole down.
    laid[:, 2, 0] -= stands * np.clip(laid[:, 2, 0], 0.0, FLAT)
    laid[:, 2, 1] -= stands * np.clip(laid[:, 2, 1], -FLAT, FLAT)
    return _orthonormal(laid), stands


def _leave_time(
    contacts: list[Contact], moves: list[np.ndarray], tips: np.ndarray, times: np.ndarray, leg: float
) -> list[Contact]:
    """Shorten contacts until there is time to go from one place to the next, and drop short ones.

    `moves` are the shifts of the held tips from the tips (n_frames, 3).
    """
    parts = [[contact.first, contact.end] for contact in contacts]
    path = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(tips, axis=0), axis=1))])
    for i in range(1, len(contacts)):
        before, after = parts[i - 1], parts[i]
        while before[1] - before[0] > 1 and after[1] - after[0] > 1:
            last, first = before[1] - 1, after[0]
            one, other = moves[i - 1][last - contacts[i - 1].first], moves[i][first - contacts[i].first]
            most = max(RATE * leg * (times[first] - times[last]), SHARE * (path[first] - path[last]))
            if np.linalg.norm(other - one) <= most:
                break
            if np.linalg.norm(one) > np.linalg.norm(other):
                before[1] -= 1
            else:
                after[0] += 1
    found = []
    for contact, (first, end) in zip(contacts, parts, strict=True):
        if (first, end) == (contact.first, contact.end) or times[end - 1] - times[first] >= SHORT:
            flat = max(contact.flat_first, first), min(contact.flat_end, end)
            found.append(Contact(first, end, *(flat if flat[1] > flat[0] else (first, first))))
    return found


def _orthonormal(frames: np.ndarray) -> np.ndarray:
    """Make axes (n, 3, 3) orthonormal, keeping the one to the left."""
    y = frames[:, :, 1] / np.linalg.norm(frames[:, :, 1], axis=1, keepdims=True)
    z = np.cross(frames[:, :, 0], y)
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    return np.stack([np.cross(y, z), y, z], axis=2)


def blend_between(
    phases: list[tuple[int, int]], values: list[np.ndarray], times: np.ndarray, width: int = 0
) -> np.ndarray:
    """Blend values (n, ...) given in some phases to zero, or to the values of the next phase, in between."""
    frames, ends = np.arange(len(times)), [(times[first], times[end - 1]) for first, end in phases]
    out = np.zeros((len(times), width) if width else len(times))
    for i, ((first, end), here) in enumerate(zip(phases, values, strict=True)):
        nearest = np.clip(frames, first, end - 1)
        before = ends[i][0] - ends[i - 1][1] if i else BLEND
        after = ends[i + 1][0] - ends[i][1] if i + 1 < len(ends) else BLEND
        length = np.minimum(BLEND, np.where(frames < first, before, after))
        x = np.minimum(np.abs(times - times[nearest]) / length, 1.0)
        share = 1.0 - x * x * (3.0 - 2.0 * x)
        out += (share[:, None] if width else share) * here[nearest - first]
    return out
