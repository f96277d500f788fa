"""Medoid shift on a sparse graph of neighbours: compiled."""

import math

import numpy as np

from skpose._compiled.simd.jit import jit


@jit
def shift_in_graph(indptr, indices, squared, factor, tie, target, staying):
    """Find the sample to which each sample moves: the neighbour j with the least Σ_k w_ik d_jk², w = exp(factor · d²).

    The graph is symmetric, with sorted rows that hold the diagonal. If it lacks d_jk², d_ij² + d_ik² is taken: its
    average for j and k in independent directions from i.
    """
    n = target.shape[0]
    weight, from_i = np.zeros(n), np.zeros(n)  # w_ik and d_ik² of the current i, zero except for its neighbours
    for i in range(n):
        total, moment = 0.0, 0.0  # Σ w_ik and Σ w_ik d_ik²
        for e in range(indptr[i], indptr[i + 1]):
            k = indices[e]
            weight[k], from_i[k] = math.exp(factor * squared[e]), squared[e]
            total += weight[k]
            moment += weight[k] * from_i[k]
        best = math.inf
        for e in range(indptr[i], indptr[i + 1]):
            j = indices[e]
            cost, seen, seen_moment = 0.0, 0.0, 0.0
            for f in range(indptr[j], indptr[j + 1]):
                k = indices[f]
                cost += weight[k] * squared[f]
                seen += weight[k]
                seen_moment += weight[k] * from_i[k]
            cost += from_i[j] * (total - seen) + (moment - seen_moment)
            if cost < best * (1.0 - tie):
                best, target[i] = cost, j
            if j == i:
                staying[i] = cost
        for e in range(indptr[i], indptr[i + 1]):
            weight[indices[e]] = 0.0
