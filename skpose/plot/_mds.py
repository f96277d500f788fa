"""Display of poses embedded in the plane."""

import numpy as np

from skpose._typing import ArrayLike
from skpose._validation.options import check_kind
from skpose.manifold import SpatialMDS
from skpose.plot._axes import PALETTE, add_legend, axes, label_style


class MDSDisplay:
    """Embedded poses, coloured by labels such as subject or action.

    Parameters
    ----------
    embedding : ndarray of shape (n_poses, n_components)
        Embedded poses; the first two components are drawn.
    labels : ndarray of shape (n_poses,) or None
        Labels such as subject, action, cluster, with a marker and one of twenty colours each. The legend of more than
        seven stands next to the axes. Floats of more than twenty values, such as a speed, have a colour bar instead.
    shares : ndarray of shape (n_components,) or None
        Shares of the variance, one for each component.
    unit : str
        Unit of the components.

    Attributes
    ----------
    ax_ : matplotlib Axes
    figure_ : matplotlib Figure

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Skeleton, SpatialMDS
    >>> from skpose.plot import MDSDisplay
    >>> arm, X = Skeleton.chain(2), np.random.default_rng(0).normal(size=(20, 2))
    >>> display = MDSDisplay.from_estimator(SpatialMDS(skeleton=arm).fit(X), X, labels=X[:, 0] > 0)
    >>> display.ax_.get_legend() is not None
    True
    """

    def __init__(
        self,
        embedding: np.ndarray,
        labels: np.ndarray | None = None,
        shares: np.ndarray | None = None,
        unit: str = "m",
    ):
        self.embedding, self.labels, self.shares, self.unit = embedding, labels, shares, unit

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
        self.ax_, self.figure_ = axes(ax, "MDSDisplay.plot")
        labels = np.zeros(len(self.embedding)) if self.labels is None else self.labels
        found, defaults = np.unique(labels), {"s": 16, "alpha": 0.8, "linewidths": 0}
        if labels.dtype.kind == "f" and len(found) > len(PALETTE):
            drawn = self.ax_.scatter(*self.embedding[:, :2].T, **defaults | {"c": labels} | style)
            self.figure_.colorbar(drawn, ax=self.ax_)
        else:
            for i, label in enumerate(found):
                own = defaults | {"label": str(label)} | label_style(i)
                self.ax_.scatter(*self.embedding[labels == label, :2].T, **own | style)
            if self.labels is not None:
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
            Coordinates of the poses, of which the first two are drawn.
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
        embedding = np.asarray(embedding)
        if embedding.ndim != 2 or embedding.shape[1] < 2:
            raise ValueError(f"embedding must have at least two components, got shape {embedding.shape}")
        labels = None if labels is None else np.asarray(labels)
        if labels is not None and labels.shape != embedding.shape[:1]:
            raise ValueError(f"labels must be one for each of the {len(embedding)} poses, got shape {labels.shape}")
        missing = sum(label is None or label != label for label in ([] if labels is None else labels.tolist()))
        if missing:
            raise ValueError(
                f"labels must be one for each pose, got {missing} of {len(embedding)} that are None or NaN: leave "
                'these poses out, or give them a label such as "unknown"'
            )
        shares = None if shares is None else np.asarray(shares)
        return cls(embedding, labels, shares, unit).plot(ax, **style)
