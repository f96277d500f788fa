"""A skeleton, and the steps between two poses, as compiled code sees them: named arrays."""

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from skpose._compiled.simd.shared import shared_structure

TWO_PI = 2.0 * math.pi
# Kinds of batches: of ball joints, and of hinges about y or z. The others' kind is their number of angles, 0 to 3.
BALL, HINGE = 4, 5


@shared_structure
class Tree(NamedTuple):
    """A skeleton as flat arrays; frame 0 and joint 0 are the root, unrotated and at the origin.

    What carries no weight, and nothing that does, is left out, with its dofs.

    Frames stand in batches, leaves last; joints in the order of their frames; dofs depth first.
    """

    frame_parent: np.ndarray  # (n_frames,) the frame that carries each frame
    first_dof: np.ndarray  # (n_frames,) dofs of frame f are first_dof[f]:end_dof[f]; the root's frame has none
    end_dof: np.ndarray  # (n_frames,)
    end_angle: np.ndarray  # (n_frames,) the same end, counting only the dofs that are angles
    ball: np.ndarray  # (n_frames,) index of a ball joint's frame among those, else -1
    reference: np.ndarray  # (n_frames, 4) quaternion (w, x, y, z) of a ball joint before its rotation vector
    ball_axes: np.ndarray  # (n_frames, 3, 3) rotation of a ball joint's columns into its frame's rotation vector
    single_axis: np.ndarray  # (n_frames,) axis, 0 to 2, of the one angle of a frame, or of its constant rotation
    fixed_rotation: np.ndarray  # (n_frames, 4) cosine and sine of its angle, and of half of it
    weight: np.ndarray  # (n_frames,) squared lengths of the bones fixed to the frame, times their weights, summed, m²
    pivot: np.ndarray  # (n_frames,) joint at the centre of the frame's rotation
    batch_kind: np.ndarray  # (n_batches,) how many angles the frames of a batch have, or BALL
    first_frame: np.ndarray  # (n_batches + 1,) frames of batch b are first_frame[b]:first_frame[b + 1]; then the leaves
    column: np.ndarray  # (n_dofs,) column of each dof in an array of poses
    sign: np.ndarray  # (n_dofs,) -1 where the frame's axis points against the skeleton's, else 1
    shift: np.ndarray  # (n_dofs,) constant added to the angle, rad
    angle_dof: np.ndarray  # (n_angles,) the dofs that are angles
    slide: np.ndarray  # (n_frames,) index of the slide whose dof is the frame's, which does not rotate; else -1
    slide_dof: np.ndarray  # (n_slides,) the dofs that are displacements, m
    slide_axis: np.ndarray  # (n_slides, 3) their directions, in the axes of their frames
    joint_slide: np.ndarray  # (n_joints + 1,) index of the slide that moves the joint from its offset, else -1
    ball_frame: np.ndarray  # (n_balls,) the frames of ball joints
    first_joint: np.ndarray  # (n_ranges + 1,) of ranges of moving joints except leaves, three kinds in turns:
    # any, of ball joints along x, and of slides
    first_leaf: np.ndarray  # (n_leaf_ranges + 1,) of ranges of leaves' joints of one weight; then of ball joints
    joint_parent: np.ndarray  # (n_joints + 1,) parent of each joint
    joint_frame: np.ndarray  # (n_joints + 1,) frame in which the joint's offset is given
    offset: np.ndarray  # (n_joints + 1, 3) from the parent, m; z is zero for a leaf's joint
    scale: np.ndarray  # (n_joints + 1,) square root of the weight of each joint, the factor of its positions
    code_joint: np.ndarray  # (n_joints + 1,) index of each joint in the code of positions, plus one
    first_dof_range: (
        np.ndarray
    )  # (n_frames + 1,) ranges of frame f: dof_ranges[first_dof_range[f]:first_dof_range[f + 1]]
    dof_ranges: np.ndarray  # (n_dof_ranges, 2) dofs of a frame and of its ancestors: first, and the one behind the last

    @property
    def n_joints(self) -> int:
        """The number of joints that count, without the root; for Python."""
        return len(self.offset) - 1


