"""Labels of points: groups with a name each, in their order."""

from numbers import Real
from typing import Any, NamedTuple

import numpy as np

from skpose._typing import ArrayLike


class Groups(NamedTuple):
    """Labels, and the groups of equal ones."""

    labels: np.ndarray  # (n,)
    names: list[str]  # of each group
    numbers: np.ndarray  # (n,) of the group of each label


def find_groups(labels: ArrayLike, n: int) -> Groups:
    """Return the groups of labels of n poses, sorted; those of an ordered categorical of pandas in its order.

    Labels that cannot be compared with each other, such as numbers and texts, are sorted as texts.
    """
    some = np.ma.asarray(labels) if np.ma.isMaskedArray(labels) else _as_objects(labels)
    if some.shape != (n,):
        raise ValueError(f"labels must be one for each of the {n} poses, got shape {some.shape}")
    missing = sum(map(_is_missing, some.tolist()))  # before numpy makes the text "nan" of NaN
    if missing:
        raise ValueError(
            f"labels must be one for each pose, got {missing} of {n} that are missing, such as None or NaN: leave "
            'these poses out, or give them a label such as "unknown"'
        )
    values = np.asarray(labels)
    if values.dtype == object and all(isinstance(label, str | Real | np.bool_) for label in values):
        values = np.array(values.tolist())  # numbers, or texts, that were kept as objects
    dtype: Any = getattr(labels, "dtype", None)
    if getattr(dtype, "ordered", False):
        place = {category: i for i, category in enumerate(dtype.categories)}
        found, numbers = np.unique([place[label] for label in some.tolist()], return_inverse=True)
        return Groups(values, [_visible(str(dtype.categories[i])) for i in found], numbers)
    try:
        found, numbers = np.unique(values, return_inverse=True)
    except TypeError:
        values = np.array([str(label) for label in values])
        found, numbers = np.unique(values, return_inverse=True)
    return Groups(values, [_visible(str(label)) for label in found], numbers)


def _as_objects(labels: ArrayLike) -> np.ndarray:
    if not isinstance(labels, list | tuple):
        return np.asarray(labels, dtype=object)
    # A masked value among them would become 0.
    return np.asarray([None if label is np.ma.masked else label for label in labels], dtype=object)


def _is_missing(label: Any) -> bool:
    try:
        return label is None or bool(label != label)
    except TypeError:  # pandas.NA is neither
        return True


def _visible(name: str) -> str:
    """Return a name as legends show it: without quotes, matplotlib leaves out empty ones and those after "_"."""
    return name if name.strip() and not name.startswith("_") else f'"{name}"'
