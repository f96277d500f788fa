"""Judging generated motion: what do distances between sets of motions find, and which metric finds jitter of 2 mm?

    python benchmarks/generated.py --cmu FOLDER_OF_CMU_FILES --hdm05 FOLDER_OF_HDM05_FILES [--quick]

Real motions are on ball joints, at 30 Hz. In the place of a generator, whose faults nobody knows, stand real motions
with one known fault. Faults of positions are added to the joint positions in the axes of the root, on the skeleton of
the person; inverse kinematics makes poses of them, which start from the real pose of the frame and stay near to it in
what positions do not show, so that a fault of zero leaves the motion as it is.

Jitter is independent noise of each coordinate, joint and frame, with standard deviations of 1 to 20 mm. The other
faults: smooth jitter of 20 mm, which is Gaussian noise filtered in time with σ = 0.1 s; positions averaged over half a
second; one frame held for the whole motion; the motion backwards; at half the speed; each second frame shown twice; the
mean motion of the training people's motions, one for each action; a root that slides through the room at 0.3 m/s, which
no metric measures.

Each person with eight motions or more is left out once; Y is the real motions of all other people, who train, and their
mean skeleton is the one on which all is compared. Nothing else is learnt from them but, in the row "chosen", the
metric: the one that has the largest area for 2 mm when each training person is left out from the others.

1. Curve: a person's motions with jitter against the same motions without, mean over the people. Controls: no jitter,
   and the same person's real motions against the other people's.
2. AUC, of single motions: the area under the curve of the statistic of `outlier_test` against Y, between the person's
   real motions and those with a fault: 1 finds all, 0.5 none; below 0.5 the fault makes a motion more usual. Mean over
   the people left out, and the least of them.
3. The share of p-values of 0.05 or less, of the person's real motions and of those with jitter of 2 mm: how far new
   people are from being exchangeable with the training people.
4. AUC, of sets of five motions of the person, drawn at random, by both statistics of `two_sample_test` against 40
   motions of Y: real sets against sets with a fault. "the same five times" is one real motion in the place of all five.

"spatial", which takes some thirty times as long as "position", is in 2. and 3. alone; 4. has four metrics.
"""

import time
from dataclasses import replace

import common
import numpy as np
from scipy.ndimage import gaussian_filter1d, uniform_filter1d
from sklearn.metrics import roc_auc_score

from skpose import forward_kinematics, inverse_kinematics
from skpose.datasets import make_gait
from skpose.kinematics import retarget
from skpose.metrics import Jerk, Velocity
from skpose.motions import mean_motion
from skpose.statistics import outlier_test, two_sample_test

RATE = 30.0  # Hz
REGULARIZATION = 0.02  # m/rad
LEVELS = (0.001, 0.002, 0.005, 0.01, 0.02)  # m
SOUGHT = "2 mm"
METRICS = {
    "angle": "angle",
    "position": "position",
    "rotation": "rotation",
    "spatial": "spatial",
    "velocity, 0.25 s": Velocity(0.25),
    "velocity, two frames": Velocity(2 / RATE),
    "jerk": Jerk(),
}
OF_SETS = ("angle", "position", "velocity, 0.25 s", "jerk")
STATISTICS = ("energy", "mmd")
FEWEST = 8  # motions of a person who is left out
OF_A_SET, IN_Y, N_DRAWS = 5, 40, 20
JITTER = tuple(f"{1e3 * level:g} mm" for level in LEVELS)
MEAN = "mean motion"


# --- motions with faults ---------------------------------------------------------------------------------------------


def moved(motion, positions):
    """Return the motion whose joints are as near to these positions as its bones allow."""
    found = inverse_kinematics(positions, motion.skeleton, initial=motion.angles, regularization=REGULARIZATION)
    return replace(motion, angles=found.poses)


def with_frames(motion, angles):
    """Return a motion of these poses, without the root, which is no part of a distance."""
    numbers = np.arange(len(angles))
    return replace(motion, angles=angles, frame_numbers=numbers, root_positions=None, root_angles=None)


def smooth_noise(rng, shape):
    """Return noise of unit variance whose times are correlated over 0.1 s."""
    width = 0.1 * RATE
    margin = int(5 * width)
    noise = gaussian_filter1d(rng.normal(size=(shape[0] + 2 * margin, *shape[1:])), width, axis=0)
    return noise[margin:-margin] * np.sqrt(2.0 * np.sqrt(np.pi) * width)