class Plan(NamedTuple):
    """The part of a Tree that a step reads, as addresses: no references to count in an inner loop."""

    n_angles: int
    n_balls: int
    n_slides: int
    n_batches: int
    n_ranges: int
    n_leaf_ranges: int
    first_moving: int  # joint; the ones before it are fixed to the root
    first_ball_leaf: int  # joint
    n_joints: int  # the root's included
    frame_parent: np.ndarray
    first_dof: np.ndarray
    end_dof: np.ndarray
    end_angle: np.ndarray
    ball: np.ndarray
    single_axis: np.ndarray
    fixed_rotation: np.ndarray
    batch_kind: np.ndarray
    first_frame: np.ndarray
    first_joint: np.ndarray
    first_leaf: np.ndarray
    joint_parent: np.ndarray
    joint_frame: np.ndarray
    joint_slide: np.ndarray
    slide_axis: np.ndarray
    offset: np.ndarray
    scale: np.ndarray


class StepArrays(NamedTuple):
    """The rows of a scratch array that a step uses; shapes as for one pose."""

    C: Any  # (n_angles,) cosines of the angles
    S: Any  # (n_angles,) sines of the angles
    A: Any  # (n_angles,) 1 − cos δ of the step
    B: Any  # (n_angles,) sin δ of the step
    Q: Any  # (9 n_balls,) see `step.advance`
    H: Any  # (6 n_frames,) two rows of every orientation
    P: Any  # (3 n_joints + 3,) positions
    X: Any  # (n_slides,) displacements along slides
    D: Any  # (n_slides,) their steps


class Squares(NamedTuple):
    """Sums of squared displacements of joints."""

    scale: Any  # of the joints that the three sums are of
    first: Any  # by coordinate: three sums, so that no addition waits for the one before
    second: Any
    third: Any
    total: Any  # of the joints of other scales, weighted


class Steps(NamedTuple):
    """The steps along the straight line from one pose to another."""

    n_steps: int  # chords along the curve
    half_turn: float  # π: differences of angles are wrapped to ± this; inf: they are not
    cos_turn: float  # of π / n_steps
    sin_turn: float
    slerp: np.ndarray  # (2, SLERP_TERMS) see `slerp_series`

    @classmethod
    def of(cls, n_steps: int, wrap: bool) -> "Steps":
        n_steps = int(n_steps)  # numba has a type for each of numpy's integers
        turn = math.pi / n_steps
        return cls(n_steps, math.pi if wrap else math.inf, math.cos(turn), math.sin(turn), slerp_series(n_steps))

    def __reduce__(self) -> tuple:  # an array that joblib maps from a file is read-only, another type to numba
        return Steps.of, (self.n_steps, self.half_turn < math.inf)


SLERP_TERMS = 19


@functools.cache
def slerp_series(n_steps: int) -> np.ndarray:
    """The coefficients in t of two functions of φ, half the angle of a ball joint's line, 1 + t = 2 (1 − cos φ).

    With φ between 0 and π/2, t is between −1 and 1. They are sin(φ/N) / sin φ and (1 − cos(φ/N)) / (1 − cos φ). Both
    are analytic up to cos φ = −1, t = 3: interpolation in Chebyshev's points gains a factor 3 + √8 per degree.
    """

    def angle(t: np.ndarray) -> np.ndarray:
        return 2.0 * np.arcsin(np.sqrt(0.25 * (1.0 + t)))

    def shares(t: np.ndarray) -> np.ndarray:
        return np.sin(angle(t) / n_steps) / np.sin(angle(t))

    def curvatures(t: np.ndarray) -> np.ndarray:
        return (np.sin(0.5 * angle(t) / n_steps) / np.sin(0.5 * angle(t))) ** 2

    series = (np.polynomial.chebyshev.chebinterpolate(f, SLERP_TERMS - 1) for f in (shares, curvatures))
    return np.stack([np.polynomial.chebyshev.cheb2poly(one) for one in series])
