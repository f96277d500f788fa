"""One bone of a skeleton: its fields, the checks of these, the mean of several."""

from collections.abc import Sequence
from typing import Any, NamedTuple, NoReturn

import numpy as np

BALL = "rotvec"  # the dofs of a ball joint
HINGE = "hinge"  # the dofs of a joint that rotates about one axis of any direction
SLIDE = "slide"  # the dofs of a joint that moves along one axis
WEIGHT = "a finite number, zero or more, or None"
UNIT_TOLERANCE = 1e-15  # of the length of an axis: a smaller difference is rounding, and what is stored stays as it is
ROTATION_TOLERANCE = 1e-6  # deviation of a rest rotation from orthonormal: six printed digits leave this much


class Bone(NamedTuple):
    """One bone of a `Skeleton`: the joint at its far end, and how it is attached to its parent joint.

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
        a *hinge* about any axis, as those of robots: its one column is the angle about `axis`. "slide" is a joint that
        moves along any axis: its one column is the displacement along `axis`, m.
    rest_rotation : (3, 3) nested tuples, default=None
        Constant rotation before the dofs: from the joint's own axes to those of its parent at angle zero. None is
        the identity.
    limits : tuple of (lower, upper) pairs, default=None
        Range of each dof, rad, or m of a slide, in the order of `dofs`. A ball joint has none.
    weight : float, default=None
        How much the joint at the far end counts in distances, see `Skeleton.with_weights`. None is 1, or 0 where the
        joint always stands in the place of another one that counts.
    axis : tuple of 3 floats, default=None
        Axis of a hinge or a slide in the joint's own axes; it gets length one. None for all other dofs.
    dof_name : str, default=None
        Name of a hinge's or a slide's column of a pose, such as the joint of a robot that it belongs to. None is the
        bone's name and "_hinge" or "_slide".

    Attributes
    ----------
    is_ball : bool
        Whether the joint is a ball joint.
    is_hinge : bool
        Whether the joint is a hinge about any axis.
    is_slide : bool
        Whether the joint moves along an axis, and rotates nothing.
    dof_names : tuple of str
        One name for each column of a pose: "elbow_rx", "elbow_rotvec_x" of a ball joint, `dof_name` of a
        hinge or a slide.
    n_dofs : int
        How many columns of a pose belong to the joint.
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
    """Return the bone with its numbers as plain tuples of floats, or raise a ValueError with the bone's name."""
    if not isinstance(bone.name, str) or not bone.name:
        raise ValueError(f"a bone's name must be a non-empty string, got {bone.name!r}")
    _check_dofs(bone)

    offset = _numbers(bone, "offset", (3,), "three finite numbers (m)")
    if not np.isfinite(offset).all():
        _refuse(bone, "offset", "three finite numbers (m)")
    rest: Any = None
    limits: Any = None
    if bone.rest_rotation is not None:
        rest = _numbers(bone, "rest_rotation", (3, 3), "a (3, 3) rotation matrix")
        if not np.allclose(rest @ rest.T, np.eye(3), atol=ROTATION_TOLERANCE) or np.linalg.det(rest) < 0:
            _refuse(bone, "rest_rotation", "a (3, 3) rotation matrix")
        rest = tuple(map(tuple, rest.tolist()))
    if bone.limits is not None:
        expected = f"one (lower, upper) pair in {'m' if bone.is_slide else 'rad'} for each of its {bone.n_dofs} dofs"
        limits = _numbers(bone, "limits", (bone.n_dofs, 2), expected)
        if (limits[:, 0] > limits[:, 1]).any():
            _refuse(bone, "limits", expected)
        limits = tuple(map(tuple, limits.tolist()))
    weight = bone.weight
    if weight is not None:
        weight = float(_numbers(bone, "weight", (), WEIGHT))
        if not 0.0 <= weight < np.inf:
            _refuse(bone, "weight", WEIGHT)
    checked = bone._replace(offset=tuple(offset.tolist()), rest_rotation=rest, limits=limits, weight=weight)
    return checked._replace(axis=_check_axis(bone), dof_name=bone.dof_names[0] if bone.dofs in (HINGE, SLIDE) else None)


