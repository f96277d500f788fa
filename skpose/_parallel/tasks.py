"""Sizes of tasks, which should be worth a thread or a worker, and end soon after Ctrl-C.

Work is counted in the unit of `Metric.measure_work`: adding a square to a sum, some 0.2 ns.
"""

WORK_PER_TASK = 1e9  # maximum, some 0.2 s: Ctrl-C takes effect between two tasks
LITTLE_WORK = 1e7  # minimum for a thread
TASKS_PER_JOB = 8  # so that no thread waits long for the last; each costs 0.25 ms
TASKS_PER_WORKER = 4  # so that no worker waits long for the last
