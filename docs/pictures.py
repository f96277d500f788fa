"""Pictures of the site and of the README: `python docs/pictures.py` writes them into docs/_static.

Each is written twice, for pages in light and in dark colours, but for the card that is shown where a link is shared.
"""

import re
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline
from sklearn.manifold import ClassicalMDS

from skpose import Motion, Skeleton, forward_kinematics, geodesic, pose_distances
from skpose.biomechanics import gait_events, joint_angles
from skpose.datasets import humanoid, make_actions, make_gait
from skpose.geodesics import frechet_mean
from skpose.metrics import Geodesic
from skpose.motions import MotionDistanceTransformer, align_motions
from skpose.plot import JointAnglesDisplay
from skpose.skeleton._sides import sides
from skpose.view._shape import find_shape, outline

TARGET = Path(__file__).parent / "_static"
INKS = {
    "light": {"grey": "#5b6570", "blue": "#0072b2", "orange": "#c04f00", "green": "#00805e", "rose": "#a6477d"}
    | {"paper": "#ffffff", "ink": "#1b1f24"},
    "dark": {"grey": "#aab1ba", "blue": "#56b4e9", "orange": "#f5924a", "green": "#35c89b", "rose": "#e08fbd"}
    | {"paper": "#0d1117", "ink": "#e8eaed"},
}
LIGHT = np.array([-0.64, 0.77])  # where it comes from
TURN = np.radians(38)  # of the person whose arm turns, about the vertical
ACTIONS = {"kick": "blue", "squat": "orange", "throw": "green", "wave": "rose"}
TURNS = {"shoulder": "left_upper_arm_rz", "wrist": "left_hand_rz"}
ANGLE = np.radians(60)


def turned(skeleton, column):
    """Return seven poses: one angle of a standing person grows from 0 to 60°."""
    poses = np.zeros((7, skeleton.n_dofs))
    poses[:, skeleton.dof_names.index(column)] = np.linspace(0, ANGLE, len(poses))
    return poses


def draw_person(ax, ink, joints, skeleton, colours, *, at=(0.0, 0.0), scale=1.0, turn=0.0, alpha=1.0, shaded=True):
    """Draw a figure as the pages do, at a turn around the vertical: parts in colours of joints, the root's last."""
    cos, sin = np.cos(turn), np.sin(turn)
    points = np.vstack([np.zeros(3), joints]) @ [[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]]
    shape = find_shape(skeleton)
    centres = shape.centres(points)
    flat, radii = scale * centres[:, :2] + at, scale * shape.radii
    for part in sorted(shape.parts, key=lambda part: centres[np.concatenate(part.hulls), 2].mean()):
        hulls = [list(hull) for hull in part.hulls]
        outlines = (outline(flat[hull], radii[hull]) for hull in hulls)
        area = Outline.make_compound_path(*(Outline(np.vstack([one, one[:1]])) for one in outlines))
        edge = {"fill": False, "edgecolor": ink["paper"], "linewidth": 1.5 * scale}
        ax.add_patch(PathPatch(area, **edge, alpha=alpha, zorder=3))
        colour = colours[part.joint]
        if shaded:
            shade(ax, area, colour, flat[hulls[-1][-1]] - flat[hulls[0][0]], alpha)
        else:
            ax.add_patch(PathPatch(area, facecolor=colour, linewidth=0, alpha=alpha, zorder=3))


