"""Keypoints: positions of named points in time, some of them not seen."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, NoReturn

import numpy as np

from skpose._utils.typing import ArrayLike, DataFrame
from skpose._utils.upper_layers import Page, upper_layers
from skpose._utils.validation import as_numbers, check_choice, check_frame_rate, check_positions, near_names
from skpose._utils.warnings import is_called_by_user, warn
from skpose.keypoints._checks import complaints_of, refuse_pictures


@dataclass(frozen=True, repr=False, eq=False)
class Keypoints:
    """Positions of named points at a constant frame rate, such as keypoints of a pose estimator or markers.

    Parameters
    ----------
    positions : array-like of shape (n_frames, n_points, 3)
        Positions, m; NaN where a point is not seen. A point of which one coordinate is NaN is not seen.
    names : iterable of str
        Name of each point, each once.
    frame_rate : float
        Frames per second, Hz.
    confidences : array-like of shape (n_frames, n_points), default=None
        Confidence of each position, from 0, not seen, to 1; the weights in `skpose.inverse_kinematics`. None is 1 for
        every point that is seen.
    up : {"x", "y", "z"}, default="y"
        The axis of the world that points up.

    Attributes
    ----------
    times : ndarray of shape (n_frames,)
        Time of each frame, s.

    Raises
    ------
    ValueError
        For shapes that do not fit each other, such as positions in two dimensions, infinite positions, duplicate names,
        confidences below 0 or above 1, a frame rate that is not positive. For eight points or more, or six with left
        and right, if they are keypoints in two dimensions: all in one plane, such as z = 0, or with COCO's visibility,
        0, 1 or 2, a score, or a depth in another unit instead of z.

    Warns
    -----
    UserWarning
        If points are at exactly (0, 0, 0), as some programs write lost points, except for a point that is there in
        every frame, such as the pelvis in positions relative to it. If x and y may be in units of a picture, from 0 to
        1 or pixels. If, by the names of points, heads are above feet along another axis than `up`.

    See Also
    --------
    skpose.inverse_kinematics : The poses of a skeleton at these positions.

    Notes
    -----
    The confidence of a point that is not seen becomes 0, and the position of a point with confidence 0 becomes NaN.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose.keypoints import Keypoints
    >>> positions = np.zeros((50, 2, 3))
    >>> positions[10:20, 1] = np.nan
    >>> seen = Keypoints(positions, ["hip", "knee"], frame_rate=25)
    >>> seen
    Keypoints(50 frames at 25 Hz, 2.0 s, 2 points, 10.0 % not seen)
    >>> int(seen.select(["knee"]).confidences.sum())
    40
    """

    positions: np.ndarray
    names: tuple[str, ...]
    frame_rate: float
    confidences: np.ndarray = None  # type: ignore[assignment]  # None becomes ones and zeros
    up: Literal["x", "y", "z"] = "y"

    if TYPE_CHECKING:

        def __init__(
            self,
            positions: ArrayLike,
            names: Iterable[str],
            frame_rate: float,
            confidences: ArrayLike | None = None,
            up: Literal["x", "y", "z"] = "y",
        ) -> None: ...

    def __post_init__(self) -> None:
        names = tuple(self.names)
        if len(set(names)) < len(names) or not all(
            isinstance(name, str) and name and "\0" not in name for name in names
        ):
            raise ValueError(f"names must be different, non-empty strings without NUL, got {names}")
        check_frame_rate(self.frame_rate)
        check_choice("up", self.up, ("x", "y", "z"))
        positions = check_positions(self.positions, len(names), "positions")
        seen = ~np.isnan(positions).any(axis=2)
        given = np.ones(seen.shape) if self.confidences is None else self.confidences
        confidences = as_numbers(given, "confidences", masked=0.0)
        if confidences.shape != seen.shape:
            raise ValueError(f"confidences must have shape {seen.shape}, got {confidences.shape}")
        if not ((confidences[seen] >= 0.0) & (confidences[seen] <= 1.0)).all():
            raise ValueError("confidences must be from 0, not seen, to 1")
        confidences[~seen] = 0.0
        positions[confidences == 0.0] = np.nan
        refuse_pictures(positions, names, "positions")
        if is_called_by_user(0):
            for complaint in complaints_of(positions, names, self.up, "by up=", "up={} (-: turn the world)"):
                warn(complaint)
        for name, value in {"names": names, "positions": positions, "confidences": confidences}.items():
            object.__setattr__(self, name, value)

    @property
    def times(self) -> np.ndarray:
        """Time of each frame, s."""
        return np.arange(len(self)) / self.frame_rate

    def __len__(self) -> int:
        return len(self.positions)

    def __getitem__(self, frames: slice) -> "Keypoints":
        """Select a range of frames: ``keypoints[100:200]``; with a step, at a lower frame rate."""
        step = getattr(frames, "step", 0) or 1
        if not isinstance(frames, slice) or step < 1:
            raise TypeError(
                f"keypoints are indexed by slices with a positive step, such as keypoints[0:10], got {frames}"
            )
        return replace(
            self,
            positions=self.positions[frames],
            confidences=self.confidences[frames],
            frame_rate=self.frame_rate / step,
        )

    def __array__(self, *arguments: object, **options: object) -> NoReturn:
        raise TypeError("Keypoints are not an array: pass keypoints.positions")

    def __repr__(self) -> str:
        lost = f", {np.mean(self.confidences == 0.0):.1%} not seen" if (self.confidences == 0.0).any() else ""
        rate = f"{len(self)} frames at {self.frame_rate:g} Hz, {len(self) / self.frame_rate:.1f} s"
        return f"Keypoints({rate}, {len(self.names)} points{lost.replace('%', ' %')})"

    def select(self, names: Iterable[str]) -> "Keypoints":
        """Select points, in the given order.

        Parameters
        ----------
        names : iterable of str
            Names of points.

        Returns
        -------
        Keypoints
            With these points.

        Raises
        ------
        KeyError
            For an unknown name.
        """
        names = (names,) if isinstance(names, str) else tuple(names)
        missing = [name for name in names if name not in self.names]
        if missing:
            raise KeyError(f"there is no point {missing[0]!r}: {near_names(self.names, missing[0], 'see names')}")
        chosen = [self.names.index(name) for name in names]
        return replace(self, positions=self.positions[:, chosen], names=names, confidences=self.confidences[:, chosen])

    def fill_gaps(self, longest: float | None = None, *, confidence: float = 0.1) -> "Keypoints":
        """Fill gaps by linear interpolation in time.

        Parameters
        ----------
        longest : float, default=None
            Longest gap to fill, s; None fills gaps of any length.
        confidence : float, default=0.1
            Confidence of the interpolated positions, above 0 and at most 1.

        Returns
        -------
        Keypoints
            Gaps at the beginning and the end stay: positions are not extrapolated.

        Raises
        ------
        ValueError
            If `longest` is negative or `confidence` out of range.

        Examples
        --------
        >>> import numpy as np
        >>> from skpose.keypoints import Keypoints
        >>> x = [0.0, np.nan, np.nan, 0.3, np.nan]
        >>> seen = Keypoints([[[x_i, 1.0, 0.0]] for x_i in x], ["hand"], frame_rate=30)
        >>> seen.fill_gaps().positions[:, 0, 0]
        array([0. , 0.1, 0.2, 0.3, nan])
        """
        longest = np.inf if longest is None else longest
        if not longest >= 0.0:
            raise ValueError(f"longest must be zero or more, got {longest!r}")
        if not 0.0 < confidence <= 1.0:
            raise ValueError(f"confidence must be above 0 and at most 1, got {confidence!r}")
        frames, seen = np.arange(len(self))[:, None], self.confidences > 0.0
        before = np.maximum.accumulate(np.where(seen, frames, -1), axis=0)
        after = np.minimum.accumulate(np.where(seen, frames, len(self))[::-1], axis=0)[::-1]
        is_short = (after - before - 1) / self.frame_rate <= longest * (1.0 + 1e-9)
        inside = ~seen & (before >= 0) & (after < len(self)) & is_short
        positions = np.where(inside[:, :, None], without_gaps(self.positions, seen), self.positions)
        return replace(self, positions=positions, confidences=np.where(inside, confidence, self.confidences))

    def play(self, layout: Any = None) -> Page:
        """Make a page that plays the points: ``skpose.view.player(keypoints)``.

        Points that are not seen are not drawn. The player has options, and shows several recordings side by side.

        Parameters
        ----------
        layout : Layout or str, default=None
            The layout, or the name of one, whose bones are drawn between the points, see `skpose.view.player`. None is
            the one of `skpose.keypoints.layouts` whose points are all present by name; without one, points are drawn
            without bones.

        Returns
        -------
        skpose.view.Page
            In a notebook it shows itself; elsewhere ``keypoints.play().open()`` shows it in the browser, and
            ``keypoints.play().save("view.html")`` writes it.

        Raises
        ------
        ValueError
            If no point is seen in any frame, or the layout has a point that the keypoints lack.

        See Also
        --------
        skpose.view.player : The page, with its options.

        Examples
        --------
        >>> import numpy as np
        >>> from skpose.keypoints import Keypoints
        >>> height = np.linspace(1.0, 1.5, 30)
        >>> seen = Keypoints(np.stack([0 * height, height, 0 * height], axis=1)[:, None], ["hand"], frame_rate=30)
        >>> seen.play().note
        '1 recording of points, positions within 0.0074 mm'
        """
        return upper_layers.player(self, layout=layout)

    def to_pandas(self) -> DataFrame:
        """Convert the positions to a pandas DataFrame, three columns for each point and one row for each frame.

        `skpose.io.load_keypoints` reads a table written by ``to_csv`` with ``frame_rate=``, and ``up=`` if that is not
        y: the file states neither. `skpose.io.save_csv` writes them too.

        Returns
        -------
        pandas.DataFrame of shape (n_frames, 3 * n_points) or (n_frames, 4 * n_points)
            Positions, m, in the columns ``NAME_x``, ``NAME_y``, ``NAME_z`` of each point, NaN if it is not seen; the
            index is the time of each frame, s. If any confidence is between 0 and 1, a column ``NAME_confidence``
            follows for each point. ``table.attrs`` states `unit`, `frame_rate` and `up`.

        Raises
        ------
        ImportError
            If pandas is not installed.

        Examples
        --------
        >>> import numpy as np
        >>> from skpose.keypoints import Keypoints
        >>> seen = Keypoints([[[0.1, 1.0, 0.0]], [[np.nan, np.nan, np.nan]]], ["hand"], frame_rate=30)
        >>> table = seen.to_pandas()
        >>> list(table.columns), table["hand_x"].tolist()
        (['hand_x', 'hand_y', 'hand_z'], [0.1, nan])
        """
        import pandas

        columns, values = columns_of(self)
        table = pandas.DataFrame(values, pandas.Index(self.times, name="time"), columns, copy=True)
        table.attrs.update(unit="m", frame_rate=self.frame_rate, up=self.up)
        return table


def columns_of(points: Keypoints) -> tuple[list[str], np.ndarray]:
    """The names and numbers (n_frames, n_columns) of a table, with confidences if any is between 0 and 1."""
    values, parts = points.positions, ["x", "y", "z"]
    if ((points.confidences > 0.0) & (points.confidences < 1.0)).any():
        values = np.concatenate([values, points.confidences[..., None]], axis=2)
        parts = [*parts, "confidence"]
    columns = [f"{name}_{part}" for name in points.names for part in parts]
    return columns, values.reshape(len(points), len(columns))


def without_gaps(positions: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Positions, linear over time in gaps, constant before the first and after the last frame in which a point is seen.

    Points that are never seen are zero.
    """
    filled, frames = np.zeros(positions.shape), np.arange(len(positions))
    for point in np.flatnonzero(seen.any(axis=0)):
        at = np.flatnonzero(seen[:, point])
        for axis in range(3):
            filled[:, point, axis] = np.interp(frames, at, positions[at, point, axis])
    return filled
