"""A motion: poses of one skeleton in time, with the movement of the root stored apart."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal, NoReturn

import numpy as np

from skpose._displays import Page, displays
from skpose._typing import ArrayLike
from skpose._validation.columns import check_column_names, other_than_poses
from skpose._validation.motions import check_frame_rate, check_up
from skpose._validation.options import check_integer
from skpose._validation.skeletons import check_skeleton
from skpose._validation.units import warn_of_degrees
from skpose._warnings import warn
from skpose.skeleton._bone import Bone, is_axes
from skpose.skeleton._comparison import mismatch
from skpose.skeleton._continuity import remove_jumps
from skpose.skeleton._conversions import convert
from skpose.skeleton._cycle import Frames, close_cycle, describe_opening, repeat_cycle
from skpose.skeleton._interpolation import interpolate_linearly, interpolate_poses
from skpose.skeleton._limits import kept_inside
from skpose.skeleton._mirror import mirror_poses
from skpose.skeleton._root import (
    continuous_root_angles,
    find_root_joint,
    heading,
    root_joint_orientations,
    root_orientations,
    root_parts,
    with_root_joint,
    without_root_joint,
)
from skpose.skeleton._sampling import check_seen, choose_frames, join_seen, resample_frames, seen_between, seen_of
from skpose.skeleton._skeleton import Skeleton
from skpose.skeleton._stance import upright_turn

if TYPE_CHECKING:
    import pandas


# What to do about motions that differ in what one motion has once.
REMEDIES = {
    "frame_rate": "use resample first",
    "root_axes": 'with_root("tilt") makes the orientation a part of the poses of both, and leaves one axis to the root',
    "up": 'their worlds are not the same; if they are, dataclasses.replace(motion, up="y") states so',
}
HEADED = 1e-6  # rad, above which the heading of poses changes


@dataclass(frozen=True, repr=False, eq=False)
class Motion:
    """Poses of a skeleton at a constant frame rate.

    Parameters
    ----------
    skeleton : Skeleton
        The skeleton of all poses.
    angles : array-like of shape (n_frames, n_dofs)
        Joint angles, rad, or m where a joint slides, one column per name in ``skeleton.dof_names``; the columns of
        a data frame must have these names.
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
    root_name : str, default="root"
        The name of the root, which is no joint of the skeleton: that of the file from which the motion was read.
    seen : array-like of shape (n_frames, n_joints) of bool, or bool, default=None
        Of poses that were found from positions of points, as by `skpose.inverse_kinematics`: which joints had a
        position, in each frame; True is all of them. Positions do not show all rotations, such as that of a straight
        arm about itself. None is a recording of rotations, which does.

    Attributes
    ----------
    fitted : bool
        Whether the poses were found from positions: whether `seen` is known.
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
    Motion(25 frames at 24 Hz, 1.0 s, y up, Skeleton(n_joints=2, n_dofs=2))
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
    root_name: str = field(default="root", kw_only=True)
    seen: np.ndarray | None = field(default=None, kw_only=True)

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
            *,
            root_name: str = "root",
            seen: ArrayLike | bool | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        check_skeleton(self.skeleton)
        check_frame_rate(self.frame_rate)
        if not is_axes(self.root_axes):
            expected = 'at most one each of the letters x, y and z in one case, such as "xyz" or "ZXY"'
            raise ValueError(f"root_axes must be {expected}, got {self.root_axes!r}")
        check_up(self.up)
        if not isinstance(self.root_name, str) or not self.root_name:
            raise ValueError(f"root_name must be the name of the root, got {self.root_name!r}")
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
        object.__setattr__(self, "seen", check_seen(self.seen, (n_frames, self.skeleton.n_joints)))
        warn_of_degrees(None, self.skeleton, angles=self.angles)

    @property
    def times(self) -> np.ndarray:
        """Time of each frame, s."""
        return self.frame_numbers / self.frame_rate

    @property
    def fitted(self) -> bool:
        """True for poses that were found from positions."""
        return self.seen is not None

    def __len__(self) -> int:
        return len(self.angles)

    def __getitem__(self, frames: int | np.integer | slice) -> "Motion":
        """Return some frames: ``motion[10:50]``, ``motion[::2]`` at half the rate, ``motion[3]`` as one frame."""
        rows, step, numbers = choose_frames(self.frame_numbers, frames)
        return replace(
            self,
            angles=self.angles[rows],
            frame_rate=self.frame_rate / step,
            root_positions=self.root_positions[rows],
            root_angles=self.root_angles[rows],
            frame_numbers=numbers,
            seen=None if self.seen is None else self.seen[rows],
        )

    def __array__(self, *arguments: object, **options: object) -> NoReturn:
        raise TypeError("a Motion is no array: pass its poses, motion.angles")

    @property
    def _root(self) -> Bone:
        """The root as a joint whose columns are `root_angles`."""
        return Bone("root", None, (0.0, 0.0, 0.0), self.root_axes)

    def __repr__(self) -> str:
        seconds = len(self) / self.frame_rate
        fitted = ", fitted to positions" if self.seen is not None else ""
        if self.seen is not None and not self.seen.all():
            fitted += f" ({100 * (1 - self.seen.mean()):.3g} % of joints unseen)"
        frames = f"{len(self)} frames at {self.frame_rate:g} Hz, {seconds:.1f} s"
        return f"Motion({frames}, {self.up} up{fitted}, {self.skeleton!r})"

    @staticmethod
    def concatenate(motions: Iterable["Motion"]) -> "Motion":
        """Return motions one after another, as one.

        Nothing is moved: where one motion ends elsewhere than the next begins, there is a jump.

        Parameters
        ----------
        motions : iterable of Motion
            At least one; with the same skeleton, frame rate, root axes and axis that points up.

        Returns
        -------
        Motion
            With the frames of all.

        Raises
        ------
        ValueError
            If the motions differ in one of these; the message states in which.
        """
        motions = list(motions)
        if not motions:
            raise ValueError("concatenate needs at least one motion, got none")
        first = motions[0]
        for i, motion in enumerate(motions[1:], start=1):
            if motion.skeleton != first.skeleton:
                difference = mismatch(first.skeleton, motion.skeleton) or "bones differ: use retarget first"
                raise ValueError(f"motions[{i}] has another skeleton than motions[0]: {difference}")
            for name, remedy in REMEDIES.items():
                if getattr(motion, name) != getattr(first, name):
                    values = f"{getattr(motion, name)!r}, but motions[0] {getattr(first, name)!r}"
                    raise ValueError(f"motions[{i}] has {name} {values}: {remedy}")
        angles, positions, rotations = (
            np.concatenate([getattr(motion, name) for motion in motions])
            for name in ("angles", "root_positions", "root_angles")
        )
        ends = np.cumsum([0] + [1 + motion.frame_numbers[-1] if len(motion) else 0 for motion in motions])
        numbers = np.concatenate([end + motion.frame_numbers for end, motion in zip(ends, motions, strict=False)])
        return replace(
            first,
            angles=angles,
            root_positions=positions,
            root_angles=rotations,
            frame_numbers=numbers,
            seen=join_seen([motion.seen for motion in motions], list(map(len, motions))),
        )

    def resample(self, frame_rate: float) -> "Motion":
        """Return the motion at another frame rate, from its first frame to the last time within it.

        Between two frames a joint with three dofs, and a root with three axes, rotates by the smallest angle (slerp).
        Other angles change linearly along their difference wrapped to [−π, π], so that a file's jump by 360° is no
        rotation. A joint with one or two dofs whose limits leave out a part of the circle has no way through that part:
        between two frames inside its limits it takes the angles between theirs, as a robot's hinge does from −170° to
        160°. Where the new times coincide with frames, as from 120 to 12 Hz, these are taken as they are. Where
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
        check_frame_rate(frame_rate)
        rows, numbers = resample_frames(self.frame_numbers, self.frame_rate, frame_rate)
        return replace(
            self,
            angles=interpolate_poses(
                self.skeleton.bones, self.angles, rows, kept_inside(self.skeleton.bones, self.angles)
            ),
            frame_rate=frame_rate,
            root_positions=interpolate_linearly(self.root_positions, rows),
            root_angles=interpolate_poses((self._root,), self.root_angles, rows),
            frame_numbers=numbers,
            seen=None if self.seen is None else seen_between(self.seen, rows),
        )

    def to_cycle(self, *, endpoint: bool = False) -> "Motion":
        """Return the motion as a cycle: its last frame is its first one, moved along the floor.

        `repeat` continues it without a jump, and so do programs that loop a motion from the place where it ends. What
        is left between the end and the start is distributed over all frames, the same share for each interval of time:
        each joint, and the tilt of the root, by a rotation about a fixed axis; hinges by their angle; the height of the
        root linearly. The first frame is changed by half of it, the last by half of it in the other direction. Where
        the cycle goes is kept: the step of the root along the floor and the change of its heading are those of the
        motion.

        Parameters
        ----------
        endpoint : bool, default=False
            Whether the last frame is the first pose again, as of a stride from heel strike to heel strike, both
            included. False: the last frame is the one before, as in slices ``motion[start:stop]`` and of
            `segment_repetitions`. A frame is then added, at the mean of the velocities of the first and the last
            step. `numpy.linspace` has the same word for the same thing.

        Returns
        -------
        Motion
            With one frame more than the motion, or as many.

        Raises
        ------
        ValueError
            For fewer than three frames; if the poses themselves change their heading, as of ``with_root("whole")``.

        Warns
        -----
        UserWarning
            If the last pose is the first one and `endpoint` is False; if the end is so far from the first pose that the
            motion is no whole cycle: more than a fifth as far as the farthest of its poses, and than one and a half
            usual steps; if the joints jump at an end: half as fast again as anywhere else.

        See Also
        --------
        skpose.motions.segment_repetitions : The cycles of a motion, such as strides.
        skpose.motions.mean_motion : A typical one.

        Examples
        --------
        One swing to and fro, in 24 steps of 1 cm forward:

        >>> import numpy as np
        >>> from skpose import Motion, Skeleton
        >>> swing = np.sin(np.arange(24) * np.pi / 12)[:, None]
        >>> forward = np.arange(24)[:, None] * [0, 0, 0.01]
        >>> cycle = Motion(Skeleton.chain(1), swing, 24, forward).to_cycle()
        >>> len(cycle), cycle.root_positions[-1].round(3)
        (25, array([0.  , 0.  , 0.24]))
        >>> cycle.repeat(3)
        Motion(73 frames at 24 Hz, 3.0 s, y up, Skeleton(n_joints=1, n_dofs=1))
        """
        self._check_heading("to_cycle", least=3)
        cycle, complaints = close_cycle(self._frames, endpoint)
        for complaint in complaints:
            warn(complaint)
        return self._with_frames(cycle)

    def repeat(self, n: int) -> "Motion":
        """Return a cycle n times, each from the place and with the heading at which the one before ends.

        Of the last frame of a cycle and the first of the next, which are one pose, there is one.

        Parameters
        ----------
        n : int
            How often, at least once.

        Returns
        -------
        Motion
            With n · (len(motion) − 1) + 1 frames.

        Raises
        ------
        ValueError
            If the last frame is not the first one, moved along the floor: if a joint or the tilt of the root is off by
            more than a tenth of what changes most between two frames, or the height likewise. `to_cycle` makes it so.

        See Also
        --------
        Motion.to_cycle : Close a cycle.
        Motion.concatenate : Motions one after another, where they are.

        Examples
        --------
        A quarter of a circle, four times:

        >>> import numpy as np
        >>> from skpose import Motion, Skeleton
        >>> arc, still = np.linspace(0, np.pi / 2, 5), np.zeros((5, 1))
        >>> places = np.column_stack([1 - np.cos(arc), still, np.sin(arc)])
        >>> quarter = Motion(Skeleton.chain(1), still, 4, places, arc[:, None], root_axes="y")
        >>> circle = quarter.repeat(4)
        >>> circle.root_positions[[4, 8, 12, 16]].round(3) + 0.0
        array([[ 1.,  0.,  1.],
               [ 2.,  0.,  0.],
               [ 1.,  0., -1.],
               [ 0.,  0.,  0.]])
        """
        check_integer(n, 1, "n")
        self._check_heading("repeat", least=2)
        if gap := describe_opening(self._frames):
            raise ValueError(
                f"repeat needs a cycle, whose last frame is its first one moved along the floor, but from one to the "
                f"other {gap}: motion.to_cycle() makes one of a motion that ends a frame before it begins again, "
                "motion.to_cycle(endpoint=True) of one that ends with its first pose"
            )
        return self if n == 1 else self._with_frames(repeat_cycle(self._frames, n))

    def _check_heading(self, function: str, least: int) -> None:
        """Refuse motions of too few frames, and those whose heading is in the poses, where it would be closed."""
        if len(self) < least:
            raise ValueError(f"{function} needs at least {least} frames, got {len(self)}")
        if find_root_joint(self.skeleton) and not self.root_angles.any():
            ends = root_joint_orientations(self.skeleton, self.angles[[0, -1]])
            if abs(heading(ends[1:] * ends[:1].inv(), self.up)[0]) > HEADED:
                raise ValueError(
                    f'the heading changes and is a part of the poses, as of with_root("whole"): {function} needs it '
                    "as the root's, call motion.without_root() first"
                )

    @property
    def _frames(self) -> Frames:
        """The poses with the orientation of the root."""
        root = root_orientations(self.root_angles, self.root_axes)
        poses = np.concatenate([self.angles, root.as_rotvec()], axis=1)
        return Frames(self.skeleton, poses, self.root_positions, self.frame_numbers, np.arange(len(self)), self.up)

    def _with_frames(self, frames: Frames) -> "Motion":
        """Return the motion with other frames."""
        root_angles, root_axes = continuous_root_angles(frames.root, self.root_axes)
        return replace(
            self,
            angles=remove_jumps(self.skeleton.bones, frames.poses[:, :-3]),
            root_positions=frames.places,
            root_angles=root_angles,
            root_axes=root_axes,
            frame_numbers=frames.numbers,
            seen=None if self.seen is None else self.seen[frames.rows],
        )

    def unwrap(self) -> "Motion":
        """Return the motion with its angles continuous in time: jumps from frame to frame are removed.

        Such jumps are those by 360°, those between the two triples of three Euler angles that are one rotation,
        (a, b, c) and (a + π, π − b, c + π), and those by whole turns of rotation vectors; the root's angles too. Of the
        numbers that are one rotation, each frame has those nearest to the frame before; the first frame stays as it is.
        An angle of a joint with one or two dofs stays as it is if it is inside its limits in all frames, and these
        leave out a part of the circle: it then cannot jump.

        The poses stay the same, and so do distances between them, except "angle", which takes angles literally.
        Filters, derivatives and plots of the angles need continuous ones.

        Returns
        -------
        Motion
            Of the same skeleton; angles may leave [−π, π].
        """
        kept = np.asarray(kept_inside(self.skeleton.bones, self.angles).all(axis=0))
        angles = remove_jumps(self.skeleton.bones, self.angles, kept)
        return replace(self, angles=angles, root_angles=remove_jumps((self._root,), self.root_angles))

    def to_rotvec(self) -> "Motion":
        """Return the same motion with joints of two or three Euler angles as ball joints, on `Skeleton.to_rotvec`.

        All joints stay where they are. Rotation vectors are continuous in time: of the vectors that are one rotation,
        each frame has the one nearest to the frame before, which may be longer than π. The root's angles stay as they
        are.

        Returns
        -------
        Motion
            Of the skeleton ``motion.skeleton.to_rotvec()``.

        See Also
        --------
        Motion.to_euler : Return ball joints as three Euler angles.

        Examples
        --------
        >>> import numpy as np
        >>> from skpose import Bone, Motion, Skeleton
        >>> arm = Skeleton([Bone("elbow", None, (0.3, 0, 0), "xyz"), Bone("wrist", "elbow", (0.25, 0, 0), "z")])
        >>> motion = Motion(arm, [[0, np.pi / 2, 0, 1]], frame_rate=60).to_rotvec()
        >>> motion.skeleton.dof_names
        ('elbow_rotvec_x', 'elbow_rotvec_y', 'elbow_rotvec_z', 'wrist_rz')
        >>> motion.angles.round(3)
        array([[0.   , 1.571, 0.   , 1.   ]])
        """
        return self._on(self.skeleton.to_rotvec())

    def to_euler(self, order: str) -> "Motion":
        """Return the same motion with ball joints as three Euler angles in one order, on `Skeleton.to_euler`.

        All joints stay where they are. Angles are continuous in time: of the triples that are one rotation, each frame
        has the one nearest to the frame before. In gimbal lock that is one of a line of triples.

        Parameters
        ----------
        order : str
            Three different letters in the notation of `Bone`: "xyz" is extrinsic, "ZXY" intrinsic.

        Returns
        -------
        Motion
            Of the skeleton ``motion.skeleton.to_euler(order)``. Joints that have Euler angles keep theirs:
            ``motion.to_rotvec().to_euler(order)`` changes these too.

        Raises
        ------
        ValueError
            If the order is not three different letters in one case.

        See Also
        --------
        Motion.to_rotvec : Return Euler angles as ball joints.

        Examples
        --------
        >>> import numpy as np
        >>> from skpose import Bone, Motion, Skeleton
        >>> arm = Skeleton([Bone("elbow", None, (0.3, 0, 0), "rotvec")])
        >>> Motion(arm, [[0, 0, 1.5]], frame_rate=60).to_euler("ZXY").angles.round(3) + 0.0
        array([[1.5, 0. , 0. ]])
        """
        return self._on(self.skeleton.to_euler(order))

    def _on(self, skeleton: Skeleton) -> "Motion":
        """Return the motion on a skeleton with the same bones in the same order, which differ in their dofs."""
        return replace(self, skeleton=skeleton, angles=convert(self.skeleton.bones, skeleton.bones, self.angles))

    def mirrored(self, axis: Literal["x", "y", "z"] = "x") -> "Motion":
        """Return the mirror image of the motion: what the left does, the right does.

        The mirror is the plane through the origin across one axis, which points to the left or to the right at angle
        zero. With M the reflection, a joint's world rotation R, relative to angle zero, becomes M R M of its partner on
        the other side. So does the root's, and its position p becomes M p. For a skeleton that is its own mirror image,
        joints are at the mirror images of the positions of their partners. The motion stays on the same skeleton: where
        left and right differ in length, or by less than 45° in direction at angle zero, so do the mirrored limbs.

        Skeletons that are not their own mirror image at angle zero across any axis are mirrored by what the bones do:
        R becomes M R S, with a constant reflection S of each joint that takes the bone of one side to that of the other
        at zero, so that all bones point where the mirror images of their partners do. Twists about bones are those of
        the partner but for quarter turns, by which the motion's mean pose is nearest to its mirror image. In files with
        all bones along x at angle zero, and in poses fitted to keypoints of points with names of one's own, that is so.

        Partners are found by name: "LeftArm" and "RightArm", "hand_left", "lfemur" and "rfemur", "L_Hip", "hip.L",
        "hip_l". Joints without a side in their name are on the middle line.

        Parameters
        ----------
        axis : {"x", "y", "z"}, default="x"
            The axis that points to the left or to the right at angle zero, and across which the world is mirrored.
            Where it points up in the world, the world is mirrored across the first of the others.

        Returns
        -------
        Motion
            Of the same skeleton. Mirrored twice, it is the same motion.

        Raises
        ------
        ValueError
            If names state a side and there is no partner, or more than one; if partners have other parents than
            partners; if the skeleton is its own mirror image across another axis at angle zero; if a joint with fewer
            than three dofs cannot take the rotation. The message names the joints, and the remedy.

        Examples
        --------
        >>> from skpose import Motion
        >>> from skpose.datasets import humanoid
        >>> wave = Motion(humanoid(), [[0.0] * 42], frame_rate=60).to_pandas()
        >>> wave["left_upper_arm_rz"] = 2.5
        >>> other = Motion(humanoid(), wave, frame_rate=60).mirrored().to_pandas()
        >>> other[["left_upper_arm_rz", "right_upper_arm_rz"]].to_numpy() + 0.0
        array([[ 0. , -2.5]])
        """
        image = mirror_poses(self.skeleton, self.angles, self.root_angles, self.root_axes, axis, self.up)
        return replace(
            self,
            angles=image.poses,
            root_positions=self.root_positions * image.world,
            root_angles=image.root_angles,
            root_axes=image.root_axes,
            seen=None if self.seen is None else self.seen[:, image.partners],
        )

    def select(self, joints: str | Iterable[str] | None = None, *, drop: str | Iterable[str] = ()) -> "Motion":
        """Return the motion of some joints, and of those that carry them, see `Skeleton.select`.

        Parameters
        ----------
        joints : str or iterable of str, default=None
            Joints to keep, with all between them and the root; None keeps all.
        drop : str or iterable of str, default=()
            Joints to leave out, each with all that it carries.

        Returns
        -------
        Motion
            Of the smaller skeleton; the root moves as before.
        """
        part = self.skeleton.select(joints, drop=drop)
        return replace(
            self,
            skeleton=part,
            angles=self.angles[:, part.columns_in(self.skeleton)],
            seen=self._seen_of(part),
        )

    def _seen_of(self, skeleton: Skeleton) -> np.ndarray | None:
        """Return which joints of another skeleton were seen, by their names."""
        return seen_of(self.seen, self.skeleton.joint_names, skeleton.joint_names)

    def play(self) -> Page:
        """Return a page that plays the motion: ``skpose.view.player(motion)``.

        The player has options, and shows several motions, side by side or aligned in time.

        Returns
        -------
        skpose.view.Page
            In a notebook it shows itself; elsewhere ``motion.play().open()`` shows it in the browser, and
            ``motion.play().save("view.html")`` writes it.

        Raises
        ------
        ValueError
            If the motion has no frames.

        See Also
        --------
        skpose.view.player : The page, with its options.

        Examples
        --------
        >>> from skpose.datasets import make_gait
        >>> make_gait(1, 1, random_state=0).motions[0].play().note
        '1 motion, positions within 0.027 mm'
        """
        return displays.player(self)

    def _repr_html_(self) -> str:
        """Return some poses of the motion as a picture, which a notebook shows."""
        return displays.strip(self)

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

        See Also
        --------
        Motion.without_root : The inverse.

        Notes
        -----
        An orientation is R = heading · tilt, of which the tilt is the rotation about a horizontal axis (the swing
        without the twist). Upside down, where there is no heading, small movements change the tilt much.

        Where the skeleton at angle zero stands along another axis than `up`, by the names of head and feet, as in AMASS
        with z up, R = heading · tilt · S, with the quarter turn S that lets it stand, which remains a part of the
        poses. Without S the heading of a person who leans to a side would be wrong, and leans that differ by 10° would
        differ by 14°.

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
        up = self.up if up is None else up
        vectors, left, axes = root_parts(
            self.root_angles, self.root_axes, part, up, upright_turn(self.skeleton, check_up(up))
        )
        skeleton = with_root_joint(self.skeleton)
        return replace(
            self,
            skeleton=skeleton,
            angles=np.concatenate([vectors, self.angles], axis=1),
            root_angles=left,
            root_axes=axes,
            up=up,
            seen=self._seen_of(skeleton),
        )

    def without_root(self) -> "Motion":
        """Return the motion with its poses' orientation of the root given back to the root, the inverse of `with_root`.

        The joint at the root is left out, and its rotation becomes a part of the root's: all other joints stay where
        they are in the world. This holds for poses that `with_root` did not make too, such as means.

        Returns
        -------
        Motion
            On the skeleton without the joint at the root. The root has the axes of the motion where these are three,
            and otherwise "xyz"; its angles are continuous in time.

        Raises
        ------
        ValueError
            If the skeleton has no such joint: of length zero, at the root, with three dofs, and carrying all others.

        See Also
        --------
        Motion.with_root : Make the orientation of the root a part of the poses.

        Examples
        --------
        >>> import numpy as np
        >>> from skpose import Motion, Skeleton
        >>> motion = Motion(Skeleton.chain(2), [[0, 0]], 30, root_angles=np.radians([[30, 60, 0]]))
        >>> there = motion.with_root("tilt").without_root()
        >>> there.skeleton == motion.skeleton
        True
        >>> np.degrees(there.root_angles).round(3) + 0.0, there.root_axes
        (array([[30., 60.,  0.]]), 'xyz')
        """
        skeleton, columns = without_root_joint(self.skeleton)
        own = root_joint_orientations(self.skeleton, self.angles)
        root = root_orientations(self.root_angles, self.root_axes) * own
        axes = self.root_axes if len(self.root_axes) == 3 else "xyz"
        root_angles, root_axes = continuous_root_angles(root, axes)
        return replace(
            self,
            skeleton=skeleton,
            angles=self.angles[:, columns],
            root_angles=root_angles,
            root_axes=root_axes,
            seen=self._seen_of(skeleton),
        )
