"""Distances that the folds of a cross-validation share, by `memory=`, against computing them in each fold.

    python benchmarks/folds.py [--hdm05 FOLDER OF HDM05 FILES] [--quick]

Protocol: whole sequences at 12 Hz on ball joints and the mean skeleton of all, time warping under "spatial", nearest
neighbours. `cross_val_score` leaves out each person in turn, then a tenth of the sequences; `GridSearchCV` leaves out
each person for two windows and three numbers of neighbours, and then fits all. Processor time on one thread, the
programs in turns. "empty" begins with an empty folder, "filled" with that of a run before; "one matrix" computes the
distances of all sequences once, of which scikit-learn takes rows and columns. Scores are checked to be the same.
Without a folder the sequences are generated gait.
"""

import shutil
import tempfile
import time
from pathlib import Path

import common
import numpy as np
from sklearn.model_selection import GridSearchCV, KFold, LeaveOneGroupOut, cross_val_score
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline

from skpose import MotionDistanceTransformer, motion_distances
from skpose.datasets import load_hdm05, make_gait

RATE = 12  # Hz
REPEATS = 3
GRID = {"motiondistancetransformer__window": [None, 0.2], "kneighborsclassifier__n_neighbors": [1, 3, 5]}


def pipeline(skeleton, memory):
    nearest = KNeighborsClassifier(1, metric="precomputed")
    return make_pipeline(MotionDistanceTransformer(skeleton, memory=memory), nearest)


def scores(model, X, y, folds):
    return cross_val_score(model, X, y, cv=folds)


def search(model, X, y, folds):
    return GridSearchCV(model, GRID, cv=folds).fit(X, y).cv_results_["mean_test_score"]


def study(title, run, dataset, folds, folder, repeats):
    """Print the time of each program, and what lies in the folder."""
    motions, skeleton = [motion.resample(RATE) for motion in dataset], dataset.skeleton
    y, expected = dataset.actions, []

    def check(found):
        expected.append(found)
        np.testing.assert_array_equal(found, expected[0])

    def on_motions(memory):
        check(run(pipeline(skeleton, memory), motions, y, folds))

    def empty():
        shutil.rmtree(folder, ignore_errors=True)
        on_motions(folder)

    contestants = {"no memory": lambda: on_motions(None), "empty": empty, "filled": lambda: on_motions(folder)}
    if run is scores:
        nearest = KNeighborsClassifier(1, metric="precomputed")
        contestants["one matrix"] = lambda: check(run(nearest, motion_distances(motions, skeleton=skeleton), y, folds))
    seconds = common.medians(contestants, repeats, clock=time.process_time)
    files = list(folder.rglob("*.npz"))
    size = sum(path.stat().st_size for path in files) / 1e6
    print(f"{title:<34}" + "".join(f"{name}: {s:7.2f} s   " for name, s in seconds.items()), end="")
    print(f"{size:.1f} MB in {len(files)} files")
    shutil.rmtree(folder)


def main():
    arguments = common.parser(__doc__, folder=False)
    arguments.add_argument("--hdm05", help="HDM05 files, see load_hdm05")
    options = arguments.parse_args()
    common.print_machine()
    dataset = load_hdm05(options.hdm05) if options.hdm05 else make_gait(3, 4, duration=2, random_state=0)
    dataset, repeats = dataset.to_rotvec(), 1 if options.quick else REPEATS
    if options.quick:
        dataset = dataset[:: max(1, len(dataset) // 12)]
    print(f"{len(dataset)} sequences of {len(np.unique(dataset.subjects))} people")
    people = list(LeaveOneGroupOut().split(dataset.subjects, groups=dataset.subjects))
    tenths = list(KFold(10, shuffle=True, random_state=0).split(dataset.subjects))
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "distances"
        study("scores, people left out", scores, dataset, people, folder, repeats)
        study("scores, ten folds", scores, dataset, tenths, folder, repeats)
        study("grid search, people left out", search, dataset, people, folder, repeats)


if __name__ == "__main__":
    main()
