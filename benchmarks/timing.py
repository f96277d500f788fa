"""Contestants that take turns."""

import statistics
import time

REPEATS = 5
PAUSE = 0.1  # s, in which the threads of the one before, which wait for more by spinning, go to sleep


def medians(contestants):
    """Median seconds of each function, all of them taking turns."""
    for function in contestants.values():
        function()
    seconds = {name: [] for name in contestants}
    for _ in range(REPEATS):
        for name, function in contestants.items():
            time.sleep(PAUSE)
            start = time.perf_counter()
            function()
            seconds[name].append(time.perf_counter() - start)
    return {name: statistics.median(values) for name, values in seconds.items()}
