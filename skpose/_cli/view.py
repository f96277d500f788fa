"""`skpose view`: a page that plays motions, and a picture."""

import argparse
from pathlib import Path

import skpose
from skpose._cli import options


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = options.add_command(
        subparsers,
        run,
        "view",
        "play motions in the browser, or draw them as PNG",
        "Write an HTML page that plays motions offline, and makes pictures, videos and GIFs of them; or a PNG picture.",
        "FILE...",
    )
    options.add_files(parser, "motions, markers or keypoints")
    options.add_out(parser, ".html", required=False)
    add = parser.add_argument
    add("--open", action="store_true", help="open the page in the browser")
    add("--align", action="store_true", help="align two motions, show their differences")
    add("--overlay", action="store_true", help="show all motions in one picture")
    options.add_frame_rate(parser)
    add("--png", type=options.file_named(".png"), metavar="FILE", help="picture: eight poses of each motion")
    options.add_reading(parser)


def run(args: argparse.Namespace) -> None:
    from skpose._cli import files

    if not (args.out or args.open or args.png):
        raise ValueError("pass --out, --open or --png")
    contents = files.read(args, args.files, files.load_moving)
    labels = files.shorten([name for name, _ in contents])
    shown = [files.resample(content, args.frame_rate) for _, content in contents]
    if args.png:
        if any(isinstance(one, skpose.Keypoints) for one in shown):
            raise ValueError("--png draws motions, got keypoints, which the page shows")
        _draw(shown, labels, args.png)
    if args.out or args.open:
        alignment = skpose.motions.align_motions(*shown) if args.align else None
        page = skpose.view.player(shown, labels=labels, alignment=alignment, layout=args.layout, overlay=args.overlay)
        files.save_page(page, args.out, args.open)


def _draw(shown: list, labels: list[str], png: Path) -> None:
    """Write a picture with a row of poses of each motion."""
    from matplotlib.figure import Figure

    from skpose._utils.files import new_file

    figure = Figure(figsize=(11.0, 3.5 * len(shown)), layout="constrained")
    for ax, motion, label in zip(figure.subplots(len(shown), squeeze=False)[:, 0], shown, labels, strict=True):
        skpose.plot.PoseDisplay.from_motion(motion, ax=ax)
        ax.set_title(label, parse_math=False)
    with new_file(png) as new:
        figure.savefig(new, format="png", dpi=100)
    print(png)
