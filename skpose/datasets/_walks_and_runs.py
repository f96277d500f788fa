"""The walks and runs of a dataset, by their labels."""

import re

import numpy as np

from skpose.datasets._motions import MotionDataset

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
