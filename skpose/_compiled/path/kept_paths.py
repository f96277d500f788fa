"""Geodesics from a pose that moves a little at a time to poses that stay: each starts from the one before.

An intrinsic mean asks for the geodesics to the same poses from one base after another; so do distances from the frames
of a motion. The path to a pose is kept, in the coordinates in which it was found. At the next base its first node is
there, and the others move by a share of that change that falls to zero at the other end. Then it is minimised again,
refined as it is: some steps, where a new search takes tens, or fails at several refinements first. A new search starts
from the straight line where this one did not converge, where the path fails the discretisation check, and where it has
become longer than the line.
"""

from typing import NamedTuple

import numpy as np

from skpose._compiled.path.energy import divide, path_of, samples_for
from skpose._compiled.path.geodesic import (
    MAX_ITER,
    PATIENCE,
    REFINEMENTS,
    SUBSTEPS,
    check_discretisation,
    find_geodesic,
    shorter_line,
)
from skpose._compiled.path.minimiser import Settings, Stop, minimise, no_bounds
from skpose._compiled.path.normal_equations import equations_for, gradient_of
from skpose._compiled.pose.chart import coordinates_of, follow, free_tree, slopes_of_turns
from skpose._compiled.simd.jit import internal, jit
from skpose._compiled.simd.lanes import copy_to

MOST_NODES = REFINEMENTS[-1][0]  # steps of the finest path, over n_steps
SAME = 1e-9  # difference of angles of one end, rad; another is a whole turn
MAX_STEPS = 200  # of the minimiser; where these are not enough, the straight line may be the better start


class Geodesics(NamedTuple):
    """Geodesics from one pose to n others."""

    energies: np.ndarray  # (n,) times the number of chords, which makes them squares of lengths, m²
    lengths: np.ndarray  # (n,) m
    gradients: np.ndarray  # (n, n_dofs) of half that energy by the one pose's coordinates, m²/rad
    converged: np.ndarray  # (n,) bool


class KeptPaths(NamedTuple):
    """The paths from a pose to n others, in the coordinates in which they were found."""

    nodes: np.ndarray  # (n, MOST_NODES n_steps + 1, n_dofs)
    references: np.ndarray  # (n, n_frames, 4) of the ball joints, see `chart`
    n_nodes: np.ndarray  # (n,) nodes of each path; zero: none is kept
    substeps: np.ndarray  # (n,) chords between two nodes


@internal
def _follow_base(tree, own, pose, end, nodes):
    """Move a path to a new first pose; return whether its coordinates still suit the two poses."""
    last, start = nodes.shape[0] - 1, np.empty(pose.shape[0])
    coordinates_of(tree, own, pose, start)
    for f in range(1, own.frame_parent.shape[0]):
        first = own.first_dof[f]
        if own.ball[f] >= 0:
            if not follow(nodes[0, first : first + 3], start[first : first + 3]):
                return False
            continue
        for d in range(first, own.end_dof[f]):
            if abs(end[d] - nodes[last, d]) > SAME:  # wrapped by another turn from here
                return False
    for d in range(start.shape[0]):
        change = start[d] - nodes[0, d]
        nodes[0, d] = start[d]
        for k in range(1, last):
            nodes[k, d] += (1.0 - k / last) * change
    return True


@internal
def _keep(kept, i, free, curve, substeps):
    """Keep the path of a curve, or none if it is the straight line."""
    kept.n_nodes[i] = (curve.poses.shape[0] - 1) // substeps + 1 if np.isfinite(curve.gradient_norm) else 0
    kept.substeps[i] = substeps
    for k in range(kept.n_nodes[i]):
        copy_to(kept.nodes[i, k], curve.poses[k * substeps])
    copy_to(kept.references[i], free.reference)


@internal
def _record(free, curve, substeps, i, found):
    """Write energy, length and gradient of the geodesic to pose i, a curve in the coordinates of the free tree."""
    n_dofs, n_chords = curve.poses.shape[1], curve.poses.shape[0] - 1
    first_step = np.empty((2, n_dofs))  # what moves with the first pose
    copy_to(first_step[0], curve.poses[0])
    copy_to(first_step[1], curve.poses[substeps])
    path = path_of(free, first_step, substeps)
    equations = equations_for(free, path)
    gradient_of(free, path, samples_for(free, path), equations)
    gradient = equations.gradient[0]
    slopes_of_turns(free, curve.poses[0], gradient)
    found.energies[i] = n_chords * curve.energy
    found.lengths[i] = curve.length
    for d in range(n_dofs):
        found.gradients[i, d] = n_chords * gradient[d]
    found.converged[i] = curve.converged


@jit
def follow_geodesics(tree, pose, ends, first, last, n_steps, frees_angles, least, kept, found):
    """Compute the geodesics from a pose to the ends first:last, whose angles are wrapped already; keep their paths.

    Joints of three angles turn freely if so asked, see `chart`. A path has converged where the norm of the energy's
    gradient is at most `least`, m²/rad.
    """
    free, own, bounds = free_tree(tree, frees_angles), free_tree(tree, frees_angles), no_bounds(pose.shape[0])
    settings = Settings(Stop(MAX_STEPS, least, 0.0), False, PATIENCE)
    for i in range(first, last):
        line, _ = shorter_line(tree, free, pose, ends[i], n_steps)
        if kept.n_nodes[i] > 0:
            copy_to(own.reference, kept.references[i])
            nodes = kept.nodes[i, : kept.n_nodes[i]].copy()
            if _follow_base(tree, own, pose, ends[i], nodes):
                path = path_of(own, nodes, kept.substeps[i])
                outcome = minimise(own, path, bounds, settings)
                samples = divide(path.poses, kept.substeps[i])
                curve, passes = check_discretisation(free, line, own, samples, outcome, outcome.n_iter)
                if passes and curve.converged:
                    _keep(kept, i, own, curve, kept.substeps[i])
                    _record(own, curve, kept.substeps[i], i, found)
                    continue
        curve = find_geodesic(free, line, bounds, Stop(MAX_ITER, least, 0.0))
        substeps = 1 if curve.poses.shape[0] - 1 == n_steps else SUBSTEPS
        _keep(kept, i, free, curve, substeps)
        _record(free, curve, substeps, i, found)
