"""Display of a mean motion: how much each joint varies in each phase."""

import numpy as np

from skpose.motions import MeanMotion
from skpose.plot._axes import axes, check_kind
from skpose.plot._pose import SIDES
from skpose.skeleton._sides import sides

WIDTH, ROW, REST = 8.0, 0.19, 1.0  # inches: the figure, a joint, what is above and below the joints
LARGEST_FONT = 9.0  # points


class MeanMotionDisplay:
    """The standard deviation of every joint about a mean motion, in each of its phases, as a map.

    `PoseStripDisplay.from_motion` draws the poses of the mean. Names of joints have the colours of `PoseDisplay`.

    Parameters
    ----------
    mean : MeanMotion
        The mean motion.

    Attributes
    ----------
    ax_ : matplotlib Axes
    figure_ : matplotlib Figure

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Skeleton, mean_motion
    >>> from skpose.plot import MeanMotionDisplay
    >>> swing = np.linspace([0.0, 0.0], [1.0, 2.0], 9)
    >>> display = MeanMotionDisplay.from_mean(mean_motion([swing, swing + 0.2], skeleton=Skeleton.chain(2)))
    >>> display.ax_.get_xlabel()
    'frame of the mean'
    """

    def __init__(self, mean: MeanMotion):
        self.mean = mean

    def plot(self, ax=None, **style) -> "MeanMotionDisplay":
        """Draw the display.

        Parameters
        ----------
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        **style
            Style of the map, such as cmap, vmax; see `matplotlib.axes.Axes.imshow`.

        Returns
        -------
        MeanMotionDisplay
            The display itself.
        """
        names = self.mean.skeleton.joint_names
        self.ax_, self.figure_ = axes(ax, "MeanMotionDisplay.plot", (WIDTH, ROW * len(names) + REST))
        left, right = np.array([-0.5, len(self.mean) - 0.5]) / (self.mean.frame_rate or 1.0)
        defaults = {"cmap": "viridis", "interpolation": "nearest", "vmin": 0.0, "aspect": "auto"}
        extent = (left, right, len(names) - 0.5, -0.5)
        image = self.ax_.imshow(100.0 * self.mean.joint_std.T, extent=extent, **defaults | style)
        self.figure_.colorbar(image, ax=self.ax_, label="standard deviation (cm)")
        row = self.ax_.get_window_extent().height / self.figure_.dpi * 72 / len(names)  # points
        self.ax_.set_yticks(np.arange(len(names)), names, fontsize=min(LARGEST_FONT, 0.8 * row))
        for text, side in zip(self.ax_.get_yticklabels(), sides(names), strict=True):
            text.set_color(SIDES[side] if side else "black")
        self.ax_.tick_params(axis="y", length=0)
        self.ax_.set_xlabel("frame of the mean" if self.mean.frame_rate is None else "time of the mean (s)")
        return self

    @classmethod
    def from_mean(cls, mean: MeanMotion, *, ax=None, **style) -> "MeanMotionDisplay":
        """Draw a `skpose.mean_motion`; the other parameters are those of `plot`."""
        check_kind(mean, MeanMotion, "mean", "skpose.mean_motion(motions) finds one")
        return cls(mean).plot(ax, **style)
