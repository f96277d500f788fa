"""The metric "angle": differences of the columns, as in other tools."""

from typing import ClassVar

import numpy as np

from skpose._compiled.pose.encode import encode_angles
from skpose._compiled.pose.measure import measure_euclidean
from skpose._compiled.pose.tree import TWO_PI, Steps, Tree
from skpose.metrics._means import ArithmeticMeans, Linearization, Sample
from skpose.metrics._metric import Metric
from skpose.skeleton import Skeleton


class Angle(Metric):
    r"""Distance between the columns of two poses, :math:`\|a - b\|_2`, rad (eq. 1 of [1]_).

    It needs no skeleton, and ignores how far a joint moves the body.

    Parameters
    ----------
    wrap : bool, default=False
        Whether each difference is wrapped to [−π, π], so that a jump by 360° in a file does not count. Means are then
        means of directions, and searches have no lower bound.

    See Also
    --------
    Spatial : How far the joints travel.

    References
    ----------
    .. [1] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, :doi:`10.1007/978-3-642-31567-1_3`.

    Examples
    --------
    >>> from skpose import pose_distances
    >>> from skpose.metrics import Angle
    >>> float(pose_distances([[0.0, 0.0]], [[3.0, 4.0]], metric=Angle())[0, 0])
    5.0
    """

    name = "angle"
    unit = "rad"
    equation = r"\|a - b\|_2"
    source = "eq. 1"
    needs_skeleton = False

    encode = encode_angles
    measure = measure_euclidean
    encode_work = 3

    _parameter_constraints: ClassVar[dict] = {"wrap": ["boolean"]}

    def __init__(self, wrap: bool = False):
        self.wrap = wrap

    @property
    def steps(self) -> Steps:
        """One step; whether differences are wrapped."""
        return Steps.of(1, bool(self.wrap))

    def n_codes(self, tree: Tree, n_dofs: int) -> int:
        """The number of columns."""
        return n_dofs

    def lower_bound(self) -> Metric | None:
        """This metric itself; None if differences are wrapped: the distance is then not Euclidean."""
        return None if self.wrap else self

    def sample(self, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton | None, n_jobs: int) -> Sample:
        """Poses as points in the space of the columns, a torus if they are wrapped."""
        return _AngleSample(X, weights, bool(self.wrap))

    def direct_means(self, X: np.ndarray, skeleton: Skeleton | None) -> ArithmeticMeans | None:
        """Arithmetic means; None if differences are wrapped."""
        return None if self.wrap else ArithmeticMeans(X)


class _AngleSample(Sample):
    def __init__(self, X: np.ndarray, weights: np.ndarray, wrap: bool):
        super().__init__(X, weights)
        self.wrap = wrap

    def starts(self) -> tuple[list[np.ndarray], np.ndarray]:
        """The weighted mean of the columns, if wrapped the mean direction."""
        if self.wrap:
            mean = np.arctan2(self.weights @ np.sin(self.dofs), self.weights @ np.cos(self.dofs))
        else:
            mean = self.weights @ self.dofs
        return [mean], mean

    def linearize(self, pose: np.ndarray, slope: float) -> Linearization:
        """Distances and gradients, both exact."""
        gaps = pose - self.dofs
        if self.wrap:
            gaps -= TWO_PI * np.rint(gaps / TWO_PI)
        energies = (gaps**2).sum(axis=1)
        return Linearization(np.sqrt(energies), energies, gaps, np.eye(len(pose)))
