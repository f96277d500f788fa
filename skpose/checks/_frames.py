"""Faults in time: frames that are missing, repeated or made up, jumps, noise, and angles that change their branch."""

from collections.abc import Iterator

import numpy as np
from scipy.ndimage import median_filter

from skpose.checks._findings import Found, check, limit
from skpose.checks._recording import Recording
from skpose.kinematics._ground import runs

AROUND = 0.15  # s, before and after a frame, of what is usual there
EVENT = 0.25  # s, between two events
SAME = 1e-9  # m, largest movement of a frame that repeats the one before
NORMAL = 6.9  # √20 times the median length of a normal vector in space: of third differences of white noise


@check("missing frames", "warning", "cut the recording there, or fill the gap")
def missing_frames(recording: Recording) -> Iterator[Found]:
    lengths = np.diff(recording.motion.frame_numbers) - 1
    if lengths.any():
        most = int(lengths.argmax())
        what = f"{lengths.sum()} frames are missing, {lengths.max()} of them after frame {most}"
        yield Found(float(lengths.sum()), "frames", what, (most, most + 2))
    seen = recording.motion.seen
    if seen is not None and not seen.all():
        worst = np.argsort(seen.mean(axis=0))[:3]
        joints = tuple(recording.skeleton.joint_names[j] for j in worst)
        share = 100.0 * float(1.0 - seen.mean())
        yield Found(share, "%", f"{share:.3g} % of the joints are not seen", None, joints)


@check("repeated frames", "error", "drop the repeated frames, or resample from the true frame rate")
def repeated_frames(recording: Recording) -> Iterator[Found]:
    still = (np.abs(np.diff(recording.points, axis=0)).max(axis=(1, 2)) <= SAME) & ~recording.gaps
    found = runs(still)
    if found and (len(still) > 1 or still.all()):
        first, end = max(found, key=lambda run: run[1] - run[0])
        n, longest = int(still.sum()), end - first
        what = f"{n} of {len(still) + 1} frames repeat the one before, at most {longest} in a row"
        yield Found(float(n), "frames", what, (first, end + 1))


@check("interpolated frames", "warning", "leave these frames out, or resample to the true frame rate")
def interpolated_frames(recording: Recording) -> Iterator[Found]:
    """The root, or all angles, change at a constant rate."""
    for values in (recording.motion.root_positions, recording.unwrapped):
        steps = np.diff(values, axis=0)
        size, change = np.abs(steps).sum(axis=1), np.abs(np.diff(steps, axis=0)).sum(axis=1)
        linear = change < limit("linear") * size[1:]
        if (n := int(linear.sum())) >= limit("made up"):
            first, end = max(runs(linear), key=lambda run: run[1] - run[0])
            what = f"{n} of {len(values)} frames are on straight lines between their neighbours"
            yield Found(float(n), "frames", what, (first, end + 2))
            return


def _sudden(points: np.ndarray, recording: Recording) -> np.ndarray:
    """How much each step (n_frames − 1, n_points) differs from those around it, m, where that is sudden; else 0."""
    steps = np.diff(points, axis=0)
    padded = np.concatenate([steps[1:2], steps, steps[-2:-1]])
    off = np.linalg.norm(steps - (padded[:-2] + padded[2:]) / 2.0, axis=2)
    for beside in (-1, 0, 1):  # a gap is no jump
        off[np.clip(np.flatnonzero(recording.gaps) + beside, 0, len(off) - 1)] = 0.0
    usual = median_filter(off, size=(2 * max(3, round(AROUND / recording.step)) + 1, 1), mode="nearest")
    least = np.maximum(limit("jump") + limit("jerk") * recording.step**3, limit("sudden") * usual)
    return np.where(off > least, off, 0.0)


def _events(off: np.ndarray, recording: Recording) -> Iterator[tuple[int, int, np.ndarray]]:
    """The first and last step of each event, and the largest size for each point."""
    steps = np.flatnonzero(off.any(axis=1))
    apart = np.flatnonzero(np.diff(steps) * recording.step > EVENT)
    for part in np.split(steps, apart + 1) if len(steps) else ():
        yield int(part[0]), int(part[-1]), off[part].max(axis=0)


def _is_spike(points: np.ndarray, first: int, last: int) -> bool:
    """Whether points (n_frames, 3) return after the steps from first to last."""
    before, after = points[max(first - 1, 0)], points[min(last + 2, len(points) - 1)]
    away = np.linalg.norm(points[first + 1 : last + 1] - (before + after) / 2.0, axis=1).max(initial=0.0)
    return bool(away > np.linalg.norm(after - before))


@check("root jump", "error", "cut the recording there, or interpolate the frames")
def root_jumps(recording: Recording) -> Iterator[Found]:
    if len(recording.motion) > 3:
        root = recording.points[:, :1]
        for first, last, sizes in _events(_sudden(root, recording), recording):
            size = float(sizes[0]) * recording.scale
            word = "leaves its path by" if _is_spike(root[:, 0], first, last) else "jumps by"
            yield Found(size, "m", f"the root {word} {size:.2g} m after frame {first}", (first, last + 2), ("root",))


@check("joint jump", "error", "interpolate the frames, or cut the recording there")
def joint_jumps(recording: Recording) -> Iterator[Found]:
    if len(recording.motion) > 3:
        joints = recording.around_root[:, 1:]
        for first, last, sizes in _events(_sudden(joints, recording), recording):
            order = np.argsort(-sizes)
            worst, size = int(order[0]), float(sizes.max()) * recording.scale
            names = tuple(recording.skeleton.joint_names[j] for j in order[:3] if sizes[j] > 0.0)
            word = "leaves its path by" if _is_spike(joints[:, worst], first, last) else "jumps by"
            what = f"{names[0]} {word} {size:.2g} m after frame {first}"
            yield Found(size, "m", what, (first, last + 2), names)


@check("noise", "warning", "filter the positions or angles, such as with a low-pass at 10 Hz")
def noise(recording: Recording) -> Iterator[Found]:
    if len(recording.motion) < 12:
        return
    first, third = (np.linalg.norm(np.diff(recording.around_root, n=n, axis=0), axis=2) for n in (1, 3))
    sizes = np.median(third, axis=0) / NORMAL
    least = limit("noise") + limit("rough") * recording.step
    noisy = sizes > least + limit("fast") * recording.step * np.median(first, axis=0)
    if noisy.any():
        order = np.argsort(-sizes * noisy)[: min(3, noisy.sum())]
        size = 1e3 * float(sizes.max()) * recording.scale
        names = tuple(recording.names[j] for j in order)
        yield Found(size, "mm", f"{names[0]} has noise of some {size:.2g} mm", None, names)


@check("angle flips", "note", "motion.unwrap() or motion.to_rotvec() before angles are filtered, averaged or learnt")
def angle_flips(recording: Recording) -> Iterator[Found]:
    motion = recording.motion
    off = np.concatenate([motion.angles, motion.root_angles], axis=1) - recording.unwrapped
    flips = np.abs(np.diff(off, axis=0)) > limit("flip")
    if flips.any():
        names = [*motion.skeleton.dof_names, *(f"root_{axis}" for axis in motion.root_axes)]
        columns, rows = np.flatnonzero(flips.any(axis=0)), np.flatnonzero(flips.any(axis=1))
        what = f"{len(columns)} angles change by whole turns or to the other Euler triple, at {len(rows)} frames"
        joints = tuple(names[c] for c in columns[:3])
        yield Found(float(len(rows)), "frames", what, (int(rows[0]), int(rows[0]) + 2), joints)
