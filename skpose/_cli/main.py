"""Run a command of the command line and return its exit status."""

import argparse
import os
import re
import shlex
import sys
import warnings
from collections.abc import Sequence

from skpose._cli.parser import command_line

INTERRUPTED = 130  # a shell's status after Ctrl-C
# Options of `load_motion`.
READING = "asf", "frame_rate", "scale", "on_nan", "trust", "stretch", "missing", "root", "model", "hands"
PREPARING = "rotations", "rest", "with_root", "up"  # options of what is done with the motions


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return the exit status."""
    parser = command_line()
    options = parser.parse_args(arguments)
    if getattr(options, "scheduler", None) is not None and options.backend not in ("dask", "ray"):
        parser.error(f"--scheduler is for --backend dask or ray, not {options.backend}")
    if getattr(options, "up", None) is not None and options.with_root is None:
        parser.error("--up is for --with-root tilt or whole")
    try:
        with warnings.catch_warnings():
            _show_warnings()
            _run(options)
    except KeyboardInterrupt:
        remedy = "; run the same command again to continue" if options.command == "distances" else ""
        print(f"skpose: interrupted{remedy}", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # the reader of the output, such as `head`, has closed it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except (OSError, ValueError, RuntimeError, MemoryError) as error:
        message = str(error) or ("not enough memory" if isinstance(error, MemoryError) else type(error).__name__)
        print(f"skpose: {_as_options(message)}", file=sys.stderr)
        return 1
    return 0


def _show_warnings() -> None:
    """Print each warning as one line, and the same one of several files once; Python's own names a line of code."""
    shown = set()

    def show(message: Warning | str, *_: object, **__: object) -> None:
        line = _as_options(str(message))
        if line not in shown:
            shown.add(line)
            print(f"skpose: warning: {line}", file=sys.stderr)

    warnings.showwarning = show


def _as_options(message: str) -> str:
    """Return the message in one line, with arguments of functions as options: on_nan='drop' as --on-nan drop."""

    def option(found: re.Match) -> str:
        name, given = found[1].replace("_", "-"), next((text for text in found.groups()[1:] if text is not None), None)
        if given == "False":
            return f"--no-{name}"
        return f"--{name}" + (f" {shlex.quote(given)}" if given is not None else "")

    message = " ".join(message.split())
    names = "|".join((*READING, *PREPARING))
    message = re.sub(r"[\w.]+\([^()]*\b(\w+=(?:\"\w+\"|False))\)", r"\1", message)  # of a call, its last argument
    return re.sub(rf"\b({names})=(?:'([^']*)'|\"([^\"]*)\"|(False|[\d.]*\d))?", option, message)


def _run(options: argparse.Namespace) -> None:
    from skpose._cli import commands  # imports much that --help does not need

    if options.command == "compare":
        commands.compare_metrics(options.folder, options.jobs)
        return
    if options.command == "reproduce":
        commands.reproduce(options.folder, options.out, options.seed, options.jobs)
        return
    reading = {name: getattr(options, name) for name in READING}
    if options.command == "info":
        commands.info(options.files, reading)
        return
    preparing = {name: getattr(options, name) for name in PREPARING}
    X, skeleton = commands.read_poses(options.files, options.rate, reading, **preparing)
    with commands.backend(options.backend, options.scheduler, options.jobs):
        if options.command == "distances":
            commands.distances(X, skeleton, options.metric, options.out, options.dtype)
        else:
            commands.neighbors(X, skeleton, options.metric, options.out, options.neighbors, options.radius)
