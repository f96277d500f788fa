"""Exact search of motions: the nearest motions, and the best windows of long recordings, against brute force."""

import itertools
import time

import numpy as np
from common import parser_of_both, print_machine
from joblib import effective_n_jobs

from skpose import MotionKNeighborsTransformer
from skpose.datasets import load_cmu, load_hdm05, make_gait
from skpose.metrics._registry import resolve
from skpose.motions import MotionIndex, find_motion
from skpose.motions._index import SequenceIndex
from skpose.motions._inputs import Sequences
from skpose.motions._windows import WindowSearch

RATE = 12  # Hz, of the nearest motions
SECONDS = 2  # of a query
K = 10  # windows
IN_A_ROW = 20  # sequences that make one recording
METRICS = "position", "spatial"


def sequences_of(dataset, rate):
    """The poses of each motion on the mean skeleton, and that skeleton."""
    X, sequence = dataset.poses(rate)
    return [X[sequence == i] for i in range(len(dataset))], dataset.skeleton


def nearest(title, dataset, metric):
    """How many motions are aligned, and how many cells measured, to find the nearest of other people."""
    motions, skeleton = sequences_of(dataset, RATE)
    for k in (1, 5):
        alignments, cells, all_cells, n_others, seconds = 0, 0, 0, 0, {"auto": 0.0, "brute": 0.0}
        for person in np.unique(dataset.subjects):
            there = dataset.subjects == person
            queries = [motions[i] for i in np.flatnonzero(there)]
            others = [motions[i] for i in np.flatnonzero(~there)]
            answers = {}
            for algorithm in seconds:
                search = MotionKNeighborsTransformer(skeleton, metric=metric, algorithm=algorithm).fit(others)
                search.kneighbors(queries[:1], 1)
                start = time.perf_counter()
                answers[algorithm] = search.kneighbors(queries, k, return_evaluations=True)
                seconds[algorithm] += time.perf_counter() - start
            for found, expected in zip(answers["auto"][:2], answers["brute"][:2], strict=True):
                np.testing.assert_array_equal(found, expected)
            alignments += answers["auto"][2].alignments
            cells += answers["auto"][2].cells
            all_cells += answers["brute"][2].cells
            n_others += len(queries) * len(others)
        n = len(motions)
        print(
            f"{title:>12} {metric:>9}  k = {k}: {alignments / n:5.1f} of {n_others / n:.0f} motions aligned, "
            f"{100 * cells / all_cells:5.2f} % of the cells, {1e3 * seconds['auto'] / n:6.2f} ms a query, "
            f"brute force {1e3 * seconds['brute'] / n:6.2f} ms"
        )


def recordings(motions, left_out, n_frames):
    """Recordings of many sequences in a row, without one of them; reversed in time again, until there are enough."""
    parts = [motion for i, motion in enumerate(motions) if i not in left_out]
    for motion in itertools.cycle(list(parts)):
        if sum(map(len, parts)) >= n_frames:
            break
        parts.append(motion[::-1])
    return [np.concatenate(parts[i : i + IN_A_ROW]) for i in range(0, len(parts), IN_A_ROW)]


def windows(title, dataset, rate, n_frames, n_queries, metric="spatial"):
    """Time to find the best windows of a sequence of SECONDS in recordings of n_frames, by search and brute force."""
    motions, skeleton = sequences_of(dataset, rate)
    mirrored = [motion.mirrored() for motion in dataset]
    mirrored = sequences_of(type(dataset)(mirrored, dataset.subjects), rate)[0]
    long = [i for i, motion in enumerate(motions) if len(motion) >= SECONDS * rate]
    chosen = np.array(long)[np.linspace(0, len(long) - 1, n_queries).astype(int)]
    n_jobs = effective_n_jobs(-1)
    results = []
    for i in chosen:
        query = motions[i][: int(SECONDS * rate)]
        where = recordings([*motions, *mirrored], {i, i + len(motions)}, n_frames)
        start = time.perf_counter()
        index = MotionIndex(where, skeleton=skeleton, metric=metric)
        indexing = time.perf_counter() - start
        find_motion(query, index, k=1, n_jobs=-1)
        start = time.perf_counter()
        found = find_motion(query, index, k=K, n_jobs=-1)
        seconds = time.perf_counter() - start
        search = WindowSearch(index._index, n_jobs)
        search.best(query, K)
        all_cells = SequenceIndex(Sequences.of(where), skeleton, resolve(metric, skeleton), brute=True)
        brute = WindowSearch(all_cells, n_jobs)
        start = time.perf_counter()
        expected = brute.best(query, K)
        results.append(
            [indexing, seconds, time.perf_counter() - start, search.evaluations.cells / brute.evaluations.cells]
        )
        assert [match.distance for match in found] == [window.sum / len(query) for window in expected]
        assert [match.stop - match.start for match in found] == [window.stop - window.start for window in expected]
    indexing, seconds, brute_seconds, share = np.median(results, axis=0)
    most = np.max(results, axis=0)
    print(
        f"{title:>12} {metric:>9}  {sum(map(len, where)):,} frames at {rate} Hz, top {K}, {n_jobs} threads: index "
        f"{indexing:.2f} s, search {seconds:.2f} s (at most {most[1]:.2f} s), brute force {brute_seconds:.1f} s, "
        f"{100 * share:.1f} % of the cells (at most {100 * most[3]:.1f} %), median of {n_queries} queries"
    )


if __name__ == "__main__":
    options = parser_of_both(__doc__).parse_args()
    print_machine()
    datasets = {}
    if options.hdm05:
        datasets["HDM05"] = load_hdm05(options.hdm05)
    if options.cmu:
        datasets["CMU"] = load_cmu(options.cmu)
    if not datasets:
        n_subjects = 3 if options.quick else 6
        datasets["gait"] = make_gait(n_subjects, 2 if options.quick else 10, duration=3, random_state=0)
    for title, dataset in datasets.items():
        for kind, some in (("balls", dataset.to_rotvec()), ("Euler", dataset)):
            for metric in METRICS:
                nearest(f"{title}, {kind}", some, metric)
        for rate, n_frames, n_queries in ((30, 500, 1),) if options.quick else ((30, 100_000, 12), (120, 100_000, 12)):
            windows(title, dataset.to_rotvec(), rate, n_frames, n_queries)
