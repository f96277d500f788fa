"""Where does each metric win? Recognition, retrieval, clusters, planes, means, regression, in-betweens, and time.

    python benchmarks/metrics.py [--cmu FOLDER] [--hdm05 FOLDER] [--msr FOLDER] [--quick]

One protocol for all metrics, with nothing chosen on the people who are tested; seeds are fixed. MSR Action3D is read
as in `recognition.py`: skeletons fitted to each person, poses to the skeletons, the ten splits of the literature. Of
HDM05, and of CMU's walks and runs, each person is tested once, and the others are known. All frames are those of the
recordings at 15 Hz, which divides their frame rates; all poses are on the mean skeleton of the set. "Euler" is the
files' own angles, everything else ball joints. The root's orientation is no part of a pose, or its tilt, or the whole.

- Recognition of frames: the action of the nearest frame of the known people, for every fifth frame, of MSR for every
  fifteenth. Precision at 5: the share of the five nearest that are of the action. By the exact search.
- Recognition of sequences: the action of the known people's nearest, by dynamic time warping. Retrieval: all known
  sequences in the order of their distances; the mean, over the places of those of the same action, of their share
  among all up to there.
- Clusters: as many as there are actions, by average and by complete linkage of the distances of sequences, without
  labels; the mean of the adjusted Rand indices of the two, and its spread by leaving out a person, the jackknife.
- Planes: classical scaling of at most 2,000 frames, without labels. The action of most of the five nearest frames of
  known people in the plane; the share of all frames that are nearer to a frame there than the one that follows it in
  its recording, which is of time and favours no metric; and the share of variance of two components, of each recording
  by itself, which each metric measures in its own terms.
- Means: a repetition of a person is left out, and a pose of it, at 25, 50 or 75 % of its time, predicted as the Fréchet
  mean of the others' poses at the same time: HDM05's actions, CMU's strides from contact to contact of the left foot.
  Of MSR a person is left out, and the others' first repetitions predict. Times are relative, without a metric.
- Regression: the pose of a person from the positions of hands, feet and head, as the mean of the five known frames
  where these are nearest, with Gaussian weights: `PoseKernelRegressor`. The kernel's width is the distance to the
  fifth nearest among the known people, in the median; neighbours and weights are the same for all metrics.
- In-betweens: two frames 0.27, 0.53 or 1.07 s apart, and the frame at 25, 50 or 75 % of the time between them. "angle":
  the line of the columns, as they are; "spatial": the line that it measures, slerp of ball joints; "geodesic": the
  shortest path at constant speed; "position" and "rotation": the weighted mean of the two, which for "position" is
  inverse kinematics of the positions in between.

Errors of poses are in three units, as each favours some metric: the mean distance of joints, mm, is near to what
"position" minimises; the mean rotation of the joints, relative to their parents, to "angle" and "spatial" along ball
joints; that of the bones in the world, to "rotation". A metric that is ahead in another one's unit has won.

As controls: training labels that are shuffled among sequences, for all shares; for means, regression and in-betweens
the given pose with the largest weight, without any mean.

After each figure: its standard deviation over people. Bold are those that are level with the best: the difference is
at most one standard error, that of differences unit by unit, a unit being a recording or a predicted pose, or that of
differences person by person, the larger one; and all that are no worse than one of these. Times are seconds of the
processor, all cores added. "geodesic" is left out where it would take hours: matrices, and motions. "position" is a
lower and "spatial" an upper bound for it.
"""

import argparse
import time
import warnings
from pathlib import Path
from typing import NamedTuple

import common
import numpy as np
from cycles import stand
from metric_tasks import (
    METRICS,
    WITHOUT_GEODESIC,
    Figures,
    Recordings,
    Times,
    compare_predictions,
    embed,
    from_ends,
    gaps,
    other_people,
    recognise_frames,
    recognise_motions,
    repetitions,
    strides,
)
from recognition import MSR, RATE, by_person, prepared, read

from skpose.datasets import MotionDataset, load_cmu, load_hdm05, make_gait, walks_and_runs

GAPS = (4, 8, 16)  # frames between two keys
OF_EULER = ("angle", "position", "spatial")  # the others do not depend on the numbers of a rotation


class Size(NamedTuple):
    every: int  # of how many frames one is looked for
    n_embedded: int  # frames at most
    n_means: int  # repetitions left out of each group at most
    n_strides: int
    n_regression: int  # poses predicted of each person
    n_gaps: int  # of each recording and length at most


