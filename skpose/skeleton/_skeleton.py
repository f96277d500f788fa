"""The skeleton: a tree of bones of fixed length, and the degrees of freedom (dofs) at which it bends."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Literal, NamedTuple, NoReturn

import numpy as np

ROTATION_TOLERANCE = 1e-6  # how far a rest rotation may be from orthonormal: what six printed digits leave


class Bone(NamedTuple):
    """One bone of a `Skeleton`: the joint at its far end, and how it hangs on the joint before.

    Parameters
    ----------
    name : str
        Name of the joint at the bone's far end.
    parent : str or None
        Name of the joint at its near end; None for the root.
    offset : tuple of 3 floats
        From the near end to the far end, m.
    dofs : str, default=""
        Rotation axes of the joint, at most one each of x, y and z. As in `scipy.spatial.transform.Rotation`, lower
        case is extrinsic ("xyz": first about x, then about the *fixed* y, then z; the product Rz·Ry·Rx) and upper
        case intrinsic ("ZXY": first about z, then about the *turned* x, then y; the product Rz·Rx·Ry). Empty for a
        rigid joint.
    rest_rotation : (3, 3) nested tuples, default=None
        Constant rotation before the dofs: from the joint's own axes to those of its parent at angle zero. None is
        the identity.
    limits : tuple of (lower, upper) pairs, default=None
        Range of each dof, rad, in the order of `dofs`.
    """

    name: str
    parent: str | None
    offset: tuple[float, float, float]
    dofs: str = ""
    rest_rotation: tuple[tuple[float, float, float], ...] | None = None
    limits: tuple[tuple[float, float], ...] | None = None


@dataclass(frozen=True, repr=False)
class Skeleton:
    """A tree of bones of fixed length whose joints turn about given axes.

    The root is the point on which the first bones hang. It stays at the origin, unrotated, and is not counted among
    the joints. A skeleton is immutable; equal bones make equal skeletons.

    Parameters
    ----------
    bones : iterable of Bone
        The bones, in any order; plain tuples (name, parent, offset, dofs, rest_rotation, limits) will do. They are
        kept in the given order as far as each can follow its parent.
    offset_frame : {"own", "parent"}, default="own"
        Whose axes the offsets are given in. "own": a joint's dofs turn the bone that *ends* at it (ASF). "parent":
        they turn the bones that *start* at it (BVH).

    Attributes
    ----------
    joint_names : tuple of str
        Names of the joints, the root not among them.
    dof_names : tuple of str
        One name for each column of an array of poses, such as "lfemur_rx".
    parents : ndarray of shape (n_joints,)
        Index of each joint's parent, -1 for the root; a parent comes before its children.
    offsets : ndarray of shape (n_joints, 3)
        The bones' offsets, m.
    rest_rotations : ndarray of shape (n_joints, 3, 3)
        The joints' constant rotations.
    limits : ndarray of shape (n_dofs, 2) or None
        Range of each dof, rad, infinite where a bone has none; None where no bone has any.
    n_joints, n_dofs : int
        How many there are.

    Raises
    ------
    ValueError
        For a cycle, an unknown parent, a name given twice, a number that is not finite, axes or limits that do not
        fit; the message names the bone.

    See Also
    --------
    skpose.io.load_asf : Read a skeleton from an ASF file.
    skpose.io.load_bvh : Read a skeleton and its motion from a BVH file.

    Examples
    --------
    >>> from skpose import Bone, Skeleton
    >>> arm = Skeleton([
    ...     Bone("elbow", None, (0.3, 0, 0), "xyz"),
    ...     Bone("wrist", "elbow", (0.25, 0, 0), "y", limits=((0.0, 2.6),)),
    ... ])
    >>> arm
    Skeleton(n_joints=2, n_dofs=4)
    >>> arm.dof_names
    ('elbow_rx', 'elbow_ry', 'elbow_rz', 'wrist_ry')
    """

    bones: tuple[Bone, ...]
    offset_frame: Literal["own", "parent"] = "own"

    def __post_init__(self):
        if self.offset_frame not in ("own", "parent"):
            raise ValueError(f'offset_frame must be "own" or "parent", got {self.offset_frame!r}')
        bones = _in_tree_order([_checked(Bone(*bone)) for bone in self.bones])
        if not any(bone.dofs for bone in bones):
            raise ValueError("a skeleton needs at least one degree of freedom, but no bone has any dofs")
        object.__setattr__(self, "bones", bones)

    @classmethod
    def chain(cls, n: int) -> "Skeleton":
        """A planar arm: n bones of 1 m, each turning about z at its near end.

        >>> Skeleton.chain(3).dof_names
        ('joint_1_rz', 'joint_2_rz', 'joint_3_rz')
        """
        names = [None, *(f"joint_{i}" for i in range(1, n + 1))]
        return cls(Bone(name, parent, (1.0, 0.0, 0.0), "z") for parent, name in pairwise(names))

    @classmethod
    def mean(cls, skeletons: Iterable["Skeleton"]) -> "Skeleton":
        """The bone-wise mean: one skeleton on which the poses of several people can be compared.

        Each bone gets the mean length and the mean direction of its namesakes, the (chordal) mean of their rest
        rotations, and the widest of their limits.

        Parameters
        ----------
        skeletons : iterable of Skeleton
            At least one; with the same joints, parents, dofs and offset frame.

        Raises
        ------
        ValueError
            If the skeletons differ in more than lengths, directions and limits; the message names the joint.
        """
        skeletons = list(skeletons)
        if not skeletons:
            raise ValueError("the mean skeleton needs at least one skeleton, got none")
        first = skeletons[0]
        for i, other in enumerate(skeletons[1:], start=1):
            difference = mismatch(first, other)
            if difference:
                raise ValueError(f"skeletons[{i}] has no bone-wise mean with skeletons[0]: {difference}")
        namesakes = [{bone.name: bone for bone in skeleton.bones} for skeleton in skeletons]
        return cls((_mean_bone([by[name] for by in namesakes]) for name in first.joint_names), first.offset_frame)

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        return tuple(bone.name for bone in self.bones)

    @cached_property
    def dof_names(self) -> tuple[str, ...]:
        return tuple(f"{bone.name}_r{axis}" for bone in self.bones for axis in bone.dofs.lower())

    @cached_property
    def parents(self) -> np.ndarray:
        index = {None: -1} | {name: i for i, name in enumerate(self.joint_names)}
        return _frozen([index[bone.parent] for bone in self.bones], dtype=np.intp)

    @cached_property
    def offsets(self) -> np.ndarray:
        return _frozen([bone.offset for bone in self.bones])

    @cached_property
    def rest_rotations(self) -> np.ndarray:
        return _frozen([np.eye(3) if b.rest_rotation is None else b.rest_rotation for b in self.bones])

    @cached_property
    def limits(self) -> np.ndarray | None:
        if all(bone.limits is None for bone in self.bones):
            return None
        free = (-np.inf, np.inf)
        return _frozen([pair for b in self.bones for pair in (b.limits or [free] * len(b.dofs))])

    @property
    def n_joints(self) -> int:
        return len(self.bones)

    @cached_property
    def n_dofs(self) -> int:
        return len(self.dof_names)

    @cached_property
    def _hash(self) -> int:
        return hash((self.bones, self.offset_frame))

    def __hash__(self):
        return self._hash

    def __repr__(self):
        return f"Skeleton(n_joints={self.n_joints}, n_dofs={self.n_dofs})"

    def __reduce__(self):
        return Skeleton, (self.bones, self.offset_frame)

    def __deepcopy__(self, memo):
        return self  # immutable; scikit-learn's clone copies every parameter


def mismatch(a: Skeleton, b: Skeleton) -> str:
    """Why the same angles do not mean the same pose on two skeletons, in words; empty where they do."""
    if a.offset_frame != b.offset_frame:
        return f"their offset frames are {a.offset_frame!r} and {b.offset_frame!r}"
    bones_a, bones_b = ({bone.name: bone for bone in skeleton.bones} for skeleton in (a, b))
    for name in [*bones_a, *bones_b]:
        if name not in bones_a or name not in bones_b:
            return f"only one of them has a joint {name!r}"
        for what in ("parent", "dofs"):
            in_a, in_b = getattr(bones_a[name], what), getattr(bones_b[name], what)
            if in_a != in_b:
                return f"joint {name!r} has {what} {in_a!r} in one and {in_b!r} in the other"
    return ""


def _frozen(values, dtype=np.float64) -> np.ndarray:
    array = np.array(values, dtype=dtype)
    array.flags.writeable = False
    return array


def _checked(bone: Bone) -> Bone:
    """The bone with plain tuples of floats in it, or a ValueError that names it."""
    if not isinstance(bone.name, str) or not bone.name:
        raise ValueError(f"a bone's name must be a non-empty string, got {bone.name!r}")
    dofs = bone.dofs
    if not isinstance(dofs, str) or dofs not in (dofs.lower(), dofs.upper()) or not set(dofs.lower()) <= set("xyz"):
        _refuse(bone, "dofs", 'letters x, y, z in one case, such as "xyz" or "ZXY"')
    if len(set(dofs)) < len(dofs):
        _refuse(bone, "dofs", "at most one each of x, y and z")

    offset = _numbers(bone, "offset", (3,), "three finite numbers (m)")
    if not np.isfinite(offset).all():
        _refuse(bone, "offset", "three finite numbers (m)")
    rest = limits = None
    if bone.rest_rotation is not None:
        rest = _numbers(bone, "rest_rotation", (3, 3), "a (3, 3) rotation matrix")
        if not np.allclose(rest @ rest.T, np.eye(3), atol=ROTATION_TOLERANCE) or np.linalg.det(rest) < 0:
            _refuse(bone, "rest_rotation", "a (3, 3) rotation matrix")
        rest = tuple(map(tuple, rest.tolist()))
    if bone.limits is not None:
        expected = f"one (lower, upper) pair in rad for each of its {len(dofs)} dofs"
        limits = _numbers(bone, "limits", (len(dofs), 2), expected)
        if (limits[:, 0] > limits[:, 1]).any():
            _refuse(bone, "limits", expected)
        limits = tuple(map(tuple, limits.tolist()))
    return Bone(bone.name, bone.parent, tuple(offset.tolist()), dofs, rest, limits)


def _numbers(bone: Bone, field: str, shape: tuple[int, ...], expected: str) -> np.ndarray:
    """A field of the bone as an array of this shape, without NaN."""
    try:
        array = np.array(getattr(bone, field), dtype=np.float64)
    except (TypeError, ValueError):
        _refuse(bone, field, expected)
    if array.shape != shape or np.isnan(array).any():
        _refuse(bone, field, expected)
    return array


def _refuse(bone: Bone, field: str, expected: str) -> NoReturn:
    raise ValueError(f"bone {bone.name!r}: {field} must be {expected}, got {getattr(bone, field)!r}")


def _in_tree_order(bones: Sequence[Bone]) -> tuple[Bone, ...]:
    """The bones, each after its parent, otherwise in the order given."""
    by_name: dict[str | None, Bone] = {}
    for bone in bones:
        if bone.name in by_name:
            raise ValueError(f"bone {bone.name!r} is given twice; every joint needs a name of its own")
        by_name[bone.name] = bone
    placed: dict[str, Bone] = {}
    for bone in bones:
        line: dict[str, Bone] = {}
        while bone.name not in placed:
            if bone.name in line:
                raise ValueError(f"bone {bone.name!r} hangs on itself, by way of {' -> '.join([*line, bone.name])}")
            line[bone.name] = bone
            if bone.parent is None:
                break
            if bone.parent not in by_name:
                raise ValueError(
                    f"bone {bone.name!r} hangs on {bone.parent!r}, which is not among the bones; "
                    "a bone that hangs on the root has parent None"
                )
            bone = by_name[bone.parent]
        placed.update(reversed(line.items()))
    return tuple(placed.values())


def _mean_bone(bones: Sequence[Bone]) -> Bone:
    """Mean of one bone over several skeletons, `Skeleton.mean`."""
    first = bones[0]
    offsets = np.array([bone.offset for bone in bones])
    lengths = np.linalg.norm(offsets, axis=1)
    direction = (offsets / np.where(lengths > 0, lengths, 1.0)[:, None]).sum(axis=0)
    spread = np.linalg.norm(direction)
    if lengths.any() and spread < ROTATION_TOLERANCE:
        raise ValueError(f"bone {first.name!r} points in opposite directions and has no mean direction")
    offset = direction * (lengths.mean() / spread) if spread > 0 else offsets[0]
    rest = first.rest_rotation
    if any(bone.rest_rotation != rest for bone in bones):
        from scipy.spatial.transform import Rotation  # 0.1 s to import, and seldom needed

        matrices = [np.eye(3) if bone.rest_rotation is None else bone.rest_rotation for bone in bones]
        rest = Rotation.from_matrix(np.array(matrices)).mean().as_matrix()
    limits = None
    if all(bone.limits is not None for bone in bones):
        ranges = np.array([bone.limits for bone in bones]).reshape(len(bones), -1, 2)
        limits = np.stack([ranges[..., 0].min(axis=0), ranges[..., 1].max(axis=0)], axis=1)
    return first._replace(offset=offset, rest_rotation=rest, limits=limits)
