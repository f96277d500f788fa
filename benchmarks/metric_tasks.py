"""The tasks of `metrics.py`: what each metric reaches in them, recording by recording, and how long it takes."""

import time
import warnings
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np
from joblib import Parallel, delayed
from recognition import Split
from regression import ENDS
from scipy.spatial.transform import Rotation
from sklearn.cluster import AgglomerativeClustering
from sklearn.exceptions import ConvergenceWarning
from sklearn.metrics import adjusted_rand_score
from sklearn.neighbors import KNeighborsClassifier

from skpose import PoseKNeighborsTransformer, SpatialMDS, forward_kinematics, motion_distances, pose_distances
from skpose.biomechanics import gait_events
from skpose.datasets import MotionDataset
from skpose.geodesics import frechet_mean, interpolate
from skpose.metrics import geodesic_error, mpjpe
from skpose.skeleton import Skeleton
from skpose.skeleton._interpolation import interpolate_poses
from skpose.skeleton._rotations import rotations_of

METRICS = ("angle", "position", "rotation", "spatial", "geodesic")
WITHOUT_GEODESIC = METRICS[:-1]
N_NEIGHBORS = 5
N_SHUFFLES = 10
FEW = 20  # items, for which other processes are not worth their start
FRACTIONS = (0.25, 0.5, 0.75)  # of a repetition, and of the time between two keys
ERRORS = ("joints, mm", "joints, °", "bones in the world, °")


class Recordings(NamedTuple):
    """Motions as a task takes them, and which people are tested with which others."""

    name: str
    dataset: MotionDataset
    splits: list[Split]

    @property
    def skeleton(self) -> Skeleton:
        return self.dataset.skeleton

    def poses(self):
        """Return all poses on the mean skeleton, and the number of the motion of each."""
        return self.dataset.poses()


class Figures(NamedTuple):
    """What the metrics reach in a task: a number for each unit, a recording or an item, and its weight."""

    task: str
    set_name: str
    is_share: bool  # in percent, the more the better; else an error, the less the better
    of_metric: dict[str, np.ndarray]
    weights: np.ndarray
    people: np.ndarray
    control: float  # what shuffled labels reach, or the nearest thing that needs no metric


class Times(NamedTuple):
    """How long each metric takes, on one core."""

    task: str
    set_name: str
    of_metric: dict[str, float]


def seconds_of(function):
    """Return the result of a function and the seconds of all processors that this process took."""
    start = time.process_time()
    return function(), time.process_time() - start


def shuffled(actions, train, seed):
    """Return the actions, those of the training motions shuffled among these."""
    found = actions.copy()
    found[train] = np.random.default_rng(seed).permutation(found[train])
    return found


class Tests:
    """Sums over the tests of each motion, which may be tested in several splits."""

    def __init__(self, n, names):
        self.sums = {name: np.zeros(n) for name in names}
        self.counts = np.zeros(n)

    def add(self, name, motions, values):
        np.add.at(self.sums[name], motions, values)

    def means(self, name, kept):
        return 100 * self.sums[name][kept] / self.counts[kept]


def recognise_frames(given: Recordings, metrics: Sequence[str], every: int) -> list[Figures | Times]:
    """Look for the nearest frames of the training people for each frame of the others."""
    X, motion_of = given.poses()
    actions, n = given.dataset.actions, len(given.dataset)
    is_query = np.arange(len(X)) % every == 0
    names = [(metric, kind) for metric in (*metrics, "shuffled") for kind in ("nearest", "five")]
    tests, seconds, n_queries = Tests(n, names), dict.fromkeys(metrics, 0.0), 0
    for seed, (train, test) in enumerate(given.splits):
        known, asked = np.isin(motion_of, train), np.isin(motion_of, test) & is_query
        owners, targets = motion_of[known], motion_of[asked]
        np.add.at(tests.counts, targets, 1.0)
        n_queries += len(targets)
        for metric in metrics:
            search = PoseKNeighborsTransformer(given.skeleton, n_neighbors=N_NEIGHBORS, metric=metric, n_jobs=-1)
            search.fit(X[known])
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ConvergenceWarning)  # of geodesics, which are then as long as they are
                (_, found), taken = seconds_of(lambda search=search, asked=asked: search.kneighbors(X[asked]))
            seconds[metric] += taken
            runs = [(metric, actions, 1)]
            if metric == "position":
                runs += [("shuffled", shuffled(actions, train, seed + k), N_SHUFFLES) for k in range(N_SHUFFLES)]
            for name, labels, n_runs in runs:
                is_same = labels[owners[found]] == actions[targets][:, None]
                tests.add((name, "nearest"), targets, is_same[:, 0] / n_runs)
                tests.add((name, "five"), targets, is_same.mean(axis=1) / n_runs)
    kept = tests.counts > 0
    titles = {"nearest": "recognition of frames, %", "five": "retrieval of frames, precision at 5, %"}
    figures = [
        Figures(
            title,
            given.name,
            True,
            {metric: tests.means((metric, kind), kept) for metric in metrics},
            tests.counts[kept],
            given.dataset.subjects[kept],
            float(np.average(tests.means(("shuffled", kind), kept), weights=tests.counts[kept])),
        )
        for kind, title in titles.items()
    ]
    each = {metric: 1e3 * taken / n_queries for metric, taken in seconds.items()}
    return [*figures, Times("search of the five nearest frames, ms a query", given.name, each)]


