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

import numpy as np

from skpose._compiled.path.geodesic import follow_to_end
from skpose._compiled.pose.chart import chart_at, pose_of
from skpose._compiled.pose.jacobian import position_jacobians
from skpose._compiled.pose.tree import Tree
from skpose.metrics._direct_means import positions_of

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


def _scaled(tree: Tree, positions: np.ndarray) -> np.ndarray:
    """Scaled positions (n_poses, 3 n_joints) in the skeleton's order, given those of all joints in the tree's order."""
    scaled = np.empty((len(positions), len(tree.offset) - 1, 3))
    scaled[:, tree.code_joint[1:] - 1] = positions.reshape(len(positions), -1, 3)[:, 1:] * tree.scale[1:, None]
    return scaled.reshape(len(positions), -1)


def _positions(tree: Tree, dofs: np.ndarray) -> np.ndarray:
    """The scaled joint positions of a pose."""
    return _scaled(tree, positions_of(tree, dofs[None]))[0]


def _derivatives(tree: Tree, dofs: np.ndarray) -> np.ndarray:
    """The Jacobians of the scaled positions of poses."""
    jacobians = np.empty((len(dofs), 3 * len(tree.offset) - 3, dofs.shape[1]))
    position_jacobians(dofs, tree, jacobians)
    return jacobians


