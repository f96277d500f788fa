"""Poses predicted from the positions of hands, feet and head, for people who are not in the training data.

    python benchmarks/regression.py [--cmu FOLDER OF CMU FILES] [--hdm05 FOLDER OF HDM05 FILES] [--quick]

Protocol: all sequences of HDM05 at 4 Hz, and the walks and runs of CMU at 12 Hz, on the mean skeleton. The features are
the positions of five joints relative to the root, 15 numbers. Each person is left out in turn; the parameters of every
model are searched for among the others, by `GridSearchCV`, leaving one of them out in turn. The error is the mean
distance between predicted and true positions of all joints, cm, and of the 5 % worst frames; the bone error is the
largest difference between the length of a predicted bone and its length on the skeleton, cm.

Models of angles predict the Euler angles of the files, models of positions the coordinates of all joints.
`PoseKernelRegressor` works on ball joints. Without folders the poses are generated gait.
"""

import time
import warnings
from typing import NamedTuple

import common
import numpy as np
from sklearn.linear_model import Ridge
from sklearn.model_selection import GridSearchCV, LeaveOneGroupOut
from sklearn.neighbors import KNeighborsRegressor

from skpose import Motion, forward_kinematics
from skpose.datasets import load_cmu, load_hdm05, make_gait, walks_and_runs
from skpose.statistics import PoseKernelRegressor

ENDS = ("hand", "foot", "head")
GAMMAS = [10.0, 30.0, 100.0, 300.0, 1000.0]  # 1/m²; widths of the kernel from 22 to 2 cm
NEIGHBORS = [1, 3, 5, 10]
ALPHAS = [1e-4, 1e-2, 1.0]
WORST = 0.95  # quantile of frames
RATE_OF_WALKS, RATE_OF_ACTIONS, QUICK_RATE = 12, 4, 4  # Hz


class Task(NamedTuple):
    """Features, and targets in three forms."""

    features: np.ndarray  # (n_poses, 15) m
    targets: dict[str, np.ndarray]  # by name of the form
    positions: np.ndarray  # (n_poses, n_joints, 3) m
    subjects: np.ndarray
    skeleton: object
    balls: object  # the skeleton of ball joints

    def to_positions(self, form, predicted):
        """Return the joint positions of predicted targets."""
        if form == "positions":
            return predicted.reshape(len(predicted), -1, 3)
        return forward_kinematics(predicted, self.balls if form == "poses" else self.skeleton)


def task(dataset, rate):
    X, sequence = dataset.poses(rate)
    on_balls = Motion(dataset.skeleton, X, rate).to_rotvec()
    skeleton, poses, balls = dataset.skeleton, on_balls.angles, on_balls.skeleton
    positions = forward_kinematics(X, skeleton)
    assert np.allclose(positions, forward_kinematics(poses, balls), atol=1e-9)
    ends = [j for j, name in enumerate(skeleton.joint_names) if name.endswith(ENDS)]
    assert len(ends) == 5
    flat = positions.reshape(len(X), -1)
    targets = {"angles": X, "positions": flat, "poses": poses}
    return Task(positions[:, ends].reshape(len(X), -1), targets, positions, dataset.subjects[sequence], skeleton, balls)


def models(balls):
    """Estimators with the form of their targets and their grids."""
    ridge = {"alpha": ALPHAS}
    yield "Ridge, angles", "angles", Ridge(), ridge
    yield "Ridge, positions", "positions", Ridge(), ridge
    for form in ("angles", "positions"):
        grid = {"n_neighbors": NEIGHBORS, "weights": ["uniform", "distance"]}
        yield f"KNeighborsRegressor, {form}", form, KNeighborsRegressor(), grid
    grid = {"gamma": GAMMAS, "n_neighbors": [5, None]}
    yield "PoseKernelRegressor, angle", "angles", PoseKernelRegressor(metric="angle"), grid
    yield "PoseKernelRegressor, position", "poses", PoseKernelRegressor(balls, n_jobs=-1), grid


def lengths(positions, skeleton):
    """The lengths of all bones (n_poses, n_joints), m."""
    positions = np.concatenate([positions, np.zeros((len(positions), 1, 3))], axis=1)  # the last is the root
    return np.linalg.norm(positions[:, :-1] - positions[:, skeleton.parents], axis=2)


def study(title, given):
    """Print the errors of all models."""
    people = np.unique(given.subjects)
    print(f"\n{title}: {len(given.features)} poses, {len(people)} people, each left out in turn")
    print(f"{'error in cm':<32}{'mean':>8}{'5 % worst':>12}{'bone':>9}{'s':>9}")
    exact = np.linalg.norm(given.skeleton.offsets, axis=1)
    for name, form, model, grid in models(given.balls):
        predicted, start = np.empty_like(given.positions), time.perf_counter()
        for person in people:
            known = given.subjects != person
            search = GridSearchCV(model, grid, cv=LeaveOneGroupOut(), error_score="raise")
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of matrices that are close to singular, for the least alpha
                search.fit(given.features[known], given.targets[form][known], groups=given.subjects[known])
            predicted[~known] = given.to_positions(form, search.predict(given.features[~known]))
        seconds = time.perf_counter() - start
        frames = 100 * np.linalg.norm(predicted - given.positions, axis=2).mean(axis=1)
        bone = 100 * np.abs(lengths(predicted, given.skeleton) - exact).max()
        worst = frames[frames >= np.quantile(frames, WORST)].mean()
        assert form == "positions" or bone < 1e-6
        print(f"{name:<32}{frames.mean():>8.2f}{worst:>12.2f}{bone:>9.2f}{seconds:>9.1f}")


def main():
    options = common.parser_of_both(__doc__).parse_args()
    common.print_machine()
    gait = make_gait(3, 1, duration=2 if options.quick else 6, random_state=0)
    walks = walks_and_runs(load_cmu(options.cmu) if options.cmu else gait)
    rate = QUICK_RATE if options.quick else RATE_OF_WALKS
    study("Walks and runs" + ", CMU" * bool(options.cmu) + f", {rate} Hz", task(walks, rate))
    if options.hdm05:
        study(f"Actions, HDM05, {RATE_OF_ACTIONS} Hz", task(load_hdm05(options.hdm05), RATE_OF_ACTIONS))


if __name__ == "__main__":
    main()
