"""The order in which the dofs of a path are eliminated, see `skpose._compiled.path.elimination`.

Which limbs are chosen is decided by the multiplications that they take. They are counted in twelfths: so all counts are
whole numbers, and no rounding chooses.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from skpose._compiled.path.energy import LANES

# Free poses of a path with the default number of steps, which decides on limbs, and of a refined one.
N_FREE, N_FREE_REFINED = 9, 19
WORTH = 0.75  # share of a band's multiplications that limbs take at most
CALL = 700  # multiplications in the time of what each four rows of a block take besides


class Subtree(NamedTuple):
    """A frame with dofs, and all that it carries."""

    first_dof: int
    n_dofs: int  # they follow one another
    ancestors: list[int]  # the dofs that carry it
    n_dofs_of_carrier: float


def supernodes_of(
    first_dof: np.ndarray,
    end_dof: np.ndarray,
    dof_ranges: Sequence,
    worth: float = WORTH,
) -> dict[str, np.ndarray]:
    """The fields of a `Tree` with its supernodes; the ranges of dofs are lists, one for each frame."""
    branches = _branches(first_dof, end_dof, dof_ranges)
    limbs = [_choose_limbs(branch, worth) for branch in branches]
    rows: list[list[int]] = []
    of_dof = np.full((2, end_dof.max(initial=0), 2), -1)
    ancestors: list[list[int]] = []
    starts = [0]
    for kind in range(2):
        for branch, its_limbs in zip(branches, limbs, strict=True):
            first = its_limbs if kind == 1 else []
            trunk = len(rows) + len(first)
            for one in [*first, branch[0]]:
                k, is_limb = len(rows), one is not branch[0]
                dofs = one.first_dof + np.flatnonzero(of_dof[kind, one.first_dof :, 0][: one.n_dofs] < 0)
                of_dof[kind, dofs, 0], of_dof[kind, dofs, 1] = k, np.arange(len(dofs))
                ancestors.append(one.ancestors if is_limb else [])
                is_dense = bool(first) and not is_limb
                ends = one.first_dof, one.first_dof + one.n_dofs
                rows.append([*ends, len(dofs), len(ancestors[k]), trunk, is_dense])
        starts.append(len(rows))
    padded = np.zeros((len(rows), max(map(len, ancestors), default=0)), dtype=int)
    for k, carriers in enumerate(ancestors):
        padded[k, : len(carriers)] = carriers
    most_poses = [n for n in (N_FREE, N_FREE_REFINED) if _are_worth_it(branches, limbs, worth, n)]
    return {
        "first_supernode": np.array(starts),
        "supernodes": np.array(rows, dtype=int).reshape(-1, 6),
        "supernode_of": of_dof,
        "limb_ancestors": padded,
        "most_poses": np.array([max(most_poses, default=0)]),
    }


def _branches(first_dof: np.ndarray, end_dof: np.ndarray, dof_ranges: Sequence) -> list[list[Subtree]]:
    """The subtrees of each branch of the skeleton, in the order of the dofs: the branch itself first."""
    frames = sorted(
        (first, end, ranges)
        for first, end, ranges in zip(first_dof.tolist(), end_dof.tolist(), dof_ranges, strict=True)
        if end > first
    )
    n_dofs = {first: end - first for first, end, _ in frames}
    ancestors = {first: [d for a, b in ranges for d in range(a, min(b, first))] for first, _, ranges in frames}
    frame_of = np.repeat(list(n_dofs), list(n_dofs.values())).tolist()
    for first in reversed(ancestors):
        if ancestors[first]:
            n_dofs[frame_of[ancestors[first][-1]]] += n_dofs[first]
    branches: list[list[Subtree]] = []
    for first, dofs in ancestors.items():
        if not dofs:
            branches.append([])
        carrier = n_dofs[frame_of[dofs[-1]]] if dofs else math.inf
        branches[-1].append(Subtree(first, n_dofs[first], dofs, carrier))
    return branches


def _limbs(branch: list[Subtree], largest: int) -> list[Subtree]:
    """The largest subtrees of a branch with no more than so many dofs."""
    return [one for one in branch[1:] if one.n_dofs <= largest < one.n_dofs_of_carrier]


def _band(n_dofs: int, n_free: int) -> int:
    """The multiplications of a band: Cholesky, the block right of it and the product of that; and its calls."""
    rows = -(-n_dofs // LANES) * LANES
    return n_free * (14 * rows**3 + 12 * CALL * rows)


def _with_limbs(branch: list[Subtree], limbs: list[Subtree], n_free: int) -> int:
    """The multiplications for the limbs of a branch: bands, borders, products and the trunk."""
    total, n_trunk = 0, branch[0].n_dofs
    for limb in limbs:
        rows, columns = -(-limb.n_dofs // LANES) * LANES, len(limb.ancestors) * n_free
        total += _band(limb.n_dofs, n_free) + n_free * rows * columns * (9 * rows + 2 * columns)
        n_trunk -= limb.n_dofs
    return total + _band(n_trunk * n_free, 1)


def _choose_limbs(branch: list[Subtree], worth: float) -> list[Subtree]:
    """The limbs of a branch: none where a band takes fewer multiplications."""
    least, chosen = worth * _band(branch[0].n_dofs, N_FREE), []
    for largest in sorted({one.n_dofs for one in branch[1:]} - {branch[0].n_dofs}):
        limbs = _limbs(branch, largest)
        cost = _with_limbs(branch, limbs, N_FREE)
        if cost < least:
            least, chosen = cost, limbs
    return chosen


def _are_worth_it(branches: list[list[Subtree]], limbs: list[list[Subtree]], worth: float, n_free: int) -> bool:
    """Whether limbs are worth it for so many free poses, in all branches that have any."""
    having = [(branch, some) for branch, some in zip(branches, limbs, strict=True) if some]
    bands = sum(_band(branch[0].n_dofs, n_free) for branch, _ in having)
    return sum(_with_limbs(*one, n_free) for one in having) < worth * bands