def _range(jacobian: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """An orthonormal basis of the range of a Jacobian, directions that move no joint, and the largest speed².

    The basis has shape (3 n_joints, rank), the directions (n_dofs, n_dofs − rank).
    """
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    moves = values > MOVES * values[-1]
    return jacobian @ (vectors[:, moves] / np.sqrt(values[moves])), vectors[:, ~moves], values[-1]


def tangent_space(tree: Tree, pose: np.ndarray) -> np.ndarray:
    """An orthonormal basis of the tangent space at a pose, (3 n_joints, rank).

    Where angles are singular it also holds the velocities after turns that move no joint. That may be more than the
    joints can do at once: two hinges of one straight leg bend in the same plane. The twist of a straight leg moves no
    joint, but turns the plane in which the knee bends.
    """
    free, coordinates = chart_at(tree, pose, True)
    (jacobian,) = _derivatives(free, coordinates[None])
    basis, still, largest = _range(jacobian)
    gram = np.zeros((len(basis), len(basis)))
    turned_coordinates = np.ascontiguousarray(coordinates + TURN * still.T)
    for turned in (_derivatives(free, turned_coordinates) - jacobian) / TURN:
        turned -= basis @ (basis.T @ turned)
        if (turned**2).sum() > OPENS * largest:
            gram += turned @ turned.T
    if not gram.any():
        return basis
    values, vectors = np.linalg.eigh(gram)
    return np.hstack([basis, vectors[:, values > OPENS * largest]])


def logarithm(
    tree: Tree, pose: np.ndarray, basis: np.ndarray, end: np.ndarray, n_steps: int
) -> tuple[np.ndarray, bool, float]:
    """The logarithm at a pose of another one, the difference of angles wrapped already, given the tangent space.

    That is the velocity of the scaled positions, m. Also whether the geodesic converged, and the largest change of a
    coordinate in one step, rad; inf where the path is not yet stationary.
    """
    nodes, positions, converged, is_stationary = follow_to_end(tree, pose, end, n_steps)
    here, following = _scaled(tree, positions)
    chord = following - here
    tangential = basis @ (basis.T @ chord)
    size = np.sqrt((tangential**2).sum())
    share = n_steps * np.sqrt((chord**2).sum()) / size if size > 0.0 else 0.0
    largest_turn = np.abs(np.diff(nodes, axis=0)).max() if is_stationary else math.inf
    return share * tangential, converged, largest_turn


def _advance(
    tree: Tree, pose: np.ndarray, basis: np.ndarray, step: np.ndarray, near: np.ndarray, tol: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """Find the pose whose chord from a pose has given components in a basis, from a pose near to it on.

    Returns the pose, its positions and the error of the components.
    """
    start, positions = _positions(tree, pose), _positions(tree, near)
    found, damping = near, FIRST_DAMPING
    error = basis.T @ (positions - start) - step
    last = math.inf
    for _ in range(MAX_STEPS):
        size = math.sqrt((error**2).sum())
        if size <= tol or size > (1.0 - STALLED) * last or damping > LARGEST_DAMPING:
            break
        free, coordinates = chart_at(tree, found, True)
        A = basis.T @ _derivatives(free, coordinates[None])[0]
        matrix, slope = A.T @ A, A.T @ error
        identity = np.diag(np.full(len(matrix), np.trace(matrix) / len(matrix)))
        while damping <= LARGEST_DAMPING:
            damped = matrix + damping * identity
            trial = pose_of(tree, free, coordinates - np.linalg.solve(damped, slope), found)
            trial_positions = _positions(tree, trial)
            trial_error = basis.T @ (trial_positions - start) - step
            if (trial_error**2).sum() < size * size:
                last, found, positions, error = size, trial, trial_positions, trial_error
                damping = max(damping / FACTOR, LEAST_DAMPING)
                break
            damping *= FACTOR
    return found, positions, math.sqrt((error**2).sum())


def _find_following(
    tree: Tree, pose: np.ndarray, basis: np.ndarray, tangential: np.ndarray, start: np.ndarray, tol: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """Find the pose whose chord from a pose has a given tangential part, from a third pose on; see `_advance`.

    It goes by the pose nearest to the positions of that tangential step, a good start where limbs are straight.
    """
    step = basis @ tangential
    near, _, _ = _advance(tree, pose, np.eye(step.shape[0]), step, start, NEAREST * math.sqrt((step**2).sum()))
    return _advance(tree, pose, basis, tangential, near, tol)


def _find_after_turns(
    tree: Tree, pose: np.ndarray, basis: np.ndarray, tangential: np.ndarray, tol: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """Do what `_find_following` does, and where the part is not met, try again after turns along slow directions."""
    found, positions, error = _find_following(tree, pose, basis, tangential, pose, tol)
    reached = REACHED * math.sqrt((tangential**2).sum())
    if error <= reached:
        return found, positions, error
    free, coordinates = chart_at(tree, pose, True)
    (jacobian,) = _derivatives(free, coordinates[None])
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    slow = vectors.T[(values > MOVES * values[-1]) & (values <= SLOW * values[-1])]
    for direction in slow[:MOST_SLOW]:
        for turn in TURNS:
            start = pose_of(tree, free, coordinates + turn * direction, pose)
            other, other_positions, other_error = _find_following(tree, pose, basis, tangential, start, tol)
            if other_error < error:
                found, positions, error = other, other_positions, other_error
            if error <= reached:
                return found, positions, error
    return found, positions, error


def _first_pose(
    tree: Tree, pose: np.ndarray, basis: np.ndarray, tangential: np.ndarray, tol: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """Find the pose whose chord from a pose is as long as a tangential step, and has its direction.

    Chords grow with their tangential parts up to a right angle: the part is found between one whose chord is too short
    and one whose chord is too long. The joints come as near to the others as they can. Returns what `_advance` does,
    with the larger of both errors.
    """
    length, start = math.sqrt((tangential**2).sum()), _positions(tree, pose)
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


def exponential(tree: Tree, pose: np.ndarray, velocity: np.ndarray, n_steps: int) -> tuple[np.ndarray, float]:
    """Follow the geodesic of n chords that begins at a pose with a velocity of the scaled positions.

    Returns the pose at its end and the largest error of a tangential part, relative to the length of a chord.
    """
    basis = tangent_space(tree, pose)
    tangential = basis.T @ velocity / n_steps
    length = math.sqrt((tangential**2).sum())
    if length <= NOTHING * math.sqrt((velocity**2).sum()) / n_steps:
        return pose, 0.0
    tol = ROUNDING * length
    before = _positions(tree, pose)
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
