"""Means and medians under "spatial" by scipy's BFGS.

The objective jumps when an angle difference passes half a turn, which breaks Weiszfeld's iteration. BFGS with a line
search usually reaches a minimum (A. S. Lewis, M. L. Overton, 2013, doi:10.1007/s10107-012-0514-2).
"""

from typing import Any

import numpy as np
from scipy.optimize import minimize

from skpose.geodesics._descent import DAMPING, KINK, MEDIAN, Spread, at_pose_if_lower, spread_from
from skpose.metrics._sample import Sample

HALVINGS = 12  # of a gradient step, if BFGS stops at a jump
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
    for halving in range(HALVINGS):
        trial = spread_from(sample, sample.retract(here.pose, here.step / 2**halving), power)
        if trial.objective < here.objective:
            return trial
    return here
