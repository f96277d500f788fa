"""scikit-learn's callback protocol, if the installed version has it (1.9)."""

import functools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from skpose._utils.progress import report_to
from skpose._utils.sklearn import CallbackSupportMixin, callback_context, with_callbacks

__all__ = ["CallbackSupportMixin", "FitReport", "with_callbacks"]


class FitReport:
    """Reports of a fit to the callbacks of its estimator: its start, each of its steps, its end.

    Parameters
    ----------
    estimator : CallbackSupportMixin
        The estimator that fits.
    n_steps : int or None
        Maximum number of steps; None if unknown.
    X : array-like
        The training data.

    Attributes
    ----------
    verbose : int
        The estimator's.
    """

    def __init__(self, estimator: Any, n_steps: int | None, X: Any):
        self._estimator, self._X = estimator, X
        self.verbose = estimator.verbose
        self._context = callback_context(estimator, n_steps)
        if self._context is not None:
            self._context.call_on_fit_task_begin(estimator=estimator, X=X)

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        """Report one step of the fit; `progress` inside it is reported as its steps."""
        if self._context is None:
            yield
            return
        with (
            self._task(self._context, name, None) as context,
            report_to(functools.partial(self._reporter, context)),
        ):
            yield

    @contextmanager
    def _task(self, parent: Any, name: str, n_steps: int | None) -> Iterator[Any]:
        context = parent.subcontext(task_name=name, max_subtasks=n_steps)
        context.call_on_fit_task_begin(estimator=self._estimator, X=self._X)
        yield context
        context.call_on_fit_task_end(estimator=self._estimator, X=self._X)

    @contextmanager
    def _reporter(self, parent: Any, what: str, n_steps: int) -> Iterator[Callable[[], None]]:
        with self._task(parent, what, n_steps) as context:

            def advance() -> None:
                with self._task(context, "step", 0):
                    pass

            yield advance

    def end(self) -> None:
        """Report the end of the fit."""
        if self._context is not None:
            self._context.call_on_fit_task_end(estimator=self._estimator, X=self._X)
