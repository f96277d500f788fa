"""What compiled code sees of a skeleton, and of how a metric goes from pose to pose: named arrays."""

import math
from typing import NamedTuple

import numpy as np

TWO_PI = 2.0 * math.pi


class Tree(NamedTuple):
    """A skeleton as flat arrays; frame 0 and joint 0 are the root, unrotated and at the origin.

    Frames stand in batches, tips last; joints in the order of their frames; dofs depth first.
    """

    frame_parent: np.ndarray  # (n_frames,) frame that each frame turns with
    first_dof: np.ndarray  # (n_frames,) dofs of frame f are first_dof[f]:end_dof[f]; the root's frame has none
    end_dof: np.ndarray  # (n_frames,)
    fixed_axis: np.ndarray  # (n_frames,) axis about which a frame without dofs is turned: 0, 1 or 2
    fixed_turn: np.ndarray  # (n_frames, 4) cosine and sine of that turn, and of half of it
    weight: np.ndarray  # (n_frames,) summed squared lengths of the bones fixed to the frame, m²
    pivot: np.ndarray  # (n_frames,) joint about which the frame turns
    batch_dofs: np.ndarray  # (n_batches,) how many dofs the frames of a batch have
    first_frame: np.ndarray  # (n_batches + 1,) frames of batch b are first_frame[b]:first_frame[b + 1]; then the tips
    branch: np.ndarray  # (n_branches + 1,) dofs of branch b, all that hangs on one frame at the root, lie between
    column: np.ndarray  # (n_dofs,) where a pose holds each dof
    sign: np.ndarray  # (n_dofs,) -1 where the frame's axis points against the skeleton's, else 1
    shift: np.ndarray  # (n_dofs,) what to add to the angle, rad
    joint_parent: np.ndarray  # (n_joints + 1,) joint before each joint
    joint_frame: np.ndarray  # (n_joints + 1,) frame in which the joint's offset is given
    offset: np.ndarray  # (n_joints + 1, 3) from the joint before, m; of a tip's joint the last is nought
    place: np.ndarray  # (n_joints + 1,) the skeleton's number of each joint, counted from one
    first_run: np.ndarray  # (n_frames + 1,) runs of frame f are runs[first_run[f]:first_run[f + 1]]
    runs: np.ndarray  # (n_runs, 2) the dofs of a frame and of those before it, as ranges


class Plan(NamedTuple):
    """What a step reads of a Tree, without references to count."""

    n_dofs: int
    n_batches: int
    first_moving: int  # joint; those before are fixed to the root
    first_tip: int  # joint
    n_joints: int  # the root's included
    frame_parent: np.ndarray
    first_dof: np.ndarray
    end_dof: np.ndarray
    fixed_axis: np.ndarray
    fixed_turn: np.ndarray
    batch_dofs: np.ndarray
    first_frame: np.ndarray
    joint_parent: np.ndarray
    joint_frame: np.ndarray
    offset: np.ndarray


class Steps(NamedTuple):
    """How a metric walks from one pose to another."""

    n_steps: int  # chords along the curve
    half_turn: float  # a larger difference of angles is taken the other way round; inf takes all as they are
    cos_turn: float  # of π / n_steps
    sin_turn: float

    @classmethod
    def of(cls, n_steps: int, wrap: bool) -> "Steps":
        turn = math.pi / n_steps
        return cls(n_steps, math.pi if wrap else math.inf, math.cos(turn), math.sin(turn))
