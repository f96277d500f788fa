"""A skeleton as an object of JSON, for the scripts that compute poses and distances in a page."""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton import Bone, Skeleton
from skpose.skeleton._sides import sides
from skpose.view._shape import find_shape

# Scripts that compute without a page, in the order of their dependencies.
NUMBERS = ("rotations.js", "kinematics.js", "distances.js")


def skeleton_data(skeleton: Skeleton) -> dict[str, Any]:
    """A skeleton as an object of JSON, for `new Skeleton(data)` of assets/kinematics.js.

    Parameters
    ----------
    skeleton : Skeleton
        The skeleton.

    Returns
    -------
    dict
        Of each joint: `names`, `parents` (−1 for the root), `offsets` (m), `dofs`, `axes` (of hinges), `rests`,
        `weights` and `sides` ("left", "right" or ""). A rest rotation is a unit quaternion (w, x, y, z), or
        None for the identity. The names of the columns of a pose are `columns`. `offsetFrame` is "own" or "parent",
        and `shape` has the parts of the figure.

    Examples
    --------
    >>> from skpose import Bone, Skeleton
    >>> from skpose.view._skeleton import skeleton_data
    >>> arm = Skeleton([Bone("left_arm", None, (0.3, 0, 0), "rotvec"), Bone("left_hand", "left_arm", (0.2, 0, 0), "z")])
    >>> data = skeleton_data(arm)
    >>> data["parents"], data["dofs"]
    ([-1, 0], ['rotvec', 'z'])
    """
    if slides := [bone.name for bone in skeleton.bones if bone.is_slide]:
        raise ValueError(f"skeleton must not slide, got {slides[0]!r}; player shows motions with slides")
    return {
        "names": list(skeleton.joint_names),
        "parents": skeleton.parents.tolist(),
        "offsets": skeleton.offsets.tolist(),
        "dofs": [bone.dofs for bone in skeleton.bones],
        "axes": [bone.axis for bone in skeleton.bones],
        "rests": [_rest(bone) for bone in skeleton.bones],
        "weights": skeleton.weights.tolist(),
        "sides": sides(skeleton.joint_names),
        "shape": find_shape(skeleton).data(),
        "columns": list(skeleton.dof_names),
        "offsetFrame": skeleton.offset_frame,
    }


def _rest(bone: Bone) -> list[float] | None:
    if bone.rest_rotation is None:
        return None
    return Rotation.from_matrix(np.array(bone.rest_rotation)).as_quat()[[3, 0, 1, 2]].tolist()
