"""Metrics of motions, which compare frames by their neighbours: velocities, jerks, centred positions.

They turn a motion into one row of numbers per frame; the Euclidean distance of two rows is the distance of two frames.
Functions that compare whole motions use these rows instead of poses.
"""

from numbers import Real
from typing import ClassVar

import numpy as np

from skpose._compiled.pose.tree import Tree
from skpose._utils.sklearn import Interval
from skpose.kinematics._forward import weighted_positions
from skpose.metrics._angle import Angle
from skpose.metrics._metric import Metric
from skpose.skeleton import Skeleton


class MotionMetric(Metric):
    """A distance between frames of motions: the Euclidean distance of the rows of `encode_motion`."""

    of_windows: ClassVar[bool]  # whether a row depends on nearby frames only
    least_frames: ClassVar[int] = 2

    encode = Angle.encode
    measure = Angle.measure
    encode_work = Angle.encode_work

    def n_codes(self, tree: Tree, n_dofs: int) -> int:
        """The number of columns of the rows."""
        return n_dofs

    def lower_bound(self) -> Metric:
        """This metric itself."""
        return self

    def tree_for(self, skeleton: Skeleton | None, dtype: np.dtype | None = None) -> Tree:
        """An empty tree, since `encode_motion` has placed the joints."""
        return super().tree_for(None, dtype)

    def encode_motion(self, poses: np.ndarray, skeleton: Skeleton, times: np.ndarray | None) -> np.ndarray:
        """The rows of a motion.

        Parameters
        ----------
        poses : ndarray of shape (n_frames, n_dofs)
            Poses: joint angles, rad.
        skeleton : Skeleton
            Their skeleton.
        times : ndarray of shape (n_frames,) or None
            Time of each frame, s; None if unknown.

        Returns
        -------
        ndarray of shape (n_frames, 3 n_joints)
            One row per frame, in float64.

        Raises
        ------
        ValueError
            For a motion with too few frames, or without times where they are needed.
        """
        if (n := len(poses)) < self.least_frames:
            raise ValueError(f"{self.name!r} needs {self.least_frames} frames or more, got {n}")
        return self._rows(weighted_positions(poses, skeleton), times)

    def _rows(self, positions: np.ndarray, times: np.ndarray | None) -> np.ndarray:
        """The rows (n_frames, 3 n_joints) of joint positions (n_frames, 3 n_joints)."""
        raise NotImplementedError

    def _require_times(self, times: np.ndarray | None) -> np.ndarray:
        if times is None:
            raise ValueError(f"{self.name!r} needs a frame rate: pass Motion(skeleton, array, frame_rate)")
        return times


class Velocity(MotionMetric):
    r"""Distance between the velocities of all joints, :math:`\|\dot F(a) - \dot F(b)\|_2`, m/s; of motions only.

    F stacks the joint positions, in the axes of the root, times the square roots of the joints' weights. The velocity
    at a frame is the difference of the positions half a `span` after and before it, over the time between them; near
    the ends of a motion the span is cut.

    Parameters
    ----------
    span : float, default=0.25
        The time over which velocities are measured, s, rounded up to a whole number of frames on each side: 0.25 s are
        0.333 s at 12 Hz and 0.267 s at 30 Hz. At least the time from the previous to the next frame. Noise of σ m in
        the positions becomes √2 σ / span m/s.

    See Also
    --------
    Centered : Positions less their mean.
    skpose.motion_distances : Distances between motions.

    Notes
    -----
    Motions need a frame rate and two frames, so arrays are refused. Where frames are missing, as after
    ``on_nan="drop"``, the velocity is that across the gap. Positions are in the axes of the root, so the speed of the
    root does not count.

    Examples
    --------
    There and back: the same poses with opposite velocities of about 1 m/s. The result is half of 2 m/s, since distances
    are divided by the frames of both motions:

    >>> import numpy as np
    >>> from skpose import Motion, Skeleton, motion_distances
    >>> arm, turn = Skeleton.chain(1), np.linspace(0, 1, 31)[:, None]
    >>> there, back = Motion(arm, turn, 30), Motion(arm, turn[::-1], 30)
    >>> motion_distances([there, back], metric="velocity").round(2)
    array([[0.  , 0.96],
           [0.96, 0.  ]])
    """

    name = "velocity"
    unit = "m/s"
    of_windows = True
    equation = r"\|\dot F(a) - \dot F(b)\|_2"

    _parameter_constraints: ClassVar[dict] = {"span": [Interval(Real, 0, None, closed="neither")]}

    def __init__(self, span: float = 0.25):
        self.span = span

    def _rows(self, positions: np.ndarray, times: np.ndarray | None) -> np.ndarray:
        """Velocities, m/s."""
        times = self._require_times(times)
        frames, last = np.arange(len(times)), len(times) - 1
        step = np.diff(times).min()
        reach = step * max(1, round(self.span / step / 2)) + step / 2  # half a step, as times are rounded
        before = np.minimum(np.searchsorted(times, times - reach), frames - 1).clip(0)
        after = np.maximum(np.searchsorted(times, times + reach, side="right") - 1, frames + 1).clip(max=last)
        return (positions[after] - positions[before]) / (times[after] - times[before])[:, np.newaxis]


