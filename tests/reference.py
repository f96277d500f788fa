"""Slow, obvious numpy: the library's results, computed a second time from the definitions.

Nothing here is shared with `skpose` but the `Bone` and `Skeleton` records; rotations are scipy's, files are parsed with
regular expressions.
"""

import functools
import re
from fractions import Fraction
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation, Slerp
from threadpoolctl import threadpool_limits

INCH = 0.0254


def joint_rotation(bone, columns):
    if bone.dofs == "slide":
        return Rotation.identity(len(columns))
    if bone.dofs == "hinge":
        return Rotation.from_rotvec(columns * np.array(bone.axis))
    return Rotation.from_rotvec(columns) if bone.dofs == "rotvec" else Rotation.from_euler(bone.dofs, columns)


def matrices_and_positions(angles, skeleton):
    """Return the world orientations of all joints' own axes (list of matrices) and their positions, by definition."""
    angles = np.atleast_2d(angles)
    orientation, position = {None: np.eye(3)[None]}, {None: np.zeros((len(angles), 3))}
    column = 0
    for bone in skeleton.bones:
        k = n_dofs(bone)
        local = np.eye(3) if bone.rest_rotation is None else np.array(bone.rest_rotation)
        if k:
            local = local @ joint_rotation(bone, angles[:, column : column + k]).as_matrix()
        column += k
        orientation[bone.name] = orientation[bone.parent] @ local
        frame = bone.name if skeleton.offset_frame == "own" else bone.parent
        position[bone.name] = position[bone.parent] + orientation[frame] @ np.array(bone.offset)
        if bone.dofs == "slide":
            position[bone.name] += orientation[bone.name] @ np.array(bone.axis) * angles[:, [column - 1]]
    names = skeleton.joint_names
    return [orientation[name] for name in names], np.stack([position[name] for name in names], axis=1)


def orientations_and_positions(angles, skeleton):
    matrices, positions = matrices_and_positions(angles, skeleton)
    return [Rotation.from_matrix(np.broadcast_to(one, (len(positions), 3, 3))) for one in matrices], positions


def forward_kinematics(angles, skeleton):
    return matrices_and_positions(angles, skeleton)[1]


@functools.cache  # positions of five poses, for each distance
def weights(skeleton):
    """Return the weights of the joints: given ones, else 1, but for a joint that is never apart from one before it."""
    angles = np.random.default_rng(0).uniform(-1, 1, size=(5, skeleton.n_dofs))
    positions, found = forward_kinematics(angles, skeleton), np.zeros(skeleton.n_joints)
    for j, bone in enumerate(skeleton.bones):
        apart = np.abs(positions - positions[:, [j]]).max(axis=(0, 2))
        counted = ((apart < 1e-9) & (found > 0)).any()
        found[j] = bone.weight if bone.weight is not None else 0.0 if counted else 1.0
    found.flags.writeable = False
    return found


def F(angles, skeleton):
    """Return positions times the square roots of the weights, (n_poses, 3 n_joints)."""
    scaled = forward_kinematics(angles, skeleton) * np.sqrt(weights(skeleton))[:, None]
    return scaled.reshape(len(scaled), -1)


def differences(a, b, wrap, skeleton=None):
    gap = np.asarray(b, dtype=float) - np.asarray(a, dtype=float)
    slides = [bone.dofs == "slide" for bone in (skeleton.bones if skeleton else ()) for _ in range(n_dofs(bone))]
    return np.where(np.array(slides or False) | (not wrap), gap, (gap + np.pi) % (2 * np.pi) - np.pi)


def distance(a, b, skeleton, metric, n_steps=10, wrap=False):
    """Return one distance by its definition in the paper."""
    return distances([a], [b], skeleton, metric, n_steps, wrap)[0, 0]


