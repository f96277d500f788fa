"""A smooth curve through key poses: a cubic spline of the geodesics between the keys, unrolled onto a flat space.

P. E. Jupp, J. T. Kent, "Fitting smooth paths to spherical data", Applied Statistics 36(1), 1987: parallel transport
along the geodesics unrolls the keys onto a flat space, a spline is drawn there, and the result is rolled back. Only the
difference from the geodesics is transported. With s from 0 to 1 between two keys h seconds apart, a cubic with slopes m
at the keys, where the geodesic has slopes a, differs from the geodesic by

    D(s) = h (s (1 − s)² (m − a) − s² (1 − s) (m' − a')),

a velocity at the geodesic's pose at s. The joints follow it for one unit of time at constant turning rates; the
exponential map would do as well, but costs as much as a geodesic and turns straight limbs far for small movements. The
slopes are those of the natural cubic spline, from its tridiagonal equations with transported vectors.
"""

from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from skpose._compiled.path.exponential import tangent_space
from skpose._compiled.pose.tree import Tree
from skpose._utils.parallel import in_threads
from skpose._utils.validation import limits_of
from skpose.geodesics._geodesic import GeodesicResult
from skpose.kinematics._chart import jacobian_at, retract
from skpose.kinematics._forward import weighted_positions
from skpose.kinematics._tree import from_tree_order, to_tree_order, tree_of
from skpose.skeleton import Skeleton

NEAR_END = 1e-4  # step from the ends of a geodesic, relative to its length, for its velocity there
DAMPING = 0.5  # 1/rad, of turns that hardly move the joints, relative to the size of the whole displacement
SOLUTIONS = 3  # steps of iterated Tikhonov regularisation
ROUNDING = 1e-12  # of the metric tensor, relative to its trace
ORTHONORMAL = 2  # Newton-Schulz iterations; error below 1e-4 for a turn by 20°


class Segment(NamedTuple):
    """What the spline needs of the geodesic from one key to the next."""

    path: GeodesicResult
    first: np.ndarray  # (n, rank) basis of the tangent space at the first key
    last: np.ndarray
    leaving: np.ndarray  # (rank,) first velocity per unit of s, in the basis
    arriving: np.ndarray
    forth: np.ndarray  # (rank at the last key, rank at the first) parallel transport


def spline_between(
    geodesics: list[GeodesicResult],
    spans: np.ndarray,
    shares: list[np.ndarray],
    skeleton: Skeleton,
    joint_limits: str,
    n_jobs: int,
) -> list[np.ndarray]:
    """Poses between keys, for each segment.

    `spans` are the times between keys, and `shares` the fractions s of the poses of each segment. With
    joint_limits="enforce" the angles are clipped.
    """
    segments = in_threads((partial(_segment_of, path, skeleton) for path in geodesics), n_jobs)
    slopes = natural_slopes(segments, spans)

    def draw(i: int) -> np.ndarray:
        segment, h = segments[i], spans[i]
        start = h * slopes[i] - segment.leaving
        end = h * slopes[i + 1] - segment.arriving
        drawn = _draw(segment, start, end, shares[i], skeleton)
        return np.clip(drawn, *limits_of(skeleton).T) if joint_limits == "enforce" else drawn

    return in_threads((partial(draw, i) for i in range(len(geodesics))), n_jobs)


def natural_slopes(segments: list[Segment], spans: np.ndarray) -> list[np.ndarray]:
    """Slopes of the natural cubic spline at the keys, per unit of time, in the basis of each key.

    Solves h' m₋ + 2 (h + h') m + h m₊ = 3 (h' a + h a'), with h the time before a key and h' the time after it.
    """
    n = len(segments)
    share, right = np.empty(n), []
    share[0], slope = 0.5, 1.5 * segments[0].leaving / spans[0]
    right.append(slope)
    for i in range(1, n + 1):
        before = segments[i - 1]
        arriving, brought = before.arriving / spans[i - 1], before.forth @ right[i - 1]
        if i == n:
            right.append((3.0 * arriving - brought) / (2.0 - share[i - 1]))
            break
        h, after = spans[i - 1], spans[i]
        pivot = 2.0 * (h + after) - after * share[i - 1]
        leaving = segments[i].leaving / after
        share[i] = h / pivot
        right.append((3.0 * (after * arriving + h * leaving) - after * brought) / pivot)
    slopes = [right[n]]
    for i in range(n - 1, -1, -1):
        slopes.append(right[i] - share[i] * (segments[i].forth.T @ slopes[-1]))
    return slopes[::-1]


