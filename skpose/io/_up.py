"""The axis that points up in a file that does not say so, and whether the motion agrees with it."""

from dataclasses import replace
from typing import Any, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._validation.options import check_choice
from skpose.io._source import Source
from skpose.skeleton import Motion
from skpose.skeleton._shared import complaint_of_up, root_angles_of, root_orientations

Up = Literal["x", "y", "z", "-x", "-y", "-z"]
UPS = ("x", "y", "z", "-x", "-y", "-z")
# Half a turn that makes the axis that points down point up, as `Layout.keypoints` has it.
HALF_TURNS = {"-x": Rotation.from_rotvec([0.0, np.pi, 0.0]), "-y": Rotation.from_rotvec([np.pi, 0.0, 0.0])}
HALF_TURNS["-z"] = HALF_TURNS["-y"]


def check_up_of_file(up: str | None) -> None:
    """Refuse what is no direction of the world."""
    if up is not None:
        check_choice("up", up, UPS)


def stand(motion: Motion, up: str | None, source: Source, default: Literal["x", "y", "z"] = "y") -> Motion:
    """Return a motion with the axis that points up: the one that is stated, or else the usual one, with a warning.

    Where an axis points down the world is turned by half a turn: about x if y or z points down, about y if x does.
    """
    if up is None:
        if complaint := complaint_of_up(motion, default):
            source.warn(complaint)
        up = default
    if up in HALF_TURNS:
        turn = HALF_TURNS[up]
        angles, axes = motion.root_angles, motion.root_axes
        if len(motion):
            turned = turn * root_orientations(motion.root_angles, motion.root_axes)
            angles, axes = root_angles_of(turned, np.zeros(3), motion.root_axes)
        motion = replace(motion, root_positions=turn.apply(motion.root_positions), root_angles=angles, root_axes=axes)
    axis: Any = up[-1]
    return replace(motion, up=axis)
