"""`skpose find`: search files for a motion."""

import argparse
from pathlib import Path

import skpose
from skpose._cli import options


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = options.add_command(
        subparsers,
        run,
        "find",
        "search files for a motion",
        "Print the places most similar to a motion, best first. Motions of several skeletons are "
        "compared on their mean skeleton.",
        "QUERY FILE...",
    )
    parser.add_argument("query", type=options.one_file, metavar="QUERY", help="the motion to find; -: standard input")
    options.add_files(parser, "where to search: motions")
    options.add_part(parser, "the motion to find")
    add = parser.add_argument
    add("--k", type=int, default=10, metavar="K", help="number of places; default: 10")
    add("--exclude-query", action="store_true", help="exclude places that overlap the query")
    options.add_metric(parser)
    options.add_jobs(parser)
    options.add_preparing(parser)
    options.add_reading(parser)


def run(args: argparse.Namespace) -> None:
    from skpose._cli import files

    (name, *names), dataset = files.read_dataset(args, [args.query, *args.files], required=1)
    whole, *recordings = dataset.motions
    here = files.rows_between(whole, args.begins, args.ends)
    parts = []  # (index of the file, first row, frames): the query's own file before and after the query only
    for i, recording in enumerate(recordings):
        own = args.exclude_query and Path(names[i]).resolve() == Path(name).resolve()
        bounds = [(0, here.start), (here.stop, len(recording))] if own else [(0, len(recording))]
        parts += [(i, start, recording[start:stop]) for start, stop in bounds if start < stop]
    found = skpose.motions.find_motion(
        whole[here],
        [motion for *_, motion in parts],
        k=args.k,
        skeleton=whole.skeleton,
        metric=args.metric,
        n_jobs=args.jobs,
    )
    width = max(len(name) for name in ("file", *names))
    distance = f"distance, {'rad' if args.metric == 'angle' else 'm'}"
    print(f"{'rank':>6}  {'file':<{width}}  {'start, s':>10}  {'end, s':>10}  {distance:>14}")
    for rank, match in enumerate(found, start=1):
        i, first, _ = parts[match.motion]
        times = recordings[i].times[first:]
        begins, ends = times[match.start], times[match.stop - 1] + 1.0 / recordings[i].frame_rate
        print(f"{rank:>6}  {names[i]:<{width}}  {begins:>10.2f}  {ends:>10.2f}  {match.distance:>14.4f}")
