"""Inverse kinematics of the frames of a sequence, each from the one before, and of single frames.

Angles that the positions leave open, such as twists, go back to the first pose a part of the way in each frame, so that
they cannot drift. Where the end of a bone is lost, which other frames see, they stay as in the frame before.
"""

import math
from typing import NamedTuple

import numpy as np

from skpose._compiled.inverse.energy import Target, copy_state, place_state, set_pose, start_at, workspace_of
from skpose._compiled.inverse.start import fit_afresh
from skpose._compiled.inverse.step import LEAST_DAMPING, Fit, minimise_pose
from skpose._compiled.pose.chart import dofs_of
from skpose._compiled.pose.tree import TWO_PI
from skpose._compiled.simd.jit import internal, jit
from skpose._compiled.simd.lanes import copy_to

WORSE, MORE = 2.0, 1e-6  # a frame starts afresh too if it is farther off than the one before: times, and m


class Observed(NamedTuple):
    """Positions of the joints in a sequence, in the tree's order, the root's first."""

    positions: np.ndarray  # (n_frames, n_joints + 1, 3) m; finite everywhere
    weights: np.ndarray  # (n_frames, n_joints + 1) zero where not seen; the largest of a frame is 1
    stiffness: np.ndarray  # (n_frames,) ρ² of these weights, m²/rad²
    ever: np.ndarray  # (n_joints + 1,) bool: seen in some frame
    changes: np.ndarray  # (n_frames,) largest change of an angle since the frame before, rad; or infinite


class Rules(NamedTuple):
    """Settings for all frames."""

    is_sequence: bool  # each frame starts from the one before, or else from a pose of its own
    warm_iter: int  # iterations from the frame before
    max_iter: int  # iterations from a first pose
    tries_first: bool  # whether a sequence also starts from its first pose as it is, and takes the better one
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
def _unwind(tree, state, target):
    """Take whole turns off angles without bounds, so that they are within half a turn of θ₀; return whether any had."""
    any_turn = False
    for f in range(2, tree.frame_parent.shape[0]):
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            if tree.ball[f] < 0 and tree.slide[f] < 0 and target.lower[d] == -math.inf and target.upper[d] == math.inf:
                turns = np.rint((state.dofs[d] - target.prior_dofs[d]) / TWO_PI)
                state.dofs[d] -= TWO_PI * turns
                any_turn = any_turn or abs(turns) > 0.0  # false for NaN
    return any_turn


@internal
def _remove_turns(work, target, fit, max_iter):
    """Take whole turns off the angles of a fit: a hinge that the positions leave nearly open may go through many.

    With a stiffness they cost, so without them the minimum is elsewhere.
    """
    while _unwind(work.tree, work.here, target) and target.stiffness > 0.0:
        again = minimise_pose(work, target, LEAST_DAMPING, max_iter)
        fit = Fit(again.half, fit.n_iter + again.n_iter, again.converged)
    return fit


@internal
def _write(tree, work, target, near, fit, found, i):
    """Write the state as the pose of frame i; of the numbers that are one rotation, those nearest to a pose's."""
    here = work.here
    copy_to(work.tree.reference, here.rotations)
    dofs_of(tree, work.tree, here.dofs, near, found.dofs[i])
    copy_to(found.origins[i], here.origin)
    for j in range(target.weights.shape[0]):
        square = 0.0
        for k in range(3):
            square += (here.P[3 * j + k] + here.origin[k] - target.positions[j, k]) ** 2
        found.residuals[i, j] = math.sqrt(square)
    found.n_iter[i], found.converged[i] = fit.n_iter, fit.converged


@internal
def _settle(tree, observed, i, rotations, angles, state, target):
    """Let the prior be the first pose; the frame before for joints before a lost one, and for one that starts at it."""
    copy_to(target.prior, rotations)
    copy_to(target.prior_dofs, angles)
    lost = observed.ever & (observed.weights[i] == 0.0)
    frames_lost = np.zeros(tree.frame_parent.shape[0], np.bool_)
    for j in range(1, lost.shape[0]):
        frames_lost[tree.joint_frame[j]] |= lost[j]
    for f in range(tree.frame_parent.shape[0] - 1, 1, -1):
        frames_lost[tree.frame_parent[f]] |= frames_lost[f]
    for f in range(2, tree.frame_parent.shape[0]):
        if frames_lost[f] or lost[tree.pivot[f]]:
            copy_to(target.prior[f], state.rotations[f])
            for d in range(tree.first_dof[f], tree.end_dof[f]):
                target.prior_dofs[d] = state.dofs[d]


@internal
def _distance(fit, weights):
    """The weighted root mean square of the distances."""
    return math.sqrt(2.0 * fit.half / weights[1:].sum())


@jit
def fit_frames(tree, observed, initials, rules, warm_up, found):
    """Find the poses of a sequence, or of frames that each have a first pose; nothing is written of the first ones.

    Of a sequence, a frame in which nothing is seen has the pose of the frame before.
    """
    work = workspace_of(tree, rules.lower, rules.upper)
    rotations, angles = np.zeros(work.here.rotations.shape), np.zeros(initials.shape[1])
    rotations[:, 0] = 1.0
    prior, prior_dofs = rotations.copy(), angles.copy()
    lower, upper = rules.lower.copy(), rules.upper.copy()
    started, last = False, math.inf
    for i in range(observed.positions.shape[0]):
        initial = initials[0 if rules.is_sequence else i]
        if i == 0 or not rules.is_sequence:
            set_pose(tree, initial, rotations, angles)
            start_at(work.tree, work.here, rotations, angles)
            place_state(work, work.here)
            copy_to(prior, rotations)
            copy_to(prior_dofs, angles)
            started = False
        change = observed.changes[i] if started else math.inf
        for d in range(lower.shape[0]):
            lower[d] = max(rules.lower[d], work.here.dofs[d] - change)
            upper[d] = min(rules.upper[d], work.here.dofs[d] + change)
        target = Target(
            observed.positions[i],
            observed.weights[i],
            prior,
            prior_dofs,
            observed.stiffness[i],
            lower,
            upper,
        )
        fit = Fit(0.0, 0, False)
        if target.weights.any():
            if started:
                _settle(tree, observed, i, rotations, angles, work.here, target)
                fit = minimise_pose(work, target, LEAST_DAMPING, rules.warm_iter)
            distance = _distance(fit, target.weights)
            if change == math.inf and (not started or not fit.converged or distance > WORSE * last + MORE):
                copy_state(work.here, work.kept)
                again = fit_afresh(work, target, prior, prior_dofs, rules.max_iter, True)
                n_iter = fit.n_iter + again.n_iter
                if fit.converged and (fit.half <= again.half or not again.converged):
                    copy_state(work.kept, work.here)
                else:
                    fit = again
                fit = Fit(fit.half, n_iter, fit.converged)
            if rules.tries_first and not started:
                copy_state(work.here, work.kept)
                again = fit_afresh(work, target, prior, prior_dofs, rules.max_iter, False)
                if again.half < fit.half:
                    fit = Fit(again.half, fit.n_iter + again.n_iter, again.converged)
                else:
                    copy_state(work.kept, work.here)
            fit = _remove_turns(work, target, fit, rules.max_iter)
            distance = _distance(fit, target.weights)
            started, last = True, min(distance, WORSE * last + MORE)
        if i >= warm_up:
            _write(tree, work, target, initial, fit, found, i - warm_up)
