"""Warnings at the line of the user, through any layers of this library and of scikit-learn.

`warnings.warn` counts frames, and their number depends on scikit-learn's wrappers, which differ between versions. Here
the frames themselves show where the user is, as with `skip_file_prefixes` of Python 3.12. Python shows a warning once
for each line, so the right line also makes it appear once per call.
"""

import sys
import warnings

# Frames between the user and skpose: importlib's while skpose is imported, the last three while numba compiles.
NOT_THE_USER = frozenset({"skpose", "sklearn", "joblib", "importlib", "numba", "functools", "contextlib"})


def warn(message: str, category: type[Warning] = UserWarning) -> None:
    """Emit a warning at the line that called skpose, directly or through scikit-learn."""
    frame = sys._getframe(1)
    while frame.f_back is not None and _package(frame.f_globals) in NOT_THE_USER:
        frame = frame.f_back
    names = frame.f_globals
    warnings.warn_explicit(
        message,
        category,
        filename=frame.f_code.co_filename,
        lineno=frame.f_lineno,
        module=names.get("__name__", "<unknown>"),
        registry=names.setdefault("__warningregistry__", {}),
    )


def is_called_by_user(depth: int) -> bool:
    """Whether the function `depth` frames above the caller was called from outside the library.

    Objects that the library makes itself, or with `dataclasses.replace`, were checked when the user made them.
    """
    frame = sys._getframe(1 + depth)
    transparent = {frame.f_globals.get("__name__"), "sklearn.utils._param_validation"}
    while frame.f_back is not None and frame.f_globals.get("__name__") in transparent:
        frame = frame.f_back
    return str(frame.f_globals.get("__name__")).partition(".")[0] not in {"skpose", "dataclasses"}


def _package(names: dict) -> str:
    """The outermost package of a module; `python -m skpose` calls its module "__main__"."""
    return (names.get("__package__") or names.get("__name__") or "").partition(".")[0]
