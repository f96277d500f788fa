"""Cycles of a movement: where they are, and joint angles over their phases."""

from typing import Any, NamedTuple

import numpy as np

from skpose.biomechanics._gait_events import GaitEvents
from skpose.kinematics._anatomy import SIDES
from skpose.motions import Repetitions
from skpose.motions._phases import PHASES, over_phases

MIDDLE = ""  # the side of the angles of the trunk


class Cycles(NamedTuple):
    """The cycles of a movement."""

    spans: dict[str, np.ndarray]  # by side, (n_cycles, 2) first and last time, s
    curves: dict[str, np.ndarray]  # by angle, (n_cycles, 101) at `PHASES`
    noun: str
    of_middle: str  # the side whose cycles the trunk has; "" if all are the same


def split_name(angle: str) -> tuple[str, str]:
    """The name of an angle without its side, and the side."""
    stem, _, side = angle.rpartition("_")
    return (stem, side) if side in SIDES else (angle, MIDDLE)


def find_cycles(angles: Any, cycles: Any) -> Cycles:
    """The cycles of a recording, as given, and its `JointAngles` in them."""
    times = cycles.motion_times if isinstance(cycles, GaitEvents) else getattr(cycles, "times", None)
    if times is not None and (len(times) != len(angles) or not np.allclose(times, angles.times, rtol=0.0, atol=1e-6)):
        raise ValueError("cycles must be of the recording that angles are of, got another one")
    noun, of_middle, headings = "cycle", MIDDLE, np.zeros(1)
    if isinstance(cycles, GaitEvents):
        noun, (of_middle, spans, headings) = "stride", _find_strides(angles.forward, cycles)
    else:
        if isinstance(cycles, Repetitions):
            cycles, noun = np.stack([cycles.starts, cycles.stops], axis=1), "repetition"
        frames = np.asarray(cycles)
        if frames.shape[1:] != (2,) or not np.issubdtype(frames.dtype, np.integer):
            raise ValueError("cycles must be GaitEvents, Repetitions, or whole numbers of shape (n_cycles, 2)")
        if not len(frames) or frames.min() < 0 or frames.max() > len(angles) or (np.diff(frames) < 2).any():
            raise ValueError(f"cycles must be parts of at least two of the {len(angles)} frames of angles")
        spans = dict.fromkeys((*SIDES, MIDDLE), angles.times[frames - [0, 1]])
    zeros = dict.fromkeys(angles.names, np.zeros(1)) | {"pelvis_rotation": headings}
    curves = {
        name: over_phases(angles.times, angles[name], spans[split_name(name)[1]], zeros[name]) for name in angles.names
    }
    return Cycles(spans, curves, noun, of_middle)


def _find_strides(forward: np.ndarray | None, events: GaitEvents) -> tuple[str, dict[str, np.ndarray], np.ndarray]:
    """The foot with more strides, the strides of each foot, and the directions of those of the middle, degrees."""
    if not len(events.strides):
        raise ValueError(f"cycles has no strides: {events.reason}")
    strides = {side: events.strides[events.feet[events.strides[:, 0]] == side][:, [0, 2]] for side in SIDES}
    of_middle = max(strides, key=lambda side: len(strides[side]))  # the left, of equal ones
    strides[MIDDLE] = strides[of_middle]
    forward = np.zeros(3) if forward is None else forward
    along = np.diff(events.positions[strides[MIDDLE]], axis=1)[:, 0]
    headings = np.arctan2(along @ np.cross(np.eye(3)["xyz".index(events.up)], forward), along @ forward)
    return of_middle, {side: events.times[pairs] for side, pairs in strides.items()}, np.degrees(headings)


def tabulate_cycles(angles: Any, cycles: Any) -> Any:
    """A dataframe with a row for each angle, cycle and per cent."""
    import pandas

    found, tables = find_cycles(angles, cycles), []
    for name, curves in found.curves.items():
        stem, side = split_name(name)
        columns = {
            "angle": stem,
            "side": side or "middle",
            "cycle": np.repeat(np.arange(len(curves)), len(PHASES)),
            "start [s]": np.repeat(found.spans[side][:, 0], len(PHASES)),
            "phase [%]": np.tile(PHASES, len(curves)),
            "value [deg]": curves.ravel(),
        }
        tables.append(pandas.DataFrame(columns))
    return pandas.concat(tables, ignore_index=True)
