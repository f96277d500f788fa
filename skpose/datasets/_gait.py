"""Generated walks and runs: published joint-angle curves, with measured differences between people.

The curves have the shape, timing and peaks of the means of healthy adults in the sources below, drawn by hand to whole
degrees at every twentieth of the gait cycle. They cannot replace measurements. The rotation and lean of the
trunk, and the swing of the arms in running, are round figures of our own.

Sources
-------
Walking, legs: M. P. Kadaba, H. K. Ramakrishnan, M. E. Wootten, "Measurement of lower extremity kinematics during level
walking", J. Orthop. Res. 8, 1990, doi:10.1002/jor.1100080310.
Running, legs: T. F. Novacheck, "The biomechanics of running", Gait & Posture 7, 1998,
doi:10.1016/S0966-6362(97)00038-6.
Walking, arms: M. P. Murray, S. B. Sepic, E. J. Barnard, "Patterns of sagittal rotation of the upper limbs in walking",
Physical Therapy 47, 1967, doi:10.1093/ptj/47.4.272.
Running, elbows: A. K. Yegian, Y. Tucker, S. Gillinov, D. E. Lieberman, "Straight arm walking, bent arm running:
gait-specific elbow angles", J. Exp. Biol. 222, 2019, doi:10.1242/jeb.197228.
"""

import re
from collections.abc import Mapping, Sequence
from numbers import Integral, Real
from typing import NamedTuple

import numpy as np
from sklearn.utils import check_random_state

from skpose._utils.sklearn import Interval, StrOptions, validate_params
from skpose.datasets._motions import MotionDataset, Rotations
from skpose.datasets._performance import ACTIONS, perform
from skpose.skeleton import Bone, Motion, Skeleton
from skpose.skeleton._proportions import MEAN_HEIGHT, PROPORTIONS

# --- people -----------------------------------------------------------------------------------------------------------


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


# --- gait -------------------------------------------------------------------------------------------------------------


# Degrees at every twentieth of the cycle, which begins when the left foot strikes the ground; left side. The trunk's
# rotation is positive with the left shoulder back.
_N_POINTS = 20
CURVES = {
    "walk": {
        "hip_flexion": (30, 29, 26, 22, 16, 10, 4, -1, -6, -10, -11, -10, -4, 5, 15, 24, 30, 33, 33, 31),
        "hip_adduction": (0, 3, 6, 6, 5, 4, 4, 3, 2, 1, -1, -4, -6, -6, -5, -4, -3, -2, -1, -1),
        "knee_flexion": (5, 11, 17, 19, 17, 13, 9, 6, 5, 7, 13, 24, 39, 53, 60, 59, 49, 33, 16, 5),
        "ankle_dorsiflexion": (0, -5, -3, 2, 5, 7, 8, 9, 10, 10, 6, -4, -15, -18, -11, -4, 0, 1, 1, 1),
        "shoulder_flexion": (-24, -23, -20, -16, -11, -6, -1, 3, 6, 8, 8, 7, 4, 1, -4, -9, -14, -18, -21, -23),
        "elbow_flexion": (20, 20, 21, 22, 24, 27, 30, 33, 36, 38, 38, 37, 35, 32, 29, 26, 24, 22, 21, 20),
        "trunk_rotation": (5, 5, 4, 3, 2, 0, -2, -3, -4, -5, -5, -5, -4, -3, -2, 0, 2, 3, 4, 5),
        "trunk_lean": (3,) * _N_POINTS,
    },
    "run": {
        "hip_flexion": (42, 40, 36, 30, 22, 13, 4, -4, -8, -8, -3, 6, 18, 30, 41, 49, 53, 53, 50, 46),
        "hip_adduction": (2, 6, 9, 10, 8, 5, 1, -3, -5, -6, -5, -3, -2, -1, -1, -1, -1, 0, 0, 1),
        "knee_flexion": (22, 33, 42, 45, 42, 35, 27, 21, 22, 34, 54, 74, 89, 95, 92, 80, 61, 40, 24, 18),
        "ankle_dorsiflexion": (5, 12, 20, 25, 25, 19, 7, -9, -21, -21, -14, -7, -2, 1, 2, 3, 4, 5, 5, 5),
        "shoulder_flexion": (-45, -44, -40, -33, -25, -16, -7, 2, 9, 13, 15, 14, 10, 4, -5, -14, -23, -32, -39, -44),
        "elbow_flexion": (88, 88, 86, 84, 82, 81, 82, 85, 89, 93, 96, 97, 97, 96, 94, 93, 92, 91, 90, 89),
        "trunk_rotation": (13, 13, 11, 8, 4, 0, -4, -8, -11, -13, -13, -13, -11, -8, -4, 0, 4, 8, 11, 13),
        "trunk_lean": (9,) * _N_POINTS,
    },
}
_N_HARMONICS = 6  # higher ones contain only the rounding to whole degrees

