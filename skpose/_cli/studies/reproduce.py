"""The study of `skpose reproduce`: every number of section 3 of the paper, on the walks and runs of a dataset.

Protocol
--------
Poses at 12 Hz, ten steps to a curve.

- 3.1: 100 random pairs of poses, both of one random walk; r is the length of the geodesic divided by the
  length of the straight line (eq. 8).
- 3.2: classical multidimensional scaling; the share of variance in the first component of every sequence, and two walks
  of two people in two dimensions.
- 3.3: ten walks and ten runs at random; each pose gets the class of its nearest neighbour among the other nineteen
  sequences.
- 3.4: every pair of one of these walks and one of these runs, clustered by medoid shift at a bandwidth that gives two
  clusters; the better of the two assignments of clusters to classes counts.

The paper draws once. This study draws `N_DRAWS` times from one seed, and reports the first draw, the mean and the
standard deviation. Leaving one person out instead of one sequence, which the paper does not do, uses all sequences.
"""

import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from joblib import Parallel, delayed
from matplotlib.figure import Figure  # without pyplot: no window, no backend
from scipy.stats import binomtest, gaussian_kde, mannwhitneyu
from sklearn.exceptions import ConvergenceWarning

from skpose._cli.studies.compare import FRAME_RATE, classify, first_component
from skpose._utils.progress import progress
from skpose.cluster import MedoidShift
from skpose.datasets import MotionDataset, walks_and_runs
from skpose.geodesics import geodesic
from skpose.manifold import SpatialMDS
from skpose.metrics import Geodesic, Spatial, pose_distances
from skpose.metrics._registry import METRICS as METRIC_OBJECTS
from skpose.plot import GeodesicDisplay, MDSDisplay
from skpose.plot._axes import COLOURS

N_DRAWS, N_PAIRS, N_SEQUENCES, N_STEPS = 20, 100, 10, 10
METRICS = ("angle", "spatial")  # the paper's two
HEAD = ("section", "quantity", "paper", "here", f"{N_DRAWS} draws", "test")
SHORTEST = 3  # frames of a sequence below which its share of variance has no meaning

DIFFERENCES = (
    "Sequences: all in the folder; the paper uses 673 of the CMU database for figure 4 (c) and does not name them.",
    "3.1: both poses of a pair are of one walk; the paper has random pairs, of a walking sequence for figure 3 (a).",
    "3.1 and figure 4 (a, b): motions whose action is just “walk”, which is on level ground, if there are any; 3.3 and"
    " 3.4 use all walks.",
    "Curves have ten steps, so eleven points; the paper has ten sample points.",
    "The straight line wraps every difference of angles to [−π, π]; the paper's does not. “angle” does not wrap here"
    " either.",
    "The gradient of the energy is eq. 7 with the minus sign that eq. 12 drops; geodesics are measured again on a finer"
    " grid and refined where that disagrees.",
    "3.2, figure 4 (c): the mode is the peak of a Gaussian kernel density (Scott's rule), the test is one-sided.",
    "3.3 and 3.4: poses are on the mean skeleton of all people; the paper does not name its skeleton. Shares are of"
    " poses.",
    "3.4: pairs for which no bandwidth gives two clusters are left out.",
    "The paper draws once; here are the first draw, and mean ± standard deviation over 20 draws.",
)


class Row(NamedTuple):
    """A number of the paper, and ours."""

    section: str
    quantity: str
    paper: str
    first: str  # value of the first draw; the only value where nothing is drawn
    draws: str  # mean and standard deviation over all draws
    test: str = ""


