"""`skpose check`: faults of motions, as a table and as a page that plays them."""

import argparse
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import skpose
from skpose._cli import options

SHOWN = 40  # findings in the terminal
COLUMNS = "severity", "kind", "file", "first_frame", "last_frame", "joints", "size", "unit", "what", "remedy"
SAME = {"units": "from end to end", "up axis": "is taken as up"}  # in warnings of readers about what is found, too


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = options.add_command(
        subparsers,
        "check",
        "find faults of motions: units, rates, jumps, feet, duplicates",
        "Print what is wrong with motions, worst first: errors, warnings, notes, see skpose.checks.check_motion. "
        "--out writes all findings as CSV, or as a page that plays each at its frame.",
        "FILE...",
    )
    options.add_files(parser, "motions")
    options.add_out(parser, ".csv", ".html", required=False)
    options.add_reading(parser, skip=False)
    parser.set_defaults(func=run)


def run(args: argparse.Namespace) -> None:
    from skpose._cli import inputs
    from skpose.checks._check import check_all
    from skpose.checks._findings import SEVERITIES, Finding
    from skpose.checks._report import report

    files = inputs.expand(args.files, inputs.MOTIONS)
    reading = {"on_nan": "drop"} | inputs.reading_options(args)
    rates = inputs.stated_rates(files)
    unread: list[Finding] = []
    read: list[int] = []  # the index of the file of each motion

    def motions() -> Iterator[skpose.Motion]:
        for i, path in enumerate(files):
            motion, reasons = _read(path, {"frame_rate": rates.get(path)} | reading)
            if motion is not None:
                read.append(i)
                yield motion
            severity, frames = ("error", 0) if motion is None else ("warning", len(motion))
            remedy = "see docs/formats.md, and the options of reading"
            unread.extend(
                Finding(severity, "reading", i, (0, frames), (), 0.0, "", reason, remedy) for reason in reasons
            )

    names = inputs.shorten([str(path) for path in files])
    found = [one._replace(motion=read[one.motion]) for one in check_all(motions(), lambda i: names[read[i]])]
    known = {(one.motion, text) for one in found for text in [SAME.get(one.kind)] if text}
    unread = [one for one in unread if not any(one.motion == i and text in one.what for i, text in known)]
    findings = sorted(unread + found, key=lambda one: SEVERITIES.index(one.severity))
    _print(findings, names)
    if len(read) < len(files):
        args.status = 3
    if args.out and args.out.suffix.lower() == ".csv":
        _write_csv(findings, names, args.out)
    elif args.out and findings:
        report(findings, names, lambda i: _read(files[i], {"frame_rate": rates.get(files[i])} | reading)[0]).save(
            args.out
        )
    print(f"{args.out}: {len(findings)} findings" if args.out else "--out writes all findings as .csv or .html")


def _read(path: Path, reading: dict) -> tuple["skpose.Motion | None", list[str]]:
    """The motion of a file, and what the reader warns about or refuses."""
    import warnings

    from skpose._cli import inputs

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            motion = inputs.load_poses(path, reading)
        except (OSError, ValueError) as error:
            return None, [str(error)]
    return motion, [str(one.message) for one in caught]


def _print(findings: list, names: list[str]) -> None:
    kinds = Counter(kind for kind, _ in {(one.kind, one.motion) for one in findings})
    words = ": " * bool(kinds) + ", ".join(f"{n} {kind}" for kind, n in kinds.most_common())
    print(f"{len(names)} files, {len({one.motion for one in findings})} with findings{words}")
    width = max(map(len, ("file", *names)))
    for one in findings[:SHOWN]:
        frames = f"{one.frames[0]} to {one.frames[1] - 1}"
        print(f"{one.severity:<7}  {names[one.motion]:<{width}}  {frames:>14}  {one.kind}: {one.what}")
    if len(findings) > SHOWN:
        print(f"and {len(findings) - SHOWN} more")


def _write_csv(findings: list, names: list[str], out: Path) -> None:
    import csv

    from skpose._utils.files import new_file

    with new_file(out) as new, new.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(COLUMNS)
        for severity, kind, motion, (first, end), joints, size, unit, what, remedy in findings:
            row = severity, kind, names[motion], first, end - 1, " ".join(joints), f"{size:.6g}", unit, what, remedy
            table.writerow(row)
