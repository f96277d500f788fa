"""Progress of long work: a bar if rich is installed and there is a terminal, else plain lines."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from datetime import timedelta
from typing import Any

SECONDS = 10.0  # between plain lines

Advance = Callable[[], None]


def progress(what: str, n_steps: int, verbose: int) -> AbstractContextManager[Advance]:
    """Show the progress of work if `verbose`; the context is the function to call after each step."""
    if not verbose:
        return nullcontext(lambda: None)
    try:
        from rich.console import Console
    except ImportError:
        return _lines(what, n_steps)
    console = Console(stderr=True)
    return _rich(what, n_steps, console) if console.is_terminal or console.is_jupyter else _lines(what, n_steps)


@contextmanager
def _rich(what: str, n_steps: int, console: Any) -> Iterator[Advance]:
    from rich import progress as rich

    columns = rich.TextColumn("{task.description}"), rich.BarColumn(), rich.TaskProgressColumn()
    with rich.Progress(*columns, rich.TimeElapsedColumn(), rich.TimeRemainingColumn(), console=console) as bar:
        task = bar.add_task(what, total=n_steps)
        yield lambda: bar.advance(task)


@contextmanager
def _lines(what: str, n_steps: int) -> Iterator[Advance]:
    """Print a line on stderr every ten seconds, and one at the end."""
    start = printed = time.monotonic()
    n_done = 0

    def advance() -> None:
        nonlocal n_done, printed
        n_done += 1
        now = time.monotonic()
        if now - printed >= SECONDS and n_done < n_steps:
            printed, left = now, (now - start) * (n_steps - n_done) / n_done
            print(
                f"{what}: {n_done / n_steps:.0%}, {timedelta(seconds=round(left))} to go", file=sys.stderr, flush=True
            )

    yield advance
    print(f"{what}: done in {time.monotonic() - start:.1f} s", file=sys.stderr, flush=True)
