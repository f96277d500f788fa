"""Layouts: which points a pose estimator or a sensor gives, in which order, and how they make a skeleton."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from skpose._typing import ArrayLike
from skpose._validation.numbers import as_numbers
from skpose._validation.positions import check_positions
from skpose.keypoints._keypoints import Keypoints
from skpose.keypoints._names import find_names
from skpose.keypoints._pictures import refuse_pictures
from skpose.keypoints._tables import TABLES
from skpose.keypoints._watch import warn_of_positions
from skpose.skeleton._shared import others, partners, sides

UPS = ("x", "y", "z", "-x", "-y", "-z")


@dataclass(frozen=True, repr=False)
class Layout:
    """The points of a pose estimator, a sensor, a set of markers or SMPL, and the tree of bones between them.

    Parameters
    ----------
    name : str
        Name of the layout.
    names : iterable of str
        Names of the points in the order of the array, each once. Names with a side, such as "left_hip" and
        "right_hip", make pairs.
    parents : mapping of str to str or None
        Parent of each point and of each midpoint; None for the root, of which there is one.
    midpoints : mapping of str to iterable of str, default={}
        Points that are not in the array, each the mean of two others or more; such as the pelvis between the hips, or
        amid four markers.
    rigid : iterable of str, default=()
        Points that are fixed to the frame of their parent, such as the hips to the pelvis and the ears to the nose.
        The bones of all others are ball joints.
    up : {"x", "y", "z", "-x", "-y", "-z"}, default="y"
        Direction of the array's axes that points up; "-y" where y points down, as in pictures.
    source : str, default=""
        Where the order of the points is stated.

    Attributes
    ----------
    points : tuple of str
        All points: those of the array, then the midpoints.
    root : str
        The point that is nobody's child.
    pairs : tuple of pairs of str
        Points of the left, each with its partner on the right, by their names.

    Raises
    ------
    ValueError
        For a name given twice, a parent or a part of a midpoint that is no point, a cycle, several roots, a layout in
        which every bone is rigid; the message names the point.

    See Also
    --------
    skpose.keypoints.layouts : The layouts that come with the library.
    skpose.keypoints.fit_skeleton : The skeleton of a layout that fits a person.

    Notes
    -----
    `dataclasses.replace` changes a layout: ``replace(layouts["coco17"], up="z")`` is COCO's where z points up.

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
        for argument in ("names", "rigid"):
            if isinstance(getattr(self, argument), str):
                raise TypeError(f"{argument} must be a sequence of names, got one string, {getattr(self, argument)!r}")
        for argument in ("parents", "midpoints"):
            if not isinstance(getattr(self, argument), Mapping):
                raise TypeError(
                    f"{argument} must be a mapping by name, such as {{'left_hip': 'pelvis'}}, got "
                    f"{type(getattr(self, argument)).__name__}"
                )
        for name, ends in dict(self.midpoints).items():
            if isinstance(ends, str):
                raise TypeError(f"midpoint {name!r} must be a sequence of names, got one string, {ends!r}")
        values = {
            "names": tuple(self.names),
            "parents": MappingProxyType(dict(self.parents)),
            "midpoints": MappingProxyType({name: tuple(ends) for name, ends in dict(self.midpoints).items()}),
            "rigid": frozenset(self.rigid),
        }
        for argument, value in values.items():
            object.__setattr__(self, argument, value)
        if self.up not in UPS:
            raise ValueError(f"up must be one of {', '.join(UPS)}, the direction that points up, got {self.up!r}")
        self._check_names()
        self._check_tree()

    def _check_names(self) -> None:
        points = self.points
        for name in points:
            if not isinstance(name, str) or not name:
                raise ValueError(f"layout {self.name!r}: names must be non-empty strings, got {name!r}")
            if points.count(name) > 1:
                raise ValueError(f"layout {self.name!r}: points must differ, got {name!r} {points.count(name)} times")
        known = set(self.names)
        for name, ends in self.midpoints.items():
            if len(ends) < 2 or len(set(ends)) != len(ends):
                raise ValueError(
                    f"layout {self.name!r}: midpoint {name!r} must be the mean of two points or more, each once, got "
                    f"{ends!r}"
                )
            for end in ends:
                if end not in known:
                    raise ValueError(
                        f"layout {self.name!r}: midpoint {name!r} is the mean of {', '.join(map(repr, ends))}, but "
                        f"{end!r} is neither among the names nor a midpoint before it"
                    )
            known.add(name)

    def _check_tree(self) -> None:
        points = set(self.points)
        for what, names in (("parents", set(self.parents)), ("rigid", self.rigid)):
            for name in sorted(names - points, key=str):
                raise ValueError(
                    f"layout {self.name!r}: {what} has {name!r}, which is no point; they are {', '.join(self.points)}"
                )
        for name in self.points:
            if name not in self.parents:
                raise ValueError(
                    f"layout {self.name!r}: parents must have every point, but {name!r} is missing; the root has None"
                )
            parent = self.parents[name]
            if parent is not None and parent not in points:
                raise ValueError(f"layout {self.name!r}: the parent of {name!r} is {parent!r}, which is no point")
        roots = [name for name in self.points if self.parents[name] is None]
        if len(roots) > 1:
            raise ValueError(
                f"layout {self.name!r}: one point must be the root, with the parent None, got {len(roots)}: "
                f"{', '.join(map(repr, roots))}"
            )
        for name in self.points:
            chain = [name]
            while (parent := self.parents[chain[-1]]) is not None:
                if parent in chain:
                    raise ValueError(f"layout {self.name!r}: cycle of parents: {' → '.join([*chain, parent])}")
                chain.append(parent)
        if points - self.rigid <= set(roots):
            raise ValueError(f"layout {self.name!r}: at least one point besides the root must not be rigid")

    @property
    def points(self) -> tuple[str, ...]:
        """All points: those of the array, then the midpoints."""
        return (*self.names, *self.midpoints)

    @property
    def root(self) -> str:
        """The point that is nobody's child."""
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

    def __reduce__(self) -> tuple:
        # A read-only view of a dictionary can be neither copied nor pickled: it is made again.
        arguments = (dict(self.parents), dict(self.midpoints), self.rigid, self.up, self.source)
        return Layout, (self.name, self.names, *arguments)

    def keypoints(
        self,
        positions: ArrayLike | Keypoints,
        frame_rate: float | None = None,
        confidences: ArrayLike | None = None,
        *,
        absent: Literal["refuse", "unseen"] = "refuse",
    ) -> Keypoints:
        """Return positions as keypoints of the layout, with its names, the midpoints among them.

        Parameters
        ----------
        positions : array-like of shape (n_frames, n_points, 3), or Keypoints
            Positions of ``layout.names``, m; NaN where a point is not seen. Points of keypoints are found by their
            names, in any order and spelling, others are left out; an array is in the order of the layout.
        frame_rate : float, default=None
            Frames per second of an array, Hz; keypoints have their own.
        confidences : array-like of shape (n_frames, n_points), default=None
            How sure each position of an array is, from 0, not seen, to 1; MediaPipe's visibility, OpenPose's score.
        absent : {"refuse", "unseen"}, default="refuse"
            What becomes of points that keypoints do not have: an error, or points that are seen in no frame. Other
            recordings of the person can show where they are, as the standing trial does for medial markers.

        Returns
        -------
        Keypoints
            Of ``layout.points``, with x, y or z up. A midpoint is seen where all of its points are, and is as sure as
            the least sure one; keypoints that have a point of its name keep theirs.

        Raises
        ------
        ValueError
            For positions in two dimensions, or of another number of points; the message names the layouts that have
            that number. For keypoints without a point of the layout, or none of all with ``absent="unseen"``, or
            with several that have its name but for the spelling.

        Warns
        -----
        UserWarning
            If points of an array are at exactly (0, 0, 0), as some programs write lost points: but for one that is
            there in every frame, as the pelvis of positions relative to it.
        UserWarning
            If x and y of nearly all points of an array are from 0 to 1, or no number is negative and all third numbers
            are up to 100: they may be those of a picture, the third ones scores.
        UserWarning
            If in nearly all frames of an array the head is not up from the feet along the axis of the layout, but along
            another one: people stand otherwise, or lie.

        Notes
        -----
        Where an axis points down the positions of an array are turned by half a turn: about x if y or z points down, so
        that (x, y, z) becomes (x, −y, −z), and about y if x does. Keypoints state themselves which axis points up.

        Of names that differ, those that are the same but for the case come first, such as Nose and nose. Then those of
        the same words: RBigToe and right_big_toe, ShoulderLeft and left_shoulder.

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
        if absent not in ("refuse", "unseen"):
            raise ValueError(f"absent must be 'refuse' or 'unseen', got {absent!r}")
        if isinstance(positions, Keypoints):
            if frame_rate is not None or confidences is not None:
                raise ValueError("keypoints have a frame rate and confidences: pass no others with them")
            return self._of_keypoints(positions, absent)
        if frame_rate is None:
            raise ValueError("frame_rate must be the frames per second of the positions, in Hz, got None")
        array, sure = self._check(positions, confidences)
        warn_of_positions(np.where(sure[:, :, None] > 0.0, array, np.nan), self.names, self.up, self.name)
        return self._of_array(array, sure, frame_rate)

    def _check(self, positions: ArrayLike, confidences: ArrayLike | None) -> tuple[np.ndarray, np.ndarray]:
        """Return positions (n, n_points, 3) and confidences (n, n_points) as arrays, or refuse them."""
        array = as_numbers(positions, "positions")
        self._check_shape(array)
        array = check_positions(array, len(self.names), "positions")
        refuse_pictures(array, self.names, "positions")
        sure = np.where(np.isnan(array).any(axis=2), 0.0, 1.0)
        if confidences is not None:
            sure = as_numbers(confidences, "confidences", masked=0.0)
        if sure.shape != array.shape[:2]:
            raise ValueError(f"confidences must have shape {array.shape[:2]}, one a position, got {sure.shape}")
        return array, sure

    def _of_array(self, array: np.ndarray, sure: np.ndarray, frame_rate: float) -> Keypoints:
        columns = {name: (array[:, i], sure[:, i]) for i, name in enumerate(self.names)}
        return self._of_columns(columns, frame_rate, self.up)

    def _of_keypoints(self, given: Keypoints, absent: str) -> Keypoints:
        found = find_names(self.names, given.names)
        # A midpoint "left_knee" of the points "L_knee" and "L_mknee" is not the first of these.
        others = [name for name in given.names if name not in found.values()]
        found |= find_names(self.midpoints, others)
        missing = [name for name in self.names if name not in found]
        if missing and (absent == "refuse" or not found):
            raise ValueError(
                f"the keypoints have no point named {missing[0]!r}, as the layout {self.name!r} has; their names are "
                f"{', '.join(given.names)}. Pass the layout that they are of, or {remedy_without(self, missing)}; or "
                'absent="unseen", if other recordings of the person show where these points are'
            )
        chosen = given.select(found.values())
        columns = {name: (chosen.positions[:, i], chosen.confidences[:, i]) for i, name in enumerate(found)}
        columns |= {name: (np.full((len(given), 3), np.nan), np.zeros(len(given))) for name in missing}
        return self._of_columns(columns, given.frame_rate, given.up)

    def _of_columns(self, columns: dict[str, tuple[np.ndarray, np.ndarray]], frame_rate: float, up: str) -> Keypoints:
        """Return keypoints of positions (n, 3) and confidences (n,) by name; midpoints that are not there are made."""
        for name, ends in self.midpoints.items():
            if name not in columns:
                parts, sure = zip(*(columns[end] for end in ends), strict=True)
                columns[name] = np.mean(parts, axis=0), np.min(sure, axis=0)
        array, confidences = (np.stack([columns[name][i] for name in self.points], axis=1) for i in (0, 1))
        if up.startswith("-"):
            array *= [-1.0, 1.0, -1.0] if up == "-x" else [1.0, -1.0, -1.0]
        axis: Any = up[-1]
        return Keypoints(array, self.points, frame_rate, confidences=confidences, up=axis)

    def _check_shape(self, array: np.ndarray) -> None:
        """Refuse arrays of another layout or in another form, with the remedy."""
        n = len(self.names)
        if array.ndim == 2 and array.shape[1] == 3 * n:
            raise ValueError(
                f"positions must have shape (n_frames, {n}, 3), got {array.shape}: pass positions.reshape(-1, {n}, 3)"
            )
        if array.ndim != 3:
            return
        if array.shape[2] == 4:
            raise ValueError(
                f"positions must have three coordinates for each point, got {array.shape}: if the fourth number is how "
                "sure each is, pass positions[..., :3] and confidences=positions[..., 3]"
            )
        if array.shape[1] != n and array.shape[2] in (2, 3):
            raise ValueError(
                f"positions have {array.shape[1]} points, and the layout {self.name!r} has {n}{self._suggest(array)}"
            )

    def _suggest(self, array: np.ndarray) -> str:
        """Return in words which layouts have as many points as an array."""
        if array.shape[1] == len(self.points):
            return f": it makes {', '.join(self.midpoints)} itself, so leave them out"
        likely = [f"layouts[{table.name!r}]" for table in TABLES if len(table.names) == array.shape[1]]
        return f": is it {' or '.join(likely)}?" if likely else ": make a Layout of your own for other points"

    def without(self, names: Iterable[str]) -> "Layout":
        """Return the layout without some points, such as those that are never seen.

        Children of a point that is left out become children of its parent. Keypoints are matched by name, so that those
        made by the whole layout fit the smaller one.

        Parameters
        ----------
        names : iterable of str
            Points to leave out.

        Returns
        -------
        Layout
            Without them.

        Raises
        ------
        KeyError
            For a name that no point has.
        ValueError
            For the root, or a part of a midpoint that stays.

        Examples
        --------
        >>> from skpose.keypoints import layouts
        >>> layouts["coco17"].without(["left_ear", "right_ear"])
        Layout('coco17', 15 points, root 'pelvis', y up)
        """
        out = {names} if isinstance(names, str) else set(names)
        unknown = sorted(out - set(self.points))
        if unknown:
            raise KeyError(f"layout {self.name!r} has no point {unknown[0]!r}; its points are {', '.join(self.points)}")
        if self.root in out:
            raise ValueError(f"layout {self.name!r}: {self.root!r} is the root, to which the other points are attached")
        parents, rigid = {}, set(self.rigid) - out
        for name in self.points:
            parent = self.parents[name]
            while parent in out:
                rigid -= {name} if parent not in self.rigid else set()
                parent = self.parents[parent]
            if name not in out:
                parents[name] = parent
        stay = tuple(name for name in self.names if name not in out)
        midpoints = {name: ends for name, ends in self.midpoints.items() if name not in out}
        return replace(self, names=stay, parents=parents, midpoints=midpoints, rigid=frozenset(rigid))


def name_points(layout: Layout, positions: ArrayLike, frame_rate: float, confidences: ArrayLike | None) -> Keypoints:
    """Return an array as keypoints of a layout; without the warnings of `Layout.keypoints`, for who warns otherwise."""
    return layout._of_array(*layout._check(positions, confidences), frame_rate)


def remedy_without(layout: Layout, missing: list[str]) -> str:
    """Return in words how to make a layout without points that are missing."""
    try:
        layout.without(missing)
    except ValueError:  # the root, or a part of a midpoint
        return "make a Layout of your own for the points that there are"
    return f"layout.without({missing})"
