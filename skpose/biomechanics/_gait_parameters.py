"""Spatio-temporal parameters of gait: cadence, speed, lengths and widths of steps, shares of stance."""

from dataclasses import dataclass

import numpy as np

from skpose._utils.typing import DataFrame
from skpose._utils.warnings import warn
from skpose.biomechanics._gait_events import OFF, GaitEvents, gait_events
from skpose.kinematics._anatomy import SIDES
from skpose.skeleton import Motion

UNITS = {
    "cadence": "steps/min",
    "speed": "m/s",
    "stride_time": "s",
    "stride_length": "m",
    "step_time": "s",
    "step_length": "m",
    "step_width": "m",
    "stance": "%",
    "double_support": "%",
}
# Largest steps per minute: elite sprinters take fewer than five a second, race walkers fewer than four.
FASTEST_WALK, FASTEST_RUN = 220.0, 300.0
# Step length over cadence, mm/(step/min): 5 to 7 in nearly all adults, in slow walks up to 10, in children less, as
# speeds of walking scale with the root of the length of legs, 0.9 m.
LEAST_RATIO, LARGEST_RATIO, LEG = 3.6, 10.0, 0.9


@dataclass(frozen=True, eq=False, repr=False)
class GaitParameters:
    """Spatio-temporal parameters of every stride, as `gait_parameters` finds them.

    A stride goes from a contact of a foot to the next contact of that foot, and is that foot's. Its step is the second
    half: from the contact of the other foot to its own. Lengths are along the floor.

    Attributes
    ----------
    feet : ndarray of shape (n_strides,) of str
        "left" or "right".
    starts : ndarray of shape (n_strides,)
        Time of the first contact, s.
    values : dict of str to ndarray of shape (n_strides,)
        By quantity; each is an attribute, too, such as ``parameters.cadence``:

        - "cadence": steps per minute, 120 over the stride time
        - "speed": stride length over stride time, m/s
        - "stride_time", "step_time": duration, s
        - "stride_length": distance between the two positions of the foot, m
        - "step_length": distance of the contact ahead of the other foot, along the line between these positions, m
        - "step_width": distance of the other foot from that line, m; negative where the feet cross
        - "stance": share of the stride with the foot on the floor, %
        - "double_support": share of the stride with both feet on the floor, %; 0 in running

        Shares are NaN where the beginning or end of a stance was not recorded.
    events : GaitEvents
        The events from which they are computed.

    Examples
    --------
    >>> from skpose.biomechanics import GaitParameters
    >>> list(GaitParameters.__dataclass_fields__)  # see gait_parameters
    ['feet', 'starts', 'values', 'events']
    """

    feet: np.ndarray
    starts: np.ndarray
    values: dict[str, np.ndarray]
    events: GaitEvents

    def __len__(self) -> int:
        return len(self.feet)

    def __getattr__(self, name: str) -> np.ndarray:
        if name not in UNITS:
            raise AttributeError(f"'GaitParameters' has no attribute {name!r}")
        return self.values[name]

    def __repr__(self) -> str:
        counts = " and ".join(f"{np.count_nonzero(self.feet == side)} {side}" for side in SIDES)
        shown = {"cadence": ".0f", "speed": ".2f", "step_length": ".2f", "stance": ".0f", "double_support": ".0f"}
        means = {name: np.ma.masked_invalid(self.values[name]).mean() for name in shown}
        words = [f"{name.replace('_', ' ')} {float(means[name]):{form}} {UNITS[name]}" for name, form in shown.items()]
        rate = f"{self.events.frame_rate:g} Hz, {self.events.up} up"
        return f"GaitParameters({counts} strides at {rate}: {', '.join(words)})"

    def to_pandas(self) -> DataFrame:
        """Convert the parameters to a pandas DataFrame, one row for each stride.

        Returns
        -------
        pandas.DataFrame
            Columns "foot" and "start [s]", and one for each quantity, with its unit in the name: "step_length [m]".

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        quantities = {f"{name} [{unit}]": self.values[name] for name, unit in UNITS.items()}
        import pandas

        return pandas.DataFrame({"foot": self.feet, "start [s]": self.starts, **quantities})


def gait_parameters(motion: Motion | GaitEvents) -> GaitParameters:
    """Measure cadence, speed, lengths and widths of steps, and shares of stance, of every stride.

    Lengths are measured between the positions of the ankles while the feet stand, along the floor, by the line between
    two positions of one foot [1]_, so that they are valid in turns and in every direction.

    Parameters
    ----------
    motion : Motion or GaitEvents
        Walking or running, see `gait_events`, or the events of it.

    Returns
    -------
    GaitParameters
        Of each stride. Mean, standard deviation and number: ``parameters.to_pandas().groupby("foot").agg(["mean",
        "std", "count"])``.

    Raises
    ------
    TypeError
        If `motion` is neither.
    ValueError
        If strides are missing, with the reason; see also `gait_events`.

    Warns
    -----
    UserWarning
        If cadence, in the median of the strides, is more than 300 steps/min, or 220 where the feet stand for more than
        half of the stride, as in walking: faster than elite sprinters [2]_ and race walkers [3]_, so the frame rate is
        wrong. Likewise if the walk ratio, step length over cadence [4]_, is more than 10 mm/(step/min), or less than
        3.6 with legs of 0.9 m: at half the frame rate it is twice as large, at any speed.

    See Also
    --------
    gait_events : The events and their assumptions.

    Notes
    -----
    An error of 20 ms in a contact or a foot off changes a share of stance by about 2 percentage points, and one of
    30 Hz frames is 33 ms; lengths and cadence depend less on it. Strides of the two feet overlap in time, so that their
    values are not independent.

    References
    ----------
    .. [1] F. Huxham, J. Gong, R. Baker, M. Morris, R. Iansek, "Defining spatial parameters for non-linear walking",
       Gait & Posture 23(2), 2006, :doi:`10.1016/j.gaitpost.2005.01.001`.
    .. [2] A. I. T. Salo, I. N. Bezodis, A. M. Batterham, D. G. Kerwin, "Elite sprinting: are athletes individually
       step-frequency or step-length reliant?", Medicine & Science in Sports & Exercise 43(6), 2011,
       :doi:`10.1249/MSS.0b013e318201f6f8`.
    .. [3] B. Hanley, A. Bissas, A. Drake, "Kinematic characteristics of elite men's and women's 20 km race walking and
       their variation during the race", Sports Biomechanics 10(2), 2011, :doi:`10.1080/14763141.2011.569566`.
    .. [4] N. Sekiya, H. Nagasaki, "Reproducibility of the walking patterns of normal young adults: test-retest
       reliability of the walk ratio (step-length/step-rate)", Gait & Posture 7(3), 1998,
       :doi:`10.1016/S0966-6362(98)00009-5`.

    Examples
    --------
    A generated walk has no root. Here the lower foot stands still, which moves the person:

    >>> from dataclasses import replace
    >>> import numpy as np
    >>> from skpose import forward_kinematics
    >>> from skpose.biomechanics import gait_parameters
    >>> from skpose.datasets import make_gait
    >>> walk = make_gait(1, 1, activities=["walk"], duration=6, random_state=0)[0]
    >>> feet = [walk.skeleton.joint_names.index(name) for name in ("left_foot", "right_foot")]
    >>> balls = forward_kinematics(walk.angles, walk.skeleton)[:, feet]
    >>> lower = balls[:-1, :, 1].argmin(axis=1)
    >>> steps = -np.diff(balls, axis=0)[np.arange(len(lower)), lower]
    >>> walk = replace(walk, root_positions=np.concatenate([[[0, 0, 0]], np.cumsum(steps, axis=0)]))
    >>> found = gait_parameters(walk)
    >>> found  # doctest: +NORMALIZE_WHITESPACE
    GaitParameters(4 left and 5 right strides at 60 Hz, y up: cadence 109 steps/min, speed 1.06 m/s, step length 0.58 m,
                   stance 50 %, double support 1 %)
    >>> found.to_pandas().groupby("foot")["step_length [m]"].mean().round(2).tolist()
    [0.6, 0.56]
    """
    found, doubt = measure_gait(motion)
    if doubt:
        warn(doubt)
    return found


def measure_gait(motion: Motion | GaitEvents) -> tuple[GaitParameters, str]:
    """The parameters, and why the frame rate is likely wrong."""
    events = motion if isinstance(motion, GaitEvents) else gait_events(motion)
    if not len(events.strides):
        raise ValueError(f"gait_parameters needs at least one stride, got none: {events.reason}")
    first, other, last = events.strides.T
    found = GaitParameters(events.feet[first], events.times[first], _measure(events, first, other, last), events)
    return found, _doubt_of_rate(found, motion)


def _doubt_of_rate(found: GaitParameters, motion: Motion | GaitEvents) -> str:
    """Why a frame rate is likely wrong: a cadence that is impossible, or unlikely with these steps and legs."""
    leg = LEG
    if isinstance(motion, Motion) and len(motion):
        up = "xyz".index(motion.up)
        leg = float(np.median(motion.root_positions[:, up]) - np.median(found.events.positions[:, up]))
    cadence, stance = float(np.median(found.values["cadence"])), np.ma.masked_invalid(found.values["stance"])
    walks, rate = bool(np.ma.median(stance) > 50.0), found.events.frame_rate
    ratio = 1e3 * float(np.median(found.values["step_length"])) / cadence
    is_short = leg > 0.0 and ratio * (LEG / leg) ** 1.5 < LEAST_RATIO
    if cadence > (FASTEST_WALK if walks else FASTEST_RUN):
        return f"cadence is {cadence:.0f} steps/min, faster than people: is the frame rate of {rate:g} Hz right?"
    if is_short or ratio > LARGEST_RATIO:
        return (
            f"step length over cadence is {ratio:.1f} mm/(step/min), in people 5 to 7: "
            f"is the frame rate of {rate:g} Hz {'twice' if is_short else 'half'} the true one?"
        )
    return ""


def _measure(events: GaitEvents, first: np.ndarray, other: np.ndarray, last: np.ndarray) -> dict[str, np.ndarray]:
    """All quantities of strides, from the numbers of their three contacts."""
    start, between, end = events.times[[first, other, last]]
    duration = end - start
    up = np.eye(3)["xyz".index(events.up)]
    flat = events.positions - np.outer(events.positions @ up, up)
    along = flat[last] - flat[first]
    length = np.linalg.norm(along, axis=1)
    along /= length[:, None]
    to_other = np.where(events.feet[first] == "left", -1.0, 1.0)[:, None] * np.cross(up, along)
    off, other_off = _offs_between(events, first, start, end), _offs_between(events, other, start - duration, between)
    both = np.maximum(other_off - start, 0.0) + np.maximum(off - between, 0.0)
    return {
        "cadence": 120.0 / duration,
        "speed": length / duration,
        "stride_time": duration,
        "stride_length": length,
        "step_time": end - between,
        "step_length": ((flat[last] - flat[other]) * along).sum(axis=1),
        "step_width": ((flat[other] - flat[first]) * to_other).sum(axis=1),
        "stance": 100.0 * (off - start) / duration,
        "double_support": 100.0 * both / duration,
    }


def _offs_between(events: GaitEvents, contacts: np.ndarray, starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """The last times between others at which the feet of contacts leave the floor; NaN if unknown."""
    inside = (events.feet == events.feet[contacts][:, None]) & (events.kinds == OFF)
    inside &= (events.times > starts[:, None]) & (events.times < ends[:, None])
    return np.fmax.reduce(np.where(inside, events.times, np.nan), axis=1)
