"""The metric "rotation": how far the bones turn in the world."""

import numpy as np

from skpose._compiled.pose.encode import encode_rotations
from skpose._compiled.pose.measure import measure_rotations
from skpose._compiled.pose.tree import Tree
from skpose.kinematics._tree import STEP, columns_around
from skpose.metrics._means import JointSample, Linearization, Sample
from skpose.metrics._metric import Metric, require_skeleton
from skpose.skeleton import Skeleton


class Rotation(Metric):
    r"""Distance between the world orientations of all bones, :math:`\sqrt{\sum_b \ell_b^2 \varphi_b^2}`, m.

    φ is the angle between the orientations of bone b in the two poses, at most π, and ℓ the length of the bone, so that
    each term is the arc of the bone's end about its start (sec. 1.1 of [1]_). Whole turns and slides do not change it;
    in a mean, slides have their arithmetic mean.

    See Also
    --------
    Position : How far apart the joints are.

    References
    ----------
    .. [1] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, :doi:`10.1007/978-3-642-31567-1_3`.

    Examples
    --------
    >>> from skpose import Skeleton, pose_distances
    >>> from skpose.metrics import Rotation
    >>> float(pose_distances([[0.0]], [[1.5]], skeleton=Skeleton.chain(1), metric=Rotation())[0, 0].round(6))
    1.5
    """

    name = "rotation"
    equation = r"\sqrt{\sum_b \ell_b^2 \varphi_b^2}"
    source = "sec. 1.1"

    encode = encode_rotations
    measure = measure_rotations
    encode_work = 40
    measure_work = 8

    def n_codes(self, tree: Tree, n_dofs: int) -> int:
        """Four per bone."""
        return 4 * (len(tree.frame_parent) - 1)

    def sample(self, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton | None, n_jobs: int) -> Sample:
        """Poses with the orientations of their bones."""
        return _RotationSample(X, weights, require_skeleton(skeleton))


class _RotationSample(JointSample):
    gap = -1.0  # always from several poses: positions do not show how limbs turn about themselves

    def __init__(self, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton):
        super().__init__(X, weights, skeleton)
        self.orientations = self._orientations(X)

    def columns(self, pose: np.ndarray, others: np.ndarray) -> np.ndarray:
        """A pose in the columns of the skeleton, with the arithmetic mean of slides, on which no distance depends."""
        slides = self.tree.slide_dof
        pose[slides] = self.weights @ self.dofs[:, slides]
        return super().columns(pose, others)

    def linearize(self, pose: np.ndarray, slope: float) -> Linearization:
        """Distances, and gradients by the angular velocities of the bones, exact to some 1e-10."""
        n = len(pose)
        columns = columns_around(self.tree, pose, np.zeros(n), STEP * np.eye(n), self.X[0], frees_angles=True)
        at, plus, minus = np.split(self._orientations(columns), [1, 1 + n])
        turns = _turns_between(at, self.orientations)
        speeds = _turns_between(minus, plus) / (2.0 * STEP)
        scale = self.tree.weight[1:, None]
        energies = (scale * turns**2).sum(axis=(1, 2))
        gradients = -np.tensordot(turns, scale * speeds, axes=([1, 2], [1, 2]))
        tensor = np.tensordot(speeds, scale * speeds, axes=([1, 2], [1, 2]))
        return Linearization(np.sqrt(energies), energies, gradients, tensor)

    def _orientations(self, X: np.ndarray) -> np.ndarray:
        """The world orientations of the bones, (n_poses, n_frames, 4), unit quaternions, scalar first."""
        return Rotation().encode_poses(X, self.skeleton).reshape(len(X), -1, 4)


def _turns_between(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """The rotation vectors (..., 3) from quaternions to others, at most π long, in the axes of the first."""
    real = (first * second).sum(axis=-1, keepdims=True)
    vector = first[..., :1] * second[..., 1:] - second[..., :1] * first[..., 1:]
    vector -= np.cross(first[..., 1:], second[..., 1:])
    size = np.linalg.norm(vector, axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(size, np.abs(real))
    # q and −q are one rotation; of a tiny turn the vector is half of it.
    return np.copysign(1.0, real) * vector * np.divide(angle, size, out=np.full_like(size, 2.0), where=size > 0.0)
