"""The picture of `skpose compare --out`: a pose of each action, and how often actions are recognised."""

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from skpose._cli.compare import Result, warp_all
from skpose.datasets import MotionDataset
from skpose.kinematics import forward_kinematics
from skpose.metrics import pose_distances
from skpose.plot._shared import COLOURS, SIDES
from skpose.skeleton import Motion
from skpose.skeleton._shared import sides

N_SHOWN = 12  # actions
LEAST_PLACES = 6  # for them, so that few are not drawn large
VIEW = np.radians(55.0)  # from which people are seen, from the front towards their left
# The axes of a person, left, up and ahead, by the axis of the world that points up.
UPRIGHT = {
    "x": np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    "y": np.eye(3),
    "z": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]),
}
GAP, WIDTH = 0.2, 11  # between two figures, m; of their names, letters
FRAMES, MOTIONS = COLOURS[4], COLOURS[0]


def draw(dataset: MotionDataset, rows: Sequence[Result], path: Path) -> None:
    """Draw prepared motions, and the results on them, to a PNG file."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 5.6), layout="constrained")
    above, below = figure.subplots(2, 1, height_ratios=[1.0, 1.5])
    _draw_figures(above, dataset)
    _draw_bars(below, dataset, rows)
    figure.savefig(path, format="png", dpi=150)


def _draw_figures(ax: Any, dataset: MotionDataset) -> None:
    """Draw a pose of each action: of the motion nearest to all others of it, the pose farthest from all poses."""
    X, sequence = dataset.poses()
    D = pose_distances(X, skeleton=dataset.skeleton, metric="position")
    frames = np.split(np.arange(len(X)), np.searchsorted(sequence, np.arange(1, len(dataset))))
    of_motions, usual = warp_all(D, frames), D.mean(axis=1)
    actions, poses = sorted(set(dataset.actions)), []
    for action in actions[:N_SHOWN]:
        those = np.flatnonzero(dataset.actions == action)
        typical = int(those[of_motions[np.ix_(those, those)].sum(axis=1).argmin()])
        poses.append(see(dataset[typical], int(usual[frames[typical]].argmax())))
    step = GAP + max(float(np.ptp(seen[..., 0])) for seen, _ in poses)
    for k, (action, (seen, side)) in enumerate(zip(actions, poses, strict=False)):
        seen[..., 0] += k * step - (seen[..., 0].min() + seen[..., 0].max()) / 2.0
        for name, colour in SIDES.items():
            some = seen[side == name]
            lines = np.concatenate([some, np.full((len(some), 1, 2), np.nan)], axis=1)
            ax.plot(*lines.reshape(-1, 2).T, color=colour, linewidth=2.2, solid_capstyle="round", clip_on=False)
        ax.text(k * step, -0.12, textwrap.fill(action, WIDTH), ha="center", va="top", fontsize=8.5)
    if len(actions) > N_SHOWN:
        ax.text((len(poses) - 0.5) * step, 0.7, f"and {len(actions) - N_SHOWN}\nmore", va="center", fontsize=8.5)
    ax.axhline(0.0, color="0.8", linewidth=0.8, zorder=0)
    empty = max(LEAST_PLACES - len(poses), 0) / 2.0  # on each side
    ax.set(aspect="equal", ylim=(-0.6, None), xlim=((-0.5 - empty) * step, (len(poses) - 0.5 + empty) * step))
    ax.axis("off")


def see(motion: Motion, frame: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the bones (n_joints, 2 ends, 2) of a pose that stands on the ground, m, and sides."""
    motion = motion[frame : frame + 1].with_root("tilt")
    P = forward_kinematics(motion.angles, motion.skeleton)[0] @ UPRIGHT[motion.up].T
    flat = np.stack([P[:, 0] * np.cos(VIEW) - P[:, 2] * np.sin(VIEW), P[:, 1]], axis=1)
    flat = np.concatenate([flat, np.zeros((1, 2))])
    flat -= [0.0, flat[:, 1].min()]
    return np.stack([flat[:-1], flat[motion.skeleton.parents]], axis=1), np.array(sides(motion.skeleton.joint_names))


def _draw_bars(ax: Any, dataset: MotionDataset, rows: Sequence[Result]) -> None:
    """Draw the shares that are recognised, among other people, or of a single one among other motions."""
    alone = len(set(dataset.subjects)) < 2
    for k, (label, colour) in enumerate((("poses", FRAMES), ("whole motions", MOTIONS))):
        shares = 100.0 * np.array([row[1:5] for row in rows])[:, 2 * alone + k]
        places = np.arange(len(rows)) + 0.3 * (k - 0.5)
        bars = ax.bar(places, shares, 0.28, color=colour, label=label, zorder=2)
        ax.bar_label(bars, fmt="%.1f", padding=2, fontsize=10)
    y = dataset.actions
    largest = 100.0 * max(np.mean(y == action) for action in set(y))
    ax.axhline(largest, color="0.4", linewidth=1.0, linestyle=":", zorder=3)
    where = {"transform": ax.get_yaxis_transform(), "va": "center", "fontsize": 9, "color": "0.3"}
    ax.text(1.015, largest, f"the most frequent\naction: {largest:.0f} %", **where)
    ax.set_xticks(range(len(rows)), [row.metric for row in rows], fontsize=11)
    ax.set(xlim=(-0.6, len(rows) - 0.4), ylim=(0.0, 109.0), ylabel="recognised, %")
    ax.set_yticks(range(0, 101, 20))
    whose = "other motions" if alone else "other people"
    counts = f"{len(set(y))} actions, {len(dataset)} motions, {len(set(dataset.subjects))} people"
    ax.set_title(f"The nearest neighbour among {whose} does the same: {counts}", loc="left", fontsize=11)
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=10)
    ax.spines[["top", "right"]].set_visible(False)
    ax.tick_params(axis="x", length=0)