# The dofs that follow a curve: their names, factors, and lags in cycles. The right limbs are half a cycle behind.
DOFS: dict[str, tuple[tuple[str, float, float], ...]] = {
    "hip_flexion": (("left_thigh_rx", -1, 0), ("right_thigh_rx", -1, 0.5)),
    "hip_adduction": (("left_thigh_rz", -1, 0), ("right_thigh_rz", 1, 0.5)),
    "knee_flexion": (("left_shank_rx", 1, 0), ("right_shank_rx", 1, 0.5)),
    "ankle_dorsiflexion": (("left_foot_rx", -1, 0), ("right_foot_rx", -1, 0.5)),
    "shoulder_flexion": (("left_upper_arm_rx", -1, 0), ("right_upper_arm_rx", -1, 0.5)),
    "elbow_flexion": (("left_forearm_rx", -1, 0), ("right_forearm_rx", -1, 0.5)),
    "trunk_rotation": (("abdomen_ry", 0.5, 0), ("chest_ry", 0.5, 0)),
    "trunk_lean": (("abdomen_rx", 0.5, 0), ("chest_rx", 0.5, 0)),
}
# Mean and standard deviation over people: round figures of our own.
_HEIGHT = (MEAN_HEIGHT, 0.09)  # m
_PROPORTION = 0.04  # relative, of the length of each segment
_CADENCE = {"walk": (0.93, 0.05), "run": (1.40, 0.07)}  # cycles per second
# Standard deviations within one person: round figures too.
_TEMPO = 0.03  # relative, of the cadence of a recording
_SWAY = 1.0  # slow variation of every dof within a recording, degrees
_NOISE = 0.3  # of the measurement, degrees a frame


