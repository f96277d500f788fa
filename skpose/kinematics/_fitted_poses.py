"""The result of inverse kinematics."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import root_angles_of


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
        Distance of each joint from its given position, m; NaN where it is not seen.
    converged : ndarray of shape (n_frames,) of bool
        Whether no small change of the pose would bring the joints nearer. False where nothing is seen.
    root_positions : ndarray of shape (n_frames, 3)
        Positions of the root, m.
    root_rotations : ndarray of shape (n_frames, 3)
        Orientations of the root as rotation vectors, rad.
    n_iter : ndarray of shape (n_frames,) of int
        Iterations.

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

    def __len__(self) -> int:
        return len(self.poses)

    def __repr__(self) -> str:
        seen = ~np.isnan(self.residuals)
        frames = f"{len(self)} frame{'s' if len(self) != 1 else ''}"
        joints = f"{seen.any(axis=0).sum()} of {self.skeleton.n_joints} joints seen"
        off = f"{round(1e3 * float(np.mean(self.residuals[seen])), 3) if seen.any() else np.nan:g} mm off in the mean"
        left = int((~self.converged).sum())
        return f"FittedPoses({frames}, {joints}, {off}, {f'{left} not converged' if left else 'all converged'})"

    def to_motion(self, frame_rate: float, up: Literal["x", "y", "z"] = "y") -> Motion:
        """Return the poses as a motion.

        Parameters
        ----------
        frame_rate : float
            Frames per second, Hz, such as that of the `Keypoints`.
        up : {"x", "y", "z"}, default="y"
            The axis of the world that points up, such as that of the `Keypoints`.

        Returns
        -------
        Motion
            With the root's positions and orientations; the latter as angles about "xyz", see `Motion.unwrap`.
        """
        angles, axes = np.zeros((len(self), 3)), "xyz"
        if len(self):
            angles, axes = root_angles_of(Rotation.from_rotvec(self.root_rotations), angles, axes)
        return Motion(self.skeleton, self.poses, frame_rate, self.root_positions, angles, axes, up=up)