FULL, QUICK = Size(5, 2000, 3, 20, 20, 2), Size(30, 60, 1, 1, 1, 1)


def at_rate(dataset):
    """Return the dataset at RATE, as ball joints and as the files have it."""
    return prepared(dataset.to_rotvec()), prepared(dataset)


def named(name, dataset, joints="", root="none"):
    """Return recordings whose people are tested one by one."""
    rooted = dataset if root == "none" else dataset.with_root(root)
    notes = [note for note in (joints, root if root != "none" else "") if note]
    return Recordings(", ".join([name, *notes]), *by_person(rooted))


def study(options, size):
    """Yield the rows of all tasks of the sets that are asked for."""
    if options.hdm05:
        yield from of_actions("HDM05", load_hdm05(options.hdm05), size)
    if options.cmu:
        yield from of_gait("CMU", load_cmu(options.cmu), size)
    if options.msr:
        dataset, splits = read(Path(options.msr), MSR)
        yield from of_splits("MSR Action3D", dataset, splits, size)
    if not (options.hdm05 or options.cmu or options.msr):
        gait = make_gait(2, 3, duration=2.0, frame_rate=30, random_state=0)
        yield from of_actions("generated gait", gait, size)
        moving = [stand(motion) for motion in gait]
        yield from of_gait("moving", MotionDataset(moving, gait.subjects, gait.trials, gait.actions), size, n_gaps=1)


def of_actions(name, dataset, size):
    """Yield the rows of a set of repeated actions, each person tested once."""
    balls, angles = at_rate(dataset)
    plain, euler = named(name, balls), named(name, angles, "Euler")
    tilted = named(name, balls, root="tilt")
    yield from recognise_frames(plain, METRICS, size.every)
    yield from recognise_frames(tilted, METRICS, size.every)
    yield from recognise_frames(euler, OF_EULER, size.every)
    yield from recognise_motions(plain, WITHOUT_GEODESIC)
    yield from recognise_motions(tilted, WITHOUT_GEODESIC)
    yield from recognise_motions(euler, OF_EULER)
    yield from embed(plain, WITHOUT_GEODESIC, size.n_embedded)
    yield from embed(euler, OF_EULER, size.n_embedded)
    items = repetitions(plain, size.n_means)
    yield from compare_predictions("means of repetitions", name, items, plain.skeleton, METRICS)
    items = repetitions(euler, size.n_means)
    yield from compare_predictions("means of repetitions", euler.name, items, euler.skeleton, OF_EULER[:2])
    yield from compare_predictions("regression", name, from_ends(plain, size.n_regression), plain.skeleton, METRICS)
    yield from in_betweens(plain, size.n_gaps, METRICS)
    yield from in_betweens(euler, size.n_gaps, OF_EULER)


def of_gait(name, dataset, size, n_gaps=6):
    """Yield the rows of a set of walks, runs and a few other motions."""
    walking = walks_and_runs(dataset)
    balls, angles = at_rate(walking)
    plain, euler = named(f"{name}, gait", balls), named(f"{name}, gait", angles, "Euler")
    yield from recognise_frames(plain, METRICS, size.every)
    yield from recognise_frames(euler, OF_EULER, size.every)
    yield from recognise_motions(plain, WITHOUT_GEODESIC)
    yield from recognise_motions(euler, OF_EULER)
    yield from embed(plain, WITHOUT_GEODESIC, size.n_embedded)
    native = walking.to_rotvec()
    if items := list(strides(native, size.n_strides)):
        yield from compare_predictions("means of strides", plain.name, items, native.skeleton, METRICS)
    items = from_ends(plain, size.n_regression)
    yield from compare_predictions("regression", plain.name, items, plain.skeleton, METRICS)
    balls, angles = at_rate(dataset)
    everything = Recordings(name, balls, [])
    yield from in_betweens(everything, n_gaps, METRICS)
    yield from in_betweens(Recordings(f"{name}, Euler", angles, []), n_gaps, OF_EULER)


def of_splits(name, dataset, splits, size):
    """Yield the rows of a set with given splits of many people, whose poses are fitted to keypoints."""
    plain = Recordings(name, dataset, splits)
    rooted = Recordings(f"{name}, whole", dataset.with_root("whole"), splits)
    yield from recognise_frames(plain, METRICS, 3 * size.every)
    yield from recognise_frames(rooted, WITHOUT_GEODESIC, 3 * size.every)
    yield from recognise_motions(plain, WITHOUT_GEODESIC)
    yield from recognise_motions(rooted, WITHOUT_GEODESIC)
    yield from embed(plain, WITHOUT_GEODESIC, size.n_embedded)
    yield from compare_predictions("means of other people", name, other_people(plain, 4), plain.skeleton, METRICS)
    yield from in_betweens(plain, 1, METRICS, every=3)


