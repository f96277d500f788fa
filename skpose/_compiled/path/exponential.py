"""Logarithms and exponentials: the first velocity of a geodesic, and the geodesic of a first velocity.

Both use one discrete geodesic of N chords, a path on which the second difference of the positions is normal to the
manifold at every pose between the ends (eq. 13): P_i (F_{i+1} − F_i) = P_i (F_i − F_{i−1}), P_i the projection onto the
tangent space at F_i, the range of J_i. (M. Rumpf, B. Wirth, "Variational time discretization of geodesic calculus", IMA
Journal of Numerical Analysis 35(3), 2015.) The logarithm has the direction of P_0 (F_1 − F_0) and N times the length of
the first chord. The exponential finds F_1 from it, and then pose after pose.

So the exponential inverts the logarithm as exactly as that path is stationary. What is left of the tangential part of
a second difference adds to all later chords, and so N-fold to the end. No bound on the gradient by the angles bounds
that for all N: an angle may move the joints little, and a chord of many is short. The share of the energy that is left
to gain does: paths whose velocities differ by the share δ, in the mean square, differ in energy by δ². Therefore the
path is found as every geodesic is, and then, of N chords, minimised to where float64 shows no more.

Velocities are those of the positions and not of the angles. Where a limb is straight, a small movement of its end
needs a large twist: the angles turn fast and the positions do not, as near the pole of a sphere. So each next pose is
found by positions: nearest to F_i + P_i (F_i − F_{i−1}) first, then such that its tangential part is met. Near a
straight limb that pose may be half a turn of a slow angle away, behind others that are locally nearest: where the part
is not met, the search starts again after turns of these angles. Where the manifold is nearly a cone, as for two hinges
of one straight limb, several poses may meet the part, and the exponential may continue from a different pose than the
logarithm.
"""

import math
from typing import NamedTuple

import numpy as np

from skpose._compiled.path.energy import path_of
from skpose._compiled.path.geodesic import (
    GRADIENT_NORM,
    MAX_ITER,
    NEVER,
    TOL,
    find_geodesic,
    shorter_line,
)
from skpose._compiled.path.minimiser import Settings, Stop, minimise, no_bounds
from skpose._compiled.pose.chart import chart_at, free_tree, pose_of
from skpose._compiled.pose.forward import orient, place_joints, workspace, workspace_rows
from skpose._compiled.pose.jacobian import write_jacobian
from skpose._compiled.simd.jit import internal, jit
from skpose._compiled.simd.lanes import copy_to

# Eigenvalue of the metric tensor, relative to the largest, of a direction that moves joints: less than for steps of
# angles (`FLAT` of the means), as velocities of positions stay small along it.
MOVES = 1e-9
TURN = 1e-5  # along directions that move no joint, rad
OPENS = 1e-7  # eigenvalue, relative to the same, of a direction that a turn adds to the tangent space; others: < 5e-9
NEAREST = 1e-2  # distance from its positions at which a nearest pose is a good start, relative to the step
# Of a step: relative to the mean diagonal of its matrix; the factor of its changes.
LEAST_DAMPING, FIRST_DAMPING, LARGEST_DAMPING, FACTOR = 1e-12, 1e-8, 1e3, 10.0
MAX_STEPS = 40  # to the next pose
STALLED = 1e-3  # relative decrease of an error below which it does not come down to zero
MAX_CHORDS = 40  # first chords that are tried for the one of the right length
ROUNDING = 1e-10  # error of a tangential part, relative to the length of a step
NOTHING = 1e-12  # length of the tangential part of a velocity, relative to it, at which there is none
REACHED = 1e-6  # the same, for a part that the joints cannot reach
# Where they do not: eigenvalue below which a direction is slow, relative to the largest; how many; turns along it, rad.
SLOW, MOST_SLOW, TURNS = 1e-4, 3, (1.0, -1.0, 2.0, -2.0, 3.0, -3.0)


class Logarithms(NamedTuple):
    """Logarithms of n poses at one pose."""

    velocities: np.ndarray  # (n, 3 n_joints) of the scaled positions, m
    converged: np.ndarray  # (n,) bool: of the geodesics
    turns: np.ndarray  # (n,) largest change of a coordinate in one step, rad; inf where the path is not yet stationary


@internal
def _positions(tree, dofs, scratch, positions):
    """Compute the scaled joint positions of a pose."""
    C, S, H, P = workspace(tree, scratch)
    orient(tree, dofs, C, S, H)
    place_joints(tree, C, H, P)
    for j in range(1, tree.offset.shape[0]):
        for i in range(3):
            positions[3 * tree.code_joint[j] - 3 + i] = P[3 * j + i] * tree.scale[j]


@internal
def _derivatives(tree, dofs, scratch):
    """The Jacobian of the scaled positions."""
    jacobian = np.zeros((3 * tree.offset.shape[0] - 3, dofs.shape[0]))
    write_jacobian(tree, dofs, scratch, jacobian)
    return jacobian


