"""The start of inverse kinematics: the root and, one after the other, the joints turned to where joints are seen.

Positions of all joints nearly are the pose: each joint can be turned to the ends of its bones, parents first. What this
leaves is small, and `step.minimise_pose` finds it. Hinges have two sides: those that are on the wrong one are found
by the distances that remain.
"""

import math

import numpy as np

from skpose._compiled.inverse.energy import TARGET, WORKSPACE, copy_state, place_state, start_at
from skpose._compiled.inverse.step import FIRST_DAMPING, FIT, Fit, minimise_pose
from skpose._compiled.pose.rotation import product, put_quaternion, quaternion_at, quaternion_of
from skpose._compiled.pose.tree import TWO_PI
from skpose._compiled.simd.jit import by_address, internal
from skpose._compiled.simd.lanes import copy_to
from skpose._compiled.simd.signatures import FLAG, INTEGER, MATRIX, VECTOR

ROOT = np.int64(1)  # frame that turns the root; not a literal: numba would compile its users once more
TIE = 1e-6  # of a rotation's products: smaller rotations fit better by this share
NOTHING = 1e-100  # m²
NO_LEVER = 1e-2  # of a hinge whose bone lies along its axis
REACHED = 1e-7  # distance of all joints together that is none, m
OFF, MAX_HINGES = 2.0, 3  # times the mean square, for hinges to be tried; so many of them after one ball joint
SQUARINGS = 30  # of a matrix whose largest eigenvalues may differ by 1e-6 only


@internal
def _greatest_eigenvector(A):
    """Find the eigenvector of the greatest eigenvalue of a matrix that is symmetric and positive definite.

    Powers of the matrix have the same eigenvectors; the greatest eigenvalue of a high one exceeds all others by far.
    LAPACK's rounding depends on the number of threads that it may use.
    """
    n = A.shape[0]
    for _ in range(SQUARINGS):
        A, before = np.zeros((n, n)), A / np.trace(A)
        for i in range(n):
            for j in range(n):
                for k in range(n):
                    A[i, j] += before[i, k] * before[k, j]
    best = 0
    for i in range(1, n):
        if A[i, i] > A[best, best]:
            best = i
    return A[best] / math.sqrt((A[best] ** 2).sum())


@internal
def _rotation_of(S):
    """The rotation Q, as a quaternion, with the largest Σ b·Q a, given S = Σ a bᵀ; of several the smallest.

    B. K. P. Horn, "Closed-form solution of absolute orientation using unit quaternions", Journal of the Optical Society
    of America A 4(4), 1987, doi:10.1364/JOSAA.4.000629.
    """
    size = 0.0
    for i in range(3):
        for k in range(3):
            size += abs(S[i, k])
    for i in range(3):
        S[i, i] += TIE * size
    trace, least = S[0, 0] + S[1, 1] + S[2, 2], 4.0 * size + NOTHING  # less than any eigenvalue
    N = (trace + least) * np.eye(4)
    for i in range(3):
        following, last = (i + 1) % 3, (i + 2) % 3
        N[0, i + 1] = N[i + 1, 0] = S[following, last] - S[last, following]
        N[i + 1, i + 1] = 2.0 * S[i, i] - trace + least
        for k in range(i):
            N[k + 1, i + 1] = N[i + 1, k + 1] = S[i, k] + S[k, i]
    best = _greatest_eigenvector(N)
    return best[0], best[1], best[2], best[3]


@internal
def _add_products(S, weight, a, b):
    for i in range(3):
        for k in range(3):
            S[i, k] += weight * a[i] * b[k]


@internal
def _align_root(work, target):
    """Turn and move the root so that the joints that are seen are nearest to their positions, the pose as it is."""
    state, positions = work.here, target.positions
    place_state(work, state)
    total, a, b, S = 0.0, np.zeros(3), np.zeros(3), np.zeros((3, 3))
    for j in range(1, target.weights.shape[0]):
        total += target.weights[j]
        a += target.weights[j] * state.P[3 * j : 3 * j + 3]
        b += target.weights[j] * positions[j]
    a, b = a / total, b / total
    for j in range(1, target.weights.shape[0]):
        _add_products(S, target.weights[j], state.P[3 * j : 3 * j + 3] - a, positions[j] - b)
    _turn(work.tree, state, ROOT, _rotation_of(S))
    place_state(work, state)
    for j in range(1, target.weights.shape[0]):
        b -= target.weights[j] / total * state.P[3 * j : 3 * j + 3]
    copy_to(state.origin, b)


@internal
def _turn(tree, state, f, turn):
    """Turn a ball joint's frame by a rotation in the world, a quaternion; the frames have been placed."""
    axes, d, rotations = state.screws, tree.first_dof[f], state.rotations
    w, x, y, z = turn
    own = (
        w,
        axes[d, 0] * x + axes[d, 1] * y + axes[d, 2] * z,
        axes[d + 1, 0] * x + axes[d + 1, 1] * y + axes[d + 1, 2] * z,
        axes[d + 2, 0] * x + axes[d + 2, 1] * y + axes[d + 2, 2] * z,
    )
    put_quaternion(product(quaternion_at(rotations, f), own), rotations, f)


