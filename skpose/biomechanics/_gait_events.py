"""Gait events: when the feet come down on the floor and leave it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from skpose.biomechanics._feet import (
    Feet,
    Stance,
    check_recording,
    feet_of,
    find_feet,
    find_stances,
    find_strides,
    stances_at,
)
from skpose.io import C3DQuantity
from skpose.kinematics._anatomy import SIDES
from skpose.skeleton import Motion
from skpose.skeleton._upright import axes_with_up_last

if TYPE_CHECKING:
    import pandas

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

    def to_pandas(self) -> "pandas.DataFrame":
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

        columns = {"foot": self.feet, "event": self.kinds, "frame": self.frames, "time [s]": self.times}
        return pandas.DataFrame(columns)


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
