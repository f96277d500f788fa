"""A motion with what several measures need of it, each computed once."""

from functools import cached_property

import numpy as np

from skpose.kinematics._anatomy import BALL, LEG as LEGS, SIDES, TOE, find_anatomy
from skpose.kinematics._floor import leg_length
from skpose.scores._plausibility import Soles, soles_of
from skpose.skeleton import Motion
from skpose.skeleton._rest import size_of

LEG, TALL = 0.9, 1.7  # m, of the person to whom all thresholds apply


class Unknown(Exception):
    """A motion does not show what a measure needs."""


class Recording:
    """A motion, its person and its points."""

    def __init__(self, motion: Motion):
        self.motion, self.skeleton, self.times = motion, motion.skeleton, motion.times
        self.names = ("root", *motion.skeleton.joint_names)
        person = find_anatomy(motion.skeleton)
        self.joints, self.leg = person.joints, leg_length(motion.skeleton, person)
        self.scale = self.leg / LEG or size_of(motion.skeleton) / TALL or 1.0
        self.step = 1.0 / motion.frame_rate
        # The root and all joints (n_frames, n_joints + 1, 3) in the axes of the motion, m; then up last, of a person
        # with legs of 0.9 m; and then without the root's movement, except for the root.
        world = np.concatenate([motion.root_positions[:, None], motion.positions()], axis=1)
        self.points = world[..., [("xyz".index(motion.up) + i) % 3 for i in (1, 2, 3)]] / self.scale
        self.around_root = np.concatenate([self.points[:, :1], self.points[:, 1:] - self.points[:, :1]], axis=1)

    def need(self, n: int) -> None:
        """Refuse motions with fewer frames."""
        if len(self.points) < n:
            raise Unknown

    @cached_property
    def unwrapped(self) -> np.ndarray:
        """The angles of joints and root (n_frames, n_angles) without jumps."""
        motion = self.motion.unwrap()
        return np.concatenate([motion.angles, motion.root_angles], axis=1)

    @cached_property
    def soles(self) -> Soles:
        """Both feet, m, as of a person with legs of 0.9 m, of a motion whose root has positions."""
        if not self.leg or not np.ptp(self.motion.root_positions, axis=0).any():
            raise Unknown
        points, heights, floors = soles_of(self.motion)
        return Soles(points / self.scale, heights / self.scale, floors / self.scale)

    @cached_property
    def upright(self) -> np.ndarray:
        """Whether the root is at least half a leg above the lowest joint (n_frames,)."""
        return self.points[:, 0, 2] - self.points[..., 2].min(axis=1) > LEG / 2.0

    def limbs(self, *marks: str) -> np.ndarray:
        """Positions (2, n_marks, n_frames, 3) of landmarks, left and right."""
        names = [[f"{side}_{mark}" for mark in marks] for side in SIDES]
        if not {*names[0], *names[1]} <= self.joints.keys():
            raise Unknown
        columns = [[self.joints[name] + 1 for name in side] for side in names]
        return self.points[:, columns].transpose(1, 2, 0, 3)

    def legs(self) -> np.ndarray:
        """Hips, knees, ankles and balls or toes (2, 4, n_frames, 3)."""
        return self.limbs(*LEGS, BALL if f"left_{BALL}" in self.joints else TOE)