@internal
def _is_below(tree, f, ancestor):
    while f > ancestor:
        f = tree.frame_parent[f]
    return f == ancestor


@internal
def _sum_bones(tree, state, target, f, below, S):
    """Sum the products of the bones that a frame carries and of the vectors to where their ends are seen.

    With `below`, of the vectors to all joints that it moves.
    """
    positions, end = target.positions, np.zeros(3)
    pivot = tree.pivot[f]
    S[:] = 0.0
    for j in range(1, target.weights.shape[0]):
        carried = tree.joint_frame[j] == f or (below and _is_below(tree, tree.joint_frame[j], f))
        if carried and target.weights[j] > 0.0:
            for i in range(3):
                end[i] = positions[j, i] - state.origin[i] - state.P[3 * pivot + i]
                if target.weights[pivot] > 0.0:
                    end[i] = positions[j, i] - positions[pivot, i]
            _add_products(S, target.weights[j], state.P[3 * j : 3 * j + 3] - state.P[3 * pivot : 3 * pivot + 3], end)


@internal
def _point_bones(work, target, ancestor):
    """Turn the joints below a frame so that the bones that they carry point to where their ends are seen.

    Parents first.
    """
    state, tree, S = work.here, work.tree, np.zeros((3, 3))
    for f in range(ancestor + 1, tree.frame_parent.shape[0]):
        if not _is_below(tree, f, ancestor):
            continue
        if tree.ball[f] >= 0:
            _sum_bones(tree, state, target, f, False, S)
            if S.any():
                _turn(tree, state, f, _rotation_of(S))
                place_state(work, state)
            continue
        for d in range(tree.first_dof[f], tree.first_dof[f] if tree.slide[f] >= 0 else tree.end_dof[f]):
            _sum_bones(tree, state, target, f, False, S)
            if not _turn_hinge(state, target, d, S):  # the bone lies along the axis, but others may not
                _sum_bones(tree, state, target, f, True, S)
                _turn_hinge(state, target, d, S)
            place_state(work, state)


@internal
def _inside(angle, lower, upper):
    """An angle of the same rotation inside bounds, else the nearer bound."""
    if lower <= angle <= upper:
        return angle
    if angle > upper:
        turned = min(angle - TWO_PI * math.ceil((angle - upper) / TWO_PI), upper)
    else:
        turned = max(angle + TWO_PI * math.ceil((lower - angle) / TWO_PI), lower)
    if lower <= turned <= upper:
        return turned
    below = turned if angle > upper else turned - TWO_PI
    return lower if lower - below < below + TWO_PI - upper else upper


@internal
def _turn_hinge(state, target, d, S):
    """Turn a hinge so that Σ b·R a is largest, given S = Σ a bᵀ; return whether that depends on its angle."""
    cos, sin, size = S[0, 0] + S[1, 1] + S[2, 2], 0.0, np.abs(S).sum()
    for i in range(3):
        axis = state.screws[d, i]
        sin += axis * (S[(i + 1) % 3, (i + 2) % 3] - S[(i + 2) % 3, (i + 1) % 3])
        for k in range(3):
            cos -= axis * S[i, k] * state.screws[d, k]
    if abs(cos) + abs(sin) <= NO_LEVER * size:
        return False
    state.dofs[d] = _inside(state.dofs[d] + math.atan2(sin, cos), target.lower[d], target.upper[d])
    return True


@internal
def _angle_about(axis, a, b):
    """The angle about an axis from one vector to another."""
    sin = axis[0] * (a[1] * b[2] - a[2] * b[1])
    sin += axis[1] * (a[2] * b[0] - a[0] * b[2]) + axis[2] * (a[0] * b[1] - a[1] * b[0])
    return math.atan2(sin, np.dot(a, b) - np.dot(axis, a) * np.dot(axis, b))


@internal
def _joint_before(tree, f):
    """The frame with dofs that carries the pivot of a frame; 1, the root's, or 0 if there is none."""
    before = tree.frame_parent[f]
    while before > 1 and (tree.end_dof[before] == tree.first_dof[before] or tree.pivot[before] == tree.pivot[f]):
        before = tree.frame_parent[before]
    return before


@internal
def _hinge_bone(tree, state, f):
    """The bone that a hinge carries, from its pivot, and whether that lies along its axis."""
    bone = np.zeros(3)
    for j in range(tree.offset.shape[0] - 1, 0, -1):
        if tree.joint_frame[j] == f:
            for i in range(3):
                bone[i] = state.P[3 * j + i] - state.P[3 * tree.pivot[f] + i]
    along, size = np.dot(state.screws[tree.first_dof[f], :3], bone), np.dot(bone, bone)
    return bone, size - along * along <= NO_LEVER * size


