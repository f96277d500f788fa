"""Section 3 of the paper again: every number, on whatever walks and runs there are. What `skpose reproduce` does.

Protocol
--------
Poses at 12 Hz, ten steps to a curve. Section 3.1: 100 random pairs of poses, both of one random walk; r is the length
of the geodesic over that of the straight line (eq. 8). 3.2: classical multidimensional scaling; the share of variance
in the first component of every sequence, and two walks of two people in two dimensions. 3.3: ten walks and ten runs at
random; the nearest neighbour of each pose among the other nineteen sequences says what it is. 3.4: of the same, every
walk with every run, clustered by medoid shift at a bandwidth that gives two clusters, which are then called what fits
best.

Where the paper draws once, this draws `N_DRAWS` times from one seed, and reports the first draw, the mean and the
standard deviation. Leaving one person out instead of one sequence, which the paper does not do, takes all sequences.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from itertools import product

import numpy as np
from joblib import effective_n_jobs
from scipy.stats import binomtest, gaussian_kde, mannwhitneyu, wilcoxon
from sklearn.exceptions import ConvergenceWarning
from sklearn.metrics import silhouette_score

from skpose._cli.compare import FRAME_RATE, classified_right, first_component
from skpose._parallel.progress import progress
from skpose._parallel.threads import in_threads
from skpose.cluster import MedoidShift
from skpose.datasets import MotionDataset, walks_and_runs
from skpose.geodesics import geodesic
from skpose.manifold import SpatialMDS
from skpose.metrics import pose_distances

N_DRAWS, N_PAIRS, N_SEQUENCES, N_STEPS = 20, 100, 10, 10
METRICS = ("angle", "spatial")  # the paper's two
SHORTEST = 3  # frames that a sequence needs for a share of variance to mean anything


DIFFERENCES = (
    "Sequences: those of the folder; the paper takes 673 of the CMU database for figure 4 (c) and does not name any.",
    "3.1: both poses of a pair are of one walk; the paper says random pairs, of a walking sequence for figure 3 (a).",
    "3.1 and figure 4 (a, b): walks on level ground, if there are any called just “walk”; 3.3 and 3.4 take all walks.",
    "Curves have ten steps, so eleven points; the paper has ten sample points.",
    "The straight line goes the short way round in every angle; the paper's is literal. “angle” is literal here too.",
    "The gradient of the energy is eq. 7 with the minus sign that eq. 12 drops; geodesics are measured again on a finer"
    " grid and refined where that disagrees.",
    "3.2, figure 4 (a, b): the paper looks; the silhouette says how far the two people lie apart, 0 where they mix.",
    "3.2, figure 4 (c): the mode is the peak of a Gaussian kernel density (Scott's rule), the test is one-sided.",
    "3.3 and 3.4: poses are on the mean skeleton of all people; the paper does not say on which. Shares are of poses.",
    "3.4: pairs for which no bandwidth gives two clusters are left out.",
    "The paper draws once; here are the first draw, and mean ± standard deviation over 20 draws.",
)


@dataclass
class Row:
    """One number of the paper, and ours."""

    section: str
    what: str
    paper: str
    first: str  # of the first draw, or where nothing is drawn
    draws: str  # mean and standard deviation of all of them
    n_sequences: int
    n_poses: int
    test: str = ""


@dataclass
class Findings:
    """All rows, and what the figures show."""

    rows: list[Row] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    pair: tuple = ()  # skeleton and two poses of figure 3 (a)
    ratios: np.ndarray | None = None  # figure 3 (b)
    draws: list[dict[str, np.ndarray]] = field(default_factory=list)  # walks and runs of 3.3 and 3.4
    walkers: dict = field(default_factory=dict)  # metric → (embedding, labels, shares), figure 4 (a, b)
    shares: dict = field(default_factory=dict)  # metric → share of each sequence, figure 4 (c)


def reproduce(dataset: MotionDataset, seed: int = 0, *, n_jobs: int | None = None, verbose: int = 0) -> Findings:
    """All of section 3 on the motions of a dataset, of which some must be walks and some runs."""
    findings, gait = Findings(), walks_and_runs(dataset)
    rng = np.random.default_rng(seed)
    for _ in range(N_DRAWS):
        of = {action: np.flatnonzero(gait.actions == action) for action in ("walk", "run")}
        draw = {action: rng.choice(those, min(N_SEQUENCES, len(those)), replace=False) for action, those in of.items()}
        findings.draws.append(draw)
    with progress("sections", len(STUDIES), verbose) as advance:
        for i, study in enumerate(STUDIES):
            study(findings, dataset, gait, np.random.default_rng([seed, i]), n_jobs)
            advance()
    return findings


def _spread(values: list[float], form: str) -> str:
    """Mean and standard deviation over the draws."""
    return f"{np.mean(values):{form}} ± {np.std(values, ddof=1):{form}}"


def _level_walks(dataset: MotionDataset, gait: MotionDataset) -> MotionDataset:
    """The walks that are called just so, or else all of them."""
    level = np.char.lower(dataset.actions) == "walk"
    return dataset.select(level) if level.any() else gait.select(gait.actions == "walk")


def _ratios(findings: Findings, dataset: MotionDataset, gait: MotionDataset, rng, n_jobs) -> None:
    """3.1: how good is the straight line?"""
    walks = _level_walks(dataset, gait)
    X, sequence = walks.poses(FRAME_RATE)
    frames = [those for i in range(len(walks)) if len(those := np.flatnonzero(sequence == i)) > 1]
    pairs = [rng.choice(frames[i], 2, replace=False) for i in rng.integers(len(frames), size=N_DRAWS * N_PAIRS)]
    ratios, converged = np.empty(len(pairs)), np.empty(len(pairs), dtype=bool)

    def measure(k: int) -> None:
        a, b = X[pairs[k]]
        way = geodesic(a, b, walks.skeleton, n_steps=N_STEPS)
        line = pose_distances(a[None], b[None], skeleton=walks.skeleton, n_steps=N_STEPS)[0, 0]
        ratios[k], converged[k] = min(way.length / line, 1.0), way.converged

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        in_threads((partial(measure, k) for k in range(len(pairs))), effective_n_jobs(n_jobs))
    draws = ratios.reshape(N_DRAWS, N_PAIRS)
    size = len(walks), len(X)
    unsure = f"{(~converged).sum()} of {len(pairs)} geodesics unconverged"
    for what, paper, values in (
        ("r, lowest of 100 pairs", "0.94", draws.min(axis=1)),
        ("r, median of 100 pairs", "", np.median(draws, axis=1)),
    ):
        findings.rows.append(
            Row("3.1, fig. 3 (b)", what, paper, f"{values[0]:.3f}", _spread(values, ".3f"), *size, unsure)
        )
    findings.ratios = draws[0]
    findings.pair = walks.skeleton, *X[pairs[int(draws[0].argmin())]]


def _walkers(findings: Findings, dataset: MotionDataset, gait: MotionDataset, rng, n_jobs) -> None:
    """3.2, figure 4 (a, b): do the walks of two people lie together?"""
    walks = _level_walks(dataset, gait)
    people = np.unique(walks.subjects)
    if len(people) < 2:
        findings.notes.append("Only one person walks, so there is no figure 4 (a, b).")
        return
    apart = {metric: [] for metric in METRICS}
    for draw in range(N_DRAWS):
        two = [rng.choice(np.flatnonzero(walks.subjects == p)) for p in rng.choice(people, 2, replace=False)]
        both = walks.select(two)
        X, sequence = both.poses(FRAME_RATE)
        for metric in METRICS:
            mds = SpatialMDS(2, skeleton=both.skeleton, metric=metric)
            Y = mds.fit_transform(X)
            apart[metric].append(silhouette_score(Y, sequence))
            if draw == 0:
                findings.walkers[metric] = Y, both.subjects[sequence], mds.explained_variance_ratio_
                size = 2, len(X)
    for metric, paper in zip(METRICS, ("bimodal", "unimodal"), strict=True):
        what = f"silhouette of two people's walks, {metric}"
        values = apart[metric]
        findings.rows.append(Row("3.2, fig. 4 (a, b)", what, paper, f"{values[0]:.2f}", _spread(values, ".2f"), *size))


def _components(findings: Findings, dataset: MotionDataset, gait: MotionDataset, rng, n_jobs) -> None:
    """3.2, figure 4 (c): how much of a sequence does one component hold?"""
    motions = [motion.resample(FRAME_RATE) for motion in dataset]
    motions = [motion for motion in motions if len(motion) >= SHORTEST]
    size = len(motions), sum(map(len, motions))
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
        said = f"median {np.median(shares):.0%}"
        what = f"share of variance in the first component, mode, {metric}"
        findings.rows.append(Row("3.2, fig. 4 (c)", what, paper, f"{mode:.0%}", said, *size))
    what = "spatial holds more than angle, p"
    said = f"Mann–Whitney U = {test.statistic:.0f}, one-sided"
    findings.rows.append(Row("3.2, fig. 4 (c)", what, "< 1e-6", f"{test.pvalue:.1e}", "", *size, said))


def _gait_distances(gait: MotionDataset, metric: str, n_jobs) -> tuple[np.ndarray, np.ndarray]:
    """Distances between all poses of walks and runs, and the sequence that each is from."""
    X, sequence = gait.poses(FRAME_RATE)
    return pose_distances(X, skeleton=gait.skeleton, metric=metric, n_jobs=n_jobs), sequence


def _classification(findings: Findings, dataset: MotionDataset, gait: MotionDataset, rng, n_jobs) -> None:
    """3.3: does the nearest neighbour tell walking from running?"""
    draws = [np.concatenate(list(draw.values())) for draw in findings.draws]
    by_draw: dict[str, list[np.ndarray]] = {metric: [] for metric in METRICS}
    by_subject: dict[str, np.ndarray] = {}
    for metric in METRICS:
        D, sequence = _gait_distances(gait, metric, n_jobs)
        y, subject = gait.actions[sequence], gait.subjects[sequence]
        for chosen in draws:
            of = np.flatnonzero(np.isin(sequence, chosen))
            by_draw[metric].append(classified_right(D[np.ix_(of, of)], y[of], sequence[of]))
        by_subject[metric] = classified_right(D, y, subject)
    first = {metric: values[0] for metric, values in by_draw.items()}
    test = _mcnemar(first)
    for metric, paper in zip(METRICS, ("90 %", "100 %"), strict=True):
        means = [values.mean() for values in by_draw[metric]]
        what = f"poses classified right, leave one sequence out, {metric}"
        size = len(draws[0]), len(first[metric])
        findings.rows.append(Row("3.3", what, paper, f"{means[0]:.1%}", _spread(means, ".1%"), *size, test))
    people = np.unique(subject)
    if len(people) < 2:
        findings.notes.append("Only one person moves, so nobody can be left out.")
        return
    test = _mcnemar(by_subject)
    for metric, right in by_subject.items():
        means = [right[subject == person].mean() for person in people]
        said = f"{len(people)} people: {_spread(means, '.1%')}"
        what = f"poses classified right, leave one person out, {metric}"
        findings.rows.append(Row("3.3", what, "", f"{right.mean():.1%}", said, len(gait), len(y), test))


def _mcnemar(right: dict[str, np.ndarray]) -> str:
    """Poses that only one of two metrics gets right, and how likely it is that they divide like this by chance."""
    one, other = right.values()
    only = int(np.sum((one == 1) & (other == 0))), int(np.sum((one == 0) & (other == 1)))
    p = f", p = {binomtest(only[0], sum(only)).pvalue:.1e}" if sum(only) else ""
    return f"McNemar, exact: only {METRICS[0]} right {only[0]}, only {METRICS[1]} {only[1]}{p}"


def _clustering(findings: Findings, dataset: MotionDataset, gait: MotionDataset, rng, n_jobs) -> None:
    """3.4: does medoid shift tell them apart?"""
    draws = findings.draws
    pairs = sorted({pair for draw in draws for pair in product(draw["walk"], draw["run"])})
    shares: dict[str, dict[tuple, float]] = {}
    larger: dict[tuple, float] = {}
    for metric in METRICS:
        D, sequence = _gait_distances(gait, metric, n_jobs)
        shares[metric] = {}

        def cluster(pair, metric=metric, D=D, sequence=sequence) -> None:
            of = np.flatnonzero(np.isin(sequence, pair))
            runs = sequence[of] == pair[1]
            labels = MedoidShift(n_clusters=2, metric="precomputed").fit_predict(D[np.ix_(of, of)])
            same = np.mean(labels == runs)
            shares[metric][pair] = max(same, 1 - same) if labels.max() == 1 else np.nan
            larger[pair] = max(runs.mean(), 1 - runs.mean())

        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)  # no bandwidth gives two clusters: NaN
            in_threads((partial(cluster, pair) for pair in pairs), effective_n_jobs(n_jobs))
    by_draw = {
        metric: [np.array([shares[metric][pair] for pair in product(draw["walk"], draw["run"])]) for draw in draws]
        for metric in METRICS
    }
    first = [by_draw[metric][0] for metric in METRICS]
    both = np.isfinite(first[0]) & np.isfinite(first[1]) & (first[0] != first[1])
    test = ""
    if both.any():
        result = wilcoxon(first[1][both], first[0][both])
        test = f"Wilcoxon W = {result.statistic:.0f} of {both.sum()} pairs, p = {result.pvalue:.1e}"
    used = np.isin(gait.poses(FRAME_RATE)[1], np.concatenate(list(draws[0].values())))
    size = sum(map(len, draws[0].values())), int(used.sum())
    for metric, paper in zip(METRICS, ("60 %", "65 %"), strict=True):
        means = [np.nanmean(values) for values in by_draw[metric]]
        none = f"; no such bandwidth for {np.isnan(by_draw[metric][0]).sum()} of {len(first[0])}"
        what = f"poses in the right cluster, {metric}"
        findings.rows.append(Row("3.4", what, paper, f"{means[0]:.1%}", _spread(means, ".1%"), *size, test + none))
    alone = [np.mean([larger[pair] for pair in product(draw["walk"], draw["run"])]) for draw in draws]
    what = "poses in the larger class, as if all were one cluster"
    findings.rows.append(Row("3.4", what, "", f"{alone[0]:.1%}", _spread(alone, ".1%"), *size))


Study = Callable[[Findings, MotionDataset, MotionDataset, np.random.Generator, int | None], None]
STUDIES: tuple[Study, ...] = (_ratios, _walkers, _components, _classification, _clustering)
