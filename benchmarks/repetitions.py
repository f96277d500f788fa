"""Repetitions: how many does `segment_repetitions` find, and how precise are their first and last frames?

    python benchmarks/repetitions.py [FOLDER OF HDM05 FILES] [--quick]

Recordings of six repetitions are made of one person's files of one repetition each, in an order drawn at random, with
pauses between them in which the last pose goes over into the next. The truth is where the files were cut. A repetition
is found if a segment and it have more in common than half of what both take. Without a folder the repetitions are
strides of generated gait, from one flexion of the left knee to the next.
"""

import time
from itertools import pairwise

import common
import numpy as np

from skpose import Motion
from skpose.datasets import MotionDataset, load_hdm05, make_gait
from skpose.motions import segment_repetitions
from skpose.skeleton._interpolation import interpolate_poses

RATE = 30  # Hz
N_REPETITIONS = 6
PAUSES = (0.5, 1.5)  # s
LEFT_OUT = ("jog in a circle", "sneak", "lie down on floor")  # files of several steps, or of one long way down


def strides(n_subjects):
    """Strides of generated walks, each a motion of its own, from one flexion of the knee to the next."""
    motions, subjects = [], []
    gait = make_gait(n_subjects, 1, activities=["walk"], duration=10, frame_rate=RATE, random_state=0)
    for walk, subject in zip(gait.motions, gait.subjects, strict=True):
        knee = walk.angles[:, walk.skeleton.dof_names.index("left_shank_rx")]
        tops = [i for i in range(10, len(knee) - 10) if knee[i] == knee[i - 10 : i + 11].max()]
        cut = [walk[first:last] for first, last in pairwise(tops)]
        motions += cut
        subjects += [subject] * len(cut)
    return MotionDataset(motions, subjects, actions=["walk"] * len(motions))


def recording(motions, rng):
    """Motions one after another with pauses between them; and the first frame of each and the one behind its last."""
    chosen = [motions[i] for i in rng.permutation(len(motions))[:N_REPETITIONS]]
    parts, truth, at = [], [], 0
    for motion, after in zip(chosen, [*chosen[1:], None], strict=True):
        parts.append(motion.angles)
        truth.append((at, at + len(motion)))
        if after is not None:
            n = int(RATE * rng.uniform(*PAUSES))
            ends = np.stack([motion.angles[-1], after.angles[0]])
            parts.append(interpolate_poses(motion.skeleton.bones, ends, np.linspace(0, 1, n + 2)[1:-1]))
            at += n
        at += len(motion)
    return Motion(chosen[0].skeleton, np.concatenate(parts), RATE), np.array(truth)


def overlap(a, b):
    """What two segments have in common, as a share of what both take."""
    return max(0, min(a[1], b[1]) - max(a[0], b[0])) / (max(a[1], b[1]) - min(a[0], b[0]))


def main():
    options = common.start(__doc__)
    if options.folder:
        dataset = load_hdm05(options.folder)
        dataset = dataset[~np.isin(dataset.actions, LEFT_OUT)].to_rotvec()
    else:
        dataset = strides(2 if options.quick else 6)
    people = sorted(set(dataset.subjects))[: 2 if options.quick else None]
    actions = sorted(set(dataset.actions))
    print(f"\n{'action':<28}{'true':>6}{'segments':>10}{'found':>8}{'first frame':>13}{'last frame':>12}{'time':>10}")
    for action in actions[: 1 if options.quick else None]:
        n_true, n_segments, errors, seconds = 0, 0, [], 0.0
        for person in people:
            for seed in range(1 if options.quick else 3):
                chosen = dataset[(dataset.subjects == person) & (dataset.actions == action)]
                motion, truth = recording([m.resample(RATE) for m in chosen], np.random.default_rng(seed))
                start = time.perf_counter()
                found = segment_repetitions(motion, metric="position")
                seconds += time.perf_counter() - start
                segments = np.stack([found.starts, found.stops], axis=1)
                n_true += len(truth)
                n_segments += len(segments)
                for one in truth:
                    best = max(segments, key=lambda other, one=one: overlap(one, other), default=(0, 0))
                    if overlap(one, best) > 0.5:
                        errors.append(np.abs(best - one) / RATE)
        first, last = np.median(errors, axis=0) if errors else (np.nan, np.nan)
        print(
            f"{action:<28}{n_true:>6}{n_segments:>10}{len(errors) / n_true:>8.0%}{first:>11.2f} s{last:>10.2f} s"
            f"{seconds:>8.1f} s"
        )
        if not options.folder:
            assert len(errors) / n_true >= 0.8, "generated strides are found"


if __name__ == "__main__":
    main()
