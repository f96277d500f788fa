"""Display of confusions: which classes were taken for which others, and the motions of the most frequent ones."""

from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np
from sklearn.metrics import ConfusionMatrixDisplay

from skpose._typing import ArrayLike
from skpose._validation.options import check_integer
from skpose.kinematics import forward_kinematics
from skpose.metrics import Metric
from skpose.motions._shared import check_motions
from skpose.plot._axes import axes
from skpose.plot._confused import (
    Confusion,
    check_column,
    check_distances,
    count_confusions,
    find_nearest,
    list_recordings,
    sort_confusions,
)
from skpose.plot._pose import GAP as BETWEEN
from skpose.plot._pose import check_projection, draw_pose
from skpose.plot._views import find_vertical, name_view
from skpose.plot._volume import shape_of_person
from skpose.skeleton import Motion, Skeleton

MATRIX, CELLS, MARGIN, GAP = (
    4.6,
    (0.25, 0.7),
    0.95,
    0.25,
)  # inches: all cells, the smallest and the largest; around them
FIGURE, ROWS = 0.66, (0.3, 0.95, 0.95)  # inches: the width of a figure; the heights of a heading and two strips
LETTER, SMALL, BOLD = 0.082, 0.068, 0.087  # inches: a letter of a class, of a label, of a heading
FONTS, MEDIUM, LITTLE = (4.5, 9.0), 10.0, 8.3  # points: the smallest and the largest of the matrix; headings; labels
RIGHT, WRONG = ("#ececec", "#8a8a8a"), ("#f6e3ee", "#cc79a7", "#8c2f66")  # greys, and about the purple of COLOURS
NOTE = "0.5"
PASSES = 3  # until the layout has found the room of cells that are square
FIGURES: dict[str, Any] = {"linewidth": 1.5, "markersize": 1.5, "clip_on": False}


