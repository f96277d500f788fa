"""One bone of a skeleton: its fields, their checks, the mean of several."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

BALL = "rotvec"  # the dofs of a ball joint
HINGE = "hinge"  # the dofs of a joint that rotates about one axis of any direction
SLIDE = "slide"  # the dofs of a joint that moves along one axis
UNIT_TOLERANCE = 1e-15  # deviation of an axis from length one that is rounding
ROTATION_TOLERANCE = 1e-6  # deviation of a rest rotation from orthonormal: six printed digits leave this much


class Bone(NamedTuple):
    """One bone of a `Skeleton`: the joint at its far end, and its attachment to the parent joint.

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
        case intrinsic ("ZXY": first about z, then about the *rotated* x, then y; the product Rz·Rx·Ry). Empty for a
        rigid joint. "rotvec" is a *ball joint*: its three columns are a rotation vector, axis times angle. "hinge" is
        a *hinge* about any axis, as in robots: its one column is the angle about `axis`. "slide" is a joint that moves
        along any axis: its one column is the displacement along `axis`, m.
    rest_rotation : (3, 3) nested tuples, default=None
        Constant rotation before the dofs: from the joint's own axes to its parent's axes at angle zero. None is
        the identity.
    limits : tuple of (lower, upper) pairs, default=None
        Range of each dof, rad (m for a slide), in the order of `dofs`. A ball joint has none.
    weight : float, default=None
        Weight of the joint at the far end in distances, see `Skeleton.with_weights`. None is 1, or 0 for a joint that
        is always at the same point as a joint with weight.
    axis : tuple of 3 floats, default=None
        Axis of a hinge or a slide in the joint's own axes, of any length. None for all other dofs.
    dof_name : str, default=None
        Name of the pose column of a hinge or slide, such as the name of a robot's joint. None is the bone's name with
        "_hinge" or "_slide".

    Attributes
    ----------
    is_ball : bool
        Whether the joint is a ball joint.
    is_hinge : bool
        Whether the joint is a hinge about any axis.
    is_slide : bool
        Whether the joint moves along an axis.
    dof_names : tuple of str
        One name for each column of a pose: "elbow_rx", "elbow_rotvec_x" of a ball joint, `dof_name` of a
        hinge or a slide.
    n_dofs : int
        Number of columns of a pose that belong to the joint.
    """

    name: str
    parent: str | None
    offset: Sequence[float] | np.ndarray
    dofs: str = ""
    rest_rotation: Sequence[Sequence[float]] | np.ndarray | None = None
    limits: Sequence[Sequence[float]] | np.ndarray | None = None
    weight: float | None = None
    axis: Sequence[float] | np.ndarray | None = None
    dof_name: str | None = None

    @property
    def is_ball(self) -> bool:
        """True for a ball joint."""
        return self.dofs == BALL

    @property
    def is_hinge(self) -> bool:
        """True for a hinge about any axis."""
        return self.dofs == HINGE

    @property
    def is_slide(self) -> bool:
        """True for a joint that moves along an axis."""
        return self.dofs == SLIDE

    @property
    def dof_names(self) -> tuple[str, ...]:
        """One name for each column of a pose."""
        if self.is_ball:
            return tuple(f"{self.name}_{BALL}_{axis}" for axis in "xyz")
        if self.dofs in (HINGE, SLIDE):
            return (f"{self.name}_{self.dofs}" if self.dof_name is None else self.dof_name,)
        return tuple(f"{self.name}_r{axis}" for axis in self.dofs.lower())

    @property
    def n_dofs(self) -> int:
        """Number of the columns of a pose that belong to the joint."""
        return 3 if self.is_ball else 1 if self.dofs in (HINGE, SLIDE) else len(self.dofs)


def check_bone(bone: Bone) -> Bone:
    """The bone with its numbers as tuples of floats, and an axis of length one."""
    if not isinstance(bone.name, str) or not bone.name or "\0" in bone.name:
        raise ValueError(f"a bone's name must be a non-empty string without NUL, got {bone.name!r}")
    has_axis = bone.dofs in (HINGE, SLIDE)
    if not (has_axis or bone.is_ball or is_axes(bone.dofs)):
        expected = 'letters of "xyz" or "XYZ", each at most once, or "rotvec", "hinge" or "slide"'
        raise ValueError(f"bone {bone.name!r}: dofs must be {expected}, got {bone.dofs!r}")
    offset = _numbers(bone, "offset", bone.offset, (3,))
    rest = limits = weight = unit = None
    if bone.rest_rotation is not None:
        rest = _numbers(bone, "rest_rotation", bone.rest_rotation, (3, 3))
        if not np.allclose(rest @ rest.T, np.eye(3), atol=ROTATION_TOLERANCE) or np.linalg.det(rest) < 0:
            raise ValueError(f"bone {bone.name!r}: rest_rotation must be a rotation matrix, got {bone.rest_rotation}")
    if bone.limits is not None:
        if bone.is_ball:
            raise ValueError(f"bone {bone.name!r}: limits must be None for a ball joint")
        limits = _numbers(bone, "limits", bone.limits, (bone.n_dofs, 2), finite=False)
        if not (limits[:, 0] <= limits[:, 1]).all():
            raise ValueError(f"bone {bone.name!r}: limits must be (lower, upper) pairs, got {bone.limits}")
    if bone.weight is not None:
        weight = float(_numbers(bone, "weight", bone.weight, ()))
        if weight < 0.0:
            raise ValueError(f"bone {bone.name!r}: weight must be zero or more, got {weight}")
    if has_axis:
        axis = _numbers(bone, "axis", () if bone.axis is None else bone.axis, (3,))
        length = np.linalg.norm(axis)
        if not length > 0.0:
            raise ValueError(f"bone {bone.name!r}: axis must not be zero")
        unit = tuple((axis if abs(length - 1.0) <= UNIT_TOLERANCE else axis / length).tolist())
    elif bone.axis is not None or bone.dof_name is not None:
        raise ValueError(f'bone {bone.name!r}: axis and dof_name must be None unless dofs is "hinge" or "slide"')
    return bone._replace(
        offset=tuple(offset.tolist()),
        rest_rotation=None if rest is None else tuple(map(tuple, rest.tolist())),
        limits=None if limits is None else tuple(map(tuple, limits.tolist())),
        weight=weight,
        axis=unit,
        dof_name=bone.dof_names[0] if has_axis else None,
    )


def _numbers(bone: Bone, field: str, value: ArrayLike, shape: tuple[int, ...], finite: bool = True) -> np.ndarray:
    """A field of the bone as an array of this shape."""
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.array(np.nan)
    if array.shape != shape or (finite and not np.isfinite(array).all()):
        raise ValueError(f"bone {bone.name!r}: {field} must be finite numbers of shape {shape}, got {value!r}")
    return array


def is_axes(dofs: object) -> bool:
    """Whether these are letters x, y, z in one case, each at most once."""
    return (
        isinstance(dofs, str) and len(set(dofs)) == len(dofs) and (set(dofs) <= set("xyz") or set(dofs) <= set("XYZ"))
    )


def axes_of(bone: Bone) -> np.ndarray:
    """The axes (n_dofs, 3) of a joint's angles, or of a slide, in its own axes, in the order of the columns."""
    if bone.axis is not None:
        return np.array([bone.axis], dtype=np.float64)
    return np.eye(3)[["xyz".index(letter) for letter in bone.dofs.lower()]]


