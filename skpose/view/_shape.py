"""The shape of a figure, for drawing: hulls of spheres about joints, as thick as the limbs of people.

A *part* is drawn as one, such as a forearm or a head: hulls of *spheres*, whose centres follow from the positions of
the joints alone. People have a head, a trunk and limbs; all other skeletons have links.
"""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from skpose.kinematics._anatomy import (
    ANKLE,
    BALL,
    ELBOW,
    HAND,
    HEAD,
    HEAD_CENTER,
    HEAD_TOP,
    HIP,
    KNEE,
    LIMBS,
    SHOULDER,
    SIDES,
    TOE,
    WRIST,
    Anatomy,
    find_anatomy,
    path_up,
)
from skpose.skeleton import Skeleton
from skpose.skeleton._proportions import PROPORTIONS
from skpose.skeleton._rest import positions_at_zero, size_of, unit

# Radii, as shares of the height.
R_HIP, R_KNEE, R_CALF, R_ANKLE = 0.055, 0.0305, 0.0325, 0.0195
R_SHOULDER, R_ELBOW, R_FOREARM, R_WRIST = 0.0275, 0.0215, 0.0255, 0.0155
R_HEEL, R_BALL, R_TOE = 0.0185, 0.015, 0.0105
R_PALM, R_TIP, R_FINGER = 0.0175, 0.0115, 0.0055
R_SKULL, R_CHIN, R_NECK = 0.047, 0.037, 0.03
R_THROAT = 0.9 * R_NECK
R_PELVIS, R_CROTCH, R_WAIST, R_RIBS, R_CHEST = 0.055, 0.025, 0.052, 0.054, 0.034
R_MARKER = 0.006  # of a bone that belongs to no part, such as that from a joint to a marker
WIDEST = 0.115  # half width of the hips; where the joints are farther out, thighs begin closer to the middle
# Above the hips, along the trunk, and below them: the trunk ends between the thighs as a wedge.
PELVIS, CROTCH = 0.03, -0.03
# The middle of the skull above the joint between neck and head, and the chin below the skull.
SKULL, CHIN = 0.045, 0.042
HEEL = (-0.014, 0.024)  # from the ankle: along the foot, and at a right angle to that, down
TIP_OF_TOE = (0.038, -0.009)  # from the ball
HAND_LENGTH = 0.085  # of a relaxed hand
CALF, FOREARM, PALM = 0.28, 0.25, 0.45  # the thickest place, as a share of the length of shank, forearm and hand
# Of the trunk: how far up from hips to shoulders, and to the side, as shares of the widths of hips and shoulders.
WAIST, RIBS, CHEST, COLLARS = (0.4, 0.34, 0.15), (0.74, 0.0, 0.42), (0.97, 0.0, 0.8), (1.08, 0.0, 0.0)
SPINE, SPINE_BETWEEN = 0.5, (0.2, 0.6)  # the weight of a point of the spine in the waist, and where it may be
NECK = (0.52, 0.52, -0.02, -0.02)  # where the neck begins: weights of shoulders and hips
EARS, NOSE = ("left_ear", "right_ear"), "nose"
EARS_UP, NOSE_AHEAD = 0.015, 0.02  # of the skull above the ears, and of the chin in front of them
NEAR_HEAD = 0.2  # distance from the joint of the head within which bones belong to it
FEW_FINGERS = 3  # hands with at most so many ends of chains are drawn as mittens
FACE = ("eye", "ear", "nose", "mouth", "jaw")  # parts of names of points inside a head


class Shift(NamedTuple):
    """A distance along the line from the mean of some points to the mean of others."""

    start: tuple[int, ...]
    end: tuple[int, ...]
    length: float


class Sphere(NamedTuple):
    """A sphere whose centre is a mean of points, moved along one direction, and at a right angle to it."""

    at: tuple[int, ...]  # points
    radius: float
    weights: tuple[float, ...] = ()  # sum to one; none for the mean
    along: Shift | None = None
    across: Shift | None = None  # its component at a right angle to `along` is taken
    inside: bool = False  # whether two parts meet in it, so that it has no edge of its own


