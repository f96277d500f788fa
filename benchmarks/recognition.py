"""Recognition of actions of people who are not in the training data, on public benchmarks and on any folder.

    python benchmarks/recognition.py [--msr FOLDER] [--hdm05 FOLDER] [--cmu FOLDER] [--folder FOLDER] [--quick]

MSR Action3D (W. Li, Z. Zhang, Z. Liu, 2010, doi:10.1109/CVPRW.2010.5543273) and other folders hold `index.csv` with the
columns action and subject, and `splits.csv` with the training people of each split, separated by blanks; without it
each person is tested once, and the others train, on the actions that two people or more do. `--group` is another column
in place of the subject, such as the view; skeletons are fitted to people. The motions are those of `positions.npz`,
joint positions (n_frames, n_joints, 3) of all sequences and `n_frames` of each, or the files of a column `file`, or of
the folder with labels in their names, as `load_motions` reads them. Options state what positions are: `--joints`, their
names in order, `--layout`, `--frame-rate`, `--scale`.

The protocol, the same for every set, with nothing chosen by hand:

1. Keypoints: a skeleton is fitted to each person's recordings, without labels, and poses to the skeleton.
2. Motions faster than 15 Hz are resampled to that; a single frame is a person who stands still; motions on skeletons of
   several rest poses are retargeted to the first.
3. In each split all is learnt from the training people: the skeleton on which motions are compared, their mean; how
   much of the root's orientation is a part of the poses, under "position"; and in the rows "chosen" which kinds of
   distances are features, and whether the model or the nearest motion decides. Choices are made by recognising each
   training person from the other ones: the root that is best, and of what is within one standard error of the best
   the model with the most kinds.
4. The features of a motion are its distances to all training motions, of each kind; the model is `StandardScaler` and
   `LinearDiscriminantAnalysis(solver="lsqr", shrinkage="auto")`. "nearest" is the nearest training motion, by the sum
   of the kinds, each divided by its median among the training motions.
5. The figure is the share of the test motions that are recognised, mean and standard deviation over the splits; where
   each split tests one person, it is the share of all motions.

As controls the same model learns from actions that are shuffled among the training motions, and from the positions of
points relative to their middle without a skeleton, "raw".
"""

import csv
import time
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import common
import numpy as np
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from skpose import inverse_kinematics, motion_distances
from skpose.datasets import MotionDataset, load_cmu, load_hdm05, load_motions, make_gait
from skpose.keypoints import Keypoints, fit_skeleton, layouts
from skpose.metrics import Velocity

RATE = 15  # Hz
REGULARIZATION = 0.02  # m/rad, of the poses that are fitted to keypoints
METRICS = ("angle", "position", "rotation", "spatial")
ROOTS = ("none", "tilt", "whole")
RAW = "raw"  # the row of positions without a skeleton
VELOCITIES = {f"velocity {span:g} s": Velocity(span) for span in (0.125, 0.25, 0.5)}
KINDS = {
    "poses": ("poses",),
    "velocities": ("velocity 0.25 s",),
    "centered": ("centered",),
    "poses, velocities": ("poses", "velocity 0.25 s"),
    "poses, velocities, centered": ("poses", "velocity 0.25 s", "centered"),
    "the same, velocities over three times": ("poses", *VELOCITIES, "centered"),
}
MSR = {
    # All wave and throw with what its documentation calls left: the sides are exchanged here.
    "joints": "left_shoulder right_shoulder shoulder_center spine left_hip right_hip hip_center left_elbow right_elbow "
    "left_wrist right_wrist left_hand right_hand left_knee right_knee left_ankle right_ankle left_foot right_foot head",
    "layout": "kinect20",
    "frame_rate": 15.0,
    "scale": 1e-4,
}


class Split(NamedTuple):
    train: np.ndarray  # indices of motions
    test: np.ndarray


class Collection(NamedTuple):
    """Motions, their groups, positions (n_frames, n_points * 3) about their middle, and splits."""

    dataset: MotionDataset
    groups: np.ndarray
    raw: list[np.ndarray]
    splits: list[Split]


class Right(NamedTuple):
    """How many motions of a split are recognised."""

    model: int
    nearest: int
    shuffled: int


