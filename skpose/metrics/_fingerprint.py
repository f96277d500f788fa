"""Digests of metrics and arrays, for `skpose.motions._memory`; to be deleted together with it."""

import hashlib
import inspect
import json
from importlib.metadata import version
from typing import Any

import numpy as np

from skpose.metrics._metric import Metric


def metric_fingerprint(metric: Metric) -> dict[str, Any]:
    """Return the part of a fingerprint that is of the version and the metric."""
    kind = type(metric)
    return {
        "version of skpose": version("skpose"),
        "metric or parameters of it": [
            f"{kind.__module__}.{kind.__qualname__}",
            *map(repr, metric._parameters()),
            *fingerprint_of_functions(metric),
        ],
    }


def digest(*arrays: np.ndarray) -> str:
    known = hashlib.sha256()
    for array in arrays:
        known.update(json.dumps([array.dtype.str, array.shape]).encode())
        known.update(np.ascontiguousarray(array))
    return known.hexdigest()


def fingerprint_of_functions(metric: Any) -> list[str]:
    """Return what identifies the functions of a metric of one's own, which may be edited while files are kept."""
    plain = [getattr(function, "plain", None) for function in (metric.encode, metric.measure)]
    described = [_describe(function, set()) for function in plain if function is not None]
    return [hashlib.sha256(repr(one).encode()).hexdigest() for one in described]


def _describe(value: Any, seen: set[int]) -> Any:
    """Return what identifies a function or a value that a function uses by name: code, numbers; of modules the name."""
    value = getattr(value, "py_func", value)
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    if inspect.ismodule(value):
        return value.__name__
    if not inspect.isfunction(value) or id(value) in seen:
        return value.__qualname__ if inspect.isfunction(value) else value
    seen.add(id(value))
    code, used = value.__code__, inspect.getclosurevars(value)
    names = sorted({**used.globals, **used.nonlocals}.items())
    return code.co_code, code.co_consts, code.co_names, [(name, _describe(one, seen)) for name, one in names]
