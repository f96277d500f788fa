"""The order in which the dofs of a path are eliminated: the supernodes of the skeleton, see `elimination`.

Which limbs are chosen is decided by the multiplications that they take. They are counted in twelfths: so all counts are
whole numbers, and no rounding chooses.
"""

from typing import NamedTuple

import numpy as np

from skpose._compiled.path.energy import LANES
from skpose._compiled.pose.signatures import TREE
from skpose._compiled.simd.jit import by_address, internal
from skpose._compiled.simd.signatures import INTEGER, INTEGER_CUBE, INTEGER_MATRIX, INTEGER_VECTOR, REAL, tuple_type

# Free poses of a path with the default number of steps, which decides on limbs, and of a refined one.
N_FREE, N_FREE_REFINED = 9, 19
WORTH = 0.75  # share of a band's multiplications that limbs take at most
CALL = 700  # multiplications in the time of what each four rows of a block take besides


class Order(NamedTuple):
    """The supernodes without limbs, and with them."""

    first_supernode: np.ndarray  # (3,) kind i has supernodes[first_supernode[i]:first_supernode[i + 1]]
    supernodes: np.ndarray  # (n_supernodes, 6) first dof, end, number of dofs, of ancestors, the trunk, 1 if dense
    indices: np.ndarray  # (2, n_dofs, 2) the supernode of each dof, and its index there
    ancestors: np.ndarray  # (n_supernodes, n) the dofs that carry a limb
    most_poses: np.ndarray  # (1,) free poses of a path up to which eliminating limbs first is faster


class Subtrees(NamedTuple):
    """All frames with dofs, each with its subtree, in the order of the dofs: parents first, branch after branch."""

    frame: np.ndarray  # (n,) in the tree
    first_dof: np.ndarray  # (n,)
    n_dofs: np.ndarray  # (n,) of the frame and of all that it carries: they follow one another
    n_ancestors: np.ndarray  # (n,) dofs that carry it
    carrier: np.ndarray  # (n,) the frame with dofs that carries it, -1 where the root does
    largest: np.ndarray  # (n,) dofs of the largest limb of a branch, where the branch begins; zero: it has none


ORDER = tuple_type(Order, INTEGER_VECTOR, INTEGER_MATRIX, INTEGER_CUBE, INTEGER_MATRIX, INTEGER_VECTOR)


@internal
def _subtrees(tree):
    n_dofs, n = tree.column.shape[0], 0
    frame_of, number = np.zeros(n_dofs, np.int64), np.zeros(n_dofs, np.int64)  # of each dof, in the tree and here
    for f in range(1, tree.frame_parent.shape[0]):
        n += tree.end_dof[f] > tree.first_dof[f]
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            frame_of[d] = f
    trees = Subtrees(
        np.zeros(n, np.int64),
        np.zeros(n, np.int64),
        np.zeros(n, np.int64),
        np.zeros(n, np.int64),
        np.zeros(n, np.int64),
        np.zeros(n, np.int64),
    )
    i, d = 0, 0
    while d < n_dofs:
        f = frame_of[d]
        trees.frame[i], trees.first_dof[i], trees.n_dofs[i], trees.carrier[i] = f, d, tree.end_dof[f] - d, -1
        for r in range(tree.first_dof_range[f], tree.first_dof_range[f + 1]):
            end = min(tree.dof_ranges[r, 1], d)  # before it are the dofs of ancestors, the nearest one's last
            if end > tree.dof_ranges[r, 0]:
                trees.n_ancestors[i] += end - tree.dof_ranges[r, 0]
                trees.carrier[i] = number[end - 1]
        while d < tree.end_dof[f]:
            number[d] = i
            d += 1
        i += 1
    for i in range(n - 1, -1, -1):
        if trees.carrier[i] >= 0:
            trees.n_dofs[trees.carrier[i]] += trees.n_dofs[i]
    return trees


@internal
def _end(trees, branch):
    """The end of the frames of a branch."""
    i = branch + 1
    while i < trees.carrier.shape[0] and trees.carrier[i] >= 0:
        i += 1
    return i


@internal
def _is_limb(trees, i, branch, largest):
    """Whether a frame is the first of a limb: of the largest subtrees with no more than so many dofs."""
    return i > branch and trees.n_dofs[i] <= largest < trees.n_dofs[trees.carrier[i]]


