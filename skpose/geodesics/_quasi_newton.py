"""Means and medians under "spatial" by scipy's BFGS: its sum has kinks and jumps, where Weiszfeld's steps fail.

A line jumps to another one where a difference of angles is half a turn. Quasi-Newton methods with a line search come to
a minimum nevertheless, mostly (A. S. Lewis, M. L. Overton, 2013, doi:10.1007/s10107-012-0514-2).
"""

import numpy as np
from scipy.optimize import minimize

from skpose.geodesics._descent import DAMPING, KINK, MEDIAN, Spread, at_pose_if_lower, spread_from
from skpose.metrics._shared import Sample

HALVINGS = 12  # of a step along the gradient, where BFGS ends at a jump
LEAST_DECREASE = 0.1  # of the sum, relative, over the square of the tolerance, for which the search goes on


def minimise_sum(sample: Sample, pose: np.ndarray, power: int, max_iter: int, tol: float) -> tuple[Spread, int, str]:
    """Minimise the sum from a pose on, or from a given one where that is better, and never to a larger sum.

    Return the last spread, the iterations and why it did not converge; the reason is empty if it did.
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
            return here, n_iter, ""
        if n_iter >= max_iter:
            return here, n_iter, f"it was still moving after max_iter={max_iter} iterations; raise max_iter"
        sizes = (here.root**2).sum(axis=1, keepdims=True)  # eigenvalues of the metric tensor, of its vectors' multiples
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
            break
        here = there
    if here.relative_norm <= KINK:
        return here, n_iter, ""
    return (
        here,
        n_iter,
        (
            f"after {n_iter} iterations no step brought the poses nearer, as lines jump where a difference of angles "
            "is half a turn; poses of ball joints, see Skeleton.to_rotvec, jump less, a larger max_iter does not help"
        ),
    )


def _across(sample: Sample, here: Spread, power: int) -> Spread:
    """Return the spread where a step along the gradient lowers the sum, over a jump maybe, or else the same one."""
    for halving in range(HALVINGS):
        trial = spread_from(sample, sample.retract(here.pose, here.step / 2**halving), power)
        if trial.objective < here.objective:
            return trial
    return here
