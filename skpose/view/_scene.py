"""Motions in space, as pages draw them: y points up, and the ground is at zero."""

import base64
import zlib
from typing import Any, NamedTuple

import numpy as np

from skpose._utils.units import extent_of
from skpose.keypoints import Keypoints, Layout
from skpose.keypoints._keypoints import without_gaps
from skpose.keypoints._layout import find_names
from skpose.keypoints._layouts import find_layout
from skpose.kinematics import forward_kinematics
from skpose.kinematics._anatomy import joint_places
from skpose.kinematics._ground import find_ground
from skpose.skeleton import Motion
from skpose.skeleton._root import heading, root_orientations
from skpose.skeleton._sides import sides
from skpose.view._shape import OF_POINT, THICKEST, Part, Shape, Sphere, find_shape

LEVELS = 2**16 - 1
MOST = 2**32 - 1
ANGLE = 2.0 * np.pi / 2**16  # rad, the step of angles

Packed = dict[str, Any]


def pack(values: np.ndarray, step: float | None = None) -> Packed:
    """Pack an array (n, k) of finite numbers as a JSON object; each is rounded to the nearest multiple of a step.

    Parameters
    ----------
    values : ndarray of shape (n, k)
        At least one number.
    step : float, default=None
        The step; None divides the range of all values into 65,535, so that no number is off by more than a 131,070th
        of the range. A given step takes 16 or 32 bits a number, and is made larger if 32 do not suffice.
    """
    low, extent = float(values.min()), float(np.ptp(values))
    dtype = np.dtype("<u2" if step is None or extent <= LEVELS * step else "<u4")
    step = extent / LEVELS if step is None else max(step, extent / MOST)
    steps = np.rint((values - low) / step) if step > 0.0 else np.zeros(values.shape)
    whole = steps.astype(dtype)
    change = np.diff(whole, axis=0, prepend=np.zeros((1, whole.shape[1]), dtype))  # modulo the number of levels
    bytes_of = np.ascontiguousarray(change.T).view(np.uint8).reshape(-1, dtype.itemsize)
    # Column by column, and of all numbers first the low bytes, then the next.
    text = base64.b64encode(zlib.compress(bytes_of.T.tobytes(), 9)).decode("ascii")
    return {"shape": list(values.shape), "low": low, "step": step, "bytes": dtype.itemsize, "data": text}


def unpack(packed: Packed) -> np.ndarray:
    """The array (n, k) that a page has after `pack`."""
    n, k = packed["shape"]
    content = zlib.decompress(base64.b64decode(packed["data"]))
    bytes_of = np.frombuffer(content, dtype=np.uint8).reshape(packed["bytes"], -1)
    change = np.ascontiguousarray(bytes_of.T).view(f"<u{packed['bytes']}").reshape(k, n)
    whole = np.cumsum(change, axis=1, dtype=change.dtype)
    return packed["low"] + packed["step"] * whole.T.astype(np.float64)


# --- scene ------------------------------------------------------------------------------------------------------------


# For each axis that points up: which axes of the world are x, y and z here. A cyclic change does not mirror.
AXES = {"x": (2, 0, 1), "y": (0, 1, 2), "z": (1, 2, 0)}


class Scene(NamedTuple):
    """Positions of a motion's joints, m."""

    joints: np.ndarray  # (n_frames, n_joints, 3) minus the root's position, as the root is rotated
    root: np.ndarray  # (n_frames, 3)
    headings: np.ndarray  # (n_frames,) rotation of the root about y, rad
    axes: str  # names of the axes of the world that are x, y and z here
    size: float  # the largest extent of the first pose along an axis, m; of all poses if that is zero; or else 1
    standing: int  # frames that the height of the ground is found from, see `skpose.kinematics._ground`


def scene_of(motion: Motion) -> Scene:
    order = AXES[motion.up]
    orientations = root_orientations(motion.root_angles, motion.root_axes)
    poses = forward_kinematics(motion.angles, motion.skeleton)
    joints = np.einsum("fij,fkj->fki", orientations.as_matrix(), poses)[..., order]
    root = motion.root_positions[:, order]
    extents = joints.max(axis=1).clip(min=0.0) - joints.min(axis=1).clip(max=0.0)  # the root is at zero
    size = float(extents[0].max() or extents.max() or 1.0)
    height, standing = find_ground(np.concatenate([root[:, None], joints + root[:, None]], axis=1), motion.times, size)
    return Scene(
        joints,
        root - [0.0, height, 0.0],
        heading(orientations, motion.up),
        "".join("xyz"[axis] for axis in order),
        size,
        standing,
    )


def vertical_of(motion: Motion) -> np.ndarray:
    """The vertical of the world (3,) in the axes of the root, summed over the frames."""
    orientations = root_orientations(motion.root_angles, motion.root_axes)
    return orientations.inv().apply(np.eye(3)["xyz".index(motion.up)]).sum(axis=0)


