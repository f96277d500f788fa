"""Labels of points: groups with a name each, in their order."""

from typing import Any, NamedTuple

import numpy as np

from skpose._utils.typing import ArrayLike


class Groups(NamedTuple):
    """Labels, and the groups of equal ones."""

    labels: np.ndarray  # (n,)
    names: list[str]  # of each group
    numbers: np.ndarray  # (n,) of the group of each label


def find_groups(labels: ArrayLike, n: int) -> Groups:
    """The groups of labels of n poses, sorted; an ordered categorical of pandas keeps its own order."""
    values = np.asarray(labels)
    if values.shape != (n,):
        raise ValueError(f"labels must have one value for each of the {n} poses, got shape {values.shape}")
    some = np.asarray(labels, dtype=object)  # before numpy makes the text "nan" of NaN
    if missing := sum(map(_is_missing, some.tolist())):
        raise ValueError(f"labels must be known for all poses, got {missing} of {n} that are None or NaN")
    dtype: Any = getattr(labels, "dtype", None)
    if getattr(dtype, "ordered", False):
        place = {category: i for i, category in enumerate(dtype.categories)}
        found, numbers = np.unique([place[label] for label in some.tolist()], return_inverse=True)
        return Groups(values, [_visible(str(dtype.categories[i])) for i in found], numbers)
    if values.dtype == object:
        values = np.array(values.tolist())  # numbers with texts become texts
    found, numbers = np.unique(values, return_inverse=True)
    return Groups(values, [_visible(str(label)) for label in found], numbers)


def _is_missing(label: Any) -> bool:
    try:
        return label is None or bool(label != label)
    except TypeError:  # of pandas.NA
        return True


def _visible(name: str) -> str:
    """A name as legends show it: matplotlib leaves out empty ones and those after "_" without quotes."""
    return name if name.strip() and not name.startswith("_") else f'"{name}"'
