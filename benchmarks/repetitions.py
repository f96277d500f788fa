"""Repetitions: how many does `segment_repetitions` find, where are they, and does it find any where nothing repeats?

    python benchmarks/repetitions.py [--hdm05 FOLDER] [--cmu FOLDER] [--quick]

Recordings of six repetitions are made of one person's files of one repetition each, in an order drawn at random, with
pauses between them in which the last pose goes over into the next. The truth is where the files were cut. A repetition
is found if a segment and it have more in common than half of what both take. Without a folder the repetitions are
strides of generated gait, from one flexion of the left knee to the next.

Negative controls are motions in which nothing repeats: white noise, smoothed random walks, smooth noise that stays near
one pose, single files of HDM05, and eight files of eight actions one after the other, without the actions that are
several steps. Walks and runs of CMU, of two or three strides, repeat.
"""

import time
from itertools import pairwise

import common
import numpy as np
from scipy.ndimage import gaussian_filter1d

from skpose import Motion, Skeleton
from skpose.datasets import MotionDataset, humanoid, load_cmu, load_hdm05, make_gait
from skpose.motions import segment_repetitions
from skpose.skeleton._interpolation import interpolate_poses

RATE = 30  # Hz
N_REPETITIONS = 6
PAUSES = (0.5, 1.5)  # s
STEPS = ("jog in a circle", "sneak")  # actions whose files have several steps
LEFT_OUT = ("lie down on floor",)  # one long way down


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


def noise(kind, skeleton, seed):
    """300 poses of a skeleton that are drawn at random, with a standard deviation of 0.3 rad."""
    rng = np.random.default_rng(seed)
    if kind == "white noise":
        poses = rng.normal(size=(300, skeleton.n_dofs))
    elif kind == "smoothed random walk":
        poses = gaussian_filter1d(np.cumsum(rng.normal(size=(300, skeleton.n_dofs)), axis=0), 5, axis=0)
    else:
        poses = gaussian_filter1d(rng.normal(size=(340, skeleton.n_dofs)), 5, axis=0)[20:-20]
    return Motion(skeleton, 0.3 * poses / poses.std(), RATE)


def one_after_the_other(dataset, person, seed):
    """Eight files of eight actions of one person, in random order."""
    rng = np.random.default_rng(seed)
    its_own = dataset[dataset.subjects == person]
    actions = rng.permutation(sorted(set(its_own.actions)))[:8]
    return Motion.concatenate([its_own.motions[rng.choice(np.flatnonzero(its_own.actions == a))] for a in actions])


def controls(hdm05, cmu, n):
    """Yield name, whether the motions repeat, and the motions."""
    skeletons = {"3 dofs": Skeleton.chain(3), "42 dofs": humanoid()}
    for kind in ("white noise", "smoothed random walk", "smooth noise near a pose"):
        for name, skeleton in skeletons.items():
            yield f"{kind}, {name}", False, [noise(kind, skeleton, seed) for seed in range(n)]
    if hdm05 is not None:
        people = sorted(set(hdm05.subjects))
        motions = [one_after_the_other(hdm05, person, seed) for person in people for seed in range(n // 2)]
        yield "HDM05, eight actions", False, motions
        yield "HDM05, single files", False, hdm05.motions
    if cmu is not None:
        for action in ("walk", "run/jog"):
            yield f"CMU, {action}", True, [m.to_rotvec().resample(RATE) for m in cmu[cmu.actions == action]]
    gait = make_gait(n, 1, duration=4, frame_rate=RATE, random_state=0)
    yield "generated gait", True, gait.motions


def print_controls(hdm05, cmu, quick):
    """Print in how many motions something is found; all of it that repeats is, and little of what does not."""
    print(f"\n{'control':<34}{'motions':>8}{'found':>8}{'fitness':>9}{'p, median':>11}{'least':>7}{'time':>10}")
    for name, repeats, motions in controls(hdm05, cmu, 3 if quick else 20):
        start = time.perf_counter()
        found = [segment_repetitions(motion, metric="position", random_state=0) for motion in motions]
        seconds = time.perf_counter() - start
        p = [one.pvalue for one in found]
        share = np.mean([len(one) > 0 for one in found])
        print(
            f"{name:<34}{len(motions):>8}{share:>8.0%}{np.median([one.fitness for one in found]):>9.2f}"
            f"{np.median(p):>11.2f}{min(p):>7.2f}{seconds:>8.1f} s"
        )
        assert share >= 0.9 if repeats else share <= 0.2 or name == "smooth noise near a pose, 3 dofs", name


def main():
    options = common.parser_of_both(__doc__).parse_args()
    common.print_machine()
    hdm05 = None
    if options.hdm05:
        hdm05 = load_hdm05(options.hdm05)
        hdm05 = hdm05[~np.isin(hdm05.actions, STEPS)].to_rotvec()
        hdm05 = MotionDataset([m.resample(RATE) for m in hdm05], hdm05.subjects, actions=hdm05.actions)
        dataset = hdm05[~np.isin(hdm05.actions, LEFT_OUT)]
    else:
        dataset = strides(2 if options.quick else 6)
    cmu = load_cmu(options.cmu) if options.cmu else None
    people = sorted(set(dataset.subjects))[: 2 if options.quick else None]
    actions = sorted(set(dataset.actions))
    print(f"\n{'action':<28}{'true':>6}{'segments':>10}{'found':>8}{'first frame':>13}{'last frame':>12}{'time':>10}")
    for action in actions[: 1 if options.quick else None]:
        n_true, n_segments, errors, seconds = 0, 0, [], 0.0
        for person in people:
            for seed in range(1 if options.quick else 3):
                chosen = dataset[(dataset.subjects == person) & (dataset.actions == action)]
                motion, truth = recording(chosen.motions, np.random.default_rng(seed))
                start = time.perf_counter()
                found = segment_repetitions(motion, metric="position", random_state=0)
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
        if not options.hdm05:
            assert len(errors) / n_true >= 0.8, "generated strides are found"
    print_controls(hdm05, cmu, options.quick)


if __name__ == "__main__":
    main()
