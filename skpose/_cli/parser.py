"""Commands and options of the command line."""

import argparse
from collections.abc import Callable
from pathlib import Path

import skpose
from skpose._cli.targets import file_named

METRICS = "angle", "position", "rotation", "spatial", "geodesic"  # the registry's, without numba and scikit-learn
ALIGNMENTS = "dtw", "subsequence", "frames"  # those of motion_distances
EXIT_STATUS = "Exit status: 0 success, 1 error in the files or the computation, 2 wrong options, 130 interrupted."


def command_line() -> argparse.ArgumentParser:
    """Return the parser of ``skpose`` and its commands."""
    parser = argparse.ArgumentParser(prog="skpose", description=skpose.__doc__.splitlines()[0], epilog=EXIT_STATUS)
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    def command(name: str, summary: str, more: str = "") -> argparse.ArgumentParser:
        description = f"{summary[0].upper()}{summary[1:]}{more}."
        return commands.add_parser(name, help=summary, description=description, epilog=EXIT_STATUS)

    compare = command(
        "compare",
        "compare how well the metrics classify walking and running",
        ", by the nearest neighbour among the poses of other people and of other sequences",
    )
    _add_folder(compare)
    _add_jobs(compare)

    reproduce = command(
        "reproduce",
        "repeat section 3 of the paper",
        ": print every number with the paper's, and write the table (report.md, table.txt) and figures 3 and 4 (PNG) "
        "to a folder. Existing files are never overwritten",
    )
    _add_folder(reproduce)
    reproduce.add_argument(
        "--out",
        type=Path,
        required=True,
        metavar="DIR",
        help="output folder; created if missing, inside an existing folder",
    )
    reproduce.add_argument("--seed", type=int, default=0, metavar="N", help="seed of all random draws; default: 0")
    _add_jobs(reproduce)

    distances = command(
        "distances",
        "write the distances between all poses of some files to a file",
        ". Poses of several skeletons are compared on their mean skeleton. If the command is interrupted, run it again "
        "to continue",
    )
    _add_poses(distances, "D.npy", ".npy", "the matrix, in numpy's format; open it with numpy.load(..., mmap_mode='r')")
    _add_dtype(distances)

    neighbors = command(
        "neighbors",
        "write the graph of nearest poses of some files to a file",
        ". Poses of several skeletons are compared on their mean skeleton",
    )
    _add_poses(neighbors, "G.npz", ".npz", "the sparse matrix of distances; open it with scipy.sparse.load_npz")
    which = neighbors.add_mutually_exclusive_group()
    which.add_argument(
        "--neighbors", type=_positive(int), default=5, metavar="K", help="neighbours of each pose; default: 5"
    )
    which.add_argument(
        "--radius",
        type=_positive(float),
        metavar="R",
        help="instead: all poses up to this distance, m (rad for angle)",
    )

    motions = command(
        "motions",
        "write the distances between the motions of some files, by dynamic time warping, to a file",
        ", with a row for each file. Motions of several skeletons are compared on their mean skeleton. If the command "
        "is interrupted, run it again to continue",
    )
    _add_poses(motions, "D.npy", ".npy", "the matrix, in numpy's format; open it with numpy.load")
    _add_dtype(motions)
    motions.add_argument(
        "--alignment",
        choices=ALIGNMENTS,
        default="dtw",
        help="dtw: warp the whole of both; subsequence: find the motion of the row inside that of the column; frames: "
        "frame by frame, for motions of equal length; default: dtw",
    )
    motions.add_argument(
        "--window",
        type=_share,
        metavar="SHARE",
        help="band of dtw: times may differ by this share of the durations, 0 to 1; default: no limit",
    )

    find = command(
        "find",
        "print the places in some files where a motion is found, the best first",
        ". Motions of several skeletons are compared on their mean skeleton",
    )
    find.add_argument("query", type=Path, metavar="QUERY", help="file of the motion to find; - is standard input")
    _add_files(find, order="")
    for name, does in (("from", "begins"), ("to", "ends")):
        find.add_argument(
            f"--{name}",
            dest=does,
            type=_seconds,
            metavar="S",
            help=f"where the motion to find {does} in its file, s; default: where the file {does}",
        )
    find.add_argument("--k", type=_positive(int), default=10, metavar="K", help="number of places; default: 10")
    _add_metric(find)
    _add_preparing(find)
    _add_jobs(find)

    view = command(
        "view",
        "write a page that plays the motions of some files, to turn them and to compare them",
        ". The page is one HTML file that needs no network",
    )
    _add_files(view, order="")
    view.add_argument(
        "--out", type=file_named(".html"), required=True, metavar="VIEW.html", help="the page; open it in a browser"
    )
    view.add_argument(
        "--align",
        action="store_true",
        help="of two files: play the frames together that belong together, by dynamic time warping, and show the "
        "differences of the joints by colours",
    )
    view.add_argument(
        "--overlay", action="store_true", help="begin with all motions in one picture instead of side by side"
    )
    _add_rate(view)
    _add_reading(view)

    info = command("info", "print the contents of BVH, AMC, ASF, AMASS, TRC or C3D files")
    info.add_argument(
        "files",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="a file, or a folder, for its BVH, AMC and ASF files; - is standard input",
    )
    _add_reading(info)
    return parser


