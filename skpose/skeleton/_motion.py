"""A motion: poses of one skeleton in time, and the movement of the root."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from operator import index
from typing import TYPE_CHECKING, Any, Literal, NoReturn

import numpy as np

from skpose._utils.typing import ArrayLike, DataFrame
from skpose._utils.units import warn_of_degrees
from skpose._utils.upper_layers import Keypoints, Page, upper_layers
from skpose._utils.validation import (
    check_choice,
    check_column_names,
    check_frame_rate,
    check_integer,
    check_skeleton,
)
from skpose.skeleton._bone import Bone, is_axes, kept_inside
from skpose.skeleton._cycle import close_cycle, describe_opening, repeat_cycle
from skpose.skeleton._interpolation import (
    interpolate_linearly,
    interpolate_poses,
    join_seen,
    seen_of,
)
from skpose.skeleton._mirror import mirror_poses
from skpose.skeleton._rest import mismatch
from skpose.skeleton._root import (
    continuous_root_angles,
    has_root_joint,
    heading,
    root_joint_orientations,
    root_orientations,
    with_root_joint,
)
from skpose.skeleton._rotations import convert, remove_jumps
from skpose.skeleton._skeleton import Skeleton
from skpose.skeleton._upright import upright_turn

HEADED = 1e-6  # rad, tolerance of a constant heading


@dataclass(frozen=True, repr=False, eq=False)
class Motion:
    """Poses of a skeleton at a constant frame rate.

    Parameters
    ----------
    skeleton : Skeleton
        The skeleton of all poses.
    angles : array-like of shape (n_frames, n_dofs)
        Joint angles, rad (m for slides), one column per name in ``skeleton.dof_names``; the columns of a dataframe
        must have these names.
    frame_rate : float
        Frames per second, Hz.
    root_positions : array-like of shape (n_frames, 3), default=None
        Positions of the root, m; None is the origin.
    root_angles : array-like of shape (n_frames, k), default=None
        Rotations of the root, rad, one column per letter of `root_axes`; None is unrotated.
    root_axes : str, default="xyz"
        The axes of `root_angles` in the notation of `Bone`: lower case extrinsic, upper case intrinsic.
    frame_numbers : array-like of shape (n_frames,) of ints, default=None
        Number of each frame, increasing; None is 0, 1, 2, … A gap in the numbers marks missing frames, as in a file
        read with ``on_nan="drop"``.
    up : {"x", "y", "z"}, default="y"
        The axis of the world that points up, for `with_root`; "y" is usual in BVH and AMC files.
    root_name : str, default="root"
        The name of the root in the file from which the motion was read.
    seen : array-like of shape (n_frames, n_joints) of bool, or bool, default=None
        For poses fitted to positions, as by `skpose.inverse_kinematics`: the joints with a position in each frame;
        True is all of them. Positions do not show all rotations, such as the twist of a straight arm. None is a
        recording of rotations.

    Attributes
    ----------
    fitted : bool
        Whether the poses were fitted to positions: whether `seen` is known.
    times : ndarray of shape (n_frames,)
        Time of each frame, s: its number over the frame rate.

    Raises
    ------
    ValueError
        For shapes that do not fit each other, columns of a dataframe out of order, numbers that are not finite, a frame
        rate that is not positive.

    Warns
    -----
    UserWarning
        If `angles` look like degrees, see `skpose.pose_distances`.

    See Also
    --------
    skpose.io.load_motion : Read a motion from a BVH, AMC or AMASS file.
    skpose.io.save_bvh : Write a motion as a BVH file.
    skpose.kinematics.retarget : Transfer a motion to another skeleton.

    Notes
    -----
    Distances use `angles` alone: global position and orientation are not part of a pose. `with_root` adds the
    orientation.

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
            raise ValueError(
                f'root_axes must be letters such as "xyz" or "ZXY", each at most once, got {self.root_axes!r}'
            )
        check_choice("up", self.up, ("x", "y", "z"))
        check_column_names(self.angles, self.skeleton, "angles")
        n_frames = len(self.angles)
        widths = {"angles": self.skeleton.n_dofs, "root_positions": 3, "root_angles": len(self.root_axes)}
        for name, width in widths.items():
            given = getattr(self, name)
            array = np.zeros((n_frames, width)) if given is None else np.asarray(given, dtype=np.float64)
            if array.shape != (n_frames, width):
                raise ValueError(f"{name} must have shape ({n_frames}, {width}), got {array.shape}")
            if not np.isfinite(array).all():
                raise ValueError(f"{name} must be finite, but frame {np.argwhere(~np.isfinite(array))[0, 0]} is not")
            object.__setattr__(self, name, array)
        numbers = np.arange(n_frames) if self.frame_numbers is None else np.asarray(self.frame_numbers)
        is_whole = numbers.dtype.kind in "iu" or not n_frames
        if numbers.shape != (n_frames,) or not is_whole or (np.diff(numbers.astype(np.int64)) <= 0).any():
            raise ValueError(f"frame_numbers must be {n_frames} increasing integers, got {numbers}")
        object.__setattr__(self, "frame_numbers", numbers.astype(np.int64))
        if self.seen is not None:
            seen, shape = np.asarray(self.seen), (n_frames, self.skeleton.n_joints)
            if seen.dtype != bool or seen.shape not in ((), shape):
                expected = f"True, None or bool of shape {shape}"
                raise ValueError(f"seen must be {expected}, got {seen.dtype} of shape {seen.shape}")
            object.__setattr__(self, "seen", np.broadcast_to(seen, shape).copy())
        warn_of_degrees(None, self.skeleton, angles=self.angles)

    @property
    def times(self) -> np.ndarray:
        """Time of each frame, s."""
        return self.frame_numbers / self.frame_rate

    @property
    def fitted(self) -> bool:
        """True for poses fitted to positions."""
        return self.seen is not None

    def __len__(self) -> int:
        return len(self.angles)

    def __getitem__(self, frames: int | np.integer | slice) -> "Motion":
        """Select frames: ``motion[10:50]``, ``motion[::2]`` at half the rate, ``motion[3]`` as one frame."""
        n, step = len(self), 1
        if isinstance(frames, slice):
            step = abs(frames.indices(n)[2])
        else:
            frame = range(n)[index(frames)]
            frames = slice(frame, frame + 1)
        numbers = self.frame_numbers[frames]
        numbers = np.abs(numbers - numbers[:1])
        if (numbers % step).any():
            raise ValueError(f"frames are missing, so every {step}th is not evenly spaced: use resample")
        return replace(
            self,
            angles=self.angles[frames],
            frame_rate=self.frame_rate / step,
            root_positions=self.root_positions[frames],
            root_angles=self.root_angles[frames],
            frame_numbers=numbers // step,
            seen=None if self.seen is None else self.seen[frames],
        )

    def __array__(self, *arguments: object, **options: object) -> NoReturn:
        raise TypeError("a Motion is not an array: pass its poses, motion.angles")

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
        """Concatenate motions in time.

        Motions are not moved: there is a jump if one ends elsewhere than the next begins.

        Parameters
        ----------
        motions : iterable of Motion
            At least one; with the same skeleton, frame rate, root axes and up axis.

        Returns
        -------
        Motion
            With the frames of all.

        Raises
        ------
        ValueError
            If the motions differ in one of these.
        """
        motions = list(motions)
        if not motions:
            raise ValueError("concatenate needs at least one motion, got none")
        first = motions[0]
        for i, motion in enumerate(motions[1:], start=1):
            if motion.skeleton != first.skeleton:
                difference = mismatch(first.skeleton, motion.skeleton) or "bones differ, use retarget first"
                raise ValueError(f"motions[{i}] has another skeleton than motions[0]: {difference}")
            for name in ("frame_rate", "root_axes", "up"):
                if getattr(motion, name) != getattr(first, name):
                    values = getattr(motion, name), getattr(first, name)
                    raise ValueError(f"motions[{i}] has {name} {values[0]!r}, but motions[0] has {values[1]!r}")
        joined: dict[str, Any] = {
            name: np.concatenate([getattr(motion, name) for motion in motions])
            for name in ("angles", "root_positions", "root_angles")
        }
        ends = np.cumsum([0] + [1 + motion.frame_numbers[-1] if len(motion) else 0 for motion in motions])
        numbers = np.concatenate([end + motion.frame_numbers for end, motion in zip(ends, motions, strict=False)])
        return replace(
            first,
            **joined,
            frame_numbers=numbers,
            seen=join_seen([motion.seen for motion in motions], list(map(len, motions))),
        )

    def resample(self, frame_rate: float) -> "Motion":
        """Resample the motion to another frame rate, from its first frame to the last time within it.

        Between two frames a joint with three dofs, and a root with three axes, rotates by the smallest angle (slerp).
        Other angles change linearly along their difference wrapped to [−π, π], so that a jump by 360° in a file is not
        a rotation. Angles of joints with one or two dofs stay within limits that exclude part of the circle: a robot's
        hinge turns from −170° to 160° through zero. New times that coincide with frames, as from 120 to 12 Hz, take
        these unchanged. Gaps of missing frames stay gaps. Without a low-pass filter, a lower rate aliases faster
        movements.

        Parameters
        ----------
        frame_rate : float
            The new rate, Hz.

        Returns
        -------
        Motion
            On the same skeleton.
        """
        check_frame_rate(frame_rate)
        bones, numbers, step = self.skeleton.bones, self.frame_numbers, self.frame_rate / frame_rate
        # 1e-9 allows for rounding: a rate that divides the old one exactly keeps the last frame.
        first, last = (numbers[0], numbers[-1]) if len(self) else (0, -1)
        new = np.arange(int(np.ceil(first / step - 1e-9)), int(np.floor(last / step + 1e-9)) + 1)
        at = new * step  # in numbers of the old frames
        near = np.rint(at)
        at = np.where(np.abs(at - near) < 1e-9, near, at)
        before = np.searchsorted(numbers, at, side="right") - 1
        part = at - numbers[before]
        known = (part == 0.0) | np.isin(numbers[before] + 1, numbers)  # not between frames that are missing
        rows = (before + part)[known]  # not necessarily whole
        around = np.floor(rows).astype(int), np.ceil(rows).astype(int)  # a joint is seen if it is in both
        return replace(
            self,
            angles=interpolate_poses(bones, self.angles, rows, kept_inside(bones, self.angles)),
            frame_rate=frame_rate,
            root_positions=interpolate_linearly(self.root_positions, rows),
            root_angles=interpolate_poses((self._root,), self.root_angles, rows),
            frame_numbers=new[known],
            seen=None if self.seen is None else self.seen[around[0]] & self.seen[around[1]],
        )

    def to_cycle(self, *, endpoint: bool = False) -> "Motion":
        """Turn the motion into a cycle: its last frame is its first one, moved along the floor.

        `repeat` continues it without a jump, and so do programs that loop a motion from the place where it ends. The
        difference between end and start is distributed evenly over time: each joint, and the tilt of the root, rotates
        about a fixed axis; hinges change by their angle; the height of the root changes linearly. The first frame
        changes by half of it, the last by half in the other direction. The step of the root along the floor and the
        change of its heading stay.

        Parameters
        ----------
        endpoint : bool, default=False
            Whether the last frame is the first pose again, as in a stride from heel strike to heel strike with both
            included. False: the last frame is the one before, as in slices ``motion[start:stop]`` and the results of
            `segment_repetitions`. A frame is then added, at the mean of the velocities of the first and the last step.
            As in `numpy.linspace`.

        Returns
        -------
        Motion
            With one frame more than the motion, or as many.

        Raises
        ------
        ValueError
            For fewer than three frames; if the poses themselves change their heading, as with ``with_root("whole")``.

        Warns
        -----
        UserWarning
            If the last pose is the first one and `endpoint` is False. If the motion is not one whole cycle: the end is
            more than a fifth as far from the first pose as the farthest pose, and than one and a half usual steps.

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
        return self._with_own_axes(close_cycle(self.with_root("whole"), endpoint))

    def repeat(self, n: int) -> "Motion":
        """Repeat a cycle n times, each from the place and with the heading at which the one before ends.

        The last frame of a cycle and the first of the next are one pose, which is kept once.

        Parameters
        ----------
        n : int
            Number of repetitions, at least one.

        Returns
        -------
        Motion
            With n · (len(motion) − 1) + 1 frames.

        Raises
        ------
        ValueError
            If the last frame is not the first one, moved along the floor: if a joint, the tilt of the root or the
            height is off by more than a tenth of the largest change between two frames. See `to_cycle`.

        See Also
        --------
        Motion.to_cycle : Close a cycle.
        Motion.concatenate : Concatenate motions in time.

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
        whole = self.with_root("whole")
        if gap := describe_opening(whole):
            raise ValueError(f"repeat needs a cycle, whose ends are one pose, but {gap}: use motion.to_cycle() first")
        return self if n == 1 else self._with_own_axes(repeat_cycle(whole, n))

    def _with_own_axes(self, whole: "Motion") -> "Motion":
        """A motion whose root is a joint, with the root's axes of this one."""
        motion = whole.without_root()
        angles, axes = continuous_root_angles(root_orientations(motion.root_angles, motion.root_axes), self.root_axes)
        return replace(motion, root_angles=angles, root_axes=axes)

    def _check_heading(self, function: str, least: int) -> None:
        """Refuse motions with too few frames or with a changing heading in the poses."""
        if len(self) < least:
            raise ValueError(f"{function} needs at least {least} frames, got {len(self)}")
        if has_root_joint(self.skeleton) and not self.root_angles.any():
            ends = root_joint_orientations(self.skeleton, self.angles[[0, -1]])
            if abs(heading(ends[1:] * ends[:1].inv(), self.up)[0]) > HEADED:
                raise ValueError(
                    f"{function} needs the heading at the root, not in the poses: use without_root() first"
                )

    def unwrap(self) -> "Motion":
        """Remove jumps of the angles between frames.

        Jumps are those by 360°, those between the two Euler triples of one rotation, (a, b, c) and (a + π, π − b,
        c + π), and those by whole turns of rotation vectors; the root's angles too. Each frame gets the equivalent
        numbers nearest to the frame before; the first frame stays. An angle of a joint with one or two dofs stays if it
        is inside its limits in all frames and these exclude part of the circle, so that it cannot jump.

        Poses and distances do not change, except "angle", which takes angles literally. Filters, derivatives and plots
        of angles need continuous ones.

        Returns
        -------
        Motion
            On the same skeleton; angles may leave [−π, π].
        """
        kept = np.asarray(kept_inside(self.skeleton.bones, self.angles).all(axis=0))
        angles = remove_jumps(self.skeleton.bones, self.angles, kept)
        return replace(self, angles=angles, root_angles=remove_jumps((self._root,), self.root_angles))

    def to_rotvec(self) -> "Motion":
        """Convert joints of two or three Euler angles to ball joints, see `Skeleton.to_rotvec`.

        Positions do not change, nor do the root's angles. Rotation vectors are continuous in time: among equivalent
        vectors each frame has the one nearest to the frame before, which may be longer than π.

        Returns
        -------
        Motion
            On the skeleton ``motion.skeleton.to_rotvec()``.

        See Also
        --------
        Motion.to_euler : Convert ball joints to three Euler angles.

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
        skeleton = self.skeleton.to_rotvec()
        return self if skeleton == self.skeleton else self._on(skeleton)

    def to_euler(self, order: str) -> "Motion":
        """Convert ball joints to three Euler angles in one order, see `Skeleton.to_euler`.

        Positions do not change. Angles are continuous in time: among equivalent triples each frame has the one nearest
        to the frame before.

        Parameters
        ----------
        order : str
            Three different letters in the notation of `Bone`: "xyz" is extrinsic, "ZXY" intrinsic.

        Returns
        -------
        Motion
            On the skeleton ``motion.skeleton.to_euler(order)``. Joints with Euler angles keep theirs:
            ``motion.to_rotvec().to_euler(order)`` converts these too.

        Raises
        ------
        ValueError
            If the order is not three different letters in one case.

        See Also
        --------
        Motion.to_rotvec : Convert Euler angles to ball joints.

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
        """The motion on a skeleton that differs in the dofs of its bones only."""
        return replace(self, skeleton=skeleton, angles=convert(self.skeleton.bones, skeleton.bones, self.angles))

    def mirrored(self, axis: Literal["x", "y", "z"] = "x") -> "Motion":
        """Mirror the motion: exchange left and right.

        The mirror is the plane through the origin across an axis that points to the left or right at angle zero. With
        the reflection M, the world rotation R of a joint since angle zero becomes M R M of its partner on the other
        side, and so does the root's; its position p becomes M p. The skeleton stays: if left and right differ in
        length, or by less than 45° in direction at angle zero, so do the mirrored limbs.

        For skeletons that are not their own mirror image at angle zero across any axis, R becomes M R S, with a
        constant reflection S of each joint that takes bones at zero to the other side's bones. All bones then point to
        the mirror images of their partners; twists about bones are determined up to quarter turns, which are chosen
        such that the mean pose is nearest to its mirror image. Files with all bones along x at angle zero are such.

        Partners are found by name: "LeftArm" and "RightArm", "hand_left", "lfemur" and "rfemur", "L_Hip", "hip.L",
        "hip_l". Joints without a side in their name are on the middle line.

        Parameters
        ----------
        axis : {"x", "y", "z"}, default="x"
            The axis that points to the left or right at angle zero, across which the world is mirrored. If it points up
            in the world, the world is mirrored across the first of the other axes.

        Returns
        -------
        Motion
            On the same skeleton. Mirrored twice, it is the same motion.

        Raises
        ------
        ValueError
            If a joint with a side has no partner or several; if partners have parents that are not partners; if the
            skeleton is its own mirror image across another axis at angle zero; if a joint with fewer than three dofs
            cannot take the rotation.

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
        angles, root_angles, root_axes, signs, partners = mirror_poses(
            self.skeleton, self.angles, self.root_angles, self.root_axes, axis, self.up
        )
        return replace(
            self,
            angles=angles,
            root_positions=self.root_positions * signs,
            root_angles=root_angles,
            root_axes=root_axes,
            seen=None if self.seen is None else self.seen[:, partners],
        )

    def select(self, joints: str | Iterable[str] | None = None, *, drop: str | Iterable[str] = ()) -> "Motion":
        """Select some joints, with all joints between them and the root, see `Skeleton.select`.

        Parameters
        ----------
        joints : str or iterable of str, default=None
            Joints to keep, with all joints between them and the root; None keeps all.
        drop : str or iterable of str, default=()
            Joints to leave out, each with all that it carries.

        Returns
        -------
        Motion
            On the smaller skeleton; the root moves as before.
        """
        part = self.skeleton.select(joints, drop=drop)
        return replace(
            self,
            skeleton=part,
            angles=self.angles[:, part.columns_in(self.skeleton)],
            seen=seen_of(self, part),
        )

    def positions(self) -> np.ndarray:
        """Compute the positions of the joints in the world.

        Returns
        -------
        ndarray of shape (n_frames, n_joints, 3)
            Positions, m, of the joints ``skeleton.joint_names``; those of the root are ``root_positions``.

        See Also
        --------
        skpose.forward_kinematics : Positions relative to the root.

        Examples
        --------
        >>> import numpy as np
        >>> from skpose import Motion, Skeleton
        >>> upright = [[0, 0, np.pi / 2]]  # the root, rotated about z
        >>> motion = Motion(Skeleton.chain(2), [[0, 0]], 30, root_positions=[[0, 5, 0]], root_angles=upright)
        >>> motion.positions().round(3) + 0.0
        array([[[0., 6., 0.],
                [0., 7., 0.]]])
        """
        return np.asarray(upper_layers.world_positions(self))

    def to_keypoints(self) -> Keypoints:
        """Convert to the positions of the root and of all joints in the world.

        Returns
        -------
        Keypoints
            Points ``(root_name, *skeleton.joint_names)``. Frames that are left out in the motion are points that are
            not seen, and so are joints that `seen` marks as unknown.

        Examples
        --------
        >>> from skpose.datasets import make_gait
        >>> make_gait(1, 1, random_state=0)[0].to_keypoints()
        Keypoints(180 frames at 60 Hz, 3.0 s, 23 points)
        """
        points = np.concatenate([self.root_positions[:, None], self.positions()], axis=1)
        if self.seen is not None:
            points[:, 1:][~self.seen] = np.nan
        rows = self.frame_numbers - self.frame_numbers[:1]
        positions = np.full((rows[-1] + 1 if len(self) else 0, *points.shape[1:]), np.nan)
        positions[rows] = points
        names = self.root_name, *self.skeleton.joint_names
        return upper_layers.keypoints(positions, names, self.frame_rate, None, self.up)

    def play(self) -> Page:
        """Make a page that plays the motion: ``skpose.view.player(motion)``.

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
        return upper_layers.player(self)

    def to_pandas(self) -> DataFrame:
        """Convert the angles to a pandas DataFrame, one column for each dof and one row for each frame.

        Estimators with a skeleton refuse a dataframe whose columns are not the skeleton's dofs, in its order.

        Returns
        -------
        pandas.DataFrame of shape (n_frames, n_dofs)
            Angles, rad; columns ``skeleton.dof_names``, index the time of each frame, s.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        import pandas

        return pandas.DataFrame(self.angles, pandas.Index(self.times, name="time"), list(self.skeleton.dof_names))

    def with_root(
        self, part: Literal["tilt", "whole"] = "tilt", *, up: Literal["x", "y", "z"] | None = None
    ) -> "Motion":
        """Add the orientation of the root to the poses.

        The skeleton gets a first joint, "root": a ball joint of length zero at the root, the parent of the root's
        children. Its three columns are the orientation, whole or without the heading.

        Parameters
        ----------
        part : {"tilt", "whole"}, default="tilt"
            "tilt" leaves out the rotation about the vertical: motions in different directions have the same poses, but
            lying differs from standing. "whole" is the orientation in the world.
        up : {"x", "y", "z"}, default=None
            The axis of the world that points up; None is the motion's.

        Returns
        -------
        Motion
            The root keeps the heading, an angle about the axis that points up, or zero. The joint's name is "root",
            with underscores added if joints have this name already.

        See Also
        --------
        Motion.without_root : The inverse.

        Notes
        -----
        An orientation is R = heading · tilt, where the tilt is the rotation about a horizontal axis (the swing without
        the twist). Upside down, where the heading is undefined, small movements change the tilt much.

        If the skeleton at angle zero stands along another axis than `up`, by the names of head and feet, as in AMASS
        with z up, R = heading · tilt · S, with the quarter turn S that makes it stand, which remains a part of the
        poses. Without S, the heading of a person who leans sideways would be wrong.

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
        check_choice("part", part, ("tilt", "whole"))
        up = self.up if up is None else up
        check_choice("up", up, ("x", "y", "z"))
        skeleton, axes = with_root_joint(self.skeleton), up if part == "tilt" else self.root_axes
        left, vectors = np.zeros((len(self), len(axes))), np.zeros((len(self), 3))
        if len(self):
            orientations = root_orientations(self.root_angles, self.root_axes)
            if part == "tilt":
                left[:, 0] = heading(orientations * upright_turn(self.skeleton, up).inv(), up)
                orientations = root_orientations(left, axes).inv() * orientations
            vectors = orientations.as_rotvec()
        return replace(
            self,
            skeleton=skeleton,
            angles=np.concatenate([vectors, self.angles], axis=1),
            root_angles=left,
            root_axes=axes,
            up=up,
            seen=seen_of(self, skeleton),
        )

    def without_root(self) -> "Motion":
        """Move the orientation of the root from the poses back to the root, the inverse of `with_root`.

        The joint at the root is removed, and its rotation becomes part of the root's: positions in the world do not
        change. The poses need not come from `with_root`; they may be means of such.

        Returns
        -------
        Motion
            On the skeleton without the joint at the root. The root has the axes of the motion if these are three, and
            otherwise "xyz"; its angles are continuous in time.

        Raises
        ------
        ValueError
            If the skeleton lacks such a joint: at the root, of length zero, with three dofs, and carrying all others.

        See Also
        --------
        Motion.with_root : Add the orientation of the root to the poses.

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
        if not has_root_joint(self.skeleton):
            raise ValueError("without_root needs a motion of with_root, whose first joint carries all others")
        first, *others = self.skeleton.bones
        bones = tuple(bone._replace(parent=None) if bone.parent == first.name else bone for bone in others)
        skeleton = replace(self.skeleton, bones=bones)
        root = root_orientations(self.root_angles, self.root_axes) * root_joint_orientations(self.skeleton, self.angles)
        axes = self.root_axes if len(self.root_axes) == 3 else "xyz"
        root_angles, root_axes = continuous_root_angles(root, axes)
        return replace(
            self,
            skeleton=skeleton,
            angles=self.angles[:, skeleton.columns_in(self.skeleton)],
            root_angles=root_angles,
            root_axes=root_axes,
            seen=seen_of(self, skeleton),
        )
