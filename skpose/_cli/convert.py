"""`skpose convert`: a motion or keypoints in another format, cut or made a loop."""

import argparse

import skpose
from skpose._cli import options


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = options.add_command(
        subparsers,
        run,
        "convert",
        "convert a motion or keypoints to another format",
        "Write a motion as .bvh for other programs, as .npz without loss, with --smpl as .npz of AMASS, as .npy of "
        "HumanML3D, or as .csv with angles in rad and positions in m. Keypoints can be written as .npz or .csv.",
        "FILE --out FILE",
    )
    parser.add_argument(
        "file", type=options.one_file, metavar="FILE", help="motion, markers or keypoints; -: standard input"
    )
    options.add_out(parser, *options.MOTION_SUFFIXES)
    group = parser.add_argument_group("changes, in this order")
    options.add_part(group, "the result")
    group.add_argument("--rotations", choices=["rotvec"], help="convert Euler angles to ball joints")
    options.add_frame_rate(group)
    group.add_argument("--cycle", action="store_true", help="make a loop that ends with its first pose")
    group.add_argument("--endpoint", action="store_true", help="the loop already ends with its first pose")
    options.add_reading(parser, skip=False)


def run(args: argparse.Namespace) -> None:
    from skpose._cli import files

    ((_, content),) = files.read(args, [args.file], files.load_moving)
    if args.begins is not None or args.ends is not None:
        content = content[files.rows_between(content, args.begins, args.ends)]
    if not isinstance(content, skpose.Motion) and (args.rotations or args.cycle):
        raise ValueError("--rotations and --cycle need a skeleton, got keypoints")
    if args.rotations:
        content = content.to_rotvec()
    content = files.resample(content, args.frame_rate)
    if args.endpoint and not args.cycle:
        raise ValueError("--endpoint needs --cycle")
    if args.cycle:
        content = content.to_cycle(endpoint=args.endpoint)
    files.save_motion(content, args.out, args.out_scale or 1.0, args.smpl)
