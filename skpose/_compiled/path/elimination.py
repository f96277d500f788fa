"""The order in which the dofs of a path are eliminated, and the indices of the factors' numbers.

One branch of the skeleton at a time, as branches move no joint in common. The poses' blocks of a branch are a band, see
`band_cholesky`: its factors cost the cube of the number of dofs. But most dofs of a large skeleton are in limbs, such
as an arm with its fingers: subtrees that couple with one another only through the trunk that carries them. So where
that takes fewer operations (`skpose.kinematics._supernodes`), limbs are eliminated first, at all poses. What is
eliminated together is a *supernode*: a limb, a trunk, or a branch without limbs. A limb's own blocks are a band, and
right of it is its border, the numbers that couple it with its ancestors:

    [B W; Wᵀ T],  B = UᵀU,  W becomes U⁻ᵀW,  T becomes T − WᵀW

The matrix T of the trunk then couples all poses with all others: it is a band of one block. A border has a column for
each ancestor and pose, pose by pose.
"""

from typing import NamedTuple

import numpy as np

from skpose._compiled.path.energy import LANES
from skpose._compiled.pose.signatures import TREE
from skpose._compiled.pose.tree import Tree
from skpose._compiled.simd.jit import by_address, internal
from skpose._compiled.simd.lanes import empty_aligned
from skpose._compiled.simd.signatures import INTEGER, INTEGER_MATRIX, MATRIX, tuple_type


class Factors(NamedTuple):
    """The factors of a path's normal equations."""

    n_free: int  # poses
    tree: Tree
    kind: int  # 1 where limbs are eliminated first, else 0
    starts: (
        np.ndarray
    )  # (n_supernodes + 1, 2) registers where a supernode's band and solution begin; last what is behind them
    cells: np.ndarray  # (n_registers, LANES) bands and solutions, then a matrix as wide as the widest border


class Supernode(NamedTuple):
    """A limb, a trunk, or a branch without limbs; rows and columns of its band."""

    first_dof: int
    end_dof: int  # the dofs of a trunk lie between, with its limbs' dofs
    n_ancestors: int  # dofs of the trunk that carry a limb; else zero
    trunk: int  # the supernode that carries a limb
    n_blocks: int  # one for all poses, or one for each
    n: int  # registers in a row of a block
    stride: int  # rows from one pose to the next
    edge: int  # registers in a row left of the border
    width: int  # registers in a row
    band: int  # first register
    solution: int  # first register; as many numbers as there are rows, then of the border's columns


FACTORS = tuple_type(Factors, INTEGER, TREE, INTEGER, INTEGER_MATRIX, MATRIX)
SUPERNODE = tuple_type(Supernode, *[INTEGER] * len(Supernode._fields))


@internal
def n_registers(n_numbers):
    """How many registers hold so many numbers."""
    return -(-n_numbers // LANES)


@by_address(lambda: SUPERNODE(FACTORS, INTEGER))
def supernode_at(factors, k):
    """A supernode by its number."""
    row, n_free = factors.tree.supernodes[k], factors.n_free
    first, end, n_dofs, n_ancestors, trunk, is_dense = row[0], row[1], row[2], row[3], row[4], row[5]
    n_blocks, n = (1, n_registers(n_free * n_dofs)) if is_dense else (n_free, n_registers(n_dofs))
    stride = n_dofs if is_dense else n * LANES
    edge = n if n_blocks == 1 else 2 * n  # nothing is right of a single block
    width = edge + n_registers(n_free * n_ancestors)
    starts = factors.starts[k]
    return Supernode(first, end, n_ancestors, trunk, n_blocks, n, stride, edge, width, starts[0], starts[1])


@by_address(lambda: FACTORS(TREE, INTEGER))
def factors_for(tree, n_nodes):
    """Factors for a path of so many poses, not yet filled."""
    n_supernodes, kind = tree.supernodes.shape[0], 1 if n_nodes - 2 <= tree.most_poses[0] else 0
    starts, end, n_sums = np.zeros((n_supernodes + 1, 2), np.int64), 0, 0
    factors = Factors(n_nodes - 2, tree, kind, starts, empty_aligned(0, LANES, np.float64))
    for k in range(tree.first_supernode[kind], tree.first_supernode[kind + 1]):
        supernode = supernode_at(factors, k)
        border = supernode.width - supernode.edge
        starts[k, 0], starts[k, 1] = end, end + supernode.n_blocks * supernode.n * LANES * supernode.width
        end = starts[k, 1] + supernode.n_blocks * supernode.n + border
        n_sums = max(n_sums, border * LANES * border)
    starts[n_supernodes, 0] = end
    return Factors(n_nodes - 2, tree, kind, starts, empty_aligned(end + n_sums, LANES, np.float64))
