"""Progress of long work: a bar if rich is installed and there is a terminal, else plain lines."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from contextvars import ContextVar
from typing import Any

SECONDS = 10.0  # between plain lines

Advance = Callable[[], None]
Reporter = Callable[[str, int], AbstractContextManager[Advance]]
StageReporter = Callable[[str], AbstractContextManager[object]]
_reporter: ContextVar[Reporter | None] = ContextVar("reporter", default=None)
_stage_reporter: ContextVar[StageReporter | None] = ContextVar("stage_reporter", default=None)


def report_to(reporter: Reporter) -> AbstractContextManager[None]:
    """Also report all progress in this context to the reporter, which is called with the name and number of steps."""
    return _set(_reporter, reporter)


def report_stages_to(reporter: StageReporter) -> AbstractContextManager[None]:
    """Report all stages in this context to the reporter, which is called with the name."""
    return _set(_stage_reporter, reporter)


@contextmanager
def _set(variable: ContextVar, value: Any) -> Iterator[None]:
    """Set a variable in this context."""
    token = variable.set(value)
    try:
        yield
    finally:
        variable.reset(token)


def stage(what: str) -> AbstractContextManager[object]:
    """A context for work without steps."""
    reporter = _stage_reporter.get()
    return nullcontext() if reporter is None else reporter(what)


@contextmanager
def progress(what: str, n_steps: int, verbose: int) -> Iterator[Advance]:
    """Show the progress of work if `verbose`; yields the function to call after each step."""
    with ExitStack() as stack:
        reporters = [_reporter.get() if n_steps > 1 else None, _bar if verbose else None]
        reports = [stack.enter_context(reporter(what, n_steps)) for reporter in reporters if reporter is not None]

        def advance() -> None:
            for report in reports:
                report()

        yield advance


def _bar(what: str, n_steps: int) -> AbstractContextManager[Advance]:
    try:
        from rich.console import Console
    except ImportError:
        return plain_lines(what, n_steps)
    console = Console(stderr=True)
    return _rich(what, n_steps, console) if console.is_terminal or console.is_jupyter else plain_lines(what, n_steps)


@contextmanager
def _rich(what: str, n_steps: int, console: Any) -> Iterator[Advance]:
    from rich import progress as rich

    columns = rich.TextColumn("{task.description}"), rich.BarColumn(), rich.TaskProgressColumn()
    with rich.Progress(*columns, rich.TimeElapsedColumn(), rich.TimeRemainingColumn(), console=console) as bar:
        task = bar.add_task(what, total=n_steps)
        yield lambda: bar.advance(task)


@contextmanager
def plain_lines(what: str, n_steps: int, least: float = 0.0) -> Iterator[Advance]:
    """Print a line on stderr every ten seconds, and one at the end if the work took at least `least` seconds."""
    start = printed = time.monotonic()
    n_done = 0

    def advance() -> None:
        nonlocal n_done, printed
        n_done += 1
        now = time.monotonic()
        if now - printed >= SECONDS and n_done < n_steps:
            printed, left = now, (now - start) * (n_steps - n_done) / n_done
            print(f"{what}: {n_done / n_steps:.0%}, {clock(left)} to go", file=sys.stderr, flush=True)

    yield advance
    if (elapsed := time.monotonic() - start) >= least:
        print(f"{what}: done in {clock(elapsed)}", file=sys.stderr, flush=True)


def clock(seconds: float) -> str:
    """A duration as text."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, seconds = divmod(round(seconds), 60)
    return f"{minutes // 60} h {minutes % 60:02} min" if minutes >= 60 else f"{minutes} min {seconds:02} s"
