"""`skpose info`: contents of files."""

import argparse

import skpose
from skpose._cli import options


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = options.add_command(
        subparsers,
        run,
        "info",
        "print the contents of files",
        "Print frames, frame rate, joints and degrees of freedom of motions, skeletons and robots, or "
        "points and the share of frames in which each is missing.",
        "FILE...",
    )
    options.add_files(parser, "motions, skeletons, robots, markers or keypoints")
    options.add_reading(parser)


def run(args: argparse.Namespace) -> None:
    from skpose._cli.files import MOVING, read

    contents = read(args, args.files, suffixes=(*MOVING, ".asf"))
    for i, (name, content) in enumerate(contents):
        if len(contents) > 1:
            print("\n" * (i > 0) + name)
        if isinstance(content, skpose.Keypoints):
            _print_points(content)
        else:
            _print_skeleton(content)


def _print_skeleton(content: "skpose.Motion | skpose.Skeleton") -> None:
    from skpose.kinematics._anatomy import describe_joints

    if isinstance(content, skpose.Skeleton):
        skeleton, root = content, "root"
    else:
        skeleton, root = content.skeleton, content.root_name
        seconds = len(content) / content.frame_rate
        print(f"{len(content)} frames at {content.frame_rate:g} Hz, {seconds:.2f} s, {content.up} up")
    print(f"{skeleton.n_joints} joints besides the root, {skeleton.n_dofs} degrees of freedom\n")
    width = max(len(name) for name in ("joint", "parent", root, *skeleton.joint_names))
    places, reason = describe_joints(skeleton)
    place = max(len("of a person"), *map(len, places))
    moves = "rotates about, or slides along" if any(bone.is_slide for bone in skeleton.bones) else "rotates about"
    print(f"{'joint':<{width}}  {'parent':<{width}}  {'bone, m':>8}  {'of a person':<{place}}  {moves}")
    for bone, at in zip(skeleton.bones, places, strict=True):
        length = sum(x * x for x in bone.offset) ** 0.5
        print(f"{bone.name:<{width}}  {bone.parent or root:<{width}}  {length:>8.3f}  {at:<{place}}  {_dofs(bone)}")
    if reason:
        print(f"\nunlike a person: {reason}")


def _dofs(bone: "skpose.Bone") -> str:
    if bone.axis is None:
        return bone.dofs or "-"
    return f"{bone.dofs} ({', '.join(f'{x:.3g}' for x in bone.axis)}) {bone.dof_name}"


def _print_points(points: "skpose.Keypoints") -> None:
    print(f"{len(points)} frames at {points.frame_rate:g} Hz, {len(points) / points.frame_rate:.2f} s")
    print(f"{len(points.names)} points, {points.up} up\n")
    width = max(len(name) for name in ("point", *points.names))
    print(f"{'point':<{width}}   missing")
    for name, confidences in zip(points.names, points.confidences.T, strict=True):
        print(f"{name:<{width}}  {(confidences == 0.0).mean():>8.1%}")
