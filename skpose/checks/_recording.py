"""A motion with what several checks need of it, each computed once."""

from functools import cached_property

import numpy as np

from skpose.kinematics._anatomy import Anatomy, find_anatomy
from skpose.kinematics._floor import leg_length
from skpose.scores._plausibility import Soles, soles_of
from skpose.skeleton import Motion
from skpose.skeleton._rest import size_of

LEG, TALL = 0.9, 1.7  # m, of the person to whom all thresholds apply


class Recording:
    """A motion, its person and its points."""

    def __init__(self, motion: Motion):
        self.motion, self.skeleton = motion, motion.skeleton
        self.names = ("root", *motion.skeleton.joint_names)
        self.person: Anatomy = find_anatomy(motion.skeleton)
        leg = leg_length(motion.skeleton, self.person)
        self.leg = leg
        self.scale = leg / LEG if leg else size_of(motion.skeleton) / TALL or 1.0
        self.step = 1.0 / motion.frame_rate

    @cached_property
    def world(self) -> np.ndarray:
        """The root and all joints (n_frames, n_joints + 1, 3) in the axes of the motion, m."""
        return np.concatenate([self.motion.root_positions[:, None], self.motion.positions()], axis=1)

    @cached_property
    def points(self) -> np.ndarray:
        """The root and all joints (n_frames, n_joints + 1, 3), up last, m, as of a person with legs of 0.9 m."""
        return self.world[..., [("xyz".index(self.motion.up) + i) % 3 for i in (1, 2, 3)]] / self.scale

    @cached_property
    def unwrapped(self) -> np.ndarray:
        """The angles of joints and root (n_frames, n_angles) without jumps."""
        motion = self.motion.unwrap()
        return np.concatenate([motion.angles, motion.root_angles], axis=1)

    @cached_property
    def around_root(self) -> np.ndarray:
        """The root, and the joints minus the root."""
        return np.concatenate([self.points[:, :1], self.points[:, 1:] - self.points[:, :1]], axis=1)

    @cached_property
    def gaps(self) -> np.ndarray:
        """Whether frames are missing (n_frames − 1,) after each frame."""
        return np.diff(self.motion.frame_numbers) > 1

    @cached_property
    def travels(self) -> bool:
        """Whether the root has positions."""
        return bool(np.ptp(self.motion.root_positions, axis=0).max(initial=0.0) > 1e-6)

    @cached_property
    def soles(self) -> Soles | None:
        """Both feet, if they are known, m, as of a person with legs of 0.9 m."""
        if not {"left_ankle", "right_ankle"} <= self.person.joints.keys() or not self.travels:
            return None
        points, heights, floors, times = soles_of(self.motion)
        return Soles(points / self.scale, heights / self.scale, floors / self.scale, times)

    @cached_property
    def upright(self) -> np.ndarray:
        """Whether the root is at least half a leg above the lowest joint (n_frames,)."""
        return self.points[:, 0, 2] - self.points[..., 2].min(axis=1) > LEG / 2.0

    def at(self, mark: str) -> np.ndarray:
        """Positions (n_frames, 3) of a landmark."""
        return self.points[:, self.person.joints[mark] + 1]

    def has(self, *marks: str) -> bool:
        return all(mark in self.person.joints for mark in marks)
