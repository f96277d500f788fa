"""The rest pose: bones where the person of a layout stands, and otherwise where they point in the mean."""

from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.warnings import warn
from skpose.keypoints._layout import Layout
from skpose.skeleton._rotations import shortest_rotations
from skpose.skeleton._sides import split_sides

OUTLIER = 4.0  # robust standard deviations from the median; of normal noise one length in 16,000 is as far
LARGEST_CORRECTION = 0.9  # of the square of the length, beyond which the bone is as short as the noise
STRETCH = 0.1  # of the length, slow change that is reported; a bending back changes by 0.08
CHANCE = 4.0  # standard deviations of a correlation by chance
UNCERTAIN = 0.05  # of the length, standard error that is reported
DIFFERENT = 0.1  # of the length, difference of the sides that is reported
FEW = 2  # frames from which a spread is known


class Length(NamedTuple):
    """The length of one bone, from all frames that show both ends."""

    value: float  # m
    error: float  # its standard error by noise, m; NaN from one frame
    stretch: float  # standard deviation of its slow change, m; zero if it may be chance


def bone_length(lengths: np.ndarray, weights: np.ndarray) -> Length:
    r"""The length of a bone from its lengths (n_frames,) in the frames; weights are zero if it is not seen.

    Noise at the ends makes the distance between them too long: with a variance σ² of the difference along each axis,
    the same in all directions, the squares q of the distances have the mean L² + 3σ² and the variance 4L²σ² + 6σ⁴.
    Together, L⁴ = mean(q)² − 1.5 var(q), without σ. Outliers are removed first.
    """
    seen = weights > 0.0
    d, w = lengths[seen], weights[seen] / weights[seen].max()
    median = np.median(d)
    kept = np.abs(d - median) <= OUTLIER * 1.4826 * np.median(np.abs(d - median)) + 1e-9 * median
    q, w = d[kept] ** 2, w[kept] / w[kept].sum()
    n = 1.0 / np.square(w).sum()  # frames of equal weight that would do as well
    if n < FEW * (1.0 - 1e-9) or not median > 0.0:
        return Length(float(np.sqrt(w @ q)), np.nan, 0.0)
    mean = w @ q
    variance = w @ np.square(q - mean) * n / (n - 1.0)
    value = (mean**2 - min(1.5 * variance, LARGEST_CORRECTION * mean**2)) ** 0.25
    # How much each frame moves the value: L⁴ = 2.5 mean(q)² − 1.5 mean(q²).
    influence = (5.0 * mean * (q - mean) - 1.5 * (q**2 - w @ q**2)) / (4.0 * value**3)
    error = np.sqrt(w @ np.square(influence) / (n - 1.0))
    return Length(float(value), float(error), _slow_change(lengths, seen, np.flatnonzero(seen)[kept]))


def _slow_change(lengths: np.ndarray, seen: np.ndarray, kept: np.ndarray) -> float:
    """The standard deviation of the change common to consecutive frames, which is not noise."""
    change = np.full(len(seen), np.nan)
    change[kept] = lengths[kept] - lengths[kept].mean()
    products = change[1:] * change[:-1]
    products = products[~np.isnan(products)]
    variance = np.square(change[kept]).mean()
    if not len(products) or products.mean() <= CHANCE / np.sqrt(len(products)) * variance:
        return 0.0
    return float(np.sqrt(products.mean()))


