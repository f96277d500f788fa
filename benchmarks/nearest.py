"""How well distances recognise actions: the nearest neighbour among other people, of frames and of sequences."""

import numpy as np

from skpose import motion_distances

RATE = 12  # Hz


def share(distances, labels, subjects):
    """The share of rows whose nearest neighbour among other people has the same label, in percent."""
    same_person = subjects[:, None] == subjects
    nearest = np.where(same_person, np.inf, distances).argmin(axis=1)
    return 100 * (labels[nearest] == labels).mean()


def shares(distances, X, sequence, dataset, **parameters):
    """The shares of frames, by their distances, and of sequences, by dynamic time warping, that are recognised."""
    subjects, actions = dataset.subjects, dataset.actions
    starts = np.searchsorted(sequence, np.arange(1, len(dataset)))
    of_sequences = motion_distances(np.split(X, starts), n_jobs=-1, **parameters)
    return share(distances, actions[sequence], subjects[sequence]), share(of_sequences, actions, subjects)