class Jerk(MotionMetric):
    r"""Distance between the jerks of all joints, :math:`\|\dddot F(a) - \dddot F(b)\|_2`, m/s³; of motions only.

    F stacks the joint positions, in the axes of the root, times the square roots of the joints' weights. The jerk is
    their third derivative in time, of the cubic polynomial through four consecutive frames: the one before a frame, it,
    and the two after it; at the ends of a motion the first and the last four. Jitter has high jerks, human movement
    has low ones.

    See Also
    --------
    Velocity : Velocities of the joints.
    skpose.statistics.outlier_test : Tell generated from recorded motions.
    skpose.motion_distances : Whole motions by dynamic time warping.

    Notes
    -----
    Independent noise of σ m in the positions becomes 4.5 σ r³ m/s³ at a frame rate of r Hz: jitter of 2 mm at 30 Hz
    becomes 240 m/s³. Do not compare jerks at two frame rates. Motions need a frame rate and four frames, so arrays are
    refused; missing frames are taken into account.

    Examples
    --------
    An arm of 1 m that swings, and the same with jitter of 2 mm, at 30 Hz:

    >>> import numpy as np
    >>> from skpose import Motion, Skeleton, motion_distances
    >>> arm, swing = Skeleton.chain(1), np.sin(np.linspace(0, 6, 61))[:, None]
    >>> jitter = np.random.default_rng(0).normal(0, 0.002, swing.shape)
    >>> smooth, jittery = Motion(arm, swing, 30), Motion(arm, swing + jitter, 30)
    >>> for metric in ("position", "velocity", "jerk"):
    ...     print(motion_distances([smooth], [jittery], metric=metric, alignment="frames").round(4))
    [[0.0015]]
    [[0.0082]]
    [[136.7756]]
    """

    name = "jerk"
    unit = "m/s³"
    of_windows = True
    least_frames = 4
    equation = r"\|\dddot F(a) - \dddot F(b)\|_2"

    def _rows(self, positions: np.ndarray, times: np.ndarray | None) -> np.ndarray:
        """Jerks, m/s³: six times the third divided differences."""
        times, rows = self._require_times(times), positions
        for order in (1, 2, 3):
            rows = order * np.diff(rows, axis=0) / (times[order:] - times[:-order])[:, np.newaxis]
        return rows[np.arange(-1, len(times) - 1).clip(0, len(rows) - 1)]


class Centered(MotionMetric):
    r"""Distance between joint positions less their mean, :math:`\|F(a) - \bar F_a - F(b) + \bar F_b\|_2`, m.

    For motions only. F stacks the joint positions, in the axes of the root, times the square roots of the joints'
    weights, and the mean is over all frames of a motion: posture does not count, only movement. `find_motion` and
    ``alignment="subsequence"`` refuse it, since the mean of a window is unknown before the window is found.

    See Also
    --------
    Velocity : Velocities of the joints.
    skpose.motion_distances : Distances between motions.

    Examples
    --------
    The same small movement, with the arm down and with the arm up:

    >>> import numpy as np
    >>> from skpose import Skeleton, motion_distances
    >>> wave = 0.1 * np.sin(np.linspace(0, 6, 31))[:, None]
    >>> for metric in ("position", "centered"):
    ...     print(motion_distances([wave], [wave + np.pi], skeleton=Skeleton.chain(1), metric=metric).round(2))
    [[1.]]
    [[0.04]]
    """

    name = "centered"
    equation = r"\|F(a) - \bar F_a - F(b) + \bar F_b\|_2"
    of_windows = False

    def _rows(self, positions: np.ndarray, times: np.ndarray | None) -> np.ndarray:
        """Positions less their mean, m."""
        return positions - positions.mean(axis=0)
