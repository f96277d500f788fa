"""Feet that stand: when they do, and how a foot is held still meanwhile.

A foot stands on its toes while the point that touches the floor is slow, near the floor and stays where it is, and flat
while the ankle is slow too. Positions have the vertical as their last axis.
"""

from typing import NamedTuple

import numpy as np

# Legs a second, below which toes and the ankle stand. Toes of a swing move at 2 and more, those of a runner's foot that
# stands at 0.1 in the middle of a tenth of a second.
SLOW, SLOW_ANKLE = 0.6, 0.35
WINDOW = 0.025  # s before and after a frame over which speed is measured
NEAR = 0.35  # legs above the lowest place where a foot stands; steps of stairs are lower
SHORT, GAP = 0.05, 0.05  # s; a shorter contact is none, and a shorter gap neither
STAYS = 0.05  # legs, by which a point may move away from its mean while it stands; a slow slide goes on
BLEND = 0.15  # s before and after a contact in which a foot goes over to where it is held
FLAT = 0.4  # sine of the tilt up to which a foot that stands is laid flat
PIVOT = 0.3  # rad, by which a foot may turn on the floor before that is taken for a pivot
LEVEL = 0.06  # legs, within which places where feet stand are one floor


class Contact(NamedTuple):
    """Frames in which the toes of a foot stand, and the part of them in which the whole foot does."""

    first: int
    end: int  # the one after the last
    flat_first: int
    flat_end: int  # not after the first if the foot is never flat


def find_contacts(toes: np.ndarray, ankles: np.ndarray, times: np.ndarray, leg: float) -> list[Contact]:
    """Return when a foot stands, from the positions (n_frames, 3) of a point at the toes and of the ankle, m.

    Times (n_frames,) are in s; a leg's length makes speeds of small people those of large ones.
    """
    slow_toes = _speeds(toes, times) < SLOW * leg
    slow_ankle = _speeds(ankles, times) < SLOW_ANKLE * leg
    heights = toes[:, 2]
    if slow_toes.any():
        slow_toes &= heights < np.percentile(heights[slow_toes], 5) + NEAR * leg
    found = []
    for first, end in _phases(slow_toes, times):
        for start, stop in _stays(toes[first:end], STAYS * leg):
            start, stop = first + start, first + stop
            if times[stop - 1] - times[start] < SHORT:
                continue
            flat = max(
                _phases(slow_ankle[start:stop], times[start:stop]),
                key=lambda phase: phase[1] - phase[0],
                default=(0, 0),
            )
            found.append(Contact(start, stop, start + flat[0], start + flat[1]))
    return found


