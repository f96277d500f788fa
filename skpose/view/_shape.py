"""The shape of a figure, for drawing: hulls of spheres about joints, as thick as the limbs of people.

A *part* is drawn as one, such as a forearm or a head: hulls of *spheres*, whose centres follow from the positions of
the joints alone. People have the parts of a person, see `_person_shape`; all other skeletons have links.
"""

from typing import Any, NamedTuple

import numpy as np

from skpose.kinematics._anatomy import find_anatomy
from skpose.kinematics._lines import unit
from skpose.skeleton import Skeleton
from skpose.skeleton._rest import size_of
from skpose.view._person_shape import Part, Shift, Sphere, person_parts

# Radii of links, as shares of the size of the figure and of the length of the bone. The size is the longest side of
# the box around all joints at angle zero.
THICKEST, OF_LENGTH, THINNEST, OF_POINT = 0.018, 0.12, 0.003, 0.008
DIRECTIONS = np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)  # of an outline, too small by 0.5 % at most


class Shape(NamedTuple):
    """The parts of a figure. Points are the root, 0, and the joints from 1 on."""

    spheres: list[Sphere]
    parts: list[Part]
    is_person: bool

    def centres(self, points: np.ndarray) -> np.ndarray:
        """Centres (..., n_spheres, 3) of the spheres, of points (..., n_points, 3)."""
        return np.stack([_centre(sphere, points) for sphere in self.spheres], axis=-2)

    @property
    def radii(self) -> np.ndarray:
        return np.array([sphere.radius for sphere in self.spheres])

    def data(self) -> dict[str, Any]:
        """The shape as an object of JSON, for assets/shape.js of the pages."""
        spheres = [{name: value for name, value in one._asdict().items() if value} for one in self.spheres]
        return {"spheres": spheres, "parts": self.parts}


def find_shape(skeleton: Skeleton) -> Shape:
    """The shape of a person if the joints are a person's, else links."""
    person = person_parts(skeleton, find_anatomy(skeleton))
    return link_shape(skeleton) if person is None else Shape(*person, is_person=True)


def link_shape(skeleton: Skeleton) -> Shape:
    """Links for all bones; links that meet at a joint are equally thick there."""
    size = size_of(skeleton) or 1.0
    lengths = np.linalg.norm(skeleton.offsets, axis=1)
    own = np.where(lengths > 1e-3 * size, np.minimum(THICKEST * size, OF_LENGTH * lengths + THINNEST * size), 0.0)
    before = skeleton.parents + 1  # the point at which each bone begins
    radii = np.concatenate([[0.0], own])
    np.maximum.at(radii, before, own)
    radii[0] = radii[0] or max(radii.max(), OF_POINT * size)
    without = np.flatnonzero(own == 0.0).tolist()
    for j in (*reversed(without), *without):  # points at one place are as thick as the thickest of them
        radii[[j + 1, before[j]]] = radii[[j + 1, before[j]]].max()
    moves = [own[j] > 0.0 or bone.is_slide for j, bone in enumerate(skeleton.bones)]
    hulls = [(int(before[j]), j + 1) if moves[j] else (j + 1,) for j in range(skeleton.n_joints)]
    at = {point: i for i, point in enumerate(dict.fromkeys(point for hull in hulls for point in hull))}
    spheres = [Sphere((point,), float(radii[point]), inside=point > 0 and point in before) for point in at]
    parts = [Part(j, (tuple(at[point] for point in hull),)) for j, hull in enumerate(hulls)]
    return Shape(spheres, parts, False)


def outline(centres: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """The outline (n, 2) of the hull of discs, in order: in each direction the farthest point."""
    directions = np.stack([np.cos(DIRECTIONS), np.sin(DIRECTIONS)], axis=1)
    farthest = (directions @ centres.T + radii).argmax(axis=1)
    return np.asarray(centres[farthest] + radii[farthest, None] * directions)


def _centre(sphere: Sphere, points: np.ndarray) -> np.ndarray:
    weights = sphere.weights or (1.0 / len(sphere.at),) * len(sphere.at)
    centre = np.einsum("...pk,p->...k", points[..., list(sphere.at), :], np.array(weights))
    if sphere.along is None:
        return centre
    along = unit(_line(sphere.along, points))
    centre = centre + sphere.along.length * along
    if sphere.across is None:
        return centre
    across = _line(sphere.across, points)
    return centre + sphere.across.length * unit(across - (across * along).sum(axis=-1, keepdims=True) * along)


def _line(shift: Shift, points: np.ndarray) -> np.ndarray:
    start, end = (points[..., list(ends), :].mean(axis=-2) for ends in (shift.start, shift.end))
    return end - start
