"""Options of the commands that make something of motions: a mean, in-betweens, another skeleton, another format."""

import argparse
import re
from collections.abc import Callable
from pathlib import Path

from skpose._cli.options import (
    CommandParser,
    add_files,
    add_frame_rate,
    add_jobs,
    add_metric,
    add_new_motion,
    add_out,
    add_preparing,
    add_reading,
    add_reading_points,
    add_rotations,
    add_skip_errors,
    positive,
    seconds,
    share,
)

ONE = "BVH, AMC or AMASS file, or an .npz file of skpose; - is standard input"


def add_mean(mean: CommandParser) -> None:
    add_files(mean, order="")
    add_new_motion(mean, "the typical motion")
    mean.group("output").add_argument(
        "--cycle",
        action="store_true",
        help="close it, so that it can be looped: its last frame becomes its first one, moved along the floor",
    )
    mean.group("output").add_argument(
        "--endpoint",
        action="store_true",
        help="with --cycle: the last frames of the files are the first pose again, as of strides from heel strike to "
        "heel strike; default: they are the ones before",
    )
    add_metric(mean, ("position", "geodesic"), "position")
    mean.group("metric").add_argument(
        "--window",
        type=share,
        metavar="SHARE",
        help="band of the alignment: times may differ by this share of the durations, 0 to 1; default: no limit",
    )
    mean.group("result").add_argument(
        "--frames",
        dest="n_frames",
        type=positive(int),
        metavar="N",
        help="number of frames; default: that of the motion with the least distances to the others",
    )
    add_preparing(mean)
    add_jobs(mean)


def add_between(between: CommandParser) -> None:
    add_files(between, order=", in the order of the key poses", skip=False)
    add_new_motion(between, "the motion")
    keyed = between.group("input")
    keys = keyed.add_mutually_exclusive_group(required=True)
    keys.add_argument(
        "--frames",
        type=_numbers(int, "frames, such as 10,50,90"),
        metavar="N,N,…",
        help="the key poses: numbers of frames, 0 is the first and -1 the last (--frames=-1,0). Two or more of one "
        "file, or one of each file",
    )
    keys.add_argument(
        "--times",
        type=_numbers(seconds, "times, such as 0.5,1.2,3"),
        metavar="S,S,…",
        help="the same by times in the files, s: the frames nearest to them",
    )
    keyed.add_argument(
        "--seconds",
        type=positive(float),
        metavar="S",
        help="time from each key pose to the next, s; default: as in the file, for one file",
    )
    between.group("result").add_argument(
        "--method",
        dest="interpolation",
        choices=["spline", "geodesic"],
        default="spline",
        metavar="NAME",
        help="spline: a smooth curve; geodesic: shortest paths at constant speed, with corners at the keys; default: "
        "spline",
    )
    between.group("output").add_argument(
        "--frame-rate",
        type=positive(float),
        metavar="HZ",
        help="frames a second of the motion; default: those of the first file",
    )
    add_preparing(between, resample=False)
    add_jobs(between)


def add_retarget(retarget: CommandParser) -> None:
    retarget.add_argument("files", nargs="+", type=Path, metavar="FILE", help=f"{ONE}. Several are only reported on")
    retarget.group("input").add_argument(
        "--onto",
        type=Path,
        required=True,
        metavar="OTHER",
        help="file whose skeleton it is: as FILE, an ASF file, or a robot (MJCF, URDF)",
    )
    add_new_motion(retarget, "the motion on the skeleton of OTHER; default: print the report alone", named=False)
    group = retarget.group("result")
    group.add_argument(
        "--method",
        choices=["auto", "numbers", "orientations", "positions", "limbs", "unchecked"],
        default="auto",
        metavar="BY",
        help="numbers (of the angles), orientations (directions of the bones in the world), positions (of the joints), "
        "limbs (within the limits of a robot), unchecked (the numbers as they are), or auto, the first of these that "
        "can; default: auto",
    )
    group.add_argument(
        "--joints",
        type=_pair,
        nargs="+",
        metavar="OTHERS=FILES",
        help="counterparts: a joint of OTHER and its joint in FILE, such as left_knee=LeftLeg; joints that are left "
        "out have none; default: by their names",
    )
    group.add_argument(
        "--factor",
        type=_factor,
        metavar="F",
        help="factor of positions in the world; lengths: the ratio of the lengths of the bones, as a person of the "
        "size of OTHER would move; default: 1, and the ratio of the legs by limbs",
    )
    add_frame_rate(retarget)
    add_skip_errors(retarget)
    add_reading(retarget)
    add_jobs(retarget)


def add_convert(convert: CommandParser) -> None:
    convert.add_argument(
        "file",
        type=Path,
        metavar="FILE",
        help="BVH, AMC, AMASS, TRC or C3D file, keypoints, or .npz; - is standard input",
    )
    add_new_motion(convert, "the file to write")
    add_frame_rate(convert)
    add_rotations(convert)
    add_reading(convert)
    add_reading_points(convert)


def add_angles(angles: CommandParser) -> None:
    angles.add_argument(
        "file",
        type=Path,
        metavar="FILE",
        help="BVH, AMC, AMASS, TRC or C3D file, keypoints, or .npz; - is standard input",
    )
    add_out(angles, "FILE.csv", (".csv",), "the table: a row for each frame, with its time, s, and all angles, degrees")
    angles.group("result").add_argument(
        "--zero",
        type=_frame_or_file,
        metavar="FRAME|FILE",
        help="the standing pose at which all angles are zero: the number of a frame, from 0, or a file in which the "
        "person stands; default: the axes of the limbs in the rest pose of the skeleton",
    )
    add_reading(angles)
    add_reading_points(angles)


def _frame_or_file(text: str) -> int | Path:
    if re.fullmatch(r"-\d+", text):
        raise argparse.ArgumentTypeError(
            f"frames are numbered from 0, got {text}: pass 0 or more, or a file (./{text} if that is its name)"
        )
    return int(text) if text.isdecimal() else Path(text)


def _numbers(kind: Callable[[str], float], expected: str) -> Callable[[str], list]:
    """Return the type of an option: two numbers or more with commas between them."""

    def values_of(text: str) -> list:
        try:
            return [kind(word) for word in text.split(",")]
        except (ValueError, argparse.ArgumentTypeError):
            raise argparse.ArgumentTypeError(f"expected {expected}, got {text!r}") from None

    return values_of


def _pair(text: str) -> tuple[str, str]:
    name, equals, counterpart = text.partition("=")
    if not (name and equals and counterpart):
        raise argparse.ArgumentTypeError(f"expected a joint of OTHER and its joint in FILE, such as a=b, got {text!r}")
    return name, counterpart


def _factor(text: str) -> float | str:
    return text if text == "lengths" else positive(float)(text)


_factor.__name__ = "positive number or lengths"  # in argparse's error message
