"""`skpose angles`: the joint angles of a person, in degrees, as a table."""

import argparse
from pathlib import Path

import skpose
from skpose._cli import options


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = options.add_command(
        subparsers,
        "angles",
        "write the joint angles of a person in degrees as a table",
        "Write flexion, adduction and rotation of each joint, in degrees, see "
        "skpose.biomechanics.joint_angles: a row for each frame. A skeleton is fitted to markers and keypoints.",
        "FILE --out FILE",
    )
    options.add_file(parser)
    options.add_out(parser, ".csv")
    parser.add_argument(
        "--zero",
        type=lambda text: int(text) if text.isdecimal() else Path(text),
        metavar="FRAME|FILE",
        help="standing frame or static trial; default: rest",
    )
    options.add_reading(parser, skip=False)
    parser.set_defaults(func=run)


def run(args: argparse.Namespace) -> None:
    import csv

    import numpy as np

    from skpose._cli import inputs
    from skpose._utils.files import new_file

    files = [args.file, args.zero] if isinstance(args.zero, Path) else [args.file]
    motions = _fit([content for _, content in inputs.read(args, files, inputs.load_moving)], args.layout)
    found = skpose.biomechanics.joint_angles(motions[0], zero=motions[1] if len(motions) > 1 else args.zero)
    with new_file(args.out) as new, new.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["time [s]", *found.names])
        for time, row in zip(found.times, found.degrees, strict=True):
            table.writerow([f"{time:.6g}", *("" if np.isnan(value) else f"{value:.4f}" for value in row)])
    print(f"{args.out}: {found!r}")
    for reason in dict.fromkeys(found.missing.values()):
        print(f"not in all frames: {', '.join(name for name, why in found.missing.items() if why == reason)}: {reason}")


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
