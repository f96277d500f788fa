"""The pictures of `skpose view`: a moment of motions as PNG, or a part of their time as GIF, drawn by `PoseDisplay`.

Keypoints are drawn as their page has them: with the bones of a layout, and without points that are not seen. Pictures
have recorded frames; nothing is drawn between two.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from skpose._files import new_file
from skpose.keypoints import Keypoints, Layout
from skpose.plot import PoseDisplay
from skpose.plot._shared import COLOURS, SIDES, draw_volume
from skpose.skeleton import Motion
from skpose.skeleton._shared import positions_at_zero, root_orientations, sides
from skpose.view._shared import AXES, points_scene, scene_of

ASIDE = 0.9  # rad, from the front, where the page looks from too
EDGE = 0.08  # of the extent, around the figure
INCHES, COLUMNS = 3.6, 4  # of a panel, and panels in a row at most
SHARP, COARSE = 150, 100  # pixels per inch of a picture, and of a GIF
FPS = 20.0  # of a GIF
MOST = 2_000  # pictures in a GIF
HUNDREDTHS = 100  # of a second: the unit of time of a GIF


class Panel(NamedTuple):
    """A motion as it is seen: to the right, up, and towards the viewer, the root at zero, m."""

    label: str
    times: np.ndarray  # (n_frames,) s
    draw: Callable[..., Any]  # takes the positions (n_joints, 3) of a frame, and ax=
    seen: np.ndarray  # (n_frames, n_joints, 3), NaN where a point is not seen
    heights: np.ndarray  # (n_frames,) of the root above the ground
    limits: np.ndarray  # (2, 2) lowest and highest, to the right of the root and above the ground

    def frame(self, time: float) -> int:
        """Return the last frame that is not after a time, s; before the first one the first."""
        return max(int(np.searchsorted(self.times, time + 1e-6, side="right")) - 1, 0)

    def check_is_seen(self, time: float) -> None:
        """Refuse a time, s, at which no point is seen."""
        frame, full = self.frame(time), np.flatnonzero(np.isfinite(self.seen).any(axis=(1, 2)))
        if frame not in full:
            nearest = full[np.abs(full - frame).argmin()]
            at = np.ceil(1e3 * self.times[nearest]) / 1e3  # not before the frame
            raise ValueError(
                f"{self.label} has no point that is seen at {self.times[frame]:.2f} s, frame {frame} from zero, and a "
                f"picture of it would be empty: the nearest frame with points is {nearest}, pass --at {at:g}"
            )


class Recording:
    """Motions side by side in one figure; the camera follows the roots."""

    def __init__(self, shown: Sequence[Motion | Keypoints], labels: Sequence[str], layout: Layout | None = None):
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.panels = [_panel(one, label, layout) for one, label in zip(shown, labels, strict=True)]
        columns = min(len(self.panels), COLUMNS)
        rows = -(-len(self.panels) // columns)
        self.figure = Figure(figsize=(INCHES * columns, INCHES * 1.15 * rows), layout="constrained", dpi=COARSE)
        self.canvas = FigureCanvasAgg(self.figure)
        self.axes = self.figure.subplots(rows, columns, squeeze=False).ravel()

    @property
    def begins(self) -> float:
        return min(float(panel.times[0]) for panel in self.panels)

    @property
    def ends(self) -> float:
        return max(float(panel.times[-1]) for panel in self.panels)

    def draw(self, time: float) -> None:
        """Draw the last frame of each motion that is not after a time, s; before the first one the first."""
        for ax, panel in zip(self.axes, self.panels, strict=False):
            ax.clear()
            times, frame = panel.times, panel.frame(time)
            panel.draw(panel.seen[frame], ax=ax)
            (left, low), (right, high) = panel.limits
            below = panel.heights[frame]
            ax.axhline(-below, color="0.75", linewidth=1, zorder=0)
            ax.set_aspect("equal", adjustable="box")
            ax.set(xlim=(left, right), ylim=(low - below, high - below))
            ax.set_title(f"{panel.label}\n{times[frame]:.2f} s", fontsize=10)
        for ax in self.axes:
            ax.axis("off")

    def save_png(self, path: Path, time: float | None) -> None:
        """Write the picture of a time, s; None is the begin."""
        time = self.begins if time is None else time
        if time > self.ends + 1e-6:
            raise ValueError(f"--at {time:g} is after the end: the files end at {self.ends:g} s")
        for panel in self.panels:
            panel.check_is_seen(time)
        self.draw(time)
        with new_file(path) as new:
            self.figure.savefig(new, format="png", dpi=SHARP)

    def save_gif(self, path: Path, begins: float | None, ends: float | None, fps: float) -> int:
        """Write the pictures from one time to another, s, and return how many; None is all of the time."""
        first = self.begins if begins is None else begins
        last = self.ends if ends is None else min(ends, self.ends)
        if first > last:
            raise ValueError(f"--from {first:g} is after the end: the files end at {self.ends:g} s")
        n = int((last - first) * fps + 1e-6) + 1
        if n > MOST:
            raise ValueError(
                f"the GIF would have {n:,} pictures, more than {MOST:,}: choose a part by --from and --to, or fewer "
                "pictures a second by --fps"
            )
        step = np.rint(np.arange(n + 1) * HUNDREDTHS / fps).astype(int)  # rounded without drift
        pictures = self._pictures(first + np.arange(n) / fps)
        durations = (10 * np.diff(step)).tolist()
        try:
            with new_file(path) as new:
                next(pictures).save(new, "GIF", save_all=True, append_images=pictures, duration=durations, loop=0)
        except OverflowError:  # of equal pictures one is shown for all of their time
            raise ValueError(
                "in a GIF a picture is shown for 655 s at most, and in these files nothing moves for longer: choose a "
                "part by --from and --to"
            ) from None
        return n

    def _pictures(self, times: np.ndarray) -> Iterator[Any]:
        """Yield the pictures of some times, with the palette of the first one."""
        from PIL import Image

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
            raise ValueError(f"{label} has no point that is seen, and there is nothing to draw: leave it out")
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
        places = (positions_at_zero(shown.skeleton)[:-1] @ turn.T)[:, AXES[shown.up]]  # so that no limb turns the view
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
    """Draw points, and the bones between those that are seen, in the colours of their sides."""
    draw_volume(ax, positions, [0, 1], side, shape, 0.0, {})
    colours = SIDES if any(side) else {"": COLOURS[0]}
    for name, colour in colours.items():
        some = [i for i, of in enumerate(side) if of == name]
        bones = [positions[[parents[i], i]] for i in some if parents[i] >= 0]
        lines = np.concatenate([[*bone[:, :2], [np.nan, np.nan]] for bone in bones]) if bones else np.empty((0, 2))
        ax.plot(*lines.T, color=colour, linewidth=0.8)
        ax.plot(*positions[some, :2].T, color=colour, linestyle="none", marker="o", markersize=1.8)


def _front(root: np.ndarray, places: np.ndarray, names: Sequence[str], size: float) -> float:
    """Return the direction in which a motion goes, or faces where left and right are known, rad about y from z.

    Places (n_joints, 3) are those of the joints in the first frame, of which hips or else shoulders say how it faces.
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
