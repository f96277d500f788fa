"""The result of inverse kinematics."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.warnings import warn
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._root import root_angles_of
from skpose.skeleton._upright import complaint_of_up


@dataclass(frozen=True, eq=False, repr=False)
class FittedPoses:
    """Poses at given positions of the joints, as `inverse_kinematics` finds them.

    In the world the joints are at R·F(θ) + o, with the pose θ, the rotation R of the root and its position o.

    Attributes
    ----------
    skeleton : Skeleton
        The skeleton.
    poses : ndarray of shape (n_frames, n_dofs)
        Joint angles, rad.
    residuals : ndarray of shape (n_frames, n_joints)
        Distance of each joint from its given position, m; NaN if it is not seen.
    converged : ndarray of shape (n_frames,) of bool
        Whether no small change of the pose would bring the joints nearer. False where nothing is seen.
    root_positions : ndarray of shape (n_frames, 3)
        Positions of the root, m.
    root_rotations : ndarray of shape (n_frames, 3)
        Orientations of the root as rotation vectors, rad.
    n_iter : ndarray of shape (n_frames,) of int
        Iterations.
    frame_rate : float or None
        Frames per second, Hz, of the `Keypoints`; None for an array.
    up : {"x", "y", "z"} or None
        The axis of the world that points up in the `Keypoints`; None for an array.

    Examples
    --------
    >>> from skpose import Skeleton, inverse_kinematics
    >>> inverse_kinematics([[[1, 0, 0], [1, 1, 0]]], Skeleton.chain(2))
    FittedPoses(1 frame, 2 of 2 joints seen, 0 mm off in the mean, all converged)
    """

    skeleton: Skeleton
    poses: np.ndarray
    residuals: np.ndarray
    converged: np.ndarray
    root_positions: np.ndarray
    root_rotations: np.ndarray
    n_iter: np.ndarray
    frame_rate: float | None = None
    up: Literal["x", "y", "z"] | None = None

    def __len__(self) -> int:
        return len(self.poses)

    def __repr__(self) -> str:
        seen = ~np.isnan(self.residuals)
        frames = f"{len(self)} frame{'s' if len(self) != 1 else ''}"
        joints = f"{seen.any(axis=0).sum()} of {self.skeleton.n_joints} joints seen"
        off = f"{round(1e3 * float(np.mean(self.residuals[seen])), 3) if seen.any() else np.nan:g} mm off in the mean"
        left = int((~self.converged).sum())
        return f"FittedPoses({frames}, {joints}, {off}, {f'{left} not converged' if left else 'all converged'})"

    def to_motion(self, frame_rate: float | None = None, up: Literal["x", "y", "z"] | None = None) -> Motion:
        """Convert the poses to a motion.

        Parameters
        ----------
        frame_rate : float, default=None
            Frames per second, Hz. None takes the rate of the `Keypoints`; arrays of positions need it.
        up : {"x", "y", "z"}, default=None
            The axis of the world that points up. None takes the axis of the `Keypoints`; for an array, y.

        Returns
        -------
        Motion
            With the root's positions and orientations; the latter as angles about "xyz", see `Motion.unwrap`.

        Raises
        ------
        ValueError
            If the frame rate is not known.

        Warns
        -----
        UserWarning
            If the axis that points up is not known, and in nearly all frames the poses stand along another axis than y.
        """
        rate = self.frame_rate if frame_rate is None else frame_rate
        if rate is None:
            raise ValueError("the frame rate is not known: pass frame_rate=, in Hz")
        angles, axes = np.zeros((len(self), 3)), "xyz"
        if len(self):
            angles, axes = root_angles_of(Rotation.from_rotvec(self.root_rotations), angles, axes)
        known = self.up if up is None else up
        seen = ~np.isnan(self.residuals)
        motion = Motion(self.skeleton, self.poses, rate, self.root_positions, angles, axes, up=known or "y", seen=seen)
        if known is None and (complaint := complaint_of_up(motion, "y")):
            warn(complaint)
        return motion
