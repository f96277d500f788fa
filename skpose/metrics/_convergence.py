"""Geodesics that did not converge, and the warning about them."""

from collections.abc import Iterable
from typing import NamedTuple

from sklearn.exceptions import ConvergenceWarning

from skpose._utils.warnings import warn


class Unconverged(NamedTuple):
    """Number of geodesics that did not converge, and the largest relative gap of these curves.

    The gap is between the length of a curve, measured on a fine grid, and the sum of its chords.
    """

    count: int  # type: ignore[assignment]  # which is a method of tuples too
    gap: float

    @classmethod
    def join(cls, parts: Iterable[tuple[int, float]]) -> "Unconverged":
        """Sum of the counts and maximum of the gaps."""
        counts, gaps = zip((0, 0.0), *parts, strict=True)
        return cls(sum(counts), max(gaps))


def warn_of_unconverged(parts: Iterable[tuple[int, float]], n_pairs: int) -> None:
    """Warn if some geodesics did not converge."""
    count, gap = Unconverged.join(parts)
    if count:
        warn(
            f"{count} of {n_pairs} geodesics did not converge: the curves found may not be the shortest. The largest "
            f"relative gap between the length of one and the sum of its chords is {gap:.2g}",
            ConvergenceWarning,
        )
