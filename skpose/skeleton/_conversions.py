"""The same motion with its joints' rotations as other numbers: methods of `Motion`."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from skpose.skeleton._continuity import continuous_columns
from skpose.skeleton._rotations import rotations_of
from skpose.skeleton._skeleton import Skeleton

if TYPE_CHECKING:
    from skpose.skeleton._motion import Motion


def to_rotvec(motion: "Motion") -> "Motion":
    """Return the same motion with joints of two or three Euler angles as ball joints, on `Skeleton.to_rotvec`.

    All joints stay where they are. Rotation vectors are continuous in time: of the vectors that are one rotation, each
    frame has the one nearest to the frame before, which may be longer than π. The root's angles stay as they are.

    Returns
    -------
    Motion
        Of the skeleton ``motion.skeleton.to_rotvec()``.

    See Also
    --------
    Motion.to_euler : Return ball joints as three Euler angles.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Bone, Motion, Skeleton
    >>> arm = Skeleton([Bone("elbow", None, (0.3, 0, 0), "xyz"), Bone("wrist", "elbow", (0.25, 0, 0), "z")])
    >>> motion = Motion(arm, [[0, np.pi / 2, 0, 1]], frame_rate=60).to_rotvec()
    >>> motion.skeleton.dof_names
    ('elbow_rotvec_x', 'elbow_rotvec_y', 'elbow_rotvec_z', 'wrist_rz')
    >>> motion.angles.round(3)
    array([[0.   , 1.571, 0.   , 1.   ]])
    """
    return _on(motion, motion.skeleton.to_rotvec())


def to_euler(motion: "Motion", order: str) -> "Motion":
    """Return the same motion with ball joints as three Euler angles in one order, on `Skeleton.to_euler`.

    All joints stay where they are. Angles are continuous in time: of the triples that are one rotation, each frame has
    the one nearest to the frame before. In gimbal lock that is one of a line of triples.

    Parameters
    ----------
    order : str
        Three different letters in the notation of `Bone`: "xyz" is extrinsic, "ZXY" intrinsic.

    Returns
    -------
    Motion
        Of the skeleton ``motion.skeleton.to_euler(order)``. Joints that have Euler angles keep theirs:
        ``motion.to_rotvec().to_euler(order)`` changes these too.

    Raises
    ------
    ValueError
        If the order is not three different letters in one case.

    See Also
    --------
    Motion.to_rotvec : Return Euler angles as ball joints.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Bone, Motion, Skeleton
    >>> arm = Skeleton([Bone("elbow", None, (0.3, 0, 0), "rotvec")])
    >>> Motion(arm, [[0, 0, 1.5]], frame_rate=60).to_euler("ZXY").angles.round(3) + 0.0
    array([[1.5, 0. , 0. ]])
    """
    return _on(motion, motion.skeleton.to_euler(order))


def _on(motion: "Motion", skeleton: Skeleton) -> "Motion":
    """Return the motion on a skeleton with the same bones in the same order, which differ in their dofs."""
    columns, first = [], 0
    for bone, other in zip(motion.skeleton.bones, skeleton.bones, strict=True):
        given = motion.angles[:, first : first + bone.n_dofs]
        first += bone.n_dofs
        if bone.dofs == other.dofs:
            columns.append(given)
        elif len(motion):
            columns.append(continuous_columns(other, rotations_of(bone, given)))
        else:
            columns.append(np.zeros((0, other.n_dofs)))
    return replace(motion, skeleton=skeleton, angles=np.concatenate(columns, axis=1))
