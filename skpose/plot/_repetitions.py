"""Display of one repetition of a movement: where its joints are, and where the other repetitions have them."""

from typing import Any

import numpy as np

from skpose._validation.options import check_integer, check_kind
from skpose.motions import Repetitions
from skpose.plot._axes import axes
from skpose.plot._pose import GAP, check_projection, draw_pose
from skpose.plot._views import find_vertical, name_view
from skpose.plot._volume import shape_of_person
from skpose.skeleton import Motion

HEIGHT, REST, LEAST, MOST = 2.3, (1.9, 1.3), 5.6, 10.0  # inches: of poses, what is around them, widths of the figure
COLOURS = ("#7fb0d6", "#a994a6", "#c2644f", "#8c1313")  # calm to dark: their lightness falls, for print
RING: dict[str, Any] = {
    "marker": "o",
    "markersize": 11,
    "markerfacecolor": "none",
    "markeredgecolor": "black",
    "zorder": 4,
}
USUAL: dict[str, Any] = {"color": "0.82", "linewidth": 4.0, "markersize": 0, "zorder": 1}


class RepetitionsDisplay:
    """One repetition over the typical one: poses side by side, with the deviation of each joint in colour.

    The typical one, in grey, is the median of the other repetitions at the same phase, as in `Repetitions.to_pandas`.
    Bones have the colour of the joint at their end. The colours of all repetitions have one scale, up to the largest
    deviation of any. A ring marks the most unusual joint.

    Parameters
    ----------
    repetitions : Repetitions
        The repetitions.
    n_phases : int, default=20
        Phases into which the movement is divided, at most 200.

    Attributes
    ----------
    ax_ : matplotlib Axes
    figure_ : matplotlib Figure
    repetition_ : int
        The repetition that is shown.
    joint_ : str
        Its most unusual joint.
    phase_ : float
        The phase at which it is, from 0 to 100 %.
    deviation_ : float
        How far it is there from where the others have it, m.
    projection_ : str
        The horizontal and the vertical axis.

    Examples
    --------
    The strides of a generated walk, of which the third (2) has a bent left elbow for a while:

    >>> from dataclasses import replace
    >>> from skpose.datasets import make_gait
    >>> from skpose.motions import segment_repetitions
    >>> from skpose.plot import RepetitionsDisplay
    >>> walk = make_gait(1, 1, activities=["walk"], duration=6, random_state=0)[0]
    >>> angles = walk.angles.copy()
    >>> angles[180:200, walk.skeleton.dof_names.index("left_forearm_rx")] -= 0.6
    >>> strides = segment_repetitions(replace(walk, angles=angles), random_state=0)
    >>> display = RepetitionsDisplay.from_repetitions(strides)
    >>> display.repetition_, display.joint_, display.projection_
    (2, 'left_hand', 'zy')
    """

    def __init__(self, repetitions: Repetitions, n_phases: int = 20):
        self.repetitions, self.n_phases = repetitions, n_phases
        self._skeleton, self._found, self._times = repetitions._compare("RepetitionsDisplay", n_phases)
        self._has_spread = bool(np.isfinite(self._found.spread).any())
        unusual = self._found.ratios if self._has_spread else self._found.distances
        self._unusual = np.nan_to_num(unusual, nan=-1.0)  # where a repetition lacks the phase, or too many others do

    def plot(
        self,
        ax=None,
        *,
        repetition: int | None = None,
        n_poses: int = 6,
        projection: str | None = None,
        cmap: Any = None,
        vmax: float | None = None,
        **style,
    ) -> "RepetitionsDisplay":
        """Draw the display.

        Parameters
        ----------
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        repetition : int, default=None
            The repetition, its index in ``repetitions.motions``; None is the one with the most unusual joint, with
            fewer than four repetitions that with the largest deviation.
        n_poses : int, default=6
            Phases to draw, fewer where there are fewer. That of the most unusual joint is among them.
        projection : str, default=None
            The horizontal and the vertical axis, see `PoseDisplay.plot`. None has the axis upright that is
            nearest to the vertical of the world, y for arrays, and shows the deviations at the most unusual phase from
            the side from which they are larger.
        cmap : str or matplotlib Colormap, default=None
            Colours of deviations; None is from blue to dark red.
        vmax : float, default=None
            The deviation of the last colour, cm; None is the largest of all repetitions.
        **style
            Style of the bones, such as linewidths; see `matplotlib.collections.LineCollection`.

        Returns
        -------
        RepetitionsDisplay
            The display itself.
        """
        check_integer(n_poses, 1, "n_poses")
        found, k = self._found, self._choose(repetition)
        worst, joint = np.unravel_index(self._unusual[k].argmax(), self._unusual[k].shape)
        self.repetition_, self.joint_ = k, self._skeleton.joint_names[joint]
        self.phase_, self.deviation_ = 100.0 * float(found.phases[worst]), float(found.distances[k, worst, joint])
        self.projection_ = self._find_projection(found.vectors[k, worst]) if projection is None else projection
        plane = check_projection(self.projection_)
        known = np.flatnonzero(np.isfinite(found.distances[k]).all(axis=1))
        phases = known[_spread(len(known), n_poses, int(np.searchsorted(known, worst)))]
        own = found.positions[k, phases][:, :, plane]
        means = (found.positions - found.vectors)[k, phases]
        usual, shape = means[:, :, plane], shape_of_person(self._skeleton)
        both = np.concatenate([own, usual], axis=1)
        low, high = (edge(both[..., 0], axis=1, initial=0.0) for edge in (np.min, np.max))
        step = (1.0 + GAP) * max((high - low).max(), 0.25 * np.ptp(both[..., 1])) or 1.0  # bones seen end on
        centres = np.arange(len(phases)) * step
        width = HEIGHT * len(phases) * step / (np.ptp(both[..., 1]) or step) + REST[0]
        size = (min(max(width, LEAST), MOST), HEIGHT + REST[1])
        self.ax_, self.figure_ = axes(ax, "RepetitionsDisplay.plot", size)
        shifts = np.stack([centres - (low + high) / 2.0, np.zeros(len(phases))], axis=1)
        for pose, shift in zip(means, shifts, strict=True):
            draw_pose(self.ax_, pose, plane, self._skeleton, shape, shift[0], USUAL)
        self._draw_bones(own, shifts, 100.0 * found.distances[k, phases], cmap, vmax, style)
        drawn = int(np.flatnonzero(phases == worst)[0])
        self.ax_.plot(*(own[drawn, joint] + shifts[drawn]), **RING)
        self._label(centres, phases, int(worst), int(joint), plane)
        self.ax_.margins(x=0.02)
        if ax is None:  # the layout first: while it finds room for labels, equal axes would grow in both directions
            self.figure_.draw_without_rendering()
        self.ax_.set_aspect("equal", adjustable="datalim")
        return self

    def _draw_bones(self, poses, shifts, values, cmap, vmax, style) -> None:
        """Draw bones and joints of poses (n_poses, n_joints, 2) in the colours of values, cm, with a colour bar."""
        from matplotlib.collections import LineCollection
        from matplotlib.colors import LinearSegmentedColormap, Normalize

        largest = 100.0 * np.nanmax(self._found.distances) if vmax is None else vmax
        colours = LinearSegmentedColormap.from_list("deviation", COLOURS) if cmap is None else cmap
        scale: dict[str, Any] = {"cmap": colours, "norm": Normalize(0.0, largest or 1.0)}
        parents = np.concatenate([poses, np.zeros((len(poses), 1, 2))], axis=1)[
            :, self._skeleton.parents
        ]  # -1: the root
        bones = (np.stack([parents, poses], axis=2) + shifts[:, None, None]).reshape(-1, 2, 2)
        defaults: dict[str, Any] = {"linewidths": 2.2, "capstyle": "round", "zorder": 2.5}
        lines = LineCollection(list(bones), array=values.ravel(), **scale, **defaults | style)
        self.ax_.add_collection(lines)
        self.ax_.scatter(*bones[:, 1].T, c=values.ravel(), s=9.0, zorder=3, **scale)
        self.figure_.colorbar(lines, ax=self.ax_, label="deviation (cm)", pad=0.02, aspect=25)

    def _choose(self, repetition: int | None) -> int:
        """Return the repetition to show."""
        n = len(self.repetitions)
        if repetition is None:
            return int(self._unusual.max(axis=(1, 2)).argmax())
        check_integer(repetition, -n, "repetition")
        if repetition >= n:
            raise ValueError(f"repetition must be one of the {n} that there are, 0 to {n - 1}, got {repetition}")
        return int(repetition) % n

    def _find_projection(self, vectors: np.ndarray) -> str:
        """Return the axes of a view in which the vertical is upright, and deviations (n_joints, 3) are large."""
        up = find_vertical([one for one in self.repetitions.motions if isinstance(one, Motion)])
        squares = (vectors**2).sum(axis=0)
        squares[up] = -1.0
        return "xyz"[int(squares.argmax())] + "xyz"[up]

    def _label(self, centres, phases, worst, joint, plane) -> None:
        """Write phases and times below the poses, and above what is most unusual."""
        k, times = self.repetition_, self._times[self.repetition_]
        shares = [f"{100.0 * share:.3g} %" for share in self._found.phases]
        seconds = [f"{time:.2f} s" if np.isfinite(time) else "" for time in times]
        labels = [f"{shares[phase]}\n{seconds[phase]}".strip() for phase in phases]
        self.ax_.set_xticks(centres, labels, fontsize="small")
        self.ax_.tick_params(axis="y", labelsize="small")
        self.ax_.spines[["top", "right"]].set_visible(False)
        self.ax_.set(xlabel="phase of the movement", ylabel=f"{self.projection_[1]} (m)")
        off = f"{self.joint_} {100.0 * self.deviation_:.1f} cm off"
        ratio = f", {self._unusual[k, worst, joint]:.1f} times the usual" if self._has_spread else ""
        at = f"at {shares[worst]} of the movement" + (f", {seconds[worst]}" if seconds[worst] else "")
        seen = self._found.positions[k]
        view = name_view(seen[np.isfinite(seen).all(axis=(1, 2))], self._skeleton.joint_names, plane)
        title = f"repetition {k} of 0 to {len(self.repetitions) - 1}: {off}{ratio},\n{at}{view}"
        self.ax_.set_title(title, fontsize="medium", loc="left")

    @classmethod
    def from_repetitions(
        cls,
        repetitions: Repetitions,
        *,
        repetition: int | None = None,
        n_phases: int = 20,
        n_poses: int = 6,
        ax=None,
        projection: str | None = None,
        cmap: Any = None,
        vmax: float | None = None,
        **style,
    ) -> "RepetitionsDisplay":
        """Draw one repetition over the typical one.

        Parameters
        ----------
        repetitions : Repetitions
            The repetitions, from `skpose.motions.segment_repetitions`; two at least, on a skeleton.
        repetition : int, default=None
            The repetition, its index in ``repetitions.motions``; None is the one with the most unusual joint, see
            `plot`.
        n_phases : int, default=20
            Phases into which the movement is divided, at most 200, as in `Repetitions.to_pandas`.
        n_poses : int, default=6
            Phases to draw, fewer where there are fewer. That of the most unusual joint is among them.
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        projection : str, default=None
            The horizontal and the vertical axis; None is the side from which deviations are larger, see `plot`.
        cmap : str or matplotlib Colormap, default=None
            Colours of deviations; None is from blue to dark red.
        vmax : float, default=None
            The deviation of the last colour, cm; None is the largest of all repetitions.
        **style
            Style of the bones, such as linewidths; see `matplotlib.collections.LineCollection`.

        Returns
        -------
        RepetitionsDisplay
            The display.
        """
        check_kind(repetitions, Repetitions, "repetitions", "skpose.motions.segment_repetitions(motion) finds them")
        return cls(repetitions, n_phases).plot(
            ax, repetition=repetition, n_poses=n_poses, projection=projection, cmap=cmap, vmax=vmax, **style
        )


def _spread(n: int, n_chosen: int, one: int) -> np.ndarray:
    """Return some of n phases, each in the middle of an equal part; in the part of a given one it is that."""
    n_chosen = min(n, n_chosen)
    edges = np.arange(n_chosen + 1) * n // n_chosen
    chosen = (edges[:-1] + edges[1:] - 1) // 2
    chosen[np.searchsorted(edges, one, side="right") - 1] = one
    return chosen
