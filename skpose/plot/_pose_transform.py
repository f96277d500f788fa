"""The scale of stick figures that stand in axes of other units."""

import numpy as np
from matplotlib.transforms import Affine2DBase


class PoseTransform(Affine2DBase):
    """From metres to the display: lengths of a pose are equal in both directions, at a point of the axes.

    The scale follows the size of the axes, so that figures keep their shape and do not overlap.

    Parameters
    ----------
    ax : matplotlib Axes
        The axes.
    centre : ndarray of shape (2,)
        The point of the pose, m, that is at `point`.
    point : tuple of two floats
        Where this is: horizontally in data, vertically as a share of the axes.
    room : tuple of two floats
        Shares of the width and of the height of the axes for one figure.
    size : tuple of two floats
        Width and height of the largest figure, m; zero where all bones are seen end on.
    """

    def __init__(self, ax, centre, point, room, size):
        super().__init__()
        self._ax, self._centre, self._point, self._room, self._size = ax, centre, point, np.array(room), size
        self._where = ax.get_xaxis_transform()
        self.set_children(self._where)

    def get_matrix(self):
        pixels = self._room * self._ax.bbox.size
        scale = min((pixels[i] / self._size[i] for i in range(2) if self._size[i] > 0.0), default=1.0)
        x, y = self._where.transform(self._point) - scale * self._centre
        return np.array([[scale, 0.0, x], [0.0, scale, y], [0.0, 0.0, 1.0]])
