"""Conversion of poses from and to quaternions, matrices, six numbers or rotation vectors."""

from collections.abc import Callable
from typing import Literal, NamedTuple, get_args

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.typing import ArrayLike
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import check_choice, check_is_array, check_poses, check_skeleton
from skpose.skeleton._bone import Bone, with_columns
from skpose.skeleton._rotations import fit_columns, rotations_of
from skpose.skeleton._skeleton import Skeleton

RotationForm = Literal["quaternion_wxyz", "quaternion_xyzw", "matrix", "6d", "rotvec"]
TOLERANCE = 1e-3  # of lengths, of products of columns, and of hinges' angles, rad: three digits, or half precision


def poses_from_rotations(rotations: ArrayLike, skeleton: Skeleton, *, form: RotationForm) -> np.ndarray:
    """Convert rotations of the joints in another form to poses.

    Parameters
    ----------
    rotations : array-like of shape (n_poses, n_rotating_joints, ...)
        The rotation of each joint that has dofs, in the order of the skeleton's bones:
        ``[bone.name for bone in skeleton.bones if bone.dofs]``. A rotation takes the joint's axes from those at angle
        zero to the pose. It excludes the constant `rest_rotation` of the bone.
    skeleton : Skeleton
        The skeleton of the poses.
    form : {"quaternion_wxyz", "quaternion_xyzw", "matrix", "6d", "rotvec"}
        Meaning of the last axes. Unit quaternions of shape (4,), real part first or last: q and −q are one rotation.
        "matrix": rotation matrices, (3, 3). "6d": the first column of the matrix, then the second, (6,), as networks
        predict them; they are made orthonormal by the Gram-Schmidt method. "rotvec": axis times angle, rad, (3,).

    Returns
    -------
    ndarray of shape (n_poses, n_dofs)
        Columns ``skeleton.dof_names``, rad. Among equivalent numbers, those nearest to zero; `Motion.unwrap` makes
        them continuous in time.

    Raises
    ------
    ValueError
        For an unknown form, another shape, numbers that are not finite, quaternions and matrices that are off by more
        than 0.001, two parallel columns of "6d"; and for a joint with one or two dofs whose rotation misses its axes by
        more than 0.001 rad. The message names joint and pose.

    See Also
    --------
    rotations_from_poses : The inverse.
    Skeleton.to_rotvec : A skeleton with ball joints, which take any rotation.

    References
    ----------
    Y. Zhou et al., "On the continuity of rotation representations in neural networks", CVPR 2019,
    :doi:`10.1109/CVPR.2019.00589`, for "6d".

    Examples
    --------
    >>> from skpose import Bone, Skeleton
    >>> from skpose.skeleton import poses_from_rotations
    >>> arm = Skeleton([Bone("elbow", None, (0.3, 0, 0), "rotvec"), Bone("wrist", "elbow", (0.25, 0, 0), "z")])
    >>> half, quarter = [0.0, 1.0, 0.0, 0.0], [0.5**0.5, 0.0, 0.0, 0.5**0.5]
    >>> poses_from_rotations([[half, quarter]], arm, form="quaternion_wxyz").round(3)
    array([[3.142, 0.   , 0.   , 1.571]])
    """
    check_choice("form", form, get_args(RotationForm))
    bones, form_of = _bones_with_dofs(skeleton), FORMS[form]
    array = np.array(rotations, dtype=np.float64)  # a copy: see `rotations_of`
    expected = (len(bones), *form_of.shape)
    if array.shape[1:] != expected:
        raise ValueError(f"rotations must have shape (n_poses, {str(expected)[1:]} for {form!r}, got {array.shape}")
    if not len(array):
        return np.zeros((0, skeleton.n_dofs))
    infinite = ~np.isfinite(array.reshape(len(array) * len(bones), -1))
    _refuse(np.asarray(infinite.any(axis=1)), bones, "must be finite numbers")
    flat = form_of.read(array.reshape(-1, *form_of.shape), lambda bad, expected: _refuse(bad, bones, expected))
    columns, missed = zip(*(fit_columns(bone, flat[i :: len(bones)]) for i, bone in enumerate(bones)), strict=True)
    bad = np.stack(missed, axis=1).ravel() > TOLERANCE
    _refuse(bad, bones, 'must be about the axes of its dofs; dofs="rotvec" takes any rotation')
    return np.concatenate(columns, axis=1)