@validate_params(
    {
        "n_subjects": [Interval(Integral, 1, None, closed="left")],
        "n_sequences": [Interval(Integral, 1, None, closed="left")],
        "activities": ["array-like"],
        "duration": [Interval(Real, 0, None, closed="neither")],
        "frame_rate": [Interval(Real, 0, None, closed="neither")],
        "rotations": [StrOptions({"rotvec", "file"})],
        "random_state": ["random_state"],
    },
    prefer_skip_nested_validation=True,
)
def make_gait(
    n_subjects: int = 5,
    n_sequences: int = 4,
    *,
    activities: Sequence[str] = ("walk", "run"),
    duration: float = 3.0,
    frame_rate: float = 60.0,
    rotations: Rotations = "rotvec",
    random_state: int | np.random.RandomState | None = None,
) -> MotionDataset:
    """Generate motions of people who walk and run on the spot.

    Height, proportions, posture and style (amplitude and phase of each curve) differ between subjects; tempo, starting
    phase, posture and slow sway differ between recordings.

    Parameters
    ----------
    n_subjects : int, default=5
        Number of people.
    n_sequences : int, default=4
        Number of recordings of each activity by each subject.
    activities : sequence of {"walk", "run"}, default=("walk", "run")
        Activities of each subject.
    duration : float, default=3.0
        Length of a recording, s.
    frame_rate : float, default=60.0
        Frames per second, Hz.
    rotations : {"rotvec", "file"}, default="rotvec"
        Whether joints are ball joints or have two or three Euler angles, see `MotionDataset`.
    random_state : int, RandomState instance or None, default=None
        Source of random numbers. Pass an int for the same motions at every call.

    Returns
    -------
    MotionDataset
        ``n_subjects * n_sequences * len(activities)`` motions, each on its subject's own skeleton.

    Notes
    -----
    The joint-angle curves are Fourier series of six harmonics, drawn by hand after the normative curves of the
    references. The right arm and leg are half a cycle behind the left ones.

    Posture and style have the standard deviations between people, and between recordings of one person, measured on
    eight people of the databases CMU and HDM05: over people 6° in the median dof, 1° to 14° in the trunk, 3° to 6° in
    the legs, 5° to 11° in the arms and 11° to 18° in the hands; over recordings 2°. Spreads of height, proportions,
    cadence and sway are round figures.

    References
    ----------
    .. [1] M. P. Kadaba, H. K. Ramakrishnan, M. E. Wootten, "Measurement of lower extremity kinematics during level
       walking", J. Orthop. Res. 8, 1990, :doi:`10.1002/jor.1100080310`.
    .. [2] T. F. Novacheck, "The biomechanics of running", Gait & Posture 7, 1998,
       :doi:`10.1016/S0966-6362(97)00038-6`.
    .. [3] M. P. Murray, S. B. Sepic, E. J. Barnard, "Patterns of sagittal rotation of the upper limbs in walking",
       Physical Therapy 47, 1967, :doi:`10.1093/ptj/47.4.272`.
    .. [4] A. K. Yegian et al., "Straight arm walking, bent arm running: gait-specific elbow angles", J. Exp. Biol. 222,
       2019, :doi:`10.1242/jeb.197228`.

    Examples
    --------
    >>> from skpose.datasets import make_gait
    >>> make_gait(n_subjects=3, n_sequences=2, activities=["walk"], random_state=0)
    MotionDataset(6 motions of 3 subjects: 6 walk)
    """
    if unknown := [activity for activity in activities if activity not in CURVES]:
        raise ValueError(f"activities must be among {list(CURVES)}, got {unknown[0]!r}")
    rng, motions = check_random_state(random_state), list[Motion]()
    for _ in range(n_subjects):
        skeleton = person(rng)
        posture, style = posture_of_person(rng, skeleton.dof_names), style_of_person(rng)
        for activity in activities:
            cadence = rng.normal(*_CADENCE[activity])
            for _ in range(n_sequences):
                tempo = cadence * (1.0 + _TEMPO * rng.standard_normal())
                angles = _angles(rng, skeleton, activity, style, tempo, duration, frame_rate)
                angles += posture + draw(rng, POSTURE, "recording", skeleton.dof_names)
                motions.append(Motion(skeleton, np.radians(angles), frame_rate))
    return _label(motions, n_subjects, activities, n_sequences, rotations)


def _label(
    motions: Sequence[Motion], n_subjects: int, actions: Sequence[str], n_sequences: int, rotations: Rotations
) -> MotionDataset:
    """The motions of each person, of each action, one after another, with their labels."""
    n = len(actions) * n_sequences
    subjects = np.repeat([f"{subject:02}" for subject in range(1, n_subjects + 1)], n)
    trials = [f"{trial:02}" for trial in range(1, n + 1)] * n_subjects
    labels = np.tile(np.repeat(actions, n_sequences), n_subjects)
    return MotionDataset(motions, subjects, trials, labels, rotations=rotations)


def person(rng: np.random.RandomState) -> Skeleton:
    """Draw the skeleton of a person."""
    height = rng.normal(*_HEIGHT)
    return humanoid(height, proportions={name: 1.0 + _PROPORTION * rng.standard_normal() for name in PARENTS})


