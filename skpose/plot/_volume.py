"""People with volume: the parts of a person as areas behind the lines of the bones."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from skpose.plot._axes import SIDES
from skpose.skeleton import Skeleton
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
