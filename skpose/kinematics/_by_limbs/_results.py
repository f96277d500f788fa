"""The motion that came of retargeting by limbs, and how near it came to where places shall be."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d
from scipy.spatial.transform import Rotation

from skpose._warnings import warn
from skpose.kinematics._by_limbs._contacts import Held
from skpose.kinematics._by_limbs._person import to_vertical
from skpose.kinematics._by_limbs._places import Place, Stance, middle_of, sole_of, toe_of
from skpose.kinematics._by_limbs._robots import HEEL, TIP
from skpose.kinematics._by_limbs._solver import Solution, Targets
from skpose.kinematics._landmarks import SIDES, path_up
from skpose.kinematics._rigs import ANKLE, HIP
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import continuous_root_angles

# Heading first, so that no heading is near to where Euler angles jump for a root whose z axis is up.
ROOT_AXES = {"x": "XZY", "y": "YZX", "z": "ZYX"}
AT_LIMIT = 1e-9  # rad
NEARBY = 0.025  # s before and after, within which the person is as fast
FASTER = 1.0  # m/s more than the person's, from which a report names it; feet that go to where they are held have less
RAISED = 1e-3  # m, from which a report names by how much the target is raised
AROUND = 0.1  # s before and after a frame, in which it is raised for that


class Aim(NamedTuple):
    """The positions of places to which the poses of the target shall be near."""

    skeleton: Skeleton  # the target with the limits that are enforced
    rest: np.ndarray  # (n_dofs,) its pose at rest
    bent: np.ndarray  # (n_dofs,) that with knees and elbows bent, from which the poses are searched
    rolls: list[int]  # its joints that stay there, though they carry places
    targets: Targets
    legs: dict[str, Held]
    paths: dict[str, np.ndarray]  # (n_frames, 3) of the person's toes, by side, and hips, in the size of the target
    is_on_base: bool  # whether its own joints move it over the floor, and its root stays where it is


class Fitted(NamedTuple):
    """A motion on the target, and how near it came."""

    motion: Motion
    feet: np.ndarray  # distances of places on the feet from where they shall be, m
    hands: np.ndarray  # those of wrists and hands
    slides: np.ndarray  # (n_contacts,) by how much the toes move at most while they stand, m
    raised: float  # by how much the target is raised at most where a corner of a sole would be below the floor, m
    feet_faster: float  # by how much toes, and the pelvis, are faster than the person's at most, m/s
    pelvis_faster: float
    at_limits: int  # angles that are at a limit in some frame
    n_left: int  # frames that did not converge
    moving: list[int]  # joints

    def in_words(self) -> str:
        """Return in words how near the motion came."""
        parts = [
            f"{name} {_millimetres(off)}" for name, off in (("soles", self.feet), ("hands", self.hands)) if off.size
        ]
        if len(self.slides):
            parts.append(f"feet stand {len(self.slides)} times and slide by {_round(self.slides.max())} mm at most")
        elif self.feet.size:
            parts.append("feet stand nowhere")
        if self.raised >= RAISED:
            parts.append(f"raised by up to {_round(self.raised)} mm where soles would be below the floor")
        faster = (("toes", self.feet_faster), ("the pelvis", self.pelvis_faster))
        named = [f"{name} by up to {speed:.2g} m/s" for name, speed in faster if speed >= FASTER]
        if named:
            parts.append(f"faster than the person's: {' and '.join(named)}")
        if self.at_limits:
            parts.append(f"{self.at_limits} angles reach their limits")
        if self.n_left:
            parts.append(f"{self.n_left} of {len(self.motion)} frames did not converge")
        return "".join(f", {part}" for part in parts)


def _round(metres: float) -> str:
    return f"{float(f'{1e3 * metres:.2g}'):g}"


def _millimetres(distances: np.ndarray) -> str:
    """Return in words how far off places are."""
    return f"{_round(distances.mean())} mm off (95 %: {_round(float(np.percentile(distances, 95)))})"


def collect(motion: Motion, skeleton: Skeleton, theirs: Stance, ours: Stance, final: Solution, aim: Aim) -> Fitted:
    """Return the motion of the whole skeleton in the world, and how near it came."""
    places = {side: [_sole_place(ours, side, corner) for corner in sole_of(ours, side).corners()] for side in aim.legs}
    soles = {side: final.positions(skeleton, corners) for side, corners in places.items()}
    raised = _raise_above_floor([sole[:, :, 2].min(axis=1) for sole in soles.values()], motion.times)
    final = final._replace(origins=final.origins + raised)
    angles = np.tile(aim.rest, (len(motion), 1))
    names = final.skeleton.dof_names
    columns = [skeleton.dof_names.index(name) for name in names]
    angles[:, columns] = final.poses
    vertical = to_vertical(motion.up)
    roots, origins = final.roots, final.origins
    if aim.is_on_base:  # exactly
        roots, origins = np.broadcast_to(np.eye(3), roots.shape), np.zeros_like(origins)
    root_angles, root_axes = continuous_root_angles(Rotation.from_matrix(vertical.T @ roots), ROOT_AXES[motion.up])
    result = replace(
        motion,
        skeleton=skeleton,
        angles=angles,
        root_positions=origins @ vertical,
        root_angles=root_angles,
        root_axes=root_axes,
        seen=_seen_of(motion, skeleton, theirs, ours),
    )
    feet = [i for side in SIDES for i in aim.targets.groups.get(f"{side} foot", [])]
    slides, feet_faster, pelvis_faster = [], 0.0, np.zeros(1)
    for foot, leg in aim.legs.items():
        tips = soles[foot][:, 2:].mean(axis=1) + raised
        feet_faster = max(feet_faster, _faster(tips, aim.paths[foot], motion.times).max(initial=0.0))
        for contact in leg.contacts:
            stood = tips[contact.first : contact.end]
            slides.append(np.linalg.norm(stood - stood.mean(axis=0), axis=1).max())
    if aim.legs:
        pelvis = final.positions(skeleton, [Place(ours.pelvis, middle_of(ours, HIP))])[:, 0]
        pelvis_faster = _faster(pelvis, aim.paths["pelvis"], motion.times)
        _warn_of_throws(pelvis_faster)
    rolled = {name for joint in aim.rolls for name in skeleton.bones[joint].dof_names}
    at_limits = 0
    if aim.skeleton.limits is not None:
        lower, upper = np.array(aim.skeleton.limits)[columns].T
        reach = ((final.poses <= lower + AT_LIMIT) | (final.poses >= upper - AT_LIMIT)) & (lower < upper)
        at_limits = int(reach.any(axis=0).sum())
    moving = [j for j, bone in enumerate(skeleton.bones) if bone.dofs and set(bone.dof_names) <= set(names) - rolled]
    return Fitted(
        result,
        final.residuals[:, feet],
        final.residuals[:, aim.targets.groups.get("hands", [])],
        np.array(slides),
        float(raised.max()),
        feet_faster,
        float(pelvis_faster.max(initial=0.0)),
        at_limits,
        int((~final.converged).sum()),
        moving,
    )


def _sole_place(ours: Stance, side: str, corner: np.ndarray) -> Place:
    """Return the place of a corner (3,) of a sole, from the ankle in the axes of the foot."""
    joint, axes = ours.feet[side]
    return Place(joint, ours.places[f"{side}_{ANKLE}"].at_zero + axes @ corner)


def _raise_above_floor(lowest: list[np.ndarray], times: np.ndarray) -> np.ndarray:
    """Return by how much (n_frames, 3) to raise soles, of these lowest heights (n_frames,), so that none is below zero.

    It goes up and down in some frames: the mean of what all frames around need, each with the most around it.
    """
    raised = np.zeros((len(times), 3))
    if lowest and len(times) > 1:
        size = 2 * max(1, round(AROUND / float(np.median(np.diff(times))))) + 1
        below = np.maximum(-np.min(lowest, axis=0), 0.0)
        raised[:, 2] = uniform_filter1d(maximum_filter1d(below, size, mode="nearest"), size, mode="nearest")
    elif lowest:
        raised[:, 2] = np.maximum(-np.min(lowest, axis=0), 0.0)
    return raised


def _warn_of_throws(faster: np.ndarray) -> None:
    """Warn if the pelvis moves as the person's does not; there its pose is not the person's."""
    thrown = np.flatnonzero(faster >= FASTER)
    if len(thrown):
        i = int(faster.argmax())
        warn(
            f"the pelvis of the given skeleton is faster than the person's by up to {faster[i]:.2g} m/s, from frame "
            f"{i} to {i + 1} ({len(thrown)} such frames): there the recording asks for what the skeleton cannot do, "
            "most often by an error of an ankle, and poses around these frames are far from the person's. Correct the "
            "recording, or leave these frames out"
        )


def _faster(ours: np.ndarray, theirs: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Return by how much (n_frames - 1,) a path (n_frames, 3) is faster than another shortly before or after, m/s."""
    if len(times) < 2:
        return np.zeros(0)
    steps = np.diff(times)
    speeds, known = (np.linalg.norm(np.diff(path, axis=0), axis=1) / steps for path in (ours, theirs))
    around = 2 * int(np.ceil(NEARBY / float(np.median(steps)))) + 1
    return np.asarray(speeds - maximum_filter1d(known, around, mode="nearest"))


def _seen_of(motion: Motion, skeleton: Skeleton, theirs: Stance, ours: Stance) -> np.ndarray | None:
    """Return in which frames each joint of a skeleton was seen: where those landmarks were between which it is."""
    if motion.seen is None:
        return None
    marks: dict[int, set[int]] = {}  # joints of the person that are counterparts of those at a joint of the target
    for mark, place in ours.places.items():
        side, _, name = mark.partition("_")
        counterpart = toe_of(theirs, side) if name in (HEEL, TIP) else mark
        if counterpart in theirs.places:
            marks.setdefault(place.joint, set()).add(theirs.places[counterpart].joint)
    needed: list[set[int]] = [set() for _ in range(skeleton.n_joints)]
    for joint, here in marks.items():
        needed[joint] |= here
        between: list[int] = []
        for above in path_up(skeleton, joint)[1:]:
            if above in marks:
                for j in between:
                    needed[j] |= marks[above]
                break
            between.append(above)
            needed[above] |= here
    seen = np.zeros((len(motion), skeleton.n_joints), bool)
    for j, joints in enumerate(needed):
        if joints:
            seen[:, j] = motion.seen[:, sorted(joints)].all(axis=1)
    return seen
