"""Compilation of the two functions of a metric of one's own, written for one pose and for two."""

import hashlib
import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit

from skpose._compiled.pose.encode import encode_positions
from skpose._compiled.pose.loops import encode_poses
from skpose._compiled.pose.tree import Tree
from skpose._compiled.simd.lanes import empty_rows, flat


def compile_encode(function: Callable[[np.ndarray, np.ndarray, np.ndarray], None]) -> Any:
    """Compile the function that writes the code of a pose, for `Metric.encode`.

    Parameters
    ----------
    function : callable
        ``function(pose, positions, code)``, which numba can compile. `pose` of shape (n_dofs,) are the columns, rad.
        `positions` of shape (n_joints, 3) are the joints that have weight, in the order of the skeleton and in the axes
        of the root, m, times the square roots of their weights; of shape (0, 3) without a skeleton. It writes into
        `code` of shape (n_codes,), which is NaN before: all numbers, each finite.

    Returns
    -------
    callable
        A function of vector registers, for the class attribute `encode`.

    See Also
    --------
    compile_measure : The function of two codes.
    Metric : The base class, with an example.

    Notes
    -----
    It is compiled in every process that uses it, in a second or two. Metrics whose codes are positions or angles can
    take ``Position.encode`` or ``Angle.encode``, which are faster.

    Examples
    --------
    >>> from skpose.metrics import compile_encode
    >>> @compile_encode
    ... def encode_heights(pose, positions, code):
    ...     for j in range(positions.shape[0]):
    ...         code[j] = positions[j, 1]
    """
    plain = getattr(function, "py_func", function)
    one = njit(plain, nogil=True)
    unwritten = (
        f"{plain.__qualname__}, which encodes poses, leaves a number of some pose's code unwritten, or writes NaN or "
        "infinity: it must write as many numbers as n_codes states, for every pose"
    )

    @njit(nogil=True)
    def encode(poses: Any, tree: Any, steps: Any, scratch: Any, codes: Any) -> None:
        n_dofs, width = poses.shape[0], codes.size // codes.shape[0]
        n_joints, columns, put = tree.offset.shape[0] - 1, flat(poses), flat(codes)
        placed = empty_rows(poses, 3 * n_joints + 1)
        if n_joints > 0:
            encode_positions(poses, tree, steps, scratch, placed)
        places = placed.reshape(-1)  # not `flat`, which is an address: numba frees an array after its last use
        pose, positions, code = np.empty(n_dofs), np.empty((n_joints, 3)), np.empty(codes.shape[0])
        for w in range(width):
            for d in range(n_dofs):
                pose[d] = columns[d * width + w]
            for j in range(n_joints):
                for i in range(3):
                    positions[j, i] = places[(3 * j + i) * width + w]
            code[:] = np.nan
            one(pose, positions, code)
            for k in range(codes.shape[0]):
                if not np.isfinite(code[k]):
                    raise ValueError(unwritten)
                put[k * width + w] = code[k]

    encode.plain = plain  # type: ignore[attr-defined]  # for `check_functions`
    return encode


def compile_measure(function: Callable[[np.ndarray, np.ndarray], float]) -> Any:
    """Compile the function that computes the distance between two codes, for `Metric.measure`.

    Parameters
    ----------
    function : callable
        ``function(a, b) -> float``, which numba can compile, on codes of shape (n_codes,), float32 or float64. It must
        give zero for equal codes, elsewhere a finite number, nowhere negative, and the same for (b, a).

    Returns
    -------
    callable
        A function of vector registers, for the class attribute `measure`.

    See Also
    --------
    compile_encode : The function that writes a code.
    Metric : The base class, with an example.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose.metrics import compile_measure
    >>> @compile_measure
    ... def largest_difference(a, b):
    ...     return np.abs(a - b).max()
    """
    plain = getattr(function, "py_func", function)
    one = njit(plain, nogil=True)
    no_distance = (
        f"{plain.__qualname__}, which measures codes, gives NaN, infinity or less than zero for some poses: a distance "
        "is finite and not negative"
    )

    @njit(nogil=True)
    def measure(x: Any, Y: Any, first: Any, last: Any, tree: Any, steps: Any, scratch: Any, results: Any) -> None:
        n, width = x.shape[0], Y.size // Y.shape[0]
        code, codes, distances = np.empty(n, x.dtype), flat(Y), flat(results.distances)
        for k in range(first, last):
            for w in range(width):
                for i in range(n):
                    code[i] = codes[(k * n + i) * width + w]
                distance = one(x, code)
                if not 0.0 <= distance < np.inf:
                    raise ValueError(no_distance)
                distances[(k - first) * width + w] = distance

    measure.plain = plain  # type: ignore[attr-defined]
    return measure


