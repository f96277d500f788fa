"""The energy of a path, eq. 6 of the paper.

A path is a sequence of poses. Its energy Σ ‖F(θ_i) − F(θ_{i−1})‖² is a sum of squares. The two ends are fixed, the
poses between them are free. Between two poses there may be several chords, over samples that lie evenly on the straight
line in angle space and move with the two poses: the energy then counts what happens between them. One chord is the
plain eq. 6.

The steps between two poses are in lanes: sample s of eight poses, at the fraction s / substeps of the step that begins
there, is computed at once. The last sample of a step is the first one of the next, a lane further on; so the last lane
has no step of its own, and its pose begins the next group.
"""

from typing import NamedTuple

import numpy as np
from numba import types

from skpose._compiled.pose.forward import orient, place, place_joints, workspace, workspace_rows
from skpose._compiled.pose.jacobian import set_screws
from skpose._compiled.pose.signatures import TREE
from skpose._compiled.simd.jit import by_address, internal
from skpose._compiled.simd.lanes import copy_to, empty_aligned, full_like, next_lane, rows, sqrt, sum_of_lanes
from skpose._compiled.simd.signatures import FLAG, INTEGER, MATRIX, REAL, tuple_type

FINE = 8  # chords into which each chord of a path is divided to measure it again
LANES = 8  # poses computed at once
STEPS = LANES - 1  # steps computed at once


class Path(NamedTuple):
    """Poses from one end to the other, and how many chords are between two of them."""

    poses: np.ndarray  # (n_nodes, n_dofs) angles in the tree's order, rad
    ends: np.ndarray  # (2, 3 n_joints + 3) joint positions of the first and the last, the root's first, m
    substeps: int


class Samples(NamedTuple):
    """The samples of a group of steps, one step in each lane; sample s has the s-th of equal parts of the rows."""

    poses: np.ndarray  # (2 n_dofs, LANES) the poses where the steps begin, and the steps; zero elsewhere
    dofs: np.ndarray  # (n_dofs, LANES) of one sample
    scratch: np.ndarray  # (workspace_rows, LANES)
    P: np.ndarray  # ((substeps + 1) · (3 n_joints + 3), LANES) joint positions, the root's first, m
    screws: np.ndarray  # ((substeps + 1) · 6 n_dofs, LANES) see `set_screws`


PATH = tuple_type(Path, MATRIX, MATRIX, INTEGER)
SAMPLES = tuple_type(Samples, MATRIX, MATRIX, MATRIX, MATRIX, MATRIX)


@by_address(lambda: PATH(TREE, MATRIX, INTEGER))
def path_of(tree, poses, substeps):
    """The path of these poses with so many chords between two of them."""
    ends = np.empty((2, 3 * tree.offset.shape[0]))
    scratch, last = np.empty(workspace_rows(tree)), poses.shape[0] - 1
    place(tree, poses[0], scratch, ends[0])
    place(tree, poses[last], scratch, ends[1])
    return Path(poses.copy(), ends, substeps)


@internal
def copy_of(path):
    """A copy of a path with the same ends."""
    return Path(path.poses.copy(), path.ends, path.substeps)


@internal
def copy_free(source, target):
    """Copy the poses between the ends to another path."""
    for i in range(1, source.poses.shape[0] - 1):
        copy_to(target.poses[i], source.poses[i])


@by_address(lambda: SAMPLES(TREE, PATH))
def samples_for(tree, path):
    """Arrays for the samples of a path."""
    n, n_samples = tree.column.shape[0], path.substeps + 1
    return Samples(
        empty_aligned(2 * n, LANES, np.float64),
        empty_aligned(n, LANES, np.float64),
        empty_aligned(workspace_rows(tree), LANES, np.float64),
        empty_aligned(n_samples * 3 * tree.offset.shape[0], LANES, np.float64),
        empty_aligned(n_samples * 6 * n, LANES, np.float64),
    )


@internal
def _load(path, first, poses):
    """Put the poses from the first on in lanes, and the steps from them; after the end, the last pose stays."""
    n, last = path.poses.shape[1], path.poses.shape[0] - 1
    for w in range(LANES):
        here, following = min(first + w, last), min(first + w + 1, last)
        for d in range(n):
            poses[d, w] = path.poses[here, d]
            poses[n + d, w] = path.poses[following, d] - path.poses[here, d] if w < STEPS else 0.0