class ConfusionDisplay:
    """The confusion matrix of a classifier, and next to it the motions of the most frequent confusions.

    Rows of the matrix are true classes, columns predicted ones. Classes that are confused with each other stand next to
    each other. Numbers are counts, colours shares of the true class: what is right is grey, confusions are purple.

    The confusions that occur most often have a frame in the matrix, and two strips of figures: one of the motions that
    were confused, and below it what is nearest to it in the class that it was taken for. Of several confused motions it
    is the one with the least such distance. Figures are at equal intervals of time, from the first frame to the last,
    in the axes of the root, on one skeleton and scale, with left and right as in `PoseDisplay`. Of poses, each strip
    has several confused ones, and below each the one that is nearest to it.

    Parameters
    ----------
    confusion_matrix : ndarray of shape (n_classes, n_classes)
        Counts, rows true, columns predicted, from `sklearn.metrics.confusion_matrix`.
    labels : list of length n_classes
        The classes in the order of the rows.
    confusions : list of Confusion
        All that were taken for another class: those of the most frequent pairs of classes first, and of one pair those
        first that are nearest to the class that they were taken for.
    skeleton : Skeleton
        The skeleton of all figures.
    motions, train : tuple
        The motions that were classified, and those that they were taken for, as `from_predictions` makes them.
    vertical : int, default=1
        The upright axis, 0 for x.

    Attributes
    ----------
    ax_ : matplotlib Axes
        The axes in whose place all is drawn.
    matrix_ax_ : matplotlib Axes
        The axes of the matrix.
    strip_axes_ : list of tuple of two matplotlib Axes
        The axes of both strips of each pair of classes, in the order of the pairs.
    shown_ : list of Confusion
        The confusions whose figures are drawn.
    figure_ : matplotlib Figure

    See Also
    --------
    sklearn.metrics.ConfusionMatrixDisplay : The matrix alone.
    AlignmentDisplay : Two of the motions, and the joints in which they differ.

    Examples
    --------
    The arm goes up once or twice; the nearest of the others names it:

    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.plot import ConfusionDisplay
    >>> def swings(times, height):
    ...     return height * np.sin(np.linspace(0, times * np.pi, 20))[:, np.newaxis] ** 2
    >>> X = [swings(1, 1.0), swings(1, 0.1), swings(2, 1.0), swings(2, 0.9)]
    >>> y_true, y_pred = ["once", "once", "twice", "twice"], ["once", "twice", "twice", "twice"]
    >>> display = ConfusionDisplay.from_predictions(y_true, y_pred, X, Skeleton.chain(1))
    >>> display.confusion_matrix
    array([[1, 1],
           [0, 2]])
    >>> [(one.sample, one.predicted, one.nearest) for one in display.confusions]
    [(1, 'twice', 3)]
    """

    def __init__(
        self,
        confusion_matrix: np.ndarray,
        labels: list,
        confusions: list[Confusion],
        skeleton: Skeleton,
        motions: Any,
        train: Any,
        vertical: int = 1,
    ):
        self.confusion_matrix, self.labels, self.confusions = confusion_matrix, labels, confusions
        self.skeleton, self.motions, self.train, self.vertical = skeleton, motions, train, vertical

    def plot(
        self, ax=None, *, n_pairs: int = 3, n_poses: int = 7, projection: str | None = None, **style
    ) -> "ConfusionDisplay":
        """Draw the display.

        Parameters
        ----------
        ax : matplotlib Axes, default=None
            The axes in whose place all is drawn, one of ``plt.subplots``; None makes new ones.
        n_pairs : int, default=3
            Pairs of classes whose motions are drawn, fewer where fewer are confused.
        n_poses : int, default=7
            Figures side by side, fewer where a motion has fewer frames.
        projection : str, default=None
            The horizontal and the vertical axis of the figures, see `PoseDisplay.plot`. None has the axis upright that
            is nearest to the vertical of the world, y for arrays, and shows each pair from the side from which the
            joints are seen to move more.
        **style
            Style of the figures, such as color, linewidth; see `matplotlib.axes.Axes.plot`.

        Returns
        -------
        ConfusionDisplay
            The display itself.
        """
        check_integer(n_pairs, 1, "n_pairs")
        check_integer(n_poses, 1, "n_poses")
        if projection is not None:
            check_projection(projection)
        each = n_poses if self.motions.noun == "pose" else 1
        pairs = [list(pair)[:each] for _, pair in groupby(self.confusions, lambda one: (one.true, one.predicted))]
        pairs = pairs[:n_pairs]
        self.shown_ = [one for pair in pairs for one in pair]
        names, cell, widths, columns = self._find_sizes(pairs, n_poses)
        size = sum(widths), max(len(self.labels) * cell + names + MARGIN, len(pairs) * sum(ROWS))
        self.ax_, self.figure_ = axes(ax, "ConfusionDisplay.plot", size)
        where = self.ax_.get_subplotspec()
        if where is None:
            raise ValueError(
                "ax must be one of a grid, in whose place a grid can be drawn: plt.subplots() or "
                "figure.add_subplot() makes one"
            )
        scale = 1.0 if ax is None else min(1.0, *(self.ax_.get_window_extent().size / self.figure_.dpi / size))
        self.ax_.set_axis_off()
        grid = where.subgridspec(1, 3, width_ratios=widths)
        # A grid of its own: what stands above and below the matrix is no margin of the strips.
        self.matrix_ax_ = self.figure_.add_subplot(grid[0].subgridspec(1, 1)[0], anchor="N")
        self._draw_matrix(pairs, cell, scale)
        self.strip_axes_: list[tuple[Any, Any]] = []
        if pairs:
            rows = grid[2].subgridspec(3 * len(pairs), 2, width_ratios=columns, height_ratios=len(pairs) * ROWS)
            for k, pair in enumerate(pairs):
                self._draw_pair(rows, 3 * k, pair, n_poses, projection, style, scale)
        else:
            words = f"no confusions:\nall {self.confusion_matrix.sum()} {self.motions.noun}s\nhave their own class"
            blank = _add_blank(self.figure_, grid[2])
            blank.text(0.5, 0.5, words, ha="center", va="center", color=NOTE, fontsize=MEDIUM * scale)
        for _ in range(PASSES if ax is None else 0):
            self.figure_.draw_without_rendering()
        return self

    def _find_sizes(self, pairs, n_poses) -> tuple[float, float, list[float], list[float]]:
        """Return sizes in inches: the longest class; a cell; the matrix, a gap and the strips; labels and figures."""
        names = LETTER * max(len(str(label)) for label in self.labels)
        cell = float(np.clip(MATRIX / len(self.labels), *CELLS))
        matrix = max(len(self.labels) * cell, LETTER * len(self._summary())) + names + MARGIN
        if not pairs:
            return names, cell, [matrix, GAP, 2.5], []
        labels = SMALL * max(
            len(line) for pair in pairs for words in self._describe(pair) for line in words.split("\n")
        )
        headings = max(BOLD * len(self._title(pair)) + SMALL * len(" seen from the right") for pair in pairs)
        columns = [labels, max(FIGURE * n_poses, headings - labels)]
        return names, cell, [matrix, GAP, sum(columns)], columns

    def _draw_matrix(self, pairs, cell, scale) -> None:
        """Draw counts on the colours of shares, and frames around the pairs."""
        from matplotlib import rcParams
        from matplotlib.colors import LinearSegmentedColormap, to_rgb
        from matplotlib.patches import Rectangle

        ax, counts = self.matrix_ax_, self.confusion_matrix
        n, longest = len(counts), max(len(str(label)) for label in self.labels)
        size = scale * float(np.clip(0.42 * 72.0 * cell, *FONTS))
        fits = max(longest, 4) * 0.6 * size < 72.0 * scale * cell
        drawn = ConfusionMatrixDisplay(counts, display_labels=self.labels)
        drawn.plot(
            ax=ax,
            colorbar=False,
            values_format="d",
            xticks_rotation="horizontal" if fits else "vertical",
            text_kw={"fontsize": size},
        )
        drawn.im_.remove()  # its colours are those of counts, in which rare classes are pale
        shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
        is_right = np.eye(n, dtype=bool)
        largest = shares[~is_right].max(initial=0.0) or 1.0
        for chosen, colours, top in ((is_right, RIGHT, 1.0), (~is_right, WRONG, largest)):
            colour_map = LinearSegmentedColormap.from_list("shares", colours)
            values = np.ma.masked_where(~chosen | (counts == 0), shares)
            ax.imshow(values, cmap=colour_map, vmin=0.0, vmax=top, interpolation="nearest")
            for i, j in np.argwhere(chosen):
                text = drawn.text_[i, j]
                luminance = np.dot(to_rgb(colour_map(shares[i, j] / top)), [0.2126, 0.7152, 0.0722])
                text.set_color("white" if luminance < 0.45 else "0.1")
                text.set_visible(bool(counts[i, j]))
        ax.set_xticks(np.arange(n - 1) + 0.5, minor=True)
        ax.set_yticks(np.arange(n - 1) + 0.5, minor=True)
        ax.grid(which="minor", color="0.5", alpha=0.3, linewidth=0.5)
        ax.tick_params(which="minor", length=0)
        ax.tick_params(which="major", length=0, labelsize=size)
        for pair in pairs:
            row, column = self.labels.index(pair[0].true), self.labels.index(pair[0].predicted)
            ax.add_patch(
                Rectangle(
                    (column - 0.5, row - 0.5), 1, 1, fill=False, edgecolor=rcParams["text.color"], linewidth=1.5 * scale
                )
            )
        ax.set_xlabel("predicted", fontsize=MEDIUM * scale)
        ax.set_ylabel("true", fontsize=MEDIUM * scale)
        ax.set_title(self._summary(), fontsize=MEDIUM * scale, loc="left")

    def _draw_pair(self, rows, k, pair, n_poses, projection, style, scale) -> None:
        """Draw a heading, and two strips with labels, from row k."""
        heading, *parts = (
            _add_blank(self.figure_, where)
            for where in (rows[k, :], rows[k + 1, 0], rows[k + 2, 0], rows[k + 1, 1], rows[k + 2, 1])
        )
        labels, strips = parts[:2], parts[2:]
        self.strip_axes_.append((strips[0], strips[1]))
        view = self._draw_figures(strips, pair, n_poses, projection, style)
        text = heading.text(0.0, 0.5, self._title(pair), va="center", fontweight="bold", fontsize=MEDIUM * scale)
        small: dict[str, Any] = {"va": "bottom", "fontsize": LITTLE * scale, "color": NOTE}
        heading.annotate(view.removeprefix("; "), (1, 0), (6, 0), xycoords=text, textcoords="offset points", **small)
        for ax, words in zip(labels, self._describe(pair), strict=True):
            ax.text(0.0, 0.5, words, va="center", fontsize=LITTLE * scale, linespacing=1.3)

    def _draw_figures(self, axes_of_strips, pair, n_poses, projection, style) -> str:
        """Draw the figures of a pair, and return in words from where they are seen."""
        from matplotlib.cbook import normalize_kwargs
        from matplotlib.lines import Line2D

        from skpose.plot._pose_transform import PoseTransform

        upper = [self.motions.poses[one.sample] for one in pair]
        lower = [self.train.poses[one.nearest] for one in pair if one.nearest is not None]
        moving = forward_kinematics(np.concatenate(upper + lower), self.skeleton)
        if projection is None:
            squares = moving.var(axis=0).sum(axis=0)
            squares[self.vertical] = -1.0
            projection = "xyz"[int(squares.argmax())] + "xyz"[self.vertical]
        plane = check_projection(projection)
        strips = [
            forward_kinematics(np.concatenate([_spread(poses, n_poses) for poses in part]), self.skeleton)
            for part in (upper, lower)
            if part
        ]
        low, high = (
            edge(np.concatenate(strips)[:, :, plane], axis=1, initial=0.0) for edge in (np.min, np.max)
        )  # with the root
        middle = (low + high) / 2
        bottom, top = low[:, 1].min(), high[:, 1].max()
        middle[:, 1] = (bottom + top) / 2  # of all, so that the roots have one height
        size = ((high - low)[:, 0].max(), top - bottom)
        room = 1.0 / ((1.0 + BETWEEN) * n_poses), 1.0 - BETWEEN
        style = FIGURES | normalize_kwargs(style, Line2D)
        centres, shape = iter(middle), shape_of_person(self.skeleton)
        for ax, poses in zip(axes_of_strips, strips, strict=False):
            for k, pose in enumerate(poses):
                transform = PoseTransform(ax, next(centres), ((k + 0.5) / n_poses, 0.5), room, size)
                draw_pose(ax, pose, plane, self.skeleton, shape, 0.0, {"transform": transform} | style)
        return name_view(moving, self.skeleton.joint_names, plane)

    def _summary(self) -> str:
        """Return how many are recognised, and which share that is."""
        right, n = int(np.trace(self.confusion_matrix)), int(self.confusion_matrix.sum())
        return f"{right} of {n} {self.motions.noun}s recognised, {right / n:.1%}"

    def _title(self, pair) -> str:
        """Return the heading of a pair: which class was taken for which, and how often."""
        first = pair[0]
        of_class = int(self.confusion_matrix[self.labels.index(first.true)].sum())
        return f"{first.true} taken for {first.predicted}, {first.frequency} of {of_class}"

    def _describe(self, pair) -> tuple[str, str]:
        """Return the labels of the strips of a pair: the class, and which motions of it."""
        of_pair = [one.sample for one in pair], [one.nearest for one in pair]
        return (
            f"{pair[0].true}\n{self.motions.describe(of_pair[0])}",
            f"{pair[0].predicted}\n{self.train.describe(of_pair[1])}",
        )

    @classmethod
    def from_predictions(
        cls,
        y_true: ArrayLike,
        y_pred: ArrayLike,
        X: Any,
        skeleton: Skeleton | None = None,
        *,
        subjects: ArrayLike | None = None,
        X_train: Any = None,
        y_train: ArrayLike | None = None,
        distances: ArrayLike | None = None,
        metric: str | Metric = "auto",
        n_jobs: int | None = None,
        labels: Sequence | None = None,
        n_pairs: int = 3,
        n_poses: int = 7,
        ax=None,
        projection: str | None = None,
        **style,
    ) -> "ConfusionDisplay":
        """Draw the confusions of predicted classes.

        Parameters
        ----------
        y_true : array-like of shape (n_motions,)
            The class of each motion.
        y_pred : array-like of shape (n_motions,)
            The predicted class of each motion, such as from `sklearn.model_selection.cross_val_predict`.
        X : list of Motion or of array-like, MotionDataset, or array of shape (n_motions, n_frames, n_dofs)
            The motions, see `skpose.motion_distances`; or poses, an array of shape (n_poses, n_dofs).
        skeleton : Skeleton, default=None
            The skeleton of all motions. None is that of the `Motion` objects, where they differ their mean; arrays need
            it.
        subjects : array-like of shape (n_motions,), default=None
            The person of each motion: without `X_train` the nearest motion is another person's, as in cross-validation
            by people. None takes those of a `MotionDataset`.
        X_train : as X, default=None
            The motions that the classifier learnt from. None is X itself, as with `cross_val_predict`.
        y_train : array-like of shape (n_train,), default=None
            Their classes.
        distances : array-like of shape (n_motions, n_train), default=None
            Distances from X to the motions that the classifier learnt from, such as of
            `skpose.motions.MotionDistanceTransformer`, from which the nearest motion follows. None computes those that
            are needed.
        metric : str or Metric, default="auto"
            The distance, where `distances` are not given, see `skpose.motion_distances`, and of poses
            `skpose.pose_distances`.
        n_jobs : int, default=None
            Threads for the distances, see `skpose.motion_distances`.
        labels : sequence, default=None
            All classes, in the order of the rows. None has classes next to each other that are confused.
        n_pairs : int, default=3
            Pairs of classes whose motions are drawn, fewer where fewer are confused.
        n_poses : int, default=7
            Figures side by side, fewer where a motion has fewer frames.
        ax : matplotlib Axes, default=None
            The axes in whose place all is drawn, one of ``plt.subplots``; None makes new ones.
        projection : str, default=None
            The horizontal and the vertical axis of the figures; None is the side from which more movement is seen, see
            `plot`.
        **style
            Style of the figures, such as color, linewidth; see `matplotlib.axes.Axes.plot`.

        Returns
        -------
        ConfusionDisplay
            The display.

        Raises
        ------
        TypeError
            If X are no motions or poses.
        ValueError
            If the numbers of motions, classes, subjects and distances differ; if `distances` are negative, or from a
            motion to itself not zero, as in a kernel; if arrays have no skeleton; if `labels`
            lack a class, or `y_train` one that was predicted.

        Notes
        -----
        Distances are computed from each motion that is confused to those of the class that it was taken for: with s the
        share of the motions that are confused, less than s times a matrix of all.
        """
        given = {"X": X} if X_train is None else {"X": X, "X_train": X_train}
        if (X_train is None) != (y_train is None):
            raise ValueError("X_train and y_train belong together, the motions and their classes; got one of the two")
        checked = check_motions(given, skeleton, rows=True)
        skeleton = checked[0].skeleton
        if skeleton is None:
            raise ValueError("ConfusionDisplay needs the skeleton of arrays to draw them: pass skeleton=")
        motions = list_recordings(X, "X", checked[0], y_true, "y_true", subjects)
        train = motions
        if X_train is not None:
            train = list_recordings(X_train, "X_train", checked[1], y_train, "y_train", None)
        predicted = check_column(y_pred, "y_pred", len(motions.poses), "X")
        if distances is not None:
            distances = check_distances(distances, len(motions.poses), train, X_train is None)
        counts, order = count_confusions(motions.classes, predicted, labels)
        confused = np.flatnonzero(motions.classes != predicted)
        nearest = find_nearest(confused, predicted, motions, train, distances, skeleton, metric, n_jobs)
        confusions = sort_confusions(confused, motions.classes, predicted, nearest, counts, order)
        vertical = find_vertical([one for one in motions.given if isinstance(one, Motion)])
        display = cls(counts, order, confusions, skeleton, motions, train, vertical)
        return display.plot(ax, n_pairs=n_pairs, n_poses=n_poses, projection=projection, **style)


def _spread(poses: np.ndarray, n: int) -> np.ndarray:
    """Return poses at equal intervals, the first and the last among them."""
    return poses[np.unique(np.rint(np.linspace(0, len(poses) - 1, n)).astype(int))]


def _add_blank(figure, where):
    """Add axes from 0 to 1 in both directions in which only what is drawn is seen."""
    ax = figure.add_subplot(where)
    ax.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    ax.set_axis_off()
    return ax
