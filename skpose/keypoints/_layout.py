"""Layouts: the points of a pose estimator or a sensor, their order, and the bones between them."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np

from skpose._utils.typing import ArrayLike
from skpose._utils.validation import check_choice
from skpose._utils.warnings import warn
from skpose.keypoints._checks import UPS, complaints_of, turn_up
from skpose.keypoints._keypoints import Keypoints
from skpose.skeleton._sides import others, partners, sides

# --- joint centres ----------------------------------------------------------------------------------------------------
# From markers: of hips by regression, of knees and ankles by their widths.


HARRINGTON, DAVIS = HIPS = "harrington", "davis"
# Distance of the centre from the marker: half a width of 10.5 or 7 cm and the radius, as a share of 42 cm.
WIDTHS = {"davis_knee": 0.142, "davis_ankle": 0.1}
RULES = (*HIPS, *WIDTHS)
BETA, THETA = np.radians(18.0), np.radians(28.4)  # Davis: angles of the hip in the sagittal and the frontal plane
RADIUS = 0.007  # m, of a marker


def hip_center(rule: str, side: str, markers: Sequence[np.ndarray]) -> np.ndarray:
    """The centre (n, 3) of a hip, m.

    Markers (n, 3) are the ASIS and the other side's, the PSIS and the other side's, and for Davis those of knee and
    ankle, up to which the leg is measured from the ASIS. Axes are ahead, up and outward from the middle of the ASIS.
    """
    asis, other, psis, other_psis, *leg = markers
    origin = (asis + other) / 2.0
    ahead, outward = origin - (psis + other_psis) / 2.0, asis - other
    depth, width = (np.linalg.norm(line, axis=1, keepdims=True) for line in (ahead, outward))
    outward = outward / width
    ahead = ahead - (ahead * outward).sum(axis=1, keepdims=True) * outward
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    up = np.cross(ahead, outward) if side == "left" else np.cross(outward, ahead)
    place = -0.24 * depth - 0.0099, -0.30 * width - 0.0109, 0.33 * width + 0.0073
    if rule == DAVIS:
        lengths = sum(np.linalg.norm(b - a, axis=1) for a, b in pairwise([asis, *leg]))
        length = np.ma.median(np.ma.masked_invalid(lengths))
        c, trochanter = 0.115 * length - 0.0153, 0.1288 * length - 0.04856 + RADIUS
        place = (
            c * np.cos(THETA) * np.sin(BETA) - trochanter * np.cos(BETA),
            -c * np.cos(THETA) * np.cos(BETA) - trochanter * np.sin(BETA),
            width / 2.0 - c * np.sin(THETA),
        )
    return np.ma.filled(origin + place[0] * ahead + place[1] * up + place[2] * outward, np.nan)


def center_of_width(rule: str, above: np.ndarray, marker: np.ndarray, wand: np.ndarray | None = None) -> np.ndarray:
    """The centre (n, 3) of a knee or an ankle, m, inward from the marker at its outer side; the marker without a wand.

    It is in the plane of the joint above, the marker and the wand, which is on the segment. At the centre, the lines to
    the joint above and to the marker are at a right angle.
    """
    if wand is None:
        return marker
    line, share = above - marker, WIDTHS[rule]
    length = np.linalg.norm(line, axis=1, keepdims=True)
    outward = wand - marker
    outward = outward - (outward * line).sum(axis=1, keepdims=True) / length**2 * line
    outward = outward / np.linalg.norm(outward, axis=1, keepdims=True)
    return marker + share**2 * line - share * np.sqrt(1.0 - share**2) * length * outward


# --- names ------------------------------------------------------------------------------------------------------------


WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
SIDES = {"l": "left", "left": "left", "r": "right", "right": "right"}


def find_names(wanted: Iterable[str], names: Sequence[str]) -> dict[str, str]:
    """The name that matches each wanted name in another spelling; wanted names without a match are left out.

    An equal name comes first, then one that differs in case, then one with the same words: case and separators are
    ignored, L is left and R is right, and a side may be anywhere. Several matches raise a ValueError.
    """
    found = {}
    for name in wanted:
        for spelling in (str, str.casefold, _words):
            same = [other for other in names if spelling(other) == spelling(name)]
            if len(same) > 1:
                raise ValueError(f"the point {name!r} may be {' or '.join(map(repr, same))}: rename one of them")
            if same:
                found[name] = same[0]
                break
    return found


def _words(name: str) -> tuple[str, str]:
    """The side and the other words of a name; no side if it has several."""
    words = [word.lower() for word in WORD.findall(name)]
    sides = [SIDES[word] for word in words if word in SIDES]
    if len(sides) != 1:
        return "", "".join(words)
    return sides[0], "".join(word for word in words if word not in SIDES)


# --- layout -----------------------------------------------------------------------------------------------------------


BENDS = "knee", "kne", "kjc", "femur", "elb", "ejc", "humerus"  # in names of points between two long bones


@dataclass(frozen=True, repr=False)
class Layout:
    """The points of a pose estimator, a sensor or a marker set, and the tree of bones between them.

    Parameters
    ----------
    name : str
        Name of the layout.
    names : iterable of str
        Names of the points in the order of the array, each once. Names with a side, such as "left_hip" and
        "right_hip", make pairs.
    parents : mapping of str to str or None
        Parent of each point and of each midpoint; None for the only root.
    midpoints : mapping of str to iterable of str, default={}
        Points that are not in the array, each the mean of two or more others, such as the pelvis between the hips, or a
        joint centre by a rule. Hips: ("harrington", ASIS, other ASIS, PSIS, other PSIS) [1]_, where "other" is of the
        other side, or ("davis", the same, knee marker, ankle marker) [2]_. Knees and ankles: ("davis_knee", hip, knee
        marker, thigh wand) and ("davis_ankle", knee, ankle marker, shank wand) [2]_, half a joint's width inward: 14 %
        and 10 % of the length of the segment.
    rigid : iterable of str, default=()
        Points that are fixed to their parent, such as the hips to the pelvis and the ears to the nose. The bones of all
        others are ball joints.
    up : {"x", "y", "z", "-x", "-y", "-z"}, default="y"
        Axis of the array that points up; "-y" if y points down, as in pictures.
    source : str, default=""
        Source of the order of the points.

    Attributes
    ----------
    points : tuple of str
        All points: the array's, then the midpoints.
    root : str
        The point without a parent.
    pairs : tuple of pairs of str
        Points of the left, each with its partner on the right, by their names.

    Raises
    ------
    ValueError
        For duplicate names, an unknown parent or part of a midpoint, a cycle, several roots, and if all bones are
        rigid.

    See Also
    --------
    skpose.keypoints.layouts : The layouts that come with the library.
    skpose.keypoints.fit_skeleton : The skeleton of a layout that fits a person.

    Notes
    -----
    `dataclasses.replace` changes a layout: ``replace(layouts["coco17"], up="z")`` is COCO's with z up.

    References
    ----------
    .. [1] M. E. Harrington, A. B. Zavatsky, S. E. M. Lawson, Z. Yuan, T. N. Theologis, "Prediction of the hip joint
       centre in adults, children, and patients with cerebral palsy based on magnetic resonance imaging", J. Biomech.
       40(3), 2007, :doi:`10.1016/j.jbiomech.2006.02.003`.
    .. [2] R. B. Davis, S. Õunpuu, D. Tyburski, J. R. Gage, "A gait analysis data collection and reduction technique",
       Human Movement Science 10(5), 1991, :doi:`10.1016/0167-9457(91)90046-Z`.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose.keypoints import Layout
    >>> arm = Layout(
    ...     "arm",
    ...     names=["shoulder", "elbow", "wrist"],
    ...     parents={"shoulder": None, "elbow": "shoulder", "wrist": "elbow"},
    ... )
    >>> arm
    Layout('arm', 3 points, root 'shoulder', y up)
    >>> arm.keypoints(np.zeros((10, 3, 3)), frame_rate=25)
    Keypoints(10 frames at 25 Hz, 0.4 s, 3 points)
    """

    name: str
    names: tuple[str, ...]
    parents: Mapping[str, str | None] = field(hash=False)
    midpoints: Mapping[str, tuple[str, ...]] = field(default_factory=dict, hash=False)
    rigid: frozenset[str] = frozenset()
    up: Literal["x", "y", "z", "-x", "-y", "-z"] = "y"
    source: str = ""

    if TYPE_CHECKING:

        def __init__(
            self,
            name: str,
            names: Iterable[str],
            parents: Mapping[str, str | None],
            midpoints: Mapping[str, Iterable[str]] = ...,
            rigid: Iterable[str] = (),
            up: Literal["x", "y", "z", "-x", "-y", "-z"] = "y",
            source: str = "",
        ) -> None: ...

    def __post_init__(self) -> None:
        for name, value in {
            "names": tuple(self.names),
            "parents": dict(self.parents),
            "midpoints": {name: tuple(ends) for name, ends in self.midpoints.items()},
            "rigid": frozenset(self.rigid),
        }.items():
            object.__setattr__(self, name, value)
        check_choice("up", self.up, UPS)
        points, layout = set(self.points), f"layout {self.name!r}"
        if len(points) < len(self.points) or not all(isinstance(name, str) and name for name in points):
            raise ValueError(f"{layout}: points must be different, non-empty strings, got {self.points}")
        known = set(self.names)
        for name, (_, ends) in self._parts.items():
            if len(set(ends)) < 2 or not set(ends) <= known:
                absent = ", ".join(map(repr, sorted(set(ends) - known, key=str))) or "another point"
                raise ValueError(f"{layout}: midpoint {name!r} of {ends} needs {absent}")
            known.add(name)
        if set(self.parents) != points or not self.rigid <= points:
            wrong = sorted((set(self.parents) ^ points) | (self.rigid - points), key=str)
            raise ValueError(f"{layout}: parents must have every point, and rigid only points; see {wrong}")
        roots = [name for name in self.points if self.parents[name] is None]
        if len(roots) != 1:
            raise ValueError(f"{layout}: one point must be the root, with the parent None, got {roots}")
        reached = list(roots)
        for name in reached:
            reached += [child for child, parent in self.parents.items() if parent == name]
        if unknown := sorted(points - set(reached)):
            raise ValueError(f"{layout}: the parents of {unknown} are unknown or make a cycle")
        if points - self.rigid <= set(roots):
            raise ValueError(f"{layout}: at least one point besides the root must not be rigid")

    @property
    def points(self) -> tuple[str, ...]:
        """All points: the array's, then the midpoints."""
        return (*self.names, *self.midpoints)

    @property
    def _parts(self) -> dict[str, tuple[str, tuple[str, ...]]]:
        """The rule of each midpoint, "" for the mean, and the points that it is computed from."""
        return {
            name: (ends[0], ends[1:]) if ends and ends[0] in RULES else ("", ends)
            for name, ends in self.midpoints.items()
        }

    @property
    def root(self) -> str:
        """The point without a parent."""
        return next(name for name, parent in self.parents.items() if parent is None)

    @property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """Points of the left, each with its partner on the right, by their names."""
        paired = [name for name in self.points if any(other in self.points for other in others(name))]
        found = zip(paired, sides(paired), partners(paired), strict=True)
        return tuple((name, paired[other]) for name, side, other in found if side == "left")

    def __repr__(self) -> str:
        up = f"{self.up} up" if len(self.up) == 1 else f"{self.up[1]} down"
        return f"Layout({self.name!r}, {len(self.names)} points, root {self.root!r}, {up})"

    def keypoints(
        self,
        positions: ArrayLike | Keypoints,
        frame_rate: float | None = None,
        confidences: ArrayLike | None = None,
        *,
        absent: Literal["refuse", "unseen"] = "refuse",
    ) -> Keypoints:
        """Convert positions to keypoints of the layout, with its names and midpoints.

        Parameters
        ----------
        positions : array-like of shape (n_frames, n_points, 3), or Keypoints
            Positions of ``layout.names``, m; NaN if a point is not seen. An array is in the order of the layout; points
            of keypoints are found by name, in any order and spelling, and others are left out.
        frame_rate : float, default=None
            Frames per second of an array, Hz; keypoints have their own.
        confidences : array-like of shape (n_frames, n_points), default=None
            Confidence of each position of an array, from 0, not seen, to 1: MediaPipe's visibility, OpenPose's score.
        absent : {"refuse", "unseen"}, default="refuse"
            What to do with points that keypoints lack: raise an error, or add them as never seen. Another recording may
            show them, such as the standing trial for medial markers.

        Returns
        -------
        Keypoints
            Of ``layout.points``, with x, y or z up. A midpoint is seen if all of its points are, and has the least of
            their confidences; keypoints that have a point of its name keep theirs.

        Raises
        ------
        ValueError
            For positions in two dimensions, or with another number of points. For keypoints without a point of the
            layout, or without any with ``absent="unseen"``, or with several whose names differ in spelling only.

        Warns
        -----
        UserWarning
            For arrays, as `Keypoints`: points at exactly (0, 0, 0), units of a picture, another axis up.

        Notes
        -----
        If an axis points down, the positions of an array are rotated by half a turn: about x if y or z points down, so
        that (x, y, z) becomes (x, −y, −z), and about y if x does. Keypoints have their own up axis.

        Names match if they are equal, then if they differ in case, such as Nose and nose, then if they have the same
        words: RBigToe and right_big_toe, ShoulderLeft and left_shoulder.

        Examples
        --------
        >>> import numpy as np
        >>> from skpose.keypoints import Keypoints, layouts
        >>> seen = layouts["coco17"].keypoints(np.random.default_rng(0).normal(size=(5, 17, 3)), frame_rate=30)
        >>> seen.names[-2:]
        ('pelvis', 'neck')
        >>> names = [name.upper() for name in layouts["coco17"].names]
        >>> found = layouts["coco17"].keypoints(Keypoints(seen.positions[:, :17], names, frame_rate=30))
        >>> bool((found.positions == seen.positions).all())
        True
        """
        check_choice("absent", absent, ("refuse", "unseen"))
        if isinstance(positions, Keypoints):
            if frame_rate is not None or confidences is not None:
                raise ValueError("frame_rate and confidences must be None for keypoints, which have their own")
            return self._of_keypoints(positions, positions.up, absent)
        if frame_rate is None:
            raise ValueError("frame_rate must be the frames per second of the positions, in Hz, got None")
        given = Keypoints(positions, self.names, frame_rate, confidences)
        why = f"as the layout {self.name!r} says"
        for complaint in complaints_of(given.positions, self.names, self.up, why, "dataclasses.replace(layout, up={})"):
            warn(complaint)
        return self._of_keypoints(given, self.up, absent)

    def _of_keypoints(self, given: Keypoints, up: str, absent: str) -> Keypoints:
        found = find_names(self.names, given.names)
        # Not from among all names: the midpoint "left_knee" is not the point "L_knee".
        found |= find_names(self.midpoints, [name for name in given.names if name not in found.values()])
        missing = [name for name in self.names if name not in found]
        if missing and (absent == "refuse" or not found):
            raise ValueError(
                f"keypoints have no {missing[0]!r} of {self.name!r}: use layout.without({missing}), absent='unseen' or "
                "a Layout of your own"
            )
        chosen = given.select(found.values())
        columns = {name: (chosen.positions[:, i], chosen.confidences[:, i]) for i, name in enumerate(found)}
        columns |= {name: (np.full((len(given), 3), np.nan), np.zeros(len(given))) for name in missing}
        for (name, (rule, ends)), side in zip(self._parts.items(), sides(list(self.midpoints)), strict=True):
            if name not in columns:
                parts, confidence = zip(*(columns[end] for end in ends), strict=True)
                if rule in HIPS:
                    place = hip_center(rule, side, parts)
                else:
                    place = center_of_width(rule, *parts) if rule else np.mean(parts, axis=0)
                columns[name] = place, np.min(confidence, axis=0)
        array, confidences = (np.stack([columns[name][i] for name in self.points], axis=1) for i in (0, 1))
        array, axis = turn_up(array, up)
        return Keypoints(array, self.points, given.frame_rate, confidences=confidences, up=axis)

    def without(self, names: Iterable[str]) -> "Layout":
        """Remove points from the layout, such as points that are never seen.

        Children of a removed point become children of its parent. Keypoints are matched by name, so keypoints of the
        whole layout fit the smaller one. Without one of the wands, all knees and ankles are at their markers.

        Parameters
        ----------
        names : iterable of str
            Points to remove.

        Returns
        -------
        Layout
            Without them.

        Raises
        ------
        KeyError
            For an unknown name.
        ValueError
            For the root, a part of a remaining midpoint, or a knee or an elbow before a point that remains, as an ankle
            is at no constant distance from the hip.

        Examples
        --------
        >>> from skpose.keypoints import layouts
        >>> layouts["coco17"].without(["left_ear", "right_ear"])
        Layout('coco17', 15 points, root 'pelvis', y up)
        """
        out = {names} if isinstance(names, str) else set(names)
        unknown = sorted(out - set(self.points))
        if unknown:
            raise KeyError(f"layout {self.name!r} has no point {unknown[0]!r}: see layout.points")
        if self.root in out:
            raise ValueError(f"layout {self.name!r}: {self.root!r} is the root and cannot be removed")
        parents, rigid = {}, set(self.rigid) - out
        for name in (one for one in self.points if one not in out):
            parent = self.parents[name]
            while parent in out:
                if not {name, parent} & self.rigid and any(word in str(parent).lower() for word in BENDS):
                    raise ValueError(
                        f"layout {self.name!r}: {name!r} cannot be without {parent!r}, where the limb bends"
                    )
                rigid -= {name} if parent not in self.rigid else set()
                parent = self.parents[parent]
            parents[name] = parent
        stay = tuple(name for name in self.names if name not in out)
        midpoints = {name: ends for name, ends in self.midpoints.items() if name not in out}
        if any(ends[0] in WIDTHS and out.intersection(ends[3:]) for ends in midpoints.values()):
            midpoints = {name: ends[:3] if ends[0] in WIDTHS else ends for name, ends in midpoints.items()}
        return replace(self, names=stay, parents=parents, midpoints=midpoints, rigid=frozenset(rigid))


# --- table ------------------------------------------------------------------------------------------------------------
# Layouts from tables: the points, their parents, and the source.
#
# A table has a row for each point of the array, in its order, and then one for each midpoint: name, parent, whether
# the point is rigid. Names follow the source in snake case; OpenPose, Kinect and Pose2Sim names have their sides
# first, and marker names are as in files, with the letters of both sides in capitals.


RIGID = True
Row = tuple[str, str | None] | tuple[str, str | None, bool]


def layout_of(
    name: str,
    rows: tuple[Row, ...],
    source: str,
    up: Literal["y", "z", "-y"] = "y",
    midpoints: Mapping[str, tuple[str, ...]] = {},
) -> Layout:
    return Layout(
        name,
        names=[row[0] for row in rows if row[0] not in midpoints],
        parents={row[0]: row[1] for row in rows},
        midpoints=midpoints,
        rigid=[row[0] for row in rows if row[2:] == (RIGID,)],
        up=up,
        source=source,
    )
