"""Repetitions: how many does `segment_repetitions` find, where are they, and does it find any where nothing repeats?

    python benchmarks/repetitions.py [--hdm05 FOLDER] [--cmu FOLDER] [--quick]

Recordings of six repetitions are made of one person's files of one repetition each, in an order drawn at random, with
pauses between them in which the last pose goes over into the next. The truth is where the files were cut. A repetition
is found if a segment and it have more in common than half of what both take. Without a folder the repetitions are
strides of generated gait, from one flexion of the left knee to the next.

Files are also joined as they are, with Euler angles, without a pause and with two seconds of standing after each: six
of one action; and all files of one action of a person between files of other actions. A recording is right if it has
as many segments as repetitions, and each of these is found. Constants were chosen on two of the people, bd and bk.

Long recordings, of more than the 2,000 frames whose distances are in memory at once, are circles of a chain, generated
walks, and squats at the full rate; the truth is known, and the count must not depend on the length.

Negative controls are motions in which nothing repeats: white noise, smoothed random walks, smooth noise that stays near
one pose, single files of HDM05, and eight files of eight actions one after the other, without the actions that are
several steps. Walks and runs of CMU, of two or three strides, repeat.
"""

import resource
import time
from dataclasses import replace
from itertools import pairwise

import common
import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

from skpose import Motion, Skeleton
from skpose.datasets import MotionDataset, humanoid, load_cmu, load_hdm05, make_gait
from skpose.motions import segment_repetitions
from skpose.skeleton._interpolation import interpolate_poses

RATE = 30  # Hz
N_REPETITIONS = 6
PAUSES = (0.5, 1.5)  # s
STEPS = ("jog in a circle", "sneak")  # actions whose files have several steps
CHOSEN_ON = ("bd", "bk")  # people of HDM05 on whom constants were chosen
STANDING = 2.0  # s
OFTEN = ("squat", "elbow to knee")  # actions that are looked for among others
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


def joined(motions, standing, rate, rng):
    """Motions one after another, each with its last pose for a time after it; and where each begins and ends."""
    parts, truth, at = [], [], 0
    for motion in motions:
        last, n = motion[-1], int(rate * standing)
        sway = 1e-3 * rng.normal(size=(n, motion.skeleton.n_dofs))
        parts += [motion, *[replace(last, angles=last.angles + one) for one in sway]]
        truth.append((at, at + len(motion)))
        at += len(motion) + n
    return Motion.concatenate(parts), np.array(truth)


def off_by(found, truth):
    """How far the first and last frame of each repetition that is found are off."""
    segments = np.stack([found.starts, found.stops], axis=1)
    best = [max(segments, key=lambda other, one=one: overlap(one, other), default=(0, 0)) for one in truth]
    return [np.abs(two - one) for one, two in zip(truth, best, strict=True) if overlap(one, two) > 0.5]


class Sum:
    """Recordings, how many are right, and how far their repetitions are off, summed up."""

    def __init__(self):
        self.n_recordings = self.n_right = self.n_true = self.n_segments = 0
        self.errors = []

    def add(self, found, truth):
        errors = off_by(found, truth)
        self.n_recordings += 1
        self.n_right += len(found) == len(truth) == len(errors)
        self.n_true += len(truth)
        self.n_segments += len(found)
        self.errors += errors

    def __str__(self):
        first, last = np.median(self.errors, axis=0) / RATE if self.errors else (np.nan, np.nan)
        return (
            f"{self.n_right:>6} of {self.n_recordings:<3}{self.n_true:>6}{self.n_segments:>9}"
            f"{len(self.errors) / max(1, self.n_true):>7.0%}{first:>7.2f} s{last:>6.2f} s"
        )