def faults(motion, rng):
    """Return the motion with each fault but the mean motion, by name."""
    positions = forward_kinematics(motion.angles, motion.skeleton).reshape(len(motion), -1, 3)
    n, angles = len(motion), motion.angles
    found = {name: moved(motion, positions + rng.normal(0.0, level, positions.shape)) for name, level in of_levels()}
    found["smooth, 20 mm"] = moved(motion, positions + 0.02 * smooth_noise(rng, positions.shape))
    averaged = uniform_filter1d(positions, int(0.5 * RATE) | 1, axis=0, mode="nearest")
    found["averaged"] = moved(motion, averaged)
    found["one frame"] = with_frames(motion, np.repeat(angles[n // 2][None], n, axis=0))
    found["backwards"] = with_frames(motion, angles[::-1])
    found["half speed"] = with_frames(motion, motion.resample(2 * RATE).angles)
    found["frames twice"] = with_frames(motion, angles[np.arange(n) // 2 * 2])
    drift = 0.3 / RATE * np.arange(n)[:, None] * [1.0, 0.0, 0.0]
    root = np.zeros((n, 3)) if motion.root_positions is None else motion.root_positions
    found["sliding"] = replace(motion, root_positions=root + drift)
    return found


def of_levels():
    return zip(JITTER, LEVELS, strict=True)


def mean_motions(training):
    """Return the mean motion of each action that the training people do twice or more."""
    own = [list(training[training.actions == action]) for action in sorted(set(training.actions))]
    means = [mean_motion(some, skeleton=training.skeleton, metric="position") for some in own if len(some) > 1]
    return [mean.to_motion() for mean in means]


# --- the four parts --------------------------------------------------------------------------------------------------


class Fold:
    """A person who is left out: real motions, those with faults, and the other people's."""

    def __init__(self, dataset, broken, person):
        own = dataset.subjects == person
        self.person, self.skeleton = person, dataset[~own].skeleton

        def on_it(motions):
            return [retarget(motion, self.skeleton, method="numbers") for motion in motions]

        self.real, self.training = on_it(dataset[own]), dataset[~own]._with(on_it(dataset[~own]))
        self.broken = {name: on_it(broken[i][name] for i in np.flatnonzero(own)) for name in broken[0]}

    def areas(self, metric, names):
        """AUC of each fault, and the p-values of real motions and of those with the fault that is sought."""
        tested = [self.real, *(self.broken[name] for name in names)]
        everything = [motion for some in tested for motion in some]
        found = outlier_test(everything, list(self.training), skeleton=self.skeleton, metric=metric, n_jobs=-1)
        ends = np.cumsum([len(some) for some in tested])[:-1]
        real, *others = np.split(found.statistic, ends)
        pvalues = dict(zip(["real", *names], np.split(found.pvalue, ends), strict=True))
        return {name: area(real, other) for name, other in zip(names, others, strict=True)}, pvalues

    def distance(self, X, Y, metric, statistic):
        """The statistic between two sets."""
        options = {"skeleton": self.skeleton, "metric": metric, "statistic": statistic}
        return two_sample_test(X, Y, n_permutations=1, random_state=0, n_jobs=-1, **options).statistic


def area(real, broken):
    truth = np.repeat([0, 1], [len(real), len(broken)])
    return roc_auc_score(truth, np.concatenate([real, broken]))


def left_out(dataset, broken):
    """Return the folds: one for each person with enough motions."""
    people = [person for person in sorted(set(dataset.subjects)) if np.sum(dataset.subjects == person) >= FEWEST]
    return [Fold(dataset, broken, person) for person in people]


def table(title, columns, rows):
    """Print a table of Markdown; rows are a name and one text a column."""
    print(f"\n{title}\n\n| | {' | '.join(columns)} |\n|{'---|' * (len(columns) + 1)}")
    for name, *cells in rows:
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


def curve(folds, metrics):
    """Print the statistics of sets with jitter."""
    found = {}

    def rows():
        for statistic in STATISTICS:
            for label, metric in metrics.items():
                if label == "spatial":
                    continue
                columns = []
                for name in ("none", *JITTER):
                    sets = [(fold, fold.real if name == "none" else fold.broken[name], fold.real) for fold in folds]
                    columns.append(np.mean([fold.distance(X, Y, metric, statistic) for fold, X, Y in sets]))
                others = [fold.distance(fold.real, list(fold.training), metric, statistic) for fold in folds]
                found[statistic, label] = np.array(columns), np.mean(others)
                cells = [f"{0.0 if abs(value) < 1e-9 else value:.3g}" for value in (*columns, np.mean(others))]
                yield f"{label}, {statistic}", *cells

    table("Curve: jitter of a person's motions against none", ["0", *JITTER, "other people, 0"], rows())
    return found


def areas(dataset, broken, folds, metrics):
    """Print the AUC of single motions with each fault, and the shares of small p-values."""
    names = list(folds[0].broken)
    found = {label: [fold.areas(metric, names) for fold in folds] for label, metric in metrics.items()}
    chosen = []
    for fold in folds:
        kept = np.flatnonzero(dataset.subjects != fold.person)
        inner = left_out(fold.training, [{SOUGHT: broken[i][SOUGHT]} for i in kept])
        if inner:
            of_metrics = {
                label: np.mean([one.areas(metric, [SOUGHT])[0][SOUGHT] for one in inner])
                for label, metric in metrics.items()
            }
            chosen.append(max(of_metrics, key=of_metrics.__getitem__))
    by_row = {label: [areas for areas, _ in of_folds] for label, of_folds in found.items()}
    if len(chosen) == len(folds):
        by_row["chosen"] = [found[label][i][0] for i, label in enumerate(chosen)]

    def rows(columns):
        for label, of_folds in by_row.items():
            values = [[one[name] for one in of_folds] for name in columns]
            yield label, *(f"{np.mean(some):.3f} ({np.min(some):.3f})" for some in values)

    table("AUC of single motions with jitter: mean over people left out (least)", JITTER, rows(JITTER))
    print(f"\nchosen on training people: {', '.join(chosen)}")
    others = [name for name in names if name not in JITTER]
    table("AUC of single motions with other faults", others, rows(others))

    def small():
        for label, of_folds in found.items():
            of_both = [[np.mean(p[name] <= 0.05) for _, p in of_folds] for name in ("real", SOUGHT)]
            yield label, *(f"{np.mean(shares):.0%}" for shares in of_both)

    table("Single motions with p ≤ 0.05", ["real, people left out", f"jitter of {SOUGHT}"], small())
    return by_row


def of_sets(folds, metrics, n_draws):
    """Print the AUC of sets of motions, by both statistics."""
    same, names = "the same five times", (*JITTER[1:3], "backwards")
    found = {}

    def rows():
        for statistic in STATISTICS:
            for label, metric in metrics.items():
                if label not in OF_SETS:
                    continue
                by_fold = []
                for fold in folds:
                    rng, values = np.random.default_rng(0), {name: [] for name in ("real", *names, same)}
                    for _ in range(n_draws):
                        Y = [fold.training[i] for i in rng.permutation(len(fold.training))[:IN_Y]]
                        some = rng.permutation(len(fold.real))[:OF_A_SET]
                        sets = {name: [fold.broken[name][i] for i in some] for name in names}
                        sets |= {"real": [fold.real[i] for i in some], same: [fold.real[some[0]]] * OF_A_SET}
                        for name, X in sets.items():
                            values[name].append(fold.distance(X, Y, metric, statistic))
                    by_fold.append([area(values["real"], values[name]) for name in (*names, same)])
                found[statistic, label] = dict(zip((*names, same), np.mean(by_fold, axis=0), strict=True))
                yield f"{label}, {statistic}", *(f"{value:.2f}" for value in found[statistic, label].values())

    table(f"AUC of sets of {OF_A_SET} motions, mean over people left out", [*names, same], rows())
    return found


def study(name, dataset, metrics, n_draws):
    """Run all parts on one collection of recordings."""
    start = time.perf_counter()
    dataset = dataset.to_rotvec()
    dataset = dataset._with([motion.resample(RATE) for motion in dataset])
    rng = np.random.default_rng(0)
    broken = [faults(motion, rng) for motion in dataset]
    folds = left_out(dataset, broken)
    for fold in folds:
        fold.broken[MEAN] = mean_motions(fold.training)
    people = ", ".join(f"{fold.person} ({len(fold.real)})" for fold in folds)
    print(f"\n## {name}: {len(dataset)} motions, left out {people}; made in {time.perf_counter() - start:.0f} s")
    parts = curve(folds, metrics), areas(dataset, broken, folds, metrics), of_sets(folds, metrics, n_draws)
    print(f"\n{time.perf_counter() - start:.0f} s")
    return parts


def main():
    options = common.parser_of_both(__doc__).parse_args()
    common.print_machine()
    if options.quick or not (options.cmu or options.hdm05):
        gait = make_gait(3, 4, duration=1.5, frame_rate=RATE, random_state=0)
        metrics = {label: METRICS[label] for label in ("position", "velocity, 0.25 s", "jerk")}
        curves, single, sets = study("generated gait", gait, metrics if options.quick else METRICS, n_draws=4)
        # The answers: all curves rise from zero, jerks find 2 mm in each motion, and nothing finds a root that slides.
        assert all(abs(values[0]) < 1e-9 * values[-1] and (np.diff(values) > 0).all() for values, _ in curves.values())
        assert all(one[SOUGHT] == 1.0 for one in single["jerk"] + single["chosen"])
        assert all(one["sliding"] == 0.5 for of_folds in single.values() for one in of_folds)
        assert all(sets[statistic, "jerk"][SOUGHT] == 1.0 for statistic in STATISTICS)
        return
    for name, dataset in common.datasets(options).items():
        study(name, dataset, METRICS, N_DRAWS)


if __name__ == "__main__":
    main()
