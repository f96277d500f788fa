"""Private parts of scikit-learn: validation of parameters, the context of `fit`, the callback protocol."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from sklearn.base import _fit_context as fit_context
from sklearn.utils._param_validation import HasMethods, Interval, StrOptions, validate_parameter_constraints

if TYPE_CHECKING:
    Function = TypeVar("Function", bound=Callable)

    def validate_params(constraints: dict, *, prefer_skip_nested_validation: bool) -> Callable[[Function], Function]:
        """Keep the types of the function that it decorates."""
        ...
else:
    from sklearn.utils._param_validation import validate_params

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
    "Interval",
    "StrOptions",
    "callback_context",
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
