"""A motion: poses of one skeleton in time, with the movement of the root stored apart."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from skpose.skeleton._interpolation import interpolate, linear
from skpose.skeleton._rotations import TWO_PI
from skpose.skeleton._skeleton import Skeleton, mismatch

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True, repr=False, eq=False)
class Motion:
    """Poses of a skeleton at a constant frame rate.

    Parameters
    ----------
    skeleton : Skeleton
        The skeleton of all poses.
    angles : array-like of shape (n_frames, n_dofs)
        Joint angles, rad, one column per name in ``skeleton.dof_names``.
    frame_rate : float
        Frames per second, Hz.
    root_positions : array-like of shape (n_frames, 3), default=None
        Positions of the root, m; None is the origin.
    root_angles : array-like of shape (n_frames, k), default=None
        Rotations of the root, rad, one column per letter of `root_axes`; None is unrotated.
    root_axes : str, default="xyz"
        The axes of `root_angles` in the notation of `Bone`: lower case extrinsic, upper case intrinsic.
    frame_numbers : array-like of shape (n_frames,) of ints, default=None
        Number of each frame, increasing; None is 0, 1, 2, … Where a number is left out a frame is missing, as of a file
        read with ``on_nan="drop"``.

    Attributes
    ----------
    times : ndarray of shape (n_frames,)
        Time of each frame, s: its number over the frame rate.

    Raises
    ------
    ValueError
        For shapes that do not fit each other, numbers that are not finite, a frame rate that is not positive.

    See Also
    --------
    skpose.io.load_motion : Read a motion from a BVH or AMC file.
    skpose.io.save_bvh : Write a motion as a BVH file.

    Notes
    -----
    The library's distances use `angles` alone: global position and orientation are not part of a pose.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Motion, Skeleton
    >>> swing = Motion(Skeleton.chain(2), np.linspace([0, 0], [1, 2], 25), frame_rate=24)
    >>> swing
    Motion(25 frames at 24 Hz, 1.0 s, Skeleton(n_joints=2, n_dofs=2))
    >>> len(swing.resample(12))
    13
    """

    skeleton: Skeleton
    angles: np.ndarray
    frame_rate: float
    root_positions: np.ndarray = None  # type: ignore[assignment]  # None becomes zeros
    root_angles: np.ndarray = None  # type: ignore[assignment]  # likewise
    root_axes: str = "xyz"
    frame_numbers: np.ndarray = None  # type: ignore[assignment]  # None becomes 0, 1, 2, …

    if TYPE_CHECKING:

        def __init__(
            self,
            skeleton: Skeleton,
            angles: ArrayLike,
            frame_rate: float,
            root_positions: ArrayLike | None = None,
            root_angles: ArrayLike | None = None,
            root_axes: str = "xyz",
            frame_numbers: ArrayLike | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        if not np.isfinite(self.frame_rate) or self.frame_rate <= 0:
            raise ValueError(f"frame_rate must be a positive number of Hz, got {self.frame_rate!r}")
        angles = np.asarray(self.angles, dtype=np.float64)
        n_frames = len(angles) if angles.ndim else 0
        root = {"root_positions": 3, "root_angles": len(self.root_axes)}
        for name, width in {"angles": self.skeleton.n_dofs, **root}.items():
            given = getattr(self, name)
            array = np.zeros((n_frames, width)) if given is None else np.asarray(given, dtype=np.float64)
            if array.shape != (n_frames, width):
                raise ValueError(f"{name} must have shape ({n_frames}, {width}), got {array.shape}")
            if not np.isfinite(array).all():
                frame, column = np.argwhere(~np.isfinite(array))[0]
                raise ValueError(f"{name} holds {array[frame, column]} at frame {frame}, column {column}")
            object.__setattr__(self, name, array)
        numbers = np.arange(n_frames) if self.frame_numbers is None else np.asarray(self.frame_numbers)
        if numbers.shape != (n_frames,) or (n_frames and numbers.dtype.kind not in "iu"):
            raise ValueError(f"frame_numbers must be {n_frames} whole numbers, got {numbers.dtype} of {numbers.shape}")
        numbers = numbers.astype(np.int64)
        if (np.diff(numbers) <= 0).any():
            frame = int(np.argmax(np.diff(numbers) <= 0))
            raise ValueError(f"frame_numbers must increase, got {numbers[frame]} and then {numbers[frame + 1]}")
        object.__setattr__(self, "frame_numbers", numbers)

    @property
    def times(self) -> np.ndarray:
        return self.frame_numbers / self.frame_rate

    def __len__(self) -> int:
        return len(self.angles)

    def __repr__(self) -> str:
        seconds = len(self) / self.frame_rate
        return f"Motion({len(self)} frames at {self.frame_rate:g} Hz, {seconds:.1f} s, {self.skeleton!r})"

    def resample(self, frame_rate: float) -> "Motion":
        """Return the motion at another frame rate, from its first frame to the last time within it.

        Between two frames a joint with three dofs turns by the short way (slerp). Other angles change linearly along
        their difference wrapped to [−π, π], so that a file's jump by 360° is no rotation. Where the new times coincide
        with frames, as from 120 to 12 Hz, these are taken as they are. Where frames are missing none are made up: new
        times between a frame and one that does not directly follow it are missing too. There is no low-pass filter: a
        lower rate aliases movements that are faster than it, as in the paper.

        Parameters
        ----------
        frame_rate : float
            The new rate, Hz.

        Returns
        -------
        Motion
            Of the same skeleton.
        """
        if not np.isfinite(frame_rate) or frame_rate <= 0:
            raise ValueError(f"frame_rate must be a positive number of Hz, got {frame_rate!r}")
        numbers, step = self.frame_numbers, self.frame_rate / frame_rate
        # 1e-9 allows for rounding: a rate that divides the old one exactly keeps the last frame.
        first, last = (numbers[0], numbers[-1]) if len(self) else (0, -1)
        new = np.arange(int(np.ceil(first / step - 1e-9)), int(np.floor(last / step + 1e-9)) + 1)
        at = new * step  # in numbers of the old frames
        near = np.rint(at)
        at = np.where(np.abs(at - near) < 1e-9, near, at)
        before = np.searchsorted(numbers, at, side="right") - 1
        part = at - numbers[before]
        known = (part == 0.0) | np.isin(numbers[before] + 1, numbers)
        return self._at((before + part)[known], frame_rate, new[known])

    def _at(self, rows: np.ndarray, frame_rate: float, frame_numbers: np.ndarray) -> "Motion":
        """Return the motion at rows, which need not be whole."""
        before = np.minimum(rows.astype(np.intp), max(len(self) - 1, 0))
        after, part = np.minimum(before + 1, len(self) - 1), (rows - before)[:, None]
        positions, angles = self.root_positions, self.root_angles
        return replace(
            self,
            angles=interpolate(self.skeleton, self.angles, rows),
            frame_rate=frame_rate,
            root_positions=linear(positions[before], positions[after], part, 0.0),
            root_angles=linear(angles[before], angles[after], part, TWO_PI),
            frame_numbers=frame_numbers,
        )

    def unwrap(self) -> "Motion":
        """Return the motion with its angles continuous in time: jumps by 360° from frame to frame are removed.

        The poses stay the same, and so do distances between them, except "angle", which takes angles literally.
        Filters, derivatives and plots of the angles need continuous ones.

        Returns
        -------
        Motion
            Of the same skeleton; angles may leave [−π, π].
        """
        angles, root_angles = (np.unwrap(values, axis=0) for values in (self.angles, self.root_angles))
        return replace(self, angles=angles, root_angles=root_angles)

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the angles as a pandas DataFrame, one column for each dof and one row for each frame.

        Estimators with a skeleton refuse a data frame whose columns are not the skeleton's dofs, in its order.

        Returns
        -------
        pandas.DataFrame of shape (n_frames, n_dofs)
            Angles, rad; columns ``skeleton.dof_names``, index the time of each frame, s.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise ImportError("to_pandas needs pandas: pip install 'skpose[pandas]'") from None

        index = pandas.Index(self.times, name="time")
        return pandas.DataFrame(self.angles, index, list(self.skeleton.dof_names))

    def retarget(self, skeleton: Skeleton) -> "Motion":
        """Return the same angles on another skeleton, columns matched by dof name.

        Poses of different people are compared on one skeleton, such as `Skeleton.mean` of theirs: angles carry over
        where joints and dofs have the same names, bone lengths do not. The root's movement stays as it is.

        Parameters
        ----------
        skeleton : Skeleton
            With the same joints, parents and dofs; lengths, directions and the order of bones may differ.

        Returns
        -------
        Motion
            Of the given skeleton.

        Raises
        ------
        ValueError
            If the skeletons differ in joints, parents or dofs; the message names the joint.
        """
        difference = mismatch(self.skeleton, skeleton)
        if difference:
            raise ValueError(f"the motion's angles do not carry over to this skeleton: {difference}")
        column = {name: i for i, name in enumerate(self.skeleton.dof_names)}
        angles = self.angles[:, [column[name] for name in skeleton.dof_names]]
        return replace(self, skeleton=skeleton, angles=angles)
