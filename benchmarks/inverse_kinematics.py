"""Inverse kinematics: does it find exact positions again, and how fast? Against scipy's least squares.

    pip install "skpose[bench]"
    python benchmarks/inverse_kinematics.py [--cmu FOLDER OF CMU FILES] [--hdm05 FOLDER OF HDM05 FILES] [--quick]

Positions are those of all joints in the world, of all frames. "Warm" frames are sequences: each starts from the frame
before. "Cold" frames start from the rest pose. In the race the frames and starts are the same for all. Times on one
thread are CPU times, those on two threads are elapsed; compilation is not counted. Without folders motions are
generated gait.
"""

import time
import warnings
from functools import partial
from typing import NamedTuple

import common
import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from threadpoolctl import threadpool_limits

from skpose import forward_kinematics, inverse_kinematics
from skpose.datasets import load_cmu, load_hdm05, make_gait
from skpose.kinematics import position_jacobian

SEED, EXACT = 0, 1e-6  # m


class Size(NamedTuple):
    repeats: int
    cold_step: int  # every so many frames are also fitted by themselves
    n_cold: int  # frames in the race


FULL, QUICK = Size(3, 10, 40), Size(1, 25, 2)


def world(motion):
    """Return positions (n_frames, n_joints, 3) in the world, from the definition."""
    rotations = Rotation.from_euler(motion.root_axes, motion.root_angles).as_matrix()
    positions = forward_kinematics(motion.angles, motion.skeleton)
    return np.einsum("nij,nkj->nki", rotations, positions) + motion.root_positions[:, None]


def by_person(dataset):
    """Yield skeleton, positions and lengths of the sequences of each person."""
    for subject in dict.fromkeys(dataset.subjects):
        motions = [motion for motion, other in zip(dataset, dataset.subjects, strict=True) if other == subject]
        positions = np.concatenate([world(motion) for motion in motions])
        yield motions[0].skeleton, positions, [len(motion) for motion in motions]


def every_frame(dataset, size):
    """Print distances and speed of all frames, warm, and of some of them cold."""
    people = list(by_person(dataset))
    cold = [(skeleton, positions[:: size.cold_step]) for skeleton, positions, _ in people]

    def warm(n_jobs):
        return [inverse_kinematics(p, skeleton, lengths=n, n_jobs=n_jobs) for skeleton, p, n in people]

    def alone(n_jobs):
        return [
            inverse_kinematics(p, skeleton, initial=np.zeros((len(p), skeleton.n_dofs)), n_jobs=n_jobs)
            for skeleton, p in cold
        ]

    for name, solve in {"warm": warm, "cold": alone}.items():
        fitted = solve(2)  # compiles
        residuals = np.concatenate([one.residuals for one in fitted])
        given = [p for _, p, _ in people] if solve is warm else [p for _, p in cold]
        for one, positions in zip(fitted, given, strict=True):
            rotations = Rotation.from_rotvec(one.root_rotations).as_matrix()
            found = np.einsum("nij,nkj->nki", rotations, forward_kinematics(one.poses, one.skeleton))
            distances = np.linalg.norm(found + one.root_positions[:, None] - positions, axis=2)
            np.testing.assert_allclose(one.residuals, distances, atol=1e-9)
        n, worst = len(residuals), residuals.max(axis=1)
        left = n - sum(one.converged.sum() for one in fitted)
        iterations = np.mean(np.concatenate([one.n_iter for one in fitted]))
        one = common.medians({1: partial(solve, 1)}, size.repeats, time.process_time)[1]
        two = common.medians({n_jobs: partial(solve, n_jobs) for n_jobs in (1, 2)}, size.repeats)
        print(
            f"{name}: {n} frames, at most {worst.max():.1e} m off, {(worst > EXACT).sum()} of them by more than "
            f"{EXACT:g} m, {left} not converged, {iterations:.1f} iterations; {n / one:,.0f} frames/s on one thread "
            f"({n / two[1]:,.0f} by the clock), {n / two[2]:,.0f} on two, {two[1] / two[2]:.2f} times"
        )
        if solve is warm:
            assert worst.max() < EXACT