def distances(X, Y, skeleton, metric, n_steps=10, wrap=False):
    """Return the distances of all pairs by their definitions in the paper."""
    X, Y = np.asarray(X, dtype=float), np.asarray(Y, dtype=float)
    A, B = np.repeat(X, len(Y), axis=0), np.tile(Y, (len(X), 1))
    return _of_pairs(A, B, skeleton, metric, n_steps, wrap).reshape(len(X), len(Y))


def _of_pairs(A, B, skeleton, metric, n_steps, wrap):
    if metric == "angle":
        return np.linalg.norm(differences(A, B, wrap), axis=1)
    if metric == "position":
        return np.linalg.norm(F(A, skeleton) - F(B, skeleton), axis=1)
    if metric == "rotation":
        of_A, of_B = (orientations_and_positions(poses, skeleton)[0] for poses in (A, B))
        index = {name: i for i, name in enumerate(skeleton.joint_names)}
        total, weight = np.zeros(len(A)), weights(skeleton)
        for i, bone in enumerate(skeleton.bones):
            frame = i if skeleton.offset_frame == "own" else index.get(bone.parent)
            if frame is not None:  # a bone fixed to the root does not rotate
                angle = (of_A[frame].inv() * of_B[frame]).magnitude()
                total += weight[i] * np.dot(bone.offset, bone.offset) * angle**2
        return np.sqrt(total)
    if metric != "spatial":
        raise ValueError(f"there is no definition of {metric!r} here: write it down")
    lines = np.concatenate([line(a, b, n_steps, wrap, skeleton) for a, b in zip(A, B, strict=True)])
    steps = np.diff(F(lines, skeleton).reshape(len(A), n_steps + 1, -1), axis=1)
    return np.linalg.norm(steps, axis=2).sum(axis=1)


def path_energy(path, skeleton):
    """Return the energy of eq. 6."""
    return np.square(np.diff(F(path, skeleton), axis=0)).sum()


def n_dofs(bone):
    return {"rotvec": 3, "hinge": 1, "slide": 1}.get(bone.dofs, len(bone.dofs))


def between(path, skeleton, parts):
    """Divide every step of a path into equal parts: joints with three dofs turn by slerp, other angles linearly."""
    path = np.asarray(path)
    at = np.linspace(0, len(path) - 1, (len(path) - 1) * parts + 1)
    fine = np.stack([np.interp(at, np.arange(len(path)), column) for column in path.T], axis=1)
    column = 0
    for bone in skeleton.bones:
        here = slice(column, column + n_dofs(bone))
        column = here.stop
        if n_dofs(bone) == 3:
            turned = Slerp(np.arange(len(path)), joint_rotation(bone, path[:, here]))(at)
            fine[:, here] = turned.as_rotvec() if bone.dofs == "rotvec" else turned.as_euler(bone.dofs)
    return fine


def path_length(path, skeleton, parts=1):
    """Return the sum of chords, every step of the path divided into equal parts."""
    fine = between(path, skeleton, parts)
    return np.linalg.norm(np.diff(F(fine, skeleton), axis=0), axis=1).sum()


def line(a, b, n_steps, wrap=True, skeleton=None):
    """Return the straight line: linear in angles, slerp of ball joints."""
    part = np.linspace(0, 1, n_steps + 1)[:, None]
    poses, column = a + part * differences(a, b, wrap, skeleton), 0
    for bone in () if skeleton is None else skeleton.bones:
        k = n_dofs(bone)
        if bone.dofs == "rotvec":
            here = slice(column, column + 3)
            p, q = Rotation.from_rotvec(a[here]), Rotation.from_rotvec(b[here])
            poses[:, here] = (p * Rotation.from_rotvec(part * (p.inv() * q).as_rotvec())).as_rotvec()
        column += k
    return poses


def energy_gradient(F, J):
    """Return the derivative of eq. 6 by the inner points, from positions (n, 3L) and Jacobians (n, 3L, D)."""
    return 2 * np.einsum("nr,nrd->nd", 2 * F[1:-1] - F[:-2] - F[2:], J[1:-1])


