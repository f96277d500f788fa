"""Inverse kinematics of the frames of a sequence, each from the one before, and of frames one by one.

The pose of a frame depends on the positions of that frame: what they leave open, such as twists, is settled by the
first pose, not by the frame before, so that it cannot drift. Only where the end of a bone is lost, a joint that
other frames see, the frame before settles what that joint leaves open.
"""

import math
from typing import NamedTuple

import numpy as np

from skpose._compiled.chart import dofs_of
from skpose._compiled.inverse import (
    LEAST_DAMPING,
    MAX_ITER,
    Fit,
    Target,
    copy_state,
    minimise_pose,
    set_pose,
    start_at,
    workspace_of,
)
from skpose._compiled.inverse_start import fit_afresh
from skpose._compiled.jit import internal, jit

WORSE, MORE = 2.0, 1e-6  # a frame is tried afresh if its distance is so many times that of the one before, and this
# much more, m
WARM_ITER = 20  # iterations from the frame before
TURN = 2.0 * math.pi


class Observed(NamedTuple):
    """Positions of the joints in a sequence, in the tree's order, the root's first."""

    positions: np.ndarray  # (n_frames, n_joints + 1, 3) m; finite everywhere
    weights: np.ndarray  # (n_frames, n_joints + 1) zero where not seen; the largest of a frame is 1
    stiffness: np.ndarray  # (n_frames,) ρ² of these weights, m²/rad²
    ever: np.ndarray  # (n_joints + 1,) bool: seen in some frame


class Rules(NamedTuple):
    """Rules that hold for all frames."""

    frees_angles: bool  # joints of three angles are rotations, without limits
    lower: np.ndarray  # (n_dofs,) rad
    upper: np.ndarray  # (n_dofs,) rad


class Found(NamedTuple):
    """The poses of a sequence."""

    dofs: np.ndarray  # (n_frames, n_dofs) in the tree's order, the root's orientation first, rad
    origins: np.ndarray  # (n_frames, 3) positions of the root, m
    residuals: np.ndarray  # (n_frames, n_joints + 1) distances from the given positions, m
    n_iter: np.ndarray  # (n_frames,)
    converged: np.ndarray  # (n_frames,) bool


@internal
def _unwind(state, target):
    """Take whole turns off angles without bounds, so that they are within half a turn of θ₀; return whether any had."""
    free, any_turn = state.tree, False
    for f in range(2, free.frame_parent.shape[0]):
        for d in range(free.first_dof[f], free.end_dof[f]):
            if free.ball[f] < 0 and target.lower[d] == -math.inf and target.upper[d] == math.inf:
                turns = np.rint((state.dofs[d] - target.prior_dofs[d]) / TURN)
                state.dofs[d] -= TURN * turns
                any_turn = any_turn or abs(turns) > 0.0  # false for NaN
    return any_turn


@internal
def _without_turns(work, target, fit):
    """Take whole turns off the angles of a fit: a hinge that the positions leave nearly open may go through many.

    With a stiffness they cost, so without them the minimum is elsewhere.
    """
    while _unwind(work.here, target) and target.stiffness > 0.0:
        again = minimise_pose(work, target, LEAST_DAMPING, MAX_ITER)
        fit = Fit(again.half, fit.n_iter + again.n_iter, again.converged)
    return fit


@internal
def _write(tree, work, target, near, fit, found, i):
    """Write the state as the pose of frame i; of the numbers that are one rotation, those nearest to a pose's."""
    here = work.here
    dofs_of(tree, here.tree, here.dofs, near, found.dofs[i])
    found.origins[i] = here.origin
    for j in range(target.weights.shape[0]):
        square = 0.0
        for k in range(3):
            square += (here.P[3 * j + k] + here.origin[k] - target.positions[j, k]) ** 2
        found.residuals[i, j] = math.sqrt(square)
    found.n_iter[i], found.converged[i] = fit.n_iter, fit.converged


