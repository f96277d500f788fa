"""Commands and options of the command line."""

import argparse
from pathlib import Path

import skpose
from skpose._cli.options import (
    METRICS,
    add_dtype,
    add_files,
    add_folder,
    add_frame_rate,
    add_jobs,
    add_metric,
    add_poses,
    add_preparing,
    add_reading,
    add_skip_errors,
    positive,
    seconds,
    share,
)
from skpose._cli.targets import file_named

ALIGNMENTS = "dtw", "subsequence", "frames"  # those of motion_distances
EXIT_STATUS = (
    "Exit status: 0 success, 1 error in the files or the computation, 2 wrong options, 3 success without the files "
    "that --skip-errors left out, 130 interrupted."
)


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
    add_folder(compare)
    add_jobs(compare)

    reproduce = command(
        "reproduce",
        "repeat section 3 of the paper",
        ": print every number with the paper's, and write the table (report.md, table.txt) and figures 3 and 4 (PNG) "
        "to a folder. Existing files are never overwritten",
    )
    add_folder(reproduce)
    reproduce.add_argument(
        "--out",
        type=Path,
        required=True,
        metavar="DIR",
        help="output folder; created if missing, inside an existing folder",
    )
    reproduce.add_argument("--seed", type=int, default=0, metavar="N", help="seed of all random draws; default: 0")
    add_jobs(reproduce)

    distances = command(
        "distances",
        "write the distances between all poses of some files to a file",
        ". Poses of several skeletons are compared on their mean skeleton. If the command is interrupted, run it again "
        "to continue",
    )
    add_poses(distances, "D.npy", ".npy", "the matrix, in numpy's format; open it with numpy.load(..., mmap_mode='r')")
    add_dtype(distances)

    neighbors = command(
        "neighbors",
        "write the graph of nearest poses of some files to a file",
        ". Poses of several skeletons are compared on their mean skeleton",
    )
    add_poses(neighbors, "G.npz", ".npz", "the sparse matrix of distances; open it with scipy.sparse.load_npz")
    which = neighbors.add_mutually_exclusive_group()
    which.add_argument(
        "--neighbors", type=positive(int), default=5, metavar="K", help="neighbours of each pose; default: 5"
    )
    which.add_argument(
        "--radius",
        type=positive(float),
        metavar="R",
        help="instead: all poses up to this distance, m (rad for angle)",
    )

    motions = command(
        "motions",
        "write the distances between the motions of some files, by dynamic time warping, to a file",
        ", with a row for each file. Motions of several skeletons are compared on their mean skeleton. If the command "
        "is interrupted, run it again to continue",
    )
    add_poses(motions, "D.npy", ".npy", "the matrix, in numpy's format; open it with numpy.load")
    add_dtype(motions)
    motions.add_argument(
        "--alignment",
        choices=ALIGNMENTS,
        default="dtw",
        help="dtw: warp the whole of both; subsequence: find the motion of the row inside that of the column; frames: "
        "frame by frame, for motions of equal length; default: dtw",
    )
    motions.add_argument(
        "--window",
        type=share,
        metavar="SHARE",
        help="band of dtw: times may differ by this share of the durations, 0 to 1; default: no limit",
    )

    find = command(
        "find",
        "print the places in some files where a motion is found, the best first",
        ". Motions of several skeletons are compared on their mean skeleton",
    )
    find.add_argument("query", type=Path, metavar="QUERY", help="file of the motion to find; - is standard input")
    add_files(find, order="")
    for name, does in (("from", "begins"), ("to", "ends")):
        find.add_argument(
            f"--{name}",
            dest=does,
            type=seconds,
            metavar="S",
            help=f"where the motion to find {does} in its file, s; default: where the file {does}",
        )
    find.add_argument("--k", type=positive(int), default=10, metavar="K", help="number of places; default: 10")
    add_metric(find)
    add_preparing(find)
    add_jobs(find)

    view = command(
        "view",
        "write a page that plays the motions of some files, to turn them and to compare them",
        ". The page is one HTML file that needs no network",
    )
    add_files(view, order="")
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
    add_frame_rate(view)
    add_reading(view)

    explore = command(
        "explore",
        "write a page of all poses of some files as points, to find and compare poses and motions",
        ". Near points are similar poses under the metric. Subjects and actions are those of an index.csv in the "
        "folder of a file or in one above it, see skpose.datasets.load_cmu, or of the names of files, "
        "SUBJECT_ACTION_TRIAL.bvh or as those of CMU and HDM05. The page is one HTML file that needs no network",
    )
    add_files(explore, order="")
    explore.add_argument(
        "--out", type=file_named(".html"), required=True, metavar="EXPLORE.html", help="the page; open it in a browser"
    )
    explore.add_argument(
        "--metric",
        dest="metrics",
        nargs="+",
        choices=METRICS,
        default=["spatial", "position", "rotation", "angle"],
        help="one or several, the page starts with the first; geodesic takes an hour for a million distances; default: "
        "all others",
    )
    add_preparing(explore, frame_rate=12.0)
    add_jobs(explore)

    info = command("info", "print the contents of BVH, AMC, ASF, AMASS, TRC or C3D files, or of keypoints")
    info.add_argument(
        "files",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="a file, also of keypoints as JSON, CSV or arrays of numpy, or a folder, for its BVH, AMC, ASF, TRC and "
        "C3D files; - is standard input",
    )
    add_skip_errors(info)
    add_reading(info)
    return parser


class _Version(argparse.Action):
    """Print the version, which takes a moment to find, only if it is requested."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        print(f"skpose {skpose.__version__}")
        parser.exit()
