"""Collections of motions with their labels."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from operator import index
from typing import Any, Literal, NoReturn, overload

import numpy as np

from skpose._typing import ArrayLike
from skpose._validation.motions import check_frame_rate
from skpose.kinematics._shared import UNCHANGED, Method, retarget_and_report
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import check_comparable, foldable_table

MISSING = ("None", "nan", "<NA>", "NaT")  # as strings, what numpy and pandas have in the place of a missing label
ONE_REST = (
    'Convert the motions to one rest pose first: dataset.retarget(dataset.motions[0].skeleton, method="orientations") '
    'keeps the directions of the bones in the world, method="unchecked" the numbers'
)
ONE_RIG = 'dataset.retarget(skeleton, method="auto") converts motions of different rigs'


class MotionDataset:
    """Motions of one or more subjects, with the labels that they have.

    It is a sequence of motions: ``len(dataset)``, ``for motion in dataset``. ``dataset[0]`` is a motion;
    ``dataset[2:5]``, ``dataset[[0, 3]]`` and ``dataset[dataset.actions == "walk"]`` are datasets.

    Parameters
    ----------
    motions : sequence of Motion
        One for each sequence.
    subjects, trials, actions : array-like of shape (n_motions,), default=None
        Labels of each motion, as strings: the person, the number of the recording, and the action. None are unknown:
        the attribute then raises an AttributeError that says so.

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

    def __init__(
        self,
        motions: Iterable[Motion],
        subjects: ArrayLike | None = None,
        trials: ArrayLike | None = None,
        actions: ArrayLike | None = None,
    ):
        if isinstance(motions, Motion):
            raise TypeError("motions must be a sequence of Motions, got a Motion: put it into a list")
        self._motions = tuple(motions)
        for i, motion in enumerate(self._motions):
            if not isinstance(motion, Motion):
                raise TypeError(f"motions[{i}] must be a skpose.Motion, got {type(motion).__name__}")
        self._retargeting = ("",) * len(self._motions)
        self._labels: dict[str, np.ndarray] = {}
        for name, given in {"subjects": subjects, "trials": trials, "actions": actions}.items():
            if given is None:
                continue
            values = np.asarray(given)
            missing = [
                i for i, label in enumerate(values.tolist()) if not isinstance(label, str) and str(label) in MISSING
            ]
            if missing:
                raise ValueError(
                    f'{name} has no label for motions[{missing[0]}], but {values[missing[0]]!r}: use a word, such as ""'
                )
            labels = np.asarray(values, dtype=str)  # a series of polars makes no strings of numbers
            if labels.shape != (len(self),):
                raise ValueError(
                    f"{name} must have one label for each of the {len(self)} motions, got shape {labels.shape}"
                )
            self._labels[name] = labels

    @property
    def motions(self) -> tuple[Motion, ...]:
        """The motions."""
        return self._motions

    @property
    def subjects(self) -> np.ndarray:
        """The person of each motion."""
        return self._label("subjects")

    @property
    def trials(self) -> np.ndarray:
        """The number of the recording of each motion."""
        return self._label("trials")

    @property
    def actions(self) -> np.ndarray:
        """The action of each motion."""
        return self._label("actions")

    @property
    def retargeting(self) -> tuple[str, ...]:
        """The method by which `retarget` brought each motion onto its skeleton, and how near; "" where it did not.

        "same numbers"; "orientations, 23 of 30 joints, directions within 0°", with the number of joints that have
        counterparts, and the largest angle between a bone and its counterpart; or "positions, 15 of 30 joints within
        1.2 cm", with the number of joints that have one at the same place, and the largest distance from it. "at rest:
        LeftHand, RightHand" follows where joints do not move, and what they carry keeps its rest pose.
        """
        return self._retargeting

    def _label(self, name: str) -> np.ndarray:
        if name not in self._labels:
            raise AttributeError(
                f"the dataset has no {name}: pass one label for each motion, MotionDataset(motions, {name}=...)"
            )
        return self._labels[name]

    def __len__(self) -> int:
        return len(self.motions)

    def __iter__(self) -> Iterator[Motion]:
        return iter(self.motions)

    @overload
    def __getitem__(self, chosen: int | np.integer) -> Motion: ...
    @overload
    def __getitem__(self, chosen: slice | Sequence | np.ndarray) -> "MotionDataset": ...
    def __getitem__(self, chosen: Any) -> "Motion | MotionDataset":
        if isinstance(chosen, bool | np.bool_) or not hasattr(chosen, "__index__") or np.ndim(chosen):
            rows = np.arange(len(self))[chosen] if isinstance(chosen, slice) else self._rows(np.asarray(chosen), chosen)
            labels = {name: labels[rows] for name, labels in self._labels.items()}
            chosen_ones = MotionDataset([self.motions[row] for row in rows], **labels)
            chosen_ones._retargeting = tuple(self._retargeting[row] for row in rows)
            return chosen_ones
        i = index(chosen)
        if not -len(self) <= i < len(self):
            raise IndexError(f"the dataset has {len(self)} motions, and no motion {i}")
        return self.motions[i]

    def __array__(self, *arguments: object, **options: object) -> NoReturn:
        raise TypeError("a MotionDataset is no array: pass its poses, dataset.poses()[0]")

    def __repr__(self) -> str:
        subjects = f" of {len(set(self.subjects))} subjects" if "subjects" in self._labels else ""
        words = f"{len(self)} motions{subjects}"
        if "actions" in self._labels:
            words += f": {_count(action or 'unnamed' for action in self.actions)}"
        methods = [report.partition(",")[0] for report in self._retargeting]
        if set(methods) - {"", UNCHANGED}:
            words += f"; retargeted by {_count(methods)}{_fewest_joints(self._retargeting)}"
        return f"MotionDataset({words})"

    def _repr_html_(self) -> str:
        """Return the motions as a table, which a notebook shows."""
        columns: dict[str, list] = {"motion": list(range(len(self)))}
        columns |= {name.removesuffix("s"): labels.tolist() for name, labels in self._labels.items()}
        columns["frames"] = [len(motion) for motion in self]
        columns["frame rate, Hz"] = [f"{motion.frame_rate:g}" for motion in self]
        columns["duration, s"] = [f"{len(motion) / motion.frame_rate:.1f}" for motion in self]
        columns["joints"] = [motion.skeleton.n_joints for motion in self]
        if any(self._retargeting):
            columns["retargeted by"] = list(self._retargeting)
        return foldable_table(repr(self), columns)

    def _with(self, motions: Iterable[Motion]) -> "MotionDataset":
        """Return other motions with the same labels."""
        others = MotionDataset(motions, **self._labels)
        others._retargeting = self._retargeting
        return others

    @cached_property
    def skeleton(self) -> Skeleton:
        """The bone-wise mean of the subjects' skeletons, each counted once, on which their poses are compared."""
        names: dict[Skeleton, str] = {}
        for i, motion in enumerate(self.motions):
            names.setdefault(motion.skeleton, f"motions[{i}]")
        check_comparable(list(names), list(names.values()), ONE_REST, ONE_RIG)
        return Skeleton.mean(names)

    def select(self, joints: str | Iterable[str] | None = None, *, drop: str | Iterable[str] = ()) -> "MotionDataset":
        """Return the motions of some joints, and of those that carry them, see `Skeleton.select`.

        ``dataset[...]`` takes some of the motions.

        Parameters
        ----------
        joints : str or iterable of str, default=None
            Joints to keep, with all between them and the root; None keeps all.
        drop : str or iterable of str, default=()
            Joints to leave out, each with all that it carries.

        Returns
        -------
        MotionDataset
            With the same labels.

        Examples
        --------
        >>> from skpose.datasets import make_gait
        >>> gait = make_gait(n_subjects=2, n_sequences=1, random_state=0)
        >>> gait.select(drop=["left_pelvis", "right_pelvis"]).skeleton
        Skeleton(n_joints=12, n_dofs=28)
        """
        return self._with([motion.select(joints, drop=drop) for motion in self.motions])

    def _rows(self, chosen: np.ndarray, given: object) -> np.ndarray:
        """Return the indices that a mask or an array of indices selects."""
        if chosen.shape == (0,):
            return np.zeros(0, dtype=np.intp)
        if chosen.ndim != 1 or chosen.dtype.kind not in "biu":
            raise TypeError(
                "a dataset is indexed by a number, a slice, a mask or an array of indices, such as "
                f'dataset[dataset.actions == "walk"], got {given!r}'
            )
        if chosen.dtype == bool:
            if len(chosen) != len(self):
                raise IndexError(f"a mask must have one value for each of the {len(self)} motions, got {len(chosen)}")
            return np.flatnonzero(chosen)
        outside = chosen[(chosen < -len(self)) | (chosen >= len(self))]
        if len(outside):
            raise IndexError(f"the dataset has {len(self)} motions, and no motion {outside[0]}")
        return np.arange(len(self))[chosen]

    def to_rotvec(self) -> "MotionDataset":
        """Return the motions with joints of two or three Euler angles as ball joints, see `Motion.to_rotvec`.

        Returns
        -------
        MotionDataset
            With the same labels.

        Examples
        --------
        >>> from skpose.datasets import make_gait
        >>> gait = make_gait(n_subjects=2, n_sequences=1, random_state=0).to_rotvec()
        >>> gait.skeleton.dof_names[:3]
        ('abdomen_rotvec_x', 'abdomen_rotvec_y', 'abdomen_rotvec_z')
        """
        return self._with(motion.to_rotvec() for motion in self)

    def retarget(
        self,
        skeleton: Skeleton,
        *,
        method: Method = "numbers",
        joints: Mapping[str, str] | Sequence[Mapping[str, str] | None] | None = None,
        scale: float | Literal["lengths"] | None = None,
        joint_limits: Literal["ignore", "enforce"] = "ignore",
        n_jobs: int | None = None,
        verbose: int = 0,
    ) -> "MotionDataset":
        """Return all motions on one skeleton, see `skpose.kinematics.retarget`; an error names the motion.

        `retargeting` states which method it was for each motion, and how near it came.

        Parameters
        ----------
        skeleton : Skeleton
            The skeleton that all poses shall have.
        method : {"numbers", "orientations", "positions", "auto", "unchecked"}, default="numbers"
            How poses are converted, see `skpose.kinematics.retarget`.
        joints : mapping of str to str, or sequence of such, default=None
            The counterpart of each joint, names of `skeleton` to names of the motion's. A sequence is one mapping for
            each motion, or None for those that `skpose.kinematics.find_counterparts` finds.
        scale : float or "lengths", default=None
            Factor of positions in the world; None is 1.
        joint_limits : {"ignore", "enforce"}, default="ignore"
            Whether angles are kept inside ``skeleton.limits``.
        n_jobs : int, default=None
            Threads of "positions"; None is 1 unless in a ``joblib.parallel_config`` context, -1 all processors.
        verbose : int, default=0
            Whether "positions" shows the progress.

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
        elif not isinstance(joints, Sequence) or len(joints) != len(self):
            got = len(joints) if isinstance(joints, Sequence) else type(joints).__name__
            raise ValueError(f"joints must be one mapping, or one for each of the {len(self)} motions, got {got}")
        motions, reports = [], []
        for i, (motion, counterparts) in enumerate(zip(self.motions, joints, strict=True)):
            try:
                result = retarget_and_report(
                    motion, skeleton, method, counterparts, scale, joint_limits, n_jobs, verbose
                )
            except ValueError as error:
                raise ValueError(f"motions[{i}]: {error}") from None
            motions.append(result[0])
            # Numbers that stay the same came here as they did before.
            reports.append((result[1] == UNCHANGED and self._retargeting[i]) or result[1])
        there = self._with(motions)
        there._retargeting = tuple(reports)
        return there

    def with_root(
        self, part: Literal["tilt", "whole"] = "tilt", *, up: Literal["x", "y", "z"] | None = None
    ) -> "MotionDataset":
        """Return the motions with the orientation of the root in their poses, see `Motion.with_root`.

        Motions whose `up` differ are refused unless `up` is given: their worlds are not the same.

        Parameters
        ----------
        part : {"tilt", "whole"}, default="tilt"
            "tilt" leaves out the rotation about the vertical, "whole" is the orientation in the world.
        up : {"x", "y", "z"}, default=None
            The axis of the world that points up; None is that of the motions.

        Returns
        -------
        MotionDataset
            With the same labels.

        See Also
        --------
        MotionDataset.without_root : The inverse.

        Examples
        --------
        >>> from skpose.datasets import make_gait
        >>> gait = make_gait(n_subjects=2, n_sequences=1, random_state=0)
        >>> gait.with_root("tilt").skeleton.n_dofs - gait.skeleton.n_dofs
        3
        """
        for i, motion in enumerate(self.motions):
            if up is None and motion.up != self.motions[0].up:
                raise ValueError(
                    f'motions[0] has "{self.motions[0].up}" up and motions[{i}] "{motion.up}": tilts of different '
                    'worlds are not comparable; rotate the motions into one world, or pass up="y" if all are in one'
                )
        return self._with(motion.with_root(part, up=up) for motion in self)

    def without_root(self) -> "MotionDataset":
        """Return the motions with the orientation of the root given back to it, see `Motion.without_root`.

        Returns
        -------
        MotionDataset
            With the same labels.

        Examples
        --------
        >>> from skpose.datasets import make_gait
        >>> gait = make_gait(n_subjects=2, n_sequences=1, random_state=0)
        >>> gait.with_root("tilt").without_root().skeleton == gait.skeleton
        True
        """
        motions = []
        for i, motion in enumerate(self.motions):
            try:
                motions.append(motion.without_root())
            except ValueError as error:
                raise ValueError(f"motions[{i}]: {error}") from None
        return self._with(motions)

    def poses(
        self,
        frame_rate: float | None = None,
        skeleton: Skeleton | None = None,
        *,
        rotations: Literal["rotvec"] | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return all poses as one array, on one skeleton.

        Parameters
        ----------
        frame_rate : float, default=None
            New frame rate, Hz, see `Motion.resample`; None takes every frame.
        skeleton : Skeleton, default=None
            Skeleton whose dofs the columns are, in its order; None is the mean skeleton of the subjects.
        rotations : {"rotvec"}, default=None
            "rotvec" turns joints of two or three Euler angles into ball joints first, so that files may differ in the
            order of their angles. The columns are then the dofs of ``dataset.to_rotvec().skeleton``, or of
            ``skeleton.to_rotvec()``. None keeps the joints as they are.

        Returns
        -------
        X : ndarray of shape (n_poses, n_dofs)
            Joint angles, rad.
        sequence : ndarray of shape (n_poses,)
            Index of each pose's motion; ``dataset.actions[sequence]`` are its labels.

        Raises
        ------
        ValueError
            If the motions' skeletons, or the given one, differ in joints, parents or dofs, or if a bone's directions at
            angle zero are more than 45° apart; the message names the joint and the motions.
        """
        if rotations is not None:
            if rotations != "rotvec":
                raise ValueError(f'rotations must be "rotvec", or None for the joints as they are, got {rotations!r}')
            return self.to_rotvec().poses(frame_rate, None if skeleton is None else skeleton.to_rotvec())
        if not len(self):
            raise ValueError("the dataset has no motions, and so no poses")
        if frame_rate is not None:
            check_frame_rate(frame_rate)
        skeleton = self.skeleton if skeleton is None else skeleton
        motions = list(self.retarget(skeleton, method="numbers").motions)
        if frame_rate is not None:
            motions = [motion.resample(frame_rate) for motion in motions]
        return np.concatenate([m.angles for m in motions]), np.repeat(
            np.arange(len(motions)), [len(m) for m in motions]
        )


def _fewest_joints(reports: Iterable[str]) -> str:
    """Return in words how many joints had counterparts in the motion with the fewest; empty if all of all had."""
    found = [re.search(r"(\d+) of (\d+) joints", report) for report in reports]
    pairs = [(int(match[1]), int(match[2])) for match in found if match]
    fewest = min(pairs, key=lambda pair: pair[0] / pair[1], default=(0, 0))
    return f", {fewest[0]} of {fewest[1]} joints or more" if fewest[0] < fewest[1] else ""


def _count(words: Iterable[str]) -> str:
    """Return how often each word occurs, the first five in the order of the alphabet."""
    names, counts = np.unique(list(words), return_counts=True)
    more = f" and {len(names) - 5} more actions" if len(names) > 5 else ""
    return ", ".join(f"{count} {name}" for name, count in zip(names[:5], counts[:5], strict=True)) + more
