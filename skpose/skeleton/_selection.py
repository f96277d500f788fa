"""Parts of a skeleton: the bones of some of its joints, and of those that carry them."""

from collections.abc import Iterable

from skpose._validation.names import near_names
from skpose._validation.skeletons import SkeletonLike
from skpose.skeleton._bone import Bone


def select_bones(
    skeleton: SkeletonLike, joints: str | Iterable[str] | None, drop: str | Iterable[str]
) -> tuple[Bone, ...]:
    """Return the bones of some joints, and of those that carry them, see `Skeleton.select`."""
    kept = set(skeleton.joint_names) if joints is None else set(check_joints(skeleton, joints, "joints"))
    dropped = set(check_joints(skeleton, drop, "drop"))
    for bone in skeleton.bones:
        if bone.parent in dropped:
            dropped.add(bone.name)
    bones = with_carriers(skeleton, kept - dropped)
    if not any(bone.dofs for bone in bones):
        names = ", ".join(repr(bone.name) for bone in bones) or "no joint"
        raise ValueError(f"a selection must leave at least one joint with dofs, but it leaves {names}")
    return bones


def with_carriers(skeleton: SkeletonLike, names: Iterable[str]) -> tuple[Bone, ...]:
    """Return the bones of these joints, and of all joints between them and the root."""
    kept: set[str | None] = set(names)
    for bone in reversed(skeleton.bones):
        if bone.name in kept:
            kept.add(bone.parent)
    return tuple(bone for bone in skeleton.bones if bone.name in kept)


def check_joints(skeleton: SkeletonLike, names: str | Iterable[str], parameter: str) -> list[str]:
    """Return names of joints as a list, or refuse one that is none."""
    listed = [names] if isinstance(names, str) else list(names)
    for name in listed:
        if name not in skeleton.joint_names:
            raise ValueError(
                f"{parameter} names {name!r}, which no joint has: {near_names(skeleton.joint_names, str(name))}"
            )
    return listed
