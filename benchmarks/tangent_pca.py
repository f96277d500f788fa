"""Principal components of poses: error of the joints and of bone lengths, on people who were not in fit.

    python benchmarks/tangent_pca.py [--cmu FOLDER OF CMU FILES --hdm05 FOLDER OF HDM05 FILES] [--quick]

All frames at 12 Hz, CMU with Euler angles and HDM05 with ball joints, each person's poses from components of all
others'. The error is the root mean square of the distances of joints, over joints and frames; of all people, and the
median of the people's own. Bones are measured in the poses of the scores: the largest error of a length, in any frame.

- "angles": scikit-learn's PCA of the columns as they are; "angles, wrapped": of Euler angles wrapped about their
  circular mean;
- "positions": scikit-learn's PCA of the positions of all joints, which need not be a pose;
- "tangent": `PoseTangentPCA`, metric="position"; "tangent, geodesic": metric="geodesic", on every so-many-th frame.

Without folders it runs on generated gait, and checks the answers.
"""

import time
from typing import NamedTuple

import common
import numpy as np
from sklearn.decomposition import PCA

from skpose import Skeleton, forward_kinematics
from skpose.datasets import load_cmu, load_hdm05, make_gait
from skpose.statistics import PoseTangentPCA

RATE = 12  # Hz
COMPONENTS = (2, 3, 5, 8, 12, 20)
FIT, TEST = 60, 30  # poses of a person on which geodesics are tried, in fit and out of it


class Result(NamedTuple):
    """Errors of one method, a row for each person left out, a column for each number of components."""

    squared: np.ndarray  # sum of the squared distances of joints, m²
    count: np.ndarray  # joints times frames, (n_people,)
    bones: np.ndarray  # largest error of a bone's length, m
    relative: np.ndarray  # the same, relative to the bone


class Angles:
    """PCA of the columns, wrapped about their circular mean or as they are."""

    def __init__(self, skeleton, X, wraps):
        names = skeleton.dof_names
        self.turns = np.array([2.0 * np.pi if wraps and "_rotvec_" not in name else np.inf for name in names])
        self.centre = np.arctan2(np.sin(X).mean(axis=0), np.cos(X).mean(axis=0))
        self.skeleton, self.pca = skeleton, PCA(max(COMPONENTS)).fit(self.wrapped(X))

    def wrapped(self, X):
        turns = np.rint((X - self.centre) / self.turns)
        return X - np.where(turns == 0.0, 0.0, turns * np.where(np.isinf(self.turns), 0.0, self.turns))

    def scores(self, X, F):
        return self.pca.transform(self.wrapped(X))

    def joints(self, scores):
        return forward_kinematics(self.pca.inverse_transform(scores), self.skeleton)


class Positions:
    """PCA of the positions."""

    def __init__(self, skeleton, X):
        self.pca = PCA(max(COMPONENTS)).fit(forward_kinematics(X, skeleton).reshape(len(X), -1))

    def scores(self, X, F):
        return self.pca.transform(F.reshape(len(F), -1))

    def joints(self, scores):
        return self.pca.inverse_transform(scores).reshape(len(scores), -1, 3)


class Tangents:
    """PCA in the tangent space."""

    def __init__(self, skeleton, X, metric):
        self.skeleton = skeleton
        self.pca = PoseTangentPCA(skeleton, n_components=max(COMPONENTS), metric=metric, n_jobs=-1).fit(X)

    def scores(self, X, F):
        return self.pca.transform(X)

    def joints(self, scores):
        return forward_kinematics(self.pca.inverse_transform(scores), self.skeleton)


METHODS = {
    "angles": lambda skeleton, X: Angles(skeleton, X, wraps=False),
    "angles, wrapped": lambda skeleton, X: Angles(skeleton, X, wraps=True),
    "positions": Positions,
    "tangent": lambda skeleton, X: Tangents(skeleton, X, "position"),
    "tangent, geodesic": lambda skeleton, X: Tangents(skeleton, X, "geodesic"),
}


