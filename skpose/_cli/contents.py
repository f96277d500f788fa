"""Contents of files of any format: motions, skeletons, markers and keypoints; and what `skpose info` prints of them."""

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from skpose._cli.inputs import motion_files
from skpose._cli.reader import Rate, Reader, name_of
from skpose._cli.stored import describe_stored
from skpose.io import file_format, load_asf, load_c3d, load_keypoints, load_motion, load_trc
from skpose.io._shared import Stored, has_keypoints, is_robot, read_stored
from skpose.keypoints import Keypoints
from skpose.skeleton import Bone, Motion, Skeleton

Content = Motion | Skeleton | Keypoints
SUFFIXES = ".bvh", ".amc", ".asf", ".trc", ".c3d"  # of the files that stand for a folder


def load_any(file: Path | BytesIO, **options: Any) -> Content:
    """Return the content of a file of any format."""
    points = {name: options.pop(name, None) for name in ("layout", "names", "zeros")}
    shared = {name: options[name] for name in ("scale", "up") if options[name] is not None}
    if is_robot(_rewind(file)):
        try:
            from skpose.robots import load_robot

            return load_robot(_rewind(file), root=options["root"])  # in metres: a scale is for the other files
        except ImportError as error:
            raise ValueError(str(error)) from None
    if has_keypoints(_rewind(file)):
        return load_keypoints(
            _rewind(file), points["layout"], names=points["names"], frame_rate=options["frame_rate"], **shared
        )
    kind = file_format(_rewind(file))
    _rewind(file)
    if kind == "ASF":
        return load_asf(file, scale=options["scale"])
    if kind == "C3D":
        return load_c3d(file, zeros=points["zeros"], **shared)
    if kind == "TRC":
        return load_trc(file, frame_rate=options["frame_rate"], trust=options["trust"], zeros=points["zeros"], **shared)
    return load_motion(file, **options)


def _rewind(file: Path | BytesIO) -> Path | BytesIO:
    if isinstance(file, BytesIO):
        file.seek(0)
    return file


def info(files: Sequence[Path], reader: Reader) -> None:
    """Print the contents of each file: frames, joints or points, degrees of freedom; its name, if there are several."""
    files, blank = motion_files(files, SUFFIXES), ""
    for path, content in reader.read(files, _load):
        if len(files) > 1:
            print(f"{blank}{name_of(path)}")
            blank = "\n"
        if isinstance(content, Stored):
            describe_stored(content)
        elif isinstance(content, Keypoints):
            _describe_points(content)
        else:
            _describe(content, reader.rates.get(path))


def _load(file: Path | BytesIO, **options: Any) -> Content | Stored:
    """Return the content of a file; of keypoints what is stored, unless names or a layout are given."""
    is_points = not is_robot(_rewind(file)) and has_keypoints(_rewind(file))
    if options["layout"] is None and options["names"] is None and is_points:
        return read_stored(_rewind(file))
    return load_any(_rewind(file), **options)


def _describe(content: Motion | Skeleton, rate: Rate | None) -> None:
    skeleton, root = (content, "root") if isinstance(content, Skeleton) else (content.skeleton, content.root_name)
    if isinstance(content, Motion):
        by = f" by {rate.origin}" if rate is not None and rate.hertz == content.frame_rate else ""
        seconds = len(content) / content.frame_rate
        print(f"{len(content)} frames at {content.frame_rate:g} Hz{by}, {seconds:.2f} s, {content.up} up")
    print(f"{skeleton.n_joints} joints besides the root, {skeleton.n_dofs} degrees of freedom\n")
    width = max(len(name) for name in ("joint", "parent", root, *skeleton.joint_names))
    moves = "rotates about, or slides along" if any(bone.is_slide for bone in skeleton.bones) else "rotates about"
    print(f"{'joint':<{width}}  {'parent':<{width}}  {'bone, m':>8}  {moves}")
    for bone in skeleton.bones:
        length = np.linalg.norm(bone.offset)
        print(f"{bone.name:<{width}}  {bone.parent or root:<{width}}  {length:>8.3f}  {_describe_dofs(bone)}")


def _describe_dofs(bone: Bone) -> str:
    """Return the axes about which a joint rotates; of a hinge about any axis this axis, and the name of its column."""
    if bone.axis is None:
        return bone.dofs or "-"
    return f"{bone.dofs} ({', '.join(f'{x:.3g}' for x in bone.axis)}) {bone.dof_name}"


def _describe_points(points: Keypoints) -> None:
    print(f"{len(points)} frames at {points.frame_rate:g} Hz, {len(points) / points.frame_rate:.2f} s")
    print(f"{len(points.names)} points, {points.up} is up\n")
    width = max(len(name) for name in ("point", *points.names))
    print(f"{'point':<{width}}  not seen")
    for name, confidences in zip(points.names, points.confidences.T, strict=True):
        print(f"{name:<{width}}  {np.mean(confidences == 0.0):>8.1%}")
