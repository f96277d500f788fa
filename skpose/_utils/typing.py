"""Types of arguments, with names that `help` and notebooks print short."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from numpy.typing import ArrayLike as ArrayLike
    from pandas import DataFrame as DataFrame
else:
    # numpy's own is a union of private types, which signatures spell out below Python 3.12, in 300 characters each.
    ArrayLike = type("ArrayLike", (), {"__module__": "numpy.typing", "__doc__": "What `numpy.asarray` takes."})
    DataFrame = type("DataFrame", (), {"__module__": "pandas"})  # imported where one is made
