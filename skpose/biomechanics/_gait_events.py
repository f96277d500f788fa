"""Gait events: when the feet come down on the floor and leave it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.ndimage import gaussian_filter1d, median_filter
from scipy.signal import butter, find_peaks, sosfiltfilt

from skpose._utils.typing import DataFrame
from skpose._utils.validation import check_kind
from skpose._utils.warnings import warn
from skpose.biomechanics._segments import find_person, find_shown, require
from skpose.io import C3DQuantity
from skpose.kinematics._anatomy import SIDES
from skpose.kinematics._ground import runs
from skpose.motions._phases import LONGEST_GAP
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._rest import degrees_between
from skpose.skeleton._upright import axes_with_up_last, describe_up, find_up

# --- feet -------------------------------------------------------------------------------------------------------------
# Feet and pelvis of a motion in the world: their joints, positions, velocities and heading. Positions are rotated so
# that the last axis points up, by a cyclic exchange of axes, which keeps left and right.


PARTS = ("hip", "ankle", "toe")
MARKS = tuple(f"{side}_{part}" for side in SIDES for part in PARTS)
LEAST_RATE = 25.0  # Hz; the contact of a running foot then has some six frames
CUTOFF = 10.0  # Hz, of the low-pass filter
HEADING = 0.25  # s, standard deviation of the weights in the mean velocity, the direction of travel
LEGS = (0.2, 1.5)  # m, from hip to ankle, shortest and longest
# Largest movement of the pelvis between two frames, and the error of a frame. Sprinters reach 12 m/s, figure skaters
# 2,050°/s. The fastest of 235 recordings of CMU and HDM05 has 4.4 m/s and 670°/s, except CMU 03_02, which jumps.
FASTEST, ERROR = 12.0, 0.01  # m/s, m
FASTEST_TURN, ERROR_OF_TURN = 2200.0, 5.0  # °/s, °
STILL = 1e-6  # m, largest movement of a root at rest


class Feet(NamedTuple):
    """Pelvis and feet over time, up last; the two sides are left and right."""

    step: float  # s, from frame to frame
    seen: np.ndarray  # (2, n) whether hips, ankle and toe are seen, short gaps included
    pelvis: np.ndarray  # (n, 3) m, amid the hips
    travel: np.ndarray  # (n, 2) m/s, velocity of the pelvis along the floor, averaged over about a step
    facing: np.ndarray  # (n, 2) unit vectors along the floor, ahead of the pelvis
    ankles: np.ndarray  # (2, n, 3) m
    toes: np.ndarray  # (2, n, 3) m
    leg: float  # m, from hip to ankle where the leg is longest


def find_feet(skeleton: Skeleton, joints: Mapping[str, str] | None) -> dict[str, str]:
    """The names of the joints at hips, ankles and toes, as given or as found."""
    found = find_person(skeleton, joints, [mark for mark in MARKS if not mark.endswith("toe")]).joints
    for side in SIDES:  # the toe markers of gait laboratories are where the toes begin; toe tips are noisy
        if f"{side}_toe" not in (joints or {}) and f"{side}_ball" in found:
            found[f"{side}_toe"] = found[f"{side}_ball"]
    require(found, MARKS)
    return {mark: skeleton.joint_names[found[mark]] for mark in MARKS}


def check_recording(motion: Motion) -> None:
    """Refuse motions that cannot show gait, such as those without movement of the root."""
    check_kind(motion, Motion, "motion", "gait needs positions of the root and a frame rate")
    if motion.frame_rate < LEAST_RATE or len(motion) < 2:
        got = f"{len(motion)} frames at {motion.frame_rate:g} Hz"
        raise ValueError(f"gait events need a stride at {LEAST_RATE:g} Hz or more, before resampling, got {got}")
    if (np.ptp(motion.root_positions, axis=0) <= STILL).all():
        raise ValueError(
            "gait needs root_positions, but they are constant: on a treadmill add the movement of the belt"
        )
    if (found := find_up(motion, motion.up)) != motion.up:
        raise ValueError(
            f"motion.up is {motion.up!r}, but {describe_up(found)}: use dataclasses.replace(motion, up=...)"
        )


def feet_of(motion: Motion, joints: Mapping[str, str]) -> Feet:
    """Pelvis and feet in the world, low-pass filtered; a row for each frame from the first to the last."""
    columns = [motion.skeleton.joint_names.index(joints[mark]) for mark in MARKS]
    here, shown = motion.positions()[:, columns].swapaxes(0, 1), find_shown(motion, columns)
    both = [MARKS.index(f"{side}_hip") for side in SIDES]
    hips = shown[:, both].all(axis=1)
    rows = motion.frame_numbers - motion.frame_numbers[0]
    every, seen = np.arange(rows[-1] + 1), np.zeros((len(SIDES), rows[-1] + 1), dtype=bool)
    for side, known in enumerate(seen):
        known[rows] = hips & shown[:, [MARKS.index(f"{SIDES[side]}_{part}") for part in PARTS]].all(axis=1)
        for first, end in runs(~known):
            if first > 0 and end < len(known) and end - first <= LONGEST_GAP * motion.frame_rate:
                known[first:end] = True
    if not seen.any():
        raise ValueError("gait events need hips and feet, but no frame shows all of them")
    marks = [
        [np.interp(every, rows[known], x[known]) for x in mark.T] if known.any() else np.full((3, len(every)), np.nan)
        for mark, known in zip(here[..., axes_with_up_last(motion.up)], shown.T, strict=True)
    ]
    feet = feet_at(np.array(marks).transpose(0, 2, 1), seen, motion.frame_rate)
    metre = 1.0
    if not LEGS[0] <= feet.leg <= LEGS[1]:
        metre = feet.leg  # a person's is nearly one
        warn(f"legs of {feet.leg:.3g} m are not a person's, so lengths are not in metres: read the file with scale=")
    _check_jumps(here[both] / metre, motion, np.flatnonzero(hips))
    return feet


def _check_jumps(hips: np.ndarray, motion: Motion, shown: np.ndarray) -> None:
    """Refuse motions whose pelvis, between hips at (2, n, 3), jumps between shown frames: two recordings in one."""
    hips = _without_spikes(hips[:, shown])
    seconds = np.diff(motion.frame_numbers[shown]) / motion.frame_rate
    metres = np.linalg.norm(np.diff(hips.mean(axis=0), axis=0), axis=1)
    across = hips[1] - hips[0]
    degrees = degrees_between(across[:-1], across[1:])
    for steps, unit, limit, error in ((metres, " m", FASTEST, ERROR), (degrees, "°", FASTEST_TURN, ERROR_OF_TURN)):
        over = steps - limit * seconds
        if over.max(initial=0.0) > error:
            most = int(over.argmax())
            cut = f"use motion[:{shown[most] + 1}] and motion[{shown[most + 1]}:]"
            raise ValueError(f"the pelvis jumps by {steps[most]:.3g}{unit} after frame {shown[most]}: {cut}")


def _without_spikes(positions: np.ndarray) -> np.ndarray:
    """The median of each frame of (n_points, n, 3) and its two neighbours.

    At the ends the third value is extrapolated from the next two (J. W. Tukey, "Exploratory data analysis", 1977): a
    low-pass filter would take a spike in the first or last frame for a movement.
    """
    n = positions.shape[1]
    before, after = (
        3.0 * positions.take([near], axis=1, mode="clip") - 2.0 * positions.take([far], axis=1, mode="clip")
        for near, far in ((1, 2), (n - 2, n - 3))
    )
    return np.asarray(median_filter(np.concatenate([before, positions, after], axis=1), size=(1, 3, 1))[:, 1:-1])


def feet_at(positions: np.ndarray, seen: np.ndarray, rate: float) -> Feet:
    """Pelvis and feet from the positions (6, n, 3) of `MARKS`, up last, and where each foot is seen, (2, n)."""
    positions = _without_spikes(positions)
    low_pass = butter(2, CUTOFF, fs=rate, output="sos")
    positions = sosfiltfilt(low_pass, positions, axis=1, padlen=min(9, positions.shape[1] - 1))
    left_hip, left_ankle, left_toe, right_hip, right_ankle, right_toe = positions
    pelvis = (left_hip + right_hip) / 2.0
    travel = gaussian_filter1d(np.gradient(pelvis[:, :2], 1.0 / rate, axis=0), HEADING * rate, axis=0, mode="nearest")
    to_right = (right_hip - left_hip)[:, :2]
    facing = np.stack([-to_right[:, 1], to_right[:, 0]], axis=1)
    facing /= np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), 1e-12)
    legs = [np.linalg.norm(hip - ankle, axis=1) for hip, ankle in ((left_hip, left_ankle), (right_hip, right_ankle))]
    return Feet(
        1.0 / rate,
        seen,
        pelvis,
        travel,
        facing,
        np.stack([left_ankle, right_ankle]),
        np.stack([left_toe, right_toe]),
        float(np.nanmax(legs)),
    )


# --- steps ------------------------------------------------------------------------------------------------------------
# Contacts of the feet with the floor and strides, from positions with up last.
#
# A foot is farthest ahead of the pelvis about when it comes down, and farthest behind when it lifts off (Zeni et
# al.). In between it stands: from the first to the last moment at which the ankle is slower than half the speed of
# travel, or the front of the foot slower than 0.8 of it (Bonci et al.). A runner's foot is that slow in the air too,
# so the slow part must also be about as low as at its slowest moment.


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
    known = [(side, *run) for side, seen in enumerate(feet.seen) for run in runs(seen)]
    for side, run in [(side, slice(first, end)) for side, first, end in known if end - first > 3]:
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
    first = int(before[-1]) + 1 if len(before) else 0
    last = int(after[0]) - 1 if len(after) else len(unrest) - 1
    contact = first - (1.0 - unrest[first]) / (unrest[first - 1] - unrest[first]) if len(before) else np.nan
    off = last + (1.0 - unrest[last]) / (unrest[last + 1] - unrest[last]) if len(after) else np.nan
    rows = slice(first, last + 1)
    still = speeds[0][rows] <= np.median(speeds[0][rows])
    slide = float(np.median(np.minimum(*speeds)[rows]))
    return Stance(side, start + contact, start + off, ankle[rows][still].mean(axis=0), slide)


def stances_at(feet: Feet, side: int, contacts: list[float], offs: list[float]) -> list[Stance]:
    """The stances of a foot between known contacts and offs, rows; NaN for the ends that are not known."""
    order = sorted([*((row, True) for row in contacts), *((row, False) for row in offs)])
    found = []
    for i, (row, is_contact) in enumerate(order):
        if is_contact or not i or not order[i - 1][1]:
            off = next((other for other, begins in order[i : i + 2] if not begins), np.nan)
            ends = (row if is_contact else np.nan), off
            first, last = (int(np.clip(np.nan_to_num(end, nan=row), 0, len(feet.pelvis) - 1)) for end in ends)
            found.append(Stance(side, *ends, np.median(feet.ankles[side, first : last + 1], axis=0), 0.0))
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
    duration, along = share * (last.contact - first.contact), share * (last.position - first.position)[:2]
    seconds, length = duration * feet.step, float(np.linalg.norm(along))
    slide = max((one.slide for one in contacts if np.isfinite(one.off)), default=0.0)
    rows = slice(int(first.contact), int(last.contact) + 1)
    height = (feet.pelvis[rows, 2] - np.fmin.reduce(feet.ankles[:, rows, 2])).min()
    facing = feet.facing[rows].mean(axis=0)
    angle = np.degrees(np.arctan2(abs(facing[0] * along[1] - facing[1] * along[0]), facing @ along))
    faults = (
        (
            not STRIDE_TIMES[0] <= seconds <= STRIDE_TIMES[1],
            f"a foot comes down again after {seconds:.2g} s, and strides take 0.3 to 3 s",
        ),
        (
            not PHASES[0] <= (other.contact - first.contact) / duration <= PHASES[1],
            "left and right foot come down nearly together, as in jumps",
        ),
        (
            length < max(least_speed_of(feet) * seconds, FORWARD * feet.leg),
            f"the feet move by {length:.2g} m only, as in steps on the spot",
        ),
        (slide > SLIDES, f"the feet slide at {slide:.2g} of the speed of travel while they should stand"),
        (
            height < UPRIGHT * feet.leg,
            "the pelvis is less than half the length of the legs above the feet, as in sitting",
        ),
        (angle > SIDEWAYS, f"the feet move {angle:.0f}° away from the direction that the pelvis faces"),
    )
    return next((why for is_fault, why in faults if is_fault), "")


# --- events -----------------------------------------------------------------------------------------------------------


CONTACT, OFF = "foot contact", "foot off"
# Names of events, such as "left foot contact", "Right Foot Strike", "LHS" and "RTO".
EVENT = re.compile(r"(l|r).*?(?:(strike|contact|down|on\b|hs\b|ic\b)|off|to\b)", re.IGNORECASE)


@dataclass(frozen=True, eq=False, repr=False)
class GaitEvents:
    """The events of walking and running, as `gait_events` finds them, in order of time.

    Attributes
    ----------
    feet : ndarray of shape (n_events,) of str
        "left" or "right".
    kinds : ndarray of shape (n_events,) of str
        "foot contact" (heel strike, where the heel comes down first) or "foot off" (toe-off).
    times : ndarray of shape (n_events,)
        Time of each event, s, as of ``motion.times``; between frames by linear interpolation.
    frames : ndarray of shape (n_events,) of int
        The nearest frame, as ``motion[frame]`` takes it.
    positions : ndarray of shape (n_events, 3)
        Position of the ankle in the world while the foot stands after a contact, or before a foot off, m.
    strides : ndarray of shape (n_strides, 3) of int
        Numbers of three events: contact of one foot, of the other foot, and of the first one again.
    joints : dict of str to str
        The names of the joints that are hips, ankles and toes.
    frame_rate : float
        Frame rate of the motion, Hz.
    up : {"x", "y", "z"}
        The axis of the world that points up.
    reason : str
        The reason if events are missing.
    motion_times : ndarray of shape (n_frames,)
        Times of the frames of the motion, s.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Motion
    >>> from skpose.biomechanics import gait_events
    >>> from skpose.datasets import humanoid
    >>> still = Motion(humanoid(), np.zeros((60, 42)), 60, np.linspace([0, 0, 0], [0, 0, 0.05], 60))
    >>> gait_events(still).reason.partition(",")[0]
    'the pelvis travels at most 0.051 m/s'
    """

    feet: np.ndarray
    kinds: np.ndarray
    times: np.ndarray
    frames: np.ndarray
    positions: np.ndarray
    strides: np.ndarray
    joints: dict[str, str]
    frame_rate: float
    up: str
    reason: str
    motion_times: np.ndarray

    def __len__(self) -> int:
        return len(self.times)

    def __repr__(self) -> str:
        if not len(self):
            return f"GaitEvents(none: {self.reason})"
        counts = [np.count_nonzero(self.kinds == kind) for kind in (CONTACT, OFF)]
        span = f"{self.times[0]:.2f} to {self.times[-1]:.2f} s at {self.frame_rate:g} Hz"
        return f"GaitEvents({counts[0]} contacts, {counts[1]} offs, {len(self.strides)} strides, {span}, {self.up} up)"

    def to_pandas(self) -> DataFrame:
        """Convert the events to a pandas DataFrame, one row for each.

        Returns
        -------
        pandas.DataFrame
            Columns "foot", "event", "frame" and "time [s]".

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        import pandas

        return pandas.DataFrame({"foot": self.feet, "event": self.kinds, "frame": self.frames, "time [s]": self.times})