def _angles(
    rng: np.random.RandomState,
    skeleton: Skeleton,
    activity: str,
    style: Mapping[str, tuple[float, float]],
    tempo: float,
    duration: float,
    frame_rate: float,
) -> np.ndarray:
    """The angles (n_frames, n_dofs) of one recording in degrees, without the posture of the subject."""
    times = np.arange(max(1, round(duration * frame_rate))) / frame_rate
    phase = rng.uniform() + tempo * times
    column = {name: i for i, name in enumerate(skeleton.dof_names)}
    angles = np.zeros((len(times), skeleton.n_dofs))
    for curve, points in CURVES[activity].items():
        amplitude, shift = style.get(curve, (1.0, 0.0))  # none for a curve that is constant
        series = series_of(points)
        series[1:] *= amplitude
        for dof, factor, lag in DOFS[curve]:
            angles[:, column[dof]] = factor * evaluate(series, phase + shift + lag)
    # Arms point a little away from the trunk, feet a little outward; the head stays level when the trunk leans.
    for side, sign in (("left", 1.0), ("right", -1.0)):
        angles[:, column[f"{side}_upper_arm_rz"]] += sign * 8.0
        angles[:, column[f"{side}_thigh_ry"]] += sign * 5.0
    angles[:, column["neck_rx"]] -= angles[:, column["chest_rx"]] + angles[:, column["abdomen_rx"]]
    slow = np.stack([np.sin(2 * np.pi * k * times / (2 * duration)) for k in (1, 2, 3)], axis=1)
    slow -= slow.mean(axis=0)  # the posture of the recording is drawn apart
    angles += _SWAY * slow @ rng.standard_normal((3, skeleton.n_dofs))
    angles += _NOISE * rng.standard_normal(angles.shape)
    return angles


def series_of(points: Sequence[float]) -> np.ndarray:
    """The Fourier coefficients c_0 … c_H of a curve in degrees: f(t) = Re Σ c_k exp(2πi k t)."""
    coefficients = np.fft.rfft(points)[: _N_HARMONICS + 1] / len(points)
    coefficients[1:] *= 2.0
    return coefficients


def evaluate(series: np.ndarray, phase: np.ndarray) -> np.ndarray:
    """The values of a Fourier series at phases in cycles."""
    return (np.exp(2j * np.pi * np.outer(phase, np.arange(len(series)))) @ series).real


# --- walks and runs ---------------------------------------------------------------------------------------------------
# The walks and runs of a dataset, by their labels.


WALKING_AND_RUNNING = ("walk", "run")


def walks_and_runs(dataset: MotionDataset) -> MotionDataset:
    """Select the walks and runs of a dataset, and label them "walk" and "run".

    A motion is selected if the first word of its action is "walk" or "run", in upper or lower case, as in CMU's "walk"
    and "Run/jog".

    Parameters
    ----------
    dataset : MotionDataset
        Motions of any actions.

    Returns
    -------
    MotionDataset
        The selected motions; their `actions` are "walk" or "run".

    Raises
    ------
    ValueError
        If walks or runs are missing.

    Examples
    --------
    >>> from skpose.datasets import make_gait, walks_and_runs
    >>> walks_and_runs(make_gait(n_subjects=2, n_sequences=1, random_state=0))
    MotionDataset(4 motions of 2 subjects: 2 run, 2 walk)
    """
    first = np.array([re.split(r"\W", action.strip().lower())[0] for action in dataset.actions])
    if missing := set(WALKING_AND_RUNNING) - set(first):
        raise ValueError(f"dataset must have walks and runs, but no action begins with {min(missing)!r}")
    chosen = dataset[np.isin(first, WALKING_AND_RUNNING)]
    chosen.actions = first[np.isin(first, WALKING_AND_RUNNING)]
    return chosen


# --- actions ----------------------------------------------------------------------------------------------------------
# Key poses of our own, with measured differences between people.


_LATEST = 0.2  # share of the duration; from 0.25 on, time would run backwards