def _speeds(points: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Return the speeds (n_frames,) of a point, m/s, over a window around each frame."""
    n = len(points)
    if n < 2:
        return np.zeros(n)
    k = max(1, round(WINDOW / float(np.median(np.diff(times)))))
    before, after = np.maximum(np.arange(n) - k, 0), np.minimum(np.arange(n) + k, n - 1)
    return np.linalg.norm(points[after] - points[before], axis=1) / (times[after] - times[before])


def _phases(stands: np.ndarray, times: np.ndarray) -> list[tuple[int, int]]:
    """Return the first frame, and the one after the last, of times in which a point is slow; short gaps are none."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], stands.astype(np.int8), [0]]))).reshape(-1, 2).tolist()
    merged: list[list[int]] = []
    for first, end in edges:
        if merged and times[first] - times[merged[-1][1] - 1] < GAP:
            merged[-1][1] = end
        else:
            merged.append([first, end])
    return [(first, end) for first, end in merged if times[end - 1] - times[first] >= SHORT]


def _stays(points: np.ndarray, away: float) -> list[tuple[int, int]]:
    """Return the parts of a slow movement in which a point stays within a distance of its mean."""
    parts, first = [], 0
    while first < len(points):
        sums = np.cumsum(points[first:], axis=0)
        means = sums / np.arange(1, len(sums) + 1)[:, None]
        left = np.linalg.norm(points[first:] - means, axis=1) > away
        end = first + int(left.argmax()) if left.any() else len(points)
        parts.append((first, end))
        first = end
    return parts


def find_floor(heights: np.ndarray) -> float:
    """Return the height of the floor from those of the places where feet stand: their median, the lowest if uneven."""
    low = float(np.min(heights))
    return float(np.median(heights[heights < low + LEVEL]))


def hold_foot(
    ankles: np.ndarray,
    frames: np.ndarray,
    tip: np.ndarray,
    heel: np.ndarray,
    contacts: list[Contact],
    times: np.ndarray,
    leg: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the positions of the ankle (n_frames, 3) and the axes of the foot with the foot held while it stands.

    Frames (n_frames, 3, 3) have the axes forward, left and up in their columns; tip and heel (3,) are the ends of the
    sole from the ankle in these. The floor is at zero. The third array (n_frames,) is how much the foot is held, from 0
    to 1.
    """
    n = len(ankles)
    yaws = np.unwrap(np.arctan2(frames[:, 1, 0], frames[:, 0, 0]))
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
    frames = _orthonormal((1.0 - flat)[:, None, None] * frames + flat[:, None, None] * level)
    standing = [(contact.first, contact.end) for contact in contacts]
    stands = blend_between(standing, [np.ones(end - first) for first, end in standing], times)
    frames[:, 2, 0] -= stands * np.maximum(
        frames[:, 2, 0], 0.0
    )  # on its toes a foot has the heel up, not below the floor
    frames = _orthonormal(frames)
    tips = ankles + frames @ tip
    moves = []
    for contact in contacts:
        part = slice(contact.first, contact.end)
        is_flat = contact.flat_end > contact.flat_first
        best = slice(contact.flat_first, contact.flat_end) if is_flat else part
        place = np.median(tips[best], axis=0)
        if abs(place[2]) < LEVEL * leg:
            place[2] = 0.0
        moves.append(place - tips[part])
    moved = blend_between(standing, moves, times, 3)
    ankles = ankles + moved
    lowest = np.minimum((ankles + frames @ tip)[:, 2], (ankles + frames @ heel)[:, 2])
    ankles[:, 2] += np.maximum(-lowest, 0.0)
    return ankles, frames, stands


def _orthonormal(frames: np.ndarray) -> np.ndarray:
    """Return the axes (n, 3, 3) that are nearly these and at right angles, the first one kept."""
    x = frames[:, :, 0] / np.linalg.norm(frames[:, :, 0], axis=1, keepdims=True)
    z = np.cross(x, frames[:, :, 1])
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=2)


def blend_between(
    phases: list[tuple[int, int]], values: list[np.ndarray], times: np.ndarray, width: int = 0
) -> np.ndarray:
    """Return values (n, ...) that are given in some phases, and go to zero, or to those of the next phase, between."""
    n = len(times)
    out = np.zeros((n, width) if width else n)
    for i, ((first, end), here) in enumerate(zip(phases, values, strict=True)):
        out[first:end] = here
        following = phases[i + 1][0] if i + 1 < len(phases) else n
        before = phases[i - 1][1] if i else 0
        for gap, edge, value in (
            (slice(end, following), times[end - 1], here[-1]),
            (slice(before, first), times[first], here[0]),
        ):
            if gap.stop <= gap.start:
                continue
            between = i + 1 < len(phases) if gap.start == end else i > 0
            span = times[min(gap.stop, n - 1)] - times[max(gap.start - 1, 0)]
            length = min(BLEND, span) if between else BLEND
            x = np.clip(np.abs(times[gap] - edge) / length, 0.0, 1.0)
            share = 1.0 - x * x * (3.0 - 2.0 * x)
            out[gap] += share[:, None] * value if width else share * value
    return out
