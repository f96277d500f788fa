"""Entry points from Python to functions that only compiled functions call."""

from numba import njit


def from_python(function):
    """A function for Python that calls this one, which has no entry point of its own."""
    return njit(lambda *args: function(*args))
