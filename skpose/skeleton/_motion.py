"""A motion: poses of one skeleton in time, with the movement of the root stored apart."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from skpose._validation.columns import check_column_names, other_than_poses
from skpose._validation.motions import check_frame_rate, check_up
from skpose._validation.skeletons import check_skeleton
from skpose._validation.units import warn_of_degrees
from skpose.skeleton import _conversions, _mirror, _sampling, _selection, _show
from skpose.skeleton._bone import Bone, is_axes
from skpose.skeleton._continuity import without_jumps
from skpose.skeleton._root import with_root
from skpose.skeleton._skeleton import Skeleton

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
        Joint angles, rad, one column per name in ``skeleton.dof_names``; the columns of a data frame must have these
        names.
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
    up : {"x", "y", "z"}, default="y"
        The axis of the world that points up, for `with_root`; "y" is usual in BVH and AMC files.

    Attributes
    ----------
    times : ndarray of shape (n_frames,)
        Time of each frame, s: its number over the frame rate.

    Raises
    ------
    ValueError
        For shapes that do not fit each other, columns of a data frame out of order, numbers that are not finite, a
        frame rate that is not positive.

    Warns
    -----
    UserWarning
        If `angles` look like degrees, see `skpose.pose_distances`.

    See Also
    --------
    skpose.io.load_motion : Read a motion from a BVH, AMC or AMASS file.
    skpose.io.save_bvh : Write a motion as a BVH file.
    skpose.kinematics.retarget : Return the poses on another skeleton.

    Notes
    -----
    The library's distances use `angles` alone: global position and orientation are not part of a pose. `with_root`
    makes the orientation a part of it.

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
    up: Literal["x", "y", "z"] = "y"

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
            up: Literal["x", "y", "z"] = "y",
        ) -> None: ...

    def __post_init__(self) -> None:
        check_skeleton(self.skeleton)
        check_frame_rate(self.frame_rate)
        if not is_axes(self.root_axes):
            expected = 'at most one each of the letters x, y and z in one case, such as "xyz" or "ZXY"'
            raise ValueError(f"root_axes must be {expected}, got {self.root_axes!r}")
        check_up(self.up)
        check_column_names(self.angles, self.skeleton, "angles")
        angles = np.asarray(self.angles, dtype=np.float64)
        n_frames = len(angles) if angles.ndim else 0
        root = {"root_positions": 3, "root_angles": len(self.root_axes)}
        for name, width in {"angles": self.skeleton.n_dofs, **root}.items():
            given = getattr(self, name)
            array = np.zeros((n_frames, width)) if given is None else np.asarray(given, dtype=np.float64)
            if array.shape != (n_frames, width):
                hint = other_than_poses(array.shape, self.skeleton) if name == "angles" and array.ndim else ""
                raise ValueError(f"{name} must have shape ({n_frames}, {width}), got {array.shape}{hint}")
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
        warn_of_degrees(angles=self.angles)

    @property
    def times(self) -> np.ndarray:
        return self.frame_numbers / self.frame_rate

    def __len__(self) -> int:
        return len(self.angles)

    __getitem__ = _sampling.frames_of

    def __array__(self, *arguments: object, **options: object) -> NoReturn:
        raise TypeError("a Motion is no array: pass its poses, motion.angles")

    @property
    def _root(self) -> Bone:
        """The root as a joint whose columns are `root_angles`."""
        return Bone("root", None, (0.0, 0.0, 0.0), self.root_axes)

    def __repr__(self) -> str:
        seconds = len(self) / self.frame_rate
        return f"Motion({len(self)} frames at {self.frame_rate:g} Hz, {seconds:.1f} s, {self.skeleton!r})"

    concatenate = staticmethod(_sampling.concatenate)
    resample = _sampling.resample

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
    select = _selection.select_in
    play = _show.play
    _repr_html_ = _show.strip

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

    def with_root(
        self, part: Literal["tilt", "whole"] = "tilt", *, up: Literal["x", "y", "z"] | None = None
    ) -> "Motion":
        """Return the motion with the orientation of the root as a part of its poses.

        The skeleton gets a first joint, "root": a ball joint of length zero at the root, the parent of the root's
        children. Its three columns are the orientation, whole or without the heading.

        Parameters
        ----------
        part : {"tilt", "whole"}, default="tilt"
            "tilt" leaves out the rotation about the vertical: two motions that differ in where they are headed have
            the same poses, but lying is not standing. "whole" is the orientation in the world.
        up : {"x", "y", "z"}, default=None
            The axis of the world that points up; None is the motion's.

        Returns
        -------
        Motion
            The orientation that is left to the root is the heading, an angle about the axis that points up, or zero.
            The joint's name is "root" with an underscore for each joint that has this name already.

        Notes
        -----
        An orientation is R = heading · tilt, of which the tilt is the rotation about a horizontal axis (the swing
        without the twist). Upside down, where there is no heading, small movements change the tilt much.

        Examples
        --------
        Headed by 90° to the side, and bent over by 30°:

        >>> import numpy as np
        >>> from skpose import Motion, Skeleton
        >>> motion = Motion(Skeleton.chain(2), [[0, 0]], 30, root_angles=np.radians([[90, 30]]), root_axes="YX")
        >>> motion = motion.with_root("tilt")
        >>> motion.skeleton.dof_names
        ('root_rotvec_x', 'root_rotvec_y', 'root_rotvec_z', 'joint_1_rz', 'joint_2_rz')
        >>> np.degrees(motion.angles).round(3) + 0.0
        array([[30.,  0.,  0.,  0.,  0.]])
        >>> np.degrees(motion.root_angles).round(3), motion.root_axes
        (array([[90.]]), 'y')
        """
        return with_root(self, part, self.up if up is None else up)
