"""Parts of a skeleton: the bones of some joints, with those between them and the root."""

from collections.abc import Iterable

from skpose._utils.validation import SkeletonLike, near_names
from skpose.skeleton._bone import Bone


def select_bones(
    skeleton: SkeletonLike, joints: str | Iterable[str] | None, drop: str | Iterable[str]
) -> tuple[Bone, ...]:
    """The bones of some joints, with those between them and the root, see `Skeleton.select`."""
    kept = set(skeleton.joint_names) if joints is None else set(check_joints(skeleton, joints, "joints"))
    dropped = set(check_joints(skeleton, drop, "drop"))
    for bone in skeleton.bones:
        if bone.parent in dropped:
            dropped.add(bone.name)
    bones = with_carriers(skeleton, kept - dropped)
    if not any(bone.dofs for bone in bones):
        raise ValueError(f"a selection must keep a joint with dofs, but it keeps {[bone.name for bone in bones]}")
    return bones


def with_carriers(skeleton: SkeletonLike, names: Iterable[str]) -> tuple[Bone, ...]:
    """The bones of these joints and of all joints between them and the root."""
    kept: set[str | None] = set(names)
    for bone in reversed(skeleton.bones):
        if bone.name in kept:
            kept.add(bone.parent)
    return tuple(bone for bone in skeleton.bones if bone.name in kept)


def check_joints(skeleton: SkeletonLike, names: str | Iterable[str], parameter: str) -> list[str]:
    """Names of joints as a list; refuse unknown ones."""
    listed = [names] if isinstance(names, str) else list(names)
    for name in listed:
        if name not in skeleton.joint_names:
            near = near_names(skeleton.joint_names, str(name))
            raise ValueError(f"{parameter} has {name!r}, which is not a joint: {near}")
    return listed