def _segment_of(path: GeodesicResult, skeleton: Skeleton) -> Segment:
    tree = tree_of(skeleton)
    shares = np.linspace(0.0, 1.0, len(path.path))
    ends = np.array([NEAR_END, 2.0 * NEAR_END])
    poses = path._at(np.concatenate([shares, ends, 1.0 - ends]))
    near = weighted_positions(poses[[0, -4, -3, len(shares) - 1, -2, -1]], skeleton)
    difference = np.array([-1.5, 2.0, -0.5]) / NEAR_END
    bases = _bases(tree, poses[: len(shares)])
    forth = np.eye(bases[0].shape[1])
    for before, after in pairwise(bases):
        forth = _step(before, after) @ forth
    first, last = bases[0], bases[-1]
    leaving, arriving = first.T @ (difference @ near[:3]), -last.T @ (difference @ near[3:])
    return Segment(path, first, last, leaving, arriving, _turn(forth @ leaving, arriving) @ forth)


def _turn(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The smallest rotation from the direction of a to the direction of b.

    A geodesic transports its own velocity; this makes the transport along its chords do so exactly.
    """
    lengths = np.linalg.norm(a), np.linalg.norm(b)
    if min(lengths) == 0.0:
        return np.eye(len(a))
    u, v = a / lengths[0], b / lengths[1]
    if u @ v < 0.0:  # chords too long to determine the rotation
        return np.eye(len(a))
    return np.eye(len(a)) - np.outer(u + v, u + v) / (1.0 + u @ v) + 2.0 * np.outer(v, u)


def _draw(segment: Segment, start: np.ndarray, end: np.ndarray, shares: np.ndarray, skeleton: Skeleton) -> np.ndarray:
    """Poses of the spline between two keys, from the differences of its slopes from the geodesic's at the ends."""
    tree = tree_of(skeleton)
    nodes, at = np.unique(np.concatenate([np.linspace(0.0, 1.0, len(segment.path.path)), shares]), return_inverse=True)
    base = segment.path._at(nodes)
    bases = _bases(tree, base)
    steps = [_step(before, after) for before, after in pairwise(bases)]
    forth = _transport(bases[0].T @ (segment.first @ start), steps)
    back = _transport(bases[-1].T @ (segment.last @ end), [step.T for step in steps[::-1]])[::-1]
    poses, dofs = base.copy(), to_tree_order(tree, base)
    drawn = at[len(at) - len(shares) :]
    for k in sorted(set(drawn)):
        s = nodes[k]
        off = bases[k] @ (s * (1.0 - s) ** 2 * forth[k] - s**2 * (1.0 - s) * back[k])
        poses[k] = from_tree_order(tree, _displace(tree, dofs[k], off), base[k])
    return poses[drawn]


def _displace(tree: Tree, pose: np.ndarray, displacement: np.ndarray) -> np.ndarray:
    """Displace the joints of a pose by one damped Gauss-Newton step.

    Iterated Tikhonov regularisation keeps straight limbs from twisting far for a small movement. The damping vanishes
    with the displacement, so the velocity of the curve is exact where it meets the geodesic.
    """
    size = np.linalg.norm(displacement)
    if size == 0.0:
        return pose
    jacobian = jacobian_at(tree, pose, True)
    matrix = jacobian.T @ jacobian
    matrix[np.diag_indices(len(matrix))] += max((DAMPING * size) ** 2, ROUNDING * np.trace(matrix))
    inverse, turns = np.linalg.inv(matrix), np.zeros(len(matrix))
    for _ in range(SOLUTIONS):
        turns += inverse @ (jacobian.T @ (displacement - jacobian @ turns))
    return retract(tree, pose, turns, True)


def _transport(vector: np.ndarray, steps: list[np.ndarray]) -> list[np.ndarray]:
    """A vector at all poses of a path, transported from the first."""
    carried = [vector]
    for step in steps:
        carried.append(step @ carried[-1])
    return carried


def _bases(tree: Tree, poses: np.ndarray) -> list[np.ndarray]:
    return [tangent_space(tree, pose) for pose in to_tree_order(tree, poses)]


def _step(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Transport between two close tangent spaces: the projection, made orthonormal (Newton, Schulz).

    A direction in only one of the two spaces, as near a straight limb, becomes short.
    """
    matrix = after.T @ before
    for _ in range(ORTHONORMAL):
        matrix = 1.5 * matrix - 0.5 * matrix @ (matrix.T @ matrix)
    return matrix
