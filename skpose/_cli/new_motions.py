"""Commands that write a motion: a mean, in-betweens, a motion on another skeleton or in another format."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from skpose._cli.browser import show_page
from skpose._cli.colours import print_written
from skpose._cli.contents import Content, load_any
from skpose._cli.inputs import files_in_messages
from skpose._cli.reader import Reader, name_of
from skpose.datasets import MotionDataset
from skpose.geodesics import interpolate
from skpose.io import save_bvh, save_csv, save_npz
from skpose.keypoints import Keypoints
from skpose.kinematics import find_counterparts
from skpose.kinematics._shared import UNCHANGED
from skpose.motions import mean_motion
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import continuous_root_angles, root_orientations
from skpose.view import player

MOST_NAMES = 12  # of joints in a line
NO_SKELETON = (
    "positions of points without a skeleton, and BVH files have one: choose .npz or .csv. In Python "
    "skpose.keypoints.fit_skeleton and skpose.inverse_kinematics find the motion, which save_bvh writes"
)


class Target(NamedTuple):
    """The file that is written, the metres per unit of length in a BVH file, and whether a browser shows the motion."""

    out: Path
    scale: float
    shown: bool = False

    def write(self, content: Motion | Keypoints) -> None:
        """Write what was made, in the format of the suffix, and print what it is."""
        suffix = self.out.suffix.lower()
        if suffix == ".bvh":
            if isinstance(content, Keypoints):
                raise ValueError(f"{self.out}: these are {NO_SKELETON}")
            save_bvh(self.out, content, scale=self.scale)
        elif suffix == ".npz":
            save_npz(self.out, content)
        else:
            save_csv(self.out, content)
        seconds = len(content) / content.frame_rate
        text = f"{len(content)} frames at {content.frame_rate:g} Hz, {seconds:.2f} s, {content.up} up"
        if isinstance(content, Keypoints):
            text += f", {len(content.names)} points"
        elif suffix != ".bvh":  # whose joints may be others, and have three degrees of freedom
            text += (
                f", {content.skeleton.n_joints} joints besides the root, {content.skeleton.n_dofs} degrees of freedom"
            )
        if suffix == ".csv":
            text += "; positions in m" if isinstance(content, Keypoints) else "; positions in m, angles in rad"
        print_written(self.out, text)
        if isinstance(content, Motion) and suffix == ".bvh":
            self._print_what_is_not_stated(content)
        if self.shown:
            show_page(player([content], labels=[self.out.name]))

    def _print_what_is_not_stated(self, motion: Motion) -> None:
        """Print with which option a BVH file is read as it was written, and what it does not keep."""
        if self.scale != 1.0:
            print(f"{self.out}: BVH files do not state their unit; to read it again pass --scale {self.scale:g}")
        if motion.fitted:
            print(
                f"{self.out}: BVH files do not state that poses were fitted to positions, which do not show how limbs "
                "are twisted; .npz files do"
            )


def mean(
    dataset: MotionDataset,
    target: Target,
    *,
    metric: str,
    n_frames: int | None,
    window: float | None,
    cycle: bool,
    endpoint: bool,
    with_root: bool,
    n_jobs: int,
) -> None:
    """Write the mean of motions that have the names of their files; print how much they differ from it.

    `with_root` says that the orientation of the root is a part of the poses; it is given back to the root.
    """
    if len(dataset) < 2:
        raise ValueError(
            f"a mean is of two motions or more, and {dataset.subjects[0]} is one: pass more files; skpose convert "
            "writes one motion"
        )
    with files_in_messages(list(dataset.subjects)):
        found = mean_motion(dataset, metric=metric, n_frames=n_frames, window=window, n_jobs=n_jobs)
    deviation = float(np.sqrt(np.average(found.std**2, weights=found.n_poses)))
    joints = np.sqrt(np.mean(found.joint_std**2, axis=0))
    state = "converged" if found.converged else "not converged"
    plural = "s" if found.n_iter != 1 else ""
    print(f"mean of {len(dataset)} motions, {state} in {found.n_iter} iteration{plural}")
    print(
        f"standard deviation {deviation:.3g} m by {metric}; of a joint at most {joints.max():.3g} m, of "
        f"{found.skeleton.joint_names[int(joints.argmax())]}"
    )
    motion = found.to_motion().without_root() if with_root else found.to_motion()
    target.write(motion.to_cycle(endpoint=endpoint) if cycle else motion)


class Keys(NamedTuple):
    """The key poses of `between`: frames, or times in s; and the time from each to the next, s."""

    frames: list[int] | None
    times: list[float] | None
    seconds: float | None

    def check(self, n_files: int) -> None:
        """Refuse keys that do not go with so many files."""
        n = len(self.frames or self.times or ())
        option = "--times" if self.frames is None else "--frames"
        if n < 2:
            raise ValueError(f"{option} has {n} key pose: pass two or more, with commas between them")
        if n_files > 1 and n != n_files:
            raise ValueError(f"{option} has {n} key poses for {n_files} files: pass one for each file")
        if n_files > 1 and self.seconds is None:
            raise ValueError("poses of several files have no times that go together: pass --seconds, from key to key")

    def rows(self, motions: Sequence[Motion], names: Sequence[str]) -> list[int]:
        """Return the row of each key in its motion."""
        if self.frames is not None:
            found = zip(motions, self.frames, names, strict=True)
            return [_row_of_frame(motion, frame, name) for motion, frame, name in found]
        rows = []
        for motion, time, name in zip(motions, self.times or [], names, strict=True):
            if time > motion.times[-1] + 0.5 / motion.frame_rate:
                raise ValueError(f"{name} has its last frame at {motion.times[-1]:.4g} s, and no pose at {time:g} s")
            rows.append(int(np.abs(motion.times - time).argmin()))
        return rows


def _row_of_frame(motion: Motion, frame: int, name: str) -> int:
    """Return the row of the frame of a number; those below zero count from the end."""
    numbers = motion.frame_numbers
    if frame < 0 and -len(motion) <= frame:
        return len(motion) + frame
    (rows,) = np.nonzero(numbers == frame)
    if not len(rows):
        missing = " without some that are left out" if numbers[-1] >= len(motion) else ""
        raise ValueError(f"{name} has frames 0 to {numbers[-1]}{missing}, and no frame {frame}")
    return int(rows[0])


def between(
    dataset: MotionDataset,
    keys: Keys,
    target: Target,
    *,
    frame_rate: float | None,
    method: str,
    with_root: bool,
    n_jobs: int,
) -> None:
    """Write a motion through key poses: frames of the only motion, or one of each; for `with_root` see `mean`."""
    motions, names = list(dataset), list(dataset.subjects)
    if len(motions) == 1:
        n = len(keys.frames or keys.times or ())
        motions, names = motions * n, names * n
    rows = keys.rows(motions, names)
    if keys.seconds is None:
        times = np.array([motion.times[row] for motion, row in zip(motions, rows, strict=True)])
        if (np.diff(times) <= 0.0).any():
            raise ValueError("key poses must follow each other in time: sort them, or pass --seconds, from key to key")
    else:
        times = np.arange(len(rows)) * keys.seconds
    poses = _join([motion[row] for motion, row in zip(motions, rows, strict=True)], names)
    rate = motions[0].frame_rate if frame_rate is None else frame_rate
    motion = interpolate(poses, times, frame_rate=rate, method=method, n_jobs=n_jobs)
    width = max(len(name) for name in ("file", *names))
    print(f"{'key':>6}  {'file':<{width}}  {'frame':>8}  {'its time, s':>12}  {'time, s':>10}")
    for i, (name, one, row) in enumerate(zip(names, motions, rows, strict=True)):
        its = f"{one.frame_numbers[row]:>8}  {one.times[row]:>12.3f}"
        print(f"{i:>6}  {name:<{width}}  {its}  {times[i] - times[0]:>10.3f}")
    target.write(motion.without_root() if with_root else motion)


def _join(poses: Sequence[Motion], names: Sequence[str]) -> Motion:
    """Return key poses as one motion."""
    first = poses[0]
    for name, pose in zip(names, poses, strict=True):
        if pose.up != first.up:
            raise ValueError(
                f"{names[0]} has {first.up} up and {name} {pose.up}: pass --up if both are in one world, or convert one"
            )
    if len({pose.root_axes for pose in poses}) > 1:
        poses = [_about_xyz(pose) for pose in poses]
    return Motion.concatenate(replace(pose, frame_rate=first.frame_rate) for pose in poses)


def _about_xyz(pose: Motion) -> Motion:
    """Return the motion with the root's angles about the axes "xyz"."""
    angles, axes = continuous_root_angles(root_orientations(pose.root_angles, pose.root_axes), "xyz")
    return replace(pose, root_angles=angles, root_axes=axes)