def motion_data(motion: Motion, label: str) -> dict[str, Any]:
    """Data of a motion in a page, as an object of JSON."""
    scene = scene_of(motion)
    skeleton, numbers = motion.skeleton, motion.frame_numbers - motion.frame_numbers[0]
    return scene_data(scene) | {
        "label": label,
        "names": joint_places(skeleton),
        "parents": skeleton.parents.tolist(),
        "sides": sides(skeleton.joint_names),
        "shape": find_shape(skeleton).data(),
        "rate": motion.frame_rate,
        "start": float(motion.times[0]),
        "numbers": pack(numbers[:, None], 1.0) if numbers[-1] >= len(numbers) else None,  # frames are missing
        "headings": pack(scene.headings[:, None], ANGLE),
    }


def scene_data(scene: Scene) -> dict[str, Any]:
    """Data of any scene: positions, and their largest error, mm."""
    joints = pack(scene.joints.reshape(len(scene.joints), -1))
    root = pack(scene.root, joints["step"] or scene.size / 2**16)
    off = unpack(root) - scene.root
    off_joints = unpack(joints).reshape(scene.joints.shape) - scene.joints + off[:, None]
    return {
        "axes": scene.axes,
        "size": scene.size,
        "standing": scene.standing,
        "error": 1e3 * float(max(np.linalg.norm(one, axis=-1).max() for one in (off, off_joints))),
        "joints": joints,
        "root": root,
    }


# --- points -----------------------------------------------------------------------------------------------------------
# Keypoints in space, as pages draw them: like a motion, with the bones of a layout.


def figure_of(keypoints: Keypoints, layout: Layout | None) -> tuple[np.ndarray, list[str], list[int], str | None]:
    """Positions (n_frames, n_points, 3), names and parents of points, −1 without a bone, and the name of the layout.

    Points are those of the layout with its midpoints, then others, which have no bones. None is the layout whose points
    are all there by name, if any.
    """
    layout = find_layout(keypoints.names) if layout is None else layout
    if layout is None:
        return keypoints.positions, list(keypoints.names), [-1] * len(keypoints.names), None
    known = layout.keypoints(keypoints)  # refuses keypoints without a point of the layout
    given = find_names(layout.points, keypoints.names)
    others = [name for name in keypoints.names if name not in given.values()]
    parents = [-1 if parent is None else known.names.index(parent) for parent in map(layout.parents.get, known.names)]
    rest = keypoints.positions[:, [keypoints.names.index(name) for name in others]]
    names = [*(given.get(name, name) for name in known.names), *others]
    return np.concatenate([known.positions, rest], axis=1), names, parents + [-1] * len(others), layout.name


def points_data(keypoints: Keypoints, label: str, layout: Layout | None) -> dict[str, Any]:
    """Data of keypoints in a page, as an object of JSON; see `motion_data`.

    Missing points are interpolated linearly over time, so that the middle of all points, which the view follows instead
    of a root, does not jump.
    """
    positions, names, parents, of_layout = figure_of(keypoints, layout)
    order = AXES[keypoints.up]
    positions = positions[..., order]
    seen = ~np.isnan(positions[..., 0])
    filled = without_gaps(positions, seen)
    middle = filled[:, seen.any(axis=0)].mean(axis=1)
    size, times = extent_of(positions) or 1.0, np.arange(len(positions)) / keypoints.frame_rate
    height, standing = find_ground(positions, times, size)
    joints = np.where(seen.any(axis=0)[:, None], filled - middle[:, None], 0.0)
    axes, root = "".join("xyz"[axis] for axis in order), middle - [0.0, height, 0.0]
    return scene_data(Scene(joints, root, np.zeros(len(middle)), axes, size, standing)) | {
        "label": label,
        "names": names,
        "parents": parents,
        "sides": sides(names),
        "shape": _shape_of(parents, size).data(),
        "rate": keypoints.frame_rate,
        "start": 0.0,
        "numbers": None,
        "headings": None,  # nothing is known of where points face
        "seen": pack(seen.astype(float), 1.0),
        "layout": of_layout,
    }


def _shape_of(parents: list[int], size: float) -> Shape:
    """Links between points, and smaller balls for points without a bone."""
    linked = {*parents, *(i for i, parent in enumerate(parents) if parent >= 0)}
    radii = [(THICKEST if i in linked else OF_POINT) * size for i in range(len(parents))]
    spheres = [Sphere((i + 1,), radius, inside=i in parents) for i, radius in enumerate(radii)]
    parts = [Part(i, ((parent, i) if parent >= 0 else (i,),)) for i, parent in enumerate(parents)]
    return Shape(spheres, parts, False)
