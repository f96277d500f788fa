"""The path of the root by which the feet of a person of another size stand where the motion's stand."""

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from skpose.kinematics._anatomy import ANKLE, BALL, HIP, SIDES, TOE, Anatomy, path_up
from skpose.skeleton import Motion, Skeleton

LOW, SLOW = 0.08, 0.5  # leg lengths above the lowest point, and leg lengths per second, of a foot that stands
STANDS, LEAST = 0.5, 1e-3  # weights of a foot that stands, and of one that does not
SMOOTH = 0.05  # s, standard deviation of the mean over time
EXACT = 1e-9  # of a leg length: smaller shifts are rounding errors


def leg_length(skeleton: Skeleton, person: Anatomy) -> float:
    """The length of the bones from hip to ankle, m, mean of both sides; 0 without legs."""
    found, lengths = [], np.linalg.norm(skeleton.offsets, axis=1)
    for side in SIDES:
        hip, ankle = (person.joints.get(f"{side}_{mark}", -1) for mark in (HIP, ANKLE))
        path = path_up(skeleton, ankle)
        found.append(lengths[path[: path.index(hip)]].sum() if hip in path else 0.0)
    return float(np.mean(found)) if all(found) else 0.0


def keep_feet(
    motion: Motion, result: Motion, people: tuple[Anatomy, Anatomy], factor: float
) -> tuple[Motion, float | None]:
    """Move the root of a result such that the feet that stand are where the motion's are, times a factor.

    Between the feet the shift is the mean weighted by how low and slow each is, smoothed in time. The lowest joints of the
    feet are as high as the motion's, in the median. The second value is
    the largest distance of a standing foot from its place, m; None if no foot stands.
    """
    if not len(motion):
        return result, None
    leg, up = leg_length(motion.skeleton, people[0]), "xyz".index(motion.up)
    positions, joints = (factor * motion.positions(), result.positions()), [person.joints for person in people]
    stood = next(part for part in (BALL, ANKLE) if all(f"{side}_{part}" in each for each in joints for side in SIDES))
    theirs, ours = (
        each[:, [marks[f"{side}_{stood}"] for side in SIDES]] for each, marks in zip(positions, joints, strict=True)
    )
    heights = theirs[:, :, up] - theirs[:, :, up].min()
    speeds = np.linalg.norm(np.gradient(theirs, motion.times, axis=0), axis=2) if len(motion) > 1 else 0.0 * heights
    stands = np.exp(-((heights / (LOW * factor * leg)) ** 2) - (speeds / (SLOW * factor * leg)) ** 2)
    weights = (stands + LEAST)[..., None]
    apart = theirs - ours
    shift = (weights * apart).sum(axis=1) / weights.sum(axis=1)
    shift = gaussian_filter1d(shift, SMOOTH * motion.frame_rate, axis=0, mode="nearest")
    lowest = [
        each[:, [j for mark, j in marks.items() if mark.endswith((ANKLE, BALL, TOE))], up].min(axis=1)
        for each, marks in zip(positions, joints, strict=True)
    ]
    shift[:, up] += np.median(lowest[0] - lowest[1] - shift[:, up])
    off = np.linalg.norm(apart - shift[:, None], axis=2)[stands > STANDS]
    if np.abs(shift).max(initial=0.0) > EXACT * leg:
        result = replace(result, root_positions=result.root_positions + shift)
    return result, float(off.max()) if len(off) else None
