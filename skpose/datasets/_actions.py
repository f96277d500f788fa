"""Generated actions: key poses of our own, with measured differences between people."""

from collections.abc import Sequence
from numbers import Integral, Real

import numpy as np
from sklearn.utils import check_random_state

from skpose._utils.sklearn import Interval, StrOptions, validate_params
from skpose.datasets._gait import person
from skpose.datasets._humanoid import EXECUTION, TEMPO, TIMING, draw, posture_of_person
from skpose.datasets._key_poses import ACTIONS
from skpose.datasets._motions import MotionDataset, Rotations
from skpose.datasets._performance import perform

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
    motions, subjects, trials, labels = [], [], [], []
    for subject in range(1, n_subjects + 1):
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
                labels.append(label)
        subjects += [f"{subject:02}"] * len(actions) * n_sequences
        trials += [f"{trial:02}" for trial in range(1, len(actions) * n_sequences + 1)]
    return MotionDataset(motions, subjects, trials, labels, rotations=rotations)


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
