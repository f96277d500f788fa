"""The rest pose in the middle of positions: each bone's mean direction, and twist, in the axes of its parent."""

import numpy as np

from skpose.keypoints._layout import Layout
from skpose.keypoints._lengths import bone_length
from skpose.keypoints._root_axes import Points, rigid_with, root_axes

# Axes of a bone that points forward, in those of the root: x forward, y left, z up. Nobody's bone at the root points
# backward, opposite to where these point, from where there is no one shortest rotation.
FORWARD = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
ROUNDS = 200  # at most; each is a few sums
SETTLED = 1e-10  # change of a mean shape, relative to its size, at which the rounds end
ROUNDING = 1e-12  # of squares: points on one line have no width
ACROSS = 0.02  # distance of a point from the line of a bone, relative to the point's, that shows the bone's twist


def rest_rotations(points: Points, layout: Layout, up: str) -> dict[str, np.ndarray]:
    """Return the rest rotation (3, 3) of each joint but the root's."""
    axes = {layout.root: root_axes(points, layout, up)}  # of each joint, in every frame, in those of the world
    known = {layout.root: ~np.isnan(axes[layout.root][:, 0, 0])}
    fixed = _rigid_shape(points, layout, axes[layout.root])
    rests = {}
    for name, parent in _in_tree_order(layout):
        base = FORWARD if parent == layout.root else np.eye(3)
        directions, weights = _directions(points, name, parent, axes[parent], known[parent])
        if not weights.any():
            rests[name] = np.eye(3)  # a bone of length zero
            axes[name], known[name] = axes[parent], known[parent]
            continue
        mean = _mean_direction(directions, weights)
        if name in fixed:
            vector = axes_at_rest(parent, layout, rests).T @ (fixed[name] - fixed[parent])
            mean = vector / np.linalg.norm(vector) if vector.any() else mean
        rest = shortest_rotations(base[:, 0], mean[None])[0] @ base
        rests[name], known[name] = rest, known[parent] & ~np.isnan(directions[:, 0])
        if name in layout.rigid:
            axes[name] = axes[parent] @ rest
            continue
        swings = shortest_rotations(mean, np.where(np.isnan(directions), mean, directions))
        axes[name] = axes[parent] @ swings @ rest
        axes[name] = axes[name] @ _about_x(_twists(points, layout, name, axes[name], known[name]))
    return rests


def axes_at_rest(name: str, layout: Layout, rests: dict[str, np.ndarray]) -> np.ndarray:
    """Return the axes (3, 3) of a joint at rest as columns, in those of the root."""
    parent = layout.parents[name]
    return np.eye(3) if parent is None else axes_at_rest(parent, layout, rests) @ rests[name]