def race(dataset, size):
    """Print the time of skpose and of scipy's least squares on the same frames and starts, and the distances left."""
    rng = np.random.default_rng(SEED)
    skeleton = dataset[0].skeleton
    everything = np.concatenate([world(motion) for motion in dataset if motion.skeleton == skeleton])
    frames = everything[rng.choice(len(everything), size.n_cold, replace=False)]
    contestants = {
        "skpose": lambda: in_the_world(
            inverse_kinematics(frames, skeleton, initial=np.zeros((len(frames), skeleton.n_dofs)), n_jobs=1)
        )
    }
    for method in ("lm", "trf"):
        contestants[f'scipy least_squares, "{method}"'] = lambda method=method: np.array(
            [by_scipy(skeleton, given, method) for given in frames]
        )
    with threadpool_limits(1), warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # scipy's angles may grow to thousands of turns
        answers = {tool: solve() for tool, solve in contestants.items()}
        seconds = common.medians(contestants, size.repeats, time.process_time)
    print(f"\ncold, {len(frames)} frames, one thread")
    print(f"{'':<34}{'ms a frame':>12}{'x skpose':>12}{'most, m':>12}{'median, m':>12}{'> 1e-6 m':>10}")
    for tool, value in seconds.items():
        off = np.linalg.norm(answers[tool] - frames, axis=2).max(axis=1)
        print(
            f"{tool:<34}{1e3 * value / len(frames):>12.3f}{value / seconds['skpose']:>12.1f}{off.max():>12.1e}"
            f"{np.median(off):>12.1e}{(off > EXACT).sum():>10}"
        )


def by_scipy(skeleton, given, method):
    """Positions that scipy finds from the rest pose at the best rigid fit, with the closed-form Jacobian."""
    rest = forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton)[0]
    rotation, _ = Rotation.align_vectors(given - given.mean(axis=0), rest - rest.mean(axis=0))
    origin = given.mean(axis=0) - rotation.apply(rest.mean(axis=0))

    def positions(x):
        turn = (Rotation.from_rotvec(x[3:6]) * rotation).as_matrix()
        return forward_kinematics(x[None, 6:], skeleton)[0] @ turn.T + x[:3]

    def jacobian(x):
        turned = positions(x) - x[:3]
        turn = (Rotation.from_rotvec(x[3:6]) * rotation).as_matrix()
        J = np.empty((skeleton.n_joints, 3, len(x)))
        J[:, :, :3] = np.eye(3)
        J[:, :, 3:6] = np.cross(left_jacobian(x[3:6]).T, turned[:, None]).transpose(0, 2, 1)
        J[:, :, 6:] = turn @ position_jacobian(x[None, 6:], skeleton)[0].reshape(skeleton.n_joints, 3, -1)
        return J.reshape(3 * skeleton.n_joints, -1)

    start = np.concatenate([origin, np.zeros(3 + skeleton.n_dofs)])
    found = least_squares(lambda x: (positions(x) - given).ravel(), start, jacobian, method=method)
    return positions(found.x)


def left_jacobian(v):
    """The matrix from the rate of a rotation vector to the angular velocity in the axes of the world."""
    angle, K = np.linalg.norm(v), np.cross(np.eye(3), v)
    if angle < 1e-4:
        return np.eye(3) + K / 2 + K @ K / 6
    return np.eye(3) + (1 - np.cos(angle)) / angle**2 * K + (angle - np.sin(angle)) / angle**3 * K @ K


def in_the_world(fitted):
    """Return the positions of fitted poses, from the definition."""
    rotations = Rotation.from_rotvec(fitted.root_rotations).as_matrix()
    positions = forward_kinematics(fitted.poses, fitted.skeleton)
    return np.einsum("nij,nkj->nki", rotations, positions) + fitted.root_positions[:, None]


def main():
    options = common.parser_of_both(__doc__).parse_args()
    common.print_machine()
    size = QUICK if options.quick else FULL
    datasets = {}
    if options.cmu:
        datasets["CMU"] = load_cmu(options.cmu, rotations="file")
    if options.hdm05:
        datasets["HDM05"] = load_hdm05(options.hdm05, rotations="file")
    gait = {"generated gait": make_gait(*((1, 1) if options.quick else (5, 4)), rotations="file", random_state=SEED)}
    for name, dataset in (datasets or gait).items():
        print(f"\n{name}: {dataset}\n{dataset[0].skeleton}")
        every_frame(dataset, size)
        race(dataset, size)


if __name__ == "__main__":
    main()
