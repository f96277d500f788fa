"""`skpose angles`: the joint angles of a person, in degrees, as a table."""

import argparse
from pathlib import Path
from typing import Any

import skpose
from skpose._cli import options


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = options.add_command(
        subparsers,
        run,
        "angles",
        "write the joint angles of a person in degrees as a table",
        "Write flexion, adduction and rotation of each joint, in degrees, see skpose.biomechanics.joint_angles: a row "
        "for each frame, or for each per cent of each stride. A skeleton is fitted to markers and keypoints.",
        "FILE [FILE ...] --out FILE",
    )
    options.add_files(parser, "motions, markers or keypoints")
    options.add_out(parser, ".csv")
    parser.add_argument(
        "--zero",
        type=lambda text: int(text) if text.isdecimal() else Path(text),
        metavar="FRAME|FILE",
        help="standing frame or static trial; default: rest",
    )
    parser.add_argument("--cycles", action="store_true", help="strides over per cent, of one or more files")
    options.add_reading(parser, skip=False)


def run(args: argparse.Namespace) -> None:
    import numpy as np

    from skpose._cli import files
    from skpose._utils.files import new_file, write_csv
    from skpose.datasets._folder import find_files

    paths = find_files(args.files, files.MOVING)
    if len(paths) > 1 and not args.cycles:
        raise ValueError(f"one file has rows of frames, got {len(paths)} files: pass --cycles")
    standing = [args.zero] if isinstance(args.zero, Path) else []
    contents = [content for _, content in files.read(args, [*paths, *standing], files.load_moving)]
    if standing:
        *motions, zero = _fit(contents, args.layout)
    else:
        motions, zero = [_fit([content], args.layout)[0] for content in contents], args.zero
    found = [skpose.biomechanics.joint_angles(motion, zero=zero) for motion in motions]
    if args.cycles:
        table = _tabulate(paths, motions, found, args.file_frame_rate is None)
        with new_file(args.out) as new:
            table.to_csv(new, index=False, float_format="%.6g")
    else:
        cells = np.char.mod("%.4f", found[0].degrees)
        rows = zip(np.char.mod("%.6g", found[0].times), np.where(cells == "nan", "", cells), strict=True)
        header = ["time [s]", *(f"{name} [deg]" for name in found[0].names)]
        write_csv(args.out, [header, *([time, *row] for time, row in rows)])
    print(f"{args.out}: {', '.join(map(repr, found))}")
    missing = {(name, reason) for one in found for name, reason in one.missing.items()}
    for reason in sorted({reason for _, reason in missing}):
        print(f"not in all frames: {', '.join(sorted(name for name, why in missing if why == reason))}: {reason}")


def _tabulate(paths: list[Path], motions: list["skpose.Motion"], found: list[Any], has_rates: bool) -> Any:
    """The strides of all files as a dataframe, by the events of C3D files that have them, in the time of the file."""
    import pandas

    from skpose.datasets._folder import rows_of

    tables, rows = [], rows_of(paths)
    for row, motion, angles in zip(rows, motions, found, strict=True):
        path = row["file"]
        is_c3d = has_rates and ".c3d" in [suffix.lower() for suffix in path.suffixes]
        quantities = skpose.io.load_c3d_quantities(path) if is_c3d else {}
        known = {name: one for name, one in quantities.items() if one.kind == "events"}
        events = skpose.biomechanics.gait_events(motion, events=known or None)
        print(f"{path}: {events}{' of the file' * bool(known)}")
        if len(events.strides):
            subject = row["subject"] if "index" in row and row.get("subject") else path.resolve().parent.name
            tables.append(angles.cycles(events).assign(subject=subject, trial=path.stem))
    if not tables:
        raise ValueError("no file has a stride")
    return pandas.concat(tables, ignore_index=True)


def _fit(contents: list, layout: str | None) -> list["skpose.Motion"]:
    """Fit a skeleton to the last of several keypoints, and all of them to it; motions stay as they are."""
    from skpose.keypoints._layouts import find_layout, missing_points, nearest_layout

    if len({type(content) for content in contents}) > 1:
        raise ValueError("FILE and the file of --zero must both be motions, or both keypoints")
    if not isinstance(contents[0], skpose.Keypoints):
        return contents
    names = contents[-1].names
    of = skpose.keypoints.layouts[layout] if layout else find_layout(names) or nearest_layout(names)
    if of is None:
        raise ValueError(
            f"the points have no known layout: pass --layout, one of {', '.join(skpose.keypoints.layouts)}"
        )
    if missing := missing_points(of, names):
        print(f"without {', '.join(missing)} of the layout {of.name}")
        try:
            of = of.without(missing)
        except ValueError as error:
            raise ValueError(f"{error}: pass --zero, a standing trial with all markers") from None
    points = [of.keypoints(content, absent="unseen") for content in contents]
    skeleton = skpose.keypoints.fit_skeleton(points[-1], of)
    return [skpose.inverse_kinematics(one, skeleton).to_motion() for one in points]
