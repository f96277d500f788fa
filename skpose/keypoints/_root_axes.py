"""The axes of the root in every frame: x to the left of the body, y up, z forward."""

import numpy as np

from skpose.keypoints._layout import Layout

TRUNK = 0.1  # weight of what moves relative to the root, such as the spine: it only says where rigid points do not
ON_A_LINE = 1e-3  # second singular value over the first; points with less do not show the rotation about their line
ROUNDS = 20
SETTLED = 1e-6  # change of the mean shape, relative to its size, at which the rounds end


class Points(dict):
    """Positions (n_frames, 3) of each point by name, with the confidences (n_frames,) of each, 0 where not seen."""

    def __init__(self, positions: dict[str, np.ndarray], confidences: dict[str, np.ndarray]):
        super().__init__(positions)
        self.confidences = confidences


def root_axes(points: Points, layout: Layout, up: str) -> np.ndarray:
    """The axes (n_frames, 3, 3) of the root as columns, in the world's axes; NaN if unknown.

    Points that are rigid with the root, and the start of the trunk, are turned onto their mean shape: generalised
    Procrustes analysis with Kabsch's rotations, J. C. Gower, "Generalized Procrustes analysis", Psychometrika 40, 1975,
    doi:10.1007/BF02291478. Left and up refer to the mean shape. Without left and right by name, left is from the
    last of the rigid points to the first, and up to all of them, as the fingers of a hand are up from the wrist. If
    there are no such points, or all are on one line, nothing is turned: the root has the axes of the world, with y up.
    """
    names, pairs, middle = _shape(layout)
    n = len(points[layout.root])
    world = np.tile(np.roll(np.eye(3), "yzx".index(up), axis=0).T, (n, 1, 1))
    if not pairs:
        return world
    vectors, weights = _vectors(points, layout, names, up)
    left = [(names.index(a), names.index(b)) for a, b in pairs]
    upward = [names.index(name) for name in middle]

    axes = _orthonormal(vectors, left, upward)
    if np.isnan(axes[:, 0, 0]).all() and not layout.pairs:
        return world
    shape = _mean_shape(layout, axes, vectors, weights)
    for _ in range(ROUNDS):
        before, axes = shape, _kabsch(vectors, weights, shape)
        shape = _mean_shape(layout, axes, vectors, weights)
        if np.abs(shape - before).max() <= SETTLED * np.abs(shape).max():
            break
    return axes @ _orthonormal(shape[None], left, upward)[0]


def rigid_with(name: str, layout: Layout) -> list[str]:
    """The points that are fixed to the frame of a point, over any number of rigid bones."""
    found = [name]
    for one in found:
        found.extend(child for child in layout.points if layout.parents[child] == one and child in layout.rigid)
    return found[1:]


def _shape(layout: Layout) -> tuple[list[str], list[tuple[str, str]], list[str]]:
    """The points that say how the root is turned, the pairs among them, those on the middle line.

    The empty name on the middle line is the world's direction up, where no point is there.
    """
    rigid = rigid_with(layout.root, layout)
    if not layout.pairs:
        return rigid, [(rigid[0], rigid[-1])] if len(rigid) > 1 else [], rigid
    balls = [name for name in layout.points if layout.parents[name] == layout.root and name not in layout.rigid]
    sided = {name for pair in layout.pairs for name in pair}
    pairs = [pair for pair in layout.pairs if set(pair) <= set(rigid)]
    names = rigid + [name for name in balls if name not in sided]
    if not pairs:
        pairs = [pair for pair in layout.pairs if set(pair) <= set(balls)]
        names += [name for pair in pairs for name in pair]
    middle = [name for name in names if name not in sided]
    if not middle:
        middle = [""]
        names.append("")
    return names, pairs, middle


def _vectors(points: Points, layout: Layout, names: list[str], up: str) -> tuple[np.ndarray, np.ndarray]:
    """Vectors (n, k, 3) from the root to the points, and their weights (n, k); bones that move have one length.

    Where a point is not seen its vector is zero, and its weight.
    """
    root, sure = points[layout.root], points.confidences[layout.root]
    rigid = rigid_with(layout.root, layout)
    vectors, weights = [], []
    for name in names:
        vectors.append(points[name] - root if name else np.tile(np.eye(3)["xyz".index(up)], (len(root), 1)))
        weights.append(points.confidences[name] * sure * (1.0 if name in rigid else TRUNK) if name else TRUNK * sure)
    lengths = [np.linalg.norm(vector, axis=1) for vector in vectors]
    sizes = [length[length > 0.0] for length, name in zip(lengths, names, strict=True) if name in rigid]
    size = max((float(np.median(length)) for length in sizes if len(length)), default=1.0)
    for i, name in enumerate(names):
        if name not in rigid:
            with np.errstate(invalid="ignore", divide="ignore"):
                vectors[i] = vectors[i] * (size / lengths[i])[:, None]
    array, weight = np.stack(vectors, axis=1), np.stack(weights, axis=1)
    unseen = np.isnan(array).any(axis=2) | (weight == 0.0)
    array[unseen], weight[unseen] = 0.0, 0.0
    return array, weight


def _orthonormal(vectors: np.ndarray, left: list[tuple[int, int]], upward: list[int]) -> np.ndarray:
    """Axes (n, 3, 3) as columns from vectors (n, k, 3): left, what of up is perpendicular to it, forward."""
    x = vectors[:, [a for a, _ in left]].sum(axis=1) - vectors[:, [b for _, b in left]].sum(axis=1)
    y = vectors[:, upward].sum(axis=1)
    some = [i for pair in left for i in pair] + upward
    seen = (np.abs(vectors[:, some]).sum(axis=2) > 0.0).all(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        x = x / np.linalg.norm(x, axis=1, keepdims=True)
        flat = y - (x * y).sum(axis=1, keepdims=True) * x
        on_a_line = ~(np.linalg.norm(flat, axis=1) > ON_A_LINE * np.linalg.norm(y, axis=1))
        flat = flat / np.linalg.norm(flat, axis=1, keepdims=True)
    axes = np.stack([x, flat, np.cross(x, flat)], axis=2)
    axes[on_a_line | ~seen] = np.nan
    return axes


def _kabsch(vectors: np.ndarray, weights: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """The rotations (n, 3, 3) that bring the shape (k, 3) nearest to the vectors (n, k, 3)."""
    u, values, vh = np.linalg.svd(np.einsum("nk,nka,kb->nab", weights, vectors, shape))
    u[:, :, 2] *= np.linalg.det(u @ vh)[:, None]
    axes = u @ vh
    axes[values[:, 1] <= ON_A_LINE * values[:, 0]] = np.nan
    return axes


def _mean_shape(layout: Layout, axes: np.ndarray, vectors: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The mean (k, 3) of the vectors (n, k, 3) in the axes (n, 3, 3), NaN if unknown."""
    known = ~np.isnan(axes[:, 0, 0])
    if not known.any():
        raise ValueError(
            f"no frame shows the orientation of {layout.root!r}: points are not seen at once or on one line"
        )
    total = np.einsum("nk,nab,nka->kb", weights[known], axes[known], vectors[known])
    return total / np.maximum(weights[known].sum(axis=0), 1e-300)[:, None]
