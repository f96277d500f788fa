"""The motions of walking and of running of a collection, by their labels."""

import re

import numpy as np

from skpose.datasets._motions import MotionDataset

WALKING_AND_RUNNING = ("walk", "run")


def walks_and_runs(dataset: MotionDataset) -> MotionDataset:
    """Return the motions of walking and of running, labelled "walk" and "run".

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
        If there is no motion of walking, or none of running.

    Examples
    --------
    >>> from skpose.datasets import make_gait, walks_and_runs
    >>> walks_and_runs(make_gait(n_subjects=2, n_sequences=1, random_state=0))
    MotionDataset(4 motions of 2 subjects: 2 run, 2 walk)
    """
    first = np.array([re.split(r"\W", action.strip().lower())[0] for action in dataset.actions])
    chosen = np.isin(first, WALKING_AND_RUNNING)
    missing = [action for action in WALKING_AND_RUNNING if action not in first]
    if missing:
        raise ValueError(
            f"dataset must have motions of walking and of running, but none has an action that begins with "
            f"{missing[0]!r}: write one line for each motion into an index.csv, see skpose.datasets.load_cmu"
        )
    return MotionDataset(dataset.motions, **dataset._labels | {"actions": first})[chosen]
