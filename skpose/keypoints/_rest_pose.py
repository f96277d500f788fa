"""The rest pose: bones where the person of a layout stands, and otherwise where they point in the mean."""

from typing import NamedTuple

import numpy as np

from skpose.keypoints._layout import Layout
from skpose.keypoints._lengths import bone_length
from skpose.keypoints._root_axes import Points, rigid_with, root_axes
from skpose.keypoints._standing import in_front, standing_directions

# Axes of a bone that points forward, in the root's axes: x forward, y left, z up. Bones rarely point backward at
# rest, where the shortest rotation is ambiguous.
FORWARD = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
ROUNDS = 200  # at most; each is a few sums
SETTLED = 1e-10  # change of a mean shape, relative to its size, at which the rounds end
ROUNDING = 1e-12  # of squares: points on one line have no width
MIRROR = np.array([-1.0, 1.0, 1.0])  # of left and right in the axes of the root
UPRIGHT = 0.9  # cosine of the largest angle to up of a trunk that stands
SURE = 5.0  # of a length's noise and the size, over √n, are 2.5 standard errors of the square of a size
ACROSS = 0.02  # distance of a point from the line of a bone, relative to the point's, that shows the bone's twist


class RestPose(NamedTuple):
    """The skeleton at rest, in the axes of the root."""

    axes: dict[str, np.ndarray]  # of each joint, as columns (3, 3); x along the bone; the parent's if rigid
    directions: dict[str, np.ndarray]  # (3,) of the bone that ends at each joint but the root
    forward: dict[str, float]  # how far, from -1 to 1, the bones of toes and nose point forward in the mean
    upright: dict[str, float]  # how far the trunk points up from the root in the mean
    off: float  # the largest distance of points that are rigid with the root from their mean places, m


def rest_pose(points: Points, layout: Layout, up: str, symmetric: bool) -> RestPose:
    """The rest pose: a standing person for points with known names, and the mean for others."""
    axes = {layout.root: root_axes(points, layout, up)}  # of each joint, in every frame, in the world's axes
    known = {layout.root: ~np.isnan(axes[layout.root][:, 0, 0])}
    standing = standing_directions(layout)
    fixed, off = _rigid_shape(points, layout, axes[layout.root])
    rest, front = RestPose({layout.root: np.eye(3)}, {}, {}, {}, off), in_front(layout)
    for level in _levels(layout):
        seen = {name: _directions(points, name, parent, axes[parent], known[parent]) for name, parent in level}
        for name, parent in level:
            mean, stands = None, name in standing and name not in layout.rigid
            directions, weights, is_shown = seen[name]
            if not is_shown and not stands:
                raise ValueError(f"no frame shows the bone from {parent!r} to {name!r} and the orientation of the root")
            if weights.any():
                mean = rest.axes[parent] @ _mean_direction(directions, weights)
            if name in fixed:
                vector = fixed[name] - fixed[parent]
                mean = vector / np.linalg.norm(vector) if vector.any() else mean
            elif stands:
                if mean is not None and name in front:
                    rest.forward[name] = float(mean[2])
                if mean is not None and parent == layout.root and standing[name][1] > UPRIGHT:
                    rest.upright[name] = float(mean[1])
                mean = standing[name]
            if mean is not None:  # except for bones of length zero
                rest.directions[name] = mean
        if symmetric:
            _make_symmetric(rest.directions, [name for name, _ in level], layout)
        for name, parent in level:
            rest.axes[name], axes[name], known[name] = rest.axes[parent], axes[parent], known[parent]
            if name in layout.rigid or name not in rest.directions:
                continue
            rest.axes[name] = shortest_rotations(FORWARD[:, 0], rest.directions[name][None])[0] @ FORWARD
            known[name] = known[parent] & ~np.isnan(seen[name][0][:, 0])
            still = rest.axes[parent].T @ rest.directions[name]
            swings = shortest_rotations(still, np.where(known[name][:, None], seen[name][0], still))
            axes[name] = axes[parent] @ swings @ rest.axes[parent].T @ rest.axes[name]
            twists = _twists(points, layout, name, axes[name], known[name], rest.axes[name])
            axes[name] = axes[name] @ _about_x(twists)
    return rest


def _make_symmetric(directions: dict[str, np.ndarray], names: list[str], layout: Layout) -> None:
    """Replace directions by the mean of each and the mirror image of its partner's."""
    partner = partners_of(layout)
    before = dict(directions)
    for name in names:
        if name in before and partner[name] in before:
            both = before[name] + before[partner[name]] * MIRROR
            size = np.linalg.norm(both)
            if size > 1e-9:
                directions[name] = both / size


def partners_of(layout: Layout) -> dict[str, str]:
    """The point on the other side of each point; itself on the middle line."""
    pairs = {one: other for pair in layout.pairs for one, other in (pair, pair[::-1])}
    return {name: pairs.get(name, name) for name in layout.points}


