"""The parts of a person: head, trunk, limbs, hands and feet, as hulls of spheres about joints.

All lengths are shares of the height, which follows from the lengths of the limbs. The radii are such that each segment
of a limb has nearly the volume that its mass needs, by the same table as `mass_weights`: P. de Leva, "Adjustments to
Zatsiorsky-Seluyanov's segment inertia parameters", Journal of Biomechanics 29(9), 1996, for people of 67.5 kg and
1.74 m whose segments have 1.05 g/cm³. Lengths of head, hands and feet are those of `PROPORTIONS`.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from skpose.kinematics._landmarks import SIDES, Landmarks, path_up
from skpose.kinematics._rigs import (
    ANKLE,
    BALL,
    ELBOW,
    HAND,
    HEAD,
    HEAD_CENTER,
    HEAD_TOP,
    HIP,
    KNEE,
    SHOULDER,
    TOE,
    WRIST,
)
from skpose.skeleton import Skeleton
from skpose.skeleton._shared import PROPORTIONS, positions_at_zero

# Radii, as shares of the height.
R_HIP, R_KNEE, R_CALF, R_ANKLE = 0.055, 0.0305, 0.0325, 0.0195
WIDEST = 0.115  # of the hips from their middle; of files whose hip joints are at the side, thighs begin further inside
R_SHOULDER, R_ELBOW, R_FOREARM, R_WRIST = 0.0275, 0.0215, 0.0255, 0.0155
R_HEEL, R_BALL, R_TOE = 0.0185, 0.015, 0.0105
R_PALM, R_TIP, R_FINGER = 0.0175, 0.0115, 0.0055
R_SKULL, R_CHIN, R_NECK = 0.047, 0.037, 0.03
R_THROAT = 0.9 * R_NECK
R_PELVIS, R_CROTCH, R_WAIST, R_RIBS, R_CHEST = 0.055, 0.025, 0.052, 0.054, 0.034
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
EARS_UP, NOSE_AHEAD = 0.015, 0.02  # of the skull above the ears, and of the chin before them
NEAR_HEAD = 0.2  # of the joint of the head, up to which bones are inside of it
FEW_FINGERS = 3  # ends of chains after a wrist, up to which a hand is drawn as a mitten
FACE = ("eye", "ear", "nose", "mouth", "jaw")  # parts of names of points that are inside of a head
MARKER = 0.006  # of a bone that belongs to no part, such as that from a joint to a marker


class Shift(NamedTuple):
    """A distance along the line from the mean of some points to that of others."""

    start: tuple[int, ...]
    end: tuple[int, ...]
    length: float


class Sphere(NamedTuple):
    """A sphere whose centre is a mean of points, moved along one direction, and at a right angle to it."""

    points: tuple[int, ...]
    radius: float
    weights: tuple[float, ...] = ()  # sum to one; none for the mean
    along: Shift | None = None
    across: Shift | None = None  # of which the component at a right angle to `along` is taken
    inside: bool = False  # whether two parts meet in it, so that it has no edge of its own


class Part(NamedTuple):
    """A part that is drawn as one: hulls of spheres, by their indices."""

    joint: int  # whose colour it has; -1 is the root
    hulls: tuple[tuple[int, ...], ...]


def person_parts(skeleton: Skeleton, person: Landmarks) -> tuple[list[Sphere], list[Part]] | None:
    """Return spheres and parts; None for what is no person with hips and shoulders."""
    height = _height(skeleton, person)
    if not height:
        return None
    maker = _Maker(skeleton, person, height)
    if not maker.has_trunk:
        return None
    maker.add_limbs()
    maker.add_trunk(maker.add_head())
    maker.add_rest()
    return maker.spheres, maker.parts


def _height(skeleton: Skeleton, person: Landmarks) -> float:
    """Return the height of a person, by the lengths of the legs, or else of the arms; zero if neither is known."""
    joints = person.joints
    for start, end, share in (
        (HIP, ANKLE, PROPORTIONS["thigh"] + PROPORTIONS["shank"]),
        (SHOULDER, WRIST, PROPORTIONS["upper_arm"] + PROPORTIONS["forearm"]),
    ):
        ends = [(joints.get(f"{side}_{start}", -1), joints.get(f"{side}_{end}", -1)) for side in SIDES]
        if min(min(pair) for pair in ends) >= 0:
            lengths = [
                sum(float(np.linalg.norm(skeleton.offsets[j])) for j in _between(skeleton, *pair)) for pair in ends
            ]
            return float(np.mean(lengths)) / share
    return 0.0


def _between(skeleton: Skeleton, above: int, below: int) -> list[int]:
    """Return the joints after one, up to another one that comes after it."""
    path = path_up(skeleton, below)
    return path[: path.index(above)] if above in path else []


def _is_of_face(name: str) -> bool:
    return any(word in name.lower() for word in FACE)


class _Head(NamedTuple):
    """The place of a head."""

    joint: int
    points: list[int]  # of which the skull begins at the mean
    along: tuple[list[int], list[int]]  # points between which the line up from the neck is
    skull: float  # the middle of the skull along this line, as a share of the height
    ahead: tuple[list[int], list[int], float] | None  # the line to the face, and how far along it the chin is


class _Maker:
    """Makes the parts of one person."""

    def __init__(self, skeleton: Skeleton, person: Landmarks, height: float):
        self.skeleton, self.joints, self.person, self.height = skeleton, person.joints, person, height
        self.spheres: list[Sphere] = []
        self.parts: list[Part] = []
        self.covered: set[int] = set()  # joints whose bones are inside of parts

    @property
    def has_trunk(self) -> bool:
        return all(f"{side}_{mark}" in self.joints for side in SIDES for mark in (HIP, SHOULDER))

    def point(self, mark: str) -> int:
        return self.joints[mark] + 1

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

    def add(self, joint: int, *hulls: tuple[int, ...]) -> None:
        self.parts.append(Part(joint, hulls))

    def add_limbs(self) -> None:
        for side in SIDES:
            if all(f"{side}_{mark}" in self.joints for mark in (HIP, KNEE, ANKLE)):
                self._add_leg(side)
            if all(f"{side}_{mark}" in self.joints for mark in (SHOULDER, ELBOW, WRIST)):
                self._add_arm(side)

    def _add_leg(self, side: str) -> None:
        hip, knee, ankle = (self.point(f"{side}_{mark}") for mark in (HIP, KNEE, ANKLE))
        upper = self.sphere(*self._hip(side, R_HIP), inside=True)
        lower = self.sphere([knee], R_KNEE, inside=True)
        calf = self.sphere([knee], R_CALF, along=([knee], [ankle], CALF * PROPORTIONS["shank"]))
        foot = self.sphere([ankle], R_ANKLE, inside=True)
        self.add(knee - 1, (upper, lower))
        self.add(ankle - 1, (lower, calf, foot))
        self.covered.update(_between(self.skeleton, hip - 1, ankle - 1))
        ends = [self.point(f"{side}_{mark}") for mark in (BALL, TOE) if f"{side}_{mark}" in self.joints]
        if not ends:
            return  # where it points is not known
        first, last = ends[0], ends[-1]
        along, across = ([ankle], [first]), ([knee], [ankle])
        heel = self.sphere([ankle], R_HEEL, along=(*along, HEEL[0]), across=(*across, HEEL[1]))
        if first == last and f"{side}_{TOE}" in self.joints:
            front = self.sphere([last], R_TOE)
            self.add(first - 1, (foot, heel, front))
        else:
            ball = self.sphere([first], R_BALL)
            if first == last:
                toe = self.sphere([first], R_TOE, along=(*along, TIP_OF_TOE[0]), across=(*across, TIP_OF_TOE[1]))
            else:
                toe = self.sphere([last], R_TOE)
            self.add(first - 1, (foot, heel, ball), (ball, toe))
        self.covered.update(_between(self.skeleton, ankle - 1, last - 1))

    def _add_arm(self, side: str) -> None:
        shoulder, elbow, wrist = (self.point(f"{side}_{mark}") for mark in (SHOULDER, ELBOW, WRIST))
        upper, lower = self.sphere([shoulder], R_SHOULDER, inside=True), self.sphere([elbow], R_ELBOW, inside=True)
        bulge = self.sphere([elbow], R_FOREARM, along=([elbow], [wrist], FOREARM * PROPORTIONS["forearm"]))
        hand = self.sphere([wrist], R_WRIST, inside=True)
        self.add(elbow - 1, (upper, lower))
        self.add(wrist - 1, (lower, bulge, hand))
        self.covered.update(_between(self.skeleton, shoulder - 1, wrist - 1))
        after = self._after(wrist - 1)
        ends = [j for j in after if j not in self.skeleton.parents]
        known = self.joints.get(f"{side}_{HAND}", -1)
        if len(ends) > FEW_FINGERS:
            knuckles = [j for j in after if self.skeleton.parents[j] == wrist - 1 and self._length(j)]
            palm = [self.sphere([j + 1], R_TIP) for j in knuckles]
            self.add(known if known >= 0 else wrist - 1, (hand, *palm))
            self.covered.update(knuckles)
            for j in after:
                if j not in knuckles and self._length(j):
                    self._add_link(j, R_FINGER)
            self.covered.update(after)
            return
        toward = ([elbow], [wrist]) if known < 0 else ([wrist], [known + 1])
        far = max((self._distance(wrist - 1, j) for j in after), default=0.0) - R_TIP
        length = float(np.clip(far, HAND_LENGTH, PROPORTIONS["hand"]))
        middle = self.sphere([wrist], R_PALM, along=(*toward, PALM * length))
        tip = self.sphere([wrist], R_TIP, along=(*toward, length))
        self.add(known if known >= 0 else wrist - 1, (hand, middle, tip))
        self.covered.update(after if known >= 0 else [])

    def _add_link(self, joint: int, radius: float) -> None:
        start = self.sphere([int(self.skeleton.parents[joint]) + 1], radius, inside=True)
        self.add(joint, (start, self.sphere([joint + 1], radius)))

    def _hip(self, side: str, radius: float) -> tuple[list[int], float, tuple[float, ...]]:
        """Return the points, the radius and the weights of a sphere at a hip that is not wider than a person's."""
        hip, other = (self.point(f"{one}_{HIP}") for one in (side, *(one for one in SIDES if one != side)))
        where = positions_at_zero(self.skeleton)
        width = float(np.linalg.norm(where[hip - 1] - where[other - 1])) / self.height
        share = max(0.0, 0.5 * width + radius - WIDEST) / width if width else 0.0
        return ([hip, other], radius, (1.0 - share, share)) if share > 0.0 else ([hip], radius, ())

    def _distance(self, above: int, below: int) -> float:
        """Return the length of the bones between two joints, as a share of the height."""
        return sum(map(self._length, _between(self.skeleton, above, below))) / self.height

    def _length(self, joint: int) -> float:
        return float(np.linalg.norm(self.skeleton.offsets[joint]))

    def _after(self, joint: int) -> list[int]:
        """Return all joints that come after one."""
        return [j for j in range(self.skeleton.n_joints) if joint in path_up(self.skeleton, j)[1:]]

    def add_trunk(self, neck: tuple[int, ...]) -> None:
        """Add the trunk, with the hull of the neck if there is one."""
        hips, shoulders = ([self.point(f"{side}_{mark}") for side in SIDES] for mark in (HIP, SHOULDER))
        at, share = self._spine(hips, shoulders)
        points = (*hips, *shoulders, *([] if at is None else [at]))

        def level(share: float, of_hips: float, of_shoulders: float, spine: float = 0.0) -> list[tuple[float, ...]]:
            """Return weights of the points for both sides at a share of the way up, so far to the side."""
            ends = ((0.5 * (1.0 - share) * (1.0 - spine), of_hips), (0.5 * share * (1.0 - spine), of_shoulders))
            rest = () if at is None else (spine,)
            return [
                (*(weight + sign * width for weight, width in ends for sign in (side, -side)), *rest)
                for side in (0.5, -0.5)
            ]

        up = (hips, shoulders)
        pelvis = [self.sphere(*self._hip(side, R_PELVIS), along=(*up, PELVIS)) for side in SIDES]
        crotch = self.sphere(hips, R_CROTCH, along=(*up, CROTCH))
        # These are inside of the others, and alone where shoulders are not seen.
        band = [self.sphere(at, R_CROTCH, w) for at, _, w in (self._hip(side, R_PELVIS) for side in SIDES)]
        spine = 0.0 if at is None else SPINE
        waist = [self.sphere(points, R_WAIST, weights=w) for w in level(share, *WAIST[1:], spine)]
        ribs = [self.sphere(points, R_RIBS, weights=w) for w in level(*RIBS)]
        chest = [self.sphere(points, R_CHEST, weights=w) for w in level(*CHEST)]
        collar = self.sphere(points, R_NECK, weights=level(*COLLARS)[0])
        joint = self.person.trunk[-1] if self.person.trunk else -1
        hulls = (crotch, *band, *pelvis, *waist), (*waist, *ribs), (*ribs, *chest, collar)
        self.add(joint, *hulls, *([neck] if neck else []))
        for end in (*hips, *shoulders):
            self.covered.update(path_up(self.skeleton, end - 1))

    def _spine(self, hips: list[int], shoulders: list[int]) -> tuple[int | None, float]:
        """Return a point of the spine near the waist, if there is one, and how far up from hips to shoulders it is."""
        where = positions_at_zero(self.skeleton)
        low, high = (where[[point - 1 for point in pair]].mean(axis=0) for pair in (hips, shoulders))
        up = high - low
        shares = {j + 1: float((where[j] - low) @ up / (up @ up)) for j in self.person.trunk} if up.any() else {}
        near = {point: share for point, share in shares.items() if SPINE_BETWEEN[0] < share < SPINE_BETWEEN[1]}
        if not near:
            return None, WAIST[0]
        best = min(near, key=lambda point: abs(near[point] - WAIST[0]))
        return best, near[best]

    def add_head(self) -> tuple[int, ...]:
        """Add the head; return the spheres of the neck, none where no head is known."""
        shoulders = [self.point(f"{side}_{SHOULDER}") for side in SIDES]
        found = self._find_head(shoulders)
        if found is None:
            return ()
        joint, at, along, skull, across = found
        top = self.sphere(at, R_SKULL, along=(*along, skull))
        chin = self.sphere(at, R_CHIN, along=(*along, skull - CHIN), across=across)
        hips = [self.point(f"{side}_{HIP}") for side in SIDES]
        base = self.sphere((*shoulders, *hips), R_NECK, weights=NECK, inside=True)
        throat = self.sphere(at, R_THROAT, along=(*along, skull - CHIN), inside=True)
        self.add(joint, (top, chin))
        self.covered.update(path_up(self.skeleton, joint))
        near = NEAR_HEAD * self.height
        where = positions_at_zero(self.skeleton)
        for j in self._after(joint if joint not in self._face().values() else int(self.skeleton.parents[joint])):
            if np.linalg.norm(where[j] - where[joint]) < near or _is_of_face(self.skeleton.joint_names[j]):
                self.covered.add(j)
        return base, throat

    def _face(self) -> dict[str, int]:
        """Return joints at ears and nose by their names, of layouts that have them."""
        names = {name.lower(): j for j, name in enumerate(self.skeleton.joint_names)}
        return {name: names[name] for name in (*EARS, NOSE) if name in names}

    def _find_head(self, shoulders: list[int]) -> _Head | None:
        """Return where the head is, by its joint, its end or its middle, or by the ears; None if that is not known."""
        parents = self.skeleton.parents
        for mark, skull in ((HEAD, SKULL), (HEAD_TOP, -R_SKULL), (HEAD_CENTER, 0.0)):
            joint = self.joints.get(mark, -1)
            if joint < 0:
                continue
            top = self.joints.get(HEAD_TOP, -1)
            if mark == HEAD and top >= 0 and self._length(top):
                crown = min(self._length(top) / self.height, PROPORTIONS["head"])
                return _Head(joint, [joint + 1], ([joint + 1], [top + 1]), max(skull, crown - R_SKULL), None)
            above = joint
            while above >= 0 and not self._length(above):
                above = int(parents[above])
            before = int(parents[above]) if above >= 0 else -1
            start = [before + 1] if before >= 0 and before + 1 not in shoulders else shoulders
            return _Head(joint, [joint + 1], (start, [joint + 1]), skull, None)
        face = self._face()
        if not all(ear in face for ear in EARS):
            return None
        ears = [face[ear] + 1 for ear in EARS]
        across = (ears, [face[NOSE] + 1], NOSE_AHEAD) if NOSE in face else None
        return _Head(face.get(NOSE, face[EARS[0]]), ears, (shoulders, ears), EARS_UP, across)

    def add_rest(self) -> None:
        """Add thin links for the bones that are in no part, such as those to markers."""
        for j in range(self.skeleton.n_joints):
            if j not in self.covered and self._length(j):
                self._add_link(j, MARKER)
