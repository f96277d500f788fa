"""A motion: poses of one skeleton in time, with the movement of the root stored apart."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from operator import index
from typing import TYPE_CHECKING, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from skpose.skeleton import _conversions, _mirror
from skpose.skeleton._bone import Bone, is_axes
from skpose.skeleton._continuity import without_jumps
from skpose.skeleton._interpolation import interpolate, linear
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
    skpose.io.load_motion : Read a motion from a BVH, AMC or AMASS file.
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
        if not is_axes(self.root_axes):
            expected = 'at most one each of the letters x, y and z in one case, such as "xyz" or "ZXY"'
            raise ValueError(f"root_axes must be {expected}, got {self.root_axes!r}")
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

    def __getitem__(self, frames: int | slice) -> "Motion":
        """Return some frames: ``motion[10:50]``, ``motion[::2]`` at half the rate, ``motion[3]`` as one frame."""
        step = 1
        if isinstance(frames, slice):
            step = abs(frames.indices(len(self))[2])
        else:
            try:
                frame = index("" if isinstance(frames, bool) else frames)  # type: ignore[arg-type]
            except TypeError:
                raise TypeError(
                    "a motion is indexed by a frame or by a slice, such as motion[10:50]: frames of a mask or an array "
                    "are not evenly spaced in time; motion.angles[...] selects poses"
                ) from None
            if not -len(self) <= frame < len(self):
                raise IndexError(f"the motion has {len(self)} frames, and no frame {frame}")
            frame %= len(self)
            frames = slice(frame, frame + 1)
        numbers = self.frame_numbers[frames]
        numbers = np.abs(numbers - numbers[:1])
        if (numbers % step).any():
            raise ValueError(
                f"every frame out of {step} is no motion, as frames are missing between them: use resample, or slices "
                "of the frames that follow each other, see frame_numbers"
            )
        return replace(
            self,
            angles=self.angles[frames],
            frame_rate=self.frame_rate / step,
            root_positions=self.root_positions[frames],
            root_angles=self.root_angles[frames],
            frame_numbers=numbers // step,
        )

    def __array__(self, *arguments: object, **options: object) -> NoReturn:
        raise TypeError("a Motion is no array: pass its poses, motion.angles")

    @property
    def _root(self) -> Bone:
        """The root as a joint whose columns are `root_angles`."""
        return Bone("root", None, (0.0, 0.0, 0.0), self.root_axes)

    def __repr__(self) -> str:
        seconds = len(self) / self.frame_rate
        return f"Motion({len(self)} frames at {self.frame_rate:g} Hz, {seconds:.1f} s, {self.skeleton!r})"

    @classmethod
    def concatenate(cls, motions: Iterable["Motion"]) -> "Motion":
        """Return motions one after another, as one.

        Nothing is moved: where one motion ends elsewhere than the next begins, there is a jump.

        Parameters
        ----------
        motions : iterable of Motion
            At least one; with the same skeleton, frame rate and root axes.

        Returns
        -------
        Motion
            With the frames of all.

        Raises
        ------
        ValueError
            If the motions differ in skeleton, frame rate or root axes; the message states in which.
        """
        motions = list(motions)
        if not motions:
            raise ValueError("concatenate needs at least one motion, got none")
        first = motions[0]
        for i, motion in enumerate(motions[1:], start=1):
            if motion.skeleton != first.skeleton:
                difference = mismatch(first.skeleton, motion.skeleton) or "bones differ: use retarget first"
                raise ValueError(f"motions[{i}] has another skeleton than motions[0]: {difference}")
            for name, remedy in (("frame_rate", "use resample first"), ("root_axes", "turn them into the same first")):
                if getattr(motion, name) != getattr(first, name):
                    values = f"{getattr(motion, name)!r}, but motions[0] {getattr(first, name)!r}"
                    raise ValueError(f"motions[{i}] has {name} {values}: {remedy}")
        angles, positions, rotations = (
            np.concatenate([getattr(motion, name) for motion in motions])
            for name in ("angles", "root_positions", "root_angles")
        )
        ends = np.cumsum([0] + [1 + motion.frame_numbers[-1] if len(motion) else 0 for motion in motions])
        numbers = np.concatenate([end + motion.frame_numbers for end, motion in zip(ends, motions, strict=False)])
        return replace(first, angles=angles, root_positions=positions, root_angles=rotations, frame_numbers=numbers)

    def resample(self, frame_rate: float) -> "Motion":
        """Return the motion at another frame rate, from its first frame to the last time within it.

        Between two frames a joint with three dofs, and a root with three axes, rotates by the smallest angle (slerp).
        Other angles change linearly along their difference wrapped to [−π, π], so that a file's jump by 360° is no
        rotation. Where the new times coincide with frames, as from 120 to 12 Hz, these are taken as they are. Where
        frames are missing none are made up: new times between a frame and one that does not directly follow it are
        missing too. There is no low-pass filter: a lower rate aliases movements that are faster than it, as in the
        paper.

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
        positions = self.root_positions
        return replace(
            self,
            angles=interpolate(self.skeleton.bones, self.angles, rows),
            frame_rate=frame_rate,
            root_positions=linear(positions[before], positions[after], part, 0.0),
            root_angles=interpolate((self._root,), self.root_angles, rows),
            frame_numbers=frame_numbers,
        )

    def unwrap(self) -> "Motion":
        """Return the motion with its angles continuous in time: jumps from frame to frame are removed.

        Such jumps are those by 360°, those between the two triples of three Euler angles that are one rotation,
        (a, b, c) and (a + π, π − b, c + π), and those by whole turns of rotation vectors; the root's angles too. Of the
        numbers that are one rotation, each frame has those nearest to the frame before; the first frame stays as it is.

        The poses stay the same, and so do distances between them, except "angle", which takes angles literally.
        Filters, derivatives and plots of the angles need continuous ones.

        Returns
        -------
        Motion
            Of the same skeleton; angles may leave [−π, π].
        """
        angles = without_jumps(self.skeleton.bones, self.angles)
        return replace(self, angles=angles, root_angles=without_jumps((self._root,), self.root_angles))

    to_rotvec = _conversions.to_rotvec
    to_euler = _conversions.to_euler
    mirrored = _mirror.mirrored

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