def print_joined(given, quick):
    """Print what is found of files that are joined as they are, by people on whom constants were chosen and others."""
    files = [motion[:: round(motion.frame_rate / RATE)] for motion in given.motions]
    actions = [a for a in sorted(set(given.actions)) if a not in (*STEPS, *LEFT_OUT)]
    people = sorted(set(given.subjects))
    for which, names in (("chosen on", CHOSEN_ON), ("others", [p for p in people if p not in CHOSEN_ON])):
        title = f"{which} ({', '.join(names)})"
        print(f"\n{title:<28}{'standing':<12}{'right':>9}{'true':>9}{'segments':>9}{'found':>7}{'first':>9}{'last':>8}")
        for standing in (0.0, STANDING):
            everything = Sum()
            for action in actions[: 1 if quick else None]:
                of_action = Sum()
                for person in names:
                    its_own = np.flatnonzero((given.subjects == person) & (given.actions == action))
                    for seed in range(1 if quick else 3):
                        rng = np.random.default_rng(seed)
                        chosen = [files[i] for i in rng.permutation(its_own)[:N_REPETITIONS]]
                        motion, truth = joined(chosen, standing, RATE, rng)
                        found = segment_repetitions(motion, random_state=0)
                        of_action.add(found, truth)
                        everything.add(found, truth)
                print(f"{action:<28}{standing:<8.0f}{of_action}")
            print(f"{'all':<28}{standing:<8.0f}{everything}")
        for action in OFTEN[: 0 if quick else None]:
            for person in names:
                rng = np.random.default_rng(0)
                others = [a for a in actions if a not in OFTEN]
                its_own = np.flatnonzero((given.subjects == person) & (given.actions == action))
                firsts = [files[np.flatnonzero((given.subjects == person) & (given.actions == a))[0]] for a in others]
                motion, truth = joined([files[i] for i in its_own], 0.5, RATE, rng)
                half = len(firsts) // 2
                truth += sum(map(len, firsts[:half]))
                among = Sum()
                motion = Motion.concatenate([*firsts[:half], motion, *firsts[half:]])
                among.add(segment_repetitions(motion, random_state=0), truth)
                print(f"{f'{person}, {action}, among others':<36}{among}")


def long_recordings(given, quick):
    """Yield name, motion, its true count, and the metric."""
    chain = Skeleton.chain(3)
    for n, period in ((1000, 25), (2500, 25), (4500, 25), (10_000, 25), (4500, 16.4), (1500, 10.3))[
        : 2 if quick else None
    ]:
        turns = 2 * np.pi * np.arange(n) / period
        poses = np.stack([np.sin(turns), np.cos(turns), 0 * turns], axis=1)
        yield f"circle of {period} frames", Motion(chain, poses, RATE), n / period, "spatial"
    for seconds in (60, 180, 600)[: 0 if quick else None]:
        walk = make_gait(1, 1, activities=["walk"], duration=seconds, frame_rate=RATE, random_state=1)[0]
        knee = np.abs(walk.angles[:, walk.skeleton.dof_names.index("left_shank_rx")])
        yield "generated walk", walk, len(find_peaks(knee, prominence=np.ptp(knee) / 2)[0]), "spatial"
    if given is not None and not quick:
        for person in sorted(set(given.subjects)):
            squats = given[(given.subjects == person) & (given.actions == "squat")].motions
            for standing in (0.0, STANDING):
                motion, truth = joined(squats, standing, squats[0].frame_rate, np.random.default_rng(0))
                yield f"{person}, squats, {standing:.0f} s standing", motion, len(truth), "spatial"


def print_long(given, quick):
    """Print the counts of long recordings; memory is the most that the process has taken so far."""
    columns = f"{'frames':>8}{'true':>8}{'segments':>10}{'median length':>15}{'time':>10}{'memory':>10}"
    print(f"\n{'long recording':<34}{columns}")
    for name, motion, n_true, metric in long_recordings(given, quick):
        start = time.perf_counter()
        found = segment_repetitions(motion, metric=metric, random_state=0)
        seconds = time.perf_counter() - start
        length = np.median(found.stops - found.starts) if len(found) else np.nan
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
        print(
            f"{name:<34}{len(motion):>8}{n_true:>8.1f}{len(found):>10}{length:>15.0f}{seconds:>8.1f} s{memory:>7.2f} GB"
        )
        assert abs(len(found) - n_true) <= 1.5, name


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
    hdm05, given = None, None
    if options.hdm05:
        hdm05 = given = load_hdm05(options.hdm05)
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
    if given is not None:
        print_joined(given, options.quick)
    print_long(given, options.quick)
    print_controls(hdm05, cmu, options.quick)


if __name__ == "__main__":
    main()
