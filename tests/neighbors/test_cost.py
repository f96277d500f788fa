"""The cost model of a search: what it prefers where the answer is clear."""

import numpy as np
import pytest

from skpose.metrics._registry import METRICS
from skpose.neighbors._cost import QUERIES_PER_SAMPLE, CostModel, count_in_lanes, sample_of

N_QUERIES, N_POSES = 1000, 20_000


@pytest.fixture(params=[metric for metric in METRICS if METRICS[metric].bound is not None])
def cost(request):
    return CostModel(METRICS[request.param], 100, N_POSES)


def test_a_filter_is_worth_it_only_if_it_leaves_few_candidates(cost):
    n_sampled = len(sample_of(N_QUERIES))
    assert cost.filter_is_worth_it(N_QUERIES, n_sampled, 20 * n_sampled)
    assert not cost.filter_is_worth_it(N_QUERIES, n_sampled, N_POSES * n_sampled)


def test_candidates_are_measured_one_by_one_only_if_they_are_few(cost):
    assert cost.refine_is_worth_it(np.full(N_QUERIES, 8), N_POSES)
    assert not cost.refine_is_worth_it(np.full(N_QUERIES, N_POSES), N_POSES)


def test_no_filter_is_tried_for_a_few_poses():
    assert not CostModel(METRICS["spatial"], 100, 20).filter_is_worth_a_trial(20)
    assert CostModel(METRICS["spatial"], 100, N_POSES).filter_is_worth_a_trial(N_QUERIES)


def test_a_sample_is_a_small_share_and_never_empty():
    for n in (1, QUERIES_PER_SAMPLE, QUERIES_PER_SAMPLE + 1, 1024):
        assert 1 <= len(sample_of(n)) <= 1 + n / QUERIES_PER_SAMPLE
        assert sample_of(n).max() < n


def test_lanes_are_full():
    assert count_in_lanes(np.array([0, 1, 8, 9])) == 0 + 8 + 8 + 16
