"""Tasks in threads: each one is run once, and none starts after a failure."""

import threading

import pytest

from skpose._parallel.threads import in_threads


@pytest.mark.parametrize("n_jobs", [1, 2, 5])
def test_every_task_is_run_once(n_jobs):
    done = in_threads((lambda i=i: i * i for i in range(50)), n_jobs)
    assert sorted(done) == [i * i for i in range(50)]
    assert in_threads([], n_jobs) == []


@pytest.mark.parametrize("n_jobs", [1, 2])
@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_after_a_failure_no_task_starts(n_jobs, error):
    started = []

    def task(i):
        started.append(i)
        if i == 3:
            raise error("three")
        return i

    with pytest.raises(error, match="three"):
        in_threads((lambda i=i: task(i) for i in range(10_000)), n_jobs)
    assert len(started) < 10_000


def test_tasks_are_made_when_a_thread_is_free():
    made, may_end = [], threading.Event()

    def tasks():
        for i in range(10):
            made.append(i)
            yield may_end.wait

    waiting = threading.Thread(target=in_threads, args=(tasks(), 2))
    waiting.start()
    may_end.wait(0.2)
    assert len(made) <= 2
    may_end.set()
    waiting.join()
    assert len(made) == 10
