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
        "actions": ["array-like"],
        "frame_rate": [Interval(Real, 0, None, closed="neither")],
        "random_state": ["random_state"],
    },
    prefer_skip_nested_validation=True,
)
def make_actions(
    n_subjects: int = 3,
    n_sequences: int = 6,
    *,
    actions: Sequence[str] = tuple(ACTIONS),
    frame_rate: float = 60.0,
    random_state: int | np.random.RandomState | None = None,
) -> MotionDataset:
    """Generate motions."""
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
            n_keys = len(action.keys)
            departs = _draw(rng, names, "person", 1) + _draw(rng, names, "person_key", n_keys)
            tempo, late = (spread[0] * rng.standard_normal() for spread in (TEMPO, TIMING))
            for _ in range(n_sequences):
                trial += 1
                this = _draw(rng, names, "recording", 1) + _draw(rng, names, "recording_key", n_keys)
                duration = action.duration * np.exp(tempo + TEMPO[1] * rng.standard_normal())
                lateness = np.clip(late + TIMING[1] * rng.standard_normal(), -_LATEST, _LATEST)
                departures = np.radians(posture + departs + this)
                motions.append(perform(skeleton, action, departures, duration, lateness, frame_rate))
                subjects.append(f"{subject:02}")
                trials.append(f"{trial:02}")
                labels.append(label)
    return MotionDataset(motions, subjects, trials, labels)


def _draw(rng: np.random.RandomState, dof_names: Sequence[str], part: str, n_keys: int) -> np.ndarray:
    """Draw deviations (n_keys, n_dofs), degrees."""
    spread = [getattr(EXECUTION[name.removeprefix("left_").removeprefix("right_")], part) for name in dof_names]
    return np.array(spread) * rng.standard_normal((n_keys, len(dof_names)))
