"""The pictures of `skpose view`: one moment of motions as PNG, or an animated GIF, without interpolation."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from skpose._utils.files import new_file
from skpose.keypoints import Keypoints, Layout
from skpose.plot import PoseDisplay
from skpose.plot._axes import COLOURS, SIDES, plain
from skpose.plot._volume import draw_volume
from skpose.skeleton import Motion
from skpose.skeleton._rest import positions_at_zero
from skpose.skeleton._root import root_orientations
from skpose.skeleton._sides import sides
from skpose.view._points import points_scene
from skpose.view._scene import AXES, scene_of

ASIDE = 0.9  # rad, from the front, as in the page
EDGE = 0.08  # of the extent, around the figure
INCHES, COLUMNS = 3.6, 4  # of a panel, and panels in a row at most
SHARP, COARSE = 150, 100  # pixels per inch of a picture, and of a GIF
HUNDREDTHS = 100  # of a second: the unit of time of a GIF


class Panel(NamedTuple):
    """A motion as it is drawn: to the right, up, and towards the viewer, the root at zero, m."""

    label: str
    times: np.ndarray  # (n_frames,) s
    draw: Callable[..., Any]  # takes the positions (n_joints, 3) of a frame, and ax=
    positions: np.ndarray  # (n_frames, n_joints, 3), NaN where a point is not seen
    heights: np.ndarray  # (n_frames,) of the root above the ground
    limits: np.ndarray  # (2, 2) lowest and highest, to the right of the root and above the ground


class Recording:
    """Motions side by side in one figure; the camera follows the roots."""

    def __init__(self, shown: Sequence[Motion | Keypoints], labels: Sequence[str], layout: Layout | None = None):
        self.panels = [_panel(one, label, layout) for one, label in zip(shown, labels, strict=True)]
        self.begins = min(float(panel.times[0]) for panel in self.panels)
        self.ends = max(float(panel.times[-1]) for panel in self.panels)
        columns = min(len(self.panels), COLUMNS)
        rows = -(-len(self.panels) // columns)
        self.figure = Figure(figsize=(INCHES * columns, INCHES * 1.15 * rows), layout="constrained", dpi=COARSE)
        self.canvas = FigureCanvasAgg(self.figure)
        self.axes = self.figure.subplots(rows, columns, squeeze=False).ravel()

    def draw(self, time: float) -> None:
        """Draw the last frame of each motion at or before a time, s, or else the first."""
        for ax, panel in zip(self.axes, self.panels, strict=False):
            ax.clear()
            frame = max(int(np.searchsorted(panel.times, time + 1e-6, side="right")) - 1, 0)
            panel.draw(panel.positions[frame], ax=ax)
            (left, low), (right, high) = panel.limits
            below = panel.heights[frame]
            ax.axhline(-below, color="0.75", linewidth=1, zorder=0)
            ax.set_aspect("equal", adjustable="box")
            ax.set(xlim=(left, right), ylim=(low - below, high - below))
            ax.set_title(f"{plain(panel.label)}\n{panel.times[frame]:.2f} s", fontsize=10)
        for ax in self.axes:
            ax.axis("off")

    def save_png(self, path: Path, time: float) -> None:
        """Write the picture of a time, s."""
        self._check(time)
        self.draw(time)
        with new_file(path) as new:
            self.figure.savefig(new, format="png", dpi=SHARP)

    def save_gif(self, path: Path, begins: float | None, ends: float | None, fps: float) -> int:
        """Write the pictures from one time to another, s, and return how many; None is the whole time."""
        first = self.begins if begins is None else begins
        last = self.ends if ends is None else min(ends, self.ends)
        self._check(first)
        n = int((last - first) * fps + 1e-6) + 1
        steps = np.rint(np.arange(n + 1) * HUNDREDTHS / fps).astype(int)  # rounded without drift
        pictures, durations = self._pictures(first + np.arange(n) / fps), (10 * np.diff(steps)).tolist()
        with new_file(path) as new:
            next(pictures).save(new, "GIF", save_all=True, append_images=pictures, duration=durations, loop=0)
        return n

    def _check(self, time: float) -> None:
        if time > self.ends + 1e-6:
            raise ValueError(f"the files end at {self.ends:g} s, got the time {time:g} s")

    def _pictures(self, times: np.ndarray) -> Iterator[Any]:
        """Yield the pictures of some times, with the palette of the first one."""
        palette = None
        for time in times:
            self.draw(float(time))
            self.canvas.draw()
            picture = Image.fromarray(np.asarray(self.canvas.buffer_rgba())[..., :3].copy())
            palette = picture.quantize(255) if palette is None else palette
            yield picture.quantize(palette=palette, dither=Image.Dither.NONE)


def _panel(shown: Motion | Keypoints, label: str, layout: Layout | None) -> Panel:
    if isinstance(shown, Keypoints):
        if not shown.confidences.any():
            raise ValueError(f"{label} has no point that is seen")
        figure, scene, is_seen, shape = points_scene(shown, layout)
        names, times = figure.names, np.arange(len(is_seen)) / shown.frame_rate
        draw: Callable[..., Any] = partial(_draw_points, figure.parents, sides(names), shape)
        joints = np.where(is_seen[..., None], scene.joints, np.nan)
        keys, places = figure.keys, np.where(is_seen.any(axis=0, keepdims=True).T, scene.joints[0], np.nan)
    else:
        scene, names, times = scene_of(shown), list(shown.skeleton.joint_names), shown.times
        draw = partial(PoseDisplay.from_positions, skeleton=shown.skeleton, projection="xy")
        joints, keys = scene.joints, names
        turn = root_orientations(shown.root_angles[:1], shown.root_axes).as_matrix()[0]
        places = (positions_at_zero(shown.skeleton)[:-1] @ turn.T)[:, AXES[shown.up]]  # limbs do not turn the view
    aside = _front(scene.root, places, keys, scene.size) - ASIDE
    sin, cos = np.sin(aside), np.cos(aside)
    seen = joints @ np.array([[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]]).T
    heights = scene.root[:, 1]
    right, up = (values[np.isfinite(values)] for values in (seen[..., 0], seen[..., 1] + heights[:, None]))
    low = np.array([right.min(initial=0.0), min(up.min(initial=0.0), heights.min())])
    high = np.array([right.max(initial=0.0), max(up.max(initial=0.0), heights.max())])
    edge = EDGE * max(float((high - low).max()), 0.1 * scene.size)
    return Panel(label, times, draw, seen, heights, np.stack([low - edge, high + edge]))


def _draw_points(parents: Sequence[int], side: Sequence[str], shape: Any, positions: np.ndarray, *, ax: Any) -> None:
    """Draw points that are seen, and the bones between them, in the colours of their sides."""
    draw_volume(ax, positions, [0, 1], side, shape, 0.0, {})
    colours = SIDES if any(side) else {"": COLOURS[0]}
    for name, colour in colours.items():
        some = [i for i, of in enumerate(side) if of == name]
        bones = [positions[[parents[i], i]] for i in some if parents[i] >= 0]
        lines = np.concatenate([[*bone[:, :2], [np.nan, np.nan]] for bone in bones]) if bones else np.empty((0, 2))
        ax.plot(*lines.T, color=colour, linewidth=0.8)
        ax.plot(*positions[some, :2].T, color=colour, linestyle="none", marker="o", markersize=1.8)


def _front(root: np.ndarray, places: np.ndarray, names: Sequence[str], size: float) -> float:
    """The direction in which a motion goes, or else faces, rad about y from z.

    The direction it faces is perpendicular to the line of the hips, or of the shoulders, in the first frame, where
    joints have the positions `places` (n_joints, 3).
    """
    x, _, z = root[-1] - root[0]
    if np.hypot(x, z) > 0.5 * size:
        return float(np.arctan2(x, z))
    side, is_known = np.array(sides(names)), ~np.isnan(places[:, 0])
    for part in ("hip", "shoulder", ""):
        chosen = is_known & [part in name.lower() for name in names]
        left, right = (places[chosen & (side == one)] for one in ("left", "right"))
        if len(left) and len(right):
            x, _, z = left.mean(axis=0) - right.mean(axis=0)
            if np.hypot(x, z) > 1e-3 * size:
                return float(np.arctan2(-z, x))
    return ASIDE
