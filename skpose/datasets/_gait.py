"""Generated walking and running after published joint-angle curves.

The curves have the shape, the timing and the peaks that the sources below report as means of healthy adults. They are
drawn by hand, to whole degrees at every twentieth of the gait cycle, and stored as Fourier series: good enough to try a
method, and no substitute for measurements. The rotation and lean of the trunk, and the swing of the arms in running,
are round figures of our own, as are the spreads over people.

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
Segment lengths: R. Drillis, R. Contini, M. Bluestein, "Body segment parameters: a survey of measurement techniques",
Artificial Limbs 8, 1964, as fractions of the height.
"""

from collections.abc import Mapping, Sequence
from numbers import Integral, Real

import numpy as np
from sklearn.utils import check_random_state

from skpose._compat.sklearn import Interval, validate_params
from skpose.datasets._motions import MotionDataset
from skpose.skeleton import Bone, Motion, Skeleton
from skpose.skeleton._proportions import MEAN_HEIGHT, PROPORTIONS

# Bones with x to the left, y up and z forward; lengths as fractions of the height. A positive rotation about x moves
# a bone that points down backward and a bone that points forward down, so flexion of hip, shoulder and elbow and
# dorsiflexion of the ankle are negative, flexion of the knee is positive.
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

# Degrees at every twentieth of the cycle, which begins when the left foot strikes the ground; left side. The trunk's
# rotation is positive with the left shoulder back.
_N_POINTS = 20
_CURVES = {
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
_CADENCE = {"walk": (0.93, 0.05), "run": (1.40, 0.07)}  # cycles per second: mean and spread over subjects

# The dof of one side that a curve gives: its name, the sign of its rotation, and whether the right side has the other.
_LIMB_DOFS: dict[str, tuple[str, float, bool]] = {
    "hip_flexion": ("thigh_rx", -1, False),
    "hip_adduction": ("thigh_rz", -1, True),
    "knee_flexion": ("shank_rx", 1, False),
    "ankle_dorsiflexion": ("foot_rx", -1, False),
    "shoulder_flexion": ("upper_arm_rx", -1, False),
    "elbow_flexion": ("forearm_rx", -1, False),
}

# Spreads (standard deviations) over people and over recordings.
_HEIGHT = (MEAN_HEIGHT, 0.09)  # m: mean and spread
_PROPORTION = 0.04  # of each segment's length, relative
_AMPLITUDE = 0.15  # of every curve, relative
_PHASE = 0.015  # of every curve, cycles
_TEMPO = 0.03  # of a recording's cadence, relative
_DAY = 0.3  # of posture from recording to recording, as a share of its spread over people
_SWAY = 1.0  # slow variation of every dof within a recording, degrees
_NOISE = 0.3  # of the measurement, degrees a frame
# Spread of the mean of a dof over people, degrees: small in the trunk, which must balance, larger towards the ends of
# the limbs, largest in the hands, which gait leaves free. Rotations about a limb's own axis (ry) also include errors of
# the markers' positions.
_POSTURE = {
    "abdomen": 3.0,
    "chest": 3.0,
    "neck": 6.0,
    "head": 6.0,
    "thigh": 4.0,
    "shank": 4.0,
    "foot": 5.0,
    "toes": 8.0,
    "clavicle": 4.0,
    "upper_arm": 8.0,
    "forearm": 10.0,
    "hand": 20.0,
}
_LIMB_TWISTS = {"thigh": 8.0, "upper_arm": 15.0}


@validate_params(
    {"height": [Interval(Real, 0, None, closed="neither")], "proportions": [Mapping, None]},
    prefer_skip_nested_validation=True,
)
def humanoid(height: float = MEAN_HEIGHT, *, proportions: Mapping[str, float] | None = None) -> Skeleton:
    """Return a human skeleton with named joints, the arms pointing down at angle zero.

    Axes: x to the left, y up, z forward.

    Parameters
    ----------
    height : float, default=1.72
        Height of the person, m; segments have their average fraction of it.
    proportions : mapping of str to float, default=None
        Factors for the lengths of segments, such as ``{"thigh": 1.1}``; both sides get the same.

    Returns
    -------
    Skeleton
        Skeleton of 22 joints and 42 dofs.

    Raises
    ------
    ValueError
        For a height or a factor that is not positive, and for unknown segments.

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
    proportions = {} if proportions is None else dict(proportions)
    unknown = set(proportions) - {name for name, *_ in (*_TRUNK, *_SIDE)}
    if unknown:
        known = ", ".join(name for name, *_ in (*_TRUNK, *_SIDE))
        raise ValueError(f"proportions names {sorted(unknown)}, which are not among the segments: {known}")

    for name, factor in proportions.items():
        if not (isinstance(factor, Real) and 0.0 < factor < np.inf):
            raise ValueError(f"proportions must be positive numbers, got {factor!r} for {name!r}")

    def bone(side: str, name: str, parent: str | None, offset: tuple[float, float, float], dofs: str) -> Bone:
        scale = height * proportions.get(name, 1.0)
        x, y, z = (scale * component for component in offset)
        trunk = parent is None or any(parent == segment for segment, *_ in _TRUNK)
        parent = parent if trunk else f"{side}{parent}"
        return Bone(f"{side}{name}", parent, (-x if side == "right_" else x, y, z), dofs)

    sides = [bone(side, *segment) for side in ("left_", "right_") for segment in _SIDE]
    return Skeleton([*(bone("", *segment) for segment in _TRUNK), *sides])


def _series(points: Sequence[float]) -> np.ndarray:
    """Return the Fourier coefficients c_0 … c_H of a curve in degrees, so that f(t) = Re Σ c_k exp(2πi k t)."""
    coefficients = np.fft.rfft(points)[: _N_HARMONICS + 1] / len(points)
    coefficients[1:] *= 2.0
    return coefficients


def _evaluate(series: np.ndarray, phase: np.ndarray) -> np.ndarray:
    """Return the values of a Fourier series at phases in cycles."""
    return (np.exp(2j * np.pi * np.outer(phase, np.arange(len(series)))) @ series).real


@validate_params(
    {
        "n_subjects": [Interval(Integral, 1, None, closed="left")],
        "n_sequences": [Interval(Integral, 1, None, closed="left")],
        "activities": ["array-like"],
        "duration": [Interval(Real, 0, None, closed="neither")],
        "frame_rate": [Interval(Real, 0, None, closed="neither")],
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
    random_state: int | np.random.RandomState | None = None,
) -> MotionDataset:
    """Generate motions of people walking and running.

    Height, proportions, posture and style (amplitudes and phases of every curve) differ between subjects; tempo,
    starting phase and slow sway differ between recordings.

    Parameters
    ----------
    n_subjects : int, default=5
        Number of people.
    n_sequences : int, default=4
        Number of recordings of each activity by each subject.
    activities : sequence of {"walk", "run"}, default=("walk", "run")
        Activities that each subject performs.
    duration : float, default=3.0
        Length of a recording, s.
    frame_rate : float, default=60.0
        Frames per second, Hz.
    random_state : int, RandomState instance or None, default=None
        Source of all random numbers. Pass an int for the same motions at every call.

    Returns
    -------
    MotionDataset
        ``n_subjects * n_sequences * len(activities)`` motions, each on its subject's own skeleton.

    Notes
    -----
    The joint-angle curves are Fourier series of six harmonics, drawn by hand after the shape, the timing and the peaks
    of the references' normative curves. Arms and legs of the right side are half a cycle behind those of the left. The
    spreads over people and recordings are independent from dof to dof and round figures of our own.

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
    strange = [activity for activity in activities if activity not in _CURVES]
    if strange:
        raise ValueError(f"activities must be among {list(_CURVES)}, got {strange[0]!r}")
    rng = check_random_state(random_state)
    motions, subjects, trials, actions = [], [], [], []
    for subject in range(1, n_subjects + 1):
        skeleton = humanoid(
            rng.normal(*_HEIGHT),
            proportions={name: 1.0 + _PROPORTION * rng.standard_normal() for name, *_ in (*_TRUNK, *_SIDE)},
        )
        spread = _posture_spread(skeleton)
        posture = spread * rng.standard_normal(skeleton.n_dofs)
        trial = 0
        for activity in activities:
            cadence = rng.normal(*_CADENCE[activity])
            style = {
                curve: (1.0 + _AMPLITUDE * rng.standard_normal(), _PHASE * rng.standard_normal())
                for curve in _CURVES[activity]
            }
            for _ in range(n_sequences):
                trial += 1
                tempo = cadence * (1.0 + _TEMPO * rng.standard_normal())
                angles = _angles(rng, skeleton, activity, style, tempo, duration, frame_rate)
                angles += posture + _DAY * spread * rng.standard_normal(skeleton.n_dofs)
                motions.append(Motion(skeleton, np.radians(angles), frame_rate))
                subjects.append(f"{subject:02}")
                trials.append(f"{trial:02}")
                actions.append(activity)
    return MotionDataset(motions, subjects, trials, actions)


def _posture_spread(skeleton: Skeleton) -> np.ndarray:
    """Return the spread of the mean of every dof over people, degrees."""
    spread = []
    for bone in skeleton.bones:
        segment = bone.name.removeprefix("left_").removeprefix("right_")
        twist = _LIMB_TWISTS.get(segment, _POSTURE.get(segment))
        spread += [twist if axis == "y" else _POSTURE[segment] for axis in bone.dofs]
    return np.array(spread)


def _angles(
    rng: np.random.RandomState,
    skeleton: Skeleton,
    activity: str,
    style: Mapping[str, tuple[float, float]],
    tempo: float,
    duration: float,
    frame_rate: float,
) -> np.ndarray:
    """Return the angles (n_frames, n_dofs) of one recording in degrees, without the subject's posture."""
    times = np.arange(max(1, round(duration * frame_rate))) / frame_rate
    phase = rng.uniform() + tempo * times
    column = {name: i for i, name in enumerate(skeleton.dof_names)}
    angles = np.zeros((len(times), skeleton.n_dofs))
    for curve, points in _CURVES[activity].items():
        amplitude, shift = style[curve]
        series = _series(points)
        series[1:] *= amplitude
        if curve in _LIMB_DOFS:
            dof, sign, mirrored = _LIMB_DOFS[curve]
            left, right = (_evaluate(series, phase + shift + lag) for lag in (0.0, 0.5))
            angles[:, column[f"left_{dof}"]] = sign * left
            angles[:, column[f"right_{dof}"]] = (-sign if mirrored else sign) * right
        else:
            dofs = {"trunk_rotation": ("abdomen_ry", "chest_ry"), "trunk_lean": ("abdomen_rx", "chest_rx")}[curve]
            for dof in dofs:
                angles[:, column[dof]] = _evaluate(series, phase + shift) / len(dofs)
    # Arms point a little away from the trunk, feet a little outward; the head stays level when the trunk leans.
    for side, sign in (("left", 1.0), ("right", -1.0)):
        angles[:, column[f"{side}_upper_arm_rz"]] += sign * 8.0
        angles[:, column[f"{side}_thigh_ry"]] += sign * 5.0
    angles[:, column["neck_rx"]] -= angles[:, column["chest_rx"]] + angles[:, column["abdomen_rx"]]
    slow = np.stack([np.sin(2 * np.pi * k * times / (2 * duration)) for k in (1, 2, 3)], axis=1)
    angles += _SWAY * slow @ rng.standard_normal((3, skeleton.n_dofs))
    angles += _NOISE * rng.standard_normal(angles.shape)
    return angles
