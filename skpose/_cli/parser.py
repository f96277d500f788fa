"""Commands and options of the command line."""

import argparse
import textwrap
from pathlib import Path

import skpose
from skpose._cli.options import (
    SUBJECTS,
    CommandParser,
    ListFormatter,
    add_dtype,
    add_files,
    add_folder,
    add_jobs,
    add_metric,
    add_out,
    add_poses,
    add_preparing,
    add_reading,
    add_reading_points,
    add_skip_errors,
    positive,
    seconds,
    share,
)
from skpose._cli.parser_motions import add_angles, add_between, add_convert, add_mean, add_retarget
from skpose._cli.parser_pages import add_explore, add_view
from skpose._cli.targets import ENDINGS, NAMED

ALIGNMENTS = "dtw", "subsequence", "frames"  # those of motion_distances
EXIT_STATUS = (
    "Exit status: 0 success, 1 error in the files or the computation, 2 wrong options, 3 success without the files "
    "that --skip-errors left out, 130 interrupted."
)
MEAN = ". {} of several skeletons are compared on their mean skeleton"
MATRIX = (
    "the matrix: .npy for numpy.load(..., mmap_mode='r'), which is continued after an interruption; .csv, with names "
    "of rows and columns, for pandas and spreadsheets; .npz, as arrays distances and names"
)


# The commands in the help of `skpose`.
SECTIONS = {
    "look at files": ("info", "view", "explore"),
    "compare poses and motions": ("distances", "neighbors", "motions", "find"),
    "make motions": ("mean", "between", "retarget", "convert"),
    "measure people": ("angles",),
    "repeat studies": ("compare", "reproduce"),
    "prepare a computer": ("warm-up",),
}


def command_line() -> CommandParser:
    """Return the parser of ``skpose`` and its commands."""
    parser = CommandParser(
        prog="skpose",
        formatter_class=ListFormatter,
        epilog=f"skpose COMMAND --help: its options\n\n{textwrap.fill(EXIT_STATUS, 78)}",
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", help=argparse.SUPPRESS)
    summaries = {}

    def command(name: str, summary: str, more: str = "") -> CommandParser:
        summaries[name] = summary
        description = f"{summary[0].upper()}{summary[1:]}{more}."
        return commands.add_parser(name, description=description, epilog=EXIT_STATUS)

    compare = command(
        "compare",
        "compare how well actions are recognised under the metrics",
        ", poses and whole motions, by the nearest neighbour among those of other people and among all others. Actions "
        "are those that two people or more do; joints of two or three angles are ball joints",
    )
    add_folder(compare)
    compare.group("input").add_argument(
        "--paper",
        action="store_true",
        help="the paper's protocol: walking and running alone, and joint angles as the files have them",
    )
    add_out(compare, "FILE.png", [".png"], "the table as a picture, with a pose of each action", named=False)
    add_jobs(compare)

    reproduce = command(
        "reproduce",
        "repeat section 3 of the paper",
        ": print every number with the paper's, and write the table (report.md, table.txt) and figures 3 and 4 (PNG) "
        "to a folder. Existing files are never overwritten",
    )
    add_folder(reproduce)
    reproduce.group("output").add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="output folder; created if missing, inside an existing folder; default: the name of FOLDER with "
        f"{ENDINGS['reproduce']}, here, with a number where there is one already",
    )
    reproduce.group("computation").add_argument(
        "--seed", type=int, default=0, metavar="N", help="seed of all random draws; default: 0"
    )
    add_jobs(reproduce)

    _add_distances(
        command(
            "distances",
            "write the distances between all poses of some files to a file",
            f"{MEAN.format('Poses')}. If the command is interrupted, run it again to continue a matrix in .npy",
        )
    )
    _add_neighbors(
        command(
            "neighbors",
            "write the graph of nearest poses of some files to a file",
            f"{MEAN.format('Poses')}. In the place of the files it also takes a file of distances, of skpose distances "
            "or motions, and writes the graph of its nearest rows",
        )
    )
    _add_motions(
        command(
            "motions",
            "write the distances between the motions of some files to a file",
            f", by dynamic time warping, with a row for each file{MEAN.format('Motions')}. If the command is "
            "interrupted, run it again to continue a matrix in .npy",
        )
    )
    _add_find(
        command(
            "find",
            "print where a motion, or a pose, is found in some files",
            f", the best first{MEAN.format('Motions')}",
        )
    )
    add_mean(
        command(
            "mean",
            "write the typical motion of some files to a file",
            ", by dynamic time warping, on their mean skeleton: bones keep their lengths. How much the motions differ "
            "from it is printed",
        )
    )
    add_between(
        command(
            "between",
            "write a motion through key poses to a file",
            ": frames of one file, or a frame of each of several files. Every frame is a pose whose bones keep their "
            "lengths",
        )
    )
    add_retarget(
        command(
            "retarget",
            "bring a motion onto the skeleton of another file",
            ", which may be rigged differently. How many joints have counterparts is printed, and how near it comes",
        )
    )
    add_convert(
        command(
            "convert",
            "write the motion or the points of a file in another format",
            ": BVH, .npz or CSV. Markers and keypoints have no skeleton, and become .npz or CSV",
        )
    )
    add_angles(
        command(
            "angles",
            "write the angles of a person's joints, in degrees, as a table",
            ": flexion, adduction and rotation of each joint, by the conventions of biomechanics, see "
            "skpose.biomechanics.joint_angles. Markers and keypoints are fitted by a skeleton",
        )
    )
    add_view(
        command(
            "view",
            "write a page that plays the motions of some files",
            ", to turn them and to compare them. The page is one HTML file that needs no network",
        )
    )
    add_explore(
        command(
            "explore",
            "write a page of all poses of some files as points",
            ", to find and compare poses and motions. Near points are similar poses under the metric. "
            "Subjects and actions are those of an index.csv in the "
            "folder of a file or in one above it, see skpose.datasets.load_cmu, or of the names of files, "
            "SUBJECT_ACTION_TRIAL.bvh or as those of CMU and HDM05. The page is one HTML file that needs no network",
        )
    )

    info = command(
        "info",
        "print what files of motions, skeletons or points contain",
        ": BVH, AMC, ASF, AMASS, TRC or C3D files, keypoints, or files of skpose",
    )
    info.add_argument(
        "files",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="a file, or a folder, for its BVH, AMC, ASF, TRC and C3D files; - is standard input",
    )
    add_skip_errors(info)
    add_reading(info)
    add_reading_points(info)
    _add_warm_up(
        command(
            "warm-up",
            "compile before anybody waits",
            ": each function compiles at its first call, and is stored for all later processes of this computer. Run "
            "the command when an image of a container is built, or before tests. What it stores is for processors like "
            "this one; the environment variable NUMBA_CPU_NAME names another, such as x86-64-v3, here and where skpose "
            "is used",
        )
    )
    lists = (
        f"{title}:\n" + "\n".join(f"  {name:<12}{summaries[name]}" for name in names)
        for title, names in SECTIONS.items()
    )
    parser.description = "\n\n".join([textwrap.fill(skpose.__doc__.splitlines()[0], 78), *lists])
    return parser


