"""Display of poses as figures."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from sklearn.utils.validation import check_is_fitted

from skpose._utils.typing import ArrayLike
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import check_integer, check_kind, check_pose, check_poses, check_skeleton
from skpose.geodesics import GeodesicResult
from skpose.kinematics import forward_kinematics
from skpose.plot._axes import COLOURS, SIDES, axes, plain
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._sides import sides
from skpose.statistics import PoseTangentPCA
from skpose.view._scene import vertical_of
from skpose.view._shape import Shape, find_shape, outline

TINT = 0.5  # share of a side's colour in its parts, mixed with the colour of the axes
EDGE = 0.8  # points, of the edge that sets a part apart from those behind it
SHARED = ("alpha", "clip_on", "zorder", "visible")  # what of the style of the lines areas have too
GROUND: dict[str, Any] = {"color": "0.75", "linewidths": 1.0, "zorder": 0.5}


def shape_of_person(skeleton: Skeleton) -> Shape | None:
    """The shape of a person; None for other skeletons, which are drawn as lines alone."""
    shape = find_shape(skeleton)
    return shape if shape.is_person else None


def draw_volume(
    ax, positions: np.ndarray, plane: list[int], side: Sequence[str], shape: Shape, shift: float, style: Mapping
) -> None:
    """Draw the parts of one pose, (n_joints, 3) with the root at the origin, far ones first, without those with NaN."""
    from matplotlib.collections import PathCollection
    from matplotlib.colors import to_rgb, to_rgba
    from matplotlib.path import Path

    paper = np.array(to_rgb(ax.get_facecolor()))
    depth = np.cross(np.eye(3)[plane[0]], np.eye(3)[plane[1]])  # towards the viewer
    centres, radii = shape.centres(with_root(positions)), shape.radii
    flat = centres[:, plane] + [shift, 0.0]
    parts = []
    for part in shape.parts:
        hulls = [list(hull) for hull in part.hulls if np.isfinite(centres[list(hull)]).all()]
        if not hulls:
            continue
        *colour, opacity = to_rgba(style.get("color", SIDES[side[part.joint] if part.joint >= 0 else ""]))
        near = float(np.mean(centres[np.concatenate(hulls)] @ depth))
        outlines = (outline(flat[hull], radii[hull]) for hull in hulls)
        path = Path.make_compound_path(*(Path(np.vstack([one, one[:1]]), closed=True) for one in outlines))
        parts.append((near, path, (*(TINT * np.array(colour) + (1.0 - TINT) * paper), opacity)))
    parts.sort(key=lambda part: part[0])
    paths = [path for _, path, _ in parts for _ in range(2)]  # an edge, and the area that covers its inner half
    fills = [colour for *_, fill in parts for colour in ("none", fill)]
    widths = [2.0 * EDGE, 0.0] * len(parts)
    options: dict[str, Any] = {"zorder": 2} | {key: style[key] for key in SHARED if key in style}
    drawn = PathCollection(paths, facecolors=fills, edgecolors=[tuple(paper)], linewidths=widths, **options)
    ax.add_collection(drawn)


def draw_ground(ax, shape: Shape, positions: np.ndarray, axis: int) -> None:
    """Draw a line across the axes at the lowest coordinate of poses (n_poses, n_joints, 3) along an axis."""
    from matplotlib.collections import LineCollection

    height = np.nanmin(shape.centres(with_root(positions))[..., axis] - shape.radii)
    line = LineCollection([[(0.0, height), (1.0, height)]], transform=ax.get_yaxis_transform(), **GROUND)
    ax.add_collection(line, autolim=False)


def with_root(positions: np.ndarray) -> np.ndarray:
    """Positions (..., n_joints, 3) with the root, at the origin, in front of them."""
    return np.concatenate([np.zeros((*positions.shape[:-2], 1, 3)), positions], axis=-2)


# --- pose -------------------------------------------------------------------------------------------------------------


Y = 1
GAP = 0.15  # between two figures of a strip, relative to the width of the widest


def check_projection(projection: str) -> list[int]:
    """The indices of two axes, or of three, which must not show the mirror image."""
    if projection not in ("xy", "yx", "xz", "zx", "yz", "zy", "xyz", "yzx", "zxy"):
        raise ValueError(f"projection must be two of x, y, z, or 'zxy', 'xyz' or 'yzx', got {projection!r}")
    return ["xyz".index(axis) for axis in projection]


def draw_pose(
    ax, positions: np.ndarray, plane: list[int], skeleton: Skeleton, shape: Shape | None, shift: float, style: dict
) -> None:
    """Draw one pose, (n_joints, 3) with the root at the origin, shifted along the first of two or three axes.

    Each side is one line with gaps. A person's shape is head, trunk and limbs behind the lines, in two dimensions.
    """
    from matplotlib.cbook import normalize_kwargs
    from matplotlib.lines import Line2D

    style, seen = normalize_kwargs(style, Line2D), positions[:, plane]
    defaults = {"linewidth": 2, "solid_capstyle": "round", "marker": "o", "markersize": 3}
    if shape is not None:
        draw_volume(ax, positions, plane, sides(skeleton.joint_names), shape, shift, style)
        defaults |= {"linewidth": 0.8, "markersize": 1.8}
    side = np.array(sides(skeleton.joint_names) if "color" not in style else [""] * skeleton.n_joints)
    colours = {"": COLOURS[0]} if (side == "").all() else SIDES
    parent = np.concatenate([seen, np.zeros((1, seen.shape[1]))])[skeleton.parents]  # -1, the root, is the last
    segments = np.stack([parent, seen, np.full_like(seen, np.nan)], axis=1)
    segments[..., 0] += shift
    for name, colour in colours.items():
        chosen = side == name
        if chosen.any():
            ax.plot(*segments[chosen].reshape(-1, seen.shape[1]).T, **defaults | {"color": colour} | style)
            style = {key: value for key, value in style.items() if key != "label"}  # one entry in a legend


class PoseDisplay:
    """A pose as a figure, or several side by side, seen along an axis or in three dimensions.

    People have head, trunk and limbs behind the lines of their bones, and a line for the ground; other skeletons, and
    all in three dimensions, are lines alone. The left side is blue, the right vermilion, the rest grey, by the names of
    the joints; everything is blue if no name has a side.

    Parameters
    ----------
    positions : ndarray of shape (n_poses, n_joints, 3)
        Positions of the joints, m, the root at the origin.
    skeleton : Skeleton
        Their skeleton.
    labels : sequence of str, default=None
        Text below each pose; None draws a single pose in axes in metres.
    title : str, default=""
        Title of the labels, with their unit.

    Attributes
    ----------
    ax_ : matplotlib Axes
    figure_ : matplotlib Figure
    projection_ : str
        The axes of the drawing.

    Examples
    --------
    >>> from skpose import Skeleton, geodesic
    >>> from skpose.plot import PoseDisplay
    >>> arm = Skeleton.chain(3)
    >>> display = PoseDisplay.from_pose([0.4, 0.5, 0.6], arm, label="an arm")
    >>> display.ax_.get_xlabel()
    'x (m)'
    >>> path = geodesic([0.2, 0.3, 0.0], [2.4, 0.2, 0.1], arm)
    >>> display = PoseDisplay.from_geodesic(path, arm, n_poses=5)
    >>> display.ax_.get_xlabel()
    'arc length from the first pose (m)'
    """

    def __init__(self, positions: np.ndarray, skeleton: Skeleton, labels: Sequence[str] | None = None, title: str = ""):
        self.positions, self.skeleton, self.labels, self.title = positions, skeleton, labels, title
        self._vertical = Y

    def plot(self, ax=None, *, projection: str | None = None, **style) -> "PoseDisplay":
        """Draw the display.

        Parameters
        ----------
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones. For a projection on three axes they have three dimensions
            (``projection="3d"``).
        projection : str, default=None
            The horizontal and the vertical axis: in files whose y points up "xy" is a view from the front or the back,
            "zy" from the side. Three axes, the last one up, draw in three dimensions: "zxy" where y points up, "xyz"
            where z does. None puts the axis upright that is nearest to the vertical of a motion, y for arrays, and
            shows the larger side of the movement, or of a single pose.
        **style
            Style of the lines, such as color, alpha, label; see `matplotlib.axes.Axes.plot`.

        Returns
        -------
        PoseDisplay
            The display itself.
        """
        if projection is None:
            is_deep = getattr(ax, "name", None) == "3d"
            projection = "zxy" if is_deep else _choose_projection(self.positions, self._vertical)
        self.projection_ = projection
        plane, shifts = check_projection(projection), np.zeros(len(self.positions))
        shape = shape_of_person(self.skeleton) if len(plane) == 2 else None
        figsize = None if self.labels is None else (max(4.0, 1.4 * len(self.positions)), 3.5)
        self.ax_, self.figure_ = axes(ax, figsize, projection="3d" if len(plane) == 3 else None)
        self.ax_.set(**{f"{axis}label": f"{name} (m)" for axis, name in zip("xyz", projection, strict=False)})
        if ax is None and len(plane) == 3:
            self.ax_.set_box_aspect((3, 3, 4))  # people are taller than wide
            self.ax_.locator_params(nbins=5)
        if self.labels is not None:
            flat = (self.positions if shape is None else shape.centres(with_root(self.positions)))[:, :, plane]
            low, high = (edge(flat[..., 0], axis=1, initial=0.0) for edge in (np.min, np.max))
            step = (1.0 + GAP) * max((high - low).max(), 0.25 * np.ptp(flat[..., 1])) or 1.0  # bones seen end on
            centres = np.arange(len(flat)) * step
            shifts = centres - (low + high) / 2
            self.ax_.set_xticks(centres, list(map(plain, self.labels)))
            self.ax_.set_xlabel(plain(self.title))
        for pose, shift in zip(self.positions, shifts, strict=True):
            draw_pose(self.ax_, pose, plane, self.skeleton, shape, shift, style)
        if shape is not None and plane[1] == self._vertical and (ax is None or self.labels is not None):
            draw_ground(self.ax_, shape, self.positions, plane[1])
        self.ax_.set_aspect("equal", adjustable="datalim")
        return self

    @classmethod
    def from_pose(cls, pose: ArrayLike, skeleton: Skeleton, *, ax=None, **options) -> "PoseDisplay":
        """Draw a pose.

        Parameters
        ----------
        pose : array-like of shape (n_dofs,)
            Joint angles, rad.
        skeleton : Skeleton
            Its skeleton.
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        **options
            Projection and style, see `plot`.

        Returns
        -------
        PoseDisplay
            The display.
        """
        pose = check_pose(pose, skeleton, "pose")
        warn_of_degrees(None, skeleton, pose=pose[None])
        return cls(forward_kinematics(pose[None], skeleton), skeleton).plot(ax, **options)

    @classmethod
    def from_positions(cls, positions: ArrayLike, skeleton: Skeleton, *, ax=None, **options) -> "PoseDisplay":
        """Draw positions of the joints, which need not be a pose, such as a mean of positions.

        Parameters
        ----------
        positions : array-like of shape (n_joints, 3)
            Positions of the joints, m, the root at the origin.
        skeleton : Skeleton
            Their skeleton.
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        **options
            Projection and style, see `plot`.

        Returns
        -------
        PoseDisplay
            The display.
        """
        check_skeleton(skeleton)
        positions = np.asarray(positions, dtype=np.float64)
        if positions.shape != (skeleton.n_joints, 3):
            raise ValueError(f"positions must have shape ({skeleton.n_joints}, 3), got {positions.shape}")
        return cls(positions[np.newaxis], skeleton).plot(ax, **options)

    @classmethod
    def from_poses(
        cls,
        X: ArrayLike,
        skeleton: Skeleton,
        *,
        labels: Sequence[str] | None = None,
        title: str = "pose",
        ax=None,
        **options,
    ) -> "PoseDisplay":
        """Draw poses.

        Parameters
        ----------
        X : array-like of shape (n_poses, n_dofs)
            Poses: joint angles, rad.
        skeleton : Skeleton
            Their skeleton.
        labels : sequence of str, default=None
            Text below each pose; None numbers them.
        title : str, default="pose"
            Title of the labels, with their unit.
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        **options
            Projection and style, see `plot`.

        Returns
        -------
        PoseDisplay
            The display.
        """
        check_skeleton(skeleton)
        X = check_poses(X, skeleton, "X")
        warn_of_degrees(None, skeleton, X=X)
        labels = [str(i) for i in range(len(X))] if labels is None else list(labels)
        if len(labels) != len(X):
            raise ValueError(f"labels must be one for each of the {len(X)} poses, got {len(labels)}")
        return cls(forward_kinematics(X, skeleton), skeleton, labels, title).plot(ax, **options)

    @classmethod
    def from_motion(cls, motion: Motion, *, n_poses: int = 8, ax=None, **options) -> "PoseDisplay":
        """Draw poses of a motion at equal intervals, the first and the last among them, with their times in s.

        Parameters
        ----------
        motion : Motion
            The motion.
        n_poses : int, default=8
            Number of poses to draw, fewer if the motion has fewer.
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        **options
            Projection and style, see `plot`.

        Returns
        -------
        PoseDisplay
            The display.
        """
        check_kind(motion, Motion, "motion", "from_poses(X, skeleton) draws an array of poses")
        check_integer(n_poses, 1, "n_poses")
        if not len(motion):
            raise ValueError("motion must have frames, got none")
        frames = np.unique(np.rint(np.linspace(0, len(motion) - 1, n_poses)).astype(int))
        labels = [f"{motion.times[frame]:.2f}" for frame in frames]
        display = cls(forward_kinematics(motion.angles[frames], motion.skeleton), motion.skeleton, labels, "time (s)")
        display._vertical = int(np.abs(vertical_of(motion)).argmax())  # the axis of the root nearest to it
        return display.plot(ax, **options)

    @classmethod
    def from_geodesic(
        cls, geodesic: GeodesicResult, skeleton: Skeleton, *, n_poses: int = 8, ax=None, **options
    ) -> "PoseDisplay":
        """Draw poses along a geodesic at equal lengths of curve, the two ends among them.

        Parameters
        ----------
        geodesic : GeodesicResult
            The geodesic.
        skeleton : Skeleton
            Its skeleton.
        n_poses : int, default=8
            Number of poses to draw.
        ax : matplotlib Axes, default=None
            The axes to draw into; None makes new ones.
        **options
            Projection and style, see `plot`.

        Returns
        -------
        PoseDisplay
            The display.
        """
        check_kind(geodesic, GeodesicResult, "geodesic", "skpose.geodesic(start, end, skeleton) finds one")
        check_integer(n_poses, 2, "n_poses")
        labels = [f"{length:.2f}" for length in np.linspace(0, geodesic.curve_length, n_poses)]
        title = "arc length from the first pose (m)"
        return cls.from_poses(geodesic.resample(n_poses), skeleton, labels=labels, title=title, ax=ax, **options)

    @classmethod
    def from_estimator(
        cls, pca: PoseTangentPCA, component: int = 0, *, n_poses: int = 5, extent: float = 2.0, ax=None, **options
    ) -> "PoseDisplay":
        """Draw poses along a component of a fitted `PoseTangentPCA`, the mean in the middle.

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
        PoseDisplay
            The display.
        """
        check_kind(pca, PoseTangentPCA, "pca", "PoseTangentPCA(skeleton).fit(X) is one")
        check_is_fitted(pca, "n_components_")
        check_integer(n_poses, 2, "n_poses")
        if not 0 <= component < pca.n_components_:
            raise ValueError(f"component must be from 0 to {pca.n_components_ - 1}, got {component}")
        if (skeleton := pca.skeleton_) is None:
            raise ValueError("pca must have a skeleton to be drawn, got PoseTangentPCA(None)")
        deviations, scores = np.linspace(-extent, extent, n_poses), np.zeros((n_poses, pca.n_components_))
        scores[:, component] = deviations * np.sqrt(pca.explained_variance_[component])
        labels = [f"{deviation:+.3g}".replace("-", "−") if deviation else "0" for deviation in deviations]
        share = pca.explained_variance_ratio_[component]
        title = f"standard deviations along component {component + 1}, {share:.0%} of the variance"
        poses = pca.inverse_transform(scores)
        return cls.from_poses(poses, skeleton, labels=labels, title=title, ax=ax, **options)


def _choose_projection(positions: np.ndarray, vertical: int) -> str:
    """The two axes that show poses (n_poses, n_joints, 3) from the side on which they differ more, upright.

    A single pose is shown from the side on which it is wider.
    """
    low, high = (axis for axis in range(3) if axis != vertical)
    known = positions[:, np.isfinite(positions).all(axis=(0, 2))]
    spread = known.var(axis=0).sum(axis=0)
    if not spread[[low, high]].any():
        spread = known.max(axis=(0, 1), initial=0.0) - known.min(axis=(0, 1), initial=0.0)
    return "xyz"[high if spread[high] > spread[low] * (1.0 + 1e-9) else low] + "xyz"[vertical]
