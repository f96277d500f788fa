"""`skpose retarget`: a motion on the skeleton of another file, which may be a robot."""

import argparse

import skpose
from skpose._cli import options


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = options.add_command(
        subparsers,
        run,
        "retarget",
        "retarget a motion to the skeleton of another file",
        "Retarget a motion to another skeleton. Print the method, the number of matched joints and the "
        "remaining error; without --out nothing is written. Methods: auto, the first that works; numbers, copy the "
        "angles; orientations, match bone directions; positions, match joint positions; limbs, onto a robot within its "
        "joint limits; unchecked, copy the angles without checks.",
        "FILE --onto OTHER",
    )
    options.add_files(parser, "a motion, or several without --out")
    add = parser.add_argument
    add(
        "--onto",
        type=options.one_file,
        required=True,
        metavar="OTHER",
        help="target: a motion, ASF file or robot (required)",
    )
    options.add_out(parser, *options.MOTION_SUFFIXES, required=False)
    add(
        "--method",
        choices=["auto", "numbers", "orientations", "positions", "limbs", "unchecked"],
        default="auto",
        metavar="NAME",
        help="method, see above; default: auto",
    )
    add(
        "--joints",
        type=_pair,
        nargs="+",
        metavar="OTHER=FILE",
        help="target=source, such as left_knee=LeftLeg; left_hand= stays at rest",
    )
    add(
        "--factor",
        type=lambda text: text if text == "lengths" else options.positive(text),
        metavar="F",
        help="scale positions by F; lengths: by bone lengths; default: by legs",
    )
    options.add_frame_rate(parser)
    options.add_jobs(parser)
    options.add_reading(parser)


def run(args: argparse.Namespace) -> None:
    from skpose._cli import files
    from skpose.datasets._folder import find_files

    paths = find_files(args.files)
    if args.out is not None and len(paths) > 1:
        raise ValueError(f"--out is for one motion, got {len(paths)} files")
    ((name, target),) = files.read(args, [args.onto], required=1)
    if isinstance(target, skpose.Keypoints):
        raise ValueError(f"{name} has points but no skeleton")
    for name, motion in files.read(args, paths, files.load_poses):
        moved, report = _retarget(files.resample(motion, args.frame_rate), target, args)
        print(f"{name}: by {report}")
        if args.out is not None:
            unit = args.scale if args.onto.suffix.lower() == ".bvh" and args.scale != "auto" else None  # the target's
            files.save_motion(moved, args.out, args.out_scale or unit or 1.0, args.smpl)


def _retarget(
    motion: "skpose.Motion", target: "skpose.Motion | skpose.Skeleton", args: argparse.Namespace
) -> tuple["skpose.Motion", str]:
    """The motion on the skeleton of another motion, or on a robot, and a report."""
    from skpose.kinematics._retarget import retarget_and_report
    from skpose.robots._retarget import retarget_and_report as retarget_to_robot

    joints = None if args.joints is None else dict(args.joints)
    skeleton = target.skeleton if isinstance(target, skpose.Motion) else target
    onto_robot = any(bone.is_hinge for bone in skeleton.bones) and not any(b.is_hinge for b in motion.skeleton.bones)
    if args.method == "limbs" or (args.method == "auto" and onto_robot):
        scale = None if args.factor == "lengths" else args.factor
        return retarget_to_robot(motion, skeleton, joints, scale)
    return retarget_and_report(motion, target, args.method, joints, args.factor, "ignore", args.jobs, 0)


def _pair(text: str) -> tuple[str, str | None]:
    name, sign, counterpart = text.partition("=")
    if not (name and sign):
        raise argparse.ArgumentTypeError(f"expected two joints, as left_knee=LeftLeg, got {text!r}")
    return name, counterpart or None
