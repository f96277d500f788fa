"""`skpose explore`: a page of all poses as points."""

import argparse

import skpose
from skpose._cli import options


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = options.add_command(
        subparsers,
        run,
        "explore",
        "show all poses of files as points in the browser",
        "Write an HTML page that shows all poses as points, with similar poses close together. Subjects "
        "and actions come from an index.csv, or from names such as SUBJECT_ACTION_TRIAL.bvh.",
        "FILE...",
    )
    options.add_files(parser, "motions")
    options.add_out(parser, ".html", required=False)
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
    parser.add_argument(
        "--metric",
        nargs="+",
        choices=options.METRICS,
        default=["spatial", "position", "rotation", "angle"],
        metavar="NAME",
        help="one or more of angle, position, rotation, spatial, geodesic; default: all except geodesic",
    )
    parser.add_argument(
        "--embedding",
        nargs="+",
        choices=["mds", "tsne"],
        default=["mds"],
        metavar="NAME",
        help="mds, tsne, or both; default: mds",
    )
    options.add_jobs(parser)
    options.add_preparing(parser, frame_rate=12.0)
    options.add_reading(parser)


def run(args: argparse.Namespace) -> None:
    from skpose._cli import files

    if not (args.out or args.open):
        raise ValueError("pass --out or --open")
    names, dataset = files.read_dataset(args, args.files)
    page = skpose.view.explorer(
        dataset,
        metrics=args.metric,
        embeddings=args.embedding,
        frame_rate=None,  # resampled before
        labels=None if files.is_labelled(dataset) else files.shorten(names),
        n_jobs=args.jobs,
        verbose=1,
    )
    files.save_page(page, args.out, args.open)
