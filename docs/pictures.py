"""Pictures of the start page and of the README: `python docs/pictures.py` writes them into docs/_static.

Each is written twice, for pages in light and in dark colours; what the README shows is one picture on white.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from skpose import Skeleton, SpatialMDS, forward_kinematics, geodesic, pose_distances
from skpose.datasets import humanoid, make_gait
from skpose.metrics import Geodesic
from skpose.plot import PoseDisplay

TARGET = Path(__file__).parent / "_static"
INKS = {
    "light": {"grey": "#5b6570", "blue": "#0072b2", "orange": "#d55e00"},
    "dark": {"grey": "#aab4be", "blue": "#56b4e9", "orange": "#ff8f4a"},
}
TURNS = {"shoulder": "left_upper_arm_rz", "wrist": "left_hand_rz"}
ANGLE = np.radians(60)


def turned(skeleton, column):
    """Return seven poses: one angle of a standing person grows from 0 to 60°."""
    poses = np.zeros((7, skeleton.n_dofs))
    poses[:, skeleton.dof_names.index(column)] = np.linspace(0, ANGLE, len(poses))
    return poses


def draw_turn(ax, ink, column):
    """Draw a person who turns one joint, the arm in colour, and the paths of its joints."""
    skeleton = humanoid()
    joints = forward_kinematics(turned(skeleton, column), skeleton)
    moved = np.ptp(joints, axis=0).any(axis=1)
    for k, pose in enumerate(joints):
        share = k / (len(joints) - 1)
        style = {"linewidth": 0, "markersize": 0, "alpha": 0.18 + 0.82 * share**2}
        arm = pose.copy()
        arm[~moved] = np.nan  # the bone of the first joint that moves begins at one that does not
        first = np.flatnonzero(moved)[0]
        arm[skeleton.parents[first]] = pose[skeleton.parents[first]]
        if k == 0:
            PoseDisplay.from_positions(
                pose, skeleton, ax=ax, projection="xy", color=ink["grey"], linewidth=0, markersize=0
            )
        else:
            PoseDisplay.from_positions(arm, skeleton, ax=ax, projection="xy", color=ink["orange"], **style)
    for joint in np.flatnonzero(moved):
        ax.plot(*joints[:, joint, :2].T, color=ink["blue"], linewidth=2.5)
    ax.set_aspect("equal", adjustable="box")
    ax.set(xlim=(-0.45, 1.0), ylim=(-1.0, 0.95))
    ax.set_axis_off()


def draw_walk(ax, ink):
    """Draw poses of a walk next to each other."""
    motion = make_gait(n_subjects=1, n_sequences=1, random_state=0)[0]
    frames = np.arange(6) * 4
    joints = forward_kinematics(motion.angles[frames], motion.skeleton)
    for k, pose in enumerate(joints):
        pose = np.vstack([pose, np.zeros(3)]) + 0.75 * k * np.eye(3)[2]  # the root is the last
        pose, ends = pose[:-1], pose[motion.skeleton.parents]
        for side, colour in (("", "grey"), ("right", "orange"), ("left", "blue")):
            chosen = [name.startswith(side) if side else "_" not in name for name in motion.skeleton.joint_names]
            lines = np.stack([ends, pose, np.full_like(pose, np.nan)], axis=1)[chosen].reshape(-1, 3)
            ax.plot(lines[:, 2], lines[:, 1], color=ink[colour], linewidth=2, solid_capstyle="round")
        _, y, z = pose[motion.skeleton.joint_names.index("head")]
        ax.plot(z, y, "o", color=ink["grey"], markersize=7)
    ax.set_aspect("equal")
    ax.set_axis_off()


def draw_path(ax, ink):
    """Draw the hand of an arm of three bones along the shortest path and along the straight line."""
    arm = Skeleton.chain(3)
    start, end = np.array([0.2, 0.3, 0.0]), np.array([2.4, 0.2, 0.1])
    found = geodesic(start, end, arm, metric=Geodesic(40)).resample(41)
    line = np.linspace(start, end, 41)
    for poses, colour in ((line, "blue"), (found, "orange")):
        hand = forward_kinematics(poses, arm)
        ax.plot(*hand[:, -1, :2].T, color=ink[colour], linewidth=3)
        for pose in hand[::10]:
            bones = np.vstack([np.zeros(3), pose])
            ax.plot(*bones[:, :2].T, ".-", color=ink["grey"], linewidth=1.5, alpha=0.5)
    ax.set_aspect("equal")
    ax.set_axis_off()


def draw_embedding(ax, ink):
    """Draw poses of walking and running people in the plane."""
    gait = make_gait(n_subjects=3, n_sequences=1, random_state=0)
    X, sequence = gait.poses(frame_rate=12)
    points = SpatialMDS(skeleton=gait.skeleton).fit_transform(X)
    for action, colour, marker in (("walk", "blue", "o"), ("run", "orange", "^")):
        chosen = gait.actions[sequence] == action
        ax.scatter(*points[chosen].T, s=22, color=ink[colour], marker=marker, linewidths=0, alpha=0.8)
    ax.set_aspect("equal")
    ax.set_axis_off()


def draw_angles(ax, ink):
    """Draw an arm of two bones with its two angles."""
    first, second = np.radians([40, 60])
    elbow = np.array([np.cos(first), np.sin(first)])
    hand = elbow + np.array([np.cos(first + second), np.sin(first + second)])
    ax.plot([0, 0.75], [0, 0], "--", color=ink["grey"], linewidth=1.5)
    ax.plot(*np.stack([elbow, 1.6 * elbow]).T, "--", color=ink["grey"], linewidth=1.5)
    ax.plot(*np.stack([np.zeros(2), elbow, hand]).T, color=ink["grey"], linewidth=5, solid_capstyle="round")
    for (x, y), start, end, colour in (((0, 0), 0, first, "blue"), (elbow, first, first + second, "orange")):
        arc = np.linspace(start, end, 30)
        ax.plot(x + 0.4 * np.cos(arc), y + 0.4 * np.sin(arc), color=ink[colour], linewidth=3)
        middle = (start + end) / 2
        text = {"ha": "center", "va": "center", "fontsize": 15, "color": ink[colour], "weight": "bold"}
        ax.text(x + 0.58 * np.cos(middle), y + 0.58 * np.sin(middle), f"{np.degrees(end - start):.0f}°", **text)
    for (x, y), name in (((0, 0), "shoulder"), (elbow, "elbow"), (hand, "hand")):
        ax.plot(x, y, "o", color=ink["grey"], markersize=11)
        ax.text(x - 0.12, y + 0.03, name, ha="right", va="center", fontsize=13, color=ink["grey"])
    ax.set_aspect("equal")
    ax.margins(0.08)
    ax.set_axis_off()


def save(name, size, draw, *arguments):
    """Write a picture of a size in inches, in light and in dark colours."""
    for theme, ink in INKS.items():
        figure, ax = plt.subplots(figsize=size)
        figure.subplots_adjust(0, 0, 1, 1)
        draw(ax, ink, *arguments)
        figure.savefig(TARGET / f"{name}_{theme}.svg", metadata={"Date": None})
        plt.close(figure)


def save_for_readme():
    """Write the same rotation at two joints, with its distances, and the poses in the plane: one picture on white."""
    skeleton, ink = humanoid(), INKS["light"]
    figure, axes = plt.subplots(1, 3, figsize=(10, 3.9), width_ratios=(1, 1, 1.35), layout="constrained")
    for ax, (joint, column) in zip(axes, TURNS.items(), strict=False):
        draw_turn(ax, ink, column)
        poses = turned(skeleton, column)[[0, -1]]
        angle, spatial = (pose_distances(poses, skeleton=skeleton, metric=m)[0, 1] for m in ("angle", "spatial"))
        ax.set_title(f"60° at the {joint}", fontsize=14)
        ax.text(0.28, -1.16, f'"angle"  {angle:.2f} rad', ha="center", color=ink["grey"], fontsize=12)
        ax.text(0.28, -1.36, f'"spatial"  {spatial:.2f} m', ha="center", color=ink["blue"], fontsize=12, weight="bold")
    draw_embedding(axes[2], ink)
    axes[2].set_title("poses by their distances", fontsize=14)
    for x, name, colour in ((0.25, "● walking", "blue"), (0.75, "▲ running", "orange")):
        axes[2].text(x, -0.09, name, transform=axes[2].transAxes, ha="center", color=ink[colour], fontsize=12)
    figure.savefig(TARGET / "readme.png", dpi=140, transparent=False, facecolor="white")
    plt.close(figure)


if __name__ == "__main__":
    plt.rcParams |= {"svg.hashsalt": "skpose", "savefig.transparent": True}  # the same files each time
    for joint, column in TURNS.items():
        save(joint, (3.0, 4.0), draw_turn, column)
    save("angles", (4.6, 3.4), draw_angles)
    save("walk", (4.0, 1.6), draw_walk)
    save("path", (4.0, 1.6), draw_path)
    save("embedding", (4.0, 1.6), draw_embedding)
    save_for_readme()
