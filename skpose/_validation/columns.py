"""Columns of poses: their names, their number, and what an array with others looks like."""

from collections.abc import Sequence
from typing import Any

from skpose._typing import ArrayLike
from skpose._validation.skeletons import SkeletonLike

NUMBERS_OF_A_ROTATION = {(3,): "rotvec", (4,): "quaternion_wxyz", (6,): "6d", (3, 3): "matrix"}


def check_column_names(X: ArrayLike, skeleton: SkeletonLike, name: str) -> None:
    """Refuse a data frame whose columns are named after dofs but are not the skeleton's, in its order.

    A data frame without any column named after a dof is taken by position, like an array.
    """
    remedy = f"{name}[list(skeleton.dof_names)]"
    check_names(X, skeleton.dof_names, name, "degrees of freedom", "a dof of it", remedy)


def check_names(X: Any, names: Sequence[str], name: str, what: str, one: str, remedy: str) -> None:
    """Refuse a data frame with some of the names, but not all of them in their order."""
    columns = getattr(X, "columns", None)
    if columns is None:
        return
    columns, expected = list(columns), list(names)
    if columns == expected or not set(columns) & set(expected):
        return
    missing = [each for each in expected if each not in columns]
    unknown = [column for column in columns if column not in expected]
    if missing or unknown:
        detail = f"missing: {_list_some(missing)}; not {one}: {_list_some(unknown)}"
    else:
        i = next(i for i, (a, b) in enumerate(zip(columns, expected, strict=True)) if a != b)
        detail = f"column {i} is {columns[i]!r} and should be {expected[i]!r}"
    raise ValueError(
        f"the columns of {name} are named after {what}, but not the skeleton's in its order ({detail}); select them "
        f"with {remedy}"
    )


def check_dimensions(X: ArrayLike, skeleton: SkeletonLike, name: str) -> None:
    """Refuse an array of three or more dimensions, in words that say what it looks like."""
    shape = shape_of(X)
    if len(shape) > 2:
        raise ValueError(
            f"{name} must have shape (n_poses, {skeleton.n_dofs}), got {shape}{other_than_poses(shape, skeleton)}"
        )


def check_width(X: Any, skeleton: SkeletonLike, name: str) -> None:
    """Refuse an array that does not have one column for each dof."""
    if X.shape[1] != skeleton.n_dofs:
        raise ValueError(
            f"{name} has {X.shape[1]} columns, but the skeleton has {skeleton.n_dofs} degrees of freedom: one column "
            f"per name in skeleton.dof_names{other_than_poses(X.shape, skeleton)}"
        )


def other_than_poses(shape: Sequence[int], skeleton: SkeletonLike) -> str:
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


def shape_of(X: Any) -> tuple[int, ...]:
    """Return the shape of an array, or of nested lists by the first of each."""
    if hasattr(X, "shape"):
        return tuple(X.shape)
    return (len(X), *shape_of(X[0])) if isinstance(X, list | tuple) and X else ()


def _list_some(names: list[str]) -> str:
    return ", ".join(map(repr, names[:3])) + (f" and {len(names) - 3} more" if len(names) > 3 else "") or "none"
