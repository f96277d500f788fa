"""The medoid shift algorithm, and the search for a bandwidth."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.sparse import csr_array, issparse
from scipy.sparse.csgraph import connected_components
from sklearn.exceptions import ConvergenceWarning
from sklearn.utils import gen_batches

from skpose._compiled import graph_shift
from skpose._utils.progress import progress
from skpose._utils.warnings import warn

QUANTILE = 0.3  # share of the other samples within the estimated bandwidth
WEIGHTS = 1 << 21  # weights in memory at once
TIE = 1e-12  # relative difference of costs that counts as a tie
HALVINGS = 24  # bisection steps of the bandwidth
GRID = 32  # bandwidths tried if bisection fails


@dataclass(frozen=True, eq=False)
class Modes:
    """Result of the shifts at one bandwidth."""

    bandwidth: float
    modes: np.ndarray  # (n_samples,) index of the mode of each sample
    n_iter: int

    @cached_property
    def count(self):
        return len(np.unique(self.modes))


def squared_distances(distances):
    """Square distances in place; a graph becomes symmetric CSR with zeros on the diagonal.

    A distance in one direction is used for both, as a graph of nearest neighbours need not be symmetric.
    """
    if not issparse(distances):
        return np.square(distances, out=distances)
    n = distances.shape[0]
    rows, columns = np.repeat(np.arange(n), np.diff(distances.indptr)), distances.indices.astype(np.intp)
    squared, diagonal = np.square(distances.data), np.arange(n)
    entries = np.concatenate([diagonal * n + diagonal, rows * n + columns, columns * n + rows])
    entries, first = np.unique(entries, return_index=True)
    values = np.concatenate([np.zeros(n), squared, squared])[first]
    starts = np.searchsorted(entries, np.arange(n + 1) * n)
    return csr_array((values, entries % n, starts), shape=(n, n))


def estimate_bandwidth(distances):
    """Mean distance that contains QUANTILE of the other samples, or of the neighbours in a graph."""
    if issparse(distances):
        rows = [row for row in np.split(distances.data, distances.indptr[1:-1]) if len(row)]
        reach = [np.quantile(row, QUANTILE) for row in rows] if rows else [0.0]
    else:
        k = max(1, int(QUANTILE * (len(distances) - 1))) if len(distances) > 1 else 0
        reach = [np.partition(row, k)[k] for row in distances]
    return float(np.mean(reach)) or 1.0  # all samples are equal, any bandwidth will do


def shift(squared, masses, bandwidth, verbose):
    """Shift the samples, then their modes among themselves, until nothing changes."""
    modes = np.arange(squared.shape[0])
    n_iter = 0
    while True:
        moving = np.unique(modes)
        among = squared if len(moving) == squared.shape[0] else squared[moving][:, moving]
        # Samples have their masses; modes count equally, as equal samples have one mode.
        of_moving = masses if n_iter == 0 else np.ones(len(moving))
        stops = moving[_stops(*targets(among, among, of_moving, bandwidth, verbose))]
        n_iter += 1
        if np.array_equal(stops, moving):
            return Modes(float(bandwidth), modes, n_iter)
        modes = stops[np.searchsorted(moving, modes)]


def targets(rows, squared, masses, bandwidth, verbose):
    """The sample j with the least Σ_k w_ik d_jk², w_ik = m_k exp(−d_ik²/2h²), for each row i, and the cost of staying.

    `rows` are squared distances to the samples, `squared` those among the samples; both dense or both graphs. Weights
    are relative to that of the nearest sample, so they cannot all underflow. Ties go to the first sample, so equal
    samples move together. A row of a graph without neighbours has the target −1.
    """
    m, n = rows.shape
    target, moments = np.full(m, -1), np.empty(m)
    # Finite for any bandwidth, so that a distance of zero has weight one.
    factor = -0.5 / max(float(bandwidth) * float(bandwidth), np.finfo(np.float64).tiny)
    if issparse(squared):
        graphs = [(graph.indptr, graph.indices, graph.data) for graph in (rows, squared)]
        graph_shift.shift_in_graph(*graphs, masses, factor, TIE, target, moments)
        return target, moments
    batches = list(gen_batches(m, max(1, WEIGHTS // n)))
    with progress(f"shift of {m:,} samples", len(batches), verbose and len(batches) > 1) as advance:
        for batch in batches:
            weights = rows[batch] - rows[batch].min(axis=1, keepdims=True)
            with np.errstate(over="ignore"):  # exp(−∞) is zero
                weights *= factor
            np.exp(weights, out=weights)
            weights *= masses
            costs = weights @ squared
            target[batch] = (costs <= costs.min(axis=1, keepdims=True) * (1.0 + TIE)).argmax(axis=1)
            moments[batch] = np.einsum("ij,ij->i", weights, rows[batch])
            advance()
    return target, moments


def _stops(target, staying):
    """The sample at which each sample stops: a fixed point or the best member of a cycle."""
    n = len(target)
    reached = target.copy()
    for _ in range(int(np.ceil(np.log2(n))) + 1 if n > 1 else 1):
        reached = reached[reached]  # doubles the moves; n moves always end in a cycle
    on_cycle = np.unique(reached)
    _, component = connected_components(
        csr_array((np.ones(n), (np.arange(n), target)), shape=(n, n)), directed=True, connection="weak"
    )
    order = on_cycle[np.lexsort((on_cycle, staying[on_cycle]))][::-1]
    mode = np.empty(component.max() + 1, dtype=np.intp)
    mode[component[order]] = order  # the best is written last
    return mode[component]


def find_bandwidth(squared, masses, scale, n_clusters, verbose):
    """Modes with n_clusters clusters, else with the closest smaller number and a warning."""
    tried = {}

    def count(bandwidth):
        if bandwidth not in tried:
            tried[bandwidth] = shift(squared, masses, bandwidth, verbose)
        return tried[bandwidth].count

    def halve(low, high):
        """Bisect from count(low) > n_clusters > count(high); True if n_clusters is found."""
        for _ in range(HALVINGS):
            middle = np.sqrt(low * high)
            if count(middle) == n_clusters:
                return True
            low, high = (middle, high) if count(middle) > n_clusters else (low, middle)
        return False

    low = high = scale
    while count(low) < n_clusters and low > scale * 1e-6:
        low /= 2.0
    while count(high) > n_clusters and high < scale * 1e6:
        high *= 2.0
    found = n_clusters in (count(low), count(high)) or halve(low, high)
    if not found:  # the number of clusters need not be monotonic
        grid = np.geomspace(low, high, GRID)
        found = any(count(bandwidth) == n_clusters for bandwidth in grid) or any(
            count(a) > n_clusters > count(b) and halve(a, b) for a, b in pairwise(grid)
        )
    below = [result for result in tried.values() if result.count <= n_clusters]
    best = max(below, key=lambda r: r.count) if below else min(tried.values(), key=lambda r: r.count)
    if not found:
        warn(
            f"no bandwidth from {min(tried):.3g} to {max(tried):.3g} gives {n_clusters} clusters; bandwidth "
            f"{best.bandwidth:.3g} gives {best.count}",
            ConvergenceWarning,
        )
    return best