def symmetric_lengths(
    lengths: dict[str, Length], partner: dict[str, str], frames: dict[str, float]
) -> dict[str, Length]:
    """Replace lengths of left and right by their mean, weighted by frames; warn if they differ much."""
    found, apart = {}, []
    for name, length in lengths.items():
        other = lengths[partner[name]]
        share = frames[name] / (frames[name] + frames[partner[name]])
        value = share * length.value + (1.0 - share) * other.value
        error = float(np.hypot(share * length.error, (1.0 - share) * other.error))
        found[name] = Length(value, error if partner[name] != name else length.error, length.stretch)
        difference = abs(length.value - other.value)
        chance = np.nan_to_num(CHANCE * np.hypot(length.error, other.error))
        if length.value > other.value and difference > max(DIFFERENT * value, chance):
            apart.append(f"{name} {100.0 * length.value:.3g} cm, {partner[name]} {100.0 * other.value:.3g} cm")
    if apart:
        warn(
            f"left and right bones differ in length: {'; '.join(apart)}. With symmetric=True they have the mean length"
        )
    return found


def warn_of_lengths(lengths: dict[str, Length]) -> None:
    """Warn about bones that stretch, and about lengths lost in noise."""
    longest = max(length.value for length in lengths.values())
    stretched = {
        name: length.stretch / length.value
        for name, length in lengths.items()
        if length.stretch > STRETCH * max(length.value, 1e-3 * longest)
    }
    if stretched:
        warn(
            f"bones stretch: {_join(stretched, 'by ')} (standard deviation). Look for swapped or slipping points, "
            "wrong depth, two people"
        )
    uncertain = {
        name: length.error / length.value
        for name, length in lengths.items()
        if length.error > UNCERTAIN * length.value and name not in stretched
    }
    if uncertain:
        warn(
            f"lengths of bones are uncertain: {_join(uncertain, '±')} (standard error). Pass more frames, or "
            "layout.without([...])"
        )


def _join(shares: dict[str, float], sign: str) -> str:
    """The names with the largest shares, in %."""
    names = sorted(shares, key=lambda name: -shares[name])
    words = [f"{name} {sign}{100.0 * shares[name]:.2g} %" for name in names[:6]]
    return ", ".join(words) + (f" and {len(names) - 6} more" if len(names) > 6 else "")


# --- root axes --------------------------------------------------------------------------------------------------------
# The axes of the root in every frame: x to the left of the body, y up, z forward.


TRUNK = 0.1  # weight of what moves relative to the root, such as the spine: it only says where rigid points do not
ON_A_LINE = 1e-3  # second singular value over the first; points with less do not show the rotation about their line
# Markers of the pelvis, in front and behind, whose plane is level at rest.
SPINES = ("asi", "asis", "ias"), ("psi", "psis", "ips", "sacr", "sacrum")
AXES_ROUNDS = 20
AXES_SETTLED = 1e-6  # change of the mean shape, relative to its size, at which the rounds end


class Points(dict):
    """Positions (n_frames, 3) of each point by name, with the confidences (n_frames,) of each, 0 where not seen."""

    def __init__(self, positions: dict[str, np.ndarray], confidences: dict[str, np.ndarray]):
        super().__init__(positions)
        self.confidences = confidences