def in_betweens(given, n_most, metrics, every=1):
    """Yield the rows of frames between keys."""
    for length in GAPS:
        items = list(gaps(given, length, n_most, every))
        if items:
            title = f"in-betweens, {length / RATE:.2f} s"
            yield from compare_predictions(title, given.name, items, given.skeleton, metrics, on_line=True)


def standard_error(difference, weights):
    """Return the standard error of a weighted mean."""
    if len(difference) < 2:
        return 0.0
    off = weights * (difference - np.average(difference, weights=weights))
    return float(np.sqrt(np.square(off).sum() * len(off) / (len(off) - 1)) / weights.sum())


def by_people(values, weights, people):
    """Return the weighted mean of each person, and the weights of the people."""
    everybody = [people == person for person in np.unique(people)]
    totals = np.array([weights[part].sum() for part in everybody])
    return np.array([weights[part] @ values[part] for part in everybody]) / totals, totals


def level(row: Figures):
    """Return the metrics within one standard error of the best, and those that are no worse than one of these."""
    means = {metric: np.average(values, weights=row.weights) for metric, values in row.of_metric.items()}
    best = (max if row.is_share else min)(means, key=means.get)
    found = set()
    for metric, values in row.of_metric.items():
        difference = values - row.of_metric[best]
        spread = max(
            standard_error(difference, row.weights), standard_error(*by_people(difference, row.weights, row.people))
        )
        if abs(means[metric] - means[best]) <= spread:
            found.add(metric)
    shown = {metric: (1 if row.is_share else -1) * float(digits(mean)) for metric, mean in means.items()}
    return {metric for metric in shown if shown[metric] >= min(shown[other] for other in found)}


def digits(value):
    """Return a number with three digits."""
    return f"{value:.1f}" if abs(value) >= 10 else f"{value:.2f}" if abs(value) >= 0.1 else f"{value:.2g}"


def line(row):
    """Return a row of the table."""
    cells, control = [], ""
    if isinstance(row, Times):
        cells = [digits(row.of_metric[metric]) if metric in row.of_metric else "" for metric in METRICS]
        return f"| {row.task} | {row.set_name} | " + " | ".join(cells) + " | |"
    winners = level(row)
    for metric in METRICS:
        if metric not in row.of_metric:
            cells.append("")
            continue
        values = row.of_metric[metric]
        cell = digits(np.average(values, weights=row.weights))
        spread = by_people(values, row.weights, row.people)[0].std(ddof=1)
        cells.append((f"**{cell}**" if metric in winners else cell) + f" ± {digits(spread)}")
    control = "" if np.isnan(row.control) else digits(row.control)
    return f"| {row.task} | {row.set_name} | " + " | ".join(cells) + f" | {control} |"


def main():
    arguments = common.parser_of_both(__doc__)
    arguments.add_argument("--msr", help="MSR Action3D: positions.npz, index.csv, splits.csv")
    options = arguments.parse_args()
    common.print_machine()
    warnings.filterwarnings("ignore", message=".*negative")  # eigenvalues of distances that are not Euclidean
    nothing = argparse.Namespace(hdm05=None, cmu=None, msr=None)
    if not options.quick:
        list(study(nothing, QUICK))  # compiles
    start = time.perf_counter()
    print("\n| task | set | " + " | ".join(METRICS) + " | control |\n|" + "---|" * (len(METRICS) + 3))
    for row in study(nothing if options.quick else options, QUICK if options.quick else FULL):
        print(line(row), flush=True)
        if options.quick:
            check(row)
    print(f"\n{time.perf_counter() - start:.0f} s")


def check(row):
    """Check what must hold on any data."""
    if isinstance(row, Times):
        assert all(seconds >= 0.0 for seconds in row.of_metric.values())
        return
    assert level(row)
    for values in row.of_metric.values():
        assert np.isfinite(values).all()
        assert len(values) == len(row.weights) == len(row.people)
    if row.is_share and "Rand" not in row.task:
        assert all(((values >= 0) & (values <= 100)).all() for values in row.of_metric.values())


if __name__ == "__main__":
    main()
