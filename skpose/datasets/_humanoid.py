"""The skeleton of generated people."""

from collections.abc import Mapping
from numbers import Real

import numpy as np

from skpose._utils.sklearn import Interval, validate_params
from skpose.skeleton import Bone, Skeleton
from skpose.skeleton._proportions import MEAN_HEIGHT, PROPORTIONS

# Bones with x to the left, y up and z forward; lengths as fractions of the height. A positive rotation about x moves a
# bone that points down backward. So flexion of hip, shoulder and elbow and dorsiflexion of the ankle are negative,
# flexion of the knee is positive.
_TRUNK = (
    ("abdomen", None, (0.0, PROPORTIONS["abdomen"], 0.0), "xyz"),
    ("chest", "abdomen", (0.0, PROPORTIONS["chest"], 0.0), "xyz"),
    ("neck", "chest", (0.0, PROPORTIONS["neck"], 0.0), "xyz"),
    ("head", "neck", (0.0, PROPORTIONS["head"], 0.0), "xyz"),
)
_SIDE = (  # of the left; the right mirrors it
    ("pelvis", None, (PROPORTIONS["hip"], 0.0, 0.0), ""),
    ("thigh", "pelvis", (0.0, -PROPORTIONS["thigh"], 0.0), "xyz"),
    ("shank", "thigh", (0.0, -PROPORTIONS["shank"], 0.0), "x"),
    ("foot", "shank", (0.0, -PROPORTIONS["ankle"], PROPORTIONS["foot"]), "xz"),
    ("toes", "foot", (0.0, 0.0, PROPORTIONS["toes"]), "x"),
    ("clavicle", "chest", (PROPORTIONS["shoulder"], 0.0, 0.0), "yz"),
    ("upper_arm", "clavicle", (0.0, -PROPORTIONS["upper_arm"], 0.0), "xyz"),
    ("forearm", "upper_arm", (0.0, -PROPORTIONS["forearm"], 0.0), "x"),
    ("hand", "forearm", (0.0, -PROPORTIONS["hand"], 0.0), "xz"),
)

PARENTS = {name: parent for name, parent, *_ in (*_TRUNK, *_SIDE)}


@validate_params(
    {"height": [Interval(Real, 0, None, closed="neither")], "proportions": [Mapping, None]},
    prefer_skip_nested_validation=True,
)
def humanoid(height: float = MEAN_HEIGHT, *, proportions: Mapping[str, float] | None = None) -> Skeleton:
    """Create a human skeleton whose arms point down at angle zero.

    Axes: x to the left, y up, z forward.

    Parameters
    ----------
    height : float, default=1.72
        Height of the person, m; segments have average proportions.
    proportions : mapping of str to float, default=None
        Factors for the lengths of segments of both sides, such as ``{"thigh": 1.1}``.

    Returns
    -------
    Skeleton
        Skeleton of 22 joints and 42 dofs.

    Raises
    ------
    ValueError
        If a factor is not positive or a segment is unknown.

    References
    ----------
    R. Drillis, R. Contini, M. Bluestein, "Body segment parameters: a survey of measurement techniques", Artificial
    Limbs 8, 1964.

    Examples
    --------
    >>> from skpose.datasets import humanoid
    >>> skeleton = humanoid(1.80)
    >>> skeleton.joint_names[4:8]
    ('left_pelvis', 'left_thigh', 'left_shank', 'left_foot')
    """
    proportions = dict(proportions or {})
    if unknown := set(proportions) - set(PARENTS):
        raise ValueError(f"proportions must name segments among {', '.join(PARENTS)}, got {min(unknown)!r}")
    if not all(0.0 < factor < np.inf for factor in proportions.values()):
        raise ValueError(f"proportions must be positive, got {proportions}")

    def bone(side: str, name: str, parent: str | None, offset: tuple[float, float, float], dofs: str) -> Bone:
        scale = height * proportions.get(name, 1.0)
        x, y, z = (scale * component for component in offset)
        trunk = parent is None or any(parent == segment for segment, *_ in _TRUNK)
        parent = parent if trunk else f"{side}{parent}"
        return Bone(f"{side}{name}", parent, (-x if side == "right_" else x, y, z), dofs)

    sides = [bone(side, *segment) for side in ("left_", "right_") for segment in _SIDE]
    return Skeleton([*(bone("", *segment) for segment in _TRUNK), *sides])
