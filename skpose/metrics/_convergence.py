"""Geodesics that did not converge: their number, and the warning about them."""

from collections.abc import Iterable
from typing import NamedTuple

from sklearn.exceptions import ConvergenceWarning

from skpose._warnings import warn


class Unconverged(NamedTuple):
    """Number of geodesics that did not converge, and the largest of their discretisation errors.

    The error is the relative gap between the length of a curve, measured on a fine grid, and the sum of its chords.
    """

    count: int  # type: ignore[assignment]  # which is a method of tuples too
    gap: float

    @classmethod
    def join(cls, parts: Iterable[tuple[int, float]]) -> "Unconverged":
        """Return the sum of the counts and the largest of the gaps."""
        counts, gaps = zip((0, 0.0), *parts, strict=True)
        return cls(sum(counts), max(gaps))


def warn_of_unconverged(parts: Iterable[tuple[int, float]], n_pairs: int) -> None:
    """Warn if some of the geodesics of so many pairs did not converge."""
    count, gap = Unconverged.join(parts)
    if count:
        warn(
            f"{count} of {n_pairs} geodesics did not converge; their distances are lengths of curves no "
            "longer than the straight line in angle space, which may not be the shortest. The largest relative gap "
            f"between such a curve's length and the sum of its chords is {gap:.2g}",
            ConvergenceWarning,
        )
