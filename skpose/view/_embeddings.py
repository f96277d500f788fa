"""Poses as points in the plane, by their distances."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from sklearn.manifold import TSNE, Isomap

from skpose.manifold import SpatialMDS
from skpose.metrics import Metric, pose_distances
from skpose.neighbors import PoseKNeighborsTransformer
from skpose.skeleton import Skeleton
from skpose.view._pack import pack

EMBEDDINGS = ("mds", "tsne", "isomap")
ALL, LANDMARKS = 2000, 1000  # of more poses than ALL only the distances to so many landmarks are computed
PERPLEXITY, NEIGHBORS = 30, 10  # of t-SNE and of Isomap
LEAST_OF_TSNE, MOST_OF_ISOMAP = 20, 4000  # poses


def embed(
    X: np.ndarray,
    skeleton: Skeleton,
    metrics: Sequence[Metric],
    methods: Sequence[str],
    n_jobs: int | None,
    verbose: int,
) -> list[dict[str, Any]]:
    """Data of each method and metric; all planes are flipped like the first."""
    if "tsne" in methods and len(X) < LEAST_OF_TSNE:
        raise ValueError(f"embeddings 'tsne' needs at least {LEAST_OF_TSNE} poses, got {len(X)}")
    if "isomap" in methods and len(X) > MOST_OF_ISOMAP:
        raise ValueError(f"embeddings 'isomap' takes at most {MOST_OF_ISOMAP:,} poses, got {len(X):,}")
    found: list[dict[str, Any]] = []
    first = None
    for metric in metrics:
        scaling = SpatialMDS(
            skeleton,
            n_components=2,
            metric=metric,
            landmarks=LANDMARKS if len(X) > ALL else None,
            random_state=0,
            n_jobs=n_jobs,
            verbose=verbose,
        )
        scaled = scaling.fit_transform(X)
        first = scaled if first is None else first
        scaled = _flip(scaled, first)
        for method in methods:
            if method == "mds":
                points = scaled
            elif method == "tsne":
                points = _flip(_tsne(X, skeleton, metric, scaled, n_jobs), first)
            else:
                points = _flip(_isomap(X, skeleton, metric, n_jobs), first)
            found.append(
                {
                    "metric": metric.label,
                    "method": method,
                    "unit": None if method == "tsne" else metric.unit,  # lengths of t-SNE mean nothing
                    "points": pack(points),
                    "share": float(scaling.explained_variance_ratio_.sum()) if method == "mds" else None,
                }
            )
    return found


def _flip(points: np.ndarray, like: np.ndarray) -> np.ndarray:
    """Points, mirrored along the axes that point opposite to another plane."""
    return points * np.where((points * like).sum(axis=0) < 0.0, -1.0, 1.0)


def _tsne(X: np.ndarray, skeleton: Skeleton, metric: Metric, start: np.ndarray, n_jobs: int | None) -> np.ndarray:
    perplexity = min(PERPLEXITY, (len(X) - 1) / 3)
    k = min(len(X) - 1, int(3.0 * perplexity + 1.0))
    graph = PoseKNeighborsTransformer(skeleton, n_neighbors=k, metric=metric, n_jobs=n_jobs).fit_transform(X)
    small = 1e-4 * start / (start[:, 0].std() or 1.0)
    tsne = TSNE(
        metric="precomputed", perplexity=perplexity, init=small.astype(np.float32), random_state=0, n_jobs=n_jobs
    )
    return tsne.fit_transform(graph)


def _isomap(X: np.ndarray, skeleton: Skeleton, metric: Metric, n_jobs: int | None) -> np.ndarray:
    D = pose_distances(X, skeleton=skeleton, metric=metric, n_jobs=n_jobs)
    isomap = Isomap(n_neighbors=min(NEIGHBORS, len(X) - 1), n_components=2, metric="precomputed", n_jobs=n_jobs)
    return isomap.fit_transform(D)
