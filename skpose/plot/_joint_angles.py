"""Display of joint angles over the cycle of a movement."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from skpose._utils.validation import check_integer, check_kind
from skpose.biomechanics import JointAngles
from skpose.biomechanics._joint_angles import Cycles, find_cycles, split_name
from skpose.motions._phases import PHASES, with_gaps, without_jumps
from skpose.plot._axes import SIDES as COLOURS, axes

WIDTH, HEIGHT, LINE = 2.4, 1.9, 0.2  # inches: of one angle, and the height of a line of text above all
LINES: dict[str, Any] = {"left": "solid", "right": (0, (4, 1.5)), "": "solid"}
LEGEND: dict[str, Any] = {"frameon": False, "fontsize": "small", "borderaxespad": 0.0}
NOTE: dict[str, Any] = {"fontsize": "small", "color": "0.4"}
NAMES = ("hip_flexion", "knee_flexion", "ankle_dorsiflexion")
SIDES = ("left", "right", "")  # of angles; angles of the trunk have none
NORM: dict[str, Any] = {"color": "#d9b84a", "alpha": 0.35, "linewidth": 0.0, "zorder": 0.2}


class JointAnglesDisplay:
    """Angles of joints over the cycle of a movement: the mean of all cycles, and their standard deviation as a band.

    One small axes for each angle, with both sides: the left is blue, the right dashed and vermilion, and angles of the
    trunk are grey. The line is thin where some cycles lack the angle, and has gaps where all do or frames are
    missing. Without cycles the angles are drawn over time.

    Parameters
    ----------
    angles : JointAngles or pandas.DataFrame
        The angles, or their cycles.
    cycles : GaitEvents, Repetitions, array-like of shape (n_cycles, 2) or None
        Where the cycles are, see `from_angles`.
    norm : pandas.DataFrame or None
        Mean and standard deviation of other people.

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

    def __init__(self, angles: Any, cycles: Any = None, norm: Any = None):
        self.angles, self.cycles, self.norm = angles, cycles, norm

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
        is_over_time = self.cycles is None and isinstance(self.angles, JointAngles)
        if is_over_time and self.norm is not None:
            raise ValueError("norm needs cycles, got None")
        cycles = None if is_over_time else _find_curves(self.angles, self.cycles)
        columns = _find_columns(cycles.curves if cycles else self.angles.names, names)
        n_columns = min(n_columns, len(columns))
        n_rows = -(-len(columns) // n_columns)
        handles = _legend(columns, cycles, show_cycles, self.norm is not None)
        per_line = n_columns if n_columns < 3 else 4
        legend = LINE * (1 - -len(handles) // per_line)
        self.ax_, self.figure_ = axes(ax, (WIDTH * n_columns + 0.4, HEIGHT * n_rows + legend))
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
            if self.norm is not None:
                norm = self.norm[self.norm["angle"] == split_name(name)[0]].sort_values("phase [%]")
                inner.fill_between(norm["phase [%]"], norm["mean"] - norm["std"], norm["mean"] + norm["std"], **NORM)
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
        elif without := [
            side for side in sides if not shown[side] and (cycles is None or len(cycles.curves[sides[side]]))
        ]:
            words = f"no data of the {without[0]}"
            ax.text(0.5, 0.98, words, transform=ax.transAxes, ha="center", va="top", **NOTE)
        low, high = ax.get_ylim()
        if high - low < 10.0:  # degrees, so that noise does not look like movement
            middle = (low + high) / 2.0
            ax.set_ylim(middle - 5.0, middle + 5.0)
        ax.set_xlim(*((0.0, 100.0) if cycles else self.angles.times[[0, -1]]))
        if cycles:
            ax.set_xticks([0, 25, 50, 75, 100])
        ax.locator_params(axis="y", nbins=5, steps=[1, 2, 3, 5, 10])

    def _draw_side(self, ax, side, name, cycles, show_cycles, style) -> bool:
        """Draw one column; return whether it has any value."""
        line = {"color": COLOURS[side], "linestyle": LINES[side], "linewidth": 1.6} | style
        if cycles is None:
            values = without_jumps(self.angles[name])
            ax.plot(*with_gaps(self.angles.times, values), **line)
        else:
            values = cycles.curves[name]
            _draw_cycles(ax, values, show_cycles, line)
        return bool(np.isfinite(values).any())

    @classmethod
    def from_angles(
        cls, angles: Any, cycles: Any = None, *, norm: Any = None, ax=None, **options
    ) -> "JointAnglesDisplay":
        """Draw angles over the cycles of a movement, or over time.

        Parameters
        ----------
        angles : JointAngles or pandas.DataFrame
            The angles, from `skpose.biomechanics.joint_angles`; or cycles of one or more recordings, from
            `JointAngles.cycles` or from `joint_angles` of a list.
        cycles : GaitEvents, Repetitions or array-like of shape (n_cycles, 2), default=None
            Where the cycles are, see `JointAngles.cycles`. None draws curves over time.
        norm : pandas.DataFrame, default=None
            Mean and standard deviation of other people, degrees, drawn as a yellow band: columns "angle", such as
            "knee_flexion", for both sides, "phase [%]", "mean" and "std".
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
            If `angles` is neither a `JointAngles` nor a table.
        ValueError
            For unknown names, without cycles, and for cycles of a recording with frames at other times.

        Notes
        -----
        The band is the standard deviation with n − 1; a single cycle has none.
        """
        if cycles is not None or not hasattr(angles, "pivot"):
            check_kind(angles, JointAngles, "angles", "skpose.biomechanics.joint_angles(motion) finds them")
        return cls(angles, cycles, norm).plot(ax, **options)


def _find_curves(angles: Any, cycles: Any) -> Cycles:
    """The curves of all cycles, also of those in a table."""
    if isinstance(angles, JointAngles):
        return find_cycles(angles, cycles)
    curves, at, value = {}, "phase [%]", "value [deg]"
    for (stem, side), rows in angles.groupby(["angle", "side"], sort=False):
        table = rows.pivot(index=[name for name in rows if name not in (at, value)], columns=at, values=value)
        curves[stem if side == "middle" else f"{stem}_{side}"] = table.to_numpy()
    return Cycles({}, curves, "cycle", "")


def _find_columns(angles: Iterable[str], names: Sequence[str] | None) -> dict[str, dict[str, str]]:
    """The columns of each name by side; "" is the middle."""
    known: dict[str, dict[str, str]] = {}
    for column in angles:
        stem, side = split_name(column)
        known.setdefault(stem, {})[side] = column
        known[column] = known.get(column, {side: column})
    if names is None:
        names = [name for name in NAMES if name in known]
    if not len(names) or not known.keys() >= set(names):
        raise ValueError(f"names must be a list of {', '.join(known)}, got {names!r}")
    return {name: known[name] for name in names}


def _draw_cycles(ax, curves: np.ndarray, show_cycles: bool, line: dict) -> None:
    """Draw the mean of cycles and the band of their standard deviation, or each cycle as a thin line."""
    known = np.ma.masked_invalid(curves)
    mean = known.mean(axis=0).filled(np.nan)
    if show_cycles:
        ax.plot(PHASES, curves.T, **line | {"linewidth": 0.5, "linestyle": "solid", "alpha": 0.6})
    else:
        std = known.std(axis=0, ddof=1).filled(np.nan)
        ax.fill_between(PHASES, mean - std, mean + std, color=line["color"], alpha=0.18, linewidth=0.0)
    is_complete = known.count(axis=0) == len(curves)
    if not is_complete.all():
        ax.plot(PHASES, mean, **line | {"linewidth": 0.6})
    ax.plot(PHASES, np.where(is_complete, mean, np.nan), **line)


def _legend(columns: dict[str, dict[str, str]], cycles: Cycles | None, show_cycles: bool, has_norm: bool) -> list:
    """Handles of the legend: lines of both sides, with the number of cycles, and the bands."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list = []
    shown = {side: name for sides in columns.values() for side, name in sides.items()}
    for side in (one for one in SIDES if one in shown):
        label = side or "middle"
        if cycles:
            n = len(cycles.curves[shown[side]])
            of = f" of the {cycles.of_middle}" if not side and cycles.of_middle else ""
            label += f", {n or 'no'} {cycles.noun}{'s' * (n != 1)}{of}"
        handles.append(Line2D([], [], color=COLOURS[side], linestyle=LINES[side], linewidth=1.6, label=label))
    if cycles and not show_cycles and max(map(len, cycles.curves.values())) > 1:
        handles.append(Patch(color="0.5", alpha=0.3, linewidth=0.0, label="± standard deviation"))
    if has_norm:
        handles.append(Patch(**NORM, label="norm ± standard deviation"))
    return handles