def shortest_rotations(start: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Return the rotations (n, 3, 3) by the least angle that turn a unit vector (3,) into unit vectors (n, 3)."""
    cosine = ends @ start
    opposite = cosine < -1.0 + 1e-12  # half a turn, about any axis across
    across = np.cross(start, np.eye(3)[np.abs(start).argmin()])
    across /= np.linalg.norm(across)
    x, y, z = np.cross(start, ends).T
    zero = np.zeros_like(x)
    cross = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    divisor = np.where(opposite, 1.0, 1.0 + cosine)
    rotations = np.eye(3) + cross + cross @ cross / divisor[:, None, None]
    rotations[opposite] = 2.0 * np.outer(across, across) - np.eye(3)
    return rotations


def _rigid_shape(points: Points, layout: Layout, axes: np.ndarray) -> dict[str, np.ndarray]:
    """Return where the root and the points that are rigid with it are, in the axes of the root.

    Mean positions in axes that follow the trunk a little are not those of one rigid shape. So the shape is that of the
    lengths between all of its points, free of bias, by classical scaling, and is turned onto the mean positions.
    """
    names = rigid_with(layout.root, layout)
    if not names:
        return {}
    known = ~np.isnan(axes[:, 0, 0])
    means = np.zeros((len(names), 3))
    squares = np.zeros((len(names) + 1, len(names) + 1))
    everyone, noise = [layout.root, *names], 0.0  # of a length in one frame, m
    for i, one in enumerate(everyone):
        sure = points.confidences[one] * points.confidences[layout.root] * known
        if i and sure.any():
            vectors = np.einsum("nab,na->nb", axes, points[one] - points[layout.root])
            means[i - 1] = sure @ np.where(sure[:, None] > 0.0, vectors, 0.0) / sure.sum()
    for i, one in enumerate(everyone):
        for j, other in enumerate(everyone[:i]):
            together = points.confidences[one] * points.confidences[other]
            length = float(np.linalg.norm((means[i - 1] if i else 0.0) - (means[j - 1] if j else 0.0)))
            if together.any():
                known_length = bone_length(np.linalg.norm(points[one] - points[other], axis=1), together)
                length = known_length.value
                noise = np.fmax(noise, known_length.error * np.sqrt(np.count_nonzero(together)))
            squares[i, j] = squares[j, i] = length**2
    products = (squares[1:, :1] + squares[:1, 1:] - squares[1:, 1:]) / 2.0
    values, vectors = np.linalg.eigh(products)
    # What is smaller than the noise of one frame cannot show a rotation: a line of hips has no bend.
    sizes = np.sqrt(np.where(values > np.fmax(ROUNDING * values[-1], (3.0 * noise) ** 2), values, 0.0))
    sizes[-1] = np.sqrt(max(values[-1], 0.0))
    flat = np.zeros((len(names), 3))
    flat[:, : len(names)] = (vectors * sizes)[:, ::-1][:, :3]
    u, _, vh = np.linalg.svd(flat.T @ means)
    shape = dict(zip(names, flat @ u @ vh, strict=True))
    return {layout.root: np.zeros(3)} | shape


def _in_tree_order(layout: Layout) -> list[tuple[str, str]]:
    """Return the points but for the root, each with its parent, parents before their children."""
    order: list[tuple[str, str]] = []
    reached = [layout.root]
    for one in reached:
        children = [name for name in layout.points if layout.parents[name] == one]
        order.extend((name, one) for name in children)
        reached.extend(children)
    return order


def _directions(
    points: Points, name: str, parent: str, axes: np.ndarray, known: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the directions (n, 3) of a bone in the axes of its parent, NaN where not seen, and their weights (n,).

    Frames in which the parent's axes are known count; if there are none, those in which it is taken to be at rest.
    """
    vectors = np.einsum("nab,na->nb", axes, points[name] - points[parent])
    sizes = np.linalg.norm(vectors, axis=1)
    directions = np.full_like(vectors, np.nan)
    np.divide(vectors, sizes[:, None], out=directions, where=sizes[:, None] > 0.0)
    shown = points.confidences[name] * points.confidences[parent] * ~np.isnan(axes[:, 0, 0])
    if not shown.any():
        raise ValueError(
            f"the bone from {parent!r} to {name!r} is seen in no frame that shows how the root is turned, so that it "
            f"has no rest pose: pass layout.without([{name!r}]), or frames that show it"
        )
    weights = np.where(sizes > 0.0, shown, 0.0)
    return directions, weights * known if (weights * known).any() else weights


def _mean_direction(directions: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the mean (3,) of unit vectors (n, 3); that of the largest weight if they cancel each other."""
    total = weights @ np.where(weights[:, None] > 0.0, directions, 0.0)
    size = np.linalg.norm(total)
    if size <= 1e-9 * weights.sum():
        return directions[weights.argmax()]
    return total / size


def _twists(points: Points, layout: Layout, name: str, axes: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Return the twists (n,), rad, of a bone from given axes (n, 3, 3), zero in the mean, and where nothing shows them.

    Points that are rigid with the bone are rotated about it onto their mean shape. Across the bone they are complex
    numbers, and a twist by φ is the factor exp(iφ).
    """
    still, rigid = np.zeros(len(axes)), rigid_with(name, layout)
    if not rigid:
        return still
    vectors = np.stack([np.einsum("nab,na->nb", axes, points[one] - points[name]) for one in rigid], axis=1)
    weights = np.stack([points.confidences[one] * points.confidences[name] for one in rigid], axis=1)
    weights[np.isnan(vectors).any(axis=2) | ~known[:, None]] = 0.0
    vectors[weights == 0.0] = 0.0
    if not weights.any():
        return still
    numbers = vectors[..., 1] + 1j * vectors[..., 2]
    if not np.median(np.abs(numbers[weights > 0.0])) > ACROSS * np.abs(vectors).max():
        return still
    fullest = (weights * np.abs(numbers)).sum(axis=1).argmax()
    shape = numbers[fullest]
    for _ in range(ROUNDS):
        overlaps = (weights * shape.conj() * numbers).sum(axis=1)
        shown = overlaps != 0.0
        turns = np.where(shown, overlaps / np.where(shown, np.abs(overlaps), 1.0), 1.0)
        before, total = shape, np.maximum(weights.sum(axis=0), 1e-300)
        shape = (weights * turns.conj()[:, None] * numbers).sum(axis=0) / total
        if np.abs(shape - before).max() <= SETTLED * np.abs(shape).max():
            break
    middle = turns[shown].sum()
    return np.where(shown, np.angle(turns * middle.conj()), 0.0)


def _about_x(angles: np.ndarray) -> np.ndarray:
    """Return rotations (n, 3, 3) about x by angles (n,), rad."""
    rotations = np.tile(np.eye(3), (len(angles), 1, 1))
    rotations[:, 1, 1] = rotations[:, 2, 2] = np.cos(angles)
    rotations[:, 2, 1] = np.sin(angles)
    rotations[:, 1, 2] = -rotations[:, 2, 1]
    return rotations
