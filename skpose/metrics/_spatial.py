"""The metric "spatial": how far the joints travel along the straight line from pose to pose."""

from numbers import Integral
from typing import ClassVar

import numpy as np

from skpose._compiled.pose.encode import count_line_codes, encode_curve_end
from skpose._compiled.pose.measure import measure_line
from skpose._compiled.pose.tree import Steps, Tree
from skpose._utils.sklearn import Interval
from skpose.kinematics._tree import STEP, columns_around, jacobian_at
from skpose.metrics._matrix import DistanceMatrix
from skpose.metrics._means import JointSample, Linearization, Sample
from skpose.metrics._metric import Metric, require_skeleton
from skpose.metrics._position import Position
from skpose.skeleton import Skeleton

TWIST = 1e-2  # of the mean of the metric tensor's diagonal, for dofs that move no joint
SOME = 100  # poses whose metric tensors are averaged, and at which a search may start


class CurveMetric(Metric):
    """The length of a curve that is searched or taken from the straight line in the angles, in so many chords."""

    encode = encode_curve_end
    encode_work = 20

    _parameter_constraints: ClassVar[dict] = {
        "n_steps": [Interval(Integral, 1, None, closed="left")],
        "wrap": ["boolean"],
    }

    def __init__(self, n_steps: int = 10, wrap: bool = True):
        self.n_steps = n_steps
        self.wrap = wrap

    @property
    def steps(self) -> Steps:
        """The steps of the line."""
        return Steps.of(self.n_steps, bool(self.wrap))

    def n_codes(self, tree: Tree, n_dofs: int) -> int:
        """Five per angle, four per ball joint and three per joint."""
        return count_line_codes(tree) + 3 * tree.n_joints

    def lower_bound(self) -> Metric:
        """The chord."""
        return Position()


class Spatial(CurveMetric):
    r"""Length of the curve of the joints along the straight line in the angles, m (sec. 2.2 of [1]_).

    :math:`\sum_{n=1}^N \|F(c_n) - F(c_{n-1})\|`, with c the straight line from a to b in N steps. The straight line of
    a ball joint is the slerp.

    Parameters
    ----------
    n_steps : int, default=10
        Chords along the curve; the paper's ten. With one it is `Position`.
    wrap : bool, default=True
        Whether each difference of angles is wrapped to [−π, π], so that a jump by 360° in a file does not count. It has
        no effect on ball joints.

    See Also
    --------
    Position : The chord of the curve, a lower bound.
    Geodesic : The shortest curve.

    Notes
    -----
    It need not obey the triangle inequality. Means and medians need two steps or more; they are found by BFGS, since
    the line jumps where a difference of angles is half a turn.

    References
    ----------
    .. [1] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, :doi:`10.1007/978-3-642-31567-1_3`.

    Examples
    --------
    >>> from skpose import Skeleton, pose_distances
    >>> from skpose.metrics import Spatial
    >>> X, arm = [[0.0], [3.14159]], Skeleton.chain(1)
    >>> [float(pose_distances(X, skeleton=arm, metric=Spatial(n_steps=n))[0, 1].round(3)) for n in (1, 10, 1000)]
    [2.0, 3.129, 3.142]
    """

    name = "spatial"
    equation = r"\sum_n \|F(c_n) - F(c_{n-1})\|"
    source = "sec. 2.2"
    has_gradients = False

    measure = measure_line
    measure_work = 16

    def sample(self, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton | None, n_jobs: int) -> Sample:
        """Poses whose distances have gradients by differences."""
        return _SpatialSample(self, X, weights, require_skeleton(skeleton), n_jobs)


class _SpatialSample(JointSample):
    """Joints with three angles are moved by their angles, in which the line is straight."""

    frees_angles = False

    def __init__(self, metric: Spatial, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton, n_jobs: int):
        super().__init__(X, weights, skeleton)
        self.metric, self.n_jobs = metric, n_jobs
        self.mean_tensor, rows = np.zeros((self.dofs.shape[1], self.dofs.shape[1])), _sample_rows(X)
        for row in rows:
            jacobian = jacobian_at(self.tree, self.dofs[row], False)
            self.mean_tensor += jacobian.T @ jacobian / len(rows)

    def linearize(self, pose: np.ndarray, slope: float) -> Linearization:
        """Distances, with gradients by central differences."""
        n = len(pose)
        energies = self._distances_around(pose, np.zeros(n), STEP * np.eye(n)) ** 2
        gradients = (energies[1 : n + 1] - energies[n + 1 :]).T / (4.0 * STEP)
        jacobian = jacobian_at(self.tree, pose, False)
        tensor = 0.5 * (jacobian.T @ jacobian + self.mean_tensor)
        # The mean of the tensors at the pose and at the sample; a twist that moves no joint moves lines to other poses.
        tensor += TWIST * np.trace(tensor) / n * np.eye(n)
        return Linearization(np.sqrt(energies[0]), energies[0], gradients, tensor)

    def sum_along(self, x: np.ndarray, pose: np.ndarray, steps: np.ndarray, power: int) -> tuple[float, np.ndarray]:
        """The sum of powers of distances, and its gradient, at a pose plus steps (n_dofs, n) times x (n,)."""
        n = len(x)
        sums = self._distances_around(pose, steps @ x, STEP * steps.T) ** power @ self.weights
        return float(sums[0]) / power, (sums[1 : n + 1] - sums[n + 1 :]) / (2.0 * power * STEP)

    def best_pose(self, power: int) -> tuple[np.ndarray, float]:
        """The pose with the least sum of distances to all, among some of the sample, and that sum."""
        rows = _sample_rows(self.X)
        sums = self._distances(self.X[rows]) ** power @ self.weights
        return self.dofs[rows[sums.argmin()]], float(sums.min())

    def _distances_around(self, pose: np.ndarray, step: np.ndarray, shifts: np.ndarray) -> np.ndarray:
        """The distances from the pose that is a step away, and from this pose plus and minus each shift."""
        return self._distances(columns_around(self.tree, pose, step, shifts, self.X[0], False))

    def _distances(self, columns: np.ndarray) -> np.ndarray:
        return DistanceMatrix(columns, self.X, self.metric, self.skeleton).write(None, self.n_jobs)[0]


def _sample_rows(X: np.ndarray) -> np.ndarray:
    """Rows of some of the poses; the choice does not depend on the order of the rows."""
    shares = np.linspace(0, len(X) - 1, min(len(X), SOME))
    return np.lexsort(X.T)[np.unique(shares.astype(int))]
