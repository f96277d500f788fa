"""Conversion of a motion to another rig by orientations: bones point in the world where their counterparts do.

Let d be the direction of a bone at angle zero, and G the rotation, since angle zero, of the joint that carries it, in
the world: the bone points along G·d. A constant rotation A of each joint takes the directions of the target at zero to
those of the source, A·d_target = d_source. So the bones of the target point where those of the source do if its joints
have rotated by G_target = G_source·A. If the source bends between the two ends of a bone, as a trunk of three joints
does for a trunk of two, the rotation that is left to fit the direction follows, frame by frame.

A joint carries the bones that rotate with it: those that end at it (offsets in its "own" axes) or start at it, and
those of joints without dofs that follow it; the root carries bones likewise. The fit is the shortest rotation for a
joint that carries one direction, and least squares (Kabsch) for several.

A bone's counterpart is the line between the counterparts of its ends, or, where its near end has none, the bone that
ends at the counterpart of its far end. In people pelvis, chest, head and feet are aligned by their axes instead, see
`_body`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.validation import list_names
from skpose._utils.warnings import warn
from skpose.kinematics._anatomy import COLLAR, HIP, LEG, SHOULDER, SIDES, TOE, Anatomy, pair_of, path_up
from skpose.kinematics._body import Poses, find_bends, find_segments, flexion_axis
from skpose.kinematics._counterparts import Counterparts
from skpose.kinematics._floor import STRAIGHT, Steps, find_steps, move_ankle
from skpose.kinematics._forward import joint_positions
from skpose.skeleton import Bone, Motion, Skeleton
from skpose.skeleton._bone import with_columns
from skpose.skeleton._rest import (
    LARGEST_DIFFERENCE,
    NO_DIRECTION,
    NOWHERE,
    ROOT,
    axes_at_zero,
    degrees_between,
    directions_at_zero,
    find_carriers,
    unit,
)
from skpose.skeleton._root import root_angles_of, root_orientations
from skpose.skeleton._rotations import (
    TWO_PI,
    columns_of,
    continuous_columns,
    fit_columns,
    rotations_of,
    shortest_rotations,
)

ROUNDING = 1e-6  # rad
# Least squares fit a second direction if it has this weight: bones bent by up to 16° have one direction, since a few
# degrees, as of hips from noisy keypoints, say nothing about the rotation about their line.
LINE = 2e-2
REMEDY = 'method="positions" comes close by inverse kinematics'
MIDDLE = -2  # the middle between the hips, in people: roots are higher up in some rigs
ONE_LINE = np.cos(np.radians(30.0))  # bones of a limb, or of the trunk, up to this angle apart have one direction


# --- lines ------------------------------------------------------------------------------------------------------------
# The lines of two skeletons that are made parallel: bones that are counterparts, or lines in their place.


class Line(NamedTuple):
    """Two joints of the target, and the two of the source between which the direction is, or `ROOT` or `MIDDLE`."""

    start: int
    end: int
    source_start: int
    source_end: int


class Lines(NamedTuple):
    """The lines that are made parallel."""

    of_bones: dict[int, Line]  # for the joint at which each bone of the target ends
    hips: tuple[tuple[int, int] | None, tuple[int, int] | None]  # of source and target
    directions: np.ndarray  # (n_joints, 3) of the lines of bones in the target at angle zero; zeros if there is none
    positions: np.ndarray  # (n_joints + 2, 3) of the target at angle zero, see `with_root`


def find_lines(source: Skeleton, target: Skeleton, found: Counterparts) -> Lines:
    """Find the lines of counterparts."""
    there, people = found.there, found.people if found.by_landmarks else None
    lines, carriers = {}, find_carriers(target)
    lengths = np.linalg.norm(target.offsets, axis=1)
    for joint in np.flatnonzero(there >= 0).tolist():
        start = int(target.parents[joint])
        while start >= 0 and there[start] < 0 and lengths[start] == 0.0:  # the same point as the joint before
            start = int(target.parents[start])
        end = int(there[joint])
        source_start = ROOT if start < 0 else int(there[start]) if there[start] >= 0 else int(source.parents[end])
        lines[joint] = Line(int(target.parents[joint]), joint, source_start, end)
    directions = directions_at_zero(target)
    hips = (None, None) if people is None else (pair_of(people[0].joints, HIP), pair_of(people[1].joints, HIP))
    positions = with_root(joint_positions(np.zeros((1, target.n_dofs)), target), hips[1])[0]
    if people is None:
        return Lines(lines, hips, directions, positions)
    _keep_straight(lines, target, there, people[1], positions)
    _adapt_girdles(lines, source, target, there, people[1].joints)
    for joint in people[1].trunk if None not in hips else ():  # the trunk begins in the middle between the hips
        line = lines.get(joint)
        if line is not None and line.source_start == ROOT:
            start = MIDDLE if line.start == ROOT and carriers[joint] == ROOT else line.start
            lines[joint] = line._replace(start=start, source_start=MIDDLE)
    for joint, line in lines.items():
        if line.start != int(target.parents[joint]) or line.end != joint:
            directions[joint] = unit(positions[line.end] - positions[line.start])
    return Lines(lines, hips, directions, positions)


def with_root(positions: np.ndarray, hips: tuple[int, int] | None) -> np.ndarray:
    """Append the middle between the hips and the root, `MIDDLE` and `ROOT`, to positions (n_frames, n_joints, 3)."""
    root = np.zeros((len(positions), 1, 3))
    middle = positions[:, list(hips)].mean(axis=1, keepdims=True) if hips is not None else root
    return np.concatenate([positions, middle, root], axis=1)


def _keep_straight(
    lines: dict[int, Line], target: Skeleton, there: np.ndarray, person: Anatomy, positions: np.ndarray
) -> None:
    """Give all bones between two joints with counterparts one direction, if they are on one line at angle zero.

    So a forearm of two bones is as straight as one of one bone.
    """
    parents = target.parents
    for end in sorted({*person.joints.values(), *person.trunk, *person.neck}):
        if there[end] < 0:
            continue
        path = [end]
        while (above := int(parents[path[-1]])) >= 0 and there[above] < 0:
            path.append(above)
        along = unit(positions[end] - positions[above])
        bones = unit(positions[path] - positions[parents[path]])
        if len(path) > 1 and ((bones @ along > ONE_LINE) | ~bones.any(axis=1)).all():
            source_start = ROOT if above < 0 else int(there[above])
            for joint in path:
                lines[joint] = Line(int(parents[joint]), joint, source_start, int(there[end]))


def _adapt_girdles(
    lines: dict[int, Line], source: Skeleton, target: Skeleton, there: np.ndarray, ours: Mapping[str, int]
) -> None:
    """Bones of the pelvis that can move stay at rest, and collarbones that end at shoulders follow collarbones."""
    for joint in pair_of(ours, HIP) or ():
        lines.pop(joint, None)
    for side, joint in zip(SIDES, pair_of(ours, SHOULDER) or (), strict=False):
        if there[joint] >= 0 and int(target.parents[joint]) != ours.get(f"{side}_{COLLAR}"):
            other = int(there[joint])
            lines[joint] = Line(int(target.parents[joint]), joint, int(source.parents[other]), other)


# --- conversion -------------------------------------------------------------------------------------------------------


def by_orientations(
    motion: Motion,
    target: Skeleton,
    found: Counterparts,
    factor: float,
    on_feet: bool,
    shown: Motion | None,
) -> tuple[Motion, float, list[int], float | None]:
    """Convert a motion by lines that are made parallel.

    Positions of the root are multiplied by a factor. In people the middle between the hips keeps its place, as roots
    are above it in some rigs. `shown` is a motion of the target that shows how its knees and elbows bend.

    The result is the motion, the largest angle between a line and its counterpart, degrees, the joints that move, and
    how far standing feet are from their places, m.
    """
    there = found.there
    seen = None if motion.seen is None else motion.seen[:, there] & (there >= 0)
    result = replace(motion, skeleton=target, angles=np.zeros((len(motion), target.n_dofs)), seen=seen)
    if slides := [bone.name for bone in (*motion.skeleton.bones, *target.bones) if bone.is_slide]:
        raise ValueError(f"directions of bones do not show how far {slides[0]!r} slides: {REMEDY}")
    if not len(motion):
        return result, 0.0, list(range(target.n_joints)), None
    poses, lines = poses_of(motion), find_lines(motion.skeleton, target, found)
    positions, followed = with_root(poses.positions, lines.hips[0]), poses.since_zero
    bones = _bones(motion.skeleton, positions, target, lines)
    leaders = _leaders(motion.skeleton, target, there, bones)
    bends = _bends(motion.skeleton, target, found.people, leaders, poses, shown)
    fixed = _fixed_turns(motion.skeleton, target, found.people)
    leaders |= {joint: leader for joint, (leader, _) in fixed.items()}
    turns = _turns(target, bones, bends, {joint: turn for joint, (_, turn) in fixed.items()})
    rotations, worst = {}, 0.0
    for joint, leader in leaders.items():
        if joint in fixed:
            rotations[joint] = followed[leader] * turns[joint]
            continue
        rotations[joint], apart = _fit_joint(followed[leader] * turns[joint], joint, bones)
        worst = max(worst, float(apart.max(initial=0.0)))
        if worst > LARGEST_DIFFERENCE:
            frame, i = np.unravel_index(apart.argmax(), apart.shape)
            bone = f"bone {target.joint_names[bones.carried[joint][i]]!r} is {worst:.0f}° apart from its counterpart"
            raise ValueError(f"{bone} after the best fit, in frame {frame}: {REMEDY}")
    positions_at_root = _positions(target, rotations, lines.positions)
    root_positions = factor * motion.root_positions
    if None not in lines.hips:  # the middle between the hips
        theirs, ours = positions[:, MIDDLE], positions_at_root[:, lines.hips[1]].mean(axis=1)
        if (shift := factor * theirs - ours).any() and np.abs(shift).max() > ROUNDING * np.abs(theirs).max():
            root_positions = root_positions + shift
    off = None
    joints = {} if found.people is None else found.people[1].joints
    sides = [side for side in SIDES if all(f"{side}_{mark}" in joints for mark in LEG)]  # of legs that move
    if on_feet and sides:
        both = motion.positions(), positions_at_root + root_positions[:, None]
        steps = find_steps(motion, both, found.landmarks, factor, sides)
        root_positions = root_positions + steps.root
        off, turned = _plant_feet(target, found.landmarks[1], sides, rotations, positions_at_root, steps, bends)
        worst = max(worst, turned)
    angles, missed = _angles(motion, target, found, rotations, bones)
    result = replace(result, angles=angles, root_positions=root_positions)
    if (followed[ROOT].inv() * rotations[ROOT]).magnitude().max() > 1e-12:  # more than rounding
        root_angles, axes = root_angles_of(rotations[ROOT], motion.root_angles, motion.root_axes)
        result = replace(result, root_angles=root_angles, root_axes=axes)
    return result, max(worst, missed), list(leaders), off


def _positions(target: Skeleton, rotations: dict[int, Rotation], zero: np.ndarray) -> np.ndarray:
    """The positions (n_frames, n_joints, 3) of joints that have rotated so since angle zero, from the root."""
    found, turned = np.zeros((len(rotations[ROOT]), target.n_joints + 1, 3)), dict(rotations)  # the last is the root
    for j, parent in enumerate(target.parents.tolist()):
        turned.setdefault(j, turned[parent])
        carrier = j if target.offset_frame == "own" else parent
        found[:, j] = found[:, parent] + turned[carrier].apply(zero[j] - zero[parent])
    return found[:, :-1]


def _plant_feet(
    target: Skeleton,
    person: Anatomy,
    sides: Sequence[str],
    rotations: dict[int, Rotation],
    positions: np.ndarray,
    steps: Steps,
    bends: dict[int, tuple[np.ndarray, np.ndarray]],
) -> tuple[float | None, float]:
    """Rotate thighs and shanks so that feet stand.

    The result is the largest distance of a standing foot from its place, m, None if none stands, and the largest angle
    by which a thigh or a shank is rotated, degrees.
    """
    carriers, missed, angles = find_carriers(target), [], [0.0]
    left = positions[:, person.joints[f"left_{HIP}"]] - positions[:, person.joints[f"right_{HIP}"]]
    for i, side in enumerate(sides):
        hip, knee, ankle = leg = [person.joints[f"{side}_{mark}"] for mark in LEG]
        path = path_up(target, ankle)
        thigh, shank = (
            {carriers[j] for j in part} for part in (path[path.index(knee) : path.index(hip)], path[: path.index(knee)])
        )
        u, v = positions[:, knee] - positions[:, hip], positions[:, ankle] - positions[:, knee]
        if (known := bends.get(carriers[knee])) is not None:
            axis = rotations[carriers[knee]].apply(known[0])
            axis *= np.sign((np.cross(u, v) * axis).sum(axis=1, keepdims=True))
        else:
            bent = np.linalg.norm(np.cross(unit(u), unit(v)), axis=1, keepdims=True) > STRAIGHT
            axis = np.where(bent, np.cross(u, v), left)
        turns = move_ankle(positions[:, leg], steps.feet[:, i], axis)
        moved = [turn.apply(bone) for turn, bone in zip(turns, (u, v), strict=True)]
        missed.append(steps.feet[:, i] - (moved[0] - u) - (moved[1] - v))
        for bone, after in zip((u, v), moved, strict=True):
            angles.append(float(degrees_between(unit(bone), unit(after)).max()))
        for turn, joints in zip(turns, (thigh, shank), strict=True):
            for joint in joints & rotations.keys():
                rotations[joint] = turn * rotations[joint]
    off = np.linalg.norm(missed, axis=2).T[steps.stands]
    return (float(off.max()) if len(off) else None), max(angles)


class _Bones(NamedTuple):
    """The bones of the target whose directions have counterparts, or lines in their place; frame 0 is angle zero."""

    directions: np.ndarray  # (n_joints, 3) at angle zero, in the axes of the root
    ends: dict[int, int]  # the joint of the source at which each counterpart ends
    wished: np.ndarray  # (n_frames + 1, n_joints, 3) directions of the counterparts in the world
    carried: dict[int, list[int]]  # bones that rotate with the root and with each joint with dofs


AT_ZERO, IN_MOTION = slice(0, 1), slice(1, None)  # frames


def _bones(source: Skeleton, positions: np.ndarray, target: Skeleton, lines: Lines) -> _Bones:
    """Find the directions of the bones of the target by positions of the source (n_frames, n_joints + 2, 3)."""
    at_zero = with_root(joint_positions(np.zeros((1, source.n_dofs)), source), lines.hips[0])
    positions, ends = np.concatenate([at_zero, positions]), {j: line.source_end for j, line in lines.of_bones.items()}
    vectors = positions[:, [*ends.values()]] - positions[:, [line.source_start for line in lines.of_bones.values()]]
    longest, directions = np.linalg.norm(source.offsets, axis=1).max(), unit(vectors)
    directions[:, np.linalg.norm(vectors, axis=2).min(axis=0) <= NO_DIRECTION * longest] = 0.0  # too short in a frame
    wished = np.zeros((len(positions), target.n_joints, 3))
    wished[:, [*ends]] = directions
    known = np.asarray(lines.directions.any(axis=1) & wished.any(axis=(0, 2)))
    carriers = np.where(known, find_carriers(target), NOWHERE)
    joints = (ROOT, *(j for j, bone in enumerate(target.bones) if bone.dofs))
    carried = {j: np.flatnonzero(carriers == j).tolist() for j in joints}
    return _Bones(lines.directions, ends, wished, carried)


def _leaders(source: Skeleton, target: Skeleton, there: np.ndarray, bones: _Bones) -> dict[int, int]:
    """The joint of the source whose rotation the root, and each joint of the target with dofs, follows.

    It is the one that carries the counterpart of the bone that the joint carries. A joint that carries none follows its
    own counterpart if dofs have the same meaning in both skeletons, and otherwise stays at rest.
    """
    leaders = {}
    for joint in bones.carried:
        if bones.carried[joint]:
            end = bones.ends[bones.carried[joint][0]]
            leaders[joint] = end if source.offset_frame == "own" else int(source.parents[end])
        elif joint == ROOT:
            leaders[joint] = ROOT
        elif there[joint] >= 0 and source.offset_frame == target.offset_frame:
            leaders[joint] = int(there[joint])
    return leaders


def poses_of(motion: Motion) -> Poses:
    """The joints of a motion in the axes of the world, from its root, and their rotations since angle zero."""
    root = root_orientations(motion.root_angles, motion.root_axes)
    rotations = rotations_since_zero(motion.skeleton, motion.angles, root)
    return Poses(motion.positions() - motion.root_positions[:, None], rotations)


def rotations_since_zero(skeleton: Skeleton, angles: np.ndarray, root: Rotation) -> dict[int, Rotation]:
    """The rotation (n_frames,) of the root and of each joint since angle zero, in the world."""
    axes, zero = {ROOT: root}, axes_at_zero(skeleton)
    rotations = {ROOT: root}
    for j, (bone, columns) in enumerate(with_columns(skeleton.bones)):
        axes[j] = axes[int(skeleton.parents[j])] * Rotation.from_matrix(skeleton.rest_rotations[j].copy())
        if bone.dofs:
            axes[j] = axes[j] * rotations_of(bone, angles[:, columns])
        rotations[j] = axes[j] * Rotation.from_matrix(zero[j].T)
    return rotations


def _fixed_turns(
    source: Skeleton, target: Skeleton, people: tuple[Anatomy, Anatomy] | None
) -> dict[int, tuple[int, Rotation]]:
    """For joints of the target whose segments have axes, the joint of the source and the constant rotation."""
    if people is None:
        return {}
    theirs, ours = (find_segments(*pair) for pair in zip((source, target), people, strict=True))
    return {
        segment.joint: (theirs[name].joint, Rotation.from_matrix([theirs[name].axes @ segment.axes.T]))
        for name, segment in ours.items()
        if name in theirs
    }


def _bends(
    source: Skeleton,
    target: Skeleton,
    people: tuple[Anatomy, Anatomy] | None,
    leaders: dict[int, int],
    poses: Poses,
    shown: Motion | None,
) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """The flexion axes (3,) at angle zero of target and source that each joint of a limb, and its leader, carry."""
    found: dict[int, tuple[np.ndarray, np.ndarray]] = {}
    if people is None:
        return found
    of_target = None if shown is None else poses_of(shown)
    theirs = {bend.name: bend for bend in find_bends(source, people[0])}
    unknown = []
    for bend in find_bends(target, people[1]):
        for joint in bend.carriers if bend.name in theirs else ():
            if joint in leaders and joint != ROOT:
                ours, other = (
                    flexion_axis(bend, joint, of_target),
                    flexion_axis(theirs[bend.name], leaders[joint], poses),
                )
                if ours is not None and other is not None:
                    found[joint] = ours, other
                else:
                    unknown.append(f"{bend.name.replace('_', ' ')} of the {'target' if ours is None else 'motion'}")
    if unknown:
        names = list_names([*dict.fromkeys(unknown)])
        warn(f"twists are arbitrary, as nothing shows how these bend: {names}. A motion with bent limbs would show it")
    return found


def _turns(
    target: Skeleton,
    bones: _Bones,
    bends: dict[int, tuple[np.ndarray, np.ndarray]],
    fixed: dict[int, Rotation],
) -> dict[int, Rotation]:
    """The constant rotation of the root and of each joint: A in the docstring of the module."""
    turns: dict[int, Rotation] = {}
    for j in (ROOT, *range(target.n_joints)):
        turns[j] = Rotation.identity(1) if j == ROOT else turns[int(target.parents[j])]
        if j in fixed:
            turns[j] = fixed[j]
        elif j in bones.carried:
            turns[j], _ = _fit_joint(turns[j], j, bones, AT_ZERO)
            if j in bends and len(carried := bones.carried[j]) == 1:
                axis = turns[j].apply(bones.directions[carried])
                turns[j] = _fit_twist(axis, turns[j].apply(bends[j][0][None]), bends[j][1][None]) * turns[j]
    return turns


def _fit_joint(
    predicted: Rotation, joint: int, bones: _Bones, frames: slice = IN_MOTION
) -> tuple[Rotation, np.ndarray]:
    """The rotations (n_frames,) of a joint that give its bones their directions, and the angles left, degrees."""
    carried = bones.carried[joint]
    wished = bones.wished[frames, carried]
    now = np.empty_like(wished)
    for i, k in enumerate(carried):
        now[:, i] = predicted.apply(bones.directions[k])
    if carried and np.abs(now - wished).max() > 1e-13:
        fit = _fit(now, wished)
        predicted = fit * predicted
        now = np.stack([fit.apply(now[:, i]) for i in range(len(carried))], axis=1)
    return predicted, degrees_between(now, wished)


def _fit(a: np.ndarray, b: np.ndarray) -> Rotation:
    """The rotations (n,) that take directions a (n, k, 3) nearest to b; the shortest if all are on a line."""
    U, singular, Vt = np.linalg.svd(np.einsum("nka,nkb->nab", b, a))
    sign = np.sign(np.linalg.det(U) * np.linalg.det(Vt))
    matrices = np.stack([U[..., 0], U[..., 1], sign[:, None] * U[..., 2]], axis=2) @ Vt
    quaternions = shortest_rotations(Vt[:, 0], U[:, :, 0]).as_quat()
    on_a_line = singular[:, 1] + sign * singular[:, 2] <= LINE * singular[:, 0]
    if not on_a_line.all():
        quaternions[~on_a_line] = Rotation.from_matrix(matrices[~on_a_line]).as_quat()
    return Rotation.from_quat(quaternions)


def _fit_twist(axes: np.ndarray, a: np.ndarray, b: np.ndarray) -> Rotation:
    """The rotations (n,) about axes (n, 3) that take directions a (n, 3) nearest to b."""
    sines = (axes * np.cross(a, b)).sum(axis=1)
    cosines = (a * b).sum(axis=1) - (axes * a).sum(axis=1) * (axes * b).sum(axis=1)
    return Rotation.from_rotvec(np.arctan2(sines, cosines)[:, None] * axes)


def _angles(
    motion: Motion, target: Skeleton, found: Counterparts, rotations: dict[int, Rotation], bones: _Bones
) -> tuple[np.ndarray, float]:
    """The angles (n_frames, n_dofs) of the target whose joints have rotated so, others at rest.

    Toes, which are hinges in many rigs, may miss their direction; by how many degrees is the second value.
    """
    there, worst = found.there, 0.0
    marks = {} if found.people is None else found.people[1].joints
    toes = [marks[f"{side}_{TOE}"] for side in SIDES if f"{side}_{TOE}" in marks]
    zero, same_frame = axes_at_zero(target), motion.skeleton.offset_frame == target.offset_frame
    columns_of_source = list(with_columns(motion.skeleton.bones))
    axes = {ROOT: rotations[ROOT]}
    columns: list[np.ndarray] = [np.zeros((len(motion), 0))]
    for j, bone in enumerate(target.bones):
        axes[j] = axes[int(target.parents[j])] * Rotation.from_matrix(target.rest_rotations[j].copy())
        if j not in rotations:
            columns.append(np.zeros((len(motion), bone.n_dofs)))
            continue
        wished = rotations[j] * Rotation.from_matrix(zero[j])
        other, at = columns_of_source[int(there[j])]
        has_same = same_frame and there[j] >= 0 and (other.dofs, other.axis) == (bone.dofs, bone.axis)
        near = motion.angles[:, at] if has_same else None
        columns.append(_numbers(bone, axes[j].inv() * wished, near))
        axes[j] = axes[j] * rotations_of(bone, columns[-1])
        for k in bones.carried[j] if bone.n_dofs < 3 else ():
            along = zero[j].T @ bones.directions[k]
            apart = degrees_between(axes[j].apply(along), wished.apply(along))
            worst = max(worst, float(apart.max()))
            if k not in toes and apart.max() > np.degrees(ROUNDING):
                names = f"joint {bone.name!r} with dofs {bone.dofs!r} leaves {target.joint_names[k]!r}"
                raise ValueError(f"{names} off by {apart.max():.2g}° in frame {apart.argmax()}: {REMEDY}")
    return np.concatenate(columns, axis=1), worst


def _numbers(bone: Bone, rotations: Rotation, near: np.ndarray | None) -> np.ndarray:
    """The columns of a joint, near to others or continuous in time.

    With one or two dofs they may not reach the rotations.
    """
    if bone.n_dofs == 3:
        return continuous_columns(bone, rotations) if near is None else columns_of(bone, rotations, near)
    angles, _ = fit_columns(bone, rotations)
    angles -= TWO_PI * np.rint((angles - (0.0 if near is None else near)) / TWO_PI)
    return np.unwrap(angles, axis=0) if near is None else angles