@by_address(lambda: types.void(TREE, PATH, INTEGER, FLAG, SAMPLES))
def place_samples(tree, path, first, with_screws, samples):
    """Compute the positions of all samples of the steps from this one on, and the screws if so asked."""
    _load(path, first, samples.poses)
    n, n_coordinates, last = tree.column.shape[0], 3 * tree.offset.shape[0], path.poses.shape[0] - 1
    begins, steps, dofs = rows(samples.poses, 0), rows(samples.poses, n), rows(samples.dofs, 0)
    C, S, H, _ = workspace(tree, samples.scratch)
    for s in range(path.substeps):
        P, screws, t = rows(samples.P, s * n_coordinates), rows(samples.screws, s * 6 * n), s / path.substeps
        for d in range(n):
            dofs[d] = begins[d] + t * steps[d]
        for i in range(3):
            P[i] = 0.0
        orient(tree, dofs, C, S, H)
        place_joints(tree, C, H, P)
        if with_screws:
            set_screws(tree, C, S, H, P, screws)
        for w in range(LANES):
            if (s == 0 and first + w == 0) or first + w >= last:
                end = path.ends[0 if first + w == 0 else 1]
                for i in range(n_coordinates):
                    samples.P[s * n_coordinates + i, w] = end[i]
    P, screws = rows(samples.P, 0), rows(samples.screws, 0)
    for i in range(n_coordinates):
        P[path.substeps * n_coordinates + i] = next_lane(P[i])
    for i in range(6 * n if with_screws else 0):
        screws[path.substeps * 6 * n + i] = next_lane(screws[i])


@by_address(lambda: REAL(TREE, PATH, SAMPLES))
def evaluate(tree, path, samples):
    """Half the energy."""
    n_coordinates, P, half = 3 * tree.offset.shape[0], rows(samples.P, 0), 0.0
    for first in range(0, path.poses.shape[0] - 1, STEPS):
        place_samples(tree, path, first, False, samples)
        square = full_like(P, 0.0)
        for s in range(path.substeps):
            for j in range(1, tree.offset.shape[0]):
                for i in range(s * n_coordinates + 3 * j, s * n_coordinates + 3 * j + 3):
                    move = (P[i + n_coordinates] - P[i]) * tree.scale[j]
                    square = square + move * move
        half += 0.5 * sum_of_lanes(square)
    return half


@by_address(lambda: MATRIX(MATRIX, INTEGER))
def divide(poses, n_parts):
    """Divide every step between poses into equal parts; return all poses, including the original ones."""
    n_steps, n_dofs = poses.shape[0] - 1, poses.shape[1]
    out = np.empty((n_steps * n_parts + 1, n_dofs))
    for i in range(out.shape[0]):
        step = min(i // n_parts, n_steps - 1)
        t = (i - step * n_parts) / n_parts
        for d in range(n_dofs):
            out[i, d] = poses[step, d] + t * (poses[step + 1, d] - poses[step, d])
    copy_to(out[-1], poses[-1])  # exactly
    return out


@internal
def _chords(tree, poses, dofs, scratch):
    """What `chords` does; the rows of the two arrays are valid as long as they are arguments."""
    angles, last, length, energy = rows(dofs, 0), poses.shape[0] - 1, 0.0, 0.0
    for first in range(0, last, STEPS):
        for w in range(LANES):
            for d in range(poses.shape[1]):
                dofs[d, w] = poses[min(first + w, last), d]
        C, S, H, P = workspace(tree, scratch)
        orient(tree, angles, C, S, H)
        place_joints(tree, C, H, P)
        square = full_like(P, 0.0)
        for j in range(1, tree.offset.shape[0]):
            for i in range(3 * j, 3 * j + 3):
                move = (next_lane(P[i]) - P[i]) * tree.scale[j]
                square = square + move * move
        length += sum_of_lanes(sqrt(square))
        energy += sum_of_lanes(square)
    return length, energy


@by_address(lambda: types.UniTuple(REAL, 2)(TREE, MATRIX))
def chords(tree, poses):
    """The sum of the chords between poses, and the sum of their squares."""
    dofs, scratch = (
        empty_aligned(poses.shape[1], LANES, np.float64),
        empty_aligned(workspace_rows(tree), LANES, np.float64),
    )
    return _chords(tree, poses, dofs, scratch)


@internal
def curve_length(tree, poses):
    """The length of the curve through poses, measured on a grid `FINE` times finer."""
    return chords(tree, divide(poses, FINE))[0]
