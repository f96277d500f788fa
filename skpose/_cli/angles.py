"""Angles of joints of a file, as a table."""

import csv
import errno
import os
from functools import partial
from pathlib import Path
from typing import cast

import numpy as np

from skpose._cli.colours import print_written
from skpose._cli.contents import Content, load_any
from skpose._cli.messages import describe
from skpose._cli.reader import STDIN, Reader, name_of
from skpose._files import new_file
from skpose.biomechanics import JointAngles, joint_angles
from skpose.keypoints import Keypoints, Layout, fit_skeleton
from skpose.keypoints._shared import check_layout, find_layout, missing_points, nearest_layout
from skpose.kinematics import inverse_kinematics
from skpose.kinematics._shared import find_landmarks
from skpose.skeleton import Motion, Skeleton


def angles(path: Path, zero: Path | int | None, reader: Reader, out: Path, layout: str | None) -> None:
    """Write the angles of the joints of a file; zero is a file, the number of a frame, or None for the rest pose."""
    files = [path, zero] if isinstance(zero, Path) else [path]
    if isinstance(zero, Path) and str(zero) != STDIN and not zero.exists():
        missing = FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(zero))
        raise ValueError(f"--zero is the number of a frame or a file, and {describe(missing)}")
    contents = [content for _, content in reader.read(files, load_any, required=len(files))]
    names = [name_of(file) for file in files]
    for name, content in zip(names, contents, strict=True):
        if isinstance(content, Skeleton):
            raise ValueError(
                f"{name} is a skeleton (ASF or a robot), which has no motion: pass a motion, such as its AMC file"
            )
    motions = _fit(contents, names, layout)
    standing = motions[1] if isinstance(zero, Path) else zero
    found = cast(JointAngles, joint_angles(motions[0], zero=standing))  # scikit-learn's configuration is the default
    with new_file(out) as new:
        _write(new, found)
    print_written(
        out, f"{len(found.names)} angles in degrees, {len(found)} frames, zero: {found.zero}, names of {found.rig}"
    )
    for reason in dict.fromkeys(found.missing.values()):
        of = [name for name, why in found.missing.items() if why == reason]
        print(f"not in all frames, as {reason}: {', '.join(of)}")


def _fit(contents: list[Content], names: list[str], layout: str | None) -> list[Motion]:
    """Return motions as they are; those of keypoints on the skeleton of the last, the one of a person who stands."""
    points = [content for content in contents if isinstance(content, Keypoints)]
    if not points:
        return [content for content in contents if isinstance(content, Motion)]
    if len(points) < len(contents):
        raise ValueError(
            f"{names[0]} and {names[1]}: one is a motion, and the other has markers or keypoints; expected two of a "
            "kind, as zero is a pose on the skeleton of the motion"
        )
    of = _layout_of(points[-1], names[-1], layout)
    missing = missing_points(of, points[-1].names)
    refuse = partial(_lacks, of, missing, names[-1], layout is None)
    try:
        smaller = of.without(missing)
    except ValueError:  # the root, or a part of a midpoint
        means = [point for point, ends in of.midpoints.items() if set(missing) & set(ends)]
        of_them = f"{', '.join(means)} {'are means' if len(means) > 1 else 'is a mean'} of them"
        raise refuse(of_them if means else f"{of.root} is the root") from None
    named = [smaller.keypoints(one, absent="unseen") for one in points]
    skeleton = fit_skeleton(named[-1], smaller)
    if missing:
        if complaint := _complain_of_legs(of, missing, skeleton):
            raise refuse(complaint)
        print(
            f"without {', '.join(missing)} of {of.name}, which {names[-1]} lacks: they are on trunk, arms or head, and "
            "angles there that rest on them are empty or not in the table"
        )
    return [inverse_kinematics(one, skeleton).to_motion() for one in named]


def _layout_of(points: Keypoints, name: str, layout: str | None) -> Layout:
    """Return the layout that is named, or the one of which most points are there."""
    of = find_layout(points.names) if layout is None else check_layout(layout)
    near = nearest_layout(points.names) if of is None else of
    if near is None:
        raise ValueError(
            f"the points of {name} are those of no layout that the library knows: pass --layout, if some names differ, "
            f"or read the file in Python with a skpose.keypoints.Layout of its points, {', '.join(points.names)}"
        )
    return near


def _complain_of_legs(of: Layout, missing: list[str], skeleton: Skeleton) -> str:
    """Return why missing points are needed: those on legs and on the pelvis; empty if all are on branches above it."""

    def branch(name: str) -> str:
        """Return the point, from a point up, that is next to the root."""
        parent = of.parents[name]
        return name if parent is None or parent == of.root else branch(parent)

    joints = find_landmarks(skeleton).joints
    legs = {branch(skeleton.joint_names[joint]) for mark, joint in joints.items() if mark.endswith(("hip", "ankle"))}
    if not legs:
        return "legs are not known without them"
    single = set(of.points) - set(of.parents.values())  # of those next to the root: markers on the pelvis
    needed = [name for name in missing if branch(name) in legs | single]
    return f"angles of legs rest on {', '.join(needed)}" if needed else ""


def _lacks(of: Layout, missing: list[str], name: str, is_nearest: bool, reason: str) -> ValueError:
    """Return the error on points of a layout that a file lacks and that are not left out."""
    return ValueError(
        f"{name} has the points of {'the nearest layout, ' if is_nearest else ''}{of.name}, but for "
        f"{', '.join(missing)}, which are not left out, as {reason}: pass --zero FILE --layout {of.name}, where FILE "
        "has them and the person stands. Markers on the inner side of joints are often in that recording alone. "
        "Without one, read the file in Python with a skpose.keypoints.Layout of the points that are there"
    )


def _write(path: Path, found: JointAngles) -> None:
    """Write angles as CSV, with the time of each frame; angles that the motion does not show are empty cells."""
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["time [s]", *found.names])
        for time, row in zip(found.times, found.degrees, strict=True):
            table.writerow([f"{time:.6g}", *("" if np.isnan(value) else f"{value:.4f}" for value in row)])
