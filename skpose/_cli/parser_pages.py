"""Options of the commands that write a page."""

from skpose._cli.options import (
    METRICS,
    CommandParser,
    add_files,
    add_frame_rate,
    add_jobs,
    add_open,
    add_out,
    add_preparing,
    add_reading,
    add_reading_points,
    positive,
    seconds,
)
from skpose._cli.targets import file_named

EMBEDDINGS = "mds", "tsne", "isomap"  # those of `explorer`


def add_view(view: CommandParser) -> None:
    add_files(
        view,
        order="",
        formats="BVH, AMC, AMASS, TRC or C3D files, .npz files of skpose, or keypoints as JSON, CSV or .npz",
        of_folders="BVH, AMC, TRC and C3D",
    )
    add_out(view, "VIEW.html", (".html",), "the page")
    add_open(view, "it")
    group = view.group("output")
    group.add_argument(
        "--png", type=file_named(".png"), metavar="OUT.png", help="a picture of one moment: the last frame before it"
    )
    group.add_argument("--at", type=seconds, metavar="S", help="time of --png in the files, s; default: the begin")
    group.add_argument(
        "--gif",
        type=file_named(".gif"),
        metavar="OUT.gif",
        help="a moving picture of recorded frames, with none made up between two",
    )
    for name, does in (("from", "begins"), ("to", "ends")):
        group.add_argument(
            f"--{name}", dest=does, type=seconds, metavar="S", help=f"where --gif {does}, s; default: where files do"
        )
    group.add_argument("--fps", type=positive(float), metavar="N", help="pictures a second of --gif; default: 20")
    group = view.group("result")
    group.add_argument(
        "--align",
        action="store_true",
        help="of two files: play the frames together that belong together, by dynamic time warping, and show the "
        "differences of the joints by colours",
    )
    group.add_argument(
        "--overlay", action="store_true", help="begin with all motions in one picture instead of side by side"
    )
    add_frame_rate(view)
    add_reading(view)
    add_reading_points(view)


def add_explore(explore: CommandParser) -> None:
    add_files(explore, order="")
    add_out(explore, "EXPLORE.html", (".html",), "the page")
    add_open(explore, "it")
    explore.group("metric").add_argument(
        "--metric",
        dest="metrics",
        nargs="+",
        choices=METRICS,
        default=["spatial", "position", "rotation", "angle"],
        metavar="NAME",
        help="one or several of angle, position, rotation, spatial and geodesic, which takes an hour for a million "
        "distances; the page starts with the first; default: all but geodesic",
    )
    explore.group("result").add_argument(
        "--embedding",
        dest="embeddings",
        nargs="+",
        choices=EMBEDDINGS,
        default=["mds"],
        metavar="NAME",
        help="one or several of mds, tsne and isomap: how the plane is made of the distances; default: mds",
    )
    add_preparing(explore, frame_rate=12.0)
    add_jobs(explore)
