"""The damped normal equations of a path, solved by Cholesky, one supernode at a time, see `elimination`."""

from numba import types

from skpose._compiled.path.band_cholesky import AT_ONCE, factorise_band, substitute_back, substitute_forward, subtract
from skpose._compiled.path.elimination import FACTORS, n_registers, supernode_at
from skpose._compiled.path.energy import LANES, STEPS
from skpose._compiled.path.normal_equations import EQUATIONS, first_row
from skpose._compiled.simd.jit import by_address, internal
from skpose._compiled.simd.lanes import rows
from skpose._compiled.simd.signatures import FLAG, FLAG_MATRIX, INTEGER, MATRIX, REAL


@internal
def _clear(cells, first, n):
    """Set registers to zero, which takes less time than number by number."""
    chunks = rows(cells, 0)
    for at in range(first, first + n):
        chunks[at] = 0.0


@by_address(lambda: types.void(EQUATIONS, REAL, FLAG_MATRIX, INTEGER, FACTORS))
def _fill(equations, damping, fixed, k, factors):
    """Copy the numbers of a supernode's dofs to its band, D damped, and those with its ancestors to the border.

    A fixed dof keeps the damping alone; padded dofs get a row of the identity.
    """
    supernode, pairs, n_free, tree = supernode_at(factors, k), equations.pairs, factors.n_free, factors.tree
    indices, numbers = tree.supernode_of[factors.kind], factors.cells.reshape(factors.cells.size)
    start, stride, width, m = supernode.band * LANES, supernode.stride, supernode.width * LANES, supernode.n * LANES
    _clear(factors.cells, supernode.band, supernode.n_blocks * m * supernode.width)
    for row in range(supernode.n_blocks * m):
        numbers[start + row * width + row % m] = 1.0
    any_fixed = fixed.any()
    for i in range(n_free):  # the step from pose i on ends at pose i + 1, where another begins
        before, after = first_row(equations, i // STEPS, 0), first_row(equations, (i + 1) // STEPS, 0)
        lane, next_lane, has_next = i % STEPS, (i + 1) % STEPS, i < n_free - 1
        top = start + i * stride * width
        block = top + i * stride if supernode.n_blocks == 1 else top
        border = top + supernode.edge * LANES + i * supernode.n_ancestors
        for f in range(1, tree.frame_parent.shape[0]):
            if not supernode.first_dof <= tree.first_dof[f] < supernode.end_dof:
                continue
            for d in range(tree.first_dof[f], tree.end_dof[f]):
                if indices[d, 0] != k:
                    continue
                row, p, a = 4 * equations.first_pair[d], indices[d, 1], 0
                for r in range(tree.first_dof_range[f], tree.first_dof_range[f + 1]):
                    for e in range(tree.dof_ranges[r, 0], min(tree.dof_ranges[r, 1], d + 1)):
                        value = pairs[before + row + 1, lane] + pairs[after + row, next_lane]
                        forward, back = pairs[after + row + 2, next_lane], pairs[after + row + 3, next_lane]
                        row += 4
                        if any_fixed:
                            value = 0.0 if fixed[i + 1, d] or fixed[i + 1, e] else value
                            forward = 0.0 if fixed[i + 1, d] or fixed[i + 2, e] else forward
                            back = 0.0 if fixed[i + 2, d] or fixed[i + 1, e] else back
                        if indices[e, 0] == k:
                            q = indices[e, 1]
                            numbers[block + q * width + p] = value
                            if has_next:
                                numbers[block + p * width + stride + q] = forward
                                numbers[block + q * width + stride + p] = back
                        else:
                            numbers[border + p * width + a] = value
                            if has_next:
                                numbers[border + p * width + supernode.n_ancestors + a] = forward
                                numbers[border + (stride + p) * width + a] = back
                            a += 1
                numbers[block + p * width + p] += damping


@by_address(lambda: FLAG(FACTORS, INTEGER, FLAG))
def _eliminate(factors, k, is_first):
    """Subtract YᵀY of a limb from its trunk, once for all limbs that one joint carries: this may be their first.

    Returns whether the next limb is the first of others.
    """
    supernode, cells, n_free = supernode_at(factors, k), factors.cells, factors.n_free
    trunk, ancestors = supernode_at(factors, supernode.trunk), factors.tree.limb_ancestors[k]
    indices = factors.tree.supernode_of[factors.kind]
    n, width, m = supernode.n_ancestors, supernode.width - supernode.edge, supernode.n * LANES
    sums, numbers = factors.starts[-1, 0], cells.reshape(cells.size)
    if is_first:
        _clear(cells, sums, width * LANES * width)
    for q in range(0, n_free * n, AT_ONCE):  # the lower triangle
        top = max(0, q // n - 1) * m  # above there are zeros
        source = supernode.band + top * supernode.width + supernode.edge
        n_rows, n_chunks, factor = n_free * m - top, n_registers(q + AT_ONCE), source + q // LANES
        subtract(cells, sums + q * width, width, source, supernode.width, n_rows, n_chunks, factor, q % LANES)
    if supernode_at(factors, k + 1).n_ancestors == n and factors.tree.limb_ancestors[k + 1, n - 1] == ancestors[n - 1]:
        return False
    for q in range(n_free * n):
        column = q // n * trunk.stride + indices[ancestors[q % n], 1]
        for p in range(q + 1):
            row = p // n * trunk.stride + indices[ancestors[p % n], 1]
            at = (trunk.band + row * trunk.width) * LANES + column
            numbers[at] += numbers[(sums + q * width) * LANES + p]
    return True


@by_address(lambda: FLAG(EQUATIONS, REAL, FLAG_MATRIX, FACTORS))
def factorise(equations, damping, fixed, factors):
    """Factorise H + λ, without the dofs that are fixed; return whether it is positive definite."""
    first, last, is_first = (
        factors.tree.first_supernode[factors.kind],
        factors.tree.first_supernode[factors.kind + 1],
        True,
    )
    for k in range(first, last):
        _fill(equations, damping, fixed, k, factors)
    for k in range(first, last):
        supernode = supernode_at(factors, k)
        if not factorise_band(factors.cells, supernode):
            return False
        if supernode.n_ancestors > 0:
            is_first = _eliminate(factors, k, is_first)
    return True


@by_address(lambda: types.void(FACTORS, INTEGER, FLAG))
def _carry(factors, k, to_trunk):
    """Add a limb's solution at its border to that of its trunk, or copy the trunk's there."""
    supernode, numbers = supernode_at(factors, k), factors.cells.reshape(factors.cells.size)
    trunk, ancestors = supernode_at(factors, supernode.trunk), factors.tree.limb_ancestors[k]
    indices = factors.tree.supernode_of[factors.kind]
    n, border = supernode.n_ancestors, (supernode.solution + supernode.n_blocks * supernode.n) * LANES
    for q in range(factors.n_free * n):
        at = trunk.solution * LANES + q // n * trunk.stride + indices[ancestors[q % n], 1]
        if to_trunk:
            numbers[at] += numbers[border + q]
        else:
            numbers[border + q] = numbers[at]


@by_address(lambda: types.void(EQUATIONS, FACTORS, MATRIX))
def solve(equations, factors, step):
    """Compute step = −(H + λ)⁻¹ gradient by the factors; of fixed dofs the gradient has to be zero."""
    first, last = factors.tree.first_supernode[factors.kind], factors.tree.first_supernode[factors.kind + 1]
    indices, cells = factors.tree.supernode_of[factors.kind], factors.cells
    numbers = cells.reshape(cells.size)
    for k in range(first, last):
        supernode = supernode_at(factors, k)
        _clear(cells, supernode.solution, supernode.n_blocks * supernode.n + supernode.width - supernode.edge)
    for d in range(indices.shape[0]):
        supernode = supernode_at(factors, indices[d, 0])
        for i in range(factors.n_free):
            numbers[supernode.solution * LANES + i * supernode.stride + indices[d, 1]] = -equations.gradient[i + 1, d]
    for k in range(first, last):
        supernode = supernode_at(factors, k)
        substitute_forward(cells, supernode)
        if supernode.n_ancestors > 0:
            _carry(factors, k, True)
    for k in range(last - 1, first - 1, -1):
        supernode = supernode_at(factors, k)
        if supernode.n_ancestors > 0:
            _carry(factors, k, False)
        substitute_back(cells, supernode)
    for d in range(indices.shape[0]):
        supernode = supernode_at(factors, indices[d, 0])
        for i in range(factors.n_free):
            step[i + 1, d] = numbers[supernode.solution * LANES + i * supernode.stride + indices[d, 1]]
