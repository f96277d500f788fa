"""Private parts of scikit-learn: validation of parameters, names and weights, the context of `fit`, the callbacks."""

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
from sklearn.utils._param_validation import validate_params as _validate_params
from sklearn.utils.validation import _check_feature_names_in as check_feature_names_in
from sklearn.utils.validation import _check_sample_weight

if TYPE_CHECKING:
    Function = TypeVar("Function", bound=Callable)

    def validate_params(constraints: dict, *, prefer_skip_nested_validation: bool) -> Callable[[Function], Function]:
        """Keep the types of the function that it decorates."""
        ...
else:

    def validate_params(constraints, *, prefer_skip_nested_validation):
        """Validate arguments as scikit-learn does, with errors that name the function and its parameters.

        scikit-learn binds the arguments to the function's signature; this one has words for those that do not fit.
        """
        decorate = _validate_params(constraints, prefer_skip_nested_validation=prefer_skip_nested_validation)

        def apply(function):
            function.__signature__ = signature = _Signature.from_callable(function)
            signature.function = function.__name__
            return decorate(function)

        return apply


class _Signature(inspect.Signature):
    """A signature whose errors name the function and the parameters that it has."""

    function = ""

    def bind(self, *args: Any, **kwargs: Any) -> inspect.BoundArguments:
        try:
            return super().bind(*args, **kwargs)
        except TypeError as error:
            parameters = self.parameters.values()
            first = [p.name for p in parameters if p.kind is not p.KEYWORD_ONLY]
            named = [p.name for p in parameters if p.kind is p.KEYWORD_ONLY]
            problem = f"got {len(args)} arguments without a name" if len(args) > len(first) else str(error)
            raise TypeError(
                f"{self.function}() {problem}: its arguments are {', '.join(first)}, and those that need their name, "
                f"as in {named[0]}=..., are {', '.join(named)}"
            ) from None


class StrOptions(_StrOptions):
    """A constraint: one of some words, which errors list in their order; scikit-learn's has that of a set.

    Parameters
    ----------
    words : iterable of str
        The words.
    """

    def __init__(self, words: Iterable[str]):
        self.words = tuple(words)
        super().__init__(set(self.words))

    def __str__(self) -> str:
        return f"a str among {{{', '.join(map(repr, self.words))}}}"


class InstanceOf(HasMethods):
    """A constraint: an instance of a public class, which errors name as users import it.

    scikit-learn's own names the private module where the class is defined. It accepts constraints of a few classes
    only, so this is one of them.

    Parameters
    ----------
    is_one : callable
        Returns whether a value is an instance.
    name : str
        Its public name.
    explain : callable
        Called with what is no instance; may raise a TypeError with a remedy.
    """

    def __init__(self, is_one: Callable[[object], bool], name: str, explain: Callable[[object], None]):
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


# Newer versions of scikit-learn refuse weights that are all zero, in other words than ours; older ones let them pass.
_ZEROS = "allow_all_zero_weights"
_MAY_BE_ZEROS = {_ZEROS: True} if _ZEROS in inspect.signature(_check_sample_weight).parameters else {}


def check_sample_weight(sample_weight: Any, X: np.ndarray) -> np.ndarray:
    """Return the weights of the rows of X in float64: not negative, and somewhere positive; ones for None."""
    weights = _check_sample_weight(sample_weight, X, dtype=np.float64, ensure_non_negative=True, **_MAY_BE_ZEROS)
    if not weights.any():
        raise ValueError(
            f"sample_weight must be somewhere positive, but the weights of all {len(weights)} samples are zero; leave "
            "it out for equal ones"
        )
    return weights


try:
    from sklearn.callback import CallbackSupportMixin, with_callbacks
except ImportError:  # before scikit-learn 1.9

    class CallbackSupportMixin:  # type: ignore[no-redef]
        """Replacement where scikit-learn has no callbacks."""

    def with_callbacks(method: Any) -> Any:
        """Return the method unchanged."""
        return method


__all__ = [
    "CallbackSupportMixin",
    "HasMethods",
    "Hidden",
    "InstanceOf",
    "Interval",
    "InvalidParameterError",
    "RealNotInt",
    "StrOptions",
    "callback_context",
    "check_feature_names_in",
    "check_sample_weight",
    "fit_context",
    "validate_parameter_constraints",
    "validate_params",
    "with_callbacks",
]


def callback_context(estimator: Any, n_steps: int | None) -> Any:
    """Return the context in which an estimator reports to its callbacks; None where it has none."""
    if not hasattr(estimator, "_init_callback_context"):
        return None
    return estimator._init_callback_context(max_subtasks=n_steps)
