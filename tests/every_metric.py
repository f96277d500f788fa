"""The metrics that the tests run through all of the library: each with its distances by definition, in numpy.

A new metric takes one entry here.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import reference

from skpose.datasets import humanoid
from skpose.metrics import (
    Angle,
    Geodesic,
    Metric,
    Position,
    Rotation,
    Spatial,
    compile_encode,
    compile_measure,
)

SKELETON = humanoid().to_rotvec()


@compile_measure
def measure_largest(a, b):
    largest = 0.0
    for j in range(0, len(a), 3):
        largest = max(largest, np.sqrt(((a[j : j + 3] - b[j : j + 3]) ** 2).sum()))
    return largest


class LargestDistance(Metric):
    """A metric of one's own: the largest distance of a joint, with the code of another metric."""

    name = "largest distance"
    encode = Position.encode
    measure = measure_largest

    def n_codes(self, tree, n_dofs):
        return 3 * tree.n_joints


@compile_encode
def encode_heights_and_angles(pose, positions, code):
    for j in range(len(positions)):
        code[j] = positions[j, 1]
    for d in range(len(pose)):
        code[len(positions) + d] = pose[d]


@compile_measure
def measure_sum(a, b):
    return np.abs(a - b).sum()


class Heights(Metric):
    """A metric of one's own, of a code of its own: the sum of the differences of all heights and angles."""

    name = "heights"
    unit = "m and rad"
    encode = encode_heights_and_angles
    measure = measure_sum

    def __init__(self, scale=1.0):
        self.scale = scale

    def n_codes(self, tree, n_dofs):
        return tree.n_joints + n_dofs


class Entry(NamedTuple):
    metric: Metric
    distances: Callable  # of (X, Y, skeleton): the matrix, by definition; None where a search has none


def _by_name(name, **parameters):
    return lambda X, Y, skeleton: reference.distances(X, Y, skeleton, name, **parameters)


def _largest(X, Y, skeleton):
    a, b = (reference.F(Z, skeleton).reshape(len(Z), -1, 3) for Z in (X, Y))
    return np.linalg.norm(a[:, None] - b[None], axis=3).max(axis=2)


def _heights(X, Y, skeleton):
    a, b = (reference.F(Z, skeleton).reshape(len(Z), -1, 3)[:, :, 1] for Z in (X, Y))
    return np.abs(a[:, None] - b[None]).sum(axis=2) + np.abs(X[:, None] - Y[None]).sum(axis=2)


EVERY_METRIC = [
    Entry(Angle(), _by_name("angle")),
    Entry(Angle(wrap=True), _by_name("angle", wrap=True)),
    Entry(Position(), _by_name("position")),
    Entry(Rotation(), _by_name("rotation")),
    Entry(Spatial(), _by_name("spatial", wrap=True)),
    Entry(Spatial(n_steps=7, wrap=False), _by_name("spatial", n_steps=7)),
    Entry(Geodesic(), None),
    Entry(LargestDistance(), _largest),
    Entry(Heights(), _heights),
]