def bone_lengths(joints, skeleton: Skeleton):
    near = np.concatenate([joints, np.zeros_like(joints[:, :1])], axis=1)[:, skeleton.parents]  # the root is the last
    return np.linalg.norm(joints - near, axis=2)


def thinned(indices, n):
    """At most n of them, at equal intervals."""
    return indices[np.unique(np.linspace(0, len(indices) - 1, n).astype(int))]


def leave_one_out(method, skeleton, X, people, sizes=None):
    """Return the errors of each person's poses from the components of the others'; of `sizes` poses of each person."""
    found, weights = [], skeleton.weights
    true = np.linalg.norm(skeleton.offsets, axis=1)
    rows = {person: np.flatnonzero(people == person) for person in np.unique(people)}
    for person in rows:
        others = [thinned(rows[p], sizes[0]) if sizes else rows[p] for p in rows if p != person]
        left = X[thinned(rows[person], sizes[1]) if sizes else rows[person]]
        F = forward_kinematics(left, skeleton)
        fitted = METHODS[method](skeleton, X[np.concatenate(others)])
        scores = fitted.scores(left, F)
        squared, bones, relative = [], [], []
        for k in COMPONENTS:
            joints = fitted.joints(np.where(np.arange(scores.shape[1]) < k, scores, 0.0))
            squared.append(np.square(joints - F).sum(axis=2) @ weights)
            off = np.abs(bone_lengths(joints, skeleton) - true).max(axis=0)
            bones.append(off.max())
            relative.append((off[true > 0] / true[true > 0]).max())
        found.append((np.sum(squared, axis=1), weights.sum() * len(left), bones, relative))
    return Result(*(np.array(column) for column in zip(*found, strict=True)))


def report(label, skeleton, X, people, methods, sizes=None):
    """Print a table of all methods, and return their results."""
    print(f"\n{label}: {len(X)} poses, {len(np.unique(people))} people, {skeleton.n_dofs} columns")
    print(f"{'':18} error (cm), k = " + "".join(f"{k:>17}" for k in COMPONENTS) + "   s")
    results = {}
    for method in methods:
        start = time.perf_counter()
        result = results[method] = leave_one_out(method, skeleton, X, people, sizes)
        seconds = time.perf_counter() - start
        all_people = 100 * np.sqrt(result.squared.sum(axis=0) / result.count.sum())
        median = 100 * np.median(np.sqrt(result.squared / result.count[:, None]), axis=0)
        cells = [f"{a:6.2f} ({m:5.2f})" for a, m in zip(all_people, median, strict=True)]
        print(f"{method:18} all (median)     " + "".join(f"{cell:>17}" for cell in cells) + f"   {seconds:.0f}")
        worst = zip(100 * result.bones.max(axis=0), 100 * result.relative.max(axis=0), strict=True)
        bones = [f"{cm:.2g} ({share:.1e} %)" if cm < 1e-6 else f"{cm:.1f} ({share:.0f} %)" for cm, share in worst]
        print(f"{'':18} worst bone, cm   " + "".join(f"{cell:>17}" for cell in bones))
    return results


def main():
    options = common.parser_of_both(__doc__).parse_args()
    common.print_machine()
    sets = {}
    if options.cmu and not options.quick:
        sets["CMU, Euler angles"] = load_cmu(options.cmu)
    if options.hdm05 and not options.quick:
        sets["HDM05, ball joints"] = load_hdm05(options.hdm05).to_rotvec()
    everyone = list(METHODS)
    for label, dataset in (sets or {"generated gait": make_gait(3, 1, random_state=0)}).items():
        skeleton, (X, sequence) = dataset.skeleton, dataset.poses(frame_rate=RATE)
        people = dataset.subjects[sequence]
        results = report(label, skeleton, X, people, everyone[:-1])
        sizes = (FIT, TEST) if sets else (12, 4)
        few = f"{label}, {sizes[0]} poses of each person in fit, {sizes[1]} out of it"
        results |= report(few, skeleton, X, people, everyone[2:], sizes)
        for method, result in results.items():
            assert method == "positions" or result.relative.max() < 1e-9, f"{method} breaks bones"
            assert np.isfinite(result.squared).all()


if __name__ == "__main__":
    main()
