"""`skpose view`: a page that plays motions, a picture, an animated GIF."""

import argparse

import skpose
from skpose._cli import options


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = options.add_command(
        subparsers,
        "view",
        "play motions in the browser, or draw them as PNG or GIF",
        "Write an HTML page that plays motions offline, a picture of one moment, or an animated GIF.",
        "FILE...",
    )
    options.add_files(parser, "motions, markers or keypoints")
    options.add_out(parser, ".html", required=False)
    add = parser.add_argument
    add("--open", action="store_true", help="open the page in the browser")
    add("--align", action="store_true", help="align two motions, show their differences")
    add("--overlay", action="store_true", help="show all motions in one picture")
    options.add_frame_rate(parser)
    group = parser.add_argument_group("pictures")
    add = group.add_argument
    add("--png", type=options.file_named(".png"), metavar="FILE", help="picture of one moment")
    add("--at", type=float, default=0.0, metavar="S", help="time of --png, s; default: the start")
    add("--gif", type=options.file_named(".gif"), metavar="FILE", help="animated GIF, without interpolation")
    add("--fps", type=options.positive, default=20.0, metavar="N", help="pictures per second of --gif; default: 20")
    options.add_part(group, "--gif")
    options.add_reading(parser)
    parser.set_defaults(func=run)


def run(args: argparse.Namespace) -> None:
    from skpose._cli import inputs, outputs

    if not (args.out or args.open or args.png or args.gif):
        raise ValueError("pass --out, --open, --png or --gif")
    contents = inputs.read(args, args.files, inputs.load_moving)
    labels = inputs.shorten([name for name, _ in contents])
    shown = [inputs.resample(content, args.frame_rate) for _, content in contents]
    if args.png or args.gif:
        from skpose._cli.pictures import Recording

        recording = Recording(shown, labels, skpose.keypoints.layouts[args.layout] if args.layout else None)
        if args.png:
            recording.save_png(args.png, args.at)
            print(args.png)
        if args.gif:
            print(f"{args.gif}: {recording.save_gif(args.gif, args.begins, args.ends, args.fps)} pictures")
    if args.out or args.open:
        alignment = skpose.motions.align_motions(*shown) if args.align else None
        page = skpose.view.player(shown, labels=labels, alignment=alignment, layout=args.layout, overlay=args.overlay)
        outputs.save_page(page, args.out, args.open)
