"""Estimates of the work of a search: which of several exact methods takes the least time.

The unit of work is that of `Metric.measure_work`: adding one square to a sum in float64, at most 0.2 ns on one core.
The times below are of CMU poses on one AVX-512 core. The choice does not change the result.
"""

from skpose.metrics import Metric

FILTER_WORK = 6  # per pair of a query and a pose. Measured: 1.1 ns
# Work of a search by brute force from which on a filter is tried; it then takes 20 ms or more. Below, a filter saves 15
# ms at most ("spatial") and may take longer than brute force ("angle").
LEAST_WORK_TO_FILTER = 400_000_000
# One query in so many is searched first, to estimate what the filter leaves: that is 1.6 % of the filter's work.
QUERIES_PER_SAMPLE = 64


class CostModel:
    """Estimates for a search of an index under a metric.

    Parameters
    ----------
    metric : Metric
    n_codes : int
        Length of an encoded pose.
    n_poses : int
        Size of the index.
    """

    def __init__(self, metric: Metric, n_codes: int, n_poses: int):
        self.metric, self.n_codes, self.n_poses = metric, n_codes, n_poses

    def work_of_pairs(self, n_pairs: float) -> float:
        """Estimate the work of measuring pairs one at a time, the pose of each encoded anew."""
        return n_pairs * self.n_codes * (self.metric.encode_work + self.metric.measure_work)

    def work_of_brute_force(self, n_queries: int) -> float:
        """Estimate the work of measuring all pairs of queries and poses, each pose encoded once."""
        return self.n_poses * self.n_codes * (self.metric.encode_work + n_queries * self.metric.measure_work)

    def filter_is_worth_a_trial(self, n_queries: int) -> bool:
        """Return whether brute force takes so long that a filter may save something."""
        return self.work_of_brute_force(n_queries) >= LEAST_WORK_TO_FILTER

    def filter_is_worth_it(self, n_queries: int, n_first: int, share: float) -> bool:
        """Return whether filter and refine takes less than brute force.

        n_first poses are measured for each query, and then this share of all pairs.
        """
        brute_force = self.work_of_brute_force(n_queries)
        work = self.work_of_pairs(n_queries * n_first) + FILTER_WORK * n_queries * self.n_poses
        return work + share * brute_force < brute_force
