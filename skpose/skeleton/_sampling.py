"""Frames of motions: some of one motion, those of several, at another rate."""

from collections.abc import Iterable
from dataclasses import replace
from operator import index
from typing import TYPE_CHECKING

import numpy as np

from skpose._validation.motions import check_frame_rate
from skpose.skeleton._interpolation import interpolate, linear
from skpose.skeleton._skeleton import mismatch

if TYPE_CHECKING:
    from skpose.skeleton._motion import Motion

# What to do about motions that differ in what one motion has once.
REMEDIES = {
    "frame_rate": "use resample first",
    "root_axes": 'with_root("tilt") makes the orientation a part of the poses of both, and leaves one axis to the root',
    "up": 'their worlds are not the same; if they are, dataclasses.replace(motion, up="y") states so',
}


def frames_of(motion: "Motion", frames: int | np.integer | slice) -> "Motion":
    """Return some frames: ``motion[10:50]``, ``motion[::2]`` at half the rate, ``motion[3]`` as one frame."""
    step = 1
    if isinstance(frames, slice):
        step = abs(frames.indices(len(motion))[2])
    else:
        try:
            frame = index("" if isinstance(frames, bool) else frames)  # type: ignore[arg-type]
        except TypeError:
            raise TypeError(
                "a motion is indexed by a frame or by a slice, such as motion[10:50]: frames of a mask or an array "
                "are not evenly spaced in time; motion.angles[...] selects poses"
            ) from None
        if not -len(motion) <= frame < len(motion):
            raise IndexError(f"the motion has {len(motion)} frames, and no frame {frame}")
        frame %= len(motion)
        frames = slice(frame, frame + 1)
    numbers = motion.frame_numbers[frames]
    numbers = np.abs(numbers - numbers[:1])
    if (numbers % step).any():
        raise ValueError(
            f"every frame out of {step} is no motion, as frames are missing between them: use resample, or slices "
            "of the frames that follow each other, see frame_numbers"
        )
    return replace(
        motion,
        angles=motion.angles[frames],
        frame_rate=motion.frame_rate / step,
        root_positions=motion.root_positions[frames],
        root_angles=motion.root_angles[frames],
        frame_numbers=numbers // step,
    )


def concatenate(motions: Iterable["Motion"]) -> "Motion":
    """Return motions one after another, as one.

    Nothing is moved: where one motion ends elsewhere than the next begins, there is a jump.

    Parameters
    ----------
    motions : iterable of Motion
        At least one; with the same skeleton, frame rate, root axes and axis that points up.

    Returns
    -------
    Motion
        With the frames of all.

    Raises
    ------
    ValueError
        If the motions differ in one of these; the message states in which.
    """
    motions = list(motions)
    if not motions:
        raise ValueError("concatenate needs at least one motion, got none")
    first = motions[0]
    for i, motion in enumerate(motions[1:], start=1):
        if motion.skeleton != first.skeleton:
            difference = mismatch(first.skeleton, motion.skeleton) or "bones differ: use retarget first"
            raise ValueError(f"motions[{i}] has another skeleton than motions[0]: {difference}")
        for name, remedy in REMEDIES.items():
            if getattr(motion, name) != getattr(first, name):
                values = f"{getattr(motion, name)!r}, but motions[0] {getattr(first, name)!r}"
                raise ValueError(f"motions[{i}] has {name} {values}: {remedy}")
    angles, positions, rotations = (
        np.concatenate([getattr(motion, name) for motion in motions])
        for name in ("angles", "root_positions", "root_angles")
    )
    ends = np.cumsum([0] + [1 + motion.frame_numbers[-1] if len(motion) else 0 for motion in motions])
    numbers = np.concatenate([end + motion.frame_numbers for end, motion in zip(ends, motions, strict=False)])
    return replace(first, angles=angles, root_positions=positions, root_angles=rotations, frame_numbers=numbers)


def resample(motion: "Motion", frame_rate: float) -> "Motion":
    """Return the motion at another frame rate, from its first frame to the last time within it.

    Between two frames a joint with three dofs, and a root with three axes, rotates by the smallest angle (slerp).
    Other angles change linearly along their difference wrapped to [−π, π], so that a file's jump by 360° is no
    rotation. Where the new times coincide with frames, as from 120 to 12 Hz, these are taken as they are. Where
    frames are missing none are made up: new times between a frame and one that does not directly follow it are
    missing too. There is no low-pass filter: a lower rate aliases movements that are faster than it, as in the
    paper.

    Parameters
    ----------
    frame_rate : float
        The new rate, Hz.

    Returns
    -------
    Motion
        Of the same skeleton.
    """
    check_frame_rate(frame_rate)
    numbers, step = motion.frame_numbers, motion.frame_rate / frame_rate
    # 1e-9 allows for rounding: a rate that divides the old one exactly keeps the last frame.
    first, last = (numbers[0], numbers[-1]) if len(motion) else (0, -1)
    new = np.arange(int(np.ceil(first / step - 1e-9)), int(np.floor(last / step + 1e-9)) + 1)
    at = new * step  # in numbers of the old frames
    near = np.rint(at)
    at = np.where(np.abs(at - near) < 1e-9, near, at)
    before = np.searchsorted(numbers, at, side="right") - 1
    part = at - numbers[before]
    known = (part == 0.0) | np.isin(numbers[before] + 1, numbers)
    return _at(motion, (before + part)[known], frame_rate, new[known])


def _at(motion: "Motion", rows: np.ndarray, frame_rate: float, frame_numbers: np.ndarray) -> "Motion":
    """Return the motion at rows, which need not be whole."""
    before = np.minimum(rows.astype(np.intp), max(len(motion) - 1, 0))
    after, part = np.minimum(before + 1, len(motion) - 1), (rows - before)[:, None]
    positions = motion.root_positions
    return replace(
        motion,
        angles=interpolate(motion.skeleton.bones, motion.angles, rows),
        frame_rate=frame_rate,
        root_positions=linear(positions[before], positions[after], part, 0.0),
        root_angles=interpolate((motion._root,), motion.root_angles, rows),
        frame_numbers=frame_numbers,
    )