@internal
def _range(jacobian):
    """An orthonormal basis of the range of a Jacobian, directions that move no joint, and the largest speed².

    The basis has shape (3 n_joints, rank), the directions (n_dofs, n_dofs − rank).
    """
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    first = np.count_nonzero(values <= MOVES * values[-1])
    basis = jacobian @ (vectors[:, first:] / np.sqrt(values[first:]))
    return basis, np.ascontiguousarray(vectors[:, :first]), values[-1]


@internal
def _after_turns(tree, coordinates, scratch, jacobian, basis, still, largest):
    """Directions (3 n_joints, n) in which joints move after a turn that moves none.

    They are orthonormal, and normal to a basis. The twist of a straight leg moves no joint, but turns the plane in
    which the knee bends.
    """
    n = basis.shape[0]
    gram, is_empty = np.zeros((n, n)), True
    for k in range(still.shape[1]):
        turned = (_derivatives(tree, coordinates + TURN * still[:, k], scratch) - jacobian) / TURN
        turned -= basis @ (basis.T @ turned)
        if (turned**2).sum() > OPENS * largest:
            gram += turned @ turned.T
            is_empty = False
    if is_empty:
        return np.empty((n, 0))
    values, vectors = np.linalg.eigh(gram)
    first = np.count_nonzero(values <= OPENS * largest)
    return np.ascontiguousarray(vectors[:, first:])


@jit
def tangent_space(tree, pose):
    """An orthonormal basis of the tangent space at a pose, (3 n_joints, rank).

    Where angles are singular it also holds the velocities after turns that move no joint. That may be more than the
    joints can do at once: two hinges of one straight leg bend in the same plane.
    """
    free, coordinates = chart_at(tree, pose, True)
    scratch = np.empty(workspace_rows(tree))
    jacobian = _derivatives(free, coordinates, scratch)
    basis, still, largest = _range(jacobian)
    return np.hstack((basis, _after_turns(free, coordinates, scratch, jacobian, basis, still, largest)))


@jit
def logarithms_from(tree, pose, ends, first, last, n_steps, found):
    """Compute the logarithms at a pose of the ends first:last, the difference of angles wrapped already."""
    n_dofs, n = pose.shape[0], found.velocities.shape[1]
    free, bounds, scratch = free_tree(tree, True), no_bounds(n_dofs), np.empty(workspace_rows(tree))
    basis = tangent_space(tree, pose)
    here, following, nodes = np.empty(n), np.empty(n), np.empty((n_steps + 1, n_dofs))
    settings = Settings(Stop(MAX_ITER, 0.0, 0.0), False, NEVER)
    for i in range(first, last):
        line, _ = shorter_line(tree, free, pose, ends[i], n_steps)
        curve = find_geodesic(free, line, bounds, Stop(MAX_ITER, 0.0, TOL))
        if not curve.converged:  # a line that is a geodesic itself is longer than no path that is found more exactly
            curve = find_geodesic(free, line, bounds, Stop(MAX_ITER, GRADIENT_NORM, 0.0))
        n_samples = (curve.poses.shape[0] - 1) // n_steps
        for k in range(n_steps + 1):
            copy_to(nodes[k], curve.poses[k * n_samples])
        path = path_of(free, nodes, 1)
        found.converged[i] = curve.converged
        found.turns[i] = 0.0 if minimise(free, path, bounds, settings).converged else math.inf
        for k in range(n_steps):
            for d in range(n_dofs):
                found.turns[i] = max(found.turns[i], abs(path.poses[k + 1, d] - path.poses[k, d]))
        _positions(free, path.poses[0], scratch, here)
        _positions(free, path.poses[1], scratch, following)
        chord = following - here
        tangential = basis @ (basis.T @ chord)
        size = math.sqrt((tangential**2).sum())
        share = n_steps * math.sqrt((chord**2).sum()) / size if size > 0.0 else 0.0
        copy_to(found.velocities[i], share * tangential)


@internal
def _advance(tree, pose, basis, step, near, tol):
    """Find the pose whose chord from a pose has given components in a basis, from a pose near to it on.

    Returns the pose, its positions and the error of the components.
    """
    n, n_dofs = basis.shape[0], pose.shape[0]
    scratch, start, positions = np.empty(workspace_rows(tree)), np.empty(n), np.empty(n)
    _positions(tree, pose, scratch, start)
    found, damping = near, FIRST_DAMPING
    _positions(tree, found, scratch, positions)
    error = basis.T @ (positions - start) - step
    last = math.inf
    for _ in range(MAX_STEPS):
        size = math.sqrt((error**2).sum())
        if size <= tol or size > (1.0 - STALLED) * last or damping > LARGEST_DAMPING:
            break
        free, coordinates = chart_at(tree, found, True)
        A = basis.T @ _derivatives(free, coordinates, scratch)
        matrix, slope = A.T @ A, A.T @ error
        mean = np.trace(matrix) / n_dofs
        while damping <= LARGEST_DAMPING:
            damped = matrix.copy()
            for d in range(n_dofs):
                damped[d, d] += damping * mean
            trial = pose_of(tree, free, coordinates - np.linalg.solve(damped, slope), found)
            _positions(tree, trial, scratch, positions)
            trial_error = basis.T @ (positions - start) - step
            if (trial_error**2).sum() < size * size:
                last, found, error, damping = size, trial, trial_error, max(damping / FACTOR, LEAST_DAMPING)
                break
            damping *= FACTOR
    _positions(tree, found, scratch, positions)
    return found, positions, math.sqrt((error**2).sum())


