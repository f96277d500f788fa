"""The results of searches: how many distances were evaluated."""

from typing import NamedTuple


class MotionEvaluations(NamedTuple):
    """Numbers of evaluations of a search for motions, which ``return_evaluations=True`` requests.

    Brute force aligns every pair of motions, and measures the distance of every pair of their frames.

    Attributes
    ----------
    alignments : int
        Pairs of motions that were aligned under the metric. Alignments of lower bounds are not counted.
    cells : int
        Pairs of frames whose distance was measured for that.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import MotionKNeighborsTransformer, Skeleton
    >>> X = [np.linspace([0.0, 0.0], [reach, 0.0], 12) for reach in (1.0, 1.1, 2.0, 2.1)]
    >>> neighbors = MotionKNeighborsTransformer(Skeleton.chain(2), n_neighbors=1).fit(X)
    >>> neighbors.kneighbors([X[0]], return_evaluations=True)[2]  # so few take less time by brute force
    MotionEvaluations(alignments=4, cells=576)
    """

    alignments: int
    cells: int

    def __add__(self, other: tuple) -> "MotionEvaluations":
        return MotionEvaluations(self.alignments + other[0], self.cells + other[1])