def read_skeleton(path: Path, reader: Reader) -> Skeleton:
    """Return the skeleton of a file."""
    ((_, content),) = reader.read([path], load_any, required=1)
    if isinstance(content, Keypoints):
        raise ValueError(f"{name_of(path)} has positions of points, and no skeleton")
    return content if isinstance(content, Skeleton) else content.skeleton


def retarget(
    names: Sequence[str],
    motions: Sequence[Motion],
    skeleton: Skeleton,
    target: Target | None,
    *,
    method: Any,
    joints: Mapping[str, str] | None,
    factor: float | Literal["lengths"] | None,
    n_jobs: int,
) -> None:
    """Print how each motion comes onto a skeleton, and write the only one if there is a target."""
    for name, motion in zip(names, motions, strict=True):
        with _options_in_messages(name):
            if method == "limbs" or (method == "auto" and _has_hinges(skeleton) and not _has_hinges(motion.skeleton)):
                from skpose.robots._retarget import retarget_and_report

                scale = None if factor is None or factor == "lengths" else factor
                there, report = retarget_and_report(motion, skeleton, joints, scale, "enforce")
            else:
                dataset = MotionDataset([motion]).retarget(
                    skeleton, method=method, joints=joints, scale=factor, n_jobs=n_jobs
                )
                (there,), (report,) = dataset.motions, dataset.retargeting
        print(f"{name}: by {report}")
        if report != UNCHANGED and not report.startswith("limbs"):  # which says what stays at rest
            have = find_counterparts(motion.skeleton, skeleton) if joints is None else joints
            alone = [joint for joint in skeleton.joint_names if joint not in have]
            if alone:
                more = f" and {len(alone) - MOST_NAMES} more" if len(alone) > MOST_NAMES else ""
                print(f"    without a counterpart: {', '.join(alone[:MOST_NAMES])}{more}")
        if target is not None:
            target.write(there)


