"""Display of a geodesic and the straight line, figure 3 (a) of the paper."""

import numpy as np

from skpose._utils.validation import check_kind, check_skeleton
from skpose.geodesics import GeodesicResult
from skpose.kinematics import metric_tensor
from skpose.metrics import Spatial, pose_distances
from skpose.plot._axes import COLOURS, axes
from skpose.skeleton import Skeleton
from skpose.skeleton._interpolation import straight_line

MARGIN = 0.2  # around the curves, relative to their extent
ABOVE = 1.5  # times that above them, where the legend stands
AROUND_ONE_POSE = 0.1  # rad, where the two are equal


class GeodesicDisplay:
    """A geodesic and the straight line, in the plane of most variance of the points of both.

    The background is the trace of the metric tensor JᵀJ: it is dark where small changes of the angles move the joints
    far.

    Parameters
    ----------
    geodesic : GeodesicResult
        The geodesic.
    skeleton : Skeleton
        Its skeleton.

    Attributes
    ----------
    ratio_ : float
        Length of the geodesic over the length of the line, eq. 8, both by equally many chords; 1 at length zero.
    ax_ : matplotlib Axes
    figure_ : matplotlib Figure

    References
    ----------
    S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding", AMDO
    2012, figure 3 (a), :doi:`10.1007/978-3-642-31567-1_3`.

    Examples
    --------
    >>> from skpose import Skeleton, geodesic
    >>> from skpose.plot import GeodesicDisplay
    >>> arm = Skeleton.chain(3)
    >>> display = GeodesicDisplay.from_geodesic(geodesic([0.2, 0.3, 0.0], [2.4, 0.2, 0.1], arm), arm)
    >>> round(display.ratio_, 2)
    0.89
    """

    def __init__(self, geodesic: GeodesicResult, skeleton: Skeleton):
        self.geodesic, self.skeleton = geodesic, skeleton

    def plot(self, ax=None, *, resolution: int = 60) -> "GeodesicDisplay":
        """Draw the display.

        Parameters
        ----------
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        resolution : int, default=60
            Points of the background, horizontally and vertically.

        Returns
        -------
        GeodesicDisplay
            The display itself.
        """
        self.ax_, self.figure_ = axes(ax)
        path = self.geodesic.path
        line = straight_line(self.skeleton.bones, path[0], path[-1], len(path))
        straight = Spatial(n_steps=len(path) - 1, wrap=False)
        length = pose_distances(path[:1], path[-1:], skeleton=self.skeleton, metric=straight)[0, 0]
        self.ratio_ = float(self.geodesic.length / length) if length > 0.0 else 1.0
        both = np.concatenate([path, line])
        mean, axes_of_plane = both.mean(axis=0), _main_axes(both - both.mean(axis=0))
        points = (both - mean) @ axes_of_plane.T
        extent = np.ptp(points, axis=0)
        margin = MARGIN * np.maximum(extent, 0.1 * extent.max()) if extent.any() else AROUND_ONE_POSE
        x, y = np.linspace(
            points.min(axis=0) - margin, points.max(axis=0) + margin * np.array([1.0, ABOVE]), resolution
        ).T
        grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        trace = np.trace(metric_tensor(mean + grid @ axes_of_plane, self.skeleton), axis1=1, axis2=2)
        image = self.ax_.pcolormesh(x, y, trace.reshape(len(y), len(x)), cmap="Greys", shading="gouraud")
        self.figure_.colorbar(image, ax=self.ax_, label="squared movement of the joints per angle (m²/rad²)")
        size = 6 if len(path) < 20 else 3
        self.ax_.plot(*points[len(path) :].T, "o--", color=COLOURS[0], ms=size, label="straight line")
        self.ax_.plot(*points[: len(path)].T, "s-", color=COLOURS[1], ms=size, label="geodesic")
        self.ax_.set(xlabel="first principal component (rad)", ylabel="second principal component (rad)")
        self.ax_.legend(loc="upper center", ncols=2)
        return self

    @classmethod
    def from_geodesic(
        cls, geodesic: GeodesicResult, skeleton: Skeleton, *, ax=None, resolution: int = 60
    ) -> "GeodesicDisplay":
        """Draw a geodesic.

        Parameters
        ----------
        geodesic : GeodesicResult
            The geodesic.
        skeleton : Skeleton
            Its skeleton.
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        resolution : int, default=60
            Points of the background, horizontally and vertically.

        Returns
        -------
        GeodesicDisplay
            The display.
        """
        check_kind(geodesic, GeodesicResult, "geodesic", "skpose.geodesic(start, end, skeleton) finds one")
        check_skeleton(skeleton)
        if (n_dofs := geodesic.path.shape[1]) != skeleton.n_dofs:
            raise ValueError(f"skeleton must have {n_dofs} dofs, as the geodesic has, got {skeleton.n_dofs}")
        return cls(geodesic, skeleton).plot(ax, resolution=resolution)


def _main_axes(centred: np.ndarray) -> np.ndarray:
    """Two axes (2, n_dofs) of most variance; for points on a line, or one point, any plane through them.

    scikit-learn's PCA divides by the variance, which may be zero, and has no second axis for a single dof.
    """
    _, _, rows = np.linalg.svd(centred)
    found = np.zeros((2, centred.shape[1]))
    found[: len(rows)] = rows[:2]
    return found * np.sign(found[[0, 1], np.abs(found).argmax(axis=1)])[:, None]  # one of two directions
