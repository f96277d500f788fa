"""The metric "position": how far apart the joints are, the chord of all curves from pose to pose."""

import numpy as np

from skpose._compiled.pose.encode import encode_positions
from skpose._compiled.pose.measure import measure_euclidean
from skpose._compiled.pose.tree import Tree
from skpose.kinematics._forward import weighted_positions
from skpose.kinematics._tree import jacobian_at
from skpose.metrics._means import ExtrinsicMeans, JointSample, Linearization, Sample
from skpose.metrics._metric import Metric, require_skeleton
from skpose.skeleton import Skeleton


class Position(Metric):
    r"""Distance between the positions of all joints, :math:`\|F(a) - F(b)\|_2`, m (sec. 2 of [1]_).

    F stacks the joint positions. It is the chord of every curve from a to b, and so the lower bound of `Spatial` and
    `Geodesic`. Its mean is the *extrinsic* one, the pose nearest to the mean of the positions.

    See Also
    --------
    Spatial : The length of the curve.

    References
    ----------
    .. [1] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, :doi:`10.1007/978-3-642-31567-1_3`.

    Examples
    --------
    >>> from skpose import Skeleton, pose_distances
    >>> from skpose.metrics import Position
    >>> float(pose_distances([[0.0]], [[3.14159]], skeleton=Skeleton.chain(1), metric=Position())[0, 0].round(3))
    2.0
    """

    name = "position"
    equation = r"\|F(a) - F(b)\|_2"
    source = "sec. 2"

    encode = encode_positions
    measure = measure_euclidean

    def n_codes(self, tree: Tree, n_dofs: int) -> int:
        """Three per joint."""
        return 3 * tree.n_joints

    def lower_bound(self) -> Metric:
        """This metric itself."""
        return self

    def sample(self, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton | None, n_jobs: int) -> Sample:
        """Poses with the positions of their joints."""
        return _PositionSample(X, weights, require_skeleton(skeleton))

    def direct_means(self, X: np.ndarray, skeleton: Skeleton | None) -> ExtrinsicMeans:
        """Extrinsic means."""
        return ExtrinsicMeans(X, require_skeleton(skeleton))


class _PositionSample(JointSample):
    def __init__(self, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton):
        super().__init__(X, weights, skeleton)
        self.positions = weighted_positions(X, skeleton)  # (n_poses, 3 n_joints) of the joints, scaled, m

    def linearize(self, pose: np.ndarray, slope: float) -> Linearization:
        """Distances and gradients, both exact."""
        at = weighted_positions(self.columns(pose, self.X[0])[None], self.skeleton)
        gaps, jacobian = at - self.positions, jacobian_at(self.tree, pose, True)
        energies = (gaps**2).sum(axis=1)
        return Linearization(np.sqrt(energies), energies, gaps @ jacobian, jacobian.T @ jacobian)
