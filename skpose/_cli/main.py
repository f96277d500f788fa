"""Run a command of the command line and return its exit status."""

import argparse
import re
import shlex
import sys
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skpose._cli import targets  # without commands and inputs, whose imports take a second
from skpose._cli.messages import Skipped
from skpose._cli.parser import command_line
from skpose._cli.terminal import Interruption, discard, output_may_close, standard_streams

if TYPE_CHECKING:
    from skpose._cli.reader import Reader

INCOMPLETE = 3  # files have been left out, as --skip-errors asks
INTERRUPTED = 130  # a shell's status after Ctrl-C
# Options of `load_motion`.
READING = [
    "asf",
    "frame_rate",
    "file_frame_rate",  # of every file, where the other is of AMC files
    "scale",
    "on_nan",
    "trust",
    "stretch",
    "missing",
    "root",
    "root_offset",
    "up",
    "model",
    "hands",
]
PREPARING = "rotations", "method", "with_root"  # options of what is done with the motions
ALIGNING = "alignment", "window"
NAMED = {"method": "retarget", "frame_rate": "file-frame-rate"}  # options that have another name than the argument
STORED = {"frame_rate": "amc_frame_rate"}  # under another name than the argument


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return the exit status."""
    with standard_streams(), Interruption() as interruption:
        try:
            return _status(arguments, interruption)
        except BaseException:
            if not interruption.happened:
                raise
            return INTERRUPTED  # before the options were read


def _status(arguments: Sequence[str] | None, interruption: Interruption) -> int:
    parser = command_line()
    options = parser.parse_args(arguments)
    if getattr(options, "scheduler", None) is not None and options.backend not in ("dask", "ray"):
        parser.error(f"--scheduler is for --backend dask or ray, not {options.backend}")
    if getattr(options, "window", None) is not None and options.alignment != "dtw":
        parser.error(f"--window is the band of --alignment dtw, not {options.alignment}")
    if getattr(options, "ends", None) is not None and options.ends <= (options.begins or 0.0):
        parser.error(f"--to {options.ends:g} must be after --from {options.begins or 0:g}")
    skipped = Skipped()
    try:
        with warnings.catch_warnings():
            _show_warnings(options)
            try:
                _run(options, skipped)
                sys.stdout.flush()
            finally:
                _list_skipped(skipped, options)
    except BrokenPipeError:  # the reader of the output, such as `head`, has closed it
        discard(sys.stdout)
        return 1
    except BaseException as error:
        if interruption.happened or isinstance(error, KeyboardInterrupt):
            print(f"skpose: interrupted{_continuation(options)}", file=sys.stderr)
            return INTERRUPTED
        if not isinstance(error, (OSError, ValueError, RuntimeError, MemoryError)):
            raise
        message = str(error) or ("not enough memory" if isinstance(error, MemoryError) else type(error).__name__)
        print(f"skpose: {_as_options(message, options)}", file=sys.stderr)
        return 1
    return INCOMPLETE if skipped.messages else 0


def _list_skipped(skipped: Skipped, options: argparse.Namespace) -> None:
    """Print which files were left out, and why."""
    if skipped.messages:
        print(f"skpose: {len(skipped.messages)} of {skipped.n_files} files left out:", file=sys.stderr)
        for message in skipped.messages:
            print(f"skpose:   {_as_options(message, options)}", file=sys.stderr)


def _continuation(options: argparse.Namespace) -> str:
    if options.command in targets.MATRICES and targets.is_unfinished(options.out):
        return "; run the same command again to continue"
    return ""


def _show_warnings(options: argparse.Namespace) -> None:
    """Print each warning as one line, and the same one of several files once; Python's own names a line of code."""
    shown = set()

    def show(message: Warning | str, *_: object, **__: object) -> None:
        line = _as_options(str(message), options)
        if line not in shown:
            shown.add(line)
            print(f"skpose: warning: {line}", file=sys.stderr)

    warnings.showwarning = show