@dataclass
class Findings:
    """All rows, and the data of the figures."""

    rows: list[Row] = field(default_factory=list)
    pair: tuple = ()  # skeleton and two poses of figure 3 (a)
    ratios: np.ndarray = field(default_factory=lambda: np.empty(0))  # figure 3 (b)
    draws: list[dict[str, np.ndarray]] = field(default_factory=list)  # walks and runs of 3.3 and 3.4
    walkers: dict = field(default_factory=dict)  # metric → (embedding, labels, shares), figure 4 (a, b)
    shares: dict = field(default_factory=dict)  # metric → share of each sequence, figure 4 (c)

    def add(
        self, section: str, quantity: str, paper: str, values: Sequence[Any] | np.ndarray, form: str, test: str = ""
    ) -> None:
        """Add the values of all draws."""
        self.rows.append(Row(section, quantity, paper, f"{values[0]:{form}}", _spread(values, form), test))


def reproduce(dataset: MotionDataset, seed: int = 0, *, n_jobs: int | None = None) -> Findings:
    """Repeat section 3 on the motions of a dataset, which must contain walks and runs."""
    findings, gait = Findings(), walks_and_runs(dataset)
    rng = np.random.default_rng(seed)
    for _ in range(N_DRAWS):
        of = {action: np.flatnonzero(gait.actions == action) for action in ("walk", "run")}
        draw = {action: rng.choice(those, min(N_SEQUENCES, len(those)), replace=False) for action, those in of.items()}
        findings.draws.append(draw)
    with progress("repeating section 3", len(STUDIES), 1) as advance:
        for i, study in enumerate(STUDIES):
            study(findings, dataset, gait, np.random.default_rng([seed, i]), n_jobs)
            advance()
    return findings


def _in_threads(task: Callable[[Any], Any], arguments: Iterable[Any], n_jobs: int | None) -> list[Any]:
    """The results of a task for each of some arguments, without warnings of searches that did not converge."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        results: list[Any] = Parallel(n_jobs, prefer="threads")(map(delayed(task), arguments))
    return results


def _spread(values: Sequence[Any] | np.ndarray, form: str) -> str:
    """Format mean and standard deviation over the draws."""
    return f"{np.mean(values):{form}} ± {np.std(values, ddof=1):{form}}"


def _level_walks(dataset: MotionDataset, gait: MotionDataset) -> MotionDataset:
    """The motions whose action is just "walk", or all walks if there are none."""
    level = np.char.lower(dataset.actions) == "walk"
    return dataset[level] if level.any() else gait[gait.actions == "walk"]


def _ratios(
    findings: Findings, dataset: MotionDataset, gait: MotionDataset, rng: np.random.Generator, n_jobs: int | None
) -> None:
    """3.1: how good is the straight line?"""
    walks = _level_walks(dataset, gait)
    X, sequence = walks.poses(FRAME_RATE)
    frames = [those for i in range(len(walks)) if len(those := np.flatnonzero(sequence == i)) > 1]
    pairs = [rng.choice(frames[i], 2, replace=False) for i in rng.integers(len(frames), size=N_DRAWS * N_PAIRS)]

    def measure(pair: np.ndarray) -> tuple[float, bool]:
        a, b = X[pair]
        path = geodesic(a, b, walks.skeleton, metric=Geodesic(N_STEPS))
        line = pose_distances(a[None], b[None], skeleton=walks.skeleton, metric=Spatial(N_STEPS))[0, 0]
        return min(path.length / line, 1.0), path.converged

    ratios, converged = zip(*_in_threads(measure, pairs, n_jobs), strict=True)
    draws = np.reshape(ratios, (N_DRAWS, N_PAIRS))
    unconverged = f"{converged.count(False)} of {len(pairs)} geodesics unconverged"
    findings.add("3.1, fig. 3 (b)", "r, lowest of 100 pairs", "0.94", draws.min(axis=1), ".3f", unconverged)
    findings.add("3.1, fig. 3 (b)", "r, median of 100 pairs", "", np.median(draws, axis=1), ".3f", unconverged)
    findings.ratios = draws[0]
    findings.pair = walks.skeleton, *X[pairs[int(draws[0].argmin())]]


def _walkers(
    findings: Findings, dataset: MotionDataset, gait: MotionDataset, rng: np.random.Generator, n_jobs: int | None
) -> None:
    """3.2, figure 4 (a, b): do the walks of two people mix? As in the paper, the reader judges."""
    walks = _level_walks(dataset, gait)
    people = np.unique(walks.subjects)
    if len(people) < 2:
        raise ValueError(f"figure 4 (a, b) needs walks of two people, got those of {people[0]!r}")
    two = [rng.choice(np.flatnonzero(walks.subjects == p)) for p in rng.choice(people, 2, replace=False)]
    both = walks[two]
    X, sequence = both.poses(FRAME_RATE)
    for metric in METRICS:
        mds = SpatialMDS(both.skeleton, n_components=2, metric=metric)
        findings.walkers[metric] = mds.fit_transform(X), both.subjects[sequence], mds.explained_variance_ratio_


def _components(
    findings: Findings, dataset: MotionDataset, gait: MotionDataset, rng: np.random.Generator, n_jobs: int | None
) -> None:
    """3.2, figure 4 (c): how much of a sequence's variance is in one component?"""
    motions = [motion.resample(FRAME_RATE) for motion in dataset]
    motions = [motion for motion in motions if len(motion) >= SHORTEST]
    for metric in METRICS:
        findings.shares[metric] = np.array(
            [
                first_component(pose_distances(m.angles, skeleton=m.skeleton, metric=metric, n_jobs=n_jobs))
                for m in motions
            ]
        )
    test = mannwhitneyu(*findings.shares.values(), alternative="less")
    for metric, paper in zip(METRICS, ("40 %", "80 %"), strict=True):
        shares = findings.shares[metric]
        grid = np.linspace(0, 1, 1001)
        mode = grid[gaussian_kde(shares)(grid).argmax()]
        median = f"median {np.median(shares):.0%}"
        quantity = f"share of variance in the first component, mode, {metric}"
        findings.rows.append(Row("3.2, fig. 4 (c)", quantity, paper, f"{mode:.0%}", median))
    quantity = "share with spatial is greater than with angle, p"
    statistic = f"Mann–Whitney U = {test.statistic:.0f}, one-sided"
    findings.rows.append(Row("3.2, fig. 4 (c)", quantity, "< 1e-6", f"{test.pvalue:.1e}", "", statistic))