def _add_distances(distances: CommandParser) -> None:
    add_poses(distances, "FILE", (".npy", *NAMED), MATRIX)
    add_dtype(distances)


def _add_neighbors(neighbors: CommandParser) -> None:
    add_poses(
        neighbors,
        "FILE",
        NAMED,
        "the graph: .npz, a sparse matrix of distances for scipy.sparse.load_npz, with the names of the rows; .csv, a "
        "row for each neighbour with both names, rank and distance",
    )
    which = neighbors.group("result").add_mutually_exclusive_group()
    which.add_argument(
        "--neighbors", type=positive(int), default=5, metavar="K", help="neighbours of each pose; default: 5"
    )
    which.add_argument(
        "--radius",
        type=positive(float),
        metavar="R",
        help="instead: all poses up to this distance, m (rad for angle)",
    )


def _add_motions(motions: CommandParser) -> None:
    add_poses(motions, "FILE", (".npy", *NAMED), MATRIX)
    add_dtype(motions)
    group = motions.group("metric")
    group.add_argument(
        "--alignment",
        choices=ALIGNMENTS,
        default="dtw",
        metavar="NAME",
        help="dtw: warp the whole of both; subsequence: find the motion of the row inside that of the column; frames: "
        "frame by frame, for motions of equal length; default: dtw",
    )
    group.add_argument(
        "--window",
        type=share,
        metavar="SHARE",
        help="band of dtw: times may differ by this share of the durations, 0 to 1; default: no limit",
    )


def _add_find(find: CommandParser) -> None:
    find.add_argument("query", type=Path, metavar="QUERY", help="file of the motion to find; - is standard input")
    add_files(find, order="")
    group = find.group("input")
    for name, does in (("from", "begins"), ("to", "ends")):
        group.add_argument(
            f"--{name}",
            dest=does,
            type=seconds,
            metavar="S",
            help=f"where the motion to find {does} in its file, s; default: where the file {does}",
        )
    group.add_argument(
        "--pose",
        type=seconds,
        metavar="S",
        help="find the single pose at this time of QUERY, s, instead of the motion; a place is then a frame to which "
        "no other within half a second is nearer",
    )
    group = find.group("result")
    group.add_argument("--k", type=positive(int), default=10, metavar="K", help="number of places; default: 10")
    group.add_argument(
        "--exclude-query",
        action="store_true",
        help="leave out the places that have frames of the motion to find, or are within half a second of the pose, "
        "where QUERY is among the files",
    )
    group.add_argument("--one-per-file", action="store_true", help="the best place of each file only")
    add_metric(find)
    add_preparing(find)
    add_jobs(find)


def _add_warm_up(warm_up: CommandParser) -> None:
    group = warm_up.group("computation")
    group.add_argument(
        "--for",
        dest="subjects",
        nargs="+",
        choices=SUBJECTS,
        default=SUBJECTS,
        metavar="NAME",
        help=f"one or several of {', '.join(SUBJECTS)}; default: all",
    )
    add_jobs(warm_up)


class _Version(argparse.Action):
    """Print the version, which takes a moment to find, only if it is requested."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        print(f"skpose {skpose.__version__}")
        parser.exit()