@internal
def _find_following(tree, pose, basis, tangential, start, tol):
    """Find the pose whose chord from a pose has a given tangential part, from a third pose on; see `_advance`.

    It goes by the pose nearest to the positions of that tangential step, a good start where limbs are straight.
    """
    step = basis @ tangential
    near, _, _ = _advance(tree, pose, np.eye(step.shape[0]), step, start, NEAREST * math.sqrt((step**2).sum()))
    return _advance(tree, pose, basis, tangential, near, tol)


@internal
def _find_after_turns(tree, pose, basis, tangential, tol):
    """Do what `_find_following` does, and where the part is not met, try again after turns along slow directions."""
    found, positions, error = _find_following(tree, pose, basis, tangential, pose, tol)
    reached = REACHED * math.sqrt((tangential**2).sum())
    if error <= reached:
        return found, positions, error
    free, coordinates = chart_at(tree, pose, True)
    jacobian = _derivatives(free, coordinates, np.empty(workspace_rows(tree)))
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    first, last = np.count_nonzero(values <= MOVES * values[-1]), np.count_nonzero(values <= SLOW * values[-1])
    for k in range(first, min(last, first + MOST_SLOW)):
        for turn in TURNS:
            start = pose_of(tree, free, coordinates + turn * vectors[:, k], pose)
            other, other_positions, other_error = _find_following(tree, pose, basis, tangential, start, tol)
            if other_error < error:
                found, positions, error = other, other_positions, other_error
            if error <= reached:
                return found, positions, error
    return found, positions, error


@internal
def _first_pose(tree, pose, basis, tangential, tol):
    """Find the pose whose chord from a pose is as long as a tangential step, and has its direction.

    Chords grow with their tangential parts up to a right angle: the part is found between one whose chord is too short
    and one whose chord is too long. The joints come as near to the others as they can. Returns what `_advance` does,
    with the larger of both errors.
    """
    length, n = math.sqrt((tangential**2).sum()), basis.shape[0]
    start = np.empty(n)
    _positions(tree, pose, np.empty(workspace_rows(tree)), start)
    found, positions, error = _find_after_turns(tree, pose, basis, tangential, tol)
    share, low, high = 1.0, 0.0, math.inf
    for _ in range(MAX_CHORDS):
        chord = math.sqrt(((positions - start) ** 2).sum())
        is_reached = error <= REACHED * length
        if is_reached and abs(chord - length) <= tol:
            break
        if chord < length:
            low = share
        else:
            high = share
        share *= length / max(chord, tol)
        if not low < share < high:
            share = 0.5 * (low + min(high, 1.0))
        if is_reached:
            found, positions, error = _advance(tree, pose, basis, share * tangential, found, tol)
        else:
            found, positions, error = _find_following(tree, pose, basis, share * tangential, pose, tol)
    chord = math.sqrt(((positions - start) ** 2).sum())
    return found, positions, max(error, abs(chord - length))


@jit
def exponential(tree, pose, velocity, n_steps):
    """Follow the geodesic of n chords that begins at a pose with a velocity of the scaled positions.

    Returns the pose at its end and the largest error of a tangential part, relative to the length of a chord.
    """
    n = velocity.shape[0]
    scratch, before, positions = np.empty(workspace_rows(tree)), np.empty(n), np.empty(n)
    basis = tangent_space(tree, pose)
    tangential = basis.T @ velocity / n_steps
    length = math.sqrt((tangential**2).sum())
    if length <= NOTHING * math.sqrt((velocity**2).sum()) / n_steps:
        return pose, 0.0
    tol = ROUNDING * length
    _positions(tree, pose, scratch, before)
    found, positions, worst = _first_pose(tree, pose, basis, tangential, tol)
    for _ in range(1, n_steps):
        basis = tangent_space(tree, found)
        tangential = basis.T @ (positions - before)
        before = positions
        if worst <= REACHED * length:
            found, positions, error = _find_after_turns(tree, found, basis, tangential, tol)
        else:
            found, positions, error = _find_following(tree, found, basis, tangential, found, tol)
        worst = max(worst, error)
    return found, worst / length
