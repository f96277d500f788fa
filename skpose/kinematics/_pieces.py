"""The pieces of a skeleton that the solver of geodesics eliminates one after another, see `_compiled.elimination`."""

import math
from typing import Any, NamedTuple

import numpy as np

from skpose.kinematics._frames import Frame

N_FREE = 9  # poses of a path with the default number of steps, for which limbs are chosen
WORTH = 0.75  # share of a band's multiplications that limbs take at most: theirs are in smaller loops, which are slower


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


class Cost(NamedTuple):
    """Multiplications of the factors for n free poses: linear · n + quadratic · n² + cubic · n³."""

    linear: float
    quadratic: float
    cubic: float

    def at(self, n_free: int) -> float:
        return self.linear * n_free + self.quadratic * n_free**2 + self.cubic * n_free**3


class Choice(NamedTuple):
    """The limbs of a branch, and their cost."""

    limbs: np.ndarray  # frames where they begin
    cost: Cost
    band: float  # what limbs may take for each pose


def _band(n_dofs: Any) -> Any:
    """Return the multiplications for one pose of a band: Cholesky, the block right of it, and the product of that."""
    return 7 / 6 * n_dofs**3


def _cost(n_trunk: int, n_dofs: np.ndarray, n_ancestors: np.ndarray) -> Cost:
    """Return the cost of limbs with so many dofs and ancestors, and of their trunk."""
    borders, products = 0.75 * n_dofs**2 @ n_ancestors, n_dofs @ n_ancestors**2 / 6
    return Cost(_band(n_dofs).sum(), borders, products + n_trunk**3 / 6)


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


def _choice(trees: Subtrees, branch: int) -> Choice:
    """Choose the limbs of a branch: the largest subtrees with no more than so many dofs, for the best such number.

    There are none where a band takes fewer multiplications.
    """
    n, n_ancestors = trees.n_dofs[branch], np.array([len(dofs) for dofs in trees.ancestors])
    in_branch = (trees.first_dof[branch] <= trees.first_dof) & (trees.first_dof < trees.first_dof[branch] + n)
    best = Choice(np.zeros(0, dtype=int), Cost(0.0, 0.0, 0.0), 0.0)
    band = WORTH * _band(n)
    least = band * N_FREE
    for largest in np.unique(trees.n_dofs[in_branch])[:-1]:  # the branch itself is no limb
        limbs = np.flatnonzero(in_branch & (trees.n_dofs <= largest) & (trees.n_dofs[trees.carrier] > largest))
        limbs = limbs[np.argsort(trees.first_dof[limbs])]
        cost = _cost(n - trees.n_dofs[limbs].sum(), trees.n_dofs[limbs], n_ancestors[limbs])
        if cost.at(N_FREE) < least:
            least, best = cost.at(N_FREE), Choice(limbs, cost, band)
    return best


def _most_poses(choices: list[Choice]) -> int:
    """Return up to how many free poses limbs are worth it, in all branches that have any."""
    linear, quadratic, cubic = np.sum([choice.cost for choice in choices], axis=0)
    if cubic == 0.0:
        return 0
    spare = sum(choice.band for choice in choices) - linear
    return math.floor((math.sqrt(quadratic**2 + 4 * cubic * spare) - quadratic) / (2 * cubic))


def pieces_of(frames: list[Frame]) -> Pieces:
    """Divide the dofs of a skeleton into pieces, given its frames with dofs, parents first."""
    trees = _subtrees(frames)
    branches = np.flatnonzero(trees.carrier < 0).tolist()
    choices = [_choice(trees, branch) for branch in branches]
    places, first_piece = np.zeros((2, trees.n_dofs[branches].sum(), 2), dtype=int), [0]
    rows: list[tuple[int, ...]] = []
    ancestors: list[np.ndarray] = []
    for order in (0, 1):
        for branch, choice in zip(branches, choices, strict=True):
            limbs, rest = choice.limbs[: order * len(choice.limbs)], trees.dofs(branch)
            trunk = len(rows) + len(limbs)
            for f in [*limbs.tolist(), branch]:
                own = trees.dofs(f) if f != branch else rest
                rest = np.setdiff1d(rest, own)
                places[order, own] = np.stack([np.full(len(own), len(rows)), np.arange(len(own))], axis=1)
                is_dense = f == branch and len(limbs) > 0
                end = trees.dofs(f)[-1] + 1
                rows.append((trees.first_dof[f], end, len(own), len(trees.ancestors[f]), trunk, is_dense))
                ancestors.append(trees.ancestors[f])
        first_piece.append(len(rows))
    padded = np.zeros((len(rows), max(map(len, ancestors), default=0)), dtype=int)
    for row, dofs in zip(padded, ancestors, strict=True):
        row[: len(dofs)] = dofs
    pieces = np.array(rows, dtype=int).reshape(-1, 6)
    return Pieces(np.array(first_piece), pieces, places, padded, np.array([_most_poses(choices) if choices else 0]))
