"""Parts of a skeleton: some of its joints, with their columns of an array of poses."""

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from skpose._validation.names import near_names
from skpose.skeleton._bone import Bone

if TYPE_CHECKING:
    from skpose.skeleton._motion import Motion
    from skpose.skeleton._skeleton import Skeleton


def select(
    skeleton: "Skeleton", joints: str | Iterable[str] | None = None, *, drop: str | Iterable[str] = ()
) -> "Skeleton":
    """Return the skeleton of some joints, and of those that carry them.

    The dofs of all other joints are no columns of its poses any more. `Motion.select` and `MotionDataset.select` do the
    same with motions; ``X[:, part.columns_in(skeleton)]`` does it with an array of poses.

    Parameters
    ----------
    joints : str or iterable of str, default=None
        Joints to keep. All joints between them and the root are kept too, as these carry them. None keeps all.
    drop : str or iterable of str, default=()
        Joints to leave out, each with all that it carries.

    Returns
    -------
    Skeleton
        With the kept bones, unchanged, in their order.

    Raises
    ------
    ValueError
        For a name that no joint has, or if no joint with dofs is left.

    See Also
    --------
    with_weights : Joints of weight zero are not seen, and the columns of poses stay.

    Examples
    --------
    >>> from skpose.datasets import humanoid
    >>> skeleton = humanoid()
    >>> skeleton.select("left_hand").joint_names
    ('abdomen', 'chest', 'left_clavicle', 'left_upper_arm', 'left_forearm', 'left_hand')
    >>> skeleton.select(drop=["left_pelvis", "right_pelvis"])  # the upper part of the body
    Skeleton(n_joints=12, n_dofs=28)
    """
    kept = set(skeleton.joint_names) if joints is None else set(checked_names(skeleton, joints, "joints"))
    dropped = set(checked_names(skeleton, drop, "drop"))
    for bone in skeleton.bones:
        if bone.parent in dropped:
            dropped.add(bone.name)
    bones = with_carriers(skeleton, kept - dropped)
    if not any(bone.dofs for bone in bones):
        names = ", ".join(repr(bone.name) for bone in bones) or "no joint"
        raise ValueError(f"a selection must leave at least one joint with dofs, but it leaves {names}")
    return replace(skeleton, bones=bones)


def with_carriers(skeleton: "Skeleton", names: Iterable[str]) -> tuple[Bone, ...]:
    """Return the bones of these joints, and of all joints between them and the root."""
    kept: set[str | None] = set(names)
    for bone in reversed(skeleton.bones):
        if bone.name in kept:
            kept.add(bone.parent)
    return tuple(bone for bone in skeleton.bones if bone.name in kept)


def columns_in(part: "Skeleton", skeleton: "Skeleton") -> np.ndarray:
    """Return the columns, in poses of a larger skeleton, of the dofs of this one.

    Parameters
    ----------
    skeleton : Skeleton
        A skeleton that has all dofs of this one, by name.

    Returns
    -------
    ndarray of shape (n_dofs,)
        Indices into ``skeleton.dof_names``.

    Raises
    ------
    ValueError
        If one of the dofs is not among those of the skeleton.

    Examples
    --------
    >>> from skpose import Skeleton
    >>> arm = Skeleton.chain(3)
    >>> arm.select("joint_2").columns_in(arm)
    array([0, 1])
    """
    index = {name: i for i, name in enumerate(skeleton.dof_names)}
    missing = [name for name in part.dof_names if name not in index]
    if missing:
        raise ValueError(f"the other skeleton has no dof {missing[0]!r}: it must be the one that this is a part of")
    return np.array([index[name] for name in part.dof_names], dtype=np.intp)


def select_in(
    motion: "Motion", joints: str | Iterable[str] | None = None, *, drop: str | Iterable[str] = ()
) -> "Motion":
    """Return the motion of some joints, and of those that carry them, see `Skeleton.select`.

    Parameters
    ----------
    joints : str or iterable of str, default=None
        Joints to keep, with all between them and the root; None keeps all.
    drop : str or iterable of str, default=()
        Joints to leave out, each with all that it carries.

    Returns
    -------
    Motion
        Of the smaller skeleton; the root moves as before.
    """
    part = motion.skeleton.select(joints, drop=drop)
    return replace(motion, skeleton=part, angles=motion.angles[:, part.columns_in(motion.skeleton)])


def checked_names(skeleton: "Skeleton", names: str | Iterable[str], parameter: str) -> list[str]:
    """Return names of joints as a list, or refuse one that is none."""
    listed = [names] if isinstance(names, str) else list(names)
    for name in listed:
        if name not in skeleton.joint_names:
            raise ValueError(
                f"{parameter} names {name!r}, which no joint has: {near_names(skeleton.joint_names, str(name))}"
            )
    return listed
