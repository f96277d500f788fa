"""Private parts of scikit-learn: validation of parameters, names and weights, the context of `fit`."""

import inspect
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from sklearn.base import _fit_context as fit_context
from sklearn.utils._param_validation import (
    HasMethods,
    Hidden,
    Interval,
    InvalidParameterError,
    RealNotInt,
    validate_parameter_constraints,
)
from sklearn.utils._param_validation import StrOptions as _StrOptions
from sklearn.utils.validation import _check_feature_names_in as check_feature_names_in
from sklearn.utils.validation import _check_sample_weight

if TYPE_CHECKING:
    Function = TypeVar("Function", bound=Callable)

    def validate_params(constraints: dict, *, prefer_skip_nested_validation: bool) -> Callable[[Function], Function]:
        """Keep the types of the function that it decorates."""
        ...
else:
    from sklearn.utils._param_validation import validate_params


class StrOptions(_StrOptions):
    """A constraint: one of some words, listed in errors in their order; scikit-learn lists them as a set."""

    def __init__(self, words: Iterable[str]):
        self.words = tuple(words)
        super().__init__(set(self.words))

    def __str__(self) -> str:
        return f"a str among {{{', '.join(map(repr, self.words))}}}"


class InstanceOf(HasMethods):
    """A constraint: an instance of a class, named in errors as users import it.

    scikit-learn's own names the private module of the class. It accepts subclasses of its own constraints only.

    Parameters
    ----------
    is_one : callable
        Says whether a value is an instance.
    name : str
        Public name of the class.
    explain : callable, optional
        Called with any other value; may raise a TypeError with a remedy.
    """

    def __init__(self, is_one: Callable[[object], bool], name: str, explain: Callable[[object], Any] = lambda _: None):
        super().__init__("__class__")
        self.is_one, self.name, self.explain = is_one, name, explain

    def is_satisfied_by(self, val: object) -> bool:
        if self.is_one(val):
            return True
        try:
            self.explain(val)
        except TypeError as error:
            raise InvalidParameterError(str(error)) from None  # a ValueError too, as all of scikit-learn's
        return False

    def __str__(self) -> str:
        return f"an instance of {self.name!r}"


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
    "Hidden",
    "InstanceOf",
    "Interval",
    "InvalidParameterError",
    "RealNotInt",
    "StrOptions",
    "check_feature_names_in",
    "check_sample_weight",
    "fit_context",
    "validate_parameter_constraints",
    "validate_params",
]
