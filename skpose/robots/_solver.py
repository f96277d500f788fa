"""The poses whose places on links are nearest to given positions."""

import functools
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.kinematics import forward_kinematics
from skpose.kinematics._inverse import Task, problem_of
from skpose.robots._stance import Place, with_places
from skpose.skeleton import Skeleton

LEVER = 0.2  # m, from a point on a pelvis or a chest to the points that show its orientation
CORNERS = LEVER * np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


class Targets:
    """Places on the links of a skeleton, their positions in each frame, and weights."""

    def __init__(self, axes: np.ndarray):
        self.axes = axes  # (3, 3) of the skeleton at angle zero: forward, left, up
        self.places: list[Place] = []
        self.positions: list[np.ndarray] = []
        self.weights: list[float] = []
        self.groups: dict[str, list[int]] = {}

    def add(self, place: Place, position: np.ndarray, weight: float, group: str) -> None:
        """Add a place with its positions (n_frames, 3) to a group."""
        self.groups.setdefault(group, []).append(len(self.places))
        self.places.append(place)
        self.positions.append(position)
        self.weights.append(weight)

    def add_link(
        self, joint: int, origin: np.ndarray, at: np.ndarray, axes: np.ndarray, weight: float, group: str = "links"
    ) -> None:
        """Add places on a link around a point that show its position (n_frames, 3) and its axes (n_frames, 3, 3)."""
        for corner in CORNERS:
            self.add(Place(joint, origin + self.axes @ corner), at + axes @ corner, weight, group)


class Solution(NamedTuple):
    """Poses of the joints that carry places."""

    skeleton: Skeleton  # those joints, and one to each place
    poses: np.ndarray
    roots: np.ndarray  # (n_frames, 3, 3) orientations
    origins: np.ndarray  # (n_frames, 3)
    residuals: np.ndarray  # (n_frames, n_places) m
    converged: np.ndarray  # (n_frames,) bool

    def positions(self, skeleton: Skeleton, places: Sequence[Place]) -> np.ndarray:
        """The positions (n_frames, n_places, 3) of other places on the same joints."""
        part, column = with_places(skeleton, places), {name: i for i, name in enumerate(self.skeleton.dof_names)}
        poses = np.zeros((len(self.poses), part.n_dofs))
        for i, name in enumerate(part.dof_names):
            if name in column:  # others do not move these places
                poses[:, i] = self.poses[:, column[name]]
        points = forward_kinematics(poses, part)[:, -len(places) :]
        return np.asarray(points @ self.roots.transpose(0, 2, 1) + self.origins[:, None])


def solve(
    skeleton: Skeleton, targets: Targets, rest: np.ndarray, stiffness: float, times: np.ndarray, fastest: float
) -> Solution:
    """Find the poses of a motion whose places are nearest to their targets, each frame starting from the one before.

    The limits of the skeleton are enforced. `stiffness` is the regularization of `inverse_kinematics`, m/rad, and
    `fastest` the largest speed of an angle, rad/s.
    """
    part = with_places(skeleton, targets.places)
    n, first = len(targets.positions[0]), part.n_joints - len(targets.places)
    wished = np.full((n, part.n_joints, 3), np.nan)
    wished[:, first:] = np.stack(targets.positions, axis=1)
    weights = np.concatenate([np.zeros(first), targets.weights])
    start = rest[[skeleton.dof_names.index(name) for name in part.dof_names]]
    limits = "ignore" if part.limits is None else "enforce"
    problem = problem_of(wished, part, weights, start, None, limits, stiffness)
    changes = fastest * np.diff(times, prepend=-np.inf)
    problem = replace(problem, changes=changes, rules=problem.rules._replace(tries_first=True))
    found = problem.fit(problem.solve(Task(0, n, 0, n)))  # one task, so that no frame depends on where a task ends
    roots = Rotation.from_rotvec(found.root_rotations).as_matrix()
    residuals = found.residuals[:, first:]
    return Solution(part, found.poses, roots, found.root_positions, residuals, found.converged)


def rest_within_limits(skeleton: Skeleton, joint_limits: str) -> np.ndarray:
    """The pose (n_dofs,) nearest to all angles zero within the enforced limits."""
    rest = np.zeros(skeleton.n_dofs)
    if joint_limits == "ignore" or skeleton.limits is None:
        return rest
    return np.clip(rest, *skeleton.limits.T)


@functools.lru_cache(maxsize=16)
def hold_at_rest(skeleton: Skeleton, joints: tuple[int, ...], joint_limits: str) -> Skeleton:
    """Give a skeleton the enforced limits, and keep some joints at rest by limits."""
    rest = rest_within_limits(skeleton, joint_limits)
    bones = [bone._replace(limits=None) if joint_limits == "ignore" else bone for bone in skeleton.bones]
    first = np.cumsum([0, *(bone.n_dofs for bone in bones)])
    for joint in joints:
        angles = rest[first[joint] : first[joint + 1]]
        bones[joint] = bones[joint]._replace(limits=[(angle, angle) for angle in angles])
    return Skeleton(bones, skeleton.offset_frame)