def _has_hinges(skeleton: Skeleton) -> bool:
    return any(bone.is_hinge for bone in skeleton.bones)


@contextmanager
def _options_in_messages(name: str) -> Iterator[None]:
    """Name the file and the option in the errors of `MotionDataset.retarget`."""
    with files_in_messages([name]):
        try:
            yield
        except ValueError as error:
            message = str(error).replace('scale="lengths"', "--factor lengths")
            message = message.replace("skeleton.joint_names are its joints", "skpose info prints its joints")
            message = message.replace("joints maps", "--joints maps").replace("but the motion's has", "but FILE has")
            message = message.replace("the given skeleton", "OTHER")
            raise ValueError(message) from None


def convert(
    path: Path, reader: Reader, target: Target, frame_rate: float | None, rotations: Literal["rotvec"] | None
) -> None:
    """Write the content of a file in the format of another."""
    ((_, content),) = reader.read([path], load_any)
    target.write(_prepare(content, name_of(path), frame_rate, rotations))


def _prepare(
    content: Content, name: str, frame_rate: float | None, rotations: Literal["rotvec"] | None
) -> Motion | Keypoints:
    """Return a motion as the options have it, or keypoints; refuse skeletons."""
    if isinstance(content, Skeleton):
        raise ValueError(
            f"{name} is a skeleton (ASF or a robot), which has no motion: pass a motion, such as its AMC file"
        )
    if isinstance(content, Keypoints):
        for option, value in (("--frame-rate", frame_rate), ("--rotations", rotations)):
            if value is not None:
                raise ValueError(f"{option} is for motions, and {name} has positions of points: leave it out")
        return content
    content = content.to_rotvec() if rotations == "rotvec" else content
    return content if frame_rate is None else content.resample(frame_rate)
