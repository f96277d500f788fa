"""Progress of long work, as lines on stderr."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta

SECONDS = 10.0  # between lines

Advance = Callable[[], None]


@contextmanager
def progress(what: str, n_steps: int, verbose: int) -> Iterator[Advance]:
    """Print a line every ten seconds and one at the end if `verbose`; the context is called after each step."""
    start = printed = time.monotonic()
    n_done = 0

    def advance() -> None:
        nonlocal n_done, printed
        n_done += 1
        now = time.monotonic()
        if verbose and now - printed >= SECONDS and n_done < n_steps:
            printed, left = now, (now - start) * (n_steps - n_done) / n_done
            print(
                f"{what}: {n_done / n_steps:.0%}, {timedelta(seconds=round(left))} to go", file=sys.stderr, flush=True
            )

    yield advance
    if verbose:
        print(f"{what}: done in {time.monotonic() - start:.1f} s", file=sys.stderr, flush=True)
