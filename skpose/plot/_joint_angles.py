"""Display of joint angles over the cycle of a movement."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from skpose._utils.validation import check_integer, check_kind
from skpose.biomechanics import GaitEvents, JointAngles
from skpose.motions import Repetitions
from skpose.plot._axes import SIDES as COLOURS
from skpose.plot._axes import axes

WIDTH, HEIGHT, LINE = 2.4, 1.9, 0.2  # inches: of one angle, and the height of a line of text above all
LINES: dict[str, Any] = {"left": "solid", "right": (0, (4, 1.5)), "": "solid"}
LEGEND: dict[str, Any] = {"frameon": False, "fontsize": "small", "borderaxespad": 0.0}
NOTE: dict[str, Any] = {"fontsize": "small", "color": "0.4"}
NAMES = ("hip_flexion", "knee_flexion", "ankle_dorsiflexion")
PERCENT = np.arange(101.0)  # of the cycle, at which curves are known
LONGEST_GAP = 0.1  # s without frames across which curves are interpolated
SIDES = ("left", "right", "")  # of angles; angles of the trunk have none


class Cycles(NamedTuple):
    """First and last times of the cycles of a movement, and the word for one."""

    spans: dict[str, np.ndarray]  # for each side, "" is the middle: (n_cycles, 2) first and last time, s
    noun: str
    of_middle: str  # the side whose cycles the trunk has; "" if all are the same


class JointAnglesDisplay:
    """Angles of joints over the cycle of a movement: the mean of all cycles, and their standard deviation as a band.

    One small axes for each angle, with both sides: the left is blue, the right dashed and vermilion, and angles of the
    trunk are grey. The line is thin where some cycles lack the angle, and has gaps where all do or frames are
    missing. Without cycles the angles are drawn over time.

    Parameters
    ----------
    angles : JointAngles
        The angles.
    cycles : GaitEvents, Repetitions, array-like of shape (n_cycles, 2) or None
        Where the cycles are, see `from_angles`.

    Attributes
    ----------
    ax_ : matplotlib Axes
        The axes that the display replaces.
    axes_ : dict of str to matplotlib Axes
        The axes of each angle, by its name without the side.
    figure_ : matplotlib Figure

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Motion
    >>> from skpose.biomechanics import joint_angles
    >>> from skpose.datasets import humanoid
    >>> from skpose.plot import JointAnglesDisplay
    >>> poses = np.zeros((120, 42))
    >>> poses[:, humanoid().dof_names.index("left_shank_rx")] = np.sin(np.linspace(0, 6 * np.pi, 120)) ** 2
    >>> angles = joint_angles(Motion(humanoid(), poses, frame_rate=30))
    >>> display = JointAnglesDisplay.from_angles(angles, [(0, 20), (20, 40), (40, 60)], names=["knee_flexion"])
    >>> display.axes_["knee_flexion"].get_xlabel()
    'cycle (%)'
    """

    def __init__(self, angles: JointAngles, cycles: Any):
        self.angles, self.cycles = angles, cycles

    def plot(
        self, ax=None, *, names: Sequence[str] | None = None, n_columns: int = 3, show_cycles: bool = False, **style
    ) -> "JointAnglesDisplay":
        """Draw the display.

        Parameters
        ----------
        ax : matplotlib Axes, default=None
            The axes to draw into, one of ``plt.subplots``; None makes new ones.
        names : sequence of str, default=None
            The angles: a name without its side is both sides, "knee_flexion_left" one. None is "hip_flexion",
            "knee_flexion" and "ankle_dorsiflexion", as far as the skeleton has them.
        n_columns : int, default=3
            Axes side by side. 1 fits into a narrow column.
        show_cycles : bool, default=False
            Draw each cycle as a thin line instead of the band.
        **style
            Style of the lines, such as linewidth; see `matplotlib.axes.Axes.plot`.

        Returns
        -------
        JointAnglesDisplay
            The display itself.
        """
        check_integer(n_columns, 1, "n_columns")
        columns = _find_columns(self.angles, names)
        cycles = None if self.cycles is None else _find_cycles(self.angles, self.cycles)
        n_columns = min(n_columns, len(columns))
        n_rows = -(-len(columns) // n_columns)
        handles = _legend(columns, cycles, show_cycles)
        per_line = n_columns if n_columns < 3 else len(handles)
        legend = LINE * (1 - -len(handles) // per_line)
        size = (WIDTH * n_columns + 0.4, HEIGHT * n_rows + legend)
        self.ax_, self.figure_ = axes(ax, size)
        where = self.ax_.get_subplotspec()
        if where is None:
            raise ValueError("ax must be in a grid, made by plt.subplots() or figure.add_subplot()")
        grid = where.subgridspec(1 + n_rows, n_columns, height_ratios=[legend] + [HEIGHT] * n_rows)
        self.ax_.set_axis_off()
        self.axes_ = {}
        for number, (name, sides) in enumerate(columns.items()):
            row, column = divmod(number, n_columns)
            inner = self.figure_.add_subplot(grid[1 + row, column])
            self.axes_[name] = inner
            self._draw(inner, sides, cycles, show_cycles, style)
            inner.set_title(name.replace("_", " "), fontsize="medium", loc="left")
            inner.tick_params(labelbottom=number + n_columns >= len(columns), labelsize="small")
            if row == n_rows - 1:
                inner.set_xlabel(f"{cycles.noun} (%)" if cycles else "time (s)")
            if column == 0:
                inner.set_ylabel("degrees")
        above = self.figure_.add_subplot(grid[0, :])
        above.set_axis_off()
        above.legend(handles=handles, loc="center left", ncols=per_line, **LEGEND).set_in_layout(False)
        return self

    def _draw(self, ax, sides, cycles, show_cycles, style) -> None:
        """Draw one angle, given by its columns for each side."""
        ax.axhline(0.0, color="0.6", linewidth=0.6, zorder=0.5)
        ax.spines[["top", "right"]].set_visible(False)
        shown = {side: self._draw_side(ax, side, name, cycles, show_cycles, style) for side, name in sides.items()}
        if not any(shown.values()):
            ax.text(0.5, 0.5, "no data", transform=ax.transAxes, ha="center", va="center", **NOTE)
        elif without := [side for side in sides if not shown[side] and (cycles is None or len(cycles.spans[side]))]:
            words = f"no data of the {without[0]}"
            ax.text(0.5, 0.98, words, transform=ax.transAxes, ha="center", va="top", **NOTE)
        low, high = ax.get_ylim()
        if high - low < 10.0:  # degrees, so that noise does not look like movement
            middle = (low + high) / 2.0
            ax.set_ylim(middle - 5.0, middle + 5.0)
        first, last = (0.0, 100.0) if cycles else self.angles.times[[0, -1]]
        ax.set_xlim(first, last)
        if cycles:
            ax.set_xticks([0, 25, 50, 75, 100])
        ax.locator_params(axis="y", nbins=5, steps=[1, 2, 3, 5, 10])

    def _draw_side(self, ax, side, name, cycles, show_cycles, style) -> bool:
        """Draw one column; return whether it has any value."""
        line = {"color": COLOURS[side], "linestyle": LINES[side], "linewidth": 1.6} | style
        if cycles is None:
            values = _without_jumps(self.angles[name])
            ax.plot(*_with_gaps(self.angles.times, values), **line)
        else:
            values = _cycle_curves(self.angles.times, self.angles[name], cycles.spans[side])
            _draw_cycles(ax, values, show_cycles, line)
        return bool(np.isfinite(values).any())

    @classmethod
    def from_angles(cls, angles: JointAngles, cycles: Any = None, *, ax=None, **options) -> "JointAnglesDisplay":
        """Draw angles over the cycles of a movement, or over time.

        Parameters
        ----------
        angles : JointAngles
            The angles, from `skpose.biomechanics.joint_angles`.
        cycles : GaitEvents, Repetitions or array-like of shape (n_cycles, 2), default=None
            Where the cycles are, from 0 to 100 %:

            - `GaitEvents`: strides of each foot, from contact to contact. Angles of the trunk use the foot with more
              strides, as the legend says.
            - `Repetitions`: the same cycles for both sides.
            - array of int: start and stop of each cycle, as in ``motion[start:stop]``.
            - None: no cycles, but curves over time, s.
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        **options
            Which angles, how and in which style, see `plot`.

        Returns
        -------
        JointAnglesDisplay
            The display.

        Raises
        ------
        TypeError
            If `angles` is not a `JointAngles`.
        ValueError
            For unknown names, without cycles, and for cycles of a recording with frames at other times.

        Notes
        -----
        Each cycle is interpolated linearly at 101 points in time, except across NaN and gaps of more than 0.1 s. Jumps
        of 360° are removed, and cycles that differ by whole turns are shifted onto each other. The band is the standard
        deviation with n − 1; a single cycle has none.
        """
        check_kind(angles, JointAngles, "angles", "skpose.biomechanics.joint_angles(motion) finds them")
        return cls(angles, cycles).plot(ax, **options)


def _find_columns(angles: JointAngles, names: Sequence[str] | None) -> dict[str, dict[str, str]]:
    """The columns of each name by side; "" is the middle."""
    known: dict[str, dict[str, str]] = {}
    for column in angles.names:
        stem, _, side = column.rpartition("_")
        if side in ("left", "right"):
            known.setdefault(stem, {})[side] = column
            known[column] = {side: column}
        else:
            known[column] = {"": column}
    if names is None:
        names = [name for name in NAMES if name in known]
    if not len(names) or not known.keys() >= set(names):
        raise ValueError(f"names must be a list of {', '.join(known)}, got {names!r}")
    return {name: known[name] for name in names}


def _find_cycles(angles: JointAngles, cycles: Any) -> Cycles:
    """The cycles of each side."""
    if isinstance(cycles, GaitEvents):
        return _strides(angles, cycles)
    noun = "cycle"
    if isinstance(cycles, Repetitions):
        if cycles.times is not None:
            _check_times(cycles.times, angles)
        cycles, noun = np.stack([cycles.starts, cycles.stops], axis=1), "repetition"
    frames = np.asarray(cycles)
    if frames.shape[1:] != (2,) or not np.issubdtype(frames.dtype, np.integer):
        raise ValueError("cycles must be GaitEvents, Repetitions, or whole numbers of shape (n_cycles, 2)")
    if not len(frames) or frames.min() < 0 or frames.max() > len(angles) or (np.diff(frames) < 2).any():
        raise ValueError(f"cycles must be parts of at least two of the {len(angles)} frames of angles")
    return Cycles(dict.fromkeys(SIDES, angles.times[frames - [0, 1]]), noun, "")


def _strides(angles: JointAngles, events: GaitEvents) -> Cycles:
    """The strides of each foot, from its contact to its next."""
    if not len(events.strides):
        raise ValueError(f"cycles has no strides: {events.reason}")
    _check_times(events.motion_times, angles)
    feet = events.feet[events.strides[:, 0]]
    times = events.times[events.strides[:, [0, 2]]]
    spans = {side: times[feet == side] for side in SIDES[:2]}
    of_middle = max(spans, key=lambda side: len(spans[side]))  # the left, of equal ones
    return Cycles(spans | {"": spans[of_middle]}, "stride", of_middle)


def _check_times(times: np.ndarray, angles: JointAngles) -> None:
    if len(times) != len(angles) or not np.allclose(times, angles.times, rtol=0.0, atol=1e-6):
        raise ValueError("cycles must be of the recording that angles are of, got another one")


def _without_jumps(degrees: np.ndarray) -> np.ndarray:
    """An angle over time without jumps of 360°, such as from 180 to -180."""
    found = degrees.astype(np.float64)
    known = np.isfinite(found)
    found[known] = np.unwrap(found[known], period=360.0)
    return found


def _with_gaps(times: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A curve over time with a NaN where frames are missing."""
    usual = np.median(np.diff(times)) if len(times) > 1 else 0.0
    after = np.flatnonzero(np.diff(times) > max(LONGEST_GAP, 1.5 * usual)) + 1
    return np.insert(times, after, (times[after - 1] + times[after]) / 2.0), np.insert(values, after, np.nan)


