"""Means and medians by one iteration: a step along the mean logarithm of the poses, at the pose so far.

The mean has the least sum of w d², and its gradient is the weighted sum of those of d²/2. The median has the least sum
of w d: the same sum with weights w/d, which is Weiszfeld's iteration. The step is that gradient in the metric tensor.
Steps are combined as D. G. Anderson does (H. F. Walker, P. Ni, 2011, doi:10.1137/10078356X).
"""

from typing import NamedTuple

import numpy as np

from skpose.metrics._shared import Sample

FLAT = 1e-6  # eigenvalue of the metric tensor, relative to the largest, below which a direction moves no joint
DAMPING = 1e-4  # of steps, relative to the largest eigenvalue of the metric tensor
HALVINGS = 6  # of a step that does not bring the poses nearer
MEMORY = 5  # steps that are combined
INDEPENDENT = 1e-6  # relative size below which a change of the steps is the same as others but for rounding
KINK = 0.02  # pull of the poses, relative to the standard deviation, that may be left where no step lowers the sum
ROUNDING = 1e-9  # standard deviation of poses that are one but for rounding, relative to the speed of the joints, rad
COINCIDES = 1e-9  # distance to a pose, relative to the mean of all distances, at which the median is that pose
NEAR = 0.1  # the same, at which that pose itself is tried
MEAN, MEDIAN = 2, 1  # the power of the distances whose sum is minimised


class Spread(NamedTuple):
    """Distances of the poses from one pose, and the step that brings it nearer to them."""

    pose: np.ndarray  # (n_dofs,)
    objective: float  # the sum that is minimised, of energies for squared distances
    value: float  # mean squared distance, or mean distance
    step: np.ndarray  # (n_dofs,) the mean logarithm, as a change of the pose's coordinates
    norm: float  # its length
    scale: float  # to which that is compared: the standard deviation; 1 for the median
    slope: float  # norm of the gradient by coordinates
    root: np.ndarray  # (n, n_dofs) square root of the metric tensor, for the lengths of steps
    lengths: np.ndarray  # (n_poses,) distances
    unconverged: int
    nearest: int = -1  # the pose that is nearest
    gap: float = 0.0  # the distance to it

    @property
    def relative_norm(self) -> float:
        """The distance from being stationary: zero at a mean or median."""
        return self.norm / max(self.scale, np.finfo(float).tiny)


def spread_from(sample: Sample, pose: np.ndarray, power: int, slope: float = np.inf) -> Spread:
    """Return the spread of the poses about a pose."""
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
        # A pose that the median coincides with holds it there, by a force of its weight (Vardi and Zhang).
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
    """Return the mean logarithm as a step of coordinates, its length, and a square root of the metric tensor.

    The step is zero along what moves no joint.
    """
    values, vectors = np.linalg.eigh(tensor)
    largest = values.max(initial=0.0)
    moving = values > FLAT * largest
    values, vectors = values[moving], vectors[:, moving]
    along = gradient @ vectors
    # Damped: otherwise a dof that moves joints very little would change much, and lead to other geodesics.
    step = -vectors @ (along / (values + DAMPING * largest))
    return step, float(np.sqrt((along**2 / values).sum())), np.sqrt(values)[:, None] * vectors.T


def descend(sample: Sample, pose: np.ndarray, power: int, max_iter: int, tol: float) -> tuple[Spread, int, str]:
    """Follow the mean logarithm from a pose on; return the last spread, the iterations and why it did not converge.

    The reason, with its remedy, is empty if it converged.
    """
    here = spread_from(sample, pose, power)
    falling = True  # the objective, until a path that is refined at one pose and not at the next makes it rise
    history: list[tuple[np.ndarray, np.ndarray]] = []  # steps taken, and what they changed in the next step
    tried: set[int] = set()
    for iteration in range(max_iter):
        if power == MEDIAN:
            here = at_pose_if_lower(sample, here, tried)
        if here.relative_norm <= tol:
            return here, iteration, _explain_unconverged(here, len(sample.dofs))
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
            if not sample.is_uneven:
                return here, iteration, f"after {iteration} iterations no step brought the poses nearer"
            if here.relative_norm <= KINK:
                return here, iteration, _explain_unconverged(here, len(sample.dofs))
            return (
                here,
                iteration,
                f"after {iteration} iterations no step brought the poses nearer, as from some poses to others "
                "the geodesics jump; a larger n_steps may help, a larger max_iter does not",
            )
        history = [*history[1 - MEMORY :], (step, trial.step - here.step)]
        here = trial
    return here, max_iter, f"it was still moving after max_iter={max_iter} iterations; raise max_iter"


def _combine(here: Spread, history: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Return the step that goes where the next step is shortest, if steps change as they did before."""
    if not history:
        return here.step
    taken, changes = (np.stack(column, axis=1) for column in zip(*history, strict=True))
    shares = np.linalg.lstsq(here.root @ changes, here.root @ here.step, rcond=INDEPENDENT)[0]
    return here.step - (taken + changes) @ shares


def at_pose_if_lower(sample: Sample, here: Spread, tried: set[int]) -> Spread:
    """Return the spread about the given pose that is nearest, if the iterate is near and the sum is lower there.

    Steps towards a median that is one of the poses become ever shorter.
    """
    if here.nearest in tried or here.gap > NEAR * here.objective:
        return here
    tried.add(here.nearest)
    there = spread_from(sample, sample.dofs[here.nearest], MEDIAN, here.slope)
    return there if there.objective < here.objective else here


def _explain_unconverged(here: Spread, n_poses: int) -> str:
    """Return the reason not to trust what has been reached: geodesics that did not converge."""
    if not here.unconverged:
        return ""
    return (
        f"{here.unconverged} of the geodesics from it to the {n_poses} poses did not converge; a larger n_steps may "
        "help, a larger max_iter does not"
    )
