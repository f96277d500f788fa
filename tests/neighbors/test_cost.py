"""The cost model of a search: what it prefers where the answer is clear."""

import pytest

from skpose.metrics._registry import METRICS
from skpose.neighbors._cost import QUERIES_PER_SAMPLE, CostModel, sample_of

N_QUERIES, N_POSES = 1000, 20_000


@pytest.fixture(params=[metric for metric in METRICS if METRICS[metric]().lower_bound() is not None])
def cost(request):
    return CostModel(METRICS[request.param](), 100, N_POSES)


def test_a_filter_is_worth_it_only_if_it_leaves_little(cost):
    assert cost.filter_is_worth_it(N_QUERIES, 20, 0.01)
    assert cost.filter_is_worth_it(N_QUERIES, 0, 0.2)
    assert not cost.filter_is_worth_it(N_QUERIES, 20, 1.0)
    assert not cost.filter_is_worth_it(N_QUERIES, N_POSES, 0.0)


def test_no_filter_is_tried_for_a_few_poses():
    assert not CostModel(METRICS["spatial"](), 100, 20).filter_is_worth_a_trial(20)
    assert CostModel(METRICS["spatial"](), 100, N_POSES).filter_is_worth_a_trial(N_QUERIES)


def test_a_sample_is_a_small_share_and_never_empty():
    for n in (1, QUERIES_PER_SAMPLE, QUERIES_PER_SAMPLE + 1, 1024):
        assert 1 <= len(sample_of(n)) <= 1 + n / QUERIES_PER_SAMPLE
        assert sample_of(n).max() < n
