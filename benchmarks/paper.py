"""Sections 3.2 and 3.4 of the paper on a folder of CMU files: dimensionality reduction and clustering.

    python benchmarks/paper.py FOLDER_OF_CMU_FILES

Poses at 12 Hz. Section 3.2: the share of variance in the first MDS component, sequence by sequence; and how far the
walks of two people lie apart in two dimensions (the silhouette of the person labels: nought where they mix). Section
3.4: ten walks and ten runs drawn at random (seed 0); every pair of a walk and a run is clustered by medoid shift at a
bandwidth that gives two clusters, and the clusters are named so as to fit best.
"""

import sys
import warnings

import numpy as np
from scipy.stats import mannwhitneyu
from sklearn.exceptions import ConvergenceWarning
from sklearn.metrics import silhouette_score

from skpose import MedoidShift, SpatialMDS
from skpose.compare import FRAME_RATE, walks_and_runs
from skpose.datasets import load_cmu

METRICS = ("angle", "position", "rotation", "spatial")
PAIRS = [(("02", "01"), ("35", "01")), (("02", "01"), ("07", "05"))]


def first_components(dataset):
    """Share of variance in the first component of each sequence, by metric."""
    return {
        metric: [
            SpatialMDS(1, skeleton=motion.skeleton, metric=metric)
            .fit(motion.resample(FRAME_RATE).angles)
            .explained_variance_ratio_[0]
            for motion in dataset
        ]
        for metric in METRICS
    }


def silhouettes(dataset, pair):
    """How far two sequences lie apart in two dimensions, by metric."""
    names = list(zip(dataset.subjects, dataset.trials, strict=True))
    both = dataset.select([names.index(name) for name in pair])
    X, sequence = both.poses(FRAME_RATE)
    return {
        metric: silhouette_score(SpatialMDS(2, skeleton=both.skeleton, metric=metric).fit_transform(X), sequence)
        for metric in METRICS
    }


def clustering(dataset, metric, rng):
    """Share of frames in the right cluster for 100 pairs of sequences, NaN where no bandwidth gives two clusters."""
    dataset = walks_and_runs(dataset)
    walks, runs = (
        rng.choice(np.flatnonzero(dataset.actions == action), 10, replace=False) for action in ("walk", "run")
    )
    shares, larger = [], []
    for i in walks:
        for j in runs:
            both = dataset.select([i, j])
            X, sequence = both.poses(FRAME_RATE, dataset.skeleton)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ConvergenceWarning)
                labels = MedoidShift(n_clusters=2, skeleton=dataset.skeleton, metric=metric).fit_predict(X)
            right = np.mean(labels == sequence)
            shares.append(max(right, 1 - right) if labels.max() == 1 else np.nan)
            larger.append(max(np.mean(sequence), 1 - np.mean(sequence)))
    return np.array(shares), np.mean(larger)


def main():
    dataset = load_cmu(sys.argv[1])
    shares = first_components(dataset)
    print(f"3.2: share of variance in the first component, median over {len(dataset)} sequences")
    for metric, values in shares.items():
        paper = {"angle": "   paper: mode 40 %", "spatial": "   paper: mode 80 %"}.get(metric, "")
        print(f"  {metric:<10}{np.median(values):>8.3f}{paper}")
    test = mannwhitneyu(shares["spatial"], shares["angle"], alternative="two-sided")
    print(f"  Mann-Whitney U of spatial against angle: U = {test.statistic:.0f}, p = {test.pvalue:.1e}   paper: < 1e-6")

    print("\nFigure 4 (a, b): silhouette of the person labels in two dimensions")
    for pair in PAIRS:
        values = silhouettes(dataset, pair)
        names = " with ".join("_".join(name) for name in pair)
        print(f"  {names}: " + ", ".join(f"{metric} {value:.3f}" for metric, value in values.items()))

    print("\n3.4: mean share of frames in the right one of two clusters, 100 pairs of a walk and a run")
    for metric in METRICS:
        values, larger = clustering(dataset, metric, np.random.default_rng(0))
        paper = {"angle": "   paper: 60 %", "spatial": "   paper: 65 %"}.get(metric, "")
        missing = np.isnan(values).sum()
        print(f"  {metric:<10}{np.nanmean(values):>8.1%}   no such bandwidth: {missing:>3} pairs{paper}")
    print(f"  the larger class alone: {larger:.1%}")


if __name__ == "__main__":
    main()
