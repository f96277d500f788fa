"""`skpose explore`: a page of all poses as points."""

import argparse
from pathlib import Path

import skpose
from skpose._cli import options


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "explore",
        help="show all poses of files as points in the browser",
        description="Write an HTML page that shows all poses as points, with similar poses close together. Subjects "
        "and actions come from an index.csv, or from names such as SUBJECT_ACTION_TRIAL.bvh.",
        parents=[
            options.writing(".html", required=False),
            options.preparing(frame_rate=12.0),
            options.computing(None),
            options.reading(),
        ],
    )
    options.add_files(parser, "motions")
    group = parser.add_argument_group("page")
    group.add_argument(
        "--open", action="store_true", help="open it in the browser; without --out it is a temporary file"
    )
    group.add_argument(
        "--metric",
        nargs="+",
        choices=options.METRICS,
        default=["spatial", "position", "rotation", "angle"],
        help="one or several, the first is shown initially; default: all except geodesic, which is slow",
    )
    group.add_argument(
        "--embedding", nargs="+", choices=["mds", "tsne", "isomap"], default=["mds"], help="default: mds"
    )
    parser.set_defaults(func=run)


def run(args: argparse.Namespace) -> None:
    from skpose._cli import inputs, outputs

    if not (args.out or args.open):
        raise ValueError("pass --out or --open")
    names, dataset = inputs.read_dataset(args, args.files)
    known = inputs.labels_of([Path(name) for name in names])
    is_labelled = all(all(known.get(key, [""])) for key in ("subjects", "actions"))
    page = skpose.view.explorer(
        skpose.datasets.MotionDataset(dataset.motions, **known),
        metrics=args.metric,
        embeddings=args.embedding,
        frame_rate=None,  # resampled before
        labels=None if is_labelled else inputs.shorten(names),
        n_jobs=args.jobs,
        verbose=1,
    )
    outputs.save_page(page, args.out, args.open)
