"""The command ``skpose``: its commands, their warnings and errors."""

import argparse
import os
import sys
import warnings
from collections.abc import Sequence

import skpose
from skpose._cli import angles, compare, convert, distances, explore, find, info, reproduce, retarget, view
from skpose._utils.files import check_new

COMMANDS = info, view, explore, distances, find, retarget, convert, angles, compare, reproduce
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
        with warnings.catch_warnings():
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


def _report(message: str) -> None:
    print(f"skpose: {message}", file=sys.stderr)