def shade(ax, area, colour, along, alpha):
    """Fill a part with a colour that is lighter where the light comes from, and darker at the other edge."""
    length = np.hypot(*along)
    normal = np.array([-along[1], along[0]]) / length if length > 0.05 else LIGHT
    low, high = area.vertices.min(axis=0), area.vertices.max(axis=0)
    x, y = np.meshgrid(*(np.linspace(*ends, 40) for ends in zip(low, high, strict=True)))
    ends = area.vertices @ normal
    share = (x * normal[0] + y * normal[1] - ends.min()) / np.ptp(ends)
    tone = (0.26 * (normal @ LIGHT) * (2.0 * share - 1.0) - 0.04)[..., None]
    image = np.where(tone > 0, to_rgb(colour) + tone * (1.0 - np.array(to_rgb(colour))), to_rgb(colour) * (1.0 + tone))
    extent = (low[0], high[0], low[1], high[1])
    drawn = ax.imshow(
        image.clip(0.0, 1.0), extent=extent, origin="lower", alpha=alpha, zorder=3, interpolation="bilinear"
    )
    drawn.set_clip_path(area, transform=ax.transData)


def draw_turn(ax, ink, column):
    """Draw a person who turns one joint, what moves in colour, and the paths of its joints."""
    skeleton = humanoid()
    joints = forward_kinematics(turned(skeleton, column), skeleton)
    moved = np.ptp(joints, axis=0).any(axis=1)
    colours = [ink["orange"] if one else ink["grey"] for one in moved] + [ink["grey"]]
    draw_person(ax, ink, joints[0], skeleton, colours, turn=TURN, alpha=0.25)
    draw_person(ax, ink, joints[-1], skeleton, colours, turn=TURN)
    cos, sin = np.cos(TURN), np.sin(TURN)
    for joint in np.flatnonzero(moved):
        x, y, z = joints[:, joint].T
        ax.plot(cos * x - sin * z, y, color=ink["blue"], linewidth=2.5, zorder=4, solid_capstyle="round")
    ax.set_aspect("equal", adjustable="box")
    ax.set(xlim=(-0.45, 1.0), ylim=(-1.05, 0.95))
    ax.set_axis_off()


def draw_walk(ax, ink):
    """Draw poses of a walk next to each other."""
    motion = make_gait(n_subjects=1, n_sequences=1, rotations="file", random_state=0)[0]
    colours = [
        ink[{"left": "blue", "right": "orange"}.get(side, "grey")] for side in sides(motion.skeleton.joint_names)
    ]
    joints = forward_kinematics(motion.angles[np.arange(6) * 4], motion.skeleton)
    for k, pose in enumerate(joints):
        at = (0.75 * k, 0.0)
        draw_person(ax, ink, pose, motion.skeleton, [*colours, ink["grey"]], at=at, turn=np.radians(-75), shaded=False)
    ax.set(xlim=(-0.5, 4.3), ylim=(-1.05, 0.95))
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


def draw_embedding(ax, ink, named=False):
    """Draw motions of four people in the plane, by their distances, with one of each action as a figure."""
    motions = make_actions(4, 3, actions=list(ACTIONS), rotations="file", random_state=0)
    poses = [motion.resample(12).angles for motion in motions]
    D = MotionDistanceTransformer(motions.skeleton, metric="spatial").fit_transform(poses)
    points = ClassicalMDS(metric="precomputed").fit_transform(D)
    middle = points.mean(axis=0)
    for action, colour in ACTIONS.items():
        chosen = np.flatnonzero(motions.actions == action)
        ax.scatter(*points[chosen].T, s=26, color=ink[colour], linewidths=0, alpha=0.85, zorder=2)
        medoid = chosen[D[np.ix_(chosen, chosen)].sum(axis=1).argmin()]
        still = forward_kinematics(poses[medoid], motions.skeleton)
        pose = still[np.linalg.norm(still - still[0], axis=2).sum(axis=1).argmax()]  # the farthest from the start
        out = points[chosen].mean(axis=0) - middle
        at = points[chosen].mean(axis=0) + 0.78 * out / np.hypot(*out)
        colours = [ink[colour]] * (len(pose) + 1)
        draw_person(ax, ink, pose, motions.skeleton, colours, at=at, scale=0.36, turn=np.radians(-50), shaded=named)
        if named:
            ax.text(at[0], at[1] - 0.4, action, color=ink[colour], ha="center", va="top", fontsize=12, zorder=4)
    ax.set(xlim=(-1.7, 1.8), ylim=(-1.75, 1.55))
    ax.set_aspect("equal")
    ax.set_axis_off()


