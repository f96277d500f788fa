"""Display of a matrix of distances."""

import numpy as np

from skpose._utils.typing import ArrayLike
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import check_poses
from skpose.metrics import Metric, pose_distances
from skpose.metrics._registry import resolve
from skpose.plot._axes import axes, plain
from skpose.skeleton import Skeleton


class DistanceMatrixDisplay:
    """A matrix of distances between poses, with lines between their sequences.

    Parameters
    ----------
    distances : ndarray of shape (n_poses, n_poses)
        Distances.
    sequence : ndarray of shape (n_poses,) or None
        Index of the sequence of each pose; the poses of a sequence are adjacent.
    names : sequence of str or None
        Names of the sequences, one each; neighbours of one name share a label, in their middle. None writes none.
    unit : str
        Unit of the distances.

    Attributes
    ----------
    ax_ : matplotlib Axes
    figure_ : matplotlib Figure

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.plot import DistanceMatrixDisplay
    >>> arm, X = Skeleton.chain(2), np.random.default_rng(0).normal(size=(20, 2))
    >>> display = DistanceMatrixDisplay.from_poses(X, arm, sequence=np.repeat([0, 1], 10), names=["up", "down"])
    >>> [label.get_text() for label in display.ax_.get_xticklabels()]
    ['up', 'down']
    """

    def __init__(self, distances: np.ndarray, sequence: np.ndarray | None = None, names=None, unit: str = "m"):
        self.distances, self.sequence, self.names, self.unit = distances, sequence, names, unit

    def plot(self, ax=None, **style) -> "DistanceMatrixDisplay":
        """Draw the display.

        Parameters
        ----------
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        **style
            Style of the image, such as cmap, vmax; see `matplotlib.axes.Axes.imshow`.

        Returns
        -------
        DistanceMatrixDisplay
            The display itself.
        """
        self.ax_, self.figure_ = axes(ax)
        image = self.ax_.imshow(self.distances, **{"cmap": "viridis", "interpolation": "nearest"} | style)
        self.figure_.colorbar(image, ax=self.ax_, label=f"distance ({self.unit})")
        if self.sequence is not None:
            borders = np.flatnonzero(np.diff(self.sequence)) + 1
            names = list(range(len(borders) + 1)) if self.names is None else list(self.names)
            first = [i for i, name in enumerate(names) if i == 0 or name != names[i - 1]]  # of neighbours of one name
            for i, border in enumerate(borders, start=1):
                width = 1.0 if i in first else 0.3
                self.ax_.axhline(border - 0.5, color="white", linewidth=width)
                self.ax_.axvline(border - 0.5, color="white", linewidth=width)
            ends = np.array([0, *borders, len(self.sequence)])[[*first, -1]]
            centres = (ends[:-1] + ends[1:] - 1) / 2
            labels = [""] * len(first) if self.names is None else [plain(names[i]) for i in first]
            self.ax_.set_xticks(centres, labels, rotation=90)
            self.ax_.set_yticks(centres, labels)
        else:
            self.ax_.set(xlabel="pose", ylabel="pose")
        return self

    @classmethod
    def from_poses(
        cls,
        X: ArrayLike,
        skeleton: Skeleton | None = None,
        *,
        sequence: ArrayLike | None = None,
        names=None,
        metric: str | Metric = "auto",
        n_jobs: int | None = None,
        ax=None,
        **style,
    ) -> "DistanceMatrixDisplay":
        """Draw the `pose_distances` of poses.

        Parameters
        ----------
        X : array-like of shape (n_poses, n_dofs)
            Poses: joint angles, rad.
        skeleton : Skeleton, default=None
            The skeleton of all poses. Needed by all metrics but "angle".
        sequence, names : array-like of shape (n_poses,), list of str, default=None
            Sequence of each pose and names of the sequences, see `from_distances`.
        metric : str or Metric, default="auto"
            The distance, see `skpose.pose_distances`; "auto" is "spatial" with a skeleton, else "angle" and a warning.
        n_jobs : int, default=None
            Threads, see `skpose.pose_distances`.
        ax : matplotlib Axes, default=None
            Axes to draw into; None makes a figure.
        **style : dict
            For ``Axes.imshow``.

        Returns
        -------
        DistanceMatrixDisplay
            The display.
        """
        X = check_poses(X, skeleton, "X")
        if skeleton is not None:
            warn_of_degrees(None, skeleton, X=X)
        distances = pose_distances(X, skeleton=skeleton, metric=metric, n_jobs=n_jobs)
        unit = resolve(metric, skeleton).unit
        return cls.from_distances(distances, sequence=sequence, names=names, unit=unit, ax=ax, **style)

    @classmethod
    def from_distances(
        cls, distances: ArrayLike, *, sequence: ArrayLike | None = None, names=None, unit: str = "m", ax=None, **style
    ) -> "DistanceMatrixDisplay":
        """Draw a matrix of distances.

        Parameters
        ----------
        distances : array-like of shape (n_poses, n_poses)
            Distances.
        sequence : array-like of shape (n_poses,), default=None
            Sequence of each pose; lines are drawn between sequences.
        names : list of str, default=None
            Names of the sequences, one each; neighbours of one name share a label.
        unit : str, default="m"
            Unit of the distances.
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        **style
            Style of the image, such as cmap, vmax; see `matplotlib.axes.Axes.imshow`.

        Returns
        -------
        DistanceMatrixDisplay
            The display.
        """
        distances = np.asarray(distances)
        if distances.shape != 2 * distances.shape[:1]:
            raise ValueError(f"distances must be a square matrix, got shape {distances.shape}")
        if sequence is not None:
            sequence = np.asarray(sequence)
            if sequence.shape != distances.shape[:1]:
                raise ValueError(f"sequence must have shape {distances.shape[:1]}, got {sequence.shape}")
            sequence = np.unique(sequence, return_inverse=True)[1]
            n_runs = 1 + np.count_nonzero(np.diff(sequence))
            if names is not None and len(names) != n_runs:
                raise ValueError(f"names must have one name for each of {n_runs} sequences, got {len(names)}")
        return cls(distances, sequence, names, unit).plot(ax, **style)
