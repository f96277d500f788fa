"""The picture of `skpose compare --out`: a pose of each action, and the accuracies."""

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from skpose._cli.studies.compare import Result, warp_all
from skpose.datasets import MotionDataset
from skpose.metrics import pose_distances
from skpose.plot import PoseStripDisplay
from skpose.plot._axes import COLOURS
from skpose.skeleton import Motion

N_SHOWN = 12  # actions
WIDTH = 11  # of their names, letters


def draw(dataset: MotionDataset, results: Sequence[Result], path: Path) -> None:
    """Draw prepared motions, and the results on them, to a PNG file."""
    figure = Figure(figsize=(10.0, 5.6), layout="constrained")
    above, below = figure.subplots(2, 1, height_ratios=[1.0, 1.5])
    _draw_poses(above, dataset)
    _draw_bars(below, dataset, results)
    figure.savefig(path, format="png", dpi=150)


def _draw_poses(ax: Any, dataset: MotionDataset) -> None:
    """Draw, of the motion nearest to all others of an action, the pose farthest from all poses."""
    X, sequence = dataset.poses()
    D = pose_distances(X, skeleton=dataset.skeleton, metric="position")
    frames = np.split(np.arange(len(X)), np.searchsorted(sequence, np.arange(1, len(dataset))))
    of_motions, distances = warp_all(D, frames), D.mean(axis=1)
    actions, poses = sorted(set(dataset.actions))[:N_SHOWN], []
    upright = dataset.retarget(dataset.skeleton).with_root("tilt")
    for action in actions:
        same = np.flatnonzero(dataset.actions == action)
        typical = int(same[of_motions[np.ix_(same, same)].sum(axis=1).argmin()])
        frame = int(distances[frames[typical]].argmax())
        poses.append(upright[typical][frame : frame + 1])
    PoseStripDisplay.from_motion(Motion.concatenate(poses), n_poses=len(poses), ax=ax)
    ax.set_xticks(ax.get_xticks(), [textwrap.fill(action, WIDTH) for action in actions])
    ax.set(xlabel="", ylabel="", yticks=[])
    ax.spines[:].set_visible(False)
    ax.tick_params(length=0)


def _draw_bars(ax: Any, dataset: MotionDataset, results: Sequence[Result]) -> None:
    """Draw the accuracies among other people, or of a single person among other motions."""
    y, n_people = dataset.actions, len(set(dataset.subjects))
    names = ("frames_of_others", "motions_of_others") if n_people > 1 else ("frames", "motions")
    for k, (name, label) in enumerate(zip(names, ("poses", "whole motions"), strict=True)):
        accuracies = [100.0 * getattr(result, name) for result in results]
        bars = ax.bar(
            np.arange(len(results)) + 0.3 * (k - 0.5), accuracies, 0.28, color=COLOURS[4 * (1 - k)], label=label
        )
        ax.bar_label(bars, fmt="%.1f", padding=2)
    largest = 100.0 * max(np.mean(y == action) for action in set(y))
    ax.axhline(largest, color="0.4", linestyle=":", label=f"most frequent action: {largest:.0f} %")
    ax.set_xticks(range(len(results)), [result.metric for result in results])
    ax.set(ylim=(0.0, 109.0), ylabel="1-NN accuracy, %")
    whose = "other people" if n_people > 1 else "other motions"
    counts = f"{len(set(y))} actions, {len(dataset)} motions, {n_people} people"
    ax.set_title(f"Nearest neighbours among {whose}: {counts}", loc="left", fontsize=11)
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    ax.spines[["top", "right"]].set_visible(False)
