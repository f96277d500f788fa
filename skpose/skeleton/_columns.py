"""Columns of poses: their names, their number, and what an array with others looks like."""

from collections.abc import Sequence
from typing import Any

from numpy.typing import ArrayLike

from skpose.skeleton._skeleton import Skeleton

NUMBERS_OF_A_ROTATION = {(3,): "rotvec", (4,): "quaternion_wxyz", (6,): "6d", (3, 3): "matrix"}


def check_column_names(X: ArrayLike, skeleton: Skeleton, name: str) -> None:
    """Refuse a data frame whose columns are named after dofs but are not the skeleton's, in its order.

    A data frame without any column named after a dof is taken by position, like an array.
    """
    remedy = f"{name}[list(skeleton.dof_names)]"
    _check_names(X, skeleton.dof_names, name, "degrees of freedom", "a dof of it", remedy)


def check_position_names(X: ArrayLike, skeleton: Skeleton, name: str) -> None:
    """Refuse a data frame whose columns are named after positions but are not the skeleton's, in its order."""
    names = [f"{joint}_{axis}" for joint in skeleton.joint_names for axis in "xyz"]
    remedy = f'{name}[[f"{{joint}}_{{axis}}" for joint in skeleton.joint_names for axis in "xyz"]]'
    _check_names(X, names, name, "positions of joints", "a position of it", remedy)


def _check_names(X: Any, names: Sequence[str], name: str, what: str, one: str, remedy: str) -> None:
    columns = getattr(X, "columns", None)
    if columns is None:
        return
    columns, expected = list(columns), list(names)
    if columns == expected or not set(columns) & set(expected):
        return
    missing = [each for each in expected if each not in columns]
    unknown = [column for column in columns if column not in expected]
    if missing or unknown:
        detail = f"missing: {_some(missing)}; not {one}: {_some(unknown)}"
    else:
        i = next(i for i, (a, b) in enumerate(zip(columns, expected, strict=True)) if a != b)
        detail = f"column {i} is {columns[i]!r} and should be {expected[i]!r}"
    raise ValueError(
        f"the columns of {name} are named after {what}, but not the skeleton's in its order ({detail}); select them "
        f"with {remedy}"
    )


def check_dimensions(X: ArrayLike, skeleton: Skeleton, name: str) -> None:
    """Refuse an array of three or more dimensions, in words that say what it looks like."""
    shape = _shape(X)
    if len(shape) > 2:
        raise ValueError(
            f"{name} must have shape (n_poses, {skeleton.n_dofs}), got {shape}{other_than_poses(shape, skeleton)}"
        )


def check_width(X: Any, skeleton: Skeleton, name: str) -> None:
    """Refuse an array that does not have one column for each dof."""
    if X.shape[1] != skeleton.n_dofs:
        raise ValueError(
            f"{name} has {X.shape[1]} columns, but the skeleton has {skeleton.n_dofs} degrees of freedom: one column "
            f"per name in skeleton.dof_names{other_than_poses(X.shape, skeleton)}"
        )


def check_position_dimensions(X: ArrayLike, skeleton: Skeleton, name: str) -> None:
    """Refuse an array of positions that is not two-dimensional, with the remedy."""
    shape = _shape(X)
    if len(shape) < 3:
        return
    likely = f": pass {name}.reshape(len({name}), -1)" if shape[1:] == (skeleton.n_joints, 3) else ""
    if shape[2] == 2:
        likely = ": positions in two dimensions do not say how a pose is, lift them to 3-D first"
    raise ValueError(
        f"{name} must have shape (n_samples, {3 * skeleton.n_joints}), x, y and z of each joint in "
        f"skeleton.joint_names, got {shape}{likely}"
    )


def check_position_width(X: Any, skeleton: Skeleton, name: str) -> None:
    """Refuse an array that does not have three columns for each joint."""
    n_joints, width = skeleton.n_joints, X.shape[1]
    if width == 3 * n_joints:
        return
    likely = ""
    if width == 3 * n_joints + 3:
        likely = ". Are these positions with the root? It is not among the joints: leave it out"
    elif width == 2 * n_joints:
        likely = ". Are these positions in two dimensions? Lift them to 3-D first: lengths of bones are not known from "
        likely += "a picture"
    elif width == skeleton.n_dofs:
        likely = ". Are these poses? Then this step is not needed"
    raise ValueError(
        f"{name} has {width} columns, but the skeleton has {n_joints} joints: x, y and z of each in "
        f"skeleton.joint_names, {3 * n_joints} columns{likely}"
    )


def other_than_poses(shape: Sequence[int], skeleton: Skeleton) -> str:
    """Return in words what an array of this shape, which is none of poses, may be; empty if there is no sign."""
    _, *sizes = shape
    n_joints, n_rotating = skeleton.n_joints, sum(bool(bone.dofs) for bone in skeleton.bones)
    sentences = []
    # With the root or without it.
    if sizes in ([3 * n_joints], [3 * n_joints + 3], [n_joints, 3], [n_joints + 1, 3]):
        sentences.append(
            "These look like positions of the joints, and poses are their angles, rad, as "
            "skpose.PoseFromPositions(skeleton) finds them; of positions relative to the root, "
            'sklearn.metrics.pairwise_distances is the metric "position"'
        )
    form = NUMBERS_OF_A_ROTATION.get(tuple(sizes[1:]))
    if form is not None and sizes[0] == n_rotating:
        sentences.append(
            f"These look like rotations of the joints: skpose.poses_from_rotations(..., skeleton, form={form!r}) "
            "makes poses of them"
        )
    return "".join(f". {sentence}" for sentence in sentences)


def _shape(X: Any) -> tuple[int, ...]:
    """Return the shape of an array, or of nested lists by the first of each."""
    if hasattr(X, "shape"):
        return tuple(X.shape)
    return (len(X), *_shape(X[0])) if isinstance(X, list | tuple) and X else ()


def _some(names: list[str]) -> str:
    return ", ".join(map(repr, names[:3])) + (f" and {len(names) - 3} more" if len(names) > 3 else "") or "none"