def least_energy_path(a, b, kinematics, n_steps=10, bounds=None):
    """The minimiser of eq. 6 from the straight line, by scipy; naive: nothing is measured between the points.

    ``kinematics(path)`` gives positions (n, 3L) and Jacobians (n, 3L, D).
    """
    start = line(a, b, n_steps)
    n, n_dofs = n_steps - 1, start.shape[1]

    def with_inner(x):
        return np.concatenate([start[:1], x.reshape(n, n_dofs), start[-1:]])

    def chords(x):
        return np.diff(kinematics(with_inner(x))[0], axis=0).ravel()

    def jacobian(x):
        J = kinematics(with_inner(x))[1]
        rows = np.zeros((n_steps, J.shape[1], n, n_dofs))
        for i in range(n):
            rows[i, :, i], rows[i + 1, :, i] = J[i + 1], -J[i + 1]
        return rows.reshape(-1, n * n_dofs)

    bounds = (-np.inf, np.inf) if bounds is None else np.tile(np.array(bounds, dtype=float), (n, 1)).T
    inside = np.clip(start[1:-1].ravel(), *bounds)
    with threadpool_limits(1):  # for matrices of this size more threads of BLAS only wait for each other
        found = least_squares(chords, inside, jacobian, bounds=bounds, xtol=1e-12, ftol=1e-12, gtol=1e-9)
    return with_inner(found.x)


def in_window(i, j, shape, window):
    """Return whether a window, a decimal number, admits the pair of frames i of n and j of m, exactly.

    It admits pairs whose relative times differ by no more, or by no more than half a frame of the shorter motion.
    """
    n, m = shape
    if window is None or min(n, m) == 1:
        return True
    apart = abs(Fraction(i, n - 1) - Fraction(j, m - 1))
    return apart <= max(Fraction(str(window)), Fraction(1, 2 * (min(n, m) - 1)))


def least_sum(costs, window=None, kind="dtw"):
    """Return the least sum of costs (n, m) along a path of steps (1, 0), (0, 1), (1, 1), by the recursion.

    A "dtw" path has all frames of both, in pairs that the window admits. A "subsequence" path begins and ends at any
    column. "frames" takes the pairs (i, i).
    """
    n, m = np.shape(costs)
    if kind == "frames":
        return sum(costs[i][i] for i in range(n))
    sums = {}
    for i, j in np.ndindex(n, m):
        if not in_window(i, j, (n, m), window):
            continue
        steps = [sums[cell] for cell in ((i - 1, j), (i, j - 1), (i - 1, j - 1)) if cell in sums]
        if i == 0 and (j == 0 or kind == "subsequence"):
            steps = [0.0]
        if steps:
            sums[i, j] = min(steps) + costs[i][j]
    return min(sums[n - 1, j] for j in range(m)) if kind == "subsequence" else sums[n - 1, m - 1]


def motion_distances(X, Y, skeleton, metric, window=None, kind="dtw", **parameters):
    """Return least sums over n + m frames, or over n but for "dtw"."""
    D = np.zeros((len(X), len(Y)))
    for i, j in np.ndindex(D.shape):
        n, m = len(X[i]), len(Y[j])
        costs = distances(X[i], Y[j], skeleton, metric, **parameters)
        D[i, j] = least_sum(costs, window, kind) / (n + m if kind == "dtw" else n)
    return D


