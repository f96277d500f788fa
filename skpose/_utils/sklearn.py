"""Private parts of scikit-learn: validation of parameters, names and weights, the context of `fit`."""

import inspect
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from sklearn.base import _fit_context as fit_context
from sklearn.metrics.pairwise import _check_chunk_size as check_chunk_size
from sklearn.utils._param_validation import (
    HasMethods,
    Interval,
    RealNotInt,
    StrOptions as _StrOptions,
)
from sklearn.utils.validation import _check_feature_names_in as check_feature_names_in, _check_sample_weight

if TYPE_CHECKING:
    Function = TypeVar("Function", bound=Callable)

    def validate_params(constraints: dict, *, prefer_skip_nested_validation: bool) -> Callable[[Function], Function]:
        """Keep the types of the function that it decorates."""
        ...
else:
    from sklearn.utils._param_validation import validate_params


def StrOptions(words: Iterable[str]) -> _StrOptions:
    """A constraint: one of some words."""
    return _StrOptions(set(words))


# Newer versions of scikit-learn refuse weights that are all zero; older ones let them pass.
_ZEROS = "allow_all_zero_weights"
_MAY_BE_ZEROS = {_ZEROS: True} if _ZEROS in inspect.signature(_check_sample_weight).parameters else {}


def check_sample_weight(sample_weight: Any, X: np.ndarray) -> np.ndarray:
    """Weights of the rows of X in float64, not negative and not all zero; ones for None."""
    weights = _check_sample_weight(sample_weight, X, dtype=np.float64, ensure_non_negative=True, **_MAY_BE_ZEROS)
    if not weights.any():
        raise ValueError(f"sample_weight must have a positive weight, but all {len(weights)} are zero")
    return weights


__all__ = [
    "HasMethods",
    "Interval",
    "RealNotInt",
    "StrOptions",
    "check_chunk_size",
    "check_feature_names_in",
    "check_sample_weight",
    "fit_context",
    "validate_params",
]