class Distances:
    """The distances of a split, of each kind, from all of its motions to the training motions."""

    def __init__(self, motions, collection: Collection, split: Split):
        self.train, self.test = ([motions[i] for i in part] for part in split)
        self.actions = collection.dataset.actions[np.concatenate(split)]
        self.groups = collection.groups[split.train]
        self.skeleton = MotionDataset(self.train).skeleton if isinstance(motions, MotionDataset) else None
        self.of_kind: dict[str, np.ndarray] = {}

    def measure(self, kind, metric):
        """Compute the distances of a kind."""
        train, test, given = self.train, self.test, {"metric": metric, "skeleton": self.skeleton, "n_jobs": -1}
        if self.skeleton is None:
            train, test = ([of_raw(one, metric) for one in part] for part in (train, test))
            given["metric"] = "angle"
        found = motion_distances(train, **given)
        median = np.median(found)
        if test:
            found = np.concatenate([found, motion_distances(test, train, **given)])
        self.of_kind[kind] = found / median

    def model(self, kinds, fit, test, actions=None):
        """The number of motions that the model recognises."""
        actions = self.actions if actions is None else actions
        features = np.hstack([self.of_kind[kind][:, fit] for kind in kinds])
        model = make_pipeline(StandardScaler(), LinearDiscriminantAnalysis(solver="lsqr", shrinkage="auto"))
        return int((model.fit(features[fit], actions[fit]).predict(features[test]) == self.actions[test]).sum())

    def nearest(self, kinds, fit, test):
        """The number of motions whose nearest training motion has their action."""
        found = sum(self.of_kind[kind] for kind in kinds)[np.ix_(test, fit)].argmin(axis=1)
        return int((self.actions[fit][found] == self.actions[test]).sum())

    def among_groups(self, kinds):
        """The numbers of training motions that are recognised from those of others, by the nearest and by the model."""
        everyone, right = np.arange(len(self.train)), np.zeros(2, int)
        for group in sorted(set(self.groups)):
            fit, test = everyone[self.groups != group], everyone[self.groups == group]
            if len(set(self.actions[fit])) > 1:
                right += np.array([self.nearest(kinds, fit, test), self.model(kinds, fit, test)])
        return right


def of_raw(positions, metric):
    """Positions (n_frames, n) as they are, minus their mean, or as velocities."""
    if metric == "centered":
        return positions - positions.mean(axis=0)
    if isinstance(metric, Velocity):
        span = min(max(1, round(metric.span * RATE)), len(positions) - 1)
        return (positions[span:] - positions[:-span]) / (span / RATE)
    return positions


def main():
    parser = common.parser_of_both(__doc__)
    parser.add_argument("--msr", help="MSR Action3D: positions.npz, index.csv, splits.csv")
    parser.add_argument("--folder", help="any other folder, see the beginning of this file")
    parser.add_argument("--joints", help="names of the joints of positions.npz, in order, separated by blanks")
    parser.add_argument("--layout", default="kinect20", choices=list(layouts), help="layout of the joints")
    parser.add_argument("--frame-rate", type=float, help="frame rate of positions.npz, Hz")
    parser.add_argument("--scale", type=float, default=1.0, help="metres for each unit of positions.npz")
    parser.add_argument("--group", default="subject", help="column of index.csv whose values are tested one by one")
    parser.add_argument(
        "--metrics", nargs="+", default=METRICS, help=f"distances of poses; default: {' '.join(METRICS)}"
    )
    options = parser.parse_args()
    common.print_machine()
    warnings.filterwarnings("ignore", message="Only one sample available")  # of an action, among the training people
    for name, collection in sets(options):
        collection = collection._replace(splits=collection.splits[: 2 if options.quick else None])
        report(name, collection, ["position"] if options.quick else options.metrics)


def sets(options) -> Iterator[tuple[str, Collection]]:
    """Yield the sets that are asked for, by name; without any generated gait."""
    for name, folder, load in (("HDM05", options.hdm05, load_hdm05), ("CMU", options.cmu, load_cmu)):
        if folder:
            yield name, by_group(prepared(load(folder)))
    if options.msr:
        yield "MSR Action3D", read(Path(options.msr), MSR)
    if options.folder:
        folder, positions = Path(options.folder), {name: getattr(options, name) for name in MSR}
        yield folder.resolve().name, read(folder, positions, options.group)
    if not any((options.hdm05, options.cmu, options.msr, options.folder)):
        yield "generated gait", by_group(prepared(make_gait(3, 3, duration=2.0, random_state=0)))


