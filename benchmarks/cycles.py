"""Cycles: does a typical stride that is repeated walk on, with feet that stand still and no jump at the seams?

    python benchmarks/cycles.py [FOLDER OF CMU FILES] [--quick]

Of each walk the mean of its strides is closed, written as BVH, read back, and repeated three times. Strides are what
`segment_repetitions` returns, or go from the start of each to the start of the next one ("whole"). A foot stands while
its joint moves along the floor by less than 0.4 m/s for a fifth of a second; its slide is the largest distance from
where it stands in the mean, its median over all stances. The jump at the seams is the largest movement of a joint
between the two frames at a seam, relative to that between any two frames of the recording. Travel is relative to the
mean distance from the start of a stride to that of the next. Without a folder the walks are generated, on feet that
stand.
"""

import tempfile
import warnings
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import common
import numpy as np

from skpose import forward_kinematics
from skpose.datasets import load_cmu, make_gait
from skpose.io import load_bvh, save_bvh
from skpose.motions import mean_motion, segment_repetitions
from skpose.skeleton._shared import root_orientations

SLOW = 0.4  # m/s
SHORTEST = 0.2  # s
ON_FLOOR = [0, 2]
FEET = [("lfoot", "rfoot"), ("left_foot", "right_foot")]


def positions(motion):
    """Positions of the joints in the world, m."""
    at = forward_kinematics(motion.angles, motion.skeleton)
    turned = np.einsum("nab,njb->nja", root_orientations(motion.root_angles, motion.root_axes).as_matrix(), at)
    return turned + motion.root_positions[:, None]


def feet(motion):
    names = motion.skeleton.joint_names
    return positions(motion)[:, [names.index(name) for pair in FEET for name in pair if name in names]]


def stances(motion):
    """The slide of each foot, m, and its height, m, each time that it stands."""
    found = []
    for foot in feet(motion).transpose(1, 0, 2):
        slow = np.linalg.norm(np.diff(foot[:, ON_FLOOR], axis=0), axis=1) * motion.frame_rate < SLOW
        for rows in np.split(np.arange(len(slow)), np.flatnonzero(np.diff(slow)) + 1):
            if slow[rows[0]] and len(rows) >= SHORTEST * motion.frame_rate:
                off = np.linalg.norm(foot[rows][:, ON_FLOOR] - foot[rows][:, ON_FLOOR].mean(axis=0), axis=1)
                found.append((off.max(), foot[rows, 1].mean()))
    return np.array(found).reshape(-1, 2)


def steps(motion):
    """The largest movement of a joint from each frame to the next, m."""
    return np.linalg.norm(np.diff(positions(motion), axis=0), axis=2).max(axis=1)


def stand(motion):
    """A generated walk, its root moved so that the lower foot stands: generated people walk on the spot."""
    at = feet(motion)
    rows, lower = np.arange(len(at)), at[..., 1].argmin(axis=1)
    moves = at[rows[:-1], lower[:-1]] - at[rows[1:], lower[:-1]]
    places = np.concatenate([np.zeros((1, 3)), moves.cumsum(axis=0)])
    places[:, 1] = -at[rows, lower, 1]
    return replace(motion, root_positions=places)


def walks(options):
    """Walks with their names."""
    if options.folder:
        dataset = load_cmu(options.folder)
        dataset = dataset[dataset.actions == "walk"][: 4 if options.quick else None]
        return [
            (f"{subject}_{trial}", walk)
            for subject, trial, walk in zip(dataset.subjects, dataset.trials, dataset, strict=True)
        ]
    gait = make_gait(2 if options.quick else 8, 1, activities=["walk"], duration=6, frame_rate=30, random_state=0)
    return [(subject, stand(walk)) for subject, walk in zip(gait.subjects, gait, strict=True)]


def main():
    options = common.start(__doc__)
    print(f"\n{'':<8}{'':<7}{'strides':>8}{'warned':>8}{'slide, recording':>18}{'loop':>9}", end="")
    print(f"{'height, recording':>20}{'loop':>9}{'jump at seams':>15}{'travel':>8}")
    for name, walk in walks(options):
        found = segment_repetitions(walk, metric="position")
        if len(found) < 3:
            continue
        apart = np.diff(walk.root_positions[found.starts], axis=0)[:, ON_FLOOR]
        whole = [walk[start : stop + 1] for start, stop in pairwise(found.starts)]
        for kind, strides in (("slices", found.motions), ("whole", whole)):
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                cycle = mean_motion(strides).to_motion().to_cycle(endpoint=kind == "whole")
            with tempfile.TemporaryDirectory() as folder:
                save_bvh(Path(folder) / "cycle.bvh", cycle)
                read = load_bvh(Path(folder) / "cycle.bvh")
            loop = cycle.repeat(3)
            np.testing.assert_allclose(read.repeat(3).root_positions, loop.root_positions, atol=1e-6)
            before, after = stances(walk), stances(loop)
            at = (len(cycle) - 1) * np.arange(1, 3)
            jump = max(steps(loop)[at - 1].max(), steps(loop)[at].max()) / steps(walk).max()
            travel = np.linalg.norm((cycle.root_positions[-1] - cycle.root_positions[0])[ON_FLOOR])
            print(f"{name:<8}{kind:<7}{len(strides):>8}{'yes' if caught else '':>8}", end="")
            for column, width in ((0, 15), (1, 17)):
                for one, wide in ((before, width), (after, 6)):
                    print(f"{100 * np.median(one[:, column]) if len(one) else np.nan:>{wide}.1f} cm", end="")
            print(f"{jump:>15.2f}{travel / np.linalg.norm(apart, axis=1).mean():>8.2f}")


if __name__ == "__main__":
    main()
