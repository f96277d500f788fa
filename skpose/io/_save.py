"""Writer of BVH files."""

from dataclasses import replace
from typing import Any, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.files import check_new, new_file
from skpose._utils.validation import check_choice, check_kind, check_positive
from skpose.io._conventions import check_even, quarter_turn, unused_name
from skpose.io._source import PathLike
from skpose.keypoints._fit import is_of_layout
from skpose.skeleton import Bone, Motion, Skeleton
from skpose.skeleton._bone import is_axes
from skpose.skeleton._rest import positions_at_zero
from skpose.skeleton._root import root_orientations
from skpose.skeleton._rotations import continuous_triples, rotations_of

DIGITS = 9  # after the point: far below the precision of mocap; no exponents, which some programs cannot read
PARALLEL = 1e-12  # axes that differ by less are the root's
STANDS = 1.3  # times as high as it is deep or wide: a skeleton that stands; arms that are held out are as wide as high


def save_bvh(path: PathLike, motion: Motion, *, scale: float = 1.0, up: Literal["x", "y", "z"] = "y") -> None:
    """Write a motion as a BVH file, which Blender and most other programs open.

    Parameters
    ----------
    path : str or path-like
        The file, which must not exist yet. It is written whole or not at all.
    motion : Motion
        The motion to write. The path of a `geodesic`, a mean or other poses become one as
        ``Motion(skeleton, poses, frame_rate)``.
    scale : float, default=1.0
        Metres per unit of length in the file: 1 writes metres, 0.01 centimetres.
    up : {"x", "y", "z"}, default="y"
        The axis of the file's world that points up. The format does not state it, and programs take y. A motion in
        which another axis points up, `Motion.up`, is turned by a quarter turn of the world, so that people stand in the
        file as they do here; ``up=motion.up`` writes it as it is.

    Raises
    ------
    ValueError
        If a joint's name cannot be written in the format, or frames are missing, see `Motion.frame_numbers`: the format
        has one time between frames.
    OSError
        If it exists, or cannot be written.

    See Also
    --------
    load_bvh : Read a BVH file.

    Notes
    -----
    Joints, offsets and angles of a skeleton that came from a BVH file are written as they are, to nine digits after
    the point, and the root has its name, with an underscore where a joint has it too. A joint with one or two dofs gets
    channels for all three axes, the others zero: Blender refuses files with fewer. A ball joint gets three angles in
    the order ZYX, which BVH has instead of rotation vectors: positions are the same. Of the angles that are one
    rotation it gets those that change least from frame to frame.

    In an ASF skeleton, and any other with offsets in the joints' "own" axes, a joint rotates the bone that *ends* at
    it; in a BVH file it rotates the bones that *start* at it. So the BVH joint with a bone's name is at the bone's near
    end, and the bone's far end is the position of its children, or an End Site. Every joint then has three angles,
    about the root's axes, in the order ZYX: positions are the same, numbers and degrees of freedom are not. A skeleton
    of `fit_skeleton` has names of points, and its BVH joints are at these points; where several bones start, as at the
    neck, there is one more joint for each, such as ``neck_turn``.

    Where the world is turned, all positions of the root are, and its orientation has three angles, the first about the
    axis that points up. Heights, tilts and headings stay, as do the poses.

    The format has no weights: those of `Skeleton.with_weights` are not written. Nor does it state that poses were
    fitted to positions, which do not show how limbs are twisted (`Motion.fitted`): where that matters, as in
    `joint_angles`, use `save_npz`, or state it again by ``dataclasses.replace(motion, seen=True)``.

    Examples
    --------
    >>> from skpose import Motion, Skeleton, geodesic
    >>> from skpose.io import load_bvh, save_bvh
    >>> arm = Skeleton.chain(3)
    >>> path = geodesic([0, 0, 0], [0.5, 1, 1.5], arm).path
    >>> save_bvh("reach.bvh", Motion(arm, path, frame_rate=10))  # doctest: +SKIP
    """
    check_kind(motion, Motion, "motion", "Motion(skeleton, poses, frame_rate) makes one of poses")
    check_new(path)
    check_positive("scale", scale)
    check_choice("up", up, ("x", "y", "z"))
    is_own = motion.skeleton.offset_frame == "own"
    motion, turn = _stand(at_joints(motion), up)
    skeleton = motion.skeleton
    if slides := [bone.name for bone in skeleton.bones if bone.is_slide]:
        raise ValueError(
            f"joint {slides[0]!r} slides, and BVH files have rotations alone: save_npz and save_csv keep it"
        )
    for name in (motion.root_name, *skeleton.joint_names):
        if name != name.strip() or set(name) & set("{}\r\n"):
            raise ValueError(f"joint {name!r} cannot be written: BVH has names of one line, without braces")
    check_even(motion, "BVH has")
    lines, columns = _hierarchy(motion, turn, scale, is_own)
    lines += ["MOTION", f"Frames: {len(motion)}"]
    lines += [f"Frame Time: {np.format_float_positional(1.0 / motion.frame_rate, trim='-')}", ""]
    with new_file(path) as new, new.open("w", encoding="utf-8", newline="\n") as file:
        file.write("\n".join(lines))
        np.savetxt(file, np.concatenate(columns, axis=1), fmt=f"%.{DIGITS}f")


