"""Tasks in threads: each is run once, and none starts after a failure."""

import pytest

from skpose._utils.parallel import in_threads


@pytest.mark.parametrize("n_jobs", [1, 2, 5])
def test_every_task_is_run_once(n_jobs):
    done = in_threads((lambda i=i: i * i for i in range(50)), n_jobs)
    assert sorted(done) == [i * i for i in range(50)]
    assert in_threads([], n_jobs) == []


@pytest.mark.parametrize("n_jobs", [1, 2])
@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_no_task_starts_after_a_failure(n_jobs, error):
    started = []

    def task(i):
        started.append(i)
        if i == 3:
            raise error("three")
        return i

    with pytest.raises(error, match="three"):
        in_threads((lambda i=i: task(i) for i in range(10_000)), n_jobs)
    assert len(started) < 10_000