def root_axes(points: Points, layout: Layout, up: str) -> np.ndarray:
    """The axes (n_frames, 3, 3) of the root as columns, in the world's axes; NaN if unknown.

    Points that are rigid with the root, and the start of the trunk, are turned onto their mean shape: generalised
    Procrustes analysis with Kabsch's rotations, J. C. Gower, "Generalized Procrustes analysis", Psychometrika 40, 1975,
    doi:10.1007/BF02291478. Left and up refer to the mean shape. Where ASIS and PSIS are seen, up is perpendicular to
    their plane (ISB: G. Wu et al., 2002, doi:10.1016/S0021-9290(01)00222-6). Without left and right by name, left is
    from the last of the rigid points to the first, and up to all of them, as the fingers of a hand are up from the
    wrist. If there are no such points, or all are on one line, nothing is turned: the root has the axes of the world,
    with y up.
    """
    names, pairs, middle = _shape(layout)
    world = np.tile(np.roll(np.eye(3), "yzx".index(up), axis=0).T, (len(points[layout.root]), 1, 1))
    if not pairs:
        return world
    vectors, weights = _vectors(points, layout, names, up)
    left = [(names.index(a), names.index(b)) for a, b in pairs]
    upward = [names.index(name) for name in middle]

    axes = _orthonormal(vectors, left, upward)
    if np.isnan(axes[:, 0, 0]).all() and not layout.pairs:
        return world
    shape = _mean_shape(layout, axes, vectors, weights)
    for _ in range(AXES_ROUNDS):
        before, axes = shape, _kabsch(vectors, weights, shape)
        shape = _mean_shape(layout, axes, vectors, weights)
        if np.abs(shape - before).max() <= AXES_SETTLED * np.abs(shape).max():
            break
    still, plain = _orthonormal(shape[None], left, upward)[0], _plain_names(layout)
    spines = [[i for i, name in enumerate(names) if name and plain[name][0] in each] for each in SPINES]
    if all(spines):
        ahead = shape[spines[0]].mean(axis=0) - shape[spines[1]].mean(axis=0)
        level = np.cross(ahead, still[:, 0])
        level *= np.sign(level @ still[:, 1])  # up, even if left and right are exchanged
        still = _orthonormal(np.vstack([shape, level])[None], left, [len(shape)])[0]
    return axes @ still


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
    rigid, sure = np.isin(names, rigid_with(layout.root, layout)), points.confidences[layout.root][:, None]
    up_again = np.tile(np.eye(3)["xyz".index(up)], (len(sure), 1))
    vectors = np.stack([points[name] - points[layout.root] if name else up_again for name in names], axis=1)
    confidences = np.stack([points.confidences[name] if name else np.ones(len(sure)) for name in names], axis=1)
    weights, lengths = confidences * sure * np.where(rigid, 1.0, TRUNK), np.linalg.norm(vectors, axis=2)
    sizes = [np.median(length[length > 0.0]) for length in lengths.T[rigid] if (length > 0.0).any()]
    with np.errstate(invalid="ignore", divide="ignore"):
        vectors[:, ~rigid] *= (max(sizes, default=1.0) / lengths[:, ~rigid])[:, :, None]
    unseen = np.isnan(vectors).any(axis=2) | (weights == 0.0)
    vectors[unseen], weights[unseen] = 0.0, 0.0
    return vectors, weights


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


# --- standing ---------------------------------------------------------------------------------------------------------
# The person of a layout at rest: the same for everyone, so that poses of several people compare.
#
# The person stands upright, with bent knees and with the forearms held forward, as in running, so that joints are in
# the middle of what they can do. An arm that hangs down at rest is half a turn away when it is raised, where rotation
# vectors jump, and so is a straight shank in a squat. The thighs point down: where nothing shows how the pelvis is
# rotated about the line of the hips, it is such that thighs and trunk are near to rest.


