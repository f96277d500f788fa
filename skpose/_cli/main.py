"""The command line: ``skpose compare``, ``reproduce``, ``distances``, ``neighbors``, ``info``."""

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import skpose
from skpose.metrics._registry import METRICS

STOPPED = 130  # as a shell has it for Ctrl-C
EXIT_STATUS = "Exit status: 0 if done, 1 if something was wrong with the files, 2 with the options, 130 if stopped."


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return the exit status."""
    parser = _parser()
    options = parser.parse_args(arguments)
    if getattr(options, "scheduler", None) is not None and options.backend not in ("dask", "ray"):
        parser.error(f"--scheduler is for --backend dask or ray, not {options.backend}")
    try:
        _run(options)
    except KeyboardInterrupt:
        again = "; the same command goes on where it stopped" if options.command == "distances" else ""
        print(f"skpose: stopped{again}", file=sys.stderr)
        return STOPPED
    except BrokenPipeError:  # whoever read what we print has read enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except (OSError, ValueError, RuntimeError, MemoryError) as error:
        said = str(error) or ("not enough memory" if isinstance(error, MemoryError) else type(error).__name__)
        print(f"skpose: {' '.join(said.split())}", file=sys.stderr)
        return 1
    return 0


def _run(options: argparse.Namespace) -> None:
    from skpose._cli import commands  # which import much that --help does not need

    if options.command == "compare":
        commands.compare_metrics(options.folder, options.jobs)
        return
    if options.command == "reproduce":
        commands.reproduce(options.folder, options.out, options.seed, options.jobs)
        return
    reading = options.asf, options.frame_rate, options.scale
    if options.command == "info":
        commands.info(options.file, *reading)
        return
    X, skeleton = commands.read_poses(options.files, options.rate, *reading)
    with commands.engine(options.backend, options.scheduler, options.jobs):
        if options.command == "distances":
            commands.distances(X, skeleton, options.metric, options.out, options.dtype)
        else:
            commands.neighbors(X, skeleton, options.metric, options.out, options.neighbors, options.radius)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="skpose", description=skpose.__doc__.splitlines()[0], epilog=EXIT_STATUS)
    parser.add_argument("--version", action="version", version=f"skpose {skpose.__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    def command(name: str, summary: str, more: str = "") -> argparse.ArgumentParser:
        description = f"{summary[0].upper()}{summary[1:]}{more}."
        return commands.add_parser(name, help=summary, description=description, epilog=EXIT_STATUS)

    compare = command(
        "compare",
        "compare the metrics at telling walking from running",
        ", by the nearest neighbour among the poses of other people and of other sequences",
    )
    compare.add_argument(
        "folder",
        nargs="?",
        type=Path,
        metavar="FOLDER",
        help="CMU files with an index.csv, see skpose.datasets.load_cmu; without it, generated motions",
    )
    _add_jobs(compare)

    reproduce = command(
        "reproduce",
        "repeat section 3 of the paper",
        ": print every number beside the paper's, and write the table (README.md, table.txt) and figures 3 and 4 (PNG) "
        "to a folder. Files of these names that are there are written over",
    )
    reproduce.add_argument(
        "folder",
        nargs="?",
        type=Path,
        metavar="FOLDER",
        help="CMU files with an index.csv, see skpose.datasets.load_cmu; without it, generated motions",
    )
    reproduce.add_argument("--out", type=Path, required=True, metavar="DIR", help="where to; made if it is not there")
    reproduce.add_argument("--seed", type=int, default=0, metavar="N", help="of all draws; default: 0")
    _add_jobs(reproduce)

    distances = command(
        "distances",
        "write the distances between all poses of some files to a file",
        ". Poses of several bodies are put on the mean of these. If it is stopped, the same command goes on where it "
        "stopped",
    )
    _add_poses(distances, "D.npy", "the matrix, in numpy's format; open it with numpy.load(..., mmap_mode='r')")
    distances.add_argument(
        "--dtype", choices=["float32", "float64"], default="float64", help="precision; default: float64"
    )

    neighbors = command(
        "neighbors",
        "write the graph of nearest poses of some files to a file",
        ". Poses of several bodies are put on the mean of these",
    )
    _add_poses(neighbors, "G.npz", "the sparse matrix of distances; open it with scipy.sparse.load_npz")
    which = neighbors.add_mutually_exclusive_group()
    which.add_argument("--neighbors", type=_positive(int), default=5, metavar="K", help="of each pose; default: 5")
    which.add_argument(
        "--radius", type=_positive(float), metavar="R", help="all poses within this, m (rad for angle), instead"
    )

    info = command("info", "say what is in a BVH, AMC or ASF file")
    info.add_argument("file", type=Path, metavar="FILE")
    _add_reading(info)
    return parser


def _add_poses(parser: argparse.ArgumentParser, out: str, what: str) -> None:
    """Which poses to work on, with which metric, where, and where to put what comes out."""
    parser.add_argument(
        "files", nargs="+", type=Path, metavar="FILE", help="BVH or AMC files, in the order of the rows"
    )
    parser.add_argument("--out", type=Path, required=True, metavar=out, help=what)
    parser.add_argument("--metric", choices=METRICS, default="spatial", help="default: spatial")
    parser.add_argument(
        "--rate", type=_positive(float), metavar="HZ", help="resample to so many poses a second; default: every frame"
    )
    _add_reading(parser)
    parser.add_argument(
        "--backend",
        choices=["threads", "loky", "dask", "ray"],
        default="threads",
        help="where to work: threads, the default; processes (loky); a cluster, of which dask or ray is installed",
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="of the cluster, such as tcp://10.0.0.1:8786; default: one on this machine",
    )
    _add_jobs(parser)


def _add_reading(parser: argparse.ArgumentParser) -> None:
    """How to read files."""
    parser.add_argument(
        "--asf",
        type=Path,
        metavar="FILE",
        help="skeleton of the AMC files; default: walk.asf beside walk.amc, or CMU's, 02.asf beside 02_01.amc",
    )
    parser.add_argument(
        "--frame-rate", type=_positive(float), default=120.0, metavar="HZ", help="of AMC files; default: 120"
    )
    parser.add_argument(
        "--scale",
        type=_positive(float),
        metavar="M",
        help="metres per unit of length; default: 1 for BVH, what the skeleton's file says for AMC",
    )


def _add_jobs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--jobs", type=int, default=-1, metavar="N", help="threads or processes; -1, the default, is all processors"
    )


def _positive(kind: type) -> Callable[[str], float]:
    def positive(text: str) -> float:
        number = kind(text)
        if not 0 < number < float("inf"):
            raise ValueError
        return number

    # What argparse calls it: invalid positive number value.
    positive.__name__ = "positive whole number" if kind is int else "positive number"
    return positive
