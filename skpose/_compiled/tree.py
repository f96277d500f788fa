"""A skeleton, and the steps between two poses, as compiled code sees them: named arrays."""

import math
from typing import Any, NamedTuple

import numpy as np

TWO_PI = 2.0 * math.pi


class Tree(NamedTuple):
    """A skeleton as flat arrays; frame 0 and joint 0 are the root, unrotated and at the origin.

    Frames stand in batches, tips last; joints in the order of their frames; dofs depth first.
    """

    frame_parent: np.ndarray  # (n_frames,) the frame that carries each frame
    first_dof: np.ndarray  # (n_frames,) dofs of frame f are first_dof[f]:end_dof[f]; the root's frame has none
    end_dof: np.ndarray  # (n_frames,)
    fixed_axis: np.ndarray  # (n_frames,) axis of the constant rotation of a frame without dofs: 0, 1 or 2
    fixed_rotation: np.ndarray  # (n_frames, 4) cosine and sine of its angle, and of half of it
    weight: np.ndarray  # (n_frames,) summed squared lengths of the bones fixed to the frame, m²
    pivot: np.ndarray  # (n_frames,) joint at the centre of the frame's rotation
    batch_dofs: np.ndarray  # (n_batches,) how many dofs the frames of a batch have
    first_frame: np.ndarray  # (n_batches + 1,) frames of batch b are first_frame[b]:first_frame[b + 1]; then the tips
    branch: np.ndarray  # (n_branches + 1,) dofs of branch b, one child of the root and all below it, lie between
    column: np.ndarray  # (n_dofs,) column of each dof in an array of poses
    sign: np.ndarray  # (n_dofs,) -1 where the frame's axis points against the skeleton's, else 1
    shift: np.ndarray  # (n_dofs,) constant added to the angle, rad
    joint_parent: np.ndarray  # (n_joints + 1,) parent of each joint
    joint_frame: np.ndarray  # (n_joints + 1,) frame in which the joint's offset is given
    offset: np.ndarray  # (n_joints + 1, 3) from the parent, m; z is zero for a tip's joint
    skeleton_joint: np.ndarray  # (n_joints + 1,) index of each joint in the skeleton, plus one
    first_run: np.ndarray  # (n_frames + 1,) runs of frame f are runs[first_run[f]:first_run[f + 1]]
    runs: np.ndarray  # (n_runs, 2) dofs of a frame and of its ancestors, as ranges


class Plan(NamedTuple):
    """The part of a Tree that a step reads, as addresses: no references to count in an inner loop."""

    n_dofs: int
    n_batches: int
    first_moving: int  # joint; the ones before it are fixed to the root
    first_tip: int  # joint
    n_joints: int  # the root's included
    frame_parent: np.ndarray
    first_dof: np.ndarray
    end_dof: np.ndarray
    fixed_axis: np.ndarray
    fixed_rotation: np.ndarray
    batch_dofs: np.ndarray
    first_frame: np.ndarray
    joint_parent: np.ndarray
    joint_frame: np.ndarray
    offset: np.ndarray


class Parts(NamedTuple):
    """The rows of a scratch array that a step uses; their shapes are those of one pose."""

    C: Any  # (n_dofs,) cosines of the angles
    S: Any  # (n_dofs,) sines of the angles
    A: Any  # (n_dofs,) 1 − cos δ of the step
    B: Any  # (n_dofs,) sin δ of the step
    H: Any  # (6 n_frames,) two rows of every orientation
    P: Any  # (3 n_joints + 3,) positions


class Steps(NamedTuple):
    """The steps along the straight line from one pose to another."""

    n_steps: int  # chords along the curve
    half_turn: float  # π: differences of angles are wrapped to ± this; inf: they are not
    cos_turn: float  # of π / n_steps
    sin_turn: float

    @classmethod
    def of(cls, n_steps: int, wrap: bool) -> "Steps":
        turn = math.pi / n_steps
        return cls(n_steps, math.pi if wrap else math.inf, math.cos(turn), math.sin(turn))