def _check_axis(bone: Bone) -> tuple[float, ...] | None:
    """Return the axis of a hinge or a slide at length one; refuse an axis or the name of a dof of other joints."""
    if bone.dofs not in (HINGE, SLIDE):
        for field in ("axis", "dof_name"):
            if getattr(bone, field) is not None:
                _refuse(bone, field, f'None for the dofs {bone.dofs!r}: it belongs to dofs="hinge" and "slide"')
        return None
    if bone.dof_name is not None and (not isinstance(bone.dof_name, str) or not bone.dof_name):
        _refuse(bone, "dof_name", "a non-empty string, or None")
    expected = "three finite numbers, not all zero: the direction of the axis"
    axis = _numbers(bone, "axis", (3,), expected)
    size = np.abs(axis).max()
    if not 0.0 < size < np.inf:
        _refuse(bone, "axis", expected)
    length = np.linalg.norm(axis)
    if not 1e-100 < size < 1e100:  # whose squares are no numbers
        axis, length = axis / size, np.linalg.norm(axis / size)
    if abs(length - 1.0) > UNIT_TOLERANCE:
        axis = axis / length
    return tuple(axis.tolist())


def axes_of(bone: Bone) -> np.ndarray:
    """Return the axes (n_dofs, 3) of a joint's angles, or of a slide, in its own axes, in the order of the columns."""
    if bone.axis is not None:
        return np.array([bone.axis], dtype=np.float64)
    return np.eye(3)[["xyz".index(letter) for letter in bone.dofs.lower()]]


def are_slides(bones: Sequence[Bone]) -> np.ndarray:
    """Return which columns (n_dofs,) of poses are displacements in m, and not angles."""
    return np.repeat([bone.is_slide for bone in bones], [bone.n_dofs for bone in bones]).astype(bool)


def is_axes(dofs: object) -> bool:
    """Return whether these are letters x, y, z in one case, at most one each."""
    return (
        isinstance(dofs, str) and len(set(dofs)) == len(dofs) and (set(dofs) <= set("xyz") or set(dofs) <= set("XYZ"))
    )


def _check_dofs(bone: Bone) -> None:
    """Refuse dofs that are neither axes nor a ball joint."""
    dofs = bone.dofs
    if bone.is_ball:
        if bone.limits is not None:
            _refuse(bone, "limits", "None for a ball joint: a range of a rotation vector's components means no posture")
        return
    if bone.dofs in (HINGE, SLIDE):
        return
    if not is_axes(dofs):
        letters = isinstance(dofs, str) and is_axes("".join(dict.fromkeys(dofs)))
        expected = (
            'letters x, y, z in one case, such as "xyz" or "ZXY", "rotvec" for a ball joint, or "hinge" or "slide" '
            "with an axis"
        )
        _refuse(bone, "dofs", "at most one each of x, y and z" if letters else expected)


def _numbers(bone: Bone, field: str, shape: tuple[int, ...], expected: str) -> np.ndarray:
    """Return a field of the bone as an array of this shape, without NaN."""
    try:
        array = np.array(getattr(bone, field), dtype=np.float64)
    except (TypeError, ValueError):
        _refuse(bone, field, expected)
    if array.shape != shape or np.isnan(array).any():
        _refuse(bone, field, expected)
    return array


def _refuse(bone: Bone, field: str, expected: str) -> NoReturn:
    raise ValueError(f"bone {bone.name!r}: {field} must be {expected}, got {getattr(bone, field)!r}")


def mean_bone(bones: Sequence[Bone]) -> Bone:
    """Mean of one bone over several skeletons, for `Skeleton.mean`."""
    first = bones[0]
    if any(bone.weight != first.weight for bone in bones):
        raise ValueError(
            f"bone {first.name!r} has different weights in the skeletons, and no mean of them is meant: give the "
            "weights to the mean skeleton instead, with with_weights"
        )
    offsets = np.array([bone.offset for bone in bones])
    lengths = np.linalg.norm(offsets, axis=1)
    direction = (offsets / np.where(lengths > 0, lengths, 1.0)[:, None]).sum(axis=0)
    spread = np.linalg.norm(direction)
    if lengths.any() and spread < ROTATION_TOLERANCE:
        raise ValueError(f"bone {first.name!r} points in opposite directions and has no mean direction")
    offset = direction * (lengths.mean() / spread) if spread > 0 else offsets[0]
    if (offsets == offsets[0]).all():  # to the last bit, so that the mean of one skeleton is that skeleton
        offset = offsets[0]
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