def rotations_from_poses(X: ArrayLike, skeleton: Skeleton, *, form: RotationForm) -> np.ndarray:
    """Convert poses to rotations of the joints in another form.

    Parameters
    ----------
    X : array-like of shape (n_poses, n_dofs)
        Poses, rad.
    skeleton : Skeleton
        Their skeleton.
    form : {"quaternion_wxyz", "quaternion_xyzw", "matrix", "6d", "rotvec"}
        The form, see `poses_from_rotations`. Quaternions have a real part of at least zero, rotation vectors are not
        longer than π.

    Returns
    -------
    ndarray of shape (n_poses, n_rotating_joints, ...)
        Rotations of the joints that have dofs, in the order of the skeleton's bones.

    Raises
    ------
    ValueError
        For an unknown form, and for poses of the wrong width, out of order by name, or not finite.

    See Also
    --------
    poses_from_rotations : The inverse.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.skeleton import rotations_from_poses
    >>> rotations_from_poses([[0.0, np.pi / 2]], Skeleton.chain(2), form="6d").round(3) + 0.0
    array([[[ 1.,  0.,  0.,  0.,  1.,  0.],
            [ 0.,  1.,  0., -1.,  0.,  0.]]])
    """
    check_choice("form", form, get_args(RotationForm))
    check_is_array(X, "X")
    _bones_with_dofs(skeleton)
    X = check_poses(X, skeleton, "X").astype(np.float64)
    warn_of_degrees(X=X)
    joints = [
        FORMS[form].write(rotations_of(bone, X[:, columns]))
        for bone, columns in with_columns(skeleton.bones)
        if bone.dofs
    ]
    return np.stack(joints, axis=1)


Refuse = Callable[[np.ndarray, str], None]  # called with which rotations are bad, and what is expected


class _Form(NamedTuple):
    """A form of rotations."""

    shape: tuple[int, ...]  # of one rotation
    read: Callable[[np.ndarray, Refuse], Rotation]
    write: Callable[[Rotation], np.ndarray]


def _from_quaternions(numbers: np.ndarray, refuse: Refuse) -> Rotation:
    refuse(np.abs(np.linalg.norm(numbers, axis=1) - 1.0) > TOLERANCE, "must be a quaternion of length one")
    return Rotation.from_quat(numbers)


def _from_matrices(numbers: np.ndarray, refuse: Refuse) -> Rotation:
    products = np.abs(numbers.transpose(0, 2, 1) @ numbers - np.eye(3)).max(axis=(1, 2))
    refuse((products > TOLERANCE) | (np.linalg.det(numbers) < 0.0), "must be a rotation matrix")
    return Rotation.from_matrix(numbers)


def _from_columns(numbers: np.ndarray, refuse: Refuse) -> Rotation:
    first, second = numbers[:, :3], numbers[:, 3:]
    normal = np.cross(first, second)
    lengths = [np.linalg.norm(vectors, axis=1) for vectors in (first, second, normal)]
    refuse(lengths[2] <= TOLERANCE * lengths[0] * lengths[1], "must be two columns of a rotation matrix")
    x, z = first / lengths[0][:, None], normal / lengths[2][:, None]
    return Rotation.from_matrix(np.stack([x, np.cross(z, x), z], axis=2))


FORMS = {
    "quaternion_wxyz": _Form(
        (4,),
        lambda numbers, refuse: _from_quaternions(numbers[:, [1, 2, 3, 0]], refuse),
        lambda rotations: rotations.as_quat(canonical=True)[:, [3, 0, 1, 2]],
    ),
    "quaternion_xyzw": _Form((4,), _from_quaternions, lambda rotations: rotations.as_quat(canonical=True)),
    "matrix": _Form((3, 3), _from_matrices, Rotation.as_matrix),
    "6d": _Form(
        (6,), _from_columns, lambda rotations: rotations.as_matrix()[:, :, :2].transpose(0, 2, 1).reshape(-1, 6)
    ),
    "rotvec": _Form((3,), lambda numbers, refuse: Rotation.from_rotvec(numbers), Rotation.as_rotvec),
}


def _bones_with_dofs(skeleton: Skeleton) -> list[Bone]:
    """The bones whose joints rotate; refuse slides, which rotations cannot represent."""
    check_skeleton(skeleton)
    slides = [bone.name for bone in skeleton.bones if bone.is_slide]
    if slides:
        raise ValueError(f"joint {slides[0]!r} slides, which rotations cannot represent")
    return [bone for bone in skeleton.bones if bone.dofs]


def _refuse(bad: np.ndarray, bones: list[Bone], expected: str) -> None:
    """Refuse the first bad rotation, of (n_poses * n_bones,) of bool."""
    if bad.any():
        pose, joint = np.argwhere(bad.reshape(-1, len(bones)))[0]
        raise ValueError(f"rotations[{pose}, {joint}], of joint {bones[joint].name!r}, {expected}")