def shortest_rotations(start: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """The rotations (n, 3, 3) by the least angle that turn a unit vector (3,) into unit vectors (n, 3)."""
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


def _rigid_shape(points: Points, layout: Layout, axes: np.ndarray) -> tuple[dict[str, np.ndarray], float]:
    """Where the root and the points that are rigid with it are, in the axes of the root, and how far off in the mean.

    Mean positions in axes that follow the trunk a little do not form one rigid shape. So the shape is found from
    unbiased lengths between all of its points, by classical scaling, and rotated onto the mean positions.
    """
    names = rigid_with(layout.root, layout)
    if not names:
        return {}, 0.0
    known = ~np.isnan(axes[:, 0, 0])
    means = np.zeros((len(names), 3))
    squares = np.zeros((len(names) + 1, len(names) + 1))
    everyone, noise, n_frames = [layout.root, *names], 0.0, 1  # noise of a length in one frame, m
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
                lengths = np.linalg.norm(points[one] - points[other], axis=1)
                length = bone_length(lengths, together).value
                if np.std(lengths[together > 0.0]) > noise:
                    noise, n_frames = float(np.std(lengths[together > 0.0])), int(np.count_nonzero(together))
            squares[i, j] = squares[j, i] = length**2
    products = (squares[1:, :1] + squares[:1, 1:] - squares[1:, 1:]) / 2.0
    values, vectors = np.linalg.eigh(products)
    # A bend below the noise of one frame cannot show a rotation, and one below the error of all frames may not exist.
    error = SURE * noise * np.sqrt(max(values[-1], 0.0) / n_frames)
    sizes = np.sqrt(np.where(values > max(ROUNDING * values[-1], noise**2, error), values, 0.0))
    sizes[-1] = np.sqrt(max(values[-1], 0.0))
    flat = np.zeros((len(names), 3))
    flat[:, : len(names)] = (vectors * sizes)[:, ::-1][:, :3]
    u, _, vh = np.linalg.svd(flat.T @ means)
    shape = flat @ u @ vh
    off = float(np.linalg.norm(shape - means, axis=1).max())
    return {layout.root: np.zeros(3)} | dict(zip(names, shape, strict=True)), off


def _levels(layout: Layout) -> list[list[tuple[str, str]]]:
    """The points except the root, each with its parent, by the number of bones between them and the root."""
    levels, parents = [], [layout.root]
    while children := [
        (name, parent) for parent in parents for name in layout.points if layout.parents[name] == parent
    ]:
        levels.append(children)
        parents = [name for name, _ in children]
    return levels


def _directions(
    points: Points, name: str, parent: str, axes: np.ndarray, known: np.ndarray
) -> tuple[np.ndarray, np.ndarray, bool]:
    """The directions (n, 3) of a bone in the axes of its parent, their weights (n,), and whether any frame shows it.

    Directions are NaN where not seen, weights zero where the bone has no length. Known are the frames in which the axes
    of the parent are seen. Where no others are, all frames count.
    """
    vectors = np.einsum("nab,na->nb", axes, points[name] - points[parent])
    sizes = np.linalg.norm(vectors, axis=1)
    directions = np.full_like(vectors, np.nan)
    np.divide(vectors, sizes[:, None], out=directions, where=sizes[:, None] > 0.0)
    shown = points.confidences[name] * points.confidences[parent] * ~np.isnan(axes[:, 0, 0])
    weights = np.where(sizes > 0.0, shown, 0.0)
    return directions, weights * known if (weights * known).any() else weights, bool(shown.any())


def _mean_direction(directions: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The mean (3,) of unit vectors (n, 3); the one with the largest weight if they cancel."""
    total = weights @ np.where(weights[:, None] > 0.0, directions, 0.0)
    size = np.linalg.norm(total)
    if size <= 1e-9 * weights.sum():
        return directions[weights.argmax()]
    return total / size


def _twists(
    points: Points, layout: Layout, name: str, axes: np.ndarray, known: np.ndarray, at_rest: np.ndarray
) -> np.ndarray:
    """The twists (n,), rad, of a bone from given axes (n, 3, 3); zero where nothing shows them.

    Points that are rigid with the bone are rotated about it onto their mean shape. Across the bone they are complex
    numbers, and a twist by φ is the factor exp(iφ). It is zero if points of the left are to the left of their
    partners at rest, or in the mean without such pairs.
    """
    still, rigid = np.zeros(len(axes)), rigid_with(name, layout)
    if not rigid:
        return still
    vectors = np.stack([np.einsum("nab,na->nb", axes, points[one] - points[name]) for one in rigid], axis=1)
    weights = np.stack([points.confidences[one] * points.confidences[name] for one in rigid], axis=1)
    weights[np.isnan(vectors).any(axis=2) | ~known[:, None]] = 0.0
    vectors[weights == 0.0] = 0.0
    numbers = vectors[..., 1] + 1j * vectors[..., 2]
    if not weights.any() or not np.median(np.abs(numbers[weights > 0.0])) > ACROSS * np.abs(vectors).max():
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
    pairs = [(rigid.index(one), rigid.index(other)) for one, other in layout.pairs if {one, other} <= set(rigid)]
    across = sum((shape[one] - shape[other] for one, other in pairs), start=0j)
    left = complex(at_rest[0, 1], at_rest[0, 2])
    middle = turns[shown].sum()
    if abs(across) > ACROSS * np.abs(shape).max() and abs(left) > ACROSS:
        middle = left / across
    return np.where(shown, np.angle(turns * middle.conjugate()), 0.0)


def _about_x(angles: np.ndarray) -> np.ndarray:
    """Rotations (n, 3, 3) about x by angles (n,), rad."""
    one, zero, cos, sin = np.ones_like(angles), np.zeros_like(angles), np.cos(angles), np.sin(angles)
    return np.array([[one, zero, zero], [zero, cos, -sin], [zero, sin, cos]]).transpose(2, 0, 1)