def read(folder, positions, group="subject"):
    """Return the collection of a folder; `positions` states what positions.npz holds."""
    index, rows, recordings = folder / "index.csv", [], None
    if index.exists():
        rows = read_rows(index)
    if (folder / "positions.npz").exists():
        labels = {f"{name}s": [row[name] for row in rows] for name in ("subject", "action")}
        motions, recordings = fitted(folder / "positions.npz", labels["subjects"], **positions)
        dataset = MotionDataset(motions, **labels)
    else:
        dataset = load_motions(folder, table=index if rows else None, on_error="raise")
    groups = [row[group] for row in rows] if rows else dataset.subjects
    collection = prepared(dataset, np.array(groups), recordings)
    if not (folder / "splits.csv").exists():
        return by_group(collection)
    training = [row[f"training_{group}s"].split() for row in read_rows(folder / "splits.csv")]
    is_train = [np.isin(collection.groups, some) for some in training]
    return collection._replace(splits=[Split(np.flatnonzero(train), np.flatnonzero(~train)) for train in is_train])


def read_rows(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def fitted(path, subjects, joints, layout, frame_rate, scale):
    """Return motions that are fitted to positions, on a skeleton for each person, and the positions as keypoints."""
    if joints is None or frame_rate is None:
        raise SystemExit(f"{path}: pass --joints and --frame-rate, which it does not state")
    names = joints.replace(",", " ").split()
    chosen = layouts[layout].without([name for name in layouts[layout].names if name not in names])
    with np.load(path) as file:
        parts = np.split(file["positions"] * scale, np.cumsum(file["n_frames"])[:-1])
    recordings = [Keypoints(part, names, frame_rate) for part in parts]
    own = {person: [k for k, s in zip(recordings, subjects, strict=True) if s == person] for person in set(subjects)}
    skeletons = {person: fit_skeleton(theirs, chosen, symmetric=True) for person, theirs in own.items()}
    motions = [
        inverse_kinematics(k, skeletons[person], regularization=REGULARIZATION).to_motion()
        for k, person in zip(recordings, subjects, strict=True)
    ]
    return motions, recordings


def prepared(dataset, groups=None, recordings=None):
    """Return motions of no more than RATE and of two frames or more, and their points without a skeleton."""
    points = [motion.to_keypoints() for motion in dataset] if recordings is None else recordings
    raw = []
    for one in points:
        step = max(1, round(one.frame_rate / RATE))
        middle = np.nanmean(one.positions, axis=1, keepdims=True)
        vectors = np.nan_to_num(one.positions - middle)[::step].reshape(-1, 3 * len(one.names))
        raw.append(np.repeat(vectors, 2, axis=0) if len(vectors) == 1 else vectors)
    motions = [motion.resample(RATE) if motion.frame_rate > RATE else motion for motion in dataset]
    motions = [still(motion) if len(motion) == 1 else motion for motion in motions]
    ready = MotionDataset(motions, subjects=dataset.subjects, actions=dataset.actions)
    try:
        ready.skeleton  # noqa: B018
    except ValueError:  # several rest poses, or rigs
        ready = ready.retarget(ready[0].skeleton, method="auto", n_jobs=-1)
    return Collection(ready, dataset.subjects if groups is None else groups, raw, [])


def still(motion):
    """Return a motion of two frames that are the only one of another."""
    rows = {name: np.repeat(getattr(motion, name), 2, axis=0) for name in ("angles", "root_positions", "root_angles")}
    return replace(motion, frame_numbers=None, seen=None, **rows)


def by_group(collection):
    """Return the motions whose action two groups or more do, and splits that test one group each."""
    actions, groups = collection.dataset.actions, collection.groups
    kept = [i for i, action in enumerate(actions) if len(set(groups[actions == action])) > 1]
    groups = groups[kept]
    splits = [Split(np.flatnonzero(groups != one), np.flatnonzero(groups == one)) for one in sorted(set(groups))]
    return Collection(collection.dataset[kept], groups, [collection.raw[i] for i in kept], splits)


def report(name, collection, metrics):
    """Print the table of a set."""
    dataset, splits = collection.dataset, collection.splits
    print(
        f"\n{name}: {len(dataset)} motions at {dataset[0].frame_rate:g} Hz, {len(set(dataset.actions))} actions, "
        f"{len(set(dataset.subjects))} people, {len(splits)} splits"
    )
    rooted = {part: dataset if part == "none" else dataset.with_root(part) for part in ROOTS}
    start = time.perf_counter()
    roots = [max(ROOTS, key=lambda part: of_root(rooted[part], collection, split)) for split in splits]
    of_splits = [Distances(rooted[part], collection, split) for part, split in zip(roots, splits, strict=True)]
    are_comparable = len({rows.shape[1] for rows in collection.raw}) == 1
    without = [Distances(collection.raw, collection, split) for split in splits if are_comparable]
    for one in [*of_splits, *without]:
        for kind, metric in (VELOCITIES | {"centered": "centered"}).items():
            one.measure(kind, metric)
    print(
        "root: "
        + ", ".join(f"{part} {roots.count(part)}" for part in dict.fromkeys(roots))
        + f" of the splits; it and velocities took {time.perf_counter() - start:.0f} s\n"
    )
    print(f"{'metric':<10}{'features':<40}{'recognised, %':>16}{'nearest':>16}{'shuffled':>16}{'seconds':>9}")
    n_tested = sum(len(split.test) for split in splits)
    by_people = len(np.unique(np.concatenate([split.test for split in splits]))) == n_tested  # each is tested once
    for metric in [*metrics, *[RAW] * are_comparable]:
        start = time.perf_counter()
        results = [of_split(one, metric, seed) for seed, one in enumerate(without if metric == RAW else of_splits)]
        seconds = time.perf_counter() - start
        for kind in (*KINDS, "chosen"):
            if kind == "chosen":
                right = np.array([[getattr(found[kinds], decides)] for found, (kinds, decides) in results])
            else:
                right = np.array([found[kind] for found, _ in results])
            shares = 100 * right / [[len(split.test)] for split in splits]
            mean = 100 * right.sum(axis=0) / n_tested if by_people else shares.mean(axis=0)
            cells = [f"{m:.2f} ± {d:.2f}" for m, d in zip(mean, shares.std(axis=0), strict=True)]
            cells += [""] * (len(Right._fields) - len(cells))
            print(f"{metric:<10}{kind:<40}" + "".join(f"{cell:>16}" for cell in cells) + f"{seconds:>9.0f}", flush=True)
        choices = [f"{kinds}, {decides}" for _, (kinds, decides) in results]
        print("chosen: " + "; ".join(f"{one}: {choices.count(one)}" for one in dict.fromkeys(choices)), flush=True)


def of_root(dataset, collection, split):
    """The number of training motions that are recognised with this part of the root."""
    distances = Distances(dataset, collection, Split(split.train, split.train[:0]))
    distances.measure("poses", "position")
    return distances.among_groups(("poses",))[1]


def of_split(distances, metric, seed):
    """How many motions of a split are recognised by each kind of features, and the kinds that its training chooses."""
    distances.measure("poses", metric)
    n = len(distances.train)
    fit, test = np.arange(n), np.arange(n, len(distances.actions))
    shuffled = distances.actions.copy()
    shuffled[fit] = np.random.default_rng(seed).permutation(shuffled[fit])
    right = {
        name: Right(
            distances.model(kinds, fit, test),
            distances.nearest(kinds, fit, test),
            distances.model(kinds, fit, test, shuffled),
        )
        for name, kinds in KINDS.items()
    }
    among = np.array([distances.among_groups(kinds) / n for kinds in KINDS.values()])  # (n_kinds, 2)
    least = among.max() - np.sqrt(among.max() * (1.0 - among.max()) / n)
    decides, kinds = np.argwhere(np.transpose(among) >= least)[-1]
    return right, (list(KINDS)[kinds], ("nearest", "model")[decides])


if __name__ == "__main__":
    main()