@validate_params(
    {
        "n_subjects": [Interval(Integral, 1, None, closed="left")],
        "n_sequences": [Interval(Integral, 1, None, closed="left")],
        "actions": ["array-like", None],
        "frame_rate": [Interval(Real, 0, None, closed="neither")],
        "rotations": [StrOptions({"rotvec", "file"})],
        "random_state": ["random_state"],
    },
    prefer_skip_nested_validation=True,
)
def make_actions(
    n_subjects: int = 3,
    n_sequences: int = 6,
    *,
    actions: Sequence[str] | None = None,
    frame_rate: float = 60.0,
    rotations: Rotations = "rotvec",
    random_state: int | np.random.RandomState | None = None,
) -> MotionDataset:
    """Generate motions of people who jump, kick, lift, reach, sit down, squat, step up, throw, turn and wave.

    People differ in size, posture and execution of each action; their repetitions differ in tempo, timing and
    execution. The differences are those measured on recordings.

    Parameters
    ----------
    n_subjects : int, default=3
        Number of people.
    n_sequences : int, default=6
        Number of repetitions of each action by each subject.
    actions : sequence of str, default=None
        Actions of each subject; None is all ten.
    frame_rate : float, default=60.0
        Frames per second, Hz.
    rotations : {"rotvec", "file"}, default="rotvec"
        Whether joints are ball joints or have two or three Euler angles, see `MotionDataset`.
    random_state : int, RandomState instance or None, default=None
        Source of random numbers. Pass an int for the same motions at every call.

    Returns
    -------
    MotionDataset
        ``n_subjects * n_sequences`` motions of each action, of about one to four seconds, each on its subject's own
        skeleton, with the movement of the root.

    Raises
    ------
    ValueError
        For an unknown action.

    See Also
    --------
    make_gait : Walking and running, from published joint-angle curves.

    Notes
    -----
    Each action has four to eight key poses of our own: angles of trunk and arms, places of pelvis and feet relative to
    the length of the leg. All people use the right hand, begin with the right foot, and turn to the left, as in HDM05;
    `Motion.mirrored` gives the other side.

    At each key pose a joint departs by a rotation about its own axes, the sum of five normal numbers: the posture of
    the person, as in `make_gait`; the person in this action at all times, and at this key pose; the repetition at all
    times, and at this key pose. The standard deviations of the last four are measured on ten actions of three people of
    HDM05: 4.3°, 3.6°, 3.8° and 4.5° in the median dof. The tempo, 11 % of a person and 16 % of a
    repetition, and the lateness of the middle, 4 % and 7 % of the duration, are measured, too.

    The legs follow pelvis and feet. Standing feet do not slide, and the pelvis stays above them. Elbows, knees, wrists
    and the rotation of the upper arm stay within human limits. Measurement noise is not added.

    References
    ----------
    M. Müller, T. Röder, M. Clausen, B. Eberhardt, B. Krüger, A. Weber, "Documentation Mocap Database HDM05", technical
    report CG-2007-2, Universität Bonn, 2007.

    Examples
    --------
    >>> from skpose.datasets import make_actions
    >>> make_actions(n_subjects=2, n_sequences=3, actions=["squat", "wave"], random_state=0)
    MotionDataset(12 motions of 2 subjects: 6 squat, 6 wave)
    """
    actions = tuple(ACTIONS) if actions is None else actions
    if unknown := [action for action in actions if action not in ACTIONS]:
        raise ValueError(f"actions must be among {list(ACTIONS)}, got {unknown[0]!r}")
    rng = check_random_state(random_state)
    motions = list[Motion]()
    for _ in range(n_subjects):
        skeleton = person(rng)
        names = skeleton.dof_names
        posture = posture_of_person(rng, names)
        for label in actions:
            action = ACTIONS[label]
            spread = _spread_over_keys([key.time for key in action.keys])

            def departures(part: str, names: Sequence[str] = names, spread: np.ndarray = spread) -> np.ndarray:
                always = draw(rng, EXECUTION, part, names)
                return always + spread @ draw(rng, EXECUTION, f"{part}_key", names, len(spread))

            own = posture + departures("person")
            tempo, late = (deviation[0] * rng.standard_normal() for deviation in (TEMPO, TIMING))
            for _ in range(n_sequences):
                this = np.radians(own + departures("recording"))
                duration = action.duration * np.exp(tempo + TEMPO[1] * rng.standard_normal())
                lateness = np.clip(late + TIMING[1] * rng.standard_normal(), -_LATEST, _LATEST)
                motions.append(perform(skeleton, action, this, duration, lateness, frame_rate))
    return _label(motions, n_subjects, actions, n_sequences, rotations)


def _spread_over_keys(times: Sequence[float]) -> np.ndarray:
    """The matrix (n_keys, n_keys) from independent numbers to departures at key poses.

    Interpolation averages departures, and their mean over time is a part of its own. So they are enlarged and their
    mean is subtracted; their mean square over nine phases is then the measured one.
    """
    phases = np.linspace(0.0, 1.0, 9)
    weights = np.stack([np.interp(phases, times, key) for key in np.eye(len(times))], axis=1)  # (n_phases, n_keys)
    mean = weights.mean(axis=0)
    size = np.sqrt(np.mean(np.square(weights - mean).sum(axis=1)))
    return (np.eye(len(times)) - mean) / size