def at_joints(motion: Motion) -> Motion:
    """The motion with its joints where they rotate, as in BVH and SMPL, and with the ends of the last bones."""
    skeleton = motion.skeleton
    if is_of_layout(skeleton):
        return _at_points(motion)
    if skeleton.offset_frame == "parent":
        return motion
    offsets = dict(zip([None, *skeleton.joint_names], np.insert(skeleton.offsets, 0, 0.0, axis=0), strict=True))
    bones = [bone._replace(offset=offsets[bone.parent]) for bone in skeleton.bones]
    for name in skeleton.joint_names:
        if all(bone.parent != name for bone in skeleton.bones):
            bones.append(Bone(unused_name(f"{name}_end", skeleton.joint_names, ()), name, offsets[name]))
    return replace(motion, skeleton=Skeleton(bones, "parent"), seen=None)


def _at_points(motion: Motion) -> Motion:
    """The motion of a fitted skeleton with a joint at each point, which rotates the bones that start there.

    Where several bones start, each that rotates has one more joint. Joints that rotate none have angles of zero.
    """
    root, *bones = motion.skeleton.bones
    children = {name: [bone for bone in bones if bone.parent == name] for name in motion.skeleton.joint_names}
    columns = motion.skeleton.dof_names
    joints, angles = list[Bone](), list[np.ndarray]()

    def add(name: str, parent: str, offset: Any, turned: Bone | None) -> None:
        dofs, rest = ("ZYX", None) if turned is None else (turned.dofs, turned.rest_rotation)
        joints.append(Bone(name, None if parent == root.name else parent, offset, dofs, rest))
        numbers = [] if turned is None else [motion.angles[:, columns.index(dof)] for dof in turned.dof_names]
        angles.extend(numbers or [np.zeros(len(motion))] * 3)

    for bone in bones:
        parent = str(bone.parent)
        if bone.dofs and (parent == root.name or len(children[parent]) > 1):
            used = {*children, *(joint.name for joint in joints)}
            add(unused_name(f"{parent}_turn", used, ()), parent, (0.0, 0.0, 0.0), bone)
            parent = joints[-1].name
        only = [child for child in children[bone.name] if child.dofs and len(children[bone.name]) == 1]
        add(bone.name, parent, bone.offset, next(iter(only), None))
    skeleton = Skeleton(joints, "parent")
    return replace(motion, skeleton=skeleton, angles=np.stack(angles, axis=1), root_name=root.name, seen=None)


def _stand(motion: Motion, up: Literal["x", "y", "z"]) -> tuple[Motion, np.ndarray]:
    """The motion in a world in which the axis points up, and what the root's own axes are turned by.

    The world is turned by a quarter turn. The root's own axes stay, so that the skeleton does. They are turned with the
    world if the skeleton stands along the motion's vertical at angle zero: then it stands in the file, too.
    """
    if motion.up == up:
        return motion, np.eye(3)
    before, after = "xyz".index(motion.up), "xyz".index(up)
    about = "xyz"[3 - before - after]
    matrix = quarter_turn(motion.up, up)
    turn = Rotation.from_matrix(matrix)
    extent = np.ptp(positions_at_zero(motion.skeleton), axis=0)
    own = matrix if extent[before] > STANDS * extent[after] else np.eye(3)
    # Heading first, and last the axis of the quarter turn: the angle between them is a lean to a side, far from 90°, at
    # which three angles are degenerate, whether or not the root's own axes are turned.
    axes, angles, positions = f"{up}{motion.up}{about}".upper(), np.zeros((0, 3)), motion.root_positions
    if len(motion):
        orientations = turn * root_orientations(motion.root_angles, motion.root_axes)
        angles = continuous_triples(axes, orientations * Rotation.from_matrix(own.T))
        positions = positions @ matrix.T
    return replace(motion, root_positions=positions, root_angles=angles, root_axes=axes, up=up), own


