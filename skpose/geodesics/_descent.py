"""Means and medians by gradient descent: steps along the mean logarithm of the poses.

A mean minimises Σ w d², whose gradient is twice Σ w ∇(d²/2), the negative mean logarithm. A median minimises Σ w d,
which Weiszfeld's iteration solves as a mean with weights w/d. Steps are gradients in the metric tensor, combined by
Anderson acceleration (H. F. Walker, P. Ni, 2011, doi:10.1137/10078356X).

Under "spatial" the objective jumps when an angle difference passes half a turn, which breaks Weiszfeld's iteration.
scipy's BFGS with a line search usually reaches a minimum (A. S. Lewis, M. L. Overton, 2013,
doi:10.1007/s10107-012-0514-2).
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize

from skpose.metrics._means import Sample

FLAT = 1e-6  # relative eigenvalue of the metric tensor below which a direction moves no joint
DAMPING = 1e-4  # of steps, relative to the largest eigenvalue of the metric tensor
HALVINGS = 6  # of a step that does not lower the objective
MEMORY = 5  # steps that Anderson acceleration combines
INDEPENDENT = 1e-6  # relative singular value below which changes of steps are linearly dependent
KINK = 0.02  # gradient, relative to the standard deviation, accepted if no step lowers a non-smooth objective
ROUNDING = 1e-9  # standard deviation of equal poses, relative to the speed of the joints, rad
COINCIDES = 1e-9  # distance to a pose, relative to the mean distance, below which the median is that pose
NEAR = 0.1  # relative distance to a pose below which that pose is tried as the median
MEAN, MEDIAN = 2, 1  # power of the distances in the objective


class Spread(NamedTuple):
    """Distances from one pose to the sample, and the next step."""

    pose: np.ndarray  # (n_dofs,)
    objective: float  # the sum that is minimised; energies stand for squared distances
    value: float  # mean squared distance, or mean distance
    step: np.ndarray  # (n_dofs,) the mean logarithm in the coordinates of the pose
    norm: float  # length of the mean logarithm
    scale: float  # unit of `norm` in the stopping criterion: the standard deviation, or 1 for the median
    slope: float  # norm of the gradient in coordinates
    root: np.ndarray  # (n, n_dofs) square root of the metric tensor
    lengths: np.ndarray  # (n_poses,) distances
    unconverged: int
    nearest: int = -1  # index of the nearest pose
    gap: float = 0.0  # distance to the nearest pose

    @property
    def relative_norm(self) -> float:
        """Relative distance from a stationary point."""
        return self.norm / max(self.scale, np.finfo(float).tiny)


def spread_from(sample: Sample, pose: np.ndarray, power: int, slope: float = np.inf) -> Spread:
    local = sample.linearize(pose, slope)
    weights, coincident = sample.weights, 0.0
    if power == MEAN:
        objective, value = weights @ local.energies, weights @ local.lengths**2
        scale = max(np.sqrt(value), ROUNDING * np.sqrt(np.trace(local.tensor)))
    else:
        distances = np.sqrt(local.energies)
        objective, value, scale = weights @ distances, weights @ local.lengths, 1.0
        here = distances <= max(COINCIDES * objective, ROUNDING * np.sqrt(np.trace(local.tensor)))
        coincident = weights[here].sum()
        weights = np.where(here, 0.0, weights) / np.where(here, 1.0, distances)
    total = weights.sum()
    gradient = weights @ local.gradients
    step, norm, root = mean_logarithm(local.tensor, gradient)
    if power == MEDIAN:
        step = step / total if total > 0.0 else step
        # A pose at the median attracts it with the force of its weight (Vardi and Zhang).
        step = max(0.0, 1.0 - coincident / norm) * step if norm > 0.0 else step
        norm = max(0.0, norm - coincident)
    slope = float(np.linalg.norm(gradient)) / total if total > 0.0 else 0.0
    nearest = int(local.energies.argmin())
    return Spread(
        pose=pose,
        objective=float(objective),
        value=float(value),
        step=step,
        norm=norm,
        scale=float(scale),
        slope=slope,
        root=root,
        lengths=local.lengths,
        unconverged=local.n_unconverged,
        nearest=nearest,
        gap=float(np.sqrt(local.energies[nearest])),
    )


def mean_logarithm(tensor: np.ndarray, gradient: np.ndarray) -> tuple[np.ndarray, float, np.ndarray]:
    """Mean logarithm in coordinates, its length, and a square root of the metric tensor; flat directions are zero."""
    values, vectors = np.linalg.eigh(tensor)
    largest = values.max(initial=0.0)
    moving = values > FLAT * largest
    values, vectors = values[moving], vectors[:, moving]
    along = gradient @ vectors
    # Without damping, dofs that hardly move the joints would change a lot and lead to different geodesics.
    step = -vectors @ (along / (values + DAMPING * largest))
    return step, float(np.sqrt((along**2 / values).sum())), np.sqrt(values)[:, None] * vectors.T


def descend(sample: Sample, pose: np.ndarray, power: int, max_iter: int, tol: float) -> tuple[Spread, int, bool]:
    """Descend from a pose; also the number of iterations, and whether it converged."""
    here = spread_from(sample, pose, power)
    falling = True  # False once refined paths have made the objective uneven
    history: list[tuple[np.ndarray, np.ndarray]] = []  # steps, and the change of the next step
    tried: set[int] = set()
    for iteration in range(max_iter):
        if power == MEDIAN:
            here = at_pose_if_lower(sample, here, tried)
        if here.relative_norm <= tol:
            return here, iteration, not here.unconverged
        step, combined = _combine(here, history), bool(history)
        for halving in range(HALVINGS + 1):
            trial = spread_from(sample, sample.retract(here.pose, step), power, here.slope)
            lower = trial.objective < here.objective
            if sample.is_uneven and not history:
                falling = falling and lower
            if lower if falling else trial.norm < here.norm:
                break
            step, history = here.step / 2 ** (halving if combined else halving + 1), []
        else:
            return here, iteration, sample.is_uneven and here.relative_norm <= KINK and not here.unconverged
        history = [*history[1 - MEMORY :], (step, trial.step - here.step)]
        here = trial
    return here, max_iter, False


def _combine(here: Spread, history: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Anderson acceleration: the step after which the next one is shortest, by linear extrapolation."""
    if not history:
        return here.step
    taken, changes = (np.stack(column, axis=1) for column in zip(*history, strict=True))
    shares = np.linalg.lstsq(here.root @ changes, here.root @ here.step, rcond=INDEPENDENT)[0]
    return here.step - (taken + changes) @ shares


