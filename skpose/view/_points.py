"""Keypoints in space, as pages draw them: like a motion, with the bones of a layout."""

from typing import Any, NamedTuple

import numpy as np

from skpose._utils.units import extent_of
from skpose.keypoints import Keypoints, Layout
from skpose.keypoints._layouts import find_layout
from skpose.keypoints._names import find_names
from skpose.kinematics._ground import find_ground
from skpose.skeleton._sides import sides
from skpose.view._pack import pack
from skpose.view._person_shape import Part, Sphere
from skpose.view._scene import AXES, Scene, scene_data
from skpose.view._shape import OF_POINT, THICKEST, Shape


class Figure(NamedTuple):
    """Points with the bones between them."""

    positions: np.ndarray  # (n_frames, n_points, 3), m, NaN where a point is not seen
    names: list[str]
    parents: list[int]  # of each point the point at the other end of its bone, or −1
    layout: str | None  # whose bones these are


def figure_of(keypoints: Keypoints, layout: Layout | None) -> Figure:
    """Points with the bones of a layout; None chooses the layout whose points are all there by name, if any.

    Midpoints of the layout are added, and points unknown to the layout have no bones.
    """
    layout = find_layout(keypoints.names) if layout is None else layout
    if layout is None:
        names = list(keypoints.names)
        return Figure(keypoints.positions, names, [-1] * len(names), None)
    known = layout.keypoints(keypoints)  # refuses keypoints without a point of the layout
    given = find_names(layout.points, keypoints.names)
    others = [name for name in keypoints.names if name not in given.values()]
    parents = [-1 if parent is None else known.names.index(parent) for parent in map(layout.parents.get, known.names)]
    rest = keypoints.positions[:, [keypoints.names.index(name) for name in others]]
    return Figure(
        np.concatenate([known.positions, rest], axis=1),
        [*(given.get(name, name) for name in known.names), *others],
        parents + [-1] * len(others),
        layout.name,
    )


def points_data(keypoints: Keypoints, label: str, layout: Layout | None) -> dict[str, Any]:
    """Data of keypoints in a page, as an object of JSON; see `motion_data` of `_scene`.

    Missing points are interpolated linearly over time, so that the middle of all points, which the view follows instead
    of a root, does not jump.
    """
    figure = figure_of(keypoints, layout)
    order = AXES[keypoints.up]
    positions = figure.positions[..., order]
    seen = ~np.isnan(positions[..., 0])
    filled = _fill(positions, seen)
    middle = filled[:, seen.any(axis=0)].mean(axis=1)
    size, times = extent_of(positions) or 1.0, np.arange(len(positions)) / keypoints.frame_rate
    height, standing = find_ground(positions, times, size)
    joints = np.where(seen.any(axis=0)[:, None], filled - middle[:, None], 0.0)
    axes, root = "".join("xyz"[axis] for axis in order), middle - [0.0, height, 0.0]
    return scene_data(Scene(joints, root, np.zeros(len(middle)), axes, size, standing)) | {
        "label": label,
        "names": figure.names,
        "parents": figure.parents,
        "sides": sides(figure.names),
        "shape": _shape_of(figure.parents, size).data(),
        "rate": keypoints.frame_rate,
        "start": 0.0,
        "numbers": None,
        "headings": None,  # nothing is known of where points face
        "seen": pack(seen.astype(float), 1.0),
        "layout": figure.layout,
    }


def _shape_of(parents: list[int], size: float) -> Shape:
    """Links between points, and smaller balls for points without a bone."""
    linked = {*parents, *(i for i, parent in enumerate(parents) if parent >= 0)}
    radii = [(THICKEST if i in linked else OF_POINT) * size for i in range(len(parents))]
    spheres = [Sphere((i + 1,), radius, inside=i in parents) for i, radius in enumerate(radii)]
    parts = [Part(i, ((parent, i) if parent >= 0 else (i,),)) for i, parent in enumerate(parents)]
    return Shape(spheres, parts, False)


def _fill(positions: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Positions without gaps: linear over time, constant before the first and after the last visible frame."""
    filled, frames = np.zeros(positions.shape), np.arange(len(positions))
    for point in np.flatnonzero(seen.any(axis=0)):
        at = np.flatnonzero(seen[:, point])
        for axis in range(3):
            filled[:, point, axis] = np.interp(frames, at, positions[at, point, axis])
    return filled
