"""Collections of motions with their labels."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._skeleton import check_comparable

WALKING_AND_RUNNING = ("walk", "run")
CONVERT = (
    'Convert the motions to one rest pose first: dataset.retarget(dataset.motions[0].skeleton, rest="world") keeps the '
    'directions of the bones in the world, rest="same" the numbers'
)


@dataclass(frozen=True, repr=False, eq=False)
class MotionDataset:
    """Motions of one or more subjects, with their labels.

    Parameters
    ----------
    motions : sequence of Motion
        One for each sequence.
    subjects, trials, actions : array-like of shape (n_motions,)
        Labels of each motion, as strings: the person, the number of the recording, and the action.

    Examples
    --------
    >>> from skpose.datasets import make_gait
    >>> gait = make_gait(n_subjects=2, n_sequences=1, random_state=0)
    >>> gait
    MotionDataset(4 motions of 2 subjects: 2 run, 2 walk)
    >>> X, sequence = gait.poses(frame_rate=12)
    >>> y, groups = gait.actions[sequence], gait.subjects[sequence]
    """

    motions: tuple[Motion, ...]
    subjects: np.ndarray
    trials: np.ndarray
    actions: np.ndarray

    if TYPE_CHECKING:

        def __init__(
            self, motions: Iterable[Motion], subjects: ArrayLike, trials: ArrayLike, actions: ArrayLike
        ) -> None: ...

    def __post_init__(self) -> None:
        object.__setattr__(self, "motions", tuple(self.motions))
        for name in ("subjects", "trials", "actions"):
            labels = np.asarray(getattr(self, name), dtype=str)
            if labels.shape != (len(self.motions),):
                raise ValueError(
                    f"{name} must have one label for each of the {len(self.motions)} motions, got shape {labels.shape}"
                )
            object.__setattr__(self, name, labels)

    def __len__(self) -> int:
        return len(self.motions)

    def __iter__(self) -> Iterator[Motion]:
        return iter(self.motions)

    def __repr__(self) -> str:
        names, counts = np.unique(self.actions, return_counts=True)
        actions = ", ".join(f"{count} {name or 'unnamed'}" for name, count in zip(names[:5], counts[:5], strict=True))
        more = f" and {len(names) - 5} more actions" if len(names) > 5 else ""
        return f"MotionDataset({len(self)} motions of {len(set(self.subjects))} subjects: {actions}{more})"

    @cached_property
    def skeleton(self) -> Skeleton:
        """The bone-wise mean of the subjects' skeletons, each counted once, on which their poses are compared."""
        names: dict[Skeleton, str] = {}
        for i, motion in enumerate(self.motions):
            names.setdefault(motion.skeleton, f"motions[{i}]")
        check_comparable(list(names), list(names.values()), CONVERT)
        return Skeleton.mean(names)

    def select(self, chosen: ArrayLike) -> "MotionDataset":
        """Return the motions that a boolean mask or an array of indices selects."""
        i = np.arange(len(self))[np.asarray(chosen)]
        return MotionDataset([self.motions[k] for k in i], self.subjects[i], self.trials[i], self.actions[i])

    def to_rotvec(self) -> "MotionDataset":
        """Return the motions with joints of two or three Euler angles as ball joints, see `Motion.to_rotvec`.

        >>> from skpose.datasets import make_gait
        >>> gait = make_gait(n_subjects=2, n_sequences=1, random_state=0).to_rotvec()
        >>> gait.skeleton.dof_names[:3]
        ('abdomen_rotvec_x', 'abdomen_rotvec_y', 'abdomen_rotvec_z')
        """
        return replace(self, motions=tuple(motion.to_rotvec() for motion in self.motions))

    def retarget(self, skeleton: Skeleton, *, rest: Literal["raise", "world", "same"] = "raise") -> "MotionDataset":
        """Return all motions on one skeleton, see `Motion.retarget`; an error names the motion.

        >>> from skpose.datasets import make_gait
        >>> gait = make_gait(n_subjects=2, n_sequences=1, random_state=0)
        >>> gait = gait.retarget(gait.motions[0].skeleton, rest="world")
        >>> len({motion.skeleton for motion in gait})
        1
        """
        motions = []
        for i, motion in enumerate(self.motions):
            try:
                motions.append(motion.retarget(skeleton, rest=rest))
            except ValueError as error:
                raise ValueError(f"motions[{i}]: {error}") from None
        return replace(self, motions=tuple(motions))

    def with_root(
        self, part: Literal["tilt", "whole"] = "tilt", *, up: Literal["x", "y", "z"] | None = None
    ) -> "MotionDataset":
        """Return the motions with the orientation of the root in their poses, see `Motion.with_root`.

        Motions whose `up` differs are refused unless `up` is given: their worlds are not the same.

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
        return replace(self, motions=tuple(motion.with_root(part, up=up) for motion in self.motions))

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
        skeleton = self.skeleton if skeleton is None else skeleton
        motions = list(self.retarget(skeleton).motions)
        if frame_rate is not None:
            motions = [motion.resample(frame_rate) for motion in motions]
        return np.concatenate([m.angles for m in motions]), np.repeat(
            np.arange(len(motions)), [len(m) for m in motions]
        )


def walks_and_runs(dataset: MotionDataset) -> MotionDataset:
    """Return the motions of walking and of running, labelled "walk" and "run".

    A motion is selected if the first word of its action is "walk" or "run", in upper or lower case, as in CMU's "walk"
    and "Run/jog".

    Parameters
    ----------
    dataset : MotionDataset
        Motions of any actions.

    Returns
    -------
    MotionDataset
        The selected motions; their `actions` are "walk" or "run".

    Raises
    ------
    ValueError
        If there is no motion of walking, or none of running.

    Examples
    --------
    >>> from skpose.datasets import make_gait, walks_and_runs
    >>> walks_and_runs(make_gait(n_subjects=2, n_sequences=1, random_state=0))
    MotionDataset(4 motions of 2 subjects: 2 run, 2 walk)
    """
    first = np.array([re.split(r"\W", action.strip().lower())[0] for action in dataset.actions])
    chosen = np.isin(first, WALKING_AND_RUNNING)
    missing = [action for action in WALKING_AND_RUNNING if action not in first]
    if missing:
        raise ValueError(
            f"dataset must have motions of walking and of running, but none has an action that begins with "
            f"{missing[0]!r}: write one line for each motion into an index.csv, see skpose.datasets.load_cmu"
        )
    return MotionDataset(
        dataset.select(chosen).motions, dataset.subjects[chosen], dataset.trials[chosen], first[chosen]
    )
