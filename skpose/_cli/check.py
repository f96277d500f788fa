"""`skpose check`: faults of motions, as a table and as a page that plays them."""

import argparse
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import skpose
from skpose._cli import options

SHOWN = 40  # findings in the terminal
COLUMNS = "severity", "kind", "file", "first_frame", "last_frame", "joints", "size", "unit", "what", "remedy"


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = options.add_command(
        subparsers,
        run,
        "check",
        "find faults of motions: units, rates, jumps, feet, duplicates",
        "Print what is wrong with motions, worst first: errors, warnings, notes, see skpose.checks.check_motion. "
        "--out writes all findings as CSV, or as a page that plays each at its frame.",
        "FILE...",
    )
    options.add_files(parser, "motions")
    options.add_out(parser, ".csv", ".html", required=False)
    options.add_reading(parser, skip=False)


def run(args: argparse.Namespace) -> None:
    from skpose._cli import files
    from skpose.checks._check import check_all
    from skpose.checks._findings import Finding
    from skpose.checks._report import report
    from skpose.datasets._folder import MOTIONS, RATE, find_files

    rows = files.describe(find_files(args.files, MOTIONS))
    names = files.shorten([str(row["file"]) for row in rows])
    unread: list[Finding] = []
    numbers: list[int] = []  # of the files of motions
    frame_numbers: dict[int, Any] = {}  # in each file, without those left out

    def read(i: int) -> skpose.Motion:
        options = {"on_nan": "drop", "frame_rate": rows[i].get(RATE)} | files.reading_options(args)
        return files.load_poses(rows[i]["file"], options)

    def motions() -> Iterator[skpose.Motion]:
        for i in range(len(rows)):
            try:
                motion = read(i)
            except (OSError, ValueError) as error:
                unread.append(
                    Finding("error", "reading", i, (0, 0), (), 0.0, "", str(error), "see the options of reading")
                )
                args.status = 3
            else:
                numbers.append(i)
                frame_numbers[i] = motion.frame_numbers
                yield motion

    found = check_all(motions(), lambda number: names[numbers[number]])
    findings = unread + [one._replace(motion=numbers[one.motion]) for one in found]
    shown = [_in_file(one, frame_numbers) for one in findings]
    _print(shown, names)
    playable = any(one.frames[1] for one in findings)
    if args.out and args.out.suffix.lower() == ".csv":
        _write_csv(shown, names, args.out)
    elif args.out and playable:
        report(findings, names, read).save(args.out)
    if args.out:
        print(
            f"{args.out}: {len(findings)} findings"
            if args.out.exists()
            else f"{args.out}: not written, nothing to play"
        )
    else:
        print("--out writes all findings as .csv or .html")


def _in_file(one: Any, frame_numbers: dict[int, Any]) -> Any:
    """A finding with the numbers of frames in the file."""
    first, end = one.frames
    if not end:
        return one
    numbers = frame_numbers[one.motion]
    return one._replace(frames=(int(numbers[first]), int(numbers[end - 1]) + 1))


def _print(findings: list, names: list[str]) -> None:
    kinds = Counter(kind for kind, _ in {(one.kind, one.motion) for one in findings})
    words = ": " * bool(kinds) + ", ".join(f"{n} {kind}" for kind, n in kinds.most_common())
    print(f"{len(names)} files, {len({one.motion for one in findings})} with findings{words}")
    width = max(map(len, ("file", *names)))
    for one in findings[:SHOWN]:
        frames = f"{one.frames[0]} to {one.frames[1] - 1}" if one.frames[1] else ""
        print(f"{one.severity:<7}  {names[one.motion]:<{width}}  {frames:>14}  {one.kind}: {one.what}")
    if len(findings) > SHOWN:
        print(f"and {len(findings) - SHOWN} more")


def _write_csv(findings: list, names: list[str], out: Path) -> None:
    from skpose._utils.files import write_csv

    rows: list[tuple] = [COLUMNS]
    for severity, kind, motion, (first, end), joints, size, unit, what, remedy in findings:
        ends = (first, end - 1) if end else ("", "")
        rows.append((severity, kind, names[motion], *ends, " ".join(joints), f"{size:.6g}", unit, what, remedy))
    write_csv(out, rows)