def asf_amc_positions(asf, amc):
    """Return joint positions (n_frames, n_bones, 3), m, and the bones' names, from R_b = R_parent · C · M · C⁻¹."""
    text = Path(asf).read_text()
    scale = INCH / float(re.search(r"length\s+([\d.]+)\s*\n\s*angle", text)[1])
    bones = {}
    for block in re.findall(r"begin\s+id(.*?)\bend\b", text, flags=re.S):
        name = re.search(r"name\s+(\w+)", block)[1]
        direction = np.array(re.search(r"direction\s+(.*)", block)[1].split(), dtype=float)
        length = float(re.search(r"length\s+(\S+)", block)[1])
        *axis, order = re.search(r"axis\s+(.*)", block)[1].split()
        assert order == "XYZ"
        C = Rotation.from_euler("xyz", np.array(axis, dtype=float), degrees=True)
        dofs = re.search(r"dof\s+(.*)", block)
        bones[name] = (direction / np.linalg.norm(direction) * length * scale, C, dofs[1].split() if dofs else [])
    parents = {}
    for line in re.search(r":hierarchy(.*)", text, flags=re.S)[1].splitlines():
        first, *rest = line.split() or ["end"]
        parents |= dict.fromkeys(rest, None if first == "root" else first)
    frames = [
        dict(line.split(maxsplit=1) for line in frame.strip().splitlines())
        for frame in re.split(r"^\d+\s*$", Path(amc).read_text(), flags=re.M)[1:]
    ]
    n = len(frames)
    orientation, position = {None: Rotation.identity(n)}, {None: np.zeros((n, 3))}

    def place(name):
        if name in position:
            return
        place(parents[name])
        offset, C, dofs = bones[name]
        euler = np.zeros((n, 3))
        for i, dof in enumerate(dofs):
            euler[:, "xyz".index(dof[1])] = [float(frame[name].split()[i]) for frame in frames]
        M = Rotation.from_euler("xyz", euler, degrees=True)
        orientation[name] = orientation[parents[name]] * C * M * C.inv()
        position[name] = position[parents[name]] + orientation[name].apply(offset)

    for name in bones:
        place(name)
    return np.stack([position[name] for name in bones], axis=1), list(bones)


def medoid_shift(D, bandwidth):
    """Return the mode of every sample, by the definition: one sample at a time, then the modes among themselves.

    NaN means that a graph of neighbours has no distance: such samples have no weight and nothing moves to them, and two
    neighbours of a sample without a distance count as if they lay at right angles.
    """
    modes = np.arange(len(D))
    while True:
        alive = sorted(set(modes))
        target = {}
        for i in alive:
            near = [j for j in alive if not np.isnan(D[i, j])]
            costs = []
            for j in near:
                cost = 0.0
                for k in near:
                    squared = D[i, j] ** 2 + D[i, k] ** 2 if np.isnan(D[j, k]) else D[j, k] ** 2
                    cost += np.exp(-(D[i, k] ** 2) / (2 * bandwidth**2)) * squared
                costs.append(cost)
            target[i] = near[int(np.argmin(np.round(costs, 12)))]
        rest = {}
        for i in alive:
            path = [i]
            while target[path[-1]] not in path:
                path.append(target[path[-1]])
            rest[i] = path[-1]
        if all(rest[i] == i for i in alive):
            return modes
        modes = np.array([rest[i] for i in modes])


def dtw(costs, window=None, kind="dtw"):
    """Return the least sum along a monotone path through a matrix, and such a path, by trying every path."""
    (n, m), best = np.shape(costs), (np.inf, None)

    def follow(path):
        nonlocal best
        i, j = path[-1]
        if not in_window(i, j, (n, m), window):
            return
        if i == n - 1 and (j == m - 1 or kind == "subsequence"):
            best = min(best, (sum(costs[cell] for cell in path), path))
        for step in ((i + 1, j), (i, j + 1), (i + 1, j + 1)):
            if step[0] < n and step[1] < m:
                follow([*path, step])

    for j in range(m if kind == "subsequence" else 1):
        follow([(0, j)])
    return best


def mean_over_pairs(X, Y, function):
    """Return the mean of a function over all pairs of poses of two motions."""
    return float(np.mean([[function(a, b) for b in Y] for a in X]))


def two_sample_statistic(X, Y, function):
    """Return twice the mean over pairs from X and Y, minus the means within X and within Y; each motion counts once."""

    def mean(one, other):
        return float(np.mean([[mean_over_pairs(a, b, function) for b in other] for a in one]))

    return 2.0 * mean(X, Y) - mean(X, X) - mean(Y, Y)
