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
)


def add_view(view: CommandParser) -> None:
    add_files(
        view,
        order="",
        formats="BVH, AMC, AMASS, TRC or C3D files, .npz files of skpose, or keypoints as JSON, CSV or .npz",
        of_folders="BVH, AMC, TRC and C3D",
    )
    add_out(view, "VIEW.html", (".html",), "the page")
    add_open(view, "it")
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
    add_preparing(explore, frame_rate=12.0)
    add_jobs(explore)