def average_precision(distances, is_same):
    """Return the average precision of each row: the mean of the precisions at the places of the same action."""
    in_order = np.take_along_axis(is_same, distances.argsort(axis=1, kind="stable"), axis=1)
    precisions = in_order.cumsum(axis=1) / np.arange(1, in_order.shape[1] + 1)
    return (precisions * in_order).sum(axis=1) / np.maximum(in_order.sum(axis=1), 1)


def recognise_motions(given: Recordings, metrics: Sequence[str]) -> list[Figures | Times]:
    """Compare whole motions: the nearest, all of the same action, and clusters."""
    dataset, actions, people = given.dataset, given.dataset.actions, given.dataset.subjects
    names = [(metric, kind) for metric in (*metrics, "shuffled") for kind in ("nearest", "retrieval")]
    tests, seconds, rand = Tests(len(dataset), names), {}, {}
    for metric in metrics:
        D, seconds[metric] = seconds_of(lambda metric=metric: motion_distances(dataset, metric=metric, n_jobs=-1))
        for seed, (train, test) in enumerate(given.splits):
            if metric == metrics[0]:
                tests.counts[test] += 1.0
            some, labels = D[np.ix_(test, train)], [(metric, actions, 1)]
            if metric == "position":
                labels += [("shuffled", shuffled(actions, train, seed + k), N_SHUFFLES) for k in range(N_SHUFFLES)]
            for name, known, n_runs in labels:
                is_same = known[train] == actions[test][:, None]
                right = is_same[np.arange(len(test)), some.argmin(axis=1)]
                tests.add((name, "nearest"), test, right / n_runs)
                tests.add((name, "retrieval"), test, average_precision(some, is_same) / n_runs)
        rand[metric] = jackknife(lambda kept, D=D: rand_index(D, actions, kept), people)
        if metric == "position":
            at_random = np.random.default_rng(0).permutation(actions)
            by_chance = 100 * rand_index(D, at_random, np.ones(len(dataset), bool))
    kept = tests.counts > 0
    titles = {
        "nearest": "recognition of sequences, %",
        "retrieval": "retrieval of sequences, mean average precision, %",
    }
    figures = [
        Figures(
            title,
            given.name,
            True,
            {metric: tests.means((metric, kind), kept) for metric in metrics},
            tests.counts[kept],
            people[kept],
            float(np.average(tests.means(("shuffled", kind), kept), weights=tests.counts[kept])),
        )
        for kind, title in titles.items()
    ]
    everybody = np.unique(people)
    title = "clusters of sequences, adjusted Rand index, %"
    figures.append(Figures(title, given.name, True, rand, np.ones(len(everybody)), everybody, by_chance))
    return [*figures, Times(f"matrix of {len(dataset)} sequences, s", given.name, seconds)]


def rand_index(D, actions, kept):
    """Return how well as many clusters as actions agree with the actions, the mean of two linkages."""
    found = []
    for linkage in ("average", "complete"):
        clusters = AgglomerativeClustering(len(set(actions[kept])), metric="precomputed", linkage=linkage)
        found.append(adjusted_rand_score(actions[kept], clusters.fit_predict(D[np.ix_(kept, kept)])))
    return float(np.mean(found))


def jackknife(statistic: Callable, people):
    """Return a statistic, in percent, as one number for each person, of which it is the mean, without one of them each.

    They are the jackknife's pseudovalues, moved by their bias: their standard error is the jackknife's.
    """
    everybody = np.unique(people)
    without = np.array([statistic(people != person) for person in everybody])
    whole = statistic(np.ones(len(people), bool))
    return 100 * (whole + (len(everybody) - 1) * (without.mean() - without))


