"""The shape of a figure, for those who draw one: hulls of spheres about joints, thick as the limbs of people are.

A *part* is what is drawn as one, such as a forearm or a head: hulls of *spheres*, whose centres follow from the
positions of the joints alone. People have the parts of a person, see `_person_shape`; all other skeletons have links.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from skpose.kinematics._landmarks import find_landmarks
from skpose.kinematics._person_shape import Part, Sphere, person_parts
from skpose.skeleton import Skeleton
from skpose.skeleton._shared import size_of

# Radii of links, as shares of the size of the figure and of the length of the bone. A size is that of the box around
# all joints at angle zero.
THICKEST, OF_LENGTH, THINNEST, OF_POINT = 0.018, 0.12, 0.003, 0.008
GAP = 1.2  # radii of a joint inside of a figure, up to which there is no edge
N_DIRECTIONS = 32  # in which the outline of a hull is found, so that it is too small by 0.5 % at most


class Shape(NamedTuple):
    """The parts of a figure. Points are the root, 0, and the joints from 1 on."""

    spheres: list[Sphere]
    parts: list[Part]
    is_person: bool

    def centres(self, points: np.ndarray) -> np.ndarray:
        """Return the centres (..., n_spheres, 3) of the spheres, of points (..., n_points, 3)."""
        return np.stack([_centre(sphere, points) for sphere in self.spheres], axis=-2)

    @property
    def radii(self) -> np.ndarray:
        """Radii (n_spheres,) of the spheres, in the unit of the skeleton."""
        return np.array([sphere.radius for sphere in self.spheres])

    def data(self) -> dict[str, Any]:
        """Return the shape as an object of JSON, for assets/shape.js of the pages."""
        return {
            "spheres": [_sphere_data(sphere) for sphere in self.spheres],
            "parts": [[part.joint, part.hulls] for part in self.parts],
        }

    def renumber(self, points: Sequence[int]) -> "Shape":
        """Return the shape with other indices of the points: those of the root and of each joint."""
        moved = [
            sphere._replace(
                points=tuple(points[i] for i in sphere.points),
                along=_renumber(sphere.along, points),
                across=_renumber(sphere.across, points),
            )
            for sphere in self.spheres
        ]
        parts = [part._replace(joint=points[part.joint + 1] - 1) for part in self.parts]
        return Shape(moved, parts, self.is_person)


def find_shape(skeleton: Skeleton) -> Shape:
    """Return the shape of a skeleton: that of a person where the names of its joints are those of a known rig."""
    person = person_parts(skeleton, find_landmarks(skeleton))
    if person is not None:
        return Shape(*person, is_person=True)
    return link_shape(skeleton, range(skeleton.n_joints))


def link_shape(skeleton: Skeleton, joints: Sequence[int]) -> Shape:
    """Return links for the bones that end at some joints: as thick at a joint as the thickest of those that meet."""
    size = size_of(skeleton) or 1.0
    lengths = np.linalg.norm(skeleton.offsets, axis=1)
    own = np.where(lengths > 1e-3 * size, np.minimum(THICKEST * size, OF_LENGTH * lengths + THINNEST * size), 0.0)
    radii = np.zeros(skeleton.n_joints + 1)  # of the points
    for j in joints:
        for point in (j + 1, int(skeleton.parents[j]) + 1):
            radii[point] = max(radii[point], own[j])
    radii[0] = radii[0] or max(radii.max(), OF_POINT * size)
    without = np.flatnonzero(own == 0.0).tolist()
    for j in (*reversed(without), *without):  # points at one place are as thick as the thickest of them
        both = [j + 1, int(skeleton.parents[j]) + 1]
        radii[both] = radii[both].max()
    spheres: list[Sphere] = []
    at: dict[int, int] = {}
    carries = {int(skeleton.parents[j]) + 1 for j in joints}

    def sphere(point: int) -> int:
        if point not in at:
            at[point] = len(spheres)
            spheres.append(Sphere((point,), float(radii[point]), inside=point in carries and point > 0))
        return at[point]

    parts = []
    for j in joints:
        ends = (int(skeleton.parents[j]) + 1, j + 1)
        moves = own[j] > 0.0 or skeleton.bones[j].is_slide
        parts.append(Part(j, (tuple(sphere(point) for point in (ends if moves else ends[1:])),)))
    return Shape(spheres, parts, False)


def point_shape(points: Sequence[int], size: float) -> Shape:
    """Return a ball for each point without a bone, by its index among the points."""
    spheres = [Sphere((point,), OF_POINT * size) for point in points]
    return Shape(spheres, [Part(point - 1, ((i,),)) for i, point in enumerate(points)], False)


def join_shapes(a: Shape, b: Shape) -> Shape:
    """Return the parts of both."""
    n = len(a.spheres)
    moved = [part._replace(hulls=tuple(tuple(i + n for i in hull) for hull in part.hulls)) for part in b.parts]
    return Shape(a.spheres + b.spheres, a.parts + moved, a.is_person or b.is_person)


class Outline(NamedTuple):
    """The outline of the hull of discs."""

    points: np.ndarray  # (n, 2) in order
    edges: np.ndarray  # (n_edges, 2, 2) the lines between them but near joints where another part goes on


def outline(
    centres: np.ndarray, radii: np.ndarray, inside: Sequence[bool] | np.ndarray, n_directions: int = N_DIRECTIONS
) -> Outline:
    """Return the outline of the hull of discs: in each direction the point that is farthest."""
    angles = np.linspace(0.0, 2.0 * np.pi, n_directions, endpoint=False)
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    farthest = (directions @ centres.T + radii).argmax(axis=1)
    points = centres[farthest] + radii[farthest, None] * directions
    before, open_ = np.roll(farthest, 1), np.array(inside)
    chosen = (before != farthest) | ~open_[farthest]
    ends = np.stack([np.roll(points, 1, axis=0), points], axis=1)[chosen]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    left_out = (
        np.where(before != farthest, 1.0, 0.0)[chosen, None]
        * np.where(open_, GAP * radii, 0.0)[np.stack([before, farthest], axis=1)[chosen]]
    )
    shares = np.minimum(0.5, np.divide(left_out, lengths[:, None], out=np.zeros_like(left_out), where=left_out > 0.0))
    along = (ends[:, 1] - ends[:, 0])[:, None] * shares[..., None] * [[1.0], [-1.0]]
    return Outline(points, ends + along)


def _centre(sphere: Sphere, points: np.ndarray) -> np.ndarray:
    weights = sphere.weights or (1.0 / len(sphere.points),) * len(sphere.points)
    centre = np.einsum("...pk,p->...k", points[..., list(sphere.points), :], np.array(weights))
    along = _direction(sphere.along, points)
    if sphere.along is not None:
        centre = centre + sphere.along.length * along
    if sphere.across is not None:
        across = _vector(sphere.across, points)
        across = across - (across * along).sum(axis=-1, keepdims=True) * along
        centre = centre + sphere.across.length * _unit(across)
    return centre


def _vector(shift: Any, points: np.ndarray) -> np.ndarray:
    start, end = (points[..., list(ends), :].mean(axis=-2) for ends in (shift.start, shift.end))
    return end - start


def _direction(shift: Any, points: np.ndarray) -> np.ndarray:
    return np.zeros((*points.shape[:-2], 3)) if shift is None else _unit(_vector(shift, points))


def _unit(vectors: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths != 0.0)


def _renumber(shift: Any, points: Sequence[int]) -> Any:
    if shift is None:
        return None
    return shift._replace(start=tuple(points[i] for i in shift.start), end=tuple(points[i] for i in shift.end))


def _sphere_data(sphere: Sphere) -> dict[str, Any]:
    """Return a sphere as an object of JSON, without what it has not."""
    data: dict[str, Any] = {"at": sphere.points, "radius": _short(sphere.radius)}
    if sphere.weights:
        data["weights"] = [_short(weight) for weight in sphere.weights]
    for name, shift in (("along", sphere.along), ("across", sphere.across)):
        if shift is not None:
            data[name] = [shift.start, shift.end, _short(shift.length)]
    if sphere.inside:
        data["inside"] = True
    return data


def _short(number: float) -> float:
    return float(f"{number:.4g}")
