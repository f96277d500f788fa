"""Display of poses embedded in the plane."""

import numpy as np

from skpose._utils.typing import ArrayLike
from skpose._utils.validation import check_kind
from skpose.manifold import SpatialMDS
from skpose.plot._axes import PALETTE, add_legend, axes, label_style
from skpose.plot._labels import find_groups

COLOUR = {"c", "color", "facecolor", "facecolors"}  # what of a style colours markers


class MDSDisplay:
    """Embedded poses, coloured by labels such as subject or action.

    Parameters
    ----------
    embedding : array-like of shape (n_poses, n_components)
        Embedded poses; the first two components are drawn.
    labels : array-like of shape (n_poses,), default=None
        Labels such as subject, action or cluster, sorted, each with a marker and one of twenty colours; an ordered
        categorical of pandas keeps its order. The legend of more than seven labels stands next to the axes. Floats of
        more than twenty values, such as a speed, have a colour bar instead. None draws all in one colour.
    shares : array-like of shape (n_components,), default=None
        Shares of the variance, one for each component.
    unit : str, default="m"
        Unit of the components.

    Attributes
    ----------
    ax_ : matplotlib Axes
    figure_ : matplotlib Figure

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.manifold import SpatialMDS
    >>> from skpose.plot import MDSDisplay
    >>> arm, X = Skeleton.chain(2), np.random.default_rng(0).normal(size=(20, 2))
    >>> display = MDSDisplay.from_estimator(SpatialMDS(skeleton=arm).fit(X), X, labels=X[:, 0] > 0)
    >>> display.ax_.get_legend() is not None
    True
    """

    def __init__(
        self,
        embedding: ArrayLike,
        labels: ArrayLike | None = None,
        shares: ArrayLike | None = None,
        unit: str = "m",
    ):
        self.embedding, self.unit = np.asarray(embedding), unit
        if self.embedding.ndim != 2 or self.embedding.shape[1] < 2:
            raise ValueError(f"embedding must have at least two components, got shape {self.embedding.shape}")
        self._groups = None if labels is None else find_groups(labels, len(self.embedding))
        self.labels = None if self._groups is None else self._groups.labels
        self.shares = None if shares is None else np.asarray(shares)

    def plot(self, ax=None, **style) -> "MDSDisplay":
        """Draw the display.

        Parameters
        ----------
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        **style
            Style of the markers, see `matplotlib.axes.Axes.scatter`.

        Returns
        -------
        MDSDisplay
            The display itself.
        """
        self.ax_, self.figure_ = axes(ax)
        x, y = self.embedding[:, :2].T
        groups, defaults = self._groups, {"s": 16, "alpha": 0.8, "linewidths": 0}
        is_coloured = not COLOUR.isdisjoint(style)
        if groups is not None and groups.labels.dtype.kind == "f" and len(groups.names) > len(PALETTE):
            drawn = self.ax_.scatter(x, y, **defaults | ({} if is_coloured else {"c": groups.labels}) | style)
            if drawn.get_array() is not None:  # colours are of numbers
                self.figure_.colorbar(drawn, ax=self.ax_)
        else:
            for i, name in enumerate([""] if groups is None else groups.names):
                own = label_style(i) | ({} if groups is None else {"label": name})
                if is_coloured:
                    del own["color"]
                chosen = slice(None) if groups is None else groups.numbers == i
                self.ax_.scatter(x[chosen], y[chosen], **defaults | own | style)
            if groups is not None:
                add_legend(self.ax_, is_new=ax is None)
        for axis, set_label in enumerate((self.ax_.set_xlabel, self.ax_.set_ylabel)):
            share = "" if self.shares is None else f", {self.shares[axis]:.0%} of the variance"
            set_label(f"component {axis + 1} ({self.unit}){share}")
        self.ax_.set_aspect("equal", adjustable="datalim")
        return self

    @classmethod
    def from_estimator(
        cls, mds: SpatialMDS, X: ArrayLike, labels: ArrayLike | None = None, *, ax=None, **style
    ) -> "MDSDisplay":
        """Draw poses embedded by a fitted `SpatialMDS` of at least two components.

        Parameters
        ----------
        mds : SpatialMDS
            The fitted estimator.
        X : array-like of shape (n_poses, n_dofs) or (n_poses, n_samples_fit)
            Poses: joint angles, rad; or what else `SpatialMDS.transform` takes.
        labels : array-like of shape (n_poses,), default=None
            Label of each pose; None draws all in one colour.
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        **style
            Style of the markers, see `matplotlib.axes.Axes.scatter`.

        Returns
        -------
        MDSDisplay
            The display.
        """
        check_kind(mds, SpatialMDS, "mds", "it comes first, then the poses; from_embedding draws other embeddings")
        unit = "m" if mds.metric_ is None else mds.metric_.unit
        return cls.from_embedding(
            mds.transform(X), labels, shares=mds.explained_variance_ratio_, unit=unit, ax=ax, **style
        )

    @classmethod
    def from_embedding(
        cls,
        embedding: ArrayLike,
        labels: ArrayLike | None = None,
        *,
        shares: ArrayLike | None = None,
        unit: str = "m",
        ax=None,
        **style,
    ) -> "MDSDisplay":
        """Draw embedded poses.

        Parameters
        ----------
        embedding : array-like of shape (n_poses, n_components)
            Coordinates of the poses; the first two are drawn.
        labels : array-like of shape (n_poses,), default=None
            Label of each pose; None draws all in one colour.
        shares : array-like of shape (n_components,), default=None
            Shares of the variance, one for each component.
        unit : str, default="m"
            Unit of the components.
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        **style
            Style of the markers, see `matplotlib.axes.Axes.scatter`.

        Returns
        -------
        MDSDisplay
            The display.
        """
        return cls(embedding, labels, shares, unit).plot(ax, **style)