class _Version(argparse.Action):
    """Print the version, which takes a moment to find, only if it is requested."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        print(f"skpose {skpose.__version__}")
        parser.exit()


def _add_folder(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "folder",
        nargs="?",
        type=Path,
        metavar="FOLDER",
        help="AMC files with an index.csv, see skpose.datasets.load_cmu, or BVH files whose names are their labels, "
        "SUBJECT_ACTION_TRIAL.bvh, where ACTION begins with the word walk or run: anna_walk_1.bvh, ben_run_fast_2.bvh; "
        "default: generated motions",
    )
    _add_scale(parser, "metres per unit of length of BVH files; default: 1")


def _add_poses(parser: argparse.ArgumentParser, out: str, suffix: str, result: str) -> None:
    """Add the options of a computation on poses that writes a file: input, output, metric, backend."""
    _add_files(parser)
    parser.add_argument("--out", type=file_named(suffix), required=True, metavar=out, help=result)
    _add_metric(parser)
    _add_preparing(parser)
    parser.add_argument(
        "--backend",
        choices=["threads", "loky", "dask", "ray"],
        default="threads",
        help="threads (default), processes (loky), or a cluster, for which dask or ray must be installed",
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="address of the cluster, such as tcp://10.0.0.1:8786; default: start one on this machine",
    )
    _add_jobs(parser)


def _add_files(parser: argparse.ArgumentParser, order: str = ", in the order of the rows") -> None:
    parser.add_argument(
        "files",
        nargs="+",
        type=Path,
        metavar="FILE",
        help=f"BVH, AMC or AMASS files{order}; for a folder its BVH and AMC files, sorted; - is standard input",
    )


def _add_metric(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--metric", choices=METRICS, default="spatial", help="default: spatial")


def _add_dtype(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--dtype", choices=["float32", "float64"], default="float64", help="precision; default: float64"
    )


def _add_preparing(parser: argparse.ArgumentParser) -> None:
    """Add the options of what is read, and of what is done with it before the computation."""
    _add_rate(parser)
    parser.add_argument(
        "--rotations",
        choices=["rotvec"],
        help="rotvec: turn joints of two or three Euler angles into ball joints, which rotate by the shortest path; "
        "default: the files' angles",
    )
    _add_reading(parser)
    parser.add_argument(
        "--retarget",
        dest="method",
        choices=["numbers", "orientations", "positions", "auto", "unchecked"],
        default="numbers",
        help="bring files of different rigs or rest poses onto the skeleton of the first: by the directions of the "
        "bones in the world, by the positions of the joints, by the first method that can (auto), or by the numbers as "
        "they are (unchecked); default: by the numbers, on the mean skeleton, with different rest poses refused",
    )
    parser.add_argument(
        "--with-root",
        choices=["tilt", "whole"],
        help="make the orientation of the root a part of the poses: without the heading, or whole; default: neither",
    )
    parser.add_argument(
        "--up",
        choices=["x", "y", "z"],
        help="the axis of the world that points up, for --with-root; default: y for BVH and AMC files, z for AMASS "
        "files",
    )


def _add_rate(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--rate", type=_positive(float), metavar="HZ", help="resample to this many poses a second; default: every frame"
    )


def _add_reading(parser: argparse.ArgumentParser) -> None:
    """Add the options of the readers of files."""
    parser.add_argument(
        "--asf",
        type=Path,
        metavar="FILE",
        help="skeleton of the AMC files; default: in the same folder, walk.asf for walk.amc, or 02.asf for 02_01.amc",
    )
    parser.add_argument(
        "--frame-rate", type=_positive(float), default=120.0, metavar="HZ", help="of AMC files; default: 120"
    )
    _add_scale(parser, "metres per unit of length; default: 1 for BVH, the unit in the skeleton's file for AMC")
    parser.add_argument(
        "--model",
        metavar="FILE",
        help="body model (.npz) of AMASS files, see skpose.io.load_amass; {gender} in it is replaced by the motion's; "
        "default: a person of mean proportions",
    )
    parser.add_argument(
        "--no-hands",
        dest="hands",
        action="store_false",
        help="leave out the joints beyond the wrists of AMASS files, with which SMPL and SMPL-H differ",
    )
    for name, choices, meaning in (
        ("on-nan", ["raise", "drop"], "frames with NaN or infinite numbers: refuse the file, or leave them out"),
        ("trust", ["header", "rows"], "number of frames of a BVH file: as stated after Frames:, or as it has rows"),
        ("stretch", ["raise", "mean"], "bones of a BVH file that change their lengths: refuse it, or take the mean"),
        ("missing", ["raise", "rest"], "bones that a frame of an AMC file leaves out: refuse it, or set them to zero"),
    ):
        parser.add_argument(f"--{name}", choices=choices, default=choices[0], help=f"{meaning}; default: {choices[0]}")
    parser.add_argument(
        "--root",
        metavar="NAME",
        help="joint of a BVH file that is the root; default: the first, or its moving child if it stands still",
    )


def _add_scale(parser: argparse.ArgumentParser, meaning: str) -> None:
    parser.add_argument("--scale", type=_positive(float), metavar="M", help=meaning)


def _add_jobs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--jobs", type=_jobs, default=-1, metavar="N", help="threads or processes; -1, the default, is all processors"
    )


def _jobs(text: str) -> int:
    number = int(text)
    if number == 0:
        raise ValueError
    return number


_jobs.__name__ = "number of jobs"  # in argparse's error message


def _share(text: str) -> float:
    share = float(text)
    if not 0 <= share <= 1:
        raise ValueError
    return share


_share.__name__ = "share from 0 to 1"


def _seconds(text: str) -> float:
    seconds = float(text)
    if not 0 <= seconds < float("inf"):
        raise ValueError
    return seconds


_seconds.__name__ = "time in seconds"


def _positive(kind: type) -> Callable[[str], float]:
    def positive(text: str) -> float:
        number = kind(text)
        if not 0 < number < float("inf"):
            raise ValueError
        return number

    positive.__name__ = "positive integer" if kind is int else "positive number"  # in argparse's error message
    return positive
