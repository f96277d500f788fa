"""Warnings at the line of the user, whichever layers of this library and of scikit-learn are in between.

`warnings.warn` counts frames, and how many there are between the user and a warning depends on scikit-learn's wrappers
(the validation of parameters, the context of `fit`, `set_output`), which differ from version to version, and on who
calls whom here. The frames themselves show where the user is; pandas and matplotlib find it likewise, and
`skip_file_prefixes` of `warnings.warn` from Python 3.12 on. As Python shows a warning once for each line, the right
line is also what makes it appear once, and again for another call.
"""

import sys
import warnings

# Others' frames between the user and us: importlib's while skpose is imported, the last three while numba compiles.
NOT_THE_USER = frozenset({"skpose", "sklearn", "joblib", "importlib", "numba", "functools", "contextlib"})


def warn(message: str, category: type[Warning] = UserWarning) -> None:
    """Emit a warning at the line that called skpose, itself or through scikit-learn."""
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
    """Return whether the function so many frames above the caller was not called by another one of the library.

    What the library makes itself, or by `dataclasses.replace`, has been looked at when the user made what it is of.
    """
    frame = sys._getframe(1 + depth)
    transparent = {frame.f_globals.get("__name__"), "sklearn.utils._param_validation"}
    while frame.f_back is not None and frame.f_globals.get("__name__") in transparent:
        frame = frame.f_back
    return str(frame.f_globals.get("__name__")).partition(".")[0] not in {"skpose", "dataclasses"}


def _package(names: dict) -> str:
    """Return the outermost package of a module's global names; `python -m skpose` calls its module "__main__"."""
    return (names.get("__package__") or names.get("__name__") or "").partition(".")[0]