def at_pose_if_lower(sample: Sample, here: Spread, tried: set[int]) -> Spread:
    """The spread at the nearest pose of the sample, if that is near and lower: a median may be one of the poses."""
    if here.nearest in tried or here.gap > NEAR * here.objective:
        return here
    tried.add(here.nearest)
    there = spread_from(sample, sample.dofs[here.nearest], MEDIAN, here.slope)
    return there if there.objective < here.objective else here


HALVINGS_ACROSS = 12  # of a gradient step, if BFGS stops at a jump
LEAST_DECREASE = 0.1  # relative decrease, divided by tol², below which the search stops


def minimise_sum(sample: Any, pose: np.ndarray, power: int, max_iter: int, tol: float) -> tuple[Spread, int, bool]:
    """Minimise from a pose, or from a better pose of the sample; the result is as in `descend`.

    The sample has the methods `best_pose` and `sum_along` too, see `skpose.metrics._spatial`.
    """
    here = spread_from(sample, pose, power)
    candidate, objective = sample.best_pose(power)
    if objective < here.objective:
        here = spread_from(sample, candidate, power)
    n_iter, tried, kept = 0, set[int](), 1.0 - LEAST_DECREASE * tol**2
    while True:
        if power == MEDIAN:
            here = at_pose_if_lower(sample, here, tried)
        if here.relative_norm <= tol:
            return here, n_iter, True
        if n_iter >= max_iter:
            return here, n_iter, False
        sizes = (here.root**2).sum(axis=1, keepdims=True)  # eigenvalues of the metric tensor
        steps = (here.root / np.sqrt(sizes * (sizes + DAMPING * sizes.max()))).T
        found = minimize(
            sample.sum_along,
            np.zeros(steps.shape[1]),
            args=(here.pose, steps, power),
            method="BFGS",
            jac=True,
            options={"maxiter": max_iter - n_iter, "gtol": 0.5 * tol * here.scale, "norm": 2},
        )
        n_iter += max(1, int(found.nit))
        there = spread_from(sample, sample.retract(here.pose, steps @ found.x), power)
        if there.objective > kept * here.objective:
            there = _across(sample, there if there.objective < here.objective else here, power)
        if there.objective > kept * here.objective:
            return here, n_iter, here.relative_norm <= KINK
        here = there


def _across(sample: Sample, here: Spread, power: int) -> Spread:
    """A shorter gradient step that lowers the objective, possibly across a jump; else the same spread."""
    for halving in range(HALVINGS_ACROSS):
        trial = spread_from(sample, sample.retract(here.pose, here.step / 2**halving), power)
        if trial.objective < here.objective:
            return trial
    return here