@internal
def _pad(n_dofs):
    return -(-n_dofs // LANES) * LANES


@internal
def _band(n_dofs, n_free, call):
    """The multiplications of a band: Cholesky, the block right of it and the product of that; and its calls."""
    rows = _pad(n_dofs)
    return n_free * (14 * rows**3 + 12 * call * rows)


@internal
def _with_limbs(trees, branch, largest, n_free, call):
    """The multiplications for the limbs of a branch: bands, borders, products and the trunk."""
    total, n_trunk = 0, trees.n_dofs[branch]
    for i in range(branch, _end(trees, branch)):
        if _is_limb(trees, i, branch, largest):
            rows, columns = _pad(trees.n_dofs[i]), trees.n_ancestors[i] * n_free
            total += _band(trees.n_dofs[i], n_free, call) + n_free * rows * columns * (9 * rows + 2 * columns)
            n_trunk -= trees.n_dofs[i]
    return total + _band(n_trunk * n_free, 1, call)


@internal
def _choose_limbs(trees, branch, worth, call, n_free):
    """Choose the limbs of a branch: none where a band takes fewer multiplications."""
    least, largest, size = worth * _band(trees.n_dofs[branch], n_free, call), 0, 0
    while True:  # for each number of dofs that a subtree has, in order
        last, size = size, trees.n_dofs[branch]
        for i in range(branch + 1, _end(trees, branch)):
            if last < trees.n_dofs[i] < size:
                size = trees.n_dofs[i]
        if size == trees.n_dofs[branch]:  # the branch itself does not count
            break
        cost = _with_limbs(trees, branch, size, n_free, call)
        if cost < least:
            largest, least = size, 1.0 * cost
    trees.largest[branch] = largest


@internal
def _is_worth_it(trees, worth, call, n_free):
    """Whether limbs are worth it for so many free poses, in all branches that have any."""
    cost, bands = 0, 0
    for i in range(trees.carrier.shape[0]):
        if trees.largest[i] > 0:
            cost += _with_limbs(trees, i, trees.largest[i], n_free, call)
            bands += _band(trees.n_dofs[i], n_free, call)
    return cost < worth * bands


@internal
def _add_supernode(tree, trees, i, trunk, k, kind, order):
    """Write supernode k: a limb, or what is left of a branch, whose dofs have no index yet."""
    supernode, indices = order.supernodes[k], order.indices[kind]
    first, n, n_ancestors = trees.first_dof[i], 0, 0
    for d in range(first, first + trees.n_dofs[i]):
        if indices[d, 0] < 0:
            indices[d, 0], indices[d, 1] = k, n
            n += 1
    if trunk != k:
        f = trees.frame[i]
        for r in range(tree.first_dof_range[f], tree.first_dof_range[f + 1]):
            for d in range(tree.dof_ranges[r, 0], min(tree.dof_ranges[r, 1], first)):
                order.ancestors[k, n_ancestors] = d
                n_ancestors += 1
    supernode[0], supernode[1], supernode[2], supernode[3] = first, first + trees.n_dofs[i], n, n_ancestors
    supernode[4], supernode[5] = trunk, 1 if trunk == k and trees.largest[i] > 0 and kind == 1 else 0


@by_address(lambda: ORDER(TREE, REAL, INTEGER, INTEGER, INTEGER))
def order_by(tree, worth, call, n_free, n_free_refined):
    """Divide the dofs of a skeleton into supernodes, by the costs of limbs and paths of so many free poses."""
    trees = _subtrees(tree)
    n_supernodes, widest, n = 0, 0, trees.carrier.shape[0]
    for branch in range(n):
        if trees.carrier[branch] < 0:
            _choose_limbs(trees, branch, worth, call, n_free)
            n_supernodes += 2
            for i in range(branch, _end(trees, branch)):
                if _is_limb(trees, i, branch, trees.largest[branch]):
                    n_supernodes += 1
                    widest = max(widest, trees.n_ancestors[i])
    order = Order(
        np.zeros(3, np.int64),
        np.zeros((n_supernodes, 6), np.int64),
        np.zeros((2, tree.column.shape[0], 2), np.int64),
        np.zeros((n_supernodes, widest), np.int64),
        np.zeros(1, np.int64),
    )
    k = 0
    for kind in range(2):
        for d in range(tree.column.shape[0]):
            order.indices[kind, d, 0] = -1
        for branch in range(n):
            if trees.carrier[branch] < 0:
                end, trunk = _end(trees, branch), k
                for i in range(branch, end):
                    trunk += kind == 1 and _is_limb(trees, i, branch, trees.largest[branch])
                for i in range(branch, end):
                    if kind == 1 and _is_limb(trees, i, branch, trees.largest[branch]):
                        _add_supernode(tree, trees, i, trunk, k, kind, order)
                        k += 1
                _add_supernode(tree, trees, branch, trunk, k, kind, order)
                k += 1
        order.first_supernode[kind + 1] = k
    if _is_worth_it(trees, worth, call, n_free):
        order.most_poses[0] = n_free
    if _is_worth_it(trees, worth, call, n_free_refined):
        order.most_poses[0] = n_free_refined
    return order
