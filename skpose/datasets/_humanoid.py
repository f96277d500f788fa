"""The skeleton of generated people."""

from collections.abc import Mapping, Sequence
from numbers import Real
from typing import NamedTuple

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


# --- spreads ----------------------------------------------------------------------------------------------------------
# Differences between people, and between recordings of one person, as measured; standard deviations in degrees.
#
# `POSTURE` and `STYLE`: 50 walks and runs of eight people (28 walks and 12 runs of five in CMU, ten jogs of three in
# HDM05) on the joints of the humanoid, variance components by REML. With 6 degrees of freedom the true value is
# between 0.64 and 2.2 times the figure (95 %). `EXECUTION`, `TEMPO` and `TIMING`: 174 recordings of ten actions by
# three people of HDM05, likewise, with 20 degrees of freedom between people and 144 within.
#
# The figures include effects of markers and skeleton files: hands, heads and twists of upper arms differ most, and
# joints of the trunk share one rotation (r = 1). ``foot_rz`` has the figure of the second dof of the foot in the
# files. Clavicles do not move in the files.


class Spread(NamedTuple):
    """Standard deviations of the mean of a dof in gait, degrees."""

    shared: float  # over people, of the part that both sides share; of the whole in the trunk
    apart: float  # over people, of the opposite differences of the left and the right side from it
    recording: float  # over the recordings of one person, of one side
    shared_r: float = 0.0  # correlation with the same part of the parent joint, about the same axis
    apart_r: float = 0.0


class Execution(NamedTuple):
    """Standard deviations of a dof within an action, degrees, about the joint's own axes; posture apart."""

    person: float  # of a person in this action, all the time
    person_key: float  # of a person in this action, at one key pose
    recording: float  # of one repetition, all the time
    recording_key: float  # of one repetition, at one key pose


POSTURE = {
    "abdomen_rx": Spread(6.9, 0.0, 1.0),
    "abdomen_ry": Spread(1.2, 0.0, 0.3),
    "abdomen_rz": Spread(0.6, 0.0, 1.3),
    "chest_rx": Spread(5.8, 0.0, 1.3, -0.71),
    "chest_ry": Spread(2.3, 0.0, 0.8, 1.00),
    "chest_rz": Spread(2.5, 0.0, 0.6, -0.24),
    "neck_rx": Spread(5.3, 0.0, 1.1),
    "neck_ry": Spread(5.8, 0.0, 1.2, -0.02),
    "neck_rz": Spread(7.2, 0.0, 0.7, -0.89),
    "head_rx": Spread(14.1, 0.0, 4.7, -0.68),
    "head_ry": Spread(12.4, 0.0, 2.7, 1.00),
    "head_rz": Spread(10.7, 0.0, 1.8, -0.89),
    "thigh_rx": Spread(5.6, 1.7, 1.9),
    "thigh_ry": Spread(2.7, 2.3, 1.2),
    "thigh_rz": Spread(1.4, 2.4, 1.2),
    "shank_rx": Spread(5.6, 2.2, 2.9, -0.54, -0.95),
    "foot_rx": Spread(4.7, 1.7, 2.3, 0.10, -0.80),
    "foot_rz": Spread(4.9, 4.0, 1.7),
    "toes_rx": Spread(4.9, 4.1, 2.8, 0.54, -0.52),
    "clavicle_ry": Spread(0.0, 0.0, 0.0),
    "clavicle_rz": Spread(0.0, 0.0, 0.0),
    "upper_arm_rx": Spread(8.3, 3.3, 1.9),
    "upper_arm_ry": Spread(8.7, 5.9, 3.9),
    "upper_arm_rz": Spread(3.7, 2.9, 2.0),
    "forearm_rx": Spread(5.8, 5.5, 4.4, -0.97, -0.69),
    "hand_rx": Spread(5.3, 17.3, 3.1, 0.39, -0.61),
    "hand_rz": Spread(9.1, 6.4, 3.4),
}
# Standard deviations over people of the logarithm of the amplitude of a curve, and of its phase after the hip, cycles.
STYLE = {
    "hip_flexion": (0.13, 0.000),
    "hip_adduction": (0.32, 0.030),
    "knee_flexion": (0.13, 0.038),
    "ankle_dorsiflexion": (0.04, 0.067),
    "shoulder_flexion": (0.31, 0.048),
    "elbow_flexion": (0.41, 0.048),
    "trunk_rotation": (0.39, 0.020),
}


