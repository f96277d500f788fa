"""Findings, and the table of their kinds with all thresholds.

Thresholds are of a person with legs of 0.9 m. Those of jumps, noise and feet are chosen on recordings of five people by
the rule of `benchmarks/faults.py`, which tests them on three others. A measure of `_measures` gives the size of a fault
at each frame. Frames above the limit form an event if they are at most `APART` from each other, or consecutive where it
has to last.
"""

from typing import NamedTuple

APART = 0.25  # s
SEVERITIES = "error", "warning", "note"


class Finding(NamedTuple):
    """One fault that `check_motion` has found.

    Attributes
    ----------
    severity : {"error", "warning", "note"}
        "error": something is wrong in the motion or its header; "warning": its quality is low; "note": a convention
        that some programs stumble over.
    kind : str
        Kind of the finding, such as "jump".
    motion : int
        Index of the motion.
    frames : tuple of two ints
        The first frame and the one after the last, as of a slice of the motion.
    joints : tuple of str
        The joints or angles that are worst; empty for all.
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
        where = f"motion {self.motion}, frames {self.frames[0]} to {self.frames[1] - 1}"
        return f"{self.severity}: {self.kind}, {where}: {self.what}; {self.remedy}"


class Kind(NamedTuple):
    """A kind of finding in one motion; a comment in `KINDS` says what the limit is of."""

    severity: str
    limit: float  # of the measure
    unit: str
    what: str  # with the size, the first frame, the number n of frames, joint and note
    remedy: str
    seconds: float = 0.0  # that an event takes at least
    least: int = 1  # frames above the limit in an event


KINDS = {
    "units": Kind(  # 0.3 to 5 m, and legs of 0.2 to 1.5 m, as in `load_motion`
        "error", 0.0, "m", "the skeleton is {size:.3g} m from end to end at angle zero{note}",
        "read the file with scale= metres per unit",
    ),
    "up axis": Kind(  # heads are above feet in nine frames of ten, as in `load_motion`
        "error", 0.0, "", "{note}", "read the file with up=, or use dataclasses.replace(motion, up=...)",
    ),
    "frame rate": Kind(  # the walk ratio of `gait_parameters`
        "error", 0.0, "Hz", "{note}", "read the file with frame_rate=, or dataclasses.replace(motion, frame_rate=...)",
    ),
    "missing frames": Kind(  # any
        "warning", 0.0, "frames", "{size:.0f} frames are missing after frame {first}",
        "cut the motion there, or fill the gap",
    ),
    "repeated frames": Kind(  # a movement of less than 1e-9 m
        "error", 0.0, "frames", "{n} frames repeat the one before", "drop them, or resample from the true frame rate",
    ),
    "interpolated frames": Kind(  # velocities of the root, or of all angles, change by less than 0.3 %
        "warning", 0.0, "frames", "{n} frames lie on straight lines between their neighbours",
        "leave them out, or resample to the true frame rate", least=5,
    ),
    "jump": Kind(  # by which a step differs from those around it; a jerk of 1,500 m/s³ explains less
        "error", 0.05, "m", "{joint} jumps by {size:.2g} m after frame {first}",
        "interpolate the frames, or cut the motion there",
    ),
    "noise": Kind(  # without what movements at 6 Hz would add
        "warning", 0.4, "mm", "{joint} has {size:.2g} mm of noise beyond movement",
        "filter it, such as by a low-pass at 10 Hz",
    ),
    "angle flips": Kind(  # 1 rad; turns have 2π
        "note", 1.0, "rad", "{joint} changes by {size:.3g} rad without a rotation, {n} times",
        "motion.unwrap() or motion.to_rotvec() before angles are filtered, averaged or learnt",
    ),
    "calibration pose": Kind(  # arms within 15° of the line of the shoulders, or all angles zero
        "warning", 0.0, "s", "{n} frames at an end hold a T-pose or the pose zero", "cut them",
    ),
    "floor": Kind(  # beyond the height of the joint above the sole
        "warning", 0.05, "m", "feet stand {size:.2g} m {note} 0", "move the root, or tell programs the floor's height",
    ),
    "floating": Kind(  # slower than 0.25 m/s, as at the top of a jump for 0.05 s
        "warning", 0.06, "m", "the lowest joint stands still {size:.2g} m above the floor, afloat or on a step",
        "lower the root there, or leave the part out", seconds=0.1,
    ),
    "sinking": Kind(  # ankle or ball, for 0.1 s
        "warning", 0.08, "m", "a foot is {size:.2g} m below the floor, where it stands most", "raise the root there",
        seconds=0.1,
    ),
    "skating": Kind(  # the slowest point within 3 cm of the floor, for 0.2 s
        "warning", 0.3, "m/s", "no foot stands: both slide, or are in the air, at {size:.2g} m/s",
        "check the unit, the axes and the scale of the root; keep the feet in place by inverse kinematics",
        seconds=0.2,
    ),
    "sides exchanged": Kind(  # of the frames
        "error", 0.5, "", "the toes point behind the line of the hips from left to right",
        "exchange left and right in the names of the joints",
    ),
    "joint limits": Kind(  # knees of people do not
        "warning", 25.0, "°", "{joint} bends towards the toes by {size:.0f}°",
        "check the axes of the joint, the retargeting, or the fit to markers",
    ),
}  # fmt: skip
