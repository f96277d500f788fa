"""Medoid shift on a sparse graph of neighbours: compiled."""

import math

import numpy as np

from skpose._compiled.simd.jit import jit


@jit
def shift_in_graph(rows, graph, masses, factor, tie, target, moments):
    """Find the sample to which each row moves: the neighbour j with the least Σ_k w_ik d_jk², w = m_k exp(factor · d²).

    Rows and graph are CSR matrices of squared distances, (indptr, indices, data). The graph is symmetric, with sorted
    rows that hold the diagonal. If it lacks d_jk², d_ij² + d_ik² is taken: its average for j and k in independent
    directions from i. `moments` receives Σ_k w_ik d_ik², the cost of staying. A row without neighbours moves nowhere.
    """
    indptr, indices, squared = graph
    starts, neighbors, distances = rows
    n = indptr.shape[0] - 1
    weight, from_i = np.zeros(n), np.zeros(n)  # w_ik and d_ik² of the current i, zero except for its neighbours
    for i in range(target.shape[0]):
        nearest = math.inf
        for e in range(starts[i], starts[i + 1]):
            nearest = min(nearest, distances[e])
        total, moment = 0.0, 0.0  # Σ w_ik and Σ w_ik d_ik²
        for e in range(starts[i], starts[i + 1]):
            k = neighbors[e]
            weight[k], from_i[k] = masses[k] * math.exp(factor * (distances[e] - nearest)), distances[e]
            total += weight[k]
            moment += weight[k] * from_i[k]
        best = math.inf
        for e in range(starts[i], starts[i + 1]):
            j = neighbors[e]
            cost, seen, seen_moment = 0.0, 0.0, 0.0
            for f in range(indptr[j], indptr[j + 1]):
                k = indices[f]
                cost += weight[k] * squared[f]
                seen += weight[k]
                seen_moment += weight[k] * from_i[k]
            cost += from_i[j] * (total - seen) + (moment - seen_moment)
            if cost < best * (1.0 - tie):
                best, target[i] = cost, j
        moments[i] = moment
        for e in range(starts[i], starts[i + 1]):
            weight[neighbors[e]] = 0.0
