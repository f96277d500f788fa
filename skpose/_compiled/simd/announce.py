"""A message while a call compiles, by the logger "skpose": on stderr, unless the user configures logging.

It comes once for each room of `skpose._compiled` that names a subject. Worker processes emit none: they compile what
the process that started them compiles, or would.
"""

import logging
import multiprocessing
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from skpose._compiled.simd.cache import CACHED

PATIENCE = 2.0  # seconds of compilation without a message
PAUSE = 0.5  # seconds between two functions that are compiled, at most, if one call compiles both

logger = logging.getLogger("skpose")


class Waiting:
    """Seconds of compilation during one call. One thread at a time compiles, so there is one of these."""

    def __init__(self) -> None:
        self.module = ""  # of the function that is compiled, with those that it calls
        self.depth, self.began, self.ended = 0, 0.0, -PAUSE
        self.announced: set[str] = set()

    @contextmanager
    def for_function(self, module: str) -> Iterator[None]:
        """Note that a function of this module is compiled."""
        if self.depth == 0:
            self.module, now = module, time.monotonic()
            if now - self.ended > PAUSE:
                self.began = now
        self.depth += 1
        try:
            yield
        finally:
            self.depth -= 1
            self.ended = time.monotonic()

    def check(self) -> None:
        """Emit the message if compilation takes longer than the patience."""
        if time.monotonic() - self.began < PATIENCE:
            return
        room = sys.modules.get(self.module.rpartition(".")[0])
        subject, duration = getattr(room, "COMPILES", ("", ""))
        if subject and subject not in self.announced and multiprocessing.parent_process() is None:
            self.announced.add(subject)
            often = "once" if CACHED else "in every process"
            logger.warning("skpose compiles %s for this machine: %s, %s", subject, often, duration)


waiting = Waiting()