@internal
def _settle(tree, observed, i, rotations, angles, state, target):
    """Let the prior be the first pose; the frame before where an end of a frame's bones is lost."""
    target.prior[:] = rotations
    target.prior_dofs[:] = angles
    lost = observed.ever & (observed.weights[i] == 0.0)
    frames_lost = np.zeros(tree.frame_parent.shape[0], np.bool_)
    for j in range(1, lost.shape[0]):
        frames_lost[tree.joint_frame[j]] |= lost[j]
    for f in range(2, tree.frame_parent.shape[0]):
        if frames_lost[f] or lost[tree.pivot[f]]:
            target.prior[f] = state.tree.reference[f]
            for d in range(tree.first_dof[f], tree.end_dof[f]):
                target.prior_dofs[d] = state.dofs[d]


@internal
def _distance(fit, weights):
    """Return the weighted root mean square of the distances."""
    total = 0.0
    for j in range(1, weights.shape[0]):
        total += weights[j]
    return math.sqrt(2.0 * fit.half / total)


@internal
def _no_fit():
    return Fit(0.0, 0, False)


@jit
def fit_sequence(tree, observed, initial, rules, run_in, found):
    """Find the poses of a sequence; of the first frames, `run_in` of them, nothing is written.

    A frame in which nothing is seen has the pose of the frame before.
    """
    work = workspace_of(tree, rules.frees_angles)
    rotations, angles = np.zeros((tree.frame_parent.shape[0], 4)), np.zeros(initial.shape[0])
    rotations[:, 0] = 1.0
    set_pose(tree, initial, rotations, angles)
    start_at(work.here, rotations, angles)
    prior, prior_dofs = rotations.copy(), angles.copy()
    started, last = False, math.inf
    for i in range(observed.positions.shape[0]):
        target = Target(
            observed.positions[i],
            observed.weights[i],
            prior,
            prior_dofs,
            observed.stiffness[i],
            rules.lower,
            rules.upper,
        )
        fit = _no_fit()
        if target.weights.any():
            n_iter = 0
            if started:
                _settle(tree, observed, i, rotations, angles, work.here, target)
                fit = minimise_pose(work, target, LEAST_DAMPING, WARM_ITER)
                n_iter = fit.n_iter
            distance = _distance(fit, target.weights)
            if not started or not fit.converged or distance > WORSE * last + MORE:
                copy_state(work.here, work.kept)
                again = fit_afresh(work, target, prior, prior_dofs)  # what is lost keeps the angles of the frame before
                n_iter += again.n_iter
                if started and (fit.half <= again.half or not again.converged) and fit.converged:
                    copy_state(work.kept, work.here)
                else:
                    fit = again
            fit = Fit(fit.half, n_iter, fit.converged)
            fit = _without_turns(work, target, fit)
            distance = _distance(fit, target.weights)
            started, last = True, min(distance, WORSE * last + MORE)
        if i >= run_in:
            _write(tree, work, target, initial, fit, found, i - run_in)


@jit
def fit_frames(tree, observed, initials, rules, found):
    """Find the poses of frames that have nothing to do with each other, each from a first pose of its own."""
    work = workspace_of(tree, rules.frees_angles)
    rotations, angles = np.zeros((tree.frame_parent.shape[0], 4)), np.zeros(initials.shape[1])
    rotations[:, 0] = 1.0
    for i in range(observed.positions.shape[0]):
        set_pose(tree, initials[i], rotations, angles)
        target = Target(
            observed.positions[i],
            observed.weights[i],
            rotations,
            angles,
            observed.stiffness[i],
            rules.lower,
            rules.upper,
        )
        fit = _no_fit()
        if target.weights.any():
            fit = _without_turns(work, target, fit_afresh(work, target, rotations, angles))
        else:
            start_at(work.here, rotations, angles)
            work.here.origin[:] = 0.0
        _write(tree, work, target, initials[i], fit, found, i)
