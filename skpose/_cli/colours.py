"""Colours of help, messages and results in a terminal."""

import os
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

BOLD, RED, YELLOW, CYAN, DIM = "1", "1;31", "33", "36", "2"
HEADING = re.compile(r"(?m)^(\S[^\n:]*):$")
USAGE = re.compile(r"^usage:")
OPTION = re.compile(r"(?<![\w-])--?[a-z][\w-]*")
COMMAND = re.compile(r"(?m)^  [a-z][\w-]*(?=  )")


def has_colours(stream: Any) -> bool:
    """Return whether a stream shows colours: a terminal does, unless it is dumb or NO_COLOR is set.

    FORCE_COLOR asks for them elsewhere too. An empty variable is as none.
    """
    if os.environ.get("NO_COLOR"):
        return False
    return bool(os.environ.get("FORCE_COLOR")) or is_live(stream)


def is_live(stream: Any) -> bool:
    """Return whether a stream is a terminal that understands escape sequences."""
    if os.environ.get("TERM") == "dumb" or not (hasattr(stream, "isatty") and stream.isatty()):
        return False
    # Of Windows' consoles the newer ones, which say so.
    return os.name != "nt" or any(name in os.environ for name in ("WT_SESSION", "ANSICON", "TERM", "TERM_PROGRAM"))


def paint(text: str, colour: str, stream: Any) -> str:
    """Return a text in a colour where the stream shows colours."""
    return f"\x1b[{colour}m{text}\x1b[0m" if has_colours(stream) else text


def paint_help(text: str, stream: Any) -> str:
    """Return help with its headings, commands and options in colours."""
    if not has_colours(stream):
        return text
    for pattern, colour in ((OPTION, CYAN), (COMMAND, CYAN), (HEADING, BOLD), (USAGE, BOLD)):
        text = pattern.sub(_painter(colour, stream), text)
    return text


def _painter(colour: str, stream: Any) -> Callable[[re.Match], str]:
    return lambda found: paint(found[0], colour, stream)


def print_written(out: Path, text: str) -> None:
    """Print which file was written, and what is in it."""
    print(f"{paint(str(out), BOLD, sys.stdout)}: {text}")


def print_error(text: str) -> None:
    """Print an error of a command."""
    print(f"{paint('skpose:', RED, sys.stderr)} {text}", file=sys.stderr)


def print_warning(text: str) -> None:
    """Print a warning of a command."""
    print(f"skpose: {paint('warning:', YELLOW, sys.stderr)} {text}", file=sys.stderr)
