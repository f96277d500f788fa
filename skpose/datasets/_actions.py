"""Generated actions: key poses of our own, and people who differ as real ones do."""

from collections.abc import Sequence
from numbers import Integral, Real

import numpy as np
from sklearn.utils import check_random_state

from skpose._compat.sklearn import Interval, validate_params
from skpose.datasets._action_spreads import EXECUTION, TEMPO, TIMING
from skpose.datasets._gait import person
from skpose.datasets._key_poses import ACTIONS
from skpose.datasets._motions import MotionDataset
from skpose.datasets._performance import perform
from skpose.datasets._spreads import posture_of_person

_LATEST = 0.2  # of the duration; from 0.25 on, time would run backwards


@validate_params(
    {
        "n_subjects": [Interval(Integral, 1, None, closed="left")],
        "n_sequences": [Interval(Integral, 1, None, closed="left")],
        "actions": ["array-like", None],
        "frame_rate": [Interval(Real, 0, None, closed="neither")],
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
    random_state: int | np.random.RandomState | None = None,
) -> MotionDataset:
    """Generate motions of people who do ten actions.

    These are jump, kick, lift, reach, sit down, squat, step up, throw, turn and wave. People differ in size, posture
    and in how they do each action; their repetitions differ in tempo, timing and execution, as measured on recordings.

    Parameters
    ----------
    n_subjects : int, default=3
        Number of people; the default is that of HDM05.
    n_sequences : int, default=6
        Number of repetitions of each action by each subject; with the default there are about as many as in HDM05.
    actions : sequence of str, default=None
        Actions that each subject performs; None is all ten.
    frame_rate : float, default=60.0
        Frames per second, Hz.
    random_state : int, RandomState instance or None, default=None
        Source of all random numbers. Pass an int for the same motions at every call.

    Returns
    -------
    MotionDataset
        ``n_subjects * n_sequences`` motions of each action, of one to four seconds or so, each on its
        subject's own skeleton, `humanoid` of drawn lengths, with the movement of the root.

    Raises
    ------
    ValueError
        For an action that is none of the ten.

    See Also
    --------
    make_gait : Walking and running, from published joint-angle curves.

    Notes
    -----
    Each action has four to eight key poses of our own. They state trunk and arms by angles, pelvis and feet by where
    they are, in lengths of the leg. Everybody uses the right hand, begins with the right foot, and turns to the left,
    as in HDM05, whose actions name the side; `Motion.mirrored` is the other one.

    At each key pose a joint departs from that by a rotation about its own axes, drawn for each dof as the sum of five
    normal numbers: the person's posture in everything, that of `make_gait`; what the person does in this action all the
    time; the person at this phase; the repetition all the time; the repetition at this phase. Their standard deviations
    are measured on ten actions of three people of HDM05 (`benchmarks/action_spreads.py`): 4.3°, 3.6°, 3.8° and 4.5° in
    the median dof, without posture. So are those of the tempo, 11 % of the person in an action and 16 % of a
    repetition, and of the timing: by how much of its duration a movement is late in the middle, 4 % and 7 %.

    The legs follow pelvis and feet. Feet that stand do not slide, and are flat, on their balls or, where the key pose
    has it so, with the heel up. People keep their balance: the pelvis stands above the feet as planned, as high as
    the departures of the knees have it, and on its seat as high as that is. So hips, ankles and toes depart as measured
    where a foot is in the air; of a leg that stands only the knee does. Elbows, knees, ankles and the rotation of the
    upper arm about itself stay within what people can do. There is no noise of a measurement.

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
    strange = [action for action in actions if action not in ACTIONS]
    if strange:
        raise ValueError(f"actions must be among {list(ACTIONS)}, got {strange[0]!r}")
    rng = check_random_state(random_state)
    motions, subjects, trials, labels = [], [], [], []
    for subject in range(1, n_subjects + 1):
        skeleton = person(rng)
        names = skeleton.dof_names
        posture = posture_of_person(rng, names)
        trial = 0
        for label in actions:
            action = ACTIONS[label]
            spread = _spread_over_keys([key.time for key in action.keys])
            departs = draw_departures(rng, names, "person") + spread @ draw_departures(
                rng, names, "person_key", len(action.keys)
            )
            tempo, late = (spread[0] * rng.standard_normal() for spread in (TEMPO, TIMING))
            for _ in range(n_sequences):
                trial += 1
                this = draw_departures(rng, names, "recording")
                this = this + spread @ draw_departures(rng, names, "recording_key", len(action.keys))
                duration = action.duration * np.exp(tempo + TEMPO[1] * rng.standard_normal())
                lateness = np.clip(late + TIMING[1] * rng.standard_normal(), -_LATEST, _LATEST)
                departures = np.radians(posture + departs + this)
                motions.append(perform(skeleton, action, departures, duration, lateness, frame_rate))
                subjects.append(f"{subject:02}")
                trials.append(f"{trial:02}")
                labels.append(label)
    return MotionDataset(motions, subjects, trials, labels)


def draw_departures(rng: np.random.RandomState, dof_names: Sequence[str], part: str, n: int = 1) -> np.ndarray:
    """Draw one part of how somebody departs from key poses, n times (n, n_dofs), degrees."""
    spread = [getattr(EXECUTION[name.removeprefix("left_").removeprefix("right_")], part) for name in dof_names]
    return np.array(spread) * rng.standard_normal((n, len(dof_names)))


def _spread_over_keys(times: Sequence[float]) -> np.ndarray:
    """Return the matrix (n_keys, n_keys) that makes independent departures those of key poses.

    Between two key poses departures are averaged, and their mean over the time is another part. So they are made larger
    and their mean is taken off, so that their mean square over the nine phases of the benchmark is what it measures.
    """
    phases = np.linspace(0.0, 1.0, 9)
    weights = np.stack([np.interp(phases, times, key) for key in np.eye(len(times))], axis=1)  # (n_phases, n_keys)
    mean = weights.mean(axis=0)
    size = np.sqrt(np.mean(np.square(weights - mean).sum(axis=1)))
    return (np.eye(len(times)) - mean) / size
