"""The command ``skpose``: its commands, their warnings and errors."""

import argparse
import os
import sys
import warnings
from collections.abc import Sequence
from contextlib import redirect_stdout
from typing import Any

import skpose
from skpose._cli import angles, check, compare, convert, distances, explore, find, info, reproduce, retarget, view
from skpose._utils.files import check_new

COMMANDS = info, check, view, explore, distances, find, retarget, convert, angles, compare, reproduce
EXIT_STATUS = (
    "Exit status: 0 success, 1 error, 2 wrong options, 3 success with files skipped by --skip-errors, 130 interrupted."
)


def command_line() -> argparse.ArgumentParser:
    """The parser of ``skpose`` and its commands."""
    parser = argparse.ArgumentParser(
        "skpose", usage="skpose COMMAND ...", description=skpose.__doc__.splitlines()[0], epilog=EXIT_STATUS
    )
    parser.add_argument("--version", action="version", version=f"skpose {skpose.__version__}")
    parser.set_defaults(func=lambda args: parser.print_help(), status=0)
    subparsers = parser.add_subparsers(title="commands", metavar="COMMAND ...", prog="skpose")
    for command in COMMANDS:
        command.add_parser(subparsers)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return the exit status."""
    args = command_line().parse_args(arguments)
    try:
        with warnings.catch_warnings(), redirect_stdout(_Printable(sys.stdout)):  # type: ignore[type-var]
            warnings.showwarning = lambda message, *_, **__: _report(f"warning: {message}")
            for path in filter(None, (getattr(args, name, None) for name in ("out", "png"))):
                check_new(path)
            args.func(args)
            sys.stdout.flush()
    except BrokenPipeError:  # the reader of the output, such as `head`, closed it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except (OSError, ValueError, RuntimeError, ImportError, MemoryError) as error:
        _report(str(error))
        return 1
    except KeyboardInterrupt:
        return 130
    return args.status


class _Printable:
    """A text stream on which control characters, which names in files may have, are escaped."""

    def __init__(self, stream: Any):
        self._stream = stream

    def write(self, text: str) -> None:
        printable = (char if char.isprintable() or char in "\n\t" else ascii(char)[1:-1] for char in text)
        self._stream.write("".join(printable))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def _report(message: str) -> None:
    print(f"skpose: {message}", file=_Printable(sys.stderr))