_checked: set[tuple] = set()  # metrics whose functions have been checked, on so many dofs and joints


def check_functions(metric: Any, tree: Tree, n_dofs: int, n_codes: int) -> None:
    """Refuse functions of a metric of one's own that do not fit its `n_codes`, or give what is no distance.

    They run as plain Python, which sees when they leave an array, on two poses that are made up. Compiled, they would
    write into other memory without a word.
    """
    encode, measure = (getattr(function, "plain", None) for function in (metric.encode, metric.measure))
    key = (metric, n_dofs, n_codes, tree.n_joints)
    if (encode is None and measure is None) or key in _checked:
        return
    name = type(metric).__name__
    poses = np.stack([0.1 + 0.05 * np.arange(n_dofs), 0.7 - 0.03 * np.arange(n_dofs)])
    codes = np.full((2, n_codes), np.nan)
    if encode is None:
        encode_poses(poses, metric.encode, tree, metric.steps, codes)
    else:
        positions = np.empty((2, 3 * tree.n_joints))
        if tree.n_joints:
            encode_poses(poses, encode_positions, tree, metric.steps, positions)
        given = (
            f"encode(pose, positions, code) was called with a pose of {n_dofs} numbers, positions of {tree.n_joints} "
            f"rows, and a code of the {n_codes} numbers that {name}.n_codes states"
        )
        for pose, placed, code in zip(poses, positions.reshape(2, tree.n_joints, 3), codes, strict=True):
            _run(f"{name}.encode", given, encode, pose, placed, code)
        if n_missing := int(np.isnan(codes).sum(axis=1).max()):
            raise ValueError(
                f"{name}.encode leaves {n_missing} of the {n_codes} numbers of a code unwritten, or NaN: it must write "
                f"as many as {name}.n_codes states"
            )
    if measure is not None:
        given = f"measure(a, b) was called with codes of {n_codes} numbers, and must return a number"
        found = [[_run(f"{name}.measure", given, measure, a.copy(), b.copy()) for b in codes] for a in codes]
        try:
            (same, there), (back, again) = np.array(found, dtype=float).tolist()
        except (TypeError, ValueError):
            raise ValueError(f"{name}.measure returns no number, got {found[0][1]!r}") from None
        if same != 0.0 or again != 0.0 or not there >= 0.0 or not np.isfinite(there):
            raise ValueError(
                f"{name}.measure gives {same or again:g} between equal poses and {there:g} between two others: a "
                "distance is zero between equal poses, finite, and nowhere negative"
            )
        if abs(there - back) > 1e-9 * abs(there):
            raise ValueError(
                f"{name}.measure gives {there:g} from one pose to another and {back:g} back: a distance is symmetric"
            )
    _checked.add(key)


def _run(name: str, given: str, function: Callable, *arguments: np.ndarray) -> Any:
    """Return what a function of a user's returns; its errors say how it was called."""
    try:
        with np.errstate(all="ignore"):
            return function(*arguments)
    except Exception as error:
        raise ValueError(f"{name} failed: {type(error).__name__}: {error}; {given}") from error


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