def _separation(
    findings: Findings, dataset: MotionDataset, gait: MotionDataset, rng: np.random.Generator, n_jobs: int | None
) -> None:
    """3.3 and 3.4: do the nearest neighbour and medoid shift separate walking and running?"""
    X, sequence = gait.poses(FRAME_RATE)
    y, subject = gait.actions[sequence], gait.subjects[sequence]
    of_draws = [list(product(draw["walk"], draw["run"])) for draw in findings.draws]
    pairs = sorted({pair for of_draw in of_draws for pair in of_draw})
    right: dict[str, list[np.ndarray]] = {metric: [] for metric in METRICS}
    right_of_people, clustered = dict[str, np.ndarray](), dict[str, list[np.floating]]()
    for metric in METRICS:
        D = pose_distances(X, skeleton=gait.skeleton, metric=metric, n_jobs=n_jobs)
        for draw in findings.draws:
            of = np.flatnonzero(np.isin(sequence, np.concatenate(list(draw.values()))))
            right[metric].append(classify(D[np.ix_(of, of)], y[of], sequence[of]))
        right_of_people[metric] = classify(D, y, subject)

        def cluster(pair: tuple, D: np.ndarray = D) -> float:
            of = np.flatnonzero(np.isin(sequence, pair))
            labels = MedoidShift(n_clusters=2, metric="precomputed").fit_predict(D[np.ix_(of, of)])
            same = np.mean(labels == (sequence[of] == pair[1]))
            return max(same, 1 - same) if labels.max() == 1 else np.nan  # no bandwidth gives two clusters: NaN

        shares = dict(zip(pairs, _in_threads(cluster, pairs, n_jobs), strict=True))
        clustered[metric] = [np.nanmean([shares[pair] for pair in of_draw]) for of_draw in of_draws]
    test = _mcnemar({metric: values[0] for metric, values in right.items()})
    for metric, paper in zip(METRICS, ("90 %", "100 %"), strict=True):
        quantity = f"poses classified right, leave one sequence out, {metric}"
        findings.add("3.3", quantity, paper, [values.mean() for values in right[metric]], ".1%", test)
    people, test = np.unique(subject), _mcnemar(right_of_people)
    for metric, values in right_of_people.items():
        means = [values[subject == person].mean() for person in people]
        by_person = f"{len(people)} people: {_spread(means, '.1%')}"
        quantity = f"poses classified right, leave one person out, {metric}"
        findings.rows.append(Row("3.3", quantity, "", f"{values.mean():.1%}", by_person, test))
    for metric, paper in zip(METRICS, ("60 %", "65 %"), strict=True):
        findings.add("3.4", f"poses in the right cluster, {metric}", paper, clustered[metric], ".1%")
    n_poses = np.bincount(sequence)
    alone = [np.mean(n_poses[of_draw].max(axis=1) / n_poses[of_draw].sum(axis=1)) for of_draw in of_draws]
    findings.add("3.4", "poses in the larger class, as if all were one cluster", "", alone, ".1%")


