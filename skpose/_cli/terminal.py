"""The terminal that a command runs in: Ctrl-C, and output whose reader has closed it."""

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any, Self, TextIO


class Interruption:
    """A context in which Ctrl-C raises KeyboardInterrupt once; a second one ends the process at once.

    Others may turn the exception into one of their own, or print it where nothing can catch it: libraries that are
    being imported, compilers. So it is noted, and nothing but the program itself reports it.
    """

    happened = False

    def __enter__(self) -> Self:
        self._unraisable = sys.unraisablehook
        sys.unraisablehook = self._report
        # Not where Ctrl-C is ignored, as of processes in the background, nor in a thread, which gets no signals.
        self._handles = signal.getsignal(signal.SIGINT) is signal.default_int_handler
        if self._handles:
            try:
                signal.signal(signal.SIGINT, self._interrupt)
            except ValueError:
                self._handles = False
        return self

    def __exit__(self, *_: object) -> None:
        if not self.happened:  # or else only the end of the process is left, which prints nothing either
            sys.unraisablehook = self._unraisable
            if self._handles:
                signal.signal(signal.SIGINT, signal.default_int_handler)

    def _interrupt(self, *_: object) -> None:
        self.happened = True
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        raise KeyboardInterrupt

    def _report(self, unraisable: Any) -> None:
        if not self.happened:
            self._unraisable(unraisable)


@contextmanager
def standard_streams() -> Iterator[None]:
    """Open those of standard input, output and error that are closed, as by `>&-`: empty, or discarded.

    Python has None for them, and the next file that is opened would get their number.
    """
    with ExitStack() as opened:
        for name, mode in {"stdin": "r", "stdout": "w", "stderr": "w"}.items():
            if getattr(sys, name) is None:
                setattr(sys, name, opened.enter_context(open(os.devnull, mode, encoding="utf-8")))
                opened.callback(setattr, sys, name, None)  # before it is closed
        yield


@contextmanager
def output_may_close() -> Iterator[None]:
    """Let work go on after the reader of the output, such as `head`, has closed it: the rest is discarded."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = _Closable(sys.stdout), _Closable(sys.stderr)
    try:
        yield
        sys.stdout.flush()
    finally:
        sys.stdout, sys.stderr = before


def discard(stream: TextIO) -> None:
    """Send all further output of a stream nowhere, and what is still in its buffer."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


class _Closable:
    """A stream that is discarded once nobody reads it any more."""

    def __init__(self, stream: TextIO):
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        self._attempt(lambda: self._stream.write(text))
        return len(text)

    def flush(self) -> None:
        self._attempt(self._stream.flush)

    def _attempt(self, call: Callable[[], object]) -> None:
        try:
            call()
        except BrokenPipeError:
            discard(self._stream)