def embed(given: Recordings, metrics: Sequence[str], n_most: int) -> list[Figures | Times]:
    """Draw frames in the plane by scaling: actions of other people, order in time, variance of single motions."""
    X, motion_of = given.poses()
    actions, people, n = given.dataset.actions, given.dataset.subjects, len(given.dataset)
    rows = np.arange(0, len(X), max(1, -(-len(X) // n_most)))
    sampled = motion_of[rows]
    follows = np.flatnonzero(sampled[1:] == sampled[:-1])
    starts = np.searchsorted(motion_of, np.arange(n + 1))
    long = np.flatnonzero(np.diff(starts) > 3)
    tests = Tests(n, [*metrics, "shuffled"])
    order, share, seconds = {}, {}, {}
    n_steps = np.bincount(sampled[follows], minlength=n).astype(float)
    for metric in metrics:
        measured = {"skeleton": given.skeleton, "metric": metric, "n_jobs": -1}
        D, seconds[metric] = seconds_of(lambda measured=measured: pose_distances(X[rows], **measured))
        plane = SpatialMDS(metric="precomputed").fit_transform(D)
        apart = np.linalg.norm(plane[:, None] - plane, axis=2)
        nearer = (apart[follows] < apart[follows, follows + 1][:, None]).sum(axis=1) - 1  # without itself
        ranks = np.bincount(sampled[follows], weights=nearer / (len(rows) - 2), minlength=n)
        order[metric] = 100 * (ranks / np.maximum(n_steps, 1.0))[n_steps > 0]
        share[metric] = np.array([variance_in_plane(X[starts[i] : starts[i + 1]], measured) for i in long], dtype=float)
        for seed, (train, test) in enumerate(given.splits):
            known, asked = np.isin(sampled, train), np.isin(sampled, test)
            if metric == metrics[0]:
                np.add.at(tests.counts, sampled[asked], 1.0)
            labels = [(metric, actions, 1)]
            if metric == "position":
                labels += [("shuffled", shuffled(actions, train, seed + k), N_SHUFFLES) for k in range(N_SHUFFLES)]
            for name, of_motions, n_runs in labels:
                nearest = KNeighborsClassifier(N_NEIGHBORS).fit(plane[known], of_motions[sampled[known]])
                right = nearest.predict(plane[asked]) == actions[sampled[asked]]
                tests.add(name, sampled[asked], right / n_runs)
    kept = tests.counts > 0
    chance = float(np.average(tests.means("shuffled", kept), weights=tests.counts[kept]))
    of_frames = {metric: tests.means(metric, kept) for metric in metrics}
    moves = n_steps > 0
    each = {metric: 1e6 * taken / (len(rows) * (len(rows) - 1) / 2) for metric, taken in seconds.items()}
    return [
        Figures("plane: recognition, %", given.name, True, of_frames, tests.counts[kept], people[kept], chance),
        Figures("plane: nearer than the next frame, %", given.name, False, order, n_steps[moves], people[moves], 50.0),
        Figures("plane: variance of a recording, %", given.name, True, share, np.ones(len(long)), people[long], np.nan),
        Times("matrix of poses, µs a pair", given.name, each),
    ]


def variance_in_plane(X, measured):
    """Return the share of variance of two components, percent."""
    D = pose_distances(X, **measured)
    if not D.any():
        return 100.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that a motion of a line has one component
        return 100 * SpatialMDS(metric="precomputed").fit(D).explained_variance_ratio_.sum()


class Item(NamedTuple):
    """A pose to predict as the mean of others."""

    poses: np.ndarray  # (n_poses, n_dofs)
    weights: np.ndarray
    truth: np.ndarray  # (n_dofs,)
    person: str


def predict(items: Sequence[Item], skeleton, metric, on_line):
    """Return the errors of the predictions of a metric, one row of ERRORS for each, and the seconds that they take."""
    predictions, seconds = [], 0.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a mean that does not converge is the best one found
        for item in (items[0], *items):  # the first one compiles
            pose, taken = seconds_of(lambda item=item: mean_of(item, skeleton, metric, on_line))
            predictions.append(pose)
            seconds += taken if len(predictions) > 1 else 0.0
    return errors(predictions[1:], items, skeleton), seconds


def mean_of(item, skeleton, metric, on_line):
    """Return the mean of an item's poses: of two `on_line`, the pose on the path that the metric measures."""
    if on_line and metric == "spatial":
        return interpolate_poses(skeleton.bones, item.poses, item.weights[1:])[0]
    if on_line and metric == "geodesic":
        steps = {fraction: round(4 * fraction) for fraction in FRACTIONS}
        motion = interpolate(item.poses, [0.0, 1.0], skeleton, frame_rate=4, method="geodesic")
        return motion.angles[steps[item.weights[1]]]
    return frechet_mean(item.poses, skeleton, metric=metric, sample_weight=item.weights).pose


def errors(predicted, items, skeleton):
    """Return the errors of poses, each in the units of ERRORS."""
    ours, true = np.array(predicted), np.array([item.truth for item in items])
    apart = np.linalg.norm(forward_kinematics(ours, skeleton) - forward_kinematics(true, skeleton), axis=2)
    angles = [
        [(a.inv() * b).magnitude() for a, b in zip(some, others, strict=True)]
        for some, others in zip(rotations(ours, skeleton), rotations(true, skeleton), strict=True)
    ]
    return np.column_stack([1e3 * apart.mean(axis=1), *(np.degrees(np.mean(each, axis=0)) for each in angles)])


def check_errors(found, parts, skeleton):
    """Compare the mean errors of the given poses with the scores of `skpose.metrics`."""
    items = [item for part in parts for item in part]
    ours, true = np.array([item.poses[item.weights.argmax()] for item in items]), np.array([i.truth for i in items])
    scores = [mpjpe(forward_kinematics(true, skeleton), forward_kinematics(ours, skeleton), unit="mm")]
    scores += [geodesic_error(true, ours, skeleton=skeleton, frame=frame) for frame in ("parent", "world")]
    np.testing.assert_allclose(found.mean(axis=0), [float(score) for score in scores])


def rotations(poses, skeleton):
    """Return the rotations of the joints that have dofs, and the orientations of all bones, of some poses at once."""
    own, axes, column = [], [], 0
    for bone, parent, rest in zip(skeleton.bones, skeleton.parents, skeleton.rest_rotations, strict=True):
        rotation = Rotation.identity(len(poses))
        if bone.n_dofs:
            rotation = rotations_of(bone, poses[:, column : column + bone.n_dofs])
            own.append(rotation)
        column += bone.n_dofs
        axes.append((axes[parent] if parent >= 0 else Rotation.identity()) * Rotation.from_matrix(rest) * rotation)
    return own, axes


def compare_predictions(
    task, given_name, items: Iterable[Item], skeleton, metrics, on_line=False
) -> list[Figures | Times]:
    """Predict each item under each metric."""
    items = list(items)
    parts = [items[first::2] for first in range(min(2, len(items)))]
    jobs = [(metric, part) for metric in metrics for part in parts]
    n_jobs = -1 if len(items) >= FEW else 1
    done = Parallel(n_jobs=n_jobs)(delayed(predict)(part, skeleton, metric, on_line) for metric, part in jobs)
    found, seconds = {}, dict.fromkeys(metrics, 0.0)
    for (metric, _), (rows, taken) in zip(jobs, done, strict=True):
        found.setdefault(metric, []).append(rows)
        seconds[metric] += taken
    people = np.array([item.person for part in parts for item in part])
    nearest = np.concatenate([errors([item.poses[item.weights.argmax()] for item in p], p, skeleton) for p in parts])
    check_errors(nearest, parts, skeleton)
    figures = []
    for column, unit in enumerate(ERRORS):
        of_metric = {metric: np.concatenate(rows)[:, column] for metric, rows in found.items()}
        control = float(nearest[:, column].mean())
        figures.append(Figures(f"{task}, {unit}", given_name, False, of_metric, np.ones(len(people)), people, control))
    each = {metric: 1e3 * taken / len(items) for metric, taken in seconds.items()}
    return [*figures, Times(f"{task}, ms each", given_name, each)]


def repetitions(given: Recordings, n_most: int) -> Iterable[Item]:
    """Yield a pose of a repetition that is left out, with those at the same phase of the person's other ones."""
    X, motion_of = given.poses()
    for person in np.unique(given.dataset.subjects):
        for action in np.unique(given.dataset.actions):
            group = np.flatnonzero((given.dataset.subjects == person) & (given.dataset.actions == action))
            yield from left_out([np.flatnonzero(motion_of == i) for i in group], X, person, n_most)


def left_out(repeated, X, person, n_most):
    """Yield an item for some of the repetitions, each a list of rows, at one phase after the other."""
    if len(repeated) < 3:
        return
    for k, i in enumerate(np.unique(np.linspace(0, len(repeated) - 1, n_most).astype(int))):
        phase = FRACTIONS[k % len(FRACTIONS)]
        at = np.array([rows[round(phase * (len(rows) - 1))] for rows in repeated])
        others = np.delete(at, i)
        yield Item(X[others], np.full(len(others), 1.0 / len(others)), X[at[i]], str(person))


def strides(dataset: MotionDataset, n_most: int, n_others: int = 6) -> Iterable[Item]:
    """Yield a pose of a stride of the left foot, with those at the same phase of other strides of the person."""
    X, motion_of = dataset.poses()
    starts = np.searchsorted(motion_of, np.arange(len(dataset)))
    found: dict[tuple[str, str], list[np.ndarray]] = {}
    for first, motion, person, action in zip(starts, dataset, dataset.subjects, dataset.actions, strict=True):
        events = gait_events(motion)
        for begins, _, ends in events.strides:
            if events.feet[begins] == "left":
                rows = np.arange(events.frames[begins], events.frames[ends] + 1)
                found.setdefault((person, action), []).append(first + rows)
    for (person, _), repeated in found.items():
        for item in left_out(repeated, X, person, n_most):
            some = np.unique(np.linspace(0, len(item.poses) - 1, n_others).astype(int))
            yield item._replace(poses=item.poses[some], weights=np.full(len(some), 1.0 / len(some)))


def other_people(given: Recordings, every: int) -> Iterable[Item]:
    """Yield a pose of a person's first repetition of an action, with those of all others at the same phase."""
    X, motion_of = given.poses()
    actions, people = given.dataset.actions, given.dataset.subjects
    k = 0
    for action in np.unique(actions):
        firsts = {person: np.flatnonzero((actions == action) & (people == person))[:1] for person in np.unique(people)}
        repeated = {person: np.flatnonzero(motion_of == i[0]) for person, i in firsts.items() if len(i)}
        for person in repeated:
            k += 1
            if k % every:
                continue
            phase = FRACTIONS[k // every % len(FRACTIONS)]
            at = {other: rows[round(phase * (len(rows) - 1))] for other, rows in repeated.items()}
            others = [row for other, row in at.items() if other != person]
            yield Item(X[others], np.full(len(others), 1.0 / len(others)), X[at[person]], str(person))


def from_ends(given: Recordings, n_most: int) -> Iterable[Item]:
    """Yield poses, each with the five training poses whose hands, feet and head are nearest, weighted by a kernel."""
    X, motion_of = given.poses()
    people = given.dataset.subjects[motion_of]
    ends = [j for j, name in enumerate(given.skeleton.joint_names) if name.endswith(ENDS)]
    features = forward_kinematics(X, given.skeleton)[:, ends].reshape(len(X), -1)
    for train, test in given.splits:
        known = np.flatnonzero(np.isin(motion_of, train))
        asked = np.flatnonzero(np.isin(motion_of, test))
        asked = asked[np.unique(np.linspace(0, len(asked) - 1, n_most).astype(int))]
        fifth = [
            np.sort(apart_from(features[known[people[known] != person]], features[row]))[N_NEIGHBORS - 1]
            for person in np.unique(people[known])
            for row in known[people[known] == person][::20]
            if (people[known] != person).any()
        ]
        gamma = 0.5 / np.median(fifth) if fifth else 100.0
        for row in asked:
            squares = apart_from(features[known], features[row])
            nearest = squares.argsort(kind="stable")[:N_NEIGHBORS]
            weights = np.exp(-gamma * (squares[nearest] - squares[nearest[0]]))
            yield Item(X[known[nearest]], weights / weights.sum(), X[row], str(people[row]))


def apart_from(features, one):
    """Return squared distances."""
    return np.square(features - one).sum(axis=1)


def gaps(given: Recordings, length: int, n_most: int, every: int = 1) -> Iterable[Item]:
    """Yield frames between two keys that are `length` frames apart, a multiple of four."""
    X, motion_of = given.poses()
    starts = np.searchsorted(motion_of, np.arange(len(given.dataset) + 1))
    for i in range(0, len(given.dataset), every):
        n_gaps = (starts[i + 1] - starts[i] - 1) // length
        for k in np.unique(np.linspace(0, n_gaps - 1, n_most).astype(int)) if n_gaps else []:
            fraction = FRACTIONS[(i // every + k) % len(FRACTIONS)]
            key = starts[i] + k * length
            keys, weights = X[[key, key + length]], np.array([1.0 - fraction, fraction])
            yield Item(keys, weights, X[key + round(fraction * length)], str(given.dataset.subjects[i]))
