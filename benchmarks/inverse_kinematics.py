"""Inverse kinematics: does it find exact positions again, and how fast? Against scipy's least squares, and mink.

    pip install "skpose[bench]"
    python benchmarks/inverse_kinematics.py [--cmu FOLDER OF CMU FILES] [--hdm05 FOLDER OF HDM05 FILES] [--quick]

Positions are those of all joints in the world, of all frames. "Warm" frames are sequences: each starts from the frame
before. "Cold" frames start from the rest pose, each by itself. In the race all contestants get the same frames, start
from the same poses, take turns on one thread, and their answers are checked in the same run. Times on one thread are
processor times, so that other work on the machine counts little; those on two threads are elapsed. Compilation is
apart. Without folders motions are generated gait.
"""

import time
import warnings
from functools import partial
from typing import NamedTuple

import common
import least_squares
import numpy as np
import robotics
from scipy.spatial.transform import Rotation
from threadpoolctl import threadpool_limits

from skpose import forward_kinematics, inverse_kinematics
from skpose.datasets import load_cmu, load_hdm05, make_gait

SEED, EXACT = 0, 1e-6  # m


class Size(NamedTuple):
    repeats: int
    cold_step: int  # every so many frames are also fitted by themselves
    n_runs: int  # in the warm race, of so many frames each
    n_frames: int
    n_cold: int  # frames in the cold race


FULL, QUICK = Size(3, 10, 4, 50, 40), Size(1, 25, 1, 4, 2)


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
    """Print the times of all contestants on the same frames, warm and cold, and how near they come."""
    rng = np.random.default_rng(SEED)
    chosen = [i for i, motion in enumerate(dataset) if motion.skeleton == dataset[0].skeleton]
    motions = [dataset[i] for i in rng.permutation(chosen)[: size.n_runs]]
    skeleton = motions[0].skeleton
    runs = []
    for motion in motions:
        first = rng.integers(1, len(motion) - size.n_frames)
        before = motion[first - 1 : first]
        root = Rotation.from_euler(motion.root_axes, before.root_angles).as_rotvec()[0]
        start = np.concatenate([before.root_positions[0], root, before.angles[0]])
        runs.append((start, world(motion[first : first + size.n_frames])))
    everything = np.concatenate([world(motion) for motion in motions])
    frames = everything[rng.choice(len(everything), size.n_cold, replace=False)]
    starts = np.array([least_squares.aligned(skeleton, positions) for positions in frames])
    contestants = {"skpose": (warm_by_skpose, cold_by_skpose)}
    for name, solver in {**least_squares.solvers(skeleton), **robotics.solvers(skeleton)}.items():
        if isinstance(solver, str):
            print(f"{name}: {solver}")
            continue
        contestants[name] = (
            lambda skeleton, runs, solver=solver: np.concatenate([in_turn(solver, *run) for run in runs]),
            lambda skeleton, pairs, solver=solver: np.array(
                [solver(start, p) for start, p in zip(*pairs, strict=True)]
            ),
        )
    given = np.concatenate([positions for _, positions in runs])
    for k, (name, data, expected) in enumerate([("warm", runs, given), ("cold", (starts, frames), frames)]):
        answers = {}

        def take(tool, k=k, data=data, answers=answers):
            answers[tool] = contestants[tool][k](skeleton, data)

        with threadpool_limits(1), warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # scipy's angles may grow to thousands of turns
            functions = {tool: lambda tool=tool: take(tool) for tool in contestants}
            seconds = common.medians(functions, size.repeats, time.process_time)
        print(f"\n{name}, {len(expected)} frames, one thread")
        print(f"{'':<34}{'ms a frame':>12}{'x skpose':>12}{'most, m':>12}{'median, m':>12}{'> 1e-6 m':>10}")
        for tool, value in seconds.items():
            off = np.linalg.norm(answers[tool] - expected, axis=2).max(axis=1)
            print(
                f"{tool:<34}{1e3 * value / len(expected):>12.3f}{value / seconds['skpose']:>12.1f}{off.max():>12.1e}"
                f"{np.median(off):>12.1e}{(off > EXACT).sum():>10}"
            )
            if tool == "skpose" and name == "warm":
                assert off.max() < EXACT


def in_turn(solver, start, positions):
    """Return the positions that a solver finds in a run of frames, each from the frame before."""
    found = []
    for given in positions:
        found.append(solver(start, given))
        start = solver.last
    return found


def warm_by_skpose(skeleton, runs):
    found = [
        inverse_kinematics(positions, skeleton, initial=start[least_squares.N_ROOT :], n_jobs=1)
        for start, positions in runs
    ]
    return np.concatenate([in_the_world(one) for one in found])


def cold_by_skpose(skeleton, pairs):
    starts, frames = pairs
    initial = np.zeros((len(starts), skeleton.n_dofs))
    return in_the_world(inverse_kinematics(frames, skeleton, initial=initial, n_jobs=1))


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
        datasets["CMU"] = load_cmu(options.cmu)
    if options.hdm05:
        datasets["HDM05"] = load_hdm05(options.hdm05)
    gait = {"generated gait": make_gait(*((1, 1) if options.quick else (5, 4)), random_state=SEED)}
    for name, dataset in (datasets or gait).items():
        print(f"\n{name}: {dataset}\n{dataset[0].skeleton}")
        every_frame(dataset, size)
        race(dataset, size)


if __name__ == "__main__":
    main()
