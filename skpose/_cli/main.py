"""Run a command of the command line and return its exit status."""

import argparse
import importlib
import re
import shlex
import sys
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skpose._cli import targets  # without commands and inputs, whose imports take a second
from skpose._cli.browser import show_file
from skpose._cli.colours import print_error, print_warning
from skpose._cli.contradictions import find_contradiction
from skpose._cli.messages import Skipped, describe
from skpose._cli.parser import command_line
from skpose._cli.stages import show_stages
from skpose._cli.terminal import Interruption, discard, output_may_close, standard_streams
from skpose._parallel.progress import stage

if TYPE_CHECKING:
    from skpose._cli import new_motions
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
POINTS = "layout", "names", "zeros"  # of the readers of markers and keypoints
PREPARING = "rotations", "method", "with_root"  # options of what is done with the motions
ALIGNING = "alignment", "window", "endpoint", "joints"
PRINTING = "info", "compare", "find", "warm-up"  # commands whose output is all that there is of them
PAGES = "view", "explore"  # commands that write a page
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
    if not (sys.argv[1:] if arguments is None else arguments):
        parser.print_help()
        return 0
    options = parser.parse_args(arguments)
    if complaint := find_contradiction(options):
        parser.error(complaint)
    skipped = Skipped()
    try:
        with warnings.catch_warnings():
            _show_warnings(options)
            try:
                with show_stages():
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
        message = describe(error)
        print_error(_as_options(message, options))
        return 1
    return INCOMPLETE if skipped.messages else 0


def _list_skipped(skipped: Skipped, options: argparse.Namespace) -> None:
    """Print which files were left out, and why."""
    if skipped.messages:
        print(f"skpose: {len(skipped.messages)} of {skipped.n_files} files left out:", file=sys.stderr)
        for message in skipped.messages:
            print(f"skpose:   {_as_options(message, options)}", file=sys.stderr)


def _continuation(options: argparse.Namespace) -> str:
    if targets.continues(options.command, getattr(options, "out", None)) and targets.is_unfinished(options.out):
        return "; run the same command again to continue"
    return ""


def _show_warnings(options: argparse.Namespace) -> None:
    """Print each warning as one line, and the same one of several files once; Python's own names a line of code."""
    shown = set()

    def show(message: Warning | str, *_: object, **__: object) -> None:
        line = _as_options(str(message), options)
        if line not in shown:
            shown.add(line)
            print_warning(line)

    warnings.showwarning = show


def _as_options(message: str, options: argparse.Namespace) -> str:
    """Return the message in one line, with arguments of functions as options: on_nan='drop' as --on-nan drop.

    Only those that the command has: `skpose compare` has no --retarget, and the message's own remedy stays.
    """

    renamed = NAMED | ({"method": "method"} if options.command == "retarget" else {})

    def option(found: re.Match) -> str:
        name = renamed.get(found[1], found[1].replace("_", "-"))
        given = next((text for text in found.groups()[1:] if text is not None), None)
        if given == "False":
            return f"--no-{name}"
        if given in (None, "True"):
            return f"--{name}"
        return f"--{name}{'=' if given.startswith('-') else ' '}{shlex.quote(given)}"  # "-y" would be another option

    message = " ".join(message.split())
    known = (*READING, *POINTS, *PREPARING, *ALIGNING, "zero")
    names = "|".join(name for name in known if hasattr(options, STORED.get(name, name)))
    if not names:
        return message
    call = rf"[\w.]+\([^()]*\b((?:{names})=(?:\"\w+\"|False|True))\)"
    message = re.sub(call, r"\1", message)  # of a call, its last argument
    return re.sub(rf"\b({names})=(?:'([^']*)'|\"([^\"]*)\"|(False|True|[\d.]*\d))?", option, message)


def _run(options: argparse.Namespace, skipped: Skipped) -> None:
    with stage(f"skpose {options.command}"):  # what is shown where nothing finer is
        if options.command in PRINTING or (options.command == "retarget" and options.out is None):
            _print(options, skipped)
            return
        targets.prepare(options)
        with output_may_close():
            _write(options, skipped)
            if options.command in PAGES and options.open:
                show_file(options.out)


def _load() -> None:
    """Import what commands need, which takes some seconds."""
    with stage("loading skpose"):
        importlib.import_module("skpose._cli.commands")


def _print(options: argparse.Namespace, skipped: Skipped) -> None:
    """Run a command whose output is all that there is of it."""
    _load()
    from skpose._cli import commands, contents, finding, inputs

    if options.command == "compare":
        commands.compare_metrics(options.folder, options.scale, options.out, options.jobs, paper=options.paper)
    elif options.command == "find":
        query = inputs.one_file(options.query, "QUERY")
        dataset = inputs.read_motions(
            [query, *options.files],
            options.frame_rate,
            **_reading_arguments(options, skipped),
            one_frame_rate=True,
            required=1,
        )
        part = finding.Query(options.begins, options.ends, options.pose)
        finding.find(
            dataset,
            part,
            k=options.k,
            metric=options.metric,
            n_jobs=options.jobs,
            exclude_query=options.exclude_query,
            one_per_file=options.one_per_file,
        )
    elif options.command == "retarget":
        _retarget(options, skipped)
    elif options.command == "warm-up":
        from skpose._cli.warm_up import warm_up

        warm_up(options.subjects, options.jobs)
    else:
        contents.info(options.files, _reader(options, skipped))


