"""Tables of pandas, which is imported where a table is asked for."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas


def frame_of(columns: Mapping[str, np.ndarray]) -> "pandas.DataFrame":
    """Return columns of equal length as a data frame."""
    try:
        import pandas
    except ImportError:
        raise ImportError("to_pandas needs pandas: pip install 'skpose[pandas]'") from None
    return pandas.DataFrame(dict(columns))
