"""Threads that all have a share of the work, however quick one of them is."""

import threading

from skpose._utils.parallel import in_threads


class Competition:
    """`in_threads`, in which the first tasks wait until each thread has one."""

    def __init__(self):
        self.n_threads = []

    def __call__(self, tasks, n_jobs):
        if n_jobs == 1:  # such as a copy of a small triangle
            return in_threads(tasks, n_jobs)
        tasks, barrier, threads = list(tasks), threading.Barrier(n_jobs, timeout=60), set()
        assert len(tasks) > n_jobs

        def waiting(task):
            barrier.wait()
            threads.add(threading.get_ident())
            return task()

        first = [lambda task=task: waiting(task) for task in tasks[:n_jobs]]
        results = in_threads(first + tasks[n_jobs:], n_jobs)
        self.n_threads.append(len(threads))
        return results
