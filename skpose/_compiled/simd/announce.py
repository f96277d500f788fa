"""A message where calls compile for long, by the logger "skpose": on stderr, unless the user configures logging.

It appears once, and not in worker processes, which compile what the process that started them compiles.
"""

import logging
import multiprocessing
import time
from typing import Any

from numba.core import event

from skpose._compiled.simd.cache import CACHED

PATIENCE = 2.0  # seconds of compilation without a message

logger = logging.getLogger("skpose")


class Announcer(event.Listener):
    """Times what numba compiles of skpose; one thread at a time compiles."""

    def __init__(self) -> None:
        self.depth, self.began, self.spent, self.announced = 0, 0.0, 0.0, False

    def on_start(self, event: Any) -> None:
        if self.depth == 0:
            self.began = time.monotonic()
        self.depth += 1

    def on_end(self, event: Any) -> None:
        self.depth -= 1
        if not (event.data["dispatcher"].py_func.__module__ or "").startswith("skpose."):
            return
        spent = self.spent + time.monotonic() - self.began
        if self.depth == 0:
            self.spent = spent
        if spent > PATIENCE and not self.announced and multiprocessing.parent_process() is None:
            self.announced = True
            often = "once" if CACHED else "in every process"
            logger.warning("skpose compiles for this machine, %s: 5 s to a minute", often)


event.register("numba:compile", Announcer())
