"""A message while a call compiles, by the logger "skpose": on stderr, unless the user configures logging.

It appears once for each folder of `skpose._compiled` that names its subject, and not in worker processes, which compile
what the process that started them compiles.
"""

import logging
import multiprocessing
import sys
import time
from typing import Any

from numba.core import event

from skpose._compiled.simd.cache import CACHED

PATIENCE = 2.0  # seconds of compilation without a message

logger = logging.getLogger("skpose")


class Announcer(event.Listener):
    """Times what numba compiles; one thread at a time compiles."""

    def __init__(self) -> None:
        self.module = ""  # of the outermost function that is being compiled
        self.depth, self.began, self.spent = 0, 0.0, 0.0
        self.announced: set[str] = set()

    def on_start(self, event: Any) -> None:
        if self.depth == 0:
            function = getattr(event.data["dispatcher"], "py_func", None)
            self.module, self.began = getattr(function, "__module__", None) or "", time.monotonic()
        self.depth += 1
        self.check()

    def on_end(self, event: Any) -> None:
        self.check()
        self.depth -= 1
        if self.depth == 0 and self.module.startswith("skpose."):
            self.spent += time.monotonic() - self.began

    def check(self) -> None:
        if self.spent + time.monotonic() - self.began < PATIENCE:
            return
        subject, duration = getattr(sys.modules.get(self.module.rpartition(".")[0]), "COMPILES", ("", ""))
        if subject and subject not in self.announced and multiprocessing.parent_process() is None:
            self.announced.add(subject)
            self.spent = 0.0
            often = "once" if CACHED else "in every process"
            logger.warning("skpose compiles %s for this machine: %s, %s", subject, often, duration)


event.register("numba:compile", Announcer())