def _as_options(message: str, options: argparse.Namespace) -> str:
    """Return the message in one line, with arguments of functions as options: on_nan='drop' as --on-nan drop.

    Only those that the command has: `skpose compare` has no --retarget, and the message's own remedy stays.
    """

    def option(found: re.Match) -> str:
        name = NAMED.get(found[1], found[1].replace("_", "-"))
        given = next((text for text in found.groups()[1:] if text is not None), None)
        if given == "False":
            return f"--no-{name}"
        if given is None:
            return f"--{name}"
        return f"--{name}{'=' if given.startswith('-') else ' '}{shlex.quote(given)}"  # "-y" would be another option

    message = " ".join(message.split())
    names = "|".join(name for name in (*READING, *PREPARING, *ALIGNING) if hasattr(options, STORED.get(name, name)))
    if not names:
        return message
    call = rf"[\w.]+\([^()]*\b((?:{names})=(?:\"\w+\"|False))\)"
    message = re.sub(call, r"\1", message)  # of a call, its last argument
    return re.sub(rf"\b({names})=(?:'([^']*)'|\"([^\"]*)\"|(False|[\d.]*\d))?", option, message)


def _run(options: argparse.Namespace, skipped: Skipped) -> None:
    if options.command in ("info", "compare", "find"):
        _print(options, skipped)
        return
    targets.check(options.command, options.out)
    with output_may_close():
        _write(options, skipped)


def _print(options: argparse.Namespace, skipped: Skipped) -> None:
    """Run a command whose output is all that there is of it."""
    from skpose._cli import commands, inputs

    if options.command == "compare":
        commands.compare_metrics(options.folder, options.scale, options.jobs)
    elif options.command == "find":
        query = inputs.query_file(options.query)
        dataset = inputs.read_motions(
            [query, *options.files],
            options.frame_rate,
            **_reading_arguments(options, skipped),
            one_frame_rate=True,
            required=1,
        )
        commands.find(dataset, options.begins, options.ends, options.k, options.metric, options.jobs)
    else:
        commands.info(options.files, _reader(options, skipped))


def _write(options: argparse.Namespace, skipped: Skipped) -> None:
    """Run a command that writes files."""
    from skpose._cli import commands, inputs
    from skpose._cli.labels import labels_of

    if options.command == "reproduce":
        commands.reproduce(options.folder, options.scale, options.out, options.seed, options.jobs)
        return
    if options.command == "view":
        names, shown = inputs.read_separately(options.files, options.frame_rate, _reader(options, skipped))
        commands.view(shown, names, options.out, align=options.align, overlay=options.overlay)
        return
    if options.command == "explore":
        dataset = inputs.read_motions(options.files, options.frame_rate, **_reading_arguments(options, skipped))
        labels = labels_of([Path(name) for name in dataset.subjects])
        commands.explore(dataset, labels, options.metrics, options.out, options.jobs)
        return
    if options.command == "motions":
        dataset = inputs.read_motions(
            options.files, options.frame_rate, **_reading_arguments(options, skipped), one_frame_rate=True
        )
        with commands.backend(options.backend, options.scheduler, options.jobs):
            commands.motions(
                dataset, options.metric, options.alignment, options.window, out=options.out, dtype=options.dtype
            )
        return
    X, skeleton = inputs.read_poses(options.files, options.frame_rate, **_reading_arguments(options, skipped))
    with commands.backend(options.backend, options.scheduler, options.jobs):
        if options.command == "distances":
            commands.distances(X, skeleton, options.metric, options.out, options.dtype)
        else:
            commands.neighbors(X, skeleton, options.metric, options.out, options.neighbors, options.radius)


def _reading_arguments(options: argparse.Namespace, skipped: Skipped) -> dict[str, Any]:
    """Return the arguments of how files are read and prepared."""
    return {"reader": _reader(options, skipped), **{name: getattr(options, name) for name in PREPARING}}


def _reader(options: argparse.Namespace, skipped: Skipped) -> "Reader":
    """Return the reader of files; the `frame_rate` of `load_motion` is that of AMC files, as others state theirs."""
    from skpose._cli.reader import Reader

    arguments = {name: getattr(options, STORED.get(name, name)) for name in READING}
    return Reader(arguments, skipped if options.skip_errors else None, "; --skip-errors leaves out such files")