def draw_file(ax, ink):
    """Draw a sheet with the angles of a walk over time."""
    walk = make_gait(n_subjects=1, n_sequences=1, rotations="file", random_state=0)[0]
    edge, fold = np.array([[0.0, 0.0], [0.0, 1.3], [0.75, 1.3], [1.0, 1.05], [1.0, 0.0], [0.0, 0.0]]), 0.25
    ax.plot(*edge.T, color=ink["grey"], linewidth=2.5, solid_joinstyle="round")
    ax.plot([0.75, 0.75, 1.0], [1.3, 1.3 - fold, 1.3 - fold], color=ink["grey"], linewidth=2.5, solid_joinstyle="round")
    shown = {"left_thigh_rx": "blue", "right_thigh_rx": "orange", "left_shank_rx": "green"}
    for k, (column, colour) in enumerate(shown.items()):
        angle = walk.angles[:120, walk.skeleton.dof_names.index(column)]
        height = 0.2 + 0.33 * k + 0.12 * (angle - angle.mean()) / np.abs(angle - angle.mean()).max()
        ax.plot(np.linspace(0.12, 0.88, len(angle)), height, color=ink[colour], linewidth=2.5)
    ax.set(xlim=(-0.4, 1.4), ylim=(-0.07, 1.37))
    ax.set_aspect("equal")
    ax.set_axis_off()


def draw_distance(ax, ink):
    """Draw two poses, and the paths of the joints from the one to the other."""
    kick = make_actions(1, 1, actions=["kick"], rotations="file", random_state=0)[0]
    joints = forward_kinematics(kick.angles, kick.skeleton)
    far = np.linalg.norm(joints - joints[0], axis=2).sum(axis=1).argmax()
    path = forward_kinematics(np.linspace(kick.angles[0], kick.angles[far], 20), kick.skeleton)
    colours, turn = [ink["grey"]] * (len(joints[0]) + 1), np.radians(-60)
    draw_person(ax, ink, path[0], kick.skeleton, colours, turn=turn, alpha=0.3)
    draw_person(ax, ink, path[-1], kick.skeleton, colours, turn=turn)
    cos, sin = np.cos(turn), np.sin(turn)
    for joint in range(len(joints[0])):
        x, y, z = path[:, joint].T
        ax.plot(cos * x - sin * z, y, color=ink["orange"], linewidth=2.5, zorder=4, solid_capstyle="round")
    ax.set(xlim=(-1.35, 1.35), ylim=(-1.1, 1.06))
    ax.set_aspect("equal")
    ax.set_axis_off()


def draw_warping(ax, ink):
    """Draw two people who walk, one below the other, with lines between the frames that belong together."""
    gait = make_gait(n_subjects=2, n_sequences=1, frame_rate=30, rotations="file", random_state=0)
    pair = [motion[:45] for motion in gait[gait.actions == "walk"].motions]
    path = align_motions(*pair).path
    for row, motion in enumerate(pair):
        joints, skeleton = forward_kinematics(motion.angles, motion.skeleton), motion.skeleton
        colours = [ink[{"left": "blue", "right": "orange"}.get(side, "grey")] for side in sides(skeleton.joint_names)]
        for frame in path[::6, row]:
            at, turn = (0.17 * frame, -2.7 * row), np.radians(-75)
            draw_person(ax, ink, joints[frame], skeleton, [*colours, ink["grey"]], at=at, turn=turn, shaded=False)
    for k, (i, j) in enumerate(path):
        shown = {"color": ink["ink"], "linewidth": 1.5} if k % 6 == 0 else {"color": ink["grey"], "linewidth": 0.6}
        ax.plot([0.17 * i, 0.17 * j], [-1.12, -1.68], **shown)
    ax.set(xlim=(-0.6, 0.17 * 44 + 0.6), ylim=(-3.8, 1.0))
    ax.set_aspect("equal")
    ax.set_axis_off()


