"""Stages of a command, on stderr: a line that moves in a terminal, a line for each long stage elsewhere."""

import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TextIO

from skpose._cli.colours import CYAN, DIM, is_live, paint
from skpose._parallel.progress import clock, plain_lines, progress, report_stages_to, report_to

TICK = 0.1  # s between two pictures of the line
LASTING = 2.0  # s; a stage that took as long leaves a line
BAR = 24  # characters


@contextmanager
def show_stages() -> Iterator[None]:
    """Show on stderr what the work in this context does, also what the library reports as progress."""
    if not is_live(sys.stderr):
        with report_to(_Plain().report):
            yield
        return
    with _Line(sys.stderr) as line, report_to(line.report), report_stages_to(lambda what: line.report(what, 0)):
        yield


def steps(what: str, items: Sequence[Any]) -> Iterator[Any]:
    """Yield items, and show how many of them are done."""
    with progress(what, len(items), 0) as advance:
        for item in items:
            yield item
            advance()


class _Plain:
    """Plain lines of the outermost stages."""

    depth = 0

    @contextmanager
    def report(self, what: str, n_steps: int) -> Iterator[Callable[[], None]]:
        self.depth += 1
        try:
            if self.depth > 1:
                yield lambda: None
            else:
                with plain_lines(what, n_steps, LASTING) as advance:
                    yield advance
        finally:
            self.depth -= 1


class _Stage:
    """A stage that has started; `n_steps` is zero where they are not known."""

    def __init__(self, what: str, n_steps: int):
        self.what, self.n_steps, self.n_done, self.start = what, n_steps, 0, time.monotonic()

    def advance(self) -> None:
        self.n_done += 1

    def text(self, what: str, columns: int, stream: TextIO) -> str:
        """Return the stage, under a name, in one line."""
        elapsed = time.monotonic() - self.start
        if self.n_steps == 0:
            dots = "." * (1 + int(2 * elapsed) % 3)
            return paint(f"{what} {clock(elapsed)} {dots}"[: columns - 1], CYAN, stream)
        share = min(self.n_done / self.n_steps, 1.0)
        filled = int(share * BAR)
        left = f", {clock(elapsed * (1.0 - share) / share)} to go" if 0.0 < share < 1.0 and elapsed > 1.0 else ""
        after = f" {share:4.0%}  {clock(elapsed)}{left}"
        what = what[: max(columns - 1 - BAR - 1 - len(after), 8)]
        full, empty = _bars(stream)
        return f"{what} {paint(full * filled, CYAN, stream)}{paint(empty * (BAR - filled), DIM, stream)}{after}"


class _Line:
    """The last line of a terminal, which shows the stage that began last; other output goes above it."""

    def __init__(self, stream: TextIO):
        self._stream, self._lock = stream, threading.RLock()
        self._stages: list[_Stage] = []
        self._shown, self._ended = False, threading.Event()
        self._at_start = True  # whether the last output ended its line

    def __enter__(self) -> "_Line":
        self._before = sys.stdout, sys.stderr
        # What is printed while the line is shown would be appended to it.
        sys.stdout, sys.stderr = (_Above(one, self) if is_live(one) else one for one in self._before)
        self._thread = threading.Thread(target=self._tick, daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()
        self.clear()
        sys.stdout, sys.stderr = self._before

    @contextmanager
    def report(self, what: str, n_steps: int) -> Iterator[Callable[[], None]]:
        """Show a stage; yields the function to call after each of its steps."""
        one = _Stage(what, n_steps)
        with self._lock:
            self._stages.append(one)
            self._draw()
        try:
            yield one.advance
        except BaseException:
            self._remove(one)
            raise
        self._remove(one)
        elapsed = time.monotonic() - one.start
        if n_steps and not any(other.n_steps for other in self._stages) and elapsed >= LASTING:
            with self.pause():
                self._stream.write(f"{what}: done in {clock(elapsed)}\n")

    def _remove(self, one: _Stage) -> None:
        with self._lock:
            self._stages.remove(one)
            self.clear()

    @contextmanager
    def pause(self) -> Iterator[None]:
        """Clear the line while something is written in its place."""
        with self._lock:
            self.clear()
            yield

    def clear(self) -> None:
        """Remove the line from the terminal."""
        with self._lock:
            if self._shown:
                self._stream.write("\r\x1b[K")
                self._stream.flush()
                self._shown = False

    def wrote(self, text: str) -> None:
        """Note what was written above the line, which waits until the other has ended."""
        if text:
            self._at_start = text.endswith("\n")

    def _tick(self) -> None:
        while not self._ended.wait(TICK):
            self._draw()

    def _draw(self) -> None:
        with self._lock:
            if self._stages and self._at_start:
                columns = shutil.get_terminal_size().columns
                # The first is the command, and says nothing where there are others.
                what = ": ".join(one.what for one in (self._stages[1:] or self._stages)[-2:])
                self._stream.write(f"\r{self._stages[-1].text(what, columns, self._stream)}\x1b[K")
                self._stream.flush()
                self._shown = True


class _Above:
    """A stream of the same terminal: what is written there goes above the line."""

    def __init__(self, stream: TextIO, line: _Line):
        self._stream, self._line = stream, line

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        with self._line.pause():
            n = self._stream.write(text)
            self._stream.flush()
            self._line.wrote(text)
        return n


def _bars(stream: TextIO) -> tuple[str, str]:
    """Return a full and an empty part of a bar, in characters that the terminal has."""
    try:
        "━─".encode(stream.encoding or "ascii")
    except (UnicodeEncodeError, LookupError):
        return "#", "-"
    return "━", "─"
