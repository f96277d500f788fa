"""The command that compiles before anybody waits: `skpose warm-up`."""

import os
import time
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path

import joblib
import numpy as np

from skpose._compiled.simd.cache import CACHED, cache_folders, processor
from skpose.datasets import MotionDataset, humanoid, make_gait
from skpose.geodesics import exp_map, frechet_mean, geodesic, geodesic_distances, geometric_median, log_map
from skpose.kinematics import forward_kinematics, inverse_kinematics, position_jacobian, retarget
from skpose.metrics import pose_distances, pose_metric
from skpose.motions import (
    MotionKNeighborsTransformer,
    align_motions,
    find_motion,
    mean_motion,
    motion_distances,
    segment_repetitions,
)
from skpose.neighbors import PoseKNeighborsTransformer, PoseRadiusNeighborsTransformer

DIRECT = "angle", "position", "rotation", "spatial"  # metrics that are measured directly
PRECISIONS = np.float64, np.float32


def warm_up(subjects: Sequence[str], n_jobs: int) -> None:
    """Compile all functions of some subjects, each in a process of its own, and print where numba stores them."""
    if not CACHED:
        raise ValueError(
            "numba finds no folder that it may write compiled functions to; set the environment variable "
            "NUMBA_CACHE_DIR to one, here and where skpose is used later"
        )
    folders, requested = cache_folders(), os.environ.get("NUMBA_CACHE_DIR")
    if requested and not all(folder.is_relative_to(Path(requested).absolute()) for folder in folders):
        raise ValueError(
            f"NUMBA_CACHE_DIR={requested} is no folder that numba can write to, so it would store functions in "
            f"{os.path.commonpath(folders)}: create it, or unset the variable"
        )
    began = time.monotonic()
    n_jobs = min(joblib.effective_n_jobs(n_jobs), len(subjects))
    print(f"skpose compiles for {processor()}, processes: {n_jobs}", flush=True)
    parallel = joblib.Parallel(n_jobs=n_jobs, backend="loky", batch_size=1, return_as="generator_unordered")
    for subject, seconds in parallel(joblib.delayed(_compile)(name) for name in subjects):
        print(f"{subject:<18} {seconds:6.1f} s", flush=True)
    files = [file for folder in folders for file in folder.glob("*.nb?")]
    size = sum(file.stat().st_size for file in files)
    print(f"{'in all':<18} {time.monotonic() - began:6.1f} s")
    print(f"{os.path.commonpath(folders)}: {len(files)} files of compiled functions, {size / 1e6:.0f} MB")


def _compile(subject: str) -> tuple[str, float]:
    """Call everything of a subject once; return how long that takes, s."""
    began = time.monotonic()
    motions = make_gait(n_subjects=1, n_sequences=2, duration=2.0, frame_rate=12.0, random_state=0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what the calls return does not matter
        CALLS[subject](motions)
    return subject, time.monotonic() - began


def _distances(motions: MotionDataset) -> None:
    X, skeleton = motions[0].angles, motions[0].skeleton
    forward_kinematics(X, skeleton)
    position_jacobian(X, skeleton)
    for metric in DIRECT:
        pose_metric(skeleton, metric=metric)(X[0], X[1])
        for precision in PRECISIONS:
            pose_distances(X.astype(precision), skeleton=skeleton, metric=metric)


def _neighbors(motions: MotionDataset) -> None:
    X, skeleton = motions[0].angles, motions[0].skeleton
    many = np.random.default_rng(0).normal(np.tile(X, (200, 1)), 0.1)  # enough for all that a search may do
    for metric in DIRECT:
        PoseKNeighborsTransformer(skeleton, n_neighbors=2, metric=metric).fit(many).transform(X)
        PoseRadiusNeighborsTransformer(skeleton, radius=0.1, metric=metric).fit(many).transform(X)
    PoseKNeighborsTransformer(skeleton, n_neighbors=2, metric="geodesic").fit_transform(X)


def _geodesics(motions: MotionDataset) -> None:
    X, skeleton = motions[0].angles, motions[0].skeleton
    geodesic(X[0], X[9], skeleton)
    pose_distances(X[:4], skeleton=skeleton, metric="geodesic")
    pose_metric(skeleton, metric="geodesic")(X[0], X[9])
    geodesic_distances(X[:4], X[8:10], skeleton=skeleton)
    exp_map(X[0], log_map(X[0], X[8:10], skeleton), skeleton)


def _means(motions: MotionDataset) -> None:
    X, skeleton = motions[0].angles, motions[0].skeleton
    for metric in ("position", "spatial", "geodesic"):
        frechet_mean(X[:4], skeleton, metric=metric)
        geometric_median(X[:4], skeleton, metric=metric)


def _inverse_kinematics(motions: MotionDataset) -> None:
    X, skeleton = motions[0].angles, motions[0].skeleton
    inverse_kinematics(forward_kinematics(X[:3], skeleton), skeleton)
    for method in ("orientations", "positions"):
        retarget(motions[0], humanoid(), method=method)


def _motions(motions: MotionDataset) -> None:
    for metric in DIRECT:
        motion_distances(list(motions), metric=metric)
    MotionKNeighborsTransformer(n_neighbors=1).fit_transform(list(motions))
    align_motions(*motions[:2])
    long = make_gait(n_subjects=1, n_sequences=4, duration=20.0, frame_rate=30.0, random_state=0)
    find_motion(long[0][:40], long)  # so many frames that a search bounds them first
    segment_repetitions(motions[0])
    mean_motion(list(motions))


CALLS: dict[str, Callable[[MotionDataset], None]] = {
    "geodesics": _geodesics,
    "means": _means,
    "motions": _motions,
    "inverse-kinematics": _inverse_kinematics,
    "neighbors": _neighbors,
    "distances": _distances,
}