def _cycle_curves(times: np.ndarray, degrees: np.ndarray, spans: np.ndarray) -> np.ndarray:
    """An angle at `PERCENT` of each cycle (n_cycles, 101), without whole turns; NaN next to frames that lack it."""
    at = spans[:, :1] + (spans[:, 1:] - spans[:, :1]) * PERCENT / 100.0
    curves = np.ma.masked_invalid(np.interp(at, *_with_gaps(times, _without_jumps(degrees))))
    centre = np.degrees(np.angle(np.exp(1j * np.radians(curves.compressed())).sum()))
    turns = np.rint((curves.mean(axis=1, keepdims=True) - centre) / 360.0)
    return (curves - 360.0 * turns).filled(np.nan)


def _draw_cycles(ax, curves: np.ndarray, show_cycles: bool, line: dict) -> None:
    """Draw the mean of cycles and the band of their standard deviation, or each cycle as a thin line."""
    known = np.ma.masked_invalid(curves)
    mean = known.mean(axis=0).filled(np.nan)
    if show_cycles:
        ax.plot(PERCENT, curves.T, **line | {"linewidth": 0.5, "linestyle": "solid", "alpha": 0.6})
    else:
        std = known.std(axis=0, ddof=1).filled(np.nan)
        ax.fill_between(PERCENT, mean - std, mean + std, color=line["color"], alpha=0.18, linewidth=0.0)
    is_complete = known.count(axis=0) == len(curves)
    if not is_complete.all():
        ax.plot(PERCENT, mean, **line | {"linewidth": 0.6})
    ax.plot(PERCENT, np.where(is_complete, mean, np.nan), **line)


def _legend(columns: dict[str, dict[str, str]], cycles: Cycles | None, show_cycles: bool) -> list:
    """Handles of the legend: lines of both sides, with the number of cycles, and the band."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list = []
    for side in (one for one in SIDES if any(one in sides for sides in columns.values())):
        label = side or "middle"
        if cycles:
            n = len(cycles.spans[side])
            of = f" of the {cycles.of_middle}" if not side and cycles.of_middle else ""
            label += f", {n or 'no'} {cycles.noun}{'s' * (n != 1)}{of}"
        handles.append(Line2D([], [], color=COLOURS[side], linestyle=LINES[side], linewidth=1.6, label=label))
    if cycles and not show_cycles and max(map(len, cycles.spans.values())) > 1:
        handles.append(Patch(color="0.5", alpha=0.3, linewidth=0.0, label="± standard deviation"))
    return handles