# Where points stand, m: x to the left, y up, z forward. Only the directions from one to another are used.
_MIDDLE = (
    (("root", "pelvis", "hips", "hip", "midhip", "hipcenter", "spinebase"), (0.0, 0.95, 0.0)),
    (("lowerback", "spine1"), (0.0, 1.05, 0.0)),
    (("spine", "spine2", "spinemid", "upperback"), (0.0, 1.16, 0.0)),
    (("spine3", "chest", "thorax", "sternum"), (0.0, 1.3, 0.0)),
    (("spineshoulder", "shouldercenter", "lowerneck"), (0.0, 1.42, 0.0)),
    (("neck", "c7"), (0.0, 1.45, 0.0)),
    (("upperneck",), (0.0, 1.53, 0.0)),
    (("head",), (0.0, 1.65, 0.0)),
    (("nose",), (0.0, 1.58, 0.12)),
)
_LEFT = (
    (("hip", "hipjoint", "hjc"), (0.1, 0.92, 0.0)),
    (("knee", "femur", "kne", "kjc"), (0.1, 0.5, 0.0)),
    (("ankle", "tibia", "ank", "ajc"), (0.1, 0.18, -0.27)),
    (("heel",), (0.1, 0.12, -0.33)),
    (("foot",), (0.1, 0.12, -0.17)),
    (("toe", "toes", "bigtoe", "smalltoe", "footindex"), (0.1, 0.08, -0.1)),
    (("collar",), (0.08, 1.42, 0.0)),
    (("shoulder", "clavicle", "sho"), (0.18, 1.45, 0.0)),
    (("elbow", "humerus", "elb", "ejc"), (0.29, 1.23, 0.13)),
    (("radius",), (0.27, 1.13, 0.3)),
    (("wrist", "wjc"), (0.265, 1.105, 0.345)),
    (("hand", "fin"), (0.26, 1.06, 0.41)),
    (("index", "pinky"), (0.255, 1.05, 0.43)),
    (("handtip", "fingers"), (0.25, 1.02, 0.48)),
    (("thumb",), (0.22, 1.08, 0.4)),
    (("eye", "eyeinner", "eyeouter"), (0.03, 1.62, 0.1)),
    (("ear",), (0.08, 1.6, 0.01)),
    (("mouth",), (0.025, 1.54, 0.1)),
)
# A hand alone, with x to the side of the thumb and y to the fingers, which are straight.
_HAND = {"wrist": (0.0, 0.0, 0.0)} | {
    f"{finger}{joint}": (x, y, 0.0)
    for finger, x, heights in (
        ("thumb", 0.05, (0.03, 0.06, 0.09, 0.115)),
        ("indexfinger", 0.03, (0.09, 0.13, 0.155, 0.175)),
        ("middlefinger", 0.01, (0.09, 0.135, 0.16, 0.185)),
        ("ringfinger", -0.01, (0.09, 0.13, 0.155, 0.175)),
        ("pinky", -0.03, (0.08, 0.115, 0.135, 0.15)),
    )
    for joint, y in zip(
        ("cmc", "mcp", "ip", "tip") if finger == "thumb" else ("mcp", "pip", "dip", "tip"), heights, strict=True
    )
}
# Points that are in front of their parents, however the person moves.
_IN_FRONT = {"nose", "foot", "footindex", "toe", "bigtoe", "smalltoe"}
_POSITIONS = {
    "": {name: point for names, point in _MIDDLE for name in names} | _HAND,
    "left": {name: point for names, point in _LEFT for name in names},
}


def standing_directions(layout: Layout) -> dict[str, np.ndarray]:
    """The directions (3,) of bones at rest, in the axes of the root; of those alone whose points are known."""
    at = {}
    for name, (plain, side) in _plain_names(layout).items():
        if (point := _POSITIONS["left" if side else ""].get(plain)) is not None:
            at[name] = np.array(point) * (MIRROR if side == "right" else 1.0)
    bones = {name: at[name] - at[parent] for name, parent in layout.parents.items() if name in at and parent in at}
    return {name: bone / np.linalg.norm(bone) for name, bone in bones.items() if bone.any()}


def in_front(layout: Layout) -> list[str]:
    """Points that are in front of their parents: toes and the nose."""
    return [name for name, (plain, _) in _plain_names(layout).items() if plain in _IN_FRONT]


def _plain_names(layout: Layout) -> dict[str, tuple[str, str]]:
    """The name of each point without the side, in lower case, and the side."""
    found = zip(layout.points, split_sides(layout.points), strict=True)
    words = {name: ("".join(filter(str.isalnum, word)).lower(), side) for name, (side, word) in found}
    return {name: (word.removesuffix("study"), side) for name, (word, side) in words.items()}  # OpenCap's names