EXECUTION = {
    "abdomen_rx": Execution(4.2, 2.9, 2.9, 3.4),
    "abdomen_ry": Execution(1.7, 1.3, 1.3, 1.5),
    "abdomen_rz": Execution(1.9, 1.8, 2.2, 2.2),
    "chest_rx": Execution(2.9, 1.5, 2.2, 2.5),
    "chest_ry": Execution(2.8, 1.8, 2.1, 2.3),
    "chest_rz": Execution(2.2, 2.2, 1.7, 2.2),
    "neck_rx": Execution(5.1, 2.4, 3.0, 3.1),
    "neck_ry": Execution(2.7, 1.6, 1.7, 1.9),
    "neck_rz": Execution(3.6, 1.4, 2.1, 1.8),
    "head_rx": Execution(5.3, 3.6, 5.5, 5.2),
    "head_ry": Execution(5.1, 3.4, 3.5, 3.6),
    "head_rz": Execution(7.4, 3.7, 4.2, 4.6),
    "thigh_rx": Execution(4.0, 5.1, 4.4, 6.6),
    "thigh_ry": Execution(4.3, 4.8, 3.0, 5.4),
    "thigh_rz": Execution(3.4, 4.2, 4.6, 6.6),
    "shank_rx": Execution(3.5, 5.7, 7.3, 9.3),
    "foot_rx": Execution(4.9, 7.5, 10.1, 17.4),
    "foot_rz": Execution(14.9, 5.9, 12.0, 9.9),
    "toes_rx": Execution(5.2, 4.8, 6.5, 5.9),
    "clavicle_ry": Execution(0.0, 0.0, 0.0, 0.0),
    "clavicle_rz": Execution(0.0, 0.0, 0.0, 0.0),
    "upper_arm_rx": Execution(6.5, 6.0, 7.3, 8.0),
    "upper_arm_ry": Execution(21.0, 8.2, 12.3, 12.6),
    "upper_arm_rz": Execution(6.8, 4.8, 3.8, 5.1),
    "forearm_rx": Execution(13.7, 6.0, 8.8, 10.8),
    "hand_rx": Execution(5.9, 3.1, 5.4, 4.5),
    "hand_rz": Execution(9.9, 4.4, 5.4, 4.3),
}
# Standard deviations of a person in an action, and of one repetition: of the logarithm of the duration, and of the
# share of the duration by which the middle is late.
TEMPO = (0.114, 0.162)
TIMING = (0.044, 0.065)


def posture_of_person(rng: np.random.RandomState, dof_names: Sequence[str]) -> np.ndarray:
    """Draw a person's deviation (n_dofs,) from the mean posture, degrees."""
    shared, apart = (
        _along_the_limbs(rng, {key: getattr(spread, f"{part}_r") for key, spread in POSTURE.items()})
        for part in ("shared", "apart")
    )
    posture: dict[str, float] = {}
    for key, spread in POSTURE.items():
        both, other = spread.shared * shared[key], spread.apart * apart[key]
        mirrored = (both - other) * (1.0 if key.endswith("x") else -1.0)
        posture |= {key: both, f"left_{key}": both + other, f"right_{key}": mirrored}
    return np.array([posture[name] for name in dof_names])


def _along_the_limbs(rng: np.random.RandomState, r: dict[str, float]) -> dict[str, float]:
    """Draw a standard normal number for each dof, correlated with the parent joint about the same axis."""
    drawn: dict[str, float] = {}
    for key, correlation in r.items():
        before = drawn.get(f"{PARENTS[key[:-3]]}{key[-3:]}", 0.0)
        drawn[key] = correlation * before + np.sqrt(1.0 - correlation**2) * rng.standard_normal()
    return drawn


def draw(
    rng: np.random.RandomState, table: Mapping[str, NamedTuple], part: str, dof_names: Sequence[str], n: int = 1
) -> np.ndarray:
    """Draw independent deviations (n, n_dofs) with the standard deviations of a part of a table, degrees."""
    spread = [getattr(table[name.removeprefix("left_").removeprefix("right_")], part) for name in dof_names]
    return np.array(spread) * rng.standard_normal((n, len(dof_names)))


def style_of_person(rng: np.random.RandomState) -> dict[str, tuple[float, float]]:
    """Draw a person's factor of the amplitude and shift of the phase, cycles, of every curve."""
    return {
        curve: (float(np.exp(amplitude * rng.standard_normal())), phase * rng.standard_normal())
        for curve, (amplitude, phase) in STYLE.items()
    }