def draw_means(ax, ink):
    """Draw two poses, the mean of the positions of their joints, and their mean pose."""
    skeleton = humanoid()
    poses = np.zeros((2, skeleton.n_dofs))
    poses[:, skeleton.dof_names.index("left_upper_arm_rz")] = np.radians([10.0, 130.0])
    poses[:, skeleton.dof_names.index("right_upper_arm_rz")] = np.radians([-10.0, -130.0])
    two = Motion(skeleton, poses, 1.0).to_rotvec()
    mean = frechet_mean(two.angles, two.skeleton, metric="rotation").pose
    *given, mean = forward_kinematics(np.vstack([two.angles, mean]), two.skeleton)
    for k, (joints, colour) in enumerate(
        [(given[0], "grey"), (given[1], "grey"), (np.mean(given, axis=0), "orange"), (mean, "blue")]
    ):
        draw_person(ax, ink, joints, skeleton, [ink[colour]] * (len(joints) + 1), at=(1.9 * k, 0.0))
    for x, text, colour in [
        (0.95, "two poses", "grey"),
        (3.8, "mean of positions", "orange"),
        (5.7, "mean pose", "blue"),
    ]:
        ax.text(x, -1.2, text, ha="center", va="top", color=ink[colour], fontsize=14, weight="bold")
    ax.set(xlim=(-0.8, 6.8), ylim=(-1.6, 1.15))
    ax.set_aspect("equal")
    ax.set_axis_off()