def _hierarchy(motion: Motion, turn: np.ndarray, scale: float, is_full: bool) -> tuple[list[str], list[np.ndarray]]:
    """The lines of the hierarchy, and the columns of its channels.

    `turn`, a rotation matrix of zeros and ones, is what the own axes of the root and of all joints are turned by.
    `is_full` is whether rigid joints have channels.
    """
    skeleton = motion.skeleton
    bones: dict[str | None, Bone] = dict(zip(skeleton.joint_names, skeleton.bones, strict=True))
    children: dict[str | None, list[str]] = {name: [] for name in (None, *bones)}
    first = dict(zip(bones, np.cumsum([0, *(bone.n_dofs for bone in bones.values())]), strict=False))
    # Axes of each joint at angle zero, in those of the root; in BVH all joints' axes are parallel at angle zero.
    rest: dict[str | None, np.ndarray] = {None: turn}
    for bone, rotation in zip(skeleton.bones, skeleton.rest_rotations, strict=True):
        children[bone.parent].append(bone.name)
        rest[bone.name] = rest[bone.parent] @ rotation

    def write(depth: int, *texts: str) -> None:
        lines.extend("\t" * depth + text for text in texts)

    root, lines = motion.root_name, ["HIERARCHY"]
    while root in bones:
        root += "_"
    axes, angles = _intrinsic(motion.root_axes, motion.root_angles)
    columns = [motion.root_positions / scale, np.degrees(angles)]
    write(0, f"ROOT {root}", "{")
    write(1, "OFFSET 0 0 0", _channels(["Xposition", "Yposition", "Zposition"], axes))
    stack: list[tuple[int, str | None]] = [(0, None), *((1, name) for name in reversed(children[None]))]
    while stack:  # no recursion: a chain may be longer than Python's stack
        depth, name = stack.pop()
        if name is None:
            write(depth, "}")
            continue
        bone = bones[name]
        # A joint that the reader makes of an End Site.
        is_end = not bone.dofs and not children[name] and name.startswith(f"{bone.parent}_end")
        write(depth, "End Site" if is_end else f"JOINT {name}", "{")
        offset = rest[bone.parent] @ bone.offset / scale  # in axes that are parallel to the root's at angle zero
        write(depth + 1, "OFFSET " + " ".join(f"{x:.{DIGITS}f}" for x in offset))
        if not is_end:
            angles = motion.angles[:, first[name] : first[name] + bone.n_dofs]
            about_axes = is_axes(bone.dofs) and np.allclose(rest[name], turn, rtol=0, atol=PARALLEL)
            if about_axes and (bone.dofs or not is_full):
                axes, angles = _turn_axes(*_intrinsic(bone.dofs, angles), turn)
            else:
                axes, angles = _about_root(bone, angles, rest[name])
            write(depth + 1, _channels([], axes))
            columns.append(np.degrees(angles))
        stack += [(depth, None), *((depth + 1, child) for child in reversed(children[name]))]
    return lines, columns


def _channels(positions: list[str], axes: str) -> str:
    names = [*positions, *(f"{axis}rotation" for axis in axes)]
    return " ".join(["CHANNELS", str(len(names)), *names])


def _intrinsic(dofs: str, angles: np.ndarray) -> tuple[str, np.ndarray]:
    """The same rotations as intrinsic ones about three axes, zero about those added; none stay none."""
    axes, angles = (dofs[::-1].upper(), angles[:, ::-1]) if dofs.islower() else (dofs, angles)
    more = [axis for axis in "ZXY" if axis not in axes] if axes else []
    return "".join([axes, *more]), np.concatenate([angles, np.zeros((len(angles), len(more)))], axis=1)


def _turn_axes(axes: str, angles: np.ndarray, turn: np.ndarray) -> tuple[str, np.ndarray]:
    """Intrinsic rotations about axes that are turned, each to another one or to its opposite."""
    columns = turn[:, ["XYZ".index(axis) for axis in axes]].T  # (n_axes, 3)
    turned = "".join("XYZ"[i] for i in np.abs(columns).argmax(axis=1))
    return turned, angles if turned == axes else angles * columns.sum(axis=1)


def _about_root(bone: Bone, angles: np.ndarray, axes: np.ndarray) -> tuple[str, np.ndarray]:
    """A joint's rotations as three intrinsic ones about the axes of the root, continuous in time."""
    if not angles.size:  # no frames, or a rigid joint
        return "ZYX", np.zeros((len(angles), 3))
    to_root = Rotation.from_matrix(axes)
    return "ZYX", continuous_triples("ZYX", to_root * rotations_of(bone, angles) * to_root.inv())
