"""The energy of a path, eq. 6 of the paper, and its gradient.

A path is a sequence of poses. Its energy Σ ‖F(θ_i) − F(θ_{i−1})‖² is a sum of squares. Its gradient is
2 (2F(θ_i) − F(θ_{i−1}) − F(θ_{i+1}))ᵀ J_i. (Eq. 12 of the paper loses the sign of the first inner derivative, so that
F(θ_i) drops out of its eq. 7 and 13.)

The two ends are fixed, the poses between them are free. Between two poses there may be several chords, over samples
that lie evenly on the straight line in angle space and move with the two poses: the energy then counts what happens
between them. One chord is the plain eq. 6.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import types

from skpose._compiled.forward import orient, place_joints, workspace, workspace_rows
from skpose._compiled.jacobian import rotation_axes
from skpose._compiled.jit import internal, separate, unfolded
from skpose._compiled.signatures import CUBE, MATRIX, REAL, TREE, VECTOR, WHOLE, named

FINE = 8  # chords into which each chord of a path is divided to measure it again


class Path(NamedTuple):
    """Poses from one end to the other, and the samples that the chords of the energy join, the poses among them."""

    poses: np.ndarray  # (n_nodes, n_dofs) angles in the tree's order, rad
    P: np.ndarray  # (n_samples, 3 n_joints + 3) joint positions, the root's first, m
    screws: np.ndarray  # (n_samples, 6, n_dofs) see `place`


PATH = named(Path, MATRIX, MATRIX, CUBE)


@unfolded
def empty_path(tree, n_nodes, n_chords):
    """Return a path of so many poses and chords, not yet filled."""
    n_samples, n_dofs = n_chords + 1, tree.column.shape[0]
    return Path(
        np.empty((n_nodes, n_dofs)), np.empty((n_samples, 3 * tree.offset.shape[0])), np.zeros((n_samples, 6, n_dofs))
    )


@separate(lambda: PATH(TREE, MATRIX, WHOLE))
def path_of(tree, poses, substeps):
    """Return the path of these poses with so many chords between two of them; its ends are placed."""
    path, last = empty_path(tree, poses.shape[0], (poses.shape[0] - 1) * substeps), poses.shape[0] - 1
    scratch = np.empty(workspace_rows(tree))
    for i in range(poses.shape[0]):
        for d in range(poses.shape[1]):
            path.poses[i, d] = poses[i, d]
        if i == 0 or i == last:
            place(tree, poses[i], scratch, path.P[i * substeps], path.screws[i * substeps])
    return path


@unfolded
def copy_of(path):
    """Return a copy of a path."""
    return Path(path.poses.copy(), path.P.copy(), path.screws.copy())


@internal
def copy_free(source, target):
    """Copy what lies between the ends to another path, whose ends are the same."""
    for i in range(1, source.poses.shape[0] - 1):
        for d in range(source.poses.shape[1]):
            target.poses[i, d] = source.poses[i, d]
    for k in range(1, source.P.shape[0] - 1):
        for i in range(source.P.shape[1]):
            target.P[k, i] = source.P[k, i]
        for i in range(source.screws.shape[1]):
            for d in range(source.screws.shape[2]):
                target.screws[k, i, d] = source.screws[k, i, d]


@unfolded
def substeps_of(path):
    """Return the number of chords between two poses of the path."""
    return (path.P.shape[0] - 1) // (path.poses.shape[0] - 1)


@internal
def place(tree, angles, scratch, P, screws):
    """Compute the joint positions of one pose, angles in the tree's order, and the screw of every dof, (6, n_dofs).

    The screw is the axis a and the velocity b = o × a of a point at the root, with o on the axis: the dof moves a point
    p of its frame, or of one below it, at the rate a × p + b.
    """
    C, S, H, positions = workspace(tree, scratch)
    orient(tree, angles, C, S, H)
    place_joints(tree, H, positions)
    for i in range(P.shape[0]):
        P[i] = positions[i]
    rotation_axes(tree, C, S, H, screws[:3].T)
    for f in range(1, tree.frame_parent.shape[0]):
        o = 3 * tree.pivot[f]
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            x, y, z = screws[0, d], screws[1, d], screws[2, d]
            screws[3, d] = P[o + 1] * z - P[o + 2] * y
            screws[4, d] = P[o + 2] * x - P[o] * z
            screws[5, d] = P[o] * y - P[o + 1] * x


@separate(lambda: MATRIX(MATRIX, WHOLE))
def divided(poses, parts):
    """Divide every step between poses into equal parts; return all poses, those given among them."""
    n_steps, n_dofs = poses.shape[0] - 1, poses.shape[1]
    out = np.empty((n_steps * parts + 1, n_dofs))
    for i in range(out.shape[0]):
        step = min(i // parts, n_steps - 1)
        t = (i - step * parts) / parts
        for d in range(n_dofs):
            out[i, d] = poses[step, d] + t * (poses[step + 1, d] - poses[step, d])
    for d in range(n_dofs):
        out[-1, d] = poses[-1, d]  # exactly
    return out


@separate(lambda: types.UniTuple(REAL, 2)(TREE, MATRIX))
def chords(tree, poses):
    """Return the sum of the chords between poses, and the sum of their squares."""
    C, S, H, P = workspace(tree, np.empty(workspace_rows(tree)))
    length, energy = 0.0, 0.0
    for i in range(poses.shape[0]):
        orient(tree, poses[i], C, S, H)
        square = place_joints(tree, H, P)
        if i > 0:
            length += math.sqrt(square)
            energy += square
    return length, energy


@internal
def curve_length(tree, poses):
    """Return the length of the curve through poses, measured on a grid `FINE` times finer."""
    return chords(tree, divided(poses, FINE))[0]


@separate(lambda: REAL(TREE, PATH, VECTOR))
def evaluate(tree, path, scratch):
    """Place the samples between the ends; return half the energy."""
    samples = divided(path.poses, substeps_of(path))
    P, last = path.P, samples.shape[0] - 1
    half = 0.0
    for i in range(1, last + 1):
        if i < last:
            place(tree, samples[i], scratch, P[i], path.screws[i])
        for k in range(3, P.shape[1]):
            half += 0.5 * ((P[i, k] - P[i - 1, k]) * tree.scale[k // 3]) ** 2
    return half


@internal
def sum_moments(tree, before, P, after, moments):
    """Sum p wᵀ and w over the joints p that each frame moves, (n_frames, 12); w is the weighted force 2p − p₋ − p₊."""
    moments[:] = 0.0
    for j in range(1, tree.offset.shape[0]):
        total, weight = moments[tree.joint_frame[j]], tree.scale[j] * tree.scale[j]
        for k in range(3):
            w = weight * (2.0 * P[3 * j + k] - before[3 * j + k] - after[3 * j + k])
            for i in range(3):
                total[3 * i + k] += P[3 * j + i] * w
            total[9 + k] += w
    for f in range(tree.frame_parent.shape[0] - 1, 0, -1):
        for i in range(moments.shape[1]):
            moments[tree.frame_parent[f], i] += moments[f, i]


@internal
def add_gradient(tree, screws, moments, t, gradient):
    """Add the forces on one sample to the gradient of the two poses next to it: their moment along each axis."""
    for f in range(1, tree.frame_parent.shape[0]):
        _, xy, xz, yx, _, yz, zx, zy, _, u, v, w = moments[f]
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            slope = (yz - zy) * screws[0, d] + (zx - xz) * screws[1, d] + (xy - yx) * screws[2, d]
            slope += u * screws[3, d] + v * screws[4, d] + w * screws[5, d]
            gradient[0, d] += (1.0 - t) * slope
            gradient[1, d] += t * slope
