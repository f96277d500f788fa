"""Display of two aligned motions: where their joints differ, and the poses that belong together."""

from typing import Any

import numpy as np

from skpose._utils.validation import check_integer, check_kind
from skpose.kinematics import forward_kinematics
from skpose.motions import Alignment
from skpose.motions._alignment import Quantity
from skpose.plot._axes import SIDES, axes, plain
from skpose.plot._pose import GAP, check_projection, draw_pose, shape_of_person
from skpose.skeleton._sides import sides

ROW = 0.19  # inches: the height of a joint
LARGEST_FONT = 9.0  # points
WIDTH, STRIPS, LABELS = 10.0, 3.6, 0.5  # inches: the figure, all poses, labels of time
# Shares of the height of the strips: for the poses of one motion, and where lines end. Between them is a little room.
FIGURES, LINES = 0.4, 0.42
HEIGHTS = (1.0 - FIGURES / 2, FIGURES / 2)  # of the middles of both
MOST_LINES = 80
TICKS: dict[str, Any] = {"nbins": 8, "steps": [1, 2, 5, 10]}
QUANTITIES = {"distance": (100.0, "distance of positions (cm)"), "rotation": (180 / np.pi, "angle of rotations (°)")}


class AlignmentDisplay:
    """Two aligned motions: a map of the differences of all joints over time, and below it matching poses.

    Each column of the map is a frame of the first motion, with the largest difference among its pairs. Poses of the
    first motion stand below their columns. Lines join pairs of the path, black ones the poses that are drawn. The
    second motion, or its part on the path with "subsequence", is stretched to the same width. Names of joints have the
    colours of `PoseDisplay`.

    Parameters
    ----------
    alignment : Alignment
        The path of the two motions, and the differences along it.

    Attributes
    ----------
    ax_ : matplotlib Axes
        The axes that the display replaces.
    map_ax_, strips_ax_ : matplotlib Axes
        The axes of the map and of the poses, inside `ax_`. Their horizontal unit is s of the first motion, or frames
        without a frame rate.
    figure_ : matplotlib Figure

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Motion, Skeleton
    >>> from skpose.motions import align_motions
    >>> from skpose.plot import AlignmentDisplay
    >>> arm, swing = Skeleton.chain(2), np.linspace([0, 0], [2, 0], 21)
    >>> alignment = align_motions(Motion(arm, swing, 10), Motion(arm, swing**2 / 2, 10))
    >>> display = AlignmentDisplay.from_alignment(alignment)
    >>> display.map_ax_.get_xlabel(), display.strips_ax_.get_xlabel()
    ('time of a (s)', 'time of b (s)')
    """

    def __init__(self, alignment: Alignment):
        self.alignment = alignment

    def plot(
        self, ax=None, *, quantity: Quantity = "distance", n_poses: int = 8, projection: str = "xy", **style
    ) -> "AlignmentDisplay":
        """Draw the display.

        Parameters
        ----------
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        quantity : {"distance", "rotation"}, default="distance"
            "distance" between the positions of each joint, cm, or "rotation", the angle between the joint's own
            rotations, degrees, for joints with dofs.
        n_poses : int, default=8
            Pairs of poses to draw, fewer if the motions have fewer.
        projection : str, default="xy"
            The horizontal and the vertical axis of the poses, see `PoseDisplay.plot`.
        **style
            Style of the map, such as cmap, vmax; see `matplotlib.axes.Axes.imshow`.

        Returns
        -------
        AlignmentDisplay
            The display itself.
        """
        names, places, differences = self.alignment._of_joints(quantity)
        check_integer(n_poses, 1, "n_poses")
        plane = check_projection(projection)
        rows = ROW * len(names)
        self.ax_, self.figure_ = axes(ax, (WIDTH, rows + STRIPS + 2 * LABELS))
        self.ax_.set_axis_off()
        between = min(0.5, LABELS * self.figure_.dpi / self.ax_.get_window_extent().height)
        top, bottom = (1.0 - between) * np.array([rows, STRIPS]) / (rows + STRIPS)
        self.strips_ax_ = self.ax_.inset_axes([0.0, 0.0, 1.0, bottom])
        self.map_ax_ = self.ax_.inset_axes([0.0, 1.0 - top, 1.0, top])
        bar_ax = self.ax_.inset_axes([1.015, 1.0 - top, 0.02, top])
        self._draw_map(names, places, differences, quantity, style, bar_ax)
        self._draw_strips(self.alignment.skeleton, n_poses, plane)
        return self

    def _draw_map(self, names, places, differences, quantity, style, bar_ax) -> None:
        """Draw the joints against the frames of the first motion, with names as small as the rows need."""
        factor, label = QUANTITIES[quantity]
        path, ax = self.alignment.path, self.map_ax_
        first_pairs = np.flatnonzero(np.diff(path[:, 0], prepend=-1))
        of_frames = factor * np.maximum.reduceat(differences, first_pairs, axis=0)
        defaults = {"cmap": "viridis", "interpolation": "nearest", "vmin": 0.0, "aspect": "auto"}
        if not of_frames.any():
            defaults["vmax"] = 1.0  # else matplotlib makes room below zero
        image = ax.imshow(of_frames.T, extent=(*self._edges(), len(names) - 0.5, -0.5), **defaults | style)
        self.figure_.colorbar(image, cax=bar_ax, label=label)
        row = ax.get_window_extent().height / self.figure_.dpi * 72 / len(names)  # points
        ax.set_yticks(np.arange(len(names)), list(map(plain, places)), fontsize=min(LARGEST_FONT, 0.8 * row))
        for text, side in zip(ax.get_yticklabels(), sides(names), strict=True):
            text.set_color(SIDES[side] if side else "black")
        ax.tick_params(axis="y", length=0)
        ax.set_xlabel(self._label("a"))
        ax.locator_params(axis="x", **TICKS)
        ax.xaxis.set_major_formatter("{x:g}")

    def _draw_strips(self, skeleton, n_poses, plane) -> None:
        """Draw pairs of poses, lines of the path between the two motions, and the time of the second."""
        from matplotlib.collections import LineCollection
        from matplotlib.ticker import MaxNLocator

        found, ax = self.alignment, self.strips_ax_
        ax.set(xlim=self._edges(), ylim=(0.0, 1.0), xlabel=self._label("b"))
        ax.set_yticks(HEIGHTS, ["a", "b"])
        ax.tick_params(axis="y", length=0)
        ax.spines[["top", "left", "right"]].set_visible(False)
        where = np.stack([self._times(found.path[:, 0]), self._below(found.path[:, 1])], axis=1)
        pairs = self._spread(n_poses)
        for some, colour, width in ((self._spread(MOST_LINES), "0.75", 0.6), (pairs, "black", 1.0)):
            ends = np.stack([where[some], np.tile([1.0 - LINES, LINES], (len(some), 1))], axis=2)
            ax.add_collection(LineCollection(list(ends), colors=colour, linewidths=width), autolim=False)
        poses = np.concatenate([found.a[found.path[pairs, 0]], found.b[found.path[pairs, 1]]])
        positions = forward_kinematics(poses, skeleton)
        shape = shape_of_person(skeleton)
        low, high = (edge(positions[..., plane], axis=1, initial=0.0) for edge in (np.min, np.max))  # with the root
        middle = (low + high) / 2
        middle[:, 1] = (low[:, 1].min() + high[:, 1].max()) / 2  # of all, so that the roots have one height
        half = np.array([(high - low)[:, 0].max(), high[:, 1].max() - low[:, 1].min()]) / 2
        half[half == 0.0] = 1.0  # where all bones are seen end on
        room = np.ptp(self._edges()) / ((1.0 + GAP) * len(pairs))
        points = [(x, height) for x_of, height in zip(where[pairs].T, HEIGHTS, strict=True) for x in x_of]
        style = {"clip_on": False} | ({"linewidth": 1.5, "markersize": 2} if shape is None else {})
        for pose, (left, low_edge), (right, high_edge), (x, height) in zip(
            positions, middle - half, middle + half, points, strict=True
        ):
            bounds = (x - room / 2, height - FIGURES / 2, room, FIGURES)
            figure = ax.inset_axes(bounds, transform=ax.get_xaxis_transform())
            figure.set_axis_off()
            figure.set(xlim=(left, right), ylim=(low_edge, high_edge), aspect="equal")
            draw_pose(figure, pose, plane, skeleton, shape, 0.0, style)
        first, last = self._times(found.path[[0, -1], 1])
        ticks = [t for t in MaxNLocator(**TICKS).tick_values(first, last) if first <= t <= last]
        rate = found.frame_rate or 1.0
        ax.set_xticks(self._below(rate * np.array(ticks)), [f"{t:g}" for t in ticks])

    def _times(self, frames):
        """Times of frames, s, or the frames themselves without a frame rate."""
        return np.asarray(frames) / (self.alignment.frame_rate or 1.0)

    def _edges(self):
        """The left edge of the first frame of the first motion, and the right edge of the last one."""
        return self._times([-0.5, len(self.alignment.a) - 0.5])

    def _below(self, frames):
        """Places of frames of the second motion: their part on the path is as wide as the first motion."""
        first, last = self.alignment.path[[0, -1], 1]
        share = (np.asarray(frames) - first) / (last - first) if last > first else np.full(np.shape(frames), 0.5)
        return self._times(len(self.alignment.a) - 1) * share

    def _spread(self, n):
        """At most n pairs of the path, spread evenly over both motions: each in the middle of an equal part."""
        path = self.alignment.path
        travelled = ((path - path[0]) / np.maximum(path[-1] - path[0], 1)).sum(axis=1)
        centres = travelled[-1] * (np.arange(n) + 0.5) / n
        return np.unique(np.abs(travelled - centres[:, None]).argmin(axis=1))

    def _label(self, name):
        return f"frame of {name}" if self.alignment.frame_rate is None else f"time of {name} (s)"

    @classmethod
    def from_alignment(cls, alignment: Alignment, *, ax=None, **options) -> "AlignmentDisplay":
        """Draw an alignment.

        Parameters
        ----------
        alignment : Alignment
            The path of two motions, from `skpose.motions.align_motions`.
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        **options
            What is drawn and its style, see `plot`.

        Returns
        -------
        AlignmentDisplay
            The display.
        """
        check_kind(alignment, Alignment, "alignment", "skpose.motions.align_motions(a, b) finds one")
        return cls(alignment).plot(ax, **options)