def are_slides(bones: Sequence[Bone]) -> np.ndarray:
    """Which columns (n_dofs,) of poses are displacements in m."""
    return np.repeat([bone.is_slide for bone in bones], [bone.n_dofs for bone in bones]).astype(bool)


def ranges_of(bones: Sequence[Bone]) -> np.ndarray:
    """The range (n_dofs, 2) of each dof, infinite without limits."""
    free = (-np.inf, np.inf)
    return np.reshape([pair for bone in bones for pair in (bone.limits or [free] * bone.n_dofs)], (-1, 2))


def limited_dofs(bones: Sequence[Bone]) -> np.ndarray:
    """Which dofs (n_dofs,) have a limit, on one side at least."""
    return np.isfinite(ranges_of(bones)).any(axis=1)


def kept_inside(bones: Sequence[Bone], poses: np.ndarray) -> np.ndarray:
    """Which numbers (n_poses, n_dofs) of a recording are to be taken without whole turns.

    They are inside limits that exclude part of the circle, of joints with one or two dofs. Joints with three dofs are
    taken as rotations, since files often break their own limits.
    """
    lower, upper = ranges_of(bones).T
    is_hinge = np.repeat([bone.n_dofs < 3 for bone in bones], [bone.n_dofs for bone in bones])
    return (is_hinge & (upper - lower < 2.0 * np.pi)) & (lower <= poses) & (poses <= upper)


def with_columns(bones: Sequence[Bone]) -> Iterator[tuple[Bone, slice]]:
    """Each bone with the columns of poses that belong to it."""
    first = 0
    for bone in bones:
        yield bone, slice(first, first + bone.n_dofs)
        first += bone.n_dofs


def mean_bone(bones: Sequence[Bone]) -> Bone:
    """Mean of one bone over several skeletons, for `Skeleton.mean`."""
    first = bones[0]
    if any(bone.weight != first.weight for bone in bones):
        raise ValueError(f"bone {first.name!r} has different weights: give weights to the mean skeleton instead")
    offsets = np.array([bone.offset for bone in bones])
    lengths = np.linalg.norm(offsets, axis=1)
    direction = (offsets / np.where(lengths > 0, lengths, 1.0)[:, None]).sum(axis=0)
    spread = np.linalg.norm(direction)
    is_same = spread == 0.0 or (offsets == offsets[0]).all()  # the mean of one skeleton is exactly that skeleton
    offset = offsets[0] if is_same else direction * (lengths.mean() / spread)
    rest = first.rest_rotation
    if any(bone.rest_rotation != rest for bone in bones):
        from scipy.spatial.transform import Rotation  # 0.1 s to import, and rarely needed

        matrices = [np.eye(3) if bone.rest_rotation is None else bone.rest_rotation for bone in bones]
        rest = Rotation.from_matrix(np.array(matrices)).mean().as_matrix()
    limits: np.ndarray | None = None
    if all(bone.limits is not None for bone in bones):
        ranges = np.array([bone.limits for bone in bones]).reshape(len(bones), -1, 2)
        limits = np.stack([ranges[..., 0].min(axis=0), ranges[..., 1].max(axis=0)], axis=1)
    return first._replace(offset=offset, rest_rotation=rest, limits=limits)