def _mcnemar(right: dict[str, np.ndarray]) -> str:
    """Test whether two metrics classify equally well, by the poses that only one of them classifies right."""
    one, other = right.values()
    only = int(np.sum((one == 1) & (other == 0))), int(np.sum((one == 0) & (other == 1)))
    p = f", p = {binomtest(only[0], sum(only)).pvalue:.1e}" if sum(only) else ""
    return f"McNemar, exact: only {METRICS[0]} right {only[0]}, only {METRICS[1]} {only[1]}{p}"


STUDIES = _ratios, _walkers, _components, _separation


def table(findings: Findings) -> str:
    """The findings as a table, and the differences from the paper."""
    rows = [HEAD, *findings.rows]
    widths = [max(len(row[i]) for row in rows) for i in range(len(HEAD))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    notes = (f"- {note}" for note in DIFFERENCES)
    return "\n".join([*lines, "", "Differences from the paper:", *notes])


def draw(findings: Findings, figure_3: Path, figure_4: Path) -> None:
    """Write figures 3 and 4 as PNG files."""
    figure = Figure(figsize=(11, 4.5), layout="constrained")
    left, right = figure.subplots(1, 2)
    skeleton, start, end = findings.pair
    display = GeodesicDisplay.from_geodesic(geodesic(start, end, skeleton), skeleton, ax=left)
    left.set_title(f"(a) the pair of lowest ratio, {display.ratio_:.3f}")
    right.hist(findings.ratios, bins=20, color=COLOURS[0])
    lowest = findings.ratios.min()
    right.axvline(lowest, color=COLOURS[1], linestyle="--", label=f"lowest, {lowest:.3f} (paper: 0.94)")
    right.set(xlabel="length of the geodesic / length of the line", ylabel="pairs of walking poses")
    right.yaxis.get_major_locator().set_params(integer=True)
    right.set_title("(b) how good the straight line is")
    right.legend()
    figure.savefig(figure_3, dpi=120)

    figure = Figure(figsize=(15, 4.5), layout="constrained")
    *planes, last = figure.subplots(1, len(findings.walkers) + 1, squeeze=False)[0]
    for ax, letter, (metric, (embedding, people, shares)) in zip(planes, "ab", findings.walkers.items(), strict=False):
        MDSDisplay.from_embedding(embedding, people, shares=shares, unit=METRIC_OBJECTS[metric].unit, ax=ax)
        ax.get_legend().set_title("person")
        ax.set_title(f"({letter}) two people's walks, “{metric}”")
    for (metric, shares), colour in zip(findings.shares.items(), COLOURS, strict=False):
        last.hist(shares, bins=np.linspace(0, 1, 21), color=colour, alpha=0.6, label=f"“{metric}”")
    last.set(xlabel="share of variance in the first component", ylabel="sequences")
    last.set_title("(c) share of variance in one component")
    last.legend()
    figure.savefig(figure_4, dpi=120)