# --- rest pose --------------------------------------------------------------------------------------------------------


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
            rest.axes[name] = shortest_rotations(FORWARD[:, 0], rest.directions[name][None]).as_matrix()[0] @ FORWARD
            known[name] = known[parent] & ~np.isnan(seen[name][0][:, 0])
            still = rest.axes[parent].T @ rest.directions[name]
            swings = shortest_rotations(still, np.where(known[name][:, None], seen[name][0], still)).as_matrix()
            axes[name] = axes[parent] @ swings @ rest.axes[parent].T @ rest.axes[name]
            twists = _twists(points, layout, name, axes[name], known[name], rest.axes[name])
            axes[name] = axes[name] @ Rotation.from_euler("x", twists[:, None]).as_matrix()
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


def _rigid_shape(points: Points, layout: Layout, axes: np.ndarray) -> tuple[dict[str, np.ndarray], float]:
    """Where the root and the points that are rigid with it are, in the axes of the root, and how far off in the mean.

    Mean positions in axes that follow the trunk a little do not form one rigid shape. So the shape is found from
    unbiased lengths between all of its points, by classical scaling, and rotated onto the mean positions.
    """
    everyone = [layout.root, *rigid_with(layout.root, layout)]
    n, known = len(everyone), ~np.isnan(axes[:, 0, 0])
    if n == 1:
        return {}, 0.0
    means, squares = np.zeros((n, 3)), np.zeros((n, n))
    noise, n_frames = 0.0, 1  # of a length in one frame, m
    for i, one in enumerate(everyone):
        sure = points.confidences[one] * points.confidences[layout.root] * known
        if sure.any():
            vectors = np.einsum("nab,na->nb", axes, points[one] - points[layout.root])
            means[i] = sure @ np.where(sure[:, None] > 0.0, vectors, 0.0) / sure.sum()
    for i, j in combinations(range(n), 2):
        one, other = everyone[i], everyone[j]
        together = points.confidences[one] * points.confidences[other]
        length = float(np.linalg.norm(means[i] - means[j]))
        if together.any():
            lengths = np.linalg.norm(points[one] - points[other], axis=1)
            length, spread = bone_length(lengths, together).value, float(np.std(lengths[together > 0.0]))
            if spread > noise:
                noise, n_frames = spread, int(np.count_nonzero(together))
        squares[i, j] = squares[j, i] = length**2
    products = (squares[1:, :1] + squares[:1, 1:] - squares[1:, 1:]) / 2.0
    values, vectors = np.linalg.eigh(products)
    # A bend below the noise of one frame cannot show a rotation, and one below the error of all frames may not exist.
    error = SURE * noise * np.sqrt(max(values[-1], 0.0) / n_frames)
    sizes = np.sqrt(np.where(values > max(ROUNDING * values[-1], noise**2, error), values, 0.0))
    sizes[-1] = np.sqrt(max(values[-1], 0.0))
    flat = np.zeros((n - 1, 3))
    flat[:, : n - 1] = (vectors * sizes)[:, ::-1][:, :3]
    u, _, vh = np.linalg.svd(flat.T @ means[1:])
    shape = np.insert(flat @ u @ vh, 0, 0.0, axis=0)  # with the root
    return dict(zip(everyone, shape, strict=True)), float(np.linalg.norm(shape - means, axis=1).max())


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
        turns = np.exp(1j * np.angle(overlaps))
        before, total = shape, np.maximum(weights.sum(axis=0), 1e-300)
        shape = (weights * turns.conj()[:, None] * numbers).sum(axis=0) / total
        if np.abs(shape - before).max() <= SETTLED * np.abs(shape).max():
            break
    pairs = [(rigid.index(one), rigid.index(other)) for one, other in layout.pairs if {one, other} <= set(rigid)]
    across = sum((shape[one] - shape[other] for one, other in pairs), start=0j)
    left = complex(at_rest[0, 1], at_rest[0, 2])
    shown = overlaps != 0.0
    middle = turns[shown].sum()
    if abs(across) > ACROSS * np.abs(shape).max() and abs(left) > ACROSS:
        middle = left / across
    return np.where(shown, np.angle(turns * middle.conjugate()), 0.0)