class Part(NamedTuple):
    """A part that is drawn as one: hulls of spheres, by their indices."""

    joint: int  # whose colour it has; -1 is the root
    hulls: tuple[tuple[int, ...], ...]


class _Maker:
    """Makes the parts of one person. A point is the index of a joint plus one; 0 where a landmark is missing."""

    def __init__(self, skeleton: Skeleton, person: Anatomy):
        self.skeleton, self.joints, self.trunk = skeleton, person.joints, person.trunk
        self.where = positions_at_zero(skeleton)
        self.lengths = np.linalg.norm(skeleton.offsets, axis=1)
        self.hips, self.shoulders, ankles = ([self.point(s, mark) for s in SIDES] for mark in (HIP, SHOULDER, ANKLE))
        legs = [self.lengths[self._between(*ends)].sum() for ends in zip(self.hips, ankles, strict=True)]
        self.height = float(np.mean(legs)) / (PROPORTIONS["thigh"] + PROPORTIONS["shank"])
        self.spheres: list[Sphere] = []
        self.parts: list[Part] = []
        self.covered: set[int] = set()  # joints whose bones are inside of parts

    def point(self, side: str, mark: str) -> int:
        return self.joints.get(f"{side}_{mark}", -1) + 1

    def _between(self, above: int, below: int) -> list[int]:
        """The joints after one point, up to one below it."""
        path = path_up(self.skeleton, below - 1)
        return path[: path.index(above - 1)] if above - 1 in path else []

    def _after(self, joint: int) -> list[int]:
        return [j for j in range(self.skeleton.n_joints) if joint in path_up(self.skeleton, j)[1:]]

    def sphere(
        self,
        points: Iterable[int],
        radius: float,
        weights: tuple[float, ...] = (),
        *,
        along: tuple[Iterable[int], Iterable[int], float] | None = None,
        across: tuple[Iterable[int], Iterable[int], float] | None = None,
        inside: bool = False,
    ) -> int:
        """Add a sphere, with lengths as shares of the height; return its index."""
        first, second = (
            None if shift is None else Shift(tuple(shift[0]), tuple(shift[1]), self.height * shift[2])
            for shift in (along, across)
        )
        self.spheres.append(Sphere(tuple(points), self.height * radius, weights, first, second, inside))
        return len(self.spheres) - 1

    def add_link(self, joint: int, radius: float) -> None:
        """Add a thin part for one bone."""
        if self.lengths[joint]:
            start = self.sphere([int(self.skeleton.parents[joint]) + 1], radius, inside=True)
            self.parts.append(Part(joint, ((start, self.sphere([joint + 1], radius)),)))

    def _add_limb(self, points: tuple[int, int, int], radii: tuple[float, ...], upper: int, bulge: float) -> int:
        """Add the two parts of an arm or a leg below a sphere; return the sphere of the wrist or the ankle."""
        first, middle, last = points
        lower = self.sphere([middle], radii[0], inside=True)
        thickest = self.sphere([middle], radii[1], along=([middle], [last], bulge))
        end = self.sphere([last], radii[2], inside=True)
        self.parts += [Part(middle - 1, ((upper, lower),)), Part(last - 1, ((lower, thickest, end),))]
        self.covered.update(self._between(first, last))
        return end

    def add_leg(self, side: str) -> None:
        hip, knee, ankle, ball, toe = (self.point(side, mark) for mark in (HIP, KNEE, ANKLE, BALL, TOE))
        upper = self.sphere(*self._hip(side, R_HIP), inside=True)
        bulge = CALF * PROPORTIONS["shank"]
        foot = self._add_limb((hip, knee, ankle), (R_KNEE, R_CALF, R_ANKLE), upper, bulge)
        if not (ball or toe):
            return  # the direction of the foot is unknown
        first, last = ball or toe, toe or ball

        def shifts(lengths: tuple[float, float]) -> dict[str, Any]:
            return {"along": ([ankle], [first], lengths[0]), "across": ([knee], [ankle], lengths[1])}

        heel = self.sphere([ankle], R_HEEL, **shifts(HEEL))
        middle = [self.sphere([ball], R_BALL)] if ball else []
        front = self.sphere([last], R_TOE, **({} if toe else shifts(TIP_OF_TOE)))
        self.parts.append(Part(first - 1, ((foot, heel, *(middle or [front])), *((one, front) for one in middle))))
        self.covered.update(self._between(ankle, last))

    def add_arm(self, side: str) -> None:
        shoulder, elbow, wrist, known = (self.point(side, mark) for mark in (SHOULDER, ELBOW, WRIST, HAND))
        upper, radii = self.sphere([shoulder], R_SHOULDER, inside=True), (R_ELBOW, R_FOREARM, R_WRIST)
        hand = self._add_limb((shoulder, elbow, wrist), radii, upper, FOREARM * PROPORTIONS["forearm"])
        after, joint = self._after(wrist - 1), (known or wrist) - 1
        if sum(j not in self.skeleton.parents for j in after) > FEW_FINGERS:
            knuckles = [j for j in after if self.skeleton.parents[j] == wrist - 1 and self.lengths[j]]
            self.parts.append(Part(joint, ((hand, *(self.sphere([j + 1], R_TIP) for j in knuckles)),)))
            for j in after:
                if j not in knuckles:
                    self.add_link(j, R_FINGER)
            self.covered.update(after)
            return
        toward = ([wrist], [known]) if known else ([elbow], [wrist])
        reach = [self.lengths[self._between(wrist, j + 1)].sum() / self.height for j in after]
        length = float(np.clip(max(reach, default=0.0) - R_TIP, HAND_LENGTH, PROPORTIONS["hand"]))
        middle = self.sphere([wrist], R_PALM, along=(*toward, PALM * length))
        tip = self.sphere([wrist], R_TIP, along=(*toward, length))
        self.parts.append(Part(joint, ((hand, middle, tip),)))
        self.covered.update(after if known else [])

    def _hip(self, side: str, radius: float) -> tuple[list[int], float, tuple[float, ...]]:
        """Points, radius and weights of a sphere at a hip, moved inwards where the joints are too far apart."""
        hip, other = self.hips if side == SIDES[0] else self.hips[::-1]
        width = float(np.linalg.norm(self.where[hip - 1] - self.where[other - 1])) / self.height
        share = max(0.0, 0.5 * width + radius - WIDEST) / width if width else 0.0
        return ([hip, other], radius, (1.0 - share, share)) if share > 0.0 else ([hip], radius, ())

    def add_trunk(self, neck: tuple[int, ...]) -> None:
        """Add the trunk, with the hull of the neck if there is one."""
        hips, shoulders = self.hips, self.shoulders
        spine, up = self._spine()
        points = (*hips, *shoulders, *spine)

        def level(share: float, of_hips: float, of_shoulders: float, weight: float = 0.0) -> list[tuple[float, ...]]:
            """Weights of the points for both sides at a share of the way up, so far to the side."""
            ends = ((0.5 * (1.0 - share) * (1.0 - weight), of_hips), (0.5 * share * (1.0 - weight), of_shoulders))
            return [
                (*(own + sign * width for own, width in ends for sign in (side, -side)), *[weight] * len(spine))
                for side in (0.5, -0.5)
            ]

        line = (hips, shoulders)
        pelvis = [self.sphere(*self._hip(side, R_PELVIS), along=(*line, PELVIS)) for side in SIDES]
        crotch = self.sphere(hips, R_CROTCH, along=(*line, CROTCH))
        # The band is inside of the other parts, and alone where shoulders are not seen.
        band = [self.sphere(at, R_CROTCH, w) for at, _, w in (self._hip(side, R_PELVIS) for side in SIDES)]
        waist = [self.sphere(points, R_WAIST, w) for w in level(up, *WAIST[1:], SPINE if spine else 0.0)]
        ribs = [self.sphere(points, R_RIBS, w) for w in level(*RIBS)]
        chest = [self.sphere(points, R_CHEST, w) for w in level(*CHEST)]
        collar = self.sphere(points, R_NECK, level(*COLLARS)[0])
        hulls = (crotch, *band, *pelvis, *waist), (*waist, *ribs), (*ribs, *chest, collar)
        self.parts.append(Part(self.trunk[-1] if self.trunk else -1, (*hulls, neck) if neck else hulls))
        for end in (*hips, *shoulders):
            self.covered.update(path_up(self.skeleton, end - 1))

    def _spine(self) -> tuple[list[int], float]:
        """The point of the spine nearest the waist, if any, and how far up from hips to shoulders it is."""
        low, high = (self.where[[point - 1 for point in pair]].mean(axis=0) for pair in (self.hips, self.shoulders))
        up = high - low
        shares = {j + 1: float((self.where[j] - low) @ up / (up @ up)) for j in self.trunk if up.any()}
        near = [point for point, share in shares.items() if SPINE_BETWEEN[0] < share < SPINE_BETWEEN[1]]
        nearest = sorted(near, key=lambda point: abs(shares[point] - WAIST[0]))[:1]
        return nearest, shares[nearest[0]] if nearest else WAIST[0]

    def add_head(self) -> tuple[int, ...]:
        """Add the head; return the spheres of the neck, none where no head is known."""
        names = enumerate(map(str.lower, self.skeleton.joint_names))
        face = {name: j for j, name in names if name in (*EARS, NOSE)}
        found = self._find_head(face)
        if found is None:
            return ()
        joint, at, line, skull = found
        ahead = (at, [face[NOSE] + 1], NOSE_AHEAD) if len(at) > 1 and NOSE in face else None
        top = self.sphere(at, R_SKULL, along=(*line, skull))
        chin = self.sphere(at, R_CHIN, along=(*line, skull - CHIN), across=ahead)
        base = self.sphere((*self.shoulders, *self.hips), R_NECK, weights=NECK, inside=True)
        throat = self.sphere(at, R_THROAT, along=(*line, skull - CHIN), inside=True)
        self.parts.append(Part(joint, ((top, chin),)))
        self.covered.update(path_up(self.skeleton, joint))
        for j in self._after(int(self.skeleton.parents[joint]) if joint in face.values() else joint):
            near = np.linalg.norm(self.where[j] - self.where[joint]) < NEAR_HEAD * self.height
            if near or any(word in self.skeleton.joint_names[j].lower() for word in FACE):
                self.covered.add(j)
        return base, throat

    def _find_head(self, face: dict[str, int]) -> tuple[int, list[int], tuple[list[int], list[int]], float] | None:
        """Joint, points, upward line and height of the skull: by the head's joint, end or middle, or by the ears."""
        parents = self.skeleton.parents
        top = self.joints.get(HEAD_TOP, -1)
        for mark, skull in ((HEAD, SKULL), (HEAD_TOP, -R_SKULL), (HEAD_CENTER, 0.0)):
            joint = self.joints.get(mark, -1)
            if joint < 0:
                continue
            if mark == HEAD and top >= 0 and self.lengths[top]:
                crown = min(self.lengths[top] / self.height, PROPORTIONS["head"])
                return joint, [joint + 1], ([joint + 1], [top + 1]), max(skull, crown - R_SKULL)
            before = next((int(parents[j]) + 1 for j in path_up(self.skeleton, joint) if self.lengths[j]), 0)
            start = [before] if before and before not in self.shoulders else self.shoulders
            return joint, [joint + 1], (start, [joint + 1]), skull
        if not all(ear in face for ear in EARS):
            return None
        ears = [face[ear] + 1 for ear in EARS]
        return face.get(NOSE, face[EARS[0]]), ears, (self.shoulders, ears), EARS_UP


# --- shape ------------------------------------------------------------------------------------------------------------


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
    """The shape of a person if the joints are those of both arms and legs, else links."""
    person = find_anatomy(skeleton)
    if not all(f"{side}_{mark}" in person.joints for side in SIDES for limb in LIMBS for mark in limb):
        return link_shape(skeleton)
    maker = _Maker(skeleton, person)
    if not maker.height:
        return link_shape(skeleton)
    for side in SIDES:
        maker.add_leg(side)
        maker.add_arm(side)
    maker.add_trunk(maker.add_head())
    for joint in range(skeleton.n_joints):
        if joint not in maker.covered:
            maker.add_link(joint, R_MARKER)
    return Shape(maker.spheres, maker.parts, True)


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