def gait_events(
    motion: Motion, *, joints: Mapping[str, str] | None = None, events: Mapping[str, Any] | None = None
) -> GaitEvents:
    r"""Find when the feet come down and leave the floor in walking and running.

    A foot comes down about when it is farthest ahead of the pelvis in the direction of travel, and leaves the floor
    when it is farthest behind [1]_. In between it stands, from the first to the last moment at which the ankle is
    slower than 0.5 of the speed of travel or the front of the foot slower than 0.8 of it [2]_. The slow part must also
    be lower than 0.05 of the length of the leg above its floor, the median height in the slower half of that stance:
    runners' feet are slow in the air, too.

    Direction and speed of travel of the middle between the hips along the floor are averaged over about a step
    (Gaussian weights, standard deviation 0.25 s), so that turns are followed. Positions are filtered before: the median
    of three frames, against spikes, then a low-pass (Butterworth, second order, 10 Hz, forwards and backwards).

    Parameters
    ----------
    motion : Motion
        Walking or running, with the positions of the root, at 25 Hz or more.
    joints : mapping of str to str, default=None
        Joints by landmark, as in `joint_angles`. Hips, ankles and toes are used, as toes the points where they begin
        unless a toe is given.
    events : mapping of str to array-like, default=None
        Known events, times in s, as of ``motion.times``, or numbers of frames: "left foot contact", "left foot off" and
        the same of the right, also under the names of C3D files, such as "Left Foot Strike". The result of
        `skpose.io.load_c3d_quantities` can be passed as it is, for all frames of the file. None detects them.

    Returns
    -------
    GaitEvents
        The events of all strides, or of a single step; the first has a swing before it. Without gait there are none,
        and `GaitEvents.reason` states why. Detected events lack those of a foot that is not seen for more
        than 0.1 s.

    Raises
    ------
    TypeError
        If `motion` is not a Motion.
    ValueError
        If the root does not move, the frame rate is below 25 Hz, people stand along another axis than `Motion.up`, or
        joints or names of events are unknown. If the pelvis jumps between frames, by more than 12 m/s and 1 cm or
        2,200°/s and 5°: another recording begins.

    See Also
    --------
    gait_parameters : Cadence, lengths of steps, share of stance.

    Notes
    -----
    A stride is three contacts: of one foot, of the other, of the first again. Strides must take 0.3 to 3 s, with the
    other foot's contact within 30 to 70 %; the foot must move by more than 0.35 of the length of the leg and faster
    than :math:`0.06 \sqrt{g \cdot leg}` (0.18 m/s), at most 45° from the direction that the pelvis faces, and the
    pelvis must stay above half the length of the leg. So jumps, squats, steps on the spot, walking sideways or
    backwards and lying down are not gait, and shuffling with shorter strides is not found.

    The height of 0.05 legs was chosen on one person of CMU and on two walks over force plates. Of these and two other
    people, eight contacts and eight foot offs at 60 to 240 Hz, contacts were 2 ms late ± 24 ms and foot offs 9 ms early
    ± 14 ms (mean and standard deviation of the people's means). The rule of [1]_ alone gives −30 ± 17 and 11 ± 17 ms.
    In walking the height has little effect; the stance of runners, which was not compared with force plates, changes
    from 30 to 37 % as it goes from 0.03 to 0.06.

    References
    ----------
    .. [1] J. A. Zeni, J. G. Richards, J. S. Higginson, "Two simple methods for determining gait events during treadmill
       and overground walking using kinematic data", Gait & Posture 27(4), 2008,
       :doi:`10.1016/j.gaitpost.2007.07.007`.
    .. [2] T. Bonci et al., "An algorithm for accurate marker-based gait event detection in healthy and pathological
       populations during complex motor tasks", Frontiers in Bioengineering and Biotechnology 10, 2022,
       :doi:`10.3389/fbioe.2022.868928`.

    Examples
    --------
    A generated walk has no root. Here the lower foot stands still, which moves the person:

    >>> from dataclasses import replace
    >>> import numpy as np
    >>> from skpose import forward_kinematics
    >>> from skpose.biomechanics import gait_events
    >>> from skpose.datasets import make_gait
    >>> walk = make_gait(1, 1, activities=["walk"], duration=6, random_state=0)[0]
    >>> feet = [walk.skeleton.joint_names.index(name) for name in ("left_foot", "right_foot")]
    >>> balls = forward_kinematics(walk.angles, walk.skeleton)[:, feet]
    >>> lower = balls[:-1, :, 1].argmin(axis=1)
    >>> steps = -np.diff(balls, axis=0)[np.arange(len(lower)), lower]
    >>> walk = replace(walk, root_positions=np.concatenate([[[0, 0, 0]], np.cumsum(steps, axis=0)]))
    >>> events = gait_events(walk)
    >>> events.to_pandas().head(4).round(2)
        foot         event  frame  time [s]
    0  right  foot contact      2      0.03
    1   left      foot off      2      0.04
    2  right      foot off     37      0.62
    3   left  foot contact     38      0.64
    """
    check_recording(motion)
    names = find_feet(motion.skeleton, joints)
    feet = feet_of(motion, names)
    stances = find_stances(feet) if events is None else _stances_of(events, motion, feet)
    strides, used, reason = find_strides(feet, stances, events is not None)
    rows: list[tuple[float, int, str, int]] = [(stances[i].contact, stances[i].side, CONTACT, i) for i in used]
    for i, stance in enumerate(stances):
        following = [j for j in range(i + 1, len(stances)) if stances[j].side == stance.side]
        if np.isfinite(stance.off) and (i in used or (following and following[0] in used)):
            rows.append((stance.off, stance.side, OFF, i))
    rows.sort()
    number = {row[3]: k for k, row in enumerate(rows) if row[2] == CONTACT}
    times = (motion.frame_numbers[0] + np.array([row[0] for row in rows])) / motion.frame_rate
    positions = np.array([stances[row[3]].position for row in rows]).reshape(-1, 3)
    return GaitEvents(
        feet=np.array([SIDES[row[1]] for row in rows], dtype=np.str_),
        kinds=np.array([row[2] for row in rows], dtype=np.str_),
        times=times,
        frames=np.abs(motion.times - times[:, None]).argmin(axis=1).astype(np.int64),
        positions=positions[:, np.argsort(axes_with_up_last(motion.up))],
        strides=np.array([[number[i] for i in stride] for stride in strides], dtype=np.int64).reshape(-1, 3),
        joints=names,
        frame_rate=motion.frame_rate,
        up=motion.up,
        reason=reason,
        motion_times=motion.times,
    )


def _stances_of(events: Mapping[str, Any], motion: Motion, feet: Feet) -> list[Stance]:
    """The stances between events that the user gives, by times, s, or frames."""
    rows: dict[tuple[int, str], list[float]] = {(side, kind): [] for side in (0, 1) for kind in (CONTACT, OFF)}
    for name, given in events.items():
        values, is_own = (given.values, given.kind == "events") if isinstance(given, C3DQuantity) else (given, True)
        match = EVENT.match(name)
        if match and is_own:
            at = np.ravel(values)
            times = motion.times[at] if np.issubdtype(at.dtype, np.integer) else at
            side, kind = "lr".index(match[1].lower()), CONTACT if match[2] else OFF
            inside = np.abs(times - np.clip(times, motion.times[0], motion.times[-1])) * motion.frame_rate < 1.0
            rows[side, kind] += (times[inside] * motion.frame_rate - motion.frame_numbers[0]).tolist()
        elif not isinstance(given, C3DQuantity):
            raise ValueError(f"events must have names such as 'left foot contact', got {name!r}")
    return sorted(
        [one for side in (0, 1) for one in stances_at(feet, side, rows[side, CONTACT], rows[side, OFF])],
        key=Stance.start,
    )
