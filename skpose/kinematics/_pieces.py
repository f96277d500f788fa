"""The pieces of a skeleton that the solver of geodesics eliminates one after another, see `_compiled.elimination`."""

from typing import Any, NamedTuple

import numpy as np

from skpose._compiled.path.energy import LANES
from skpose.kinematics._frames import Frame

N_FREE = 9, 19  # poses of a path with the default number of steps, for which limbs are chosen, and of a refined one
WORTH = 0.75  # share of a band's multiplications that limbs take at most
CALL = 700  # multiplications in the time of what each four rows of a block take besides


class Pieces(NamedTuple):
    """The pieces without limbs, and with them, as a Tree holds them."""

    first_piece: np.ndarray
    pieces: np.ndarray
    places: np.ndarray
    ancestors: np.ndarray
    most_poses: np.ndarray


class Subtrees(NamedTuple):
    """All frames with dofs, each with what it carries; parents first."""

    first_dof: np.ndarray  # (n_frames,)
    n_dofs: np.ndarray  # (n_frames,) of the frame and of all that it carries: they follow one another
    ancestors: list[np.ndarray]  # dofs that carry it
    carrier: np.ndarray  # (n_frames,) the frame with dofs that carries it, -1 where the root does

    def dofs(self, f: int) -> np.ndarray:
        return np.arange(self.first_dof[f], self.first_dof[f] + self.n_dofs[f])


def _band(n_dofs: Any, n_free: int) -> Any:
    """Return the multiplications of a band: Cholesky, the block right of it and the product of that; and its calls."""
    rows = _padded(n_dofs)
    return n_free * (7 / 6 * rows**3 + CALL * rows)


def _padded(n_dofs: Any) -> Any:
    return -(-n_dofs // LANES) * LANES


def _with_limbs(n_trunk: int, n_dofs: np.ndarray, n_ancestors: np.ndarray, n_free: int) -> float:
    """Return the multiplications for limbs with so many dofs and ancestors: bands, borders, products and the trunk."""
    rows, columns = _padded(n_dofs), n_ancestors * n_free
    of_limbs = _band(n_dofs, n_free) + n_free * rows**2 * columns * 0.75 + n_free * rows * columns**2 / 6
    return of_limbs.sum() + _band(n_trunk * n_free, 1)


def _subtrees(frames: list[Frame]) -> Subtrees:
    number = {frame: f for f, frame in enumerate(frames)}
    first_dof, n_dofs = np.array([(frame.first_dof, frame.n_dofs) for frame in frames], dtype=int).reshape(-1, 2).T
    carrier, ancestors = np.full(len(frames), -1), [np.zeros(0, dtype=int)] * len(frames)
    for f, frame in enumerate(frames):
        parent = frame.parent
        while parent is not None and parent not in number:  # the root, or a constant rotation
            parent = parent.parent
        if parent is not None:
            carrier[f] = number[parent]
            ancestors[f] = np.append(ancestors[carrier[f]], np.arange(parent.first_dof, parent.end_dof))
    for f in range(len(frames) - 1, -1, -1):
        if carrier[f] >= 0:
            n_dofs[carrier[f]] += n_dofs[f]
    return Subtrees(first_dof, n_dofs, ancestors, carrier)


def _limbs(trees: Subtrees, branch: int) -> np.ndarray:
    """Return the frames where the limbs of a branch begin: none where a band takes fewer multiplications.

    They are the largest subtrees with no more than so many dofs, for the best such number.
    """
    n, n_ancestors = trees.n_dofs[branch], np.array([len(dofs) for dofs in trees.ancestors])
    in_branch = (trees.first_dof[branch] <= trees.first_dof) & (trees.first_dof < trees.first_dof[branch] + n)
    best, least = np.zeros(0, dtype=int), WORTH * _band(n, N_FREE[0])
    for largest in np.unique(trees.n_dofs[in_branch])[:-1]:  # the branch itself is no limb
        limbs = np.flatnonzero(in_branch & (trees.n_dofs <= largest) & (trees.n_dofs[trees.carrier] > largest))
        n_dofs = trees.n_dofs[limbs]
        cost = _with_limbs(n - n_dofs.sum(), n_dofs, n_ancestors[limbs], N_FREE[0])
        if cost < least:
            best, least = limbs, cost
    return best


def _most_poses(trees: Subtrees, branches: list[int], limbs: list[np.ndarray]) -> int:
    """Return up to how many free poses limbs are worth it, in all branches that have any."""
    most = 0
    for n_free in N_FREE:
        cost, bands = 0.0, 0.0
        for branch, of_branch in zip(branches, limbs, strict=True):
            if len(of_branch) > 0:
                n_dofs, n_ancestors = trees.n_dofs[of_branch], np.array([len(trees.ancestors[f]) for f in of_branch])
                cost += _with_limbs(trees.n_dofs[branch] - n_dofs.sum(), n_dofs, n_ancestors, n_free)
                bands += _band(trees.n_dofs[branch], n_free)
        if cost < WORTH * bands:
            most = n_free
    return most


def pieces_of(frames: list[Frame]) -> Pieces:
    """Divide the dofs of a skeleton into pieces, given its frames with dofs, parents first."""
    trees = _subtrees(frames)
    branches = np.flatnonzero(trees.carrier < 0).tolist()
    limbs = [_limbs(trees, branch) for branch in branches]
    places, first_piece = np.zeros((2, trees.n_dofs[branches].sum(), 2), dtype=int), [0]
    rows: list[tuple[int, ...]] = []
    ancestors: list[np.ndarray] = []
    for order in (0, 1):
        for branch, chosen in zip(branches, limbs, strict=True):
            first, rest = chosen[: order * len(chosen)].tolist(), trees.dofs(branch)
            trunk = len(rows) + len(first)
            for f in [*first, branch]:
                own = trees.dofs(f) if f != branch else rest
                rest = np.setdiff1d(rest, own)
                places[order, own] = np.stack([np.full(len(own), len(rows)), np.arange(len(own))], axis=1)
                is_dense = f == branch and len(first) > 0
                end = trees.dofs(f)[-1] + 1
                rows.append((trees.first_dof[f], end, len(own), len(trees.ancestors[f]), trunk, is_dense))
                ancestors.append(trees.ancestors[f])
        first_piece.append(len(rows))
    padded = np.zeros((len(rows), max(map(len, ancestors), default=0)), dtype=int)
    for row, dofs in zip(padded, ancestors, strict=True):
        row[: len(dofs)] = dofs
    pieces = np.array(rows, dtype=int).reshape(-1, 6)
    return Pieces(np.array(first_piece), pieces, places, padded, np.array([_most_poses(trees, branches, limbs)]))
