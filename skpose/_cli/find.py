"""`skpose find`: search files for a motion or a single pose."""

import argparse
from pathlib import Path
from typing import Any

import skpose
from skpose._cli import options

APART = 0.5  # s, between two places of a pose


Place = tuple[float, int, int, int]  # the distance, the index of the file, the first row and the one after the last


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = options.add_command(
        subparsers,
        "find",
        "search files for a motion or a pose",
        "Print the places most similar to a motion or a pose, best first. Motions of several skeletons are "
        "compared on their mean skeleton.",
        "QUERY FILE...",
    )
    parser.add_argument("query", type=options.one_file, metavar="QUERY", help="the motion to find; -: standard input")
    options.add_files(parser, "where to search: motions")
    options.add_part(parser, "the motion to find")
    add = parser.add_argument
    add("--pose", type=float, metavar="S", help="search for the pose at this time, s")
    add("--k", type=int, default=10, metavar="K", help="number of places; default: 10")
    add("--exclude-query", action="store_true", help="exclude places that overlap the query")
    options.add_metric(parser)
    options.add_jobs(parser)
    options.add_preparing(parser)
    options.add_reading(parser)
    parser.set_defaults(func=run)


def run(args: argparse.Namespace) -> None:
    from skpose._cli import inputs

    if args.pose is not None and (args.begins, args.ends) != (None, None):
        raise ValueError("--pose is one moment: leave out --from and --to")
    (name, *names), dataset = inputs.read_dataset(args, [args.query, *args.files], required=1)
    whole, *recordings = dataset.motions
    query = Path(name).resolve()
    own = {i for i, other in enumerate(names) if args.exclude_query and Path(other).resolve() == query}
    if args.pose is None:
        here = inputs.rows_between(whole, args.begins, args.ends)
        places = _find_motion(args, whole, here, recordings, own)
    else:
        row = inputs.rows_between(whole, args.pose - 0.5 / whole.frame_rate, None).start
        places = _find_pose(args, whole, row, recordings, own)
    places = sorted(places)[: args.k]
    _print_places(places, names, recordings, args)


def _find_motion(
    args: argparse.Namespace, whole: "skpose.Motion", here: slice, recordings: list["skpose.Motion"], own: set[int]
) -> list[Place]:
    """The best places of the rows `here`; files in `own` are searched before and after them only."""
    parts = []  # (index of the file, first row, frames)
    for i, recording in enumerate(recordings):
        bounds = [(0, here.start), (here.stop, len(recording))] if i in own else [(0, len(recording))]
        parts += [(i, start, recording[start:stop]) for start, stop in bounds if start < stop]
    found = skpose.motions.find_motion(
        whole[here],
        [motion for *_, motion in parts],
        k=args.k,
        skeleton=whole.skeleton,
        metric=args.metric,
        n_jobs=args.jobs,
    )
    places = []
    for match in found:
        i, first, _ = parts[match.motion]
        places.append((match.distance, i, first + match.start, first + match.stop))
    return places


def _find_pose(
    args: argparse.Namespace, whole: "skpose.Motion", row: int, recordings: list["skpose.Motion"], own: set[int]
) -> list[Place]:
    """The places of a pose; in files in `own` not those near the pose itself."""
    import numpy as np

    places = []
    for i, recording in enumerate(recordings):
        X = whole.angles[row : row + 1], recording.angles
        (distances,) = skpose.pose_distances(*X, skeleton=whole.skeleton, metric=args.metric, n_jobs=args.jobs)
        rows = find_minima(distances, recording.frame_numbers, recording.frame_rate)
        if i in own:
            rows = rows[np.abs(recording.times[rows] - whole.times[row]) > APART]
        places += [(float(distances[r]), i, r, r + 1) for r in rows.tolist()]
    return places


def find_minima(distances: Any, numbers: Any, frame_rate: float) -> Any:
    """The rows of frames that are nearer than all others within half a second; of equal ones the first."""
    import numpy as np
    from scipy.ndimage import minimum_filter1d

    reach = int(APART * frame_rate)
    at = np.full(numbers[-1] - numbers[0] + 1, np.inf)
    at[numbers - numbers[0]] = distances
    lowest = minimum_filter1d(at, 2 * reach + 1, mode="constant", cval=np.inf)
    rows: list[int] = []
    for row in np.flatnonzero(lowest[numbers - numbers[0]] == distances).tolist():
        if not rows or numbers[row] - numbers[rows[-1]] > reach:
            rows.append(row)
    return np.array(rows, dtype=np.intp)


def _print_places(
    places: list[Place], names: list[str], recordings: list["skpose.Motion"], args: argparse.Namespace
) -> None:
    width = max(len(name) for name in ("file", *names))
    times = f"{'start, s':>10}  {'end, s':>10}" if args.pose is None else f"{'time, s':>10}"
    distance = f"distance, {'rad' if args.metric == 'angle' else 'm'}"
    print(f"{'rank':>6}  {'file':<{width}}  {times}  {distance:>14}")
    for rank, (nearest, i, start, stop) in enumerate(places, start=1):
        motion = recordings[i]
        times = f"{motion.times[start]:>10.2f}"
        if args.pose is None:
            times += f"  {motion.times[stop - 1] + 1.0 / motion.frame_rate:>10.2f}"
        print(f"{rank:>6}  {names[i]:<{width}}  {times}  {nearest:>14.4f}")
