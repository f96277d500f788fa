"""The axis that points up in a file that does not say so, and whether the motion agrees with it."""

from dataclasses import replace
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._validation.options import check_choice
from skpose.io._source import Source
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import root_angles_of, root_orientations, rotations_of

Up = Literal["x", "y", "z", "-x", "-y", "-z"]
UPS = ("x", "y", "z", "-x", "-y", "-z")
# Half a turn that makes the axis that points down point up, as `Layout.keypoints` has it.
HALF_TURNS = {"-x": Rotation.from_rotvec([0.0, np.pi, 0.0]), "-y": Rotation.from_rotvec([np.pi, 0.0, 0.0])}
HALF_TURNS["-z"] = HALF_TURNS["-y"]
N_FRAMES = 32  # that are looked at, evenly spaced
NEARLY_ALL = 0.9  # of these
FLAT = 0.8  # height over the largest extent below which a pose does not stand along an axis; of a T-pose it is 0.9
HIGH, LOW = ("head",), ("foot", "toe", "ankle")  # parts of the names of joints
N_ENDS = 4  # joints without children from which a skeleton whose names say nothing is taken for that of a person


def check_up_of_file(up: str | None) -> None:
    """Refuse what is no direction of the world."""
    if up is not None:
        check_choice("up", up, UPS)


def stand(motion: Motion, up: str | None, source: Source, default: Literal["x", "y", "z"] = "y") -> Motion:
    """Return a motion with the axis that points up: the one that is stated, or else the usual one, with a warning.

    Where an axis points down the world is turned by half a turn: about x if y or z points down, about y if x does.
    """
    if up is None:
        if (found := _find_up(motion, default)) != default:
            source.warn(
                f"{default} is taken as the axis that points up, as is usual, but in nearly all frames the pose "
                f"stands along {found[-1]}{', head down' if len(found) > 1 else ''}: pass up={found!r}, or "
                f"up={default!r} if the person lies"
            )
        up = default
    if up in HALF_TURNS:
        turn = HALF_TURNS[up]
        angles, axes = motion.root_angles, motion.root_axes
        if len(motion):
            turned = turn * root_orientations(motion.root_angles, motion.root_axes)
            angles, axes = root_angles_of(turned, np.zeros(3), motion.root_axes)
        motion = replace(motion, root_positions=turn.apply(motion.root_positions), root_angles=angles, root_axes=axes)
    return replace(motion, up=up[-1])


def _find_up(motion: Motion, default: str) -> str:
    """Return the direction along which the poses of nearly all frames stand; the default where there is none."""
    frames = np.unique(np.linspace(0, len(motion) - 1, min(N_FRAMES, len(motion))).astype(int))
    names = ["", *(name.lower() for name in motion.skeleton.joint_names)]
    high, low = ([j for j, name in enumerate(names) if any(part in name for part in parts)] for parts in (HIGH, LOW))
    n_ends = len({*range(motion.skeleton.n_joints)} - {*motion.skeleton.parents.tolist()})
    if not len(frames) or not ((high and low) or n_ends >= N_ENDS):
        return default
    positions = _positions(motion, frames)
    if high and low:
        heights = positions[:, high].mean(axis=1) - positions[:, low].mean(axis=1)
    else:
        heights = np.ptp(positions, axis=1)  # the tallest axis, whichever end is up
    for i, axis in enumerate("xyz"):
        for sign in (1.0, -1.0):
            height, extent = sign * heights[:, i], np.abs(heights).max(axis=1)
            stands = (height == extent) & (extent > 0.0)
            if axis != default:
                stands &= np.abs(heights[:, "xyz".index(default)]) < FLAT * extent
            if stands.mean() >= NEARLY_ALL:
                return axis if sign > 0.0 else f"-{axis}"
    return default


def _positions(motion: Motion, frames: np.ndarray) -> np.ndarray:
    """Return the positions (n, n_joints + 1, 3) of the root and of the joints in some frames, relative to the root."""
    skeleton: Skeleton = motion.skeleton
    orientations = [root_orientations(motion.root_angles[frames], motion.root_axes)]
    positions = [np.zeros((len(frames), 3))]
    first = 0
    for bone, parent, rest in zip(skeleton.bones, skeleton.parents, skeleton.rest_rotations, strict=True):
        columns = motion.angles[frames, first : first + bone.n_dofs]
        first += bone.n_dofs
        own = orientations[parent + 1] * Rotation.from_matrix(rest)
        if bone.n_dofs:
            own = own * rotations_of(bone, columns)
        carrier = own if skeleton.offset_frame == "own" else orientations[parent + 1]
        positions.append(positions[parent + 1] + carrier.apply(bone.offset))
        orientations.append(own)
    return np.stack(positions, axis=1)
