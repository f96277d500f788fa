"""Compilation of the two functions of a user's metric, which are written for one pose and for two codes."""

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
        ``function(pose, positions, code)``, which numba can compile. `pose` has shape (n_dofs,), rad. `positions` has
        shape (n_joints, 3): the joints with positive weight, in the order of the skeleton and in the axes of the root,
        m, times the square roots of their weights; without a skeleton its shape is (0, 3). The function fills `code`,
        of shape (n_codes,), with finite numbers.

    Returns
    -------
    callable
        The class attribute `encode`.

    See Also
    --------
    compile_measure : The function of two codes.
    Metric : The base class, with an example.

    Notes
    -----
    Each process compiles it anew, in a second or two. Metrics whose codes are positions or angles can use
    ``Position.encode`` or ``Angle.encode``, which are faster.

    Examples
    --------
    >>> from skpose.metrics import compile_encode
    >>> @compile_encode
    ... def encode_heights(pose, positions, code):
    ...     for j in range(positions.shape[0]):
    ...         code[j] = positions[j, 1]
    """
    plain = getattr(function, "py_func", function)
    one = njit(plain, nogil=True, boundscheck=True)
    unwritten = f"{plain.__qualname__} must write as many finite numbers as n_codes() states, for every pose"

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

    return encode


def compile_measure(function: Callable[[np.ndarray, np.ndarray], float]) -> Any:
    """Compile the function that computes the distance between two codes, for `Metric.measure`.

    Parameters
    ----------
    function : callable
        ``function(a, b) -> float``, which numba can compile, on codes of shape (n_codes,), float32 or float64. It must
        be symmetric, finite, not negative, and zero for equal codes.

    Returns
    -------
    callable
        The class attribute `measure`.

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
    no_distance = f"{plain.__qualname__} must be finite and not negative for all poses"

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


_checked: set[tuple] = set()  # metrics whose functions have been checked, with the numbers of dofs and joints


def check_functions(metric: Any, tree: Tree, n_dofs: int, n_codes: int) -> None:
    """Refuse a measure of a user's metric that is no distance, before its first use on a number of columns."""
    measure, name = getattr(metric.measure, "plain", None), type(metric).__name__
    key = metric, n_dofs, n_codes, tree.n_joints
    if measure is None or key in _checked:
        return
    poses = np.stack([0.1 + 0.05 * np.arange(n_dofs), 0.7 - 0.03 * np.arange(n_dofs)])  # far from equal
    codes = np.empty((2, n_codes))
    encode_poses(poses, metric.encode, tree, metric.steps, codes)
    (same, there), (back, again) = ([float(measure(a, b)) for b in codes] for a in codes)
    if same != 0.0 or again != 0.0:
        raise ValueError(f"{name}.measure must be zero for equal poses, got {same:g} and {again:g}")
    if not abs(there - back) <= 1e-9 * abs(there):
        raise ValueError(f"{name}.measure must be finite and symmetric, got {there:g} and {back:g}")
    _checked.add(key)
