"""Display of a principal component of poses."""

import numpy as np
from sklearn.utils.validation import check_is_fitted

from skpose._utils.validation import check_integer, check_kind, check_positive
from skpose.kinematics import forward_kinematics
from skpose.plot._pose import PoseStripDisplay
from skpose.skeleton import Skeleton
from skpose.statistics import PoseTangentPCA


class TangentPCADisplay:
    """Poses along a principal component, the mean in the middle; left and right as in `PoseDisplay`.

    Parameters
    ----------
    positions : ndarray of shape (n_poses, n_joints, 3)
        Positions of the joints, m, the root at the origin.
    skeleton : Skeleton
        Their skeleton.
    deviations : ndarray of shape (n_poses,)
        Score of each pose, in standard deviations of the training poses.
    component : int
        Index of the component.
    share : float
        Its share of the variance.

    Attributes
    ----------
    ax_ : matplotlib Axes
    figure_ : matplotlib Figure

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.statistics import PoseTangentPCA
    >>> from skpose.plot import TangentPCADisplay
    >>> arm, X = Skeleton.chain(2), np.random.default_rng(0).normal(scale=0.5, size=(20, 2))
    >>> display = TangentPCADisplay.from_estimator(PoseTangentPCA(arm).fit(X))
    >>> [label.get_text() for label in display.ax_.get_xticklabels()]
    ['−2', '−1', '0', '+1', '+2']
    """

    def __init__(self, positions: np.ndarray, skeleton: Skeleton, deviations: np.ndarray, component: int, share: float):
        self.positions, self.skeleton, self.deviations = positions, skeleton, deviations
        self.component, self.share = component, share

    def plot(self, ax=None, *, projection: str | None = None, **style) -> "TangentPCADisplay":
        """Draw the poses.

        Parameters
        ----------
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        projection : str, default=None
            The horizontal and the vertical axis, see `PoseDisplay.plot`.
        **style
            Style of the lines, see `PoseDisplay.plot`.

        Returns
        -------
        TangentPCADisplay
            The display itself.
        """
        labels = [f"{deviation:+.3g}".replace("-", "−") if deviation else "0" for deviation in self.deviations]
        title = f"standard deviations along component {self.component + 1}, {self.share:.0%} of the variance"
        strip = PoseStripDisplay(self.positions, self.skeleton, labels, title).plot(ax, projection=projection, **style)
        self.ax_, self.figure_ = strip.ax_, strip.figure_
        return self

    @classmethod
    def from_estimator(
        cls, pca: PoseTangentPCA, component: int = 0, *, n_poses: int = 5, extent: float = 2.0, ax=None, **options
    ) -> "TangentPCADisplay":
        """Draw poses along a component of a fitted `PoseTangentPCA`, from minus to plus `extent` standard deviations.

        Parameters
        ----------
        pca : PoseTangentPCA
            The fitted estimator.
        component : int, default=0
            Index of the component, the first is 0.
        n_poses : int, default=5
            Number of poses to draw.
        extent : float, default=2.0
            Score of the last pose, in standard deviations of the training poses; the first has its opposite.
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        **options
            Projection and style, see `plot`.

        Returns
        -------
        TangentPCADisplay
            The display.
        """
        check_kind(pca, PoseTangentPCA, "pca", "PoseTangentPCA(skeleton).fit(X) is one")
        check_is_fitted(pca, "n_components_")
        check_integer(n_poses, 2, "n_poses")
        if not 0 <= component < pca.n_components_:
            raise ValueError(f"component must be from 0 to {pca.n_components_ - 1}, got {component}")
        if pca.skeleton_ is None:
            raise ValueError("pca must have a skeleton to be drawn, got PoseTangentPCA(None)")
        check_positive("extent", extent)
        deviations, scores = np.linspace(-extent, extent, n_poses), np.zeros((n_poses, pca.n_components_))
        scores[:, component] = deviations * np.sqrt(pca.explained_variance_[component])
        positions = forward_kinematics(pca.inverse_transform(scores), pca.skeleton_)
        share = float(pca.explained_variance_ratio_[component])
        return cls(positions, pca.skeleton_, deviations, component, share).plot(ax, **options)
