"""The poses whose places on links are nearest to given positions."""

import functools
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.kinematics import FittedPoses
from skpose.kinematics._forward import joint_positions
from skpose.kinematics._inverse import Task, problem_of
from skpose.robots._stance import Place, Stance, with_places
from skpose.skeleton import Skeleton
from skpose.skeleton._bone import with_columns

LEVER = 0.2  # m, from a point on a pelvis or a chest to the points that show its orientation
FASTEST = 20.0  # rad/s, of a joint; the G1 reaches 20 to 37
CORNERS = LEVER * np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


class Target(NamedTuple):
    """A place on a link, and where it should be in each frame."""

    place: Place
    position: np.ndarray  # (n_frames, 3)
    weight: float
    group: str = ""


def targets_of_link(
    stance: Stance, joint: int, origin: np.ndarray, at: np.ndarray, axes: np.ndarray, weight: float
) -> list[Target]:
    """Targets around a point of a link that show its position (n_frames, 3) and its axes (n_frames, 3, 3)."""
    return [Target(Place(joint, origin + stance.axes @ corner), at + axes @ corner, weight) for corner in CORNERS]


def solve(
    skeleton: Skeleton, targets: Sequence[Target], rest: np.ndarray, stiffness: float, times: np.ndarray
) -> FittedPoses:
    """Find the poses of a motion whose places are nearest to their targets, each frame starting from the one before.

    The poses are of the joints that carry places; the places are the last joints. The limits of the skeleton are
    enforced. `stiffness` is the regularization of `inverse_kinematics`, m/rad.
    """
    part = with_places(skeleton, [target.place for target in targets])
    n, first = len(times), part.n_joints - len(targets)
    wished = np.full((n, part.n_joints, 3), np.nan)
    wished[:, first:] = np.stack([target.position for target in targets], axis=1)
    weights = np.concatenate([np.zeros(first), [target.weight for target in targets]])
    limits = "ignore" if part.limits is None else "enforce"
    problem = problem_of(wished, part, weights, rest[part.columns_in(skeleton)], None, limits, stiffness)
    changes = FASTEST * np.diff(times, prepend=-np.inf)
    problem = replace(problem, changes=changes, rules=problem.rules._replace(tries_first=True))
    return problem.fit(problem.solve(Task(0, n, 0, n)))  # one task, so that no frame depends on where a task ends


def positions_in(found: FittedPoses, skeleton: Skeleton, places: Sequence[Place]) -> np.ndarray:
    """The positions (n_frames, n_places, 3) of other places on the same joints."""
    part = with_places(skeleton, places)
    poses = np.zeros((len(found), skeleton.n_dofs))  # other angles do not move these places
    poses[:, found.skeleton.columns_in(skeleton)] = found.poses
    points = joint_positions(poses[:, part.columns_in(skeleton)], part)[:, -len(places) :]
    roots = Rotation.from_rotvec(found.root_rotations).as_matrix()
    return np.asarray(points @ roots.transpose(0, 2, 1) + found.root_positions[:, None])


def rest_pose(skeleton: Skeleton) -> np.ndarray:
    """The pose (n_dofs,) nearest to all angles zero within the limits."""
    rest = np.zeros(skeleton.n_dofs)
    return rest if skeleton.limits is None else np.clip(rest, *skeleton.limits.T)


@functools.lru_cache(maxsize=16)
def hold_at_rest(skeleton: Skeleton, joints: tuple[int, ...]) -> Skeleton:
    """Keep some joints of a skeleton at rest, by limits."""
    rest, bones = rest_pose(skeleton), list(skeleton.bones)
    for joint, (bone, columns) in enumerate(with_columns(skeleton.bones)):
        if joint in joints:
            bones[joint] = bone._replace(limits=[(angle, angle) for angle in rest[columns]])
    return Skeleton(bones, skeleton.offset_frame)