@internal
def _bend_back(work, target, f):
    """Bend a hinge to the other side, and twist the ball joint before it so that its bone ends where it did.

    A hinge along its bone turns by half a turn. The joints below follow.
    """
    state, tree, P = work.here, work.tree, work.here.P
    d, pivot, before = tree.first_dof[f], 3 * tree.pivot[f], 3 * tree.pivot[_joint_before(tree, f)]
    bone, is_twist = _hinge_bone(tree, state, f)
    axis = state.screws[d, :3].copy()
    upper = P[pivot : pivot + 3] - P[before : before + 3]
    angle = state.dofs[d] + (math.pi if is_twist else 2.0 * _angle_about(axis, bone, upper))
    state.dofs[d] = _inside(angle, target.lower[d], target.upper[d])
    place_state(work, state)
    if not is_twist:
        upper /= math.sqrt(np.dot(upper, upper))
        twist = _angle_about(upper, _hinge_bone(tree, state, f)[0], bone)
        _turn(tree, state, _joint_before(tree, f), quaternion_of(twist * upper[0], twist * upper[1], twist * upper[2]))
        place_state(work, state)
    _point_bones(work, target, f)


@internal
def _hinges_after(tree, state, ball, hinges):
    """Find the hinges after a ball joint that may be bent to the wrong side; return how many."""
    n = 0
    for f in range(ball + 1, tree.frame_parent.shape[0]):
        above = tree.frame_parent[f]
        while above > ball and tree.ball[above] < 0:
            above = tree.frame_parent[above]
        is_hinge = tree.end_dof[f] - tree.first_dof[f] == 1 and tree.slide[f] < 0
        if above != ball or not is_hinge or n == hinges.shape[0]:
            continue
        bone, is_twist = _hinge_bone(tree, state, f)
        o, p = 3 * tree.pivot[ball], 3 * tree.pivot[f]
        bends = _joint_before(tree, f) == ball and np.any(state.P[o : o + 3] != state.P[p : p + 3])
        if bone.any() and (is_twist or bends):
            hinges[n] = f
            n += 1
    return n


@internal
def _is_off(tree, state, target, f):
    """Whether the joints below a frame are much farther from their positions than all joints are."""
    here, n_here, all_of_them, n = 0.0, 0.0, 0.0, 0.0
    for j in range(1, target.weights.shape[0]):
        w, square = target.weights[j], 0.0
        for i in range(3):
            square += w * (state.P[3 * j + i] + state.origin[i] - target.positions[j, i]) ** 2
        all_of_them += square
        n += w
        if _is_below(tree, tree.joint_frame[j], f):
            here += square
            n_here += w
    return here * n > OFF * all_of_them * n_here


@internal
def _try_hinges(work, target, fit, max_iter):
    """Try the hinges on their other sides, in all combinations of those after one ball joint.

    An elbow that is bent backwards, below an upper arm twisted by half a turn, is nearly as good as the right one: a
    local minimum. So is a wrist twisted by half a turn.
    """
    tree, n_iter, hinges = work.tree, fit.n_iter, np.zeros(MAX_HINGES, np.int64)
    for ball in range(2, tree.frame_parent.shape[0]):
        n_hinges = _hinges_after(tree, work.here, ball, hinges) if tree.ball[ball] >= 0 else 0
        if n_hinges == 0 or 2.0 * fit.half <= REACHED * REACHED or not _is_off(tree, work.here, target, ball):
            continue
        copy_state(work.here, work.best)
        for n in range(1, 2**n_hinges):  # one hinge changes at a time, as in Gray's code
            k = 0
            while n % 2 ** (k + 1) == 0:
                k += 1
            _bend_back(work, target, hinges[k])
            again = minimise_pose(work, target, FIRST_DAMPING * FIRST_DAMPING, max_iter)
            n_iter += again.n_iter
            if again.half < fit.half:
                fit = again
                copy_state(work.here, work.best)
        copy_state(work.best, work.here)
    return Fit(fit.half, n_iter, fit.converged)


@by_address(lambda: FIT(WORKSPACE, TARGET, MATRIX, VECTOR, INTEGER, FLAG))
def fit_afresh(work, target, rotations, angles, max_iter, points_bones):
    """Find the pose from a first one on, with the root's position and orientation by the best fit of all joints.

    Its bones point at the target first, if so asked. Where limits matter, a joint that does may end at a limit and stay
    there.
    """
    start_at(work.tree, work.here, rotations, angles)
    _align_root(work, target)
    if not points_bones:
        return minimise_pose(work, target, FIRST_DAMPING, max_iter)
    _point_bones(work, target, ROOT)
    return _try_hinges(work, target, minimise_pose(work, target, FIRST_DAMPING, max_iter), max_iter)
