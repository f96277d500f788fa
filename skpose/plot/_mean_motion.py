"""Display of a mean motion: how much each joint varies in each phase."""

import numpy as np

from skpose._utils.validation import check_kind
from skpose.kinematics._places import joint_places
from skpose.motions import MeanMotion
from skpose.plot._axes import ROW, axes, draw_joint_map

WIDTH, REST = 8.0, 1.0  # inches: the figure, what is above and below the joints


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
    >>> from skpose import Skeleton
    >>> from skpose.motions import mean_motion
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
        names, places = self.mean.skeleton.joint_names, joint_places(self.mean.skeleton)
        self.ax_, self.figure_ = axes(ax, (WIDTH, ROW * len(names) + REST))
        edges = np.array([-0.5, len(self.mean) - 0.5]) / (self.mean.frame_rate or 1.0)
        draw_joint_map(self.ax_, 100.0 * self.mean.joint_std, names, places, edges, "standard deviation (cm)", style)
        self.ax_.set_xlabel("frame of the mean" if self.mean.frame_rate is None else "time of the mean (s)")
        return self

    @classmethod
    def from_mean(cls, mean: MeanMotion, *, ax=None, **style) -> "MeanMotionDisplay":
        """Draw a mean motion.

        Parameters
        ----------
        mean : MeanMotion
            The mean, from `skpose.motions.mean_motion`.
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        **style
            Style of the map, such as cmap, vmax; see `matplotlib.axes.Axes.imshow`.

        Returns
        -------
        MeanMotionDisplay
            The display.
        """
        check_kind(mean, MeanMotion, "mean", "skpose.motions.mean_motion(motions) finds one")
        return cls(mean).plot(ax, **style)
