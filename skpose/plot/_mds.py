"""Display of poses embedded in the plane."""

import math

import numpy as np

from skpose._utils.typing import ArrayLike
from skpose._utils.validation import check_kind
from skpose.manifold import SpatialMDS
from skpose.plot._axes import INSIDE, LINES, OUTSIDE, PALETTE, axes, label_style, plain

MISSING = {"None", "nan", "NaT", "<NA>"}  # texts of labels that are not known


class MDSDisplay:
    """Embedded poses, coloured by labels such as subject or action.

    Parameters
    ----------
    embedding : array-like of shape (n_poses, n_components)
        Embedded poses; the first two components are drawn.
    labels : array-like of shape (n_poses,), default=None
        Labels such as subject, action or cluster, sorted, each with a marker and one of twenty colours. The legend of
        more than seven labels stands next to the axes. Floats of more than twenty values, such as a speed, have a
        colour bar instead. None draws all in one colour.
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
        self.labels = None if labels is None else _check_labels(labels, len(self.embedding))
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
        defaults = {"s": 16, "alpha": 0.8, "linewidths": 0}
        if self.labels is None:
            self.ax_.scatter(x, y, **defaults | label_style(0) | style)
        elif self.labels.dtype.kind == "f" and len(np.unique(self.labels)) > len(PALETTE):
            self.figure_.colorbar(self.ax_.scatter(x, y, **defaults | {"c": self.labels} | style), ax=self.ax_)
        else:
            for i, label in enumerate(np.unique(self.labels)):
                chosen = self.labels == label
                self.ax_.scatter(
                    x[chosen], y[chosen], label=_visible(plain(label)), **defaults | label_style(i) | style
                )
            n = len(np.unique(self.labels))
            self.ax_.legend(**({} if n <= INSIDE else OUTSIDE | {"ncols": math.ceil(n / LINES)}))
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


def _check_labels(labels: ArrayLike, n: int) -> np.ndarray:
    values = np.asarray(labels)
    if values.shape != (n,):
        raise ValueError(f"labels must have one value for each of the {n} poses, got shape {values.shape}")
    if missing := sum(str(label) in MISSING for label in values):
        raise ValueError(f"labels must be known for all poses, got {missing} of {n} that are None or NaN")
    return values


def _visible(name: str) -> str:
    """A name as legends show it: matplotlib leaves out empty ones and those after "_" without quotes."""
    return name if name.strip() and not name.startswith("_") else f'"{name}"'