def _write(options: argparse.Namespace, skipped: Skipped) -> None:
    """Run a command that writes files."""
    _load()
    from skpose._cli import commands, contents, inputs

    if options.command == "reproduce":
        commands.reproduce(options.folder, options.scale, options.out, options.seed, options.jobs)
    elif options.command == "view":
        if drawn := bool(options.png or options.gif):
            commands.check_matplotlib("pictures need")
        reader = _reader(options, skipped)
        names, shown = inputs.read_moving(options.files, options.frame_rate, reader, contents.load_any)
        if drawn:
            part = options.begins, options.ends
            commands.draw(shown, names, options.png, options.at, options.gif, part, options.fps, options.layout)
        if options.out is not None:
            commands.view(
                shown, names, options.out, align=options.align, overlay=options.overlay, layout=options.layout
            )
    elif options.command == "angles":
        from skpose._cli.angles import angles

        reader, file = _reader(options, skipped), inputs.one_file(options.file, "FILE")
        angles(file, options.zero, reader, options.out, options.layout)
    elif options.command in ("mean", "between", "retarget", "convert"):
        _write_motion(options, skipped)
    else:
        _write_comparison(options, skipped)


def _write_motion(options: argparse.Namespace, skipped: Skipped) -> None:
    """Run a command that writes a motion."""
    from skpose._cli import inputs, new_motions

    target = new_motions.Target(options.out, options.out_scale, options.open)
    if options.command == "mean":
        dataset = inputs.read_motions(
            options.files, options.frame_rate, **_reading_arguments(options, skipped), one_frame_rate=True
        )
        new_motions.mean(
            dataset,
            target,
            metric=options.metric,
            n_frames=options.n_frames,
            window=options.window,
            cycle=options.cycle,
            endpoint=options.endpoint,
            with_root=options.with_root is not None,
            n_jobs=options.jobs,
        )
    elif options.command == "between":
        reading = _reading_arguments(options, skipped)
        keys = new_motions.Keys(options.frames, options.times, options.seconds)
        keys.check(len(inputs.motion_files(options.files)))
        new_motions.between(
            inputs.read_motions(options.files, None, **reading, frames=True, required=len(options.files)),
            keys,
            target,
            frame_rate=options.frame_rate,
            method=options.interpolation,
            with_root=options.with_root is not None,
            n_jobs=options.jobs,
        )
    elif options.command == "retarget":
        _retarget(options, skipped, target)
    else:
        reader = _reader(options, skipped)
        new_motions.convert(
            inputs.one_file(options.file, "FILE"), reader, target, options.frame_rate, options.rotations
        )


def _retarget(options: argparse.Namespace, skipped: Skipped, target: "new_motions.Target | None" = None) -> None:
    """Run the command `retarget`, whose file is optional."""
    from skpose._cli import inputs, new_motions

    reader = _reader(options, skipped)
    skeleton = new_motions.read_skeleton(inputs.one_file(options.onto, "OTHER"), reader)
    names, motions = inputs.read_separately(options.files, options.frame_rate, reader)
    new_motions.retarget(
        names,
        motions,
        skeleton,
        target,
        method=options.method,
        joints=None if options.joints is None else dict(options.joints),
        factor=options.factor,
        n_jobs=options.jobs,
    )


def _write_comparison(options: argparse.Namespace, skipped: Skipped) -> None:
    """Run a command that writes distances, or a page of them."""
    from skpose._cli import commands, inputs, matrices
    from skpose._cli.labels import labels_of

    if options.command == "neighbors" and (matrix := matrices.find_matrix(options.files)) is not None:
        if given := _find_changed(options, apart_from=("files", "out", "neighbors", "radius")):
            raise ValueError(f"{matrix} holds distances, and --{given} is for files of motions: leave one of them out")
        commands.neighbors_in(matrix, options.out, options.neighbors, options.radius)
        return
    reading = _reading_arguments(options, skipped)
    dataset = inputs.read_motions(
        options.files, options.frame_rate, **reading, one_frame_rate=options.command == "motions"
    )
    if options.command == "explore":
        labels = labels_of([Path(name) for name in dataset.subjects])
        commands.explore(dataset, labels, options.metrics, options.embeddings, options.out, options.jobs)
        return
    with commands.backend(options.backend, options.scheduler, options.jobs):
        if options.command == "motions":
            commands.motions(
                dataset, options.metric, options.alignment, options.window, out=options.out, dtype=options.dtype
            )
        elif options.command == "distances":
            commands.distances(dataset, options.metric, options.out, options.dtype)
        else:
            commands.neighbors(dataset, options.metric, options.out, options.neighbors, options.radius)


def _find_changed(options: argparse.Namespace, apart_from: Sequence[str]) -> str:
    """Return the name of an option that is not as by default, empty if all are."""
    defaults = command_line().parse_args([options.command, "FILE", "--out", "FILE.npz"])
    dests = [name for name, value in vars(defaults).items() if name not in apart_from and value != vars(options)[name]]
    return next(({"method": "retarget", "hands": "no-hands"}.get(name, name.replace("_", "-")) for name in dests), "")


def _reading_arguments(options: argparse.Namespace, skipped: Skipped) -> dict[str, Any]:
    """Return the arguments of how files are read and prepared."""
    return {"reader": _reader(options, skipped), **{name: getattr(options, name) for name in PREPARING}}


def _reader(options: argparse.Namespace, skipped: Skipped) -> "Reader":
    """Return the reader of files; the `frame_rate` of `load_motion` is that of AMC files, as others state theirs."""
    from skpose._cli.reader import Reader

    arguments = {name: getattr(options, STORED.get(name, name)) for name in READING}
    arguments |= {name: getattr(options, name) for name in POINTS if hasattr(options, name)}
    skip = getattr(options, "skip_errors", False)
    return Reader(arguments, skipped if skip else None, "; --skip-errors leaves out such files")