def draw_keypoints(ax, ink):
    """Draw the points of a person, the same on its figure, and the figure alone."""
    motion = make_actions(1, 1, actions=["throw"], rotations="file", random_state=0)[0]
    skeleton, joints = (
        motion.skeleton,
        forward_kinematics(motion.angles[len(motion) // 2 : len(motion) // 2 + 1], motion.skeleton)[0],
    )
    turn = np.radians(-40)
    noisy = joints + np.random.default_rng(0).normal(scale=0.02, size=joints.shape)
    x, y = np.cos(turn) * noisy[:, 0] - np.sin(turn) * noisy[:, 2], noisy[:, 1]
    colours = [ink[{"left": "blue", "right": "orange"}.get(side, "grey")] for side in sides(skeleton.joint_names)]
    for k in (1, 2):
        draw_person(
            ax,
            ink,
            joints,
            skeleton,
            [*colours, ink["grey"]],
            at=(2.0 * k, 0.0),
            turn=turn,
            alpha=0.4 if k == 1 else 1.0,
        )
    for k in (0, 1):
        ax.scatter(2.0 * k + x, y, s=30, color=ink["ink"], linewidths=0, zorder=5)
    for k, text in enumerate(["keypoints", "a skeleton that fits", "a pose"]):
        ax.text(2.0 * k, -1.2, text, ha="center", va="top", color=ink["ink"], fontsize=15, weight="bold")
    ax.set(xlim=(-1.0, 5.0), ylim=(-1.6, 1.25))
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
        path = TARGET / f"{name}_{theme}.svg"
        figure.savefig(path, metadata={"Date": None})
        path.write_text(shorten(path.read_text(encoding="utf-8")), encoding="utf-8")
        plt.close(figure)


def save_strides():
    """Write joint angles of a walk over the stride, with those of five other people as a band."""
    walks = []
    for motion in make_gait(6, 1, activities=["walk"], duration=8, random_state=0):
        ends = [motion.skeleton.joint_names.index(name) for name in ("left_shank", "right_shank")]
        ankles = forward_kinematics(motion.angles, motion.skeleton)[:, ends]
        lower = ankles[:-1, :, 1].argmin(axis=1)
        steps = -np.diff(ankles, axis=0)[np.arange(len(lower)), lower]  # the lower ankle stands still
        walks.append(replace(motion, root_positions=np.concatenate([np.zeros((1, 3)), steps.cumsum(axis=0)])))
    others = joint_angles(walks[1:]).groupby(["angle", "phase [%]"])["value [deg]"]
    norm = others.agg(["mean", "std"]).reset_index()
    for theme, ink in INKS.items():
        parts = "text.color", "axes.edgecolor", "axes.labelcolor", "xtick.color", "ytick.color"
        with plt.rc_context(dict.fromkeys(parts, ink["grey"]) | {"axes.facecolor": "none"}):
            display = JointAnglesDisplay.from_angles(joint_angles(walks[0]), gait_events(walks[0]), norm=norm)
        path = TARGET / f"strides_{theme}.svg"
        display.figure_.savefig(path, metadata={"Date": None}, bbox_inches="tight")
        path.write_text(shorten(path.read_text(encoding="utf-8")), encoding="utf-8")
        plt.close(display.figure_)


def shorten(svg):
    """Return a drawing with two digits after the points of its outlines, which are in points."""
    return re.sub(r' d="[^"]*"', lambda outline: re.sub(r"(\.\d\d)\d+", r"\1", outline[0]), svg)


def compose(figure, axes, ink):
    """Draw the same rotation at two joints, with its distances, and motions in the plane."""
    skeleton = humanoid()
    for ax, (joint, column) in zip(axes, TURNS.items(), strict=False):
        draw_turn(ax, ink, column)
        poses = turned(skeleton, column)[[0, -1]]
        angle, spatial = (pose_distances(poses, skeleton=skeleton, metric=m)[0, 1] for m in ("angle", "spatial"))
        ax.set_title(f"60° at the {joint}", fontsize=14, color=ink["ink"])
        ax.text(0.28, -1.18, f'"angle"  {angle:.2f} rad', ha="center", color=ink["grey"], fontsize=12)
        ax.text(
            0.28, -1.38, f'"spatial"  {spatial:.2f} m', ha="center", color=ink["orange"], fontsize=12, weight="bold"
        )
    draw_embedding(axes[2], ink, named=True)
    axes[2].set_title("motions by their distances", fontsize=14, color=ink["ink"])


def save_for_readme():
    """Write the picture of the README, in light and in dark colours, and the card for links."""
    for theme, ink in INKS.items():
        figure, axes = plt.subplots(1, 3, figsize=(10, 3.9), width_ratios=(1, 1, 1.35), layout="constrained")
        compose(figure, axes, ink)
        figure.savefig(TARGET / f"readme_{theme}.png", dpi=140, facecolor=ink["paper"], transparent=False)
        plt.close(figure)
    ink = INKS["light"]
    figure, axes = plt.subplots(1, 3, figsize=(12, 6.3), width_ratios=(1, 1, 1.35))
    figure.subplots_adjust(0.02, 0.14, 0.98, 0.68)
    compose(figure, axes, ink)
    figure.text(0.5, 0.9, "skpose", fontsize=40, weight="bold", color=ink["ink"], ha="center", va="center")
    words = "distances between human poses that measure how far the joints move"
    figure.text(0.5, 0.8, words, fontsize=20, color=ink["grey"], ha="center", va="center")
    figure.savefig(TARGET / "card.png", dpi=100, facecolor="white", transparent=False)
    plt.close(figure)


if __name__ == "__main__":
    plt.rcParams |= {"svg.hashsalt": "skpose", "savefig.transparent": True}  # the same files each time
    save("angles", (4.6, 3.4), draw_angles)
    save("walk", (4.0, 1.6), draw_walk)
    save("file", (2.0, 1.6), draw_file)
    save("distance", (2.0, 1.6), draw_distance)
    save("warping", (6.4, 3.7), draw_warping)
    save("means", (7.0, 2.5), draw_means)
    save("keypoints", (6.0, 2.85), draw_keypoints)
    save_strides()
    save("path", (4.0, 1.6), draw_path)
    save("embedding", (4.0, 1.6), draw_embedding)
    save_for_readme()
