"""Collections of motions with their labels."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from numbers import Integral
from typing import Any, Literal, get_args, overload

import numpy as np

from skpose._utils.typing import ArrayLike
from skpose._utils.validation import check_choice, check_kind
from skpose.kinematics._retarget import UNCHANGED, Method, retarget_and_report
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._rest import check_comparable, size_of

ONE_REST = 'Convert them to one rest pose: dataset.retarget(skeleton, method="orientations")'
ONE_RIG = 'dataset.retarget(skeleton, method="auto") converts motions of different rigs'
LARGEST_RATIO = 3.0  # of the sizes of people
LABELS = "subjects", "trials", "actions"
Rotations = Literal["rotvec", "file"]


class MotionDataset:
    """Motions of one or more subjects with their labels.

    A dataset is a sequence of motions: ``len(dataset)``, ``for motion in dataset``. ``dataset[0]`` is a motion;
    ``dataset[2:5]``, ``dataset[[0, 3]]`` and ``dataset[dataset.actions == "walk"]`` are datasets.

    Parameters
    ----------
    motions : sequence of Motion
        The motions.
    subjects, trials, actions : array-like of shape (n_motions,), default=None
        Labels of each motion, as strings: the person, the number of the recording, and the action.
    rotations : {"rotvec", "file"}, default="rotvec"
        "rotvec" converts joints of two or three Euler angles to ball joints, see `Motion.to_rotvec`, for which
        "spatial" and "angle" are more accurate. "file" keeps the angles of the files, and their joint limits, which
        ball joints do not have.

    Attributes
    ----------
    motions : tuple of Motion
        The motions.
    subjects, trials, actions : ndarray of shape (n_motions,) of str
        The labels; only if they were given.
    retargeting : tuple of str
        The method of `retarget` for each motion and its accuracy; "" if it was not retargeted. For example "same
        numbers"; "orientations, 23 of 30 joints, directions within 0°", with the number of joints that have
        counterparts; or "positions, 15 of 30 joints within 1.2 cm". "at rest: LeftHand" follows for joints that do not
        move.

    Raises
    ------
    ValueError
        If people differ threefold in size, as where one file is in centimetres; or for labels of another shape.

    Examples
    --------
    >>> from skpose.datasets import MotionDataset, make_gait
    >>> gait = make_gait(n_subjects=2, n_sequences=1, random_state=0)
    >>> gait
    MotionDataset(4 motions of 2 subjects: 2 run, 2 walk)
    >>> X, sequence = gait.poses(frame_rate=12)
    >>> y, groups = gait.actions[sequence], gait.subjects[sequence]
    >>> gait[gait.actions == "run"]
    MotionDataset(2 motions of 2 subjects: 2 run)
    >>> MotionDataset(gait.motions[:3])
    MotionDataset(3 motions)
    """

    subjects: np.ndarray
    trials: np.ndarray
    actions: np.ndarray

    def __init__(
        self,
        motions: Iterable[Motion],
        subjects: ArrayLike | None = None,
        trials: ArrayLike | None = None,
        actions: ArrayLike | None = None,
        *,
        rotations: Rotations = "rotvec",
    ):
        check_choice("rotations", rotations, get_args(Rotations))
        motions = tuple(motions)
        for i, motion in enumerate(motions):
            check_kind(motion, Motion, f"motions[{i}]", "load_motion reads one")
        _check_sizes(motions)
        self.motions = motions if rotations == "file" else tuple(motion.to_rotvec() for motion in motions)
        self.retargeting = ("",) * len(self.motions)
        for name, given in {"subjects": subjects, "trials": trials, "actions": actions}.items():
            if given is not None:
                values = np.asarray(given)
                if values.shape != (len(self),):
                    raise ValueError(f"{name} must have shape ({len(self)},), one per motion, got {values.shape}")
                if any(label is None or label != label for label in values.tolist()):
                    raise ValueError(f'{name} must not be missing; use ""')
                setattr(self, name, values.astype(str))

    def __len__(self) -> int:
        return len(self.motions)

    def __iter__(self) -> Iterator[Motion]:
        return iter(self.motions)

    @overload
    def __getitem__(self, chosen: int | np.integer) -> Motion: ...
    @overload
    def __getitem__(self, chosen: slice | Sequence | np.ndarray) -> "MotionDataset": ...
    def __getitem__(self, chosen: Any) -> "Motion | MotionDataset":
        if isinstance(chosen, bool | np.bool_):  # such as a list of labels == "walk"
            raise TypeError(f"motions are chosen by an index, a slice or an array of bool, got {chosen}")
        if isinstance(chosen, Integral):
            return self.motions[int(chosen)]
        if not isinstance(chosen, slice):
            chosen = np.asarray(chosen)
            chosen = chosen if chosen.size else chosen.astype(int)
        rows = np.arange(len(self))[chosen]
        return self._with([self.motions[row] for row in rows], rows)

    def __array__(self, *arguments: object, **options: object) -> np.ndarray:
        raise TypeError("a MotionDataset is not an array: pass dataset.poses()[0]")

    def __repr__(self) -> str:
        subjects = f" of {len(set(self.subjects))} subjects" if hasattr(self, "subjects") else ""
        words = f"{len(self)} motions{subjects}"
        if hasattr(self, "actions"):
            words += f": {_count(action or 'unnamed' for action in self.actions)}"
        methods = [report.partition(",")[0] for report in self.retargeting]
        if set(methods) - {"", UNCHANGED}:
            words += f"; retargeted by {_count(methods)}"
        return f"MotionDataset({words})"

    def _with(self, motions: Iterable[Motion], rows: Any = slice(None)) -> "MotionDataset":
        """Other motions with the same labels, or with those of some rows."""
        labels = {name: getattr(self, name)[rows] for name in LABELS if hasattr(self, name)}
        others = MotionDataset(motions, **labels, rotations="file")
        others.retargeting = tuple(np.array(self.retargeting, dtype=object)[rows])
        return others

    @cached_property
    def skeleton(self) -> Skeleton:
        """The bone-wise mean of the subjects' skeletons; poses are compared on it."""
        names: dict[Skeleton, str] = {}
        for i, motion in enumerate(self.motions):
            names.setdefault(motion.skeleton, f"motions[{i}]")
        check_comparable(list(names), list(names.values()), ONE_REST, ONE_RIG)
        return Skeleton.mean(names)

    def select(self, joints: str | Iterable[str] | None = None, *, drop: str | Iterable[str] = ()) -> "MotionDataset":
        """Select joints of all motions, see `Skeleton.select`.

        Parameters
        ----------
        joints : str or iterable of str, default=None
            Joints to keep, with all joints between them and the root; None keeps all.
        drop : str or iterable of str, default=()
            Joints to remove, each with all joints below it.

        Returns
        -------
        MotionDataset
            With the same labels.

        Examples
        --------
        >>> from skpose.datasets import make_gait
        >>> gait = make_gait(n_subjects=2, n_sequences=1, random_state=0)
        >>> gait.select(drop=["left_pelvis", "right_pelvis"]).skeleton
        Skeleton(n_joints=12, n_dofs=32)
        """
        return self._with([motion.select(joints, drop=drop) for motion in self.motions])

    def retarget(
        self,
        skeleton: Skeleton | Motion,
        *,
        method: Method = "numbers",
        joints: Mapping[str, str | None] | Sequence[Mapping[str, str | None] | None] | None = None,
        scale: float | Literal["lengths"] | None = None,
        joint_limits: Literal["ignore", "enforce"] = "ignore",
        n_jobs: int | None = None,
        verbose: int = 0,
    ) -> "MotionDataset":
        """Retarget all motions to one skeleton, see `skpose.kinematics.retarget`.

        `retargeting` states the method for each motion and its accuracy.

        Parameters
        ----------
        skeleton : Skeleton or Motion
            The target skeleton, or a motion on it, whose joints the motions get: ``skeleton.to_rotvec()`` for ball
            joints.
        method : {"numbers", "orientations", "positions", "auto", "unchecked"}, default="numbers"
            How poses are converted, see `skpose.kinematics.retarget`.
        joints : mapping of str to str, or sequence of such, default=None
            The counterparts of joints of `skeleton` in the motions, or a sequence with one mapping per motion; the
            others are found as by `skpose.kinematics.find_counterparts`.
        scale : float or "lengths", default=None
            Factor for positions in the world; None is the ratio of the lengths of people's legs, or 1.
        joint_limits : {"ignore", "enforce"}, default="ignore"
            Whether angles are kept inside ``skeleton.limits``.
        n_jobs : int, default=None
            Threads of "positions"; None is 1 unless in a ``joblib.parallel_config`` context, -1 uses all processors.
        verbose : int, default=0
            Whether "positions" shows progress.

        Returns
        -------
        MotionDataset
            With the same labels.

        Examples
        --------
        >>> from skpose.datasets import make_gait
        >>> gait = make_gait(n_subjects=2, n_sequences=1, random_state=0)
        >>> gait = gait.retarget(gait.motions[0].skeleton, method="orientations")
        >>> len({motion.skeleton for motion in gait})
        1
        >>> gait.retargeting[0]
        'orientations, 22 of 22 joints, directions within 0°'
        """
        if joints is None or isinstance(joints, Mapping):
            joints = [joints] * len(self)
        if len(joints) != len(self):
            raise ValueError(f"joints must have one mapping for each of the {len(self)} motions, got {len(joints)}")
        motions, reports = [], []
        for i, (motion, counterparts) in enumerate(zip(self.motions, joints, strict=True)):
            try:
                result = retarget_and_report(
                    motion, skeleton, method, counterparts, scale, joint_limits, n_jobs, verbose
                )
            except ValueError as error:
                raise ValueError(f"motions[{i}]: {error}") from None
            motions.append(result[0])
            unchanged = result[1] == UNCHANGED and self.retargeting[i]
            reports.append(unchanged or result[1])
        there = self._with(motions)
        there.retargeting = tuple(reports)
        return there

    def with_root(
        self, part: Literal["tilt", "whole"] = "tilt", *, up: Literal["x", "y", "z"] | None = None
    ) -> "MotionDataset":
        """Add the orientation of the root to the poses, see `Motion.with_root`.

        Motions with different up axes raise a ValueError unless `up` is given.

        Parameters
        ----------
        part : {"tilt", "whole"}, default="tilt"
            "tilt" ignores the rotation about the vertical, "whole" is the orientation in the world.
        up : {"x", "y", "z"}, default=None
            The axis of the world that points up; None takes it from the motions.

        Returns
        -------
        MotionDataset
            With the same labels.

        Examples
        --------
        >>> from skpose.datasets import make_gait
        >>> gait = make_gait(n_subjects=2, n_sequences=1, random_state=0)
        >>> gait.with_root("tilt").skeleton.n_dofs - gait.skeleton.n_dofs
        3
        """
        for i, motion in enumerate(self.motions):
            if up is None and motion.up != self.motions[0].up:
                raise ValueError(f'motions[0] has "{self.motions[0].up}" up and motions[{i}] "{motion.up}": pass up')
        return self._with(motion.with_root(part, up=up) for motion in self)

    def poses(
        self,
        frame_rate: float | None = None,
        skeleton: Skeleton | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Collect all poses in one array, on one skeleton.

        Parameters
        ----------
        frame_rate : float, default=None
            New frame rate, Hz, see `Motion.resample`; None takes every frame.
        skeleton : Skeleton, default=None
            Skeleton whose dofs are the columns; None is the mean skeleton of the subjects.

        Returns
        -------
        X : ndarray of shape (n_poses, n_dofs)
            Joint angles, rad.
        sequence : ndarray of shape (n_poses,)
            Index of the motion of each pose; ``dataset.actions[sequence]`` has the labels.

        Raises
        ------
        ValueError
            If the skeletons differ in joints, parents or dofs, or the rest directions of a bone by more than 45°.
        """
        if not len(self):
            raise ValueError("the dataset has no motions")
        skeleton = self.skeleton if skeleton is None else skeleton
        motions = list(self.retarget(skeleton, method="numbers").motions)
        if frame_rate is not None:
            motions = [motion.resample(frame_rate) for motion in motions]
        sequence = np.repeat(np.arange(len(motions)), [len(motion) for motion in motions])
        return np.concatenate([motion.angles for motion in motions]), sequence


def _check_sizes(motions: Sequence[Motion]) -> None:
    """Refuse motions of people who differ so much in size that they must be in different units."""
    first = {id(motion.skeleton): i for i, motion in reversed([*enumerate(motions)])}
    sizes = {i: size_of(motions[i].skeleton) for i in first.values()}
    small, large = min(sizes, key=sizes.__getitem__, default=0), max(sizes, key=sizes.__getitem__, default=0)
    if sizes and sizes[large] > LARGEST_RATIO * sizes[small] > 0.0:
        names = f"motions[{large}] is {sizes[large]:.3g} m from end to end and motions[{small}] {sizes[small]:.3g} m"
        raise ValueError(f"{names}: expected one unit of length, see scale of the readers")


def _count(words: Iterable[str]) -> str:
    """How often each word occurs, the first five in alphabetical order."""
    names, counts = np.unique(list(words), return_counts=True)
    more = f" and {len(names) - 5} more actions" if len(names) > 5 else ""
    return ", ".join(f"{count} {name}" for name, count in zip(names[:5], counts[:5], strict=True)) + more
