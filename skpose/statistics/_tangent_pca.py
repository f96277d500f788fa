"""Principal components of poses in the tangent space at their mean."""

from numbers import Integral
from typing import Any, ClassVar

import numpy as np
from joblib import effective_n_jobs
from sklearn.base import BaseEstimator, ClassNamePrefixFeaturesOutMixin, TransformerMixin
from sklearn.exceptions import ConvergenceWarning
from sklearn.utils.extmath import svd_flip
from sklearn.utils.validation import check_array, check_is_fitted

from skpose._base import PoseEstimatorMixin
from skpose._utils.sklearn import Interval, RealNotInt, fit_context
from skpose._utils.warnings import warn
from skpose.geodesics import frechet_mean
from skpose.geodesics._logarithm import TangentSpace, to_joints
from skpose.kinematics._forward import jacobians_of, weighted_positions
from skpose.kinematics._tree import tree_of_all_joints
from skpose.metrics import Angle, Geodesic, Metric, Position
from skpose.metrics._registry import METRIC_CONSTRAINTS, require
from skpose.skeleton import Skeleton
from skpose.skeleton._interpolation import mean_of_joints, move, skeleton_at, steps_from


class Space:
    """A vector space at a base pose."""

    def __init__(self, pose: np.ndarray, skeleton: Skeleton | None, metric: Any, n_jobs: int | None):
        self.pose, self.skeleton, self.metric, self.n_jobs = pose, skeleton, metric, n_jobs

    def steps(self, X: np.ndarray, mixing: np.ndarray, directions: np.ndarray) -> np.ndarray:
        return directions

    def motions(self, steps: np.ndarray) -> np.ndarray:
        return steps


class Columns(Space):
    """Columns as they are, as in scikit-learn's PCA."""

    @staticmethod
    def mean(X: np.ndarray, skeleton: Skeleton | None, metric: Angle, n_jobs: int | None) -> np.ndarray:
        return X.mean(axis=0)

    def vectors(self, X: np.ndarray) -> np.ndarray:
        return X - self.pose

    def move(self, steps: np.ndarray) -> np.ndarray:
        return self.pose + steps


class Lines(Space):
    """Positions to first order along straight lines from the base, F ≈ F₀ + J δ.

    Steps δ include twists that move no joint; components get the average twists of their poses.
    """

    skeleton: Skeleton

    @staticmethod
    def mean(X: np.ndarray, skeleton: Skeleton, metric: Position, n_jobs: int | None) -> np.ndarray:
        mean, converged = mean_of_joints(skeleton.bones, X)
        if not converged:
            warn(
                "the joint-wise mean did not converge, as rotations of a joint spread over half a turn or more",
                ConvergenceWarning,
            )
        return mean

    def jacobian(self) -> np.ndarray:
        """Jacobian (3 n_joints, n_dofs) of the positions with respect to steps."""
        skeleton, pose = skeleton_at(self.skeleton, self.pose)
        return jacobians_of(pose[None], tree_of_all_joints(skeleton))[0]

    def vectors(self, X: np.ndarray) -> np.ndarray:
        roots = np.repeat(np.sqrt(self.skeleton.weights), 3)
        return steps_from(self.skeleton.bones, self.pose, X) @ (roots[:, None] * self.jacobian()).T

    def steps(self, X: np.ndarray, mixing: np.ndarray, directions: np.ndarray) -> np.ndarray:
        return mixing.T @ steps_from(self.skeleton.bones, self.pose, X)

    def motions(self, steps: np.ndarray) -> np.ndarray:
        return steps @ self.jacobian().T

    def move(self, steps: np.ndarray) -> np.ndarray:
        return move(self.skeleton.bones, self.pose, steps)


class Geodesics(Space):
    """Logarithms at the base."""

    skeleton: Skeleton

    @staticmethod
    def mean(X: np.ndarray, skeleton: Skeleton, metric: Geodesic, n_jobs: int | None) -> np.ndarray:
        return frechet_mean(X, skeleton, metric=metric, n_jobs=n_jobs).pose

    @property
    def tangent_space(self) -> TangentSpace:
        return TangentSpace(self.skeleton, self.pose, self.metric.n_steps, effective_n_jobs(self.n_jobs))

    def vectors(self, X: np.ndarray) -> np.ndarray:
        found = self.tangent_space.logarithms(X)
        found.warn(" from the mean")
        return found.velocities

    def motions(self, steps: np.ndarray) -> np.ndarray:
        return to_joints(self.skeleton, steps).reshape(len(steps), -1)

    def move(self, steps: np.ndarray) -> np.ndarray:
        poses, n_missed = self.tangent_space.exponentials(steps)
        if n_missed:
            warn(
                f"{n_missed} of the {len(steps)} poses are too far from the mean for n_steps={self.metric.n_steps}: "
                "fit with a larger n_steps",
                ConvergenceWarning,
            )
        return poses


SPACES: dict[type[Metric], Any] = {Angle: Columns, Position: Lines, Geodesic: Geodesics}


def has_vectors(metric: Metric) -> bool:
    """Whether distances under a metric are lengths of vectors; wrapped angles are points of a torus."""
    if type(metric) is Geodesic:
        return metric.has_means and metric.wrap
    return type(metric) in SPACES and metric.lower_bound() == metric


# --- tangent pca ------------------------------------------------------------------------------------------------------


VARIES = 1e-7  # singular values below this share of the largest count as zero
ROUNDING = 1e-12  # root mean square of all scores, m or rad, that counts as zero


class PoseTangentPCA(PoseEstimatorMixin, ClassNamePrefixFeaturesOutMixin, TransformerMixin, BaseEstimator):
    r"""Principal component analysis of poses in the tangent space at their mean.

    Every point of the component space is a pose, so bones keep their lengths. PCA of joint positions changes the
    lengths of bones, and PCA of joint angles ignores the size of the resulting movement. Here, poses are vectors in the
    tangent space at a mean pose, whose lengths are distances: linearised principal geodesic analysis [1]_ under the
    metric of the positions, eq. 15 of [2]_. Scores are in m.

    Parameters
    ----------
    skeleton : Skeleton, default=None
        The skeleton of all poses. Required by all metrics except "angle".
    n_components : int or float, default=None
        Number of components, at most min(n_samples, n_dofs). A float between 0 and 1 is the share of variance to
        explain. None keeps all components with variance. If an int exceeds these, the remaining variances, rows of
        `components_` and scores are zero.
    metric : str or Metric, default="auto"
        "angle", "position", "geodesic" or a metric object. "position" linearises the positions along the straight line
        from the joint-wise mean. "geodesic" uses logarithms at the intrinsic mean. "angle" uses the columns as they
        are, as scikit-learn's PCA. "auto" is "position" with a skeleton, else "angle" with a warning.
    n_jobs : int, default=None
        Number of threads for "geodesic". It does not change results.

    Attributes
    ----------
    mean_ : ndarray of shape (n_dofs,)
        The mean pose, rad. Its scores are zero.
    components_ : ndarray of shape (n_components, 3 * n_joints)
        Velocities of the joints per unit of score. ``components_.reshape(-1, skeleton.n_joints, 3)`` has one row per
        joint. Scaled by the square roots of the weights, non-zero components are orthonormal, and the largest entry of
        each is positive. Joints without weight have velocities under "position", and zeros under "geodesic". Under
        "angle" the shape is (n_components, n_dofs), as in scikit-learn.
    explained_variance_ : ndarray of shape (n_components,)
        Variance of the scores about the mean pose, m².
    explained_variance_ratio_ : ndarray of shape (n_components,)
        Share of the total variance.
    singular_values_ : ndarray of shape (n_components,)
        Norms of the scores of the training poses, m.
    n_components_ : int
        Number of components.
    metric_ : Metric
        The metric in use, a copy of the parameter.
    skeleton_ : Skeleton or None
        The skeleton in use.
    n_features_in_ : int
        Number of features seen during `fit`.
    feature_names_in_ : ndarray of shape (`n_features_in_`,)
        Names of features seen during `fit`. Defined only when `X` has feature names that are all strings.

    See Also
    --------
    SpatialMDS : Coordinates from distances, without an inverse transform.
    frechet_mean, log_map, exp_map : Mean and tangent vectors for "geodesic".
    skpose.plot.PoseDisplay.from_estimator : Poses along a component.

    Notes
    -----
    *Position.* The mean is the pose from which the mean step to the poses is zero. For a joint with three dofs, a step
    δ is the rotation vector from the mean in the joint's own axes, so Euler orders have no effect; for other angles it
    is the difference, wrapped to [−π, π]. With J the Jacobian at the mean of positions scaled by √w, the vectors are
    Jδ, and their inner products :math:`\delta^T J^T J \delta`. `inverse_transform` follows the straight line, with
    slerp for ball joints. Components are also combinations of the training steps, so twists that move no joint at the
    mean, as of a straight arm, are restored as they vary with the scores. ``transform(inverse_transform(scores))``
    returns the scores, up to half a turn of each joint.

    This joint-wise mean differs from ``frechet_mean(metric="position")``: its mean step is zero, so the training scores
    have mean zero, and it defines a mean for twists, which positions do not show.

    *Geodesic.* Lengths of vectors are distances. `inverse_transform` follows geodesics with `exp_map`.

    "position" takes O(n_samples · n_joints²) time. Fitted attributes are float64, also for float32 poses.

    References
    ----------
    .. [1] P. T. Fletcher, C. Lu, S. M. Pizer, S. Joshi, "Principal geodesic analysis for the study of nonlinear
       statistics of shape", IEEE Transactions on Medical Imaging 23(8), 2004, :doi:`10.1109/TMI.2004.831793`.
    .. [2] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, appendix B, :doi:`10.1007/978-3-642-31567-1_3`.

    Examples
    --------
    A swinging arm with a little noise has one component:

    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.statistics import PoseTangentPCA
    >>> arm = Skeleton.chain(2)
    >>> X = np.linspace([-0.5, 0.0], [0.5, 0.2], 20) + np.random.default_rng(0).normal(scale=0.01, size=(20, 2))
    >>> pca = PoseTangentPCA(arm, n_components=1).fit(X)
    >>> pca.explained_variance_ratio_.round(2)
    array([1.])
    >>> pca.components_.reshape(-1, 2, 3).round(1) + 0.0  # both joints rise, the hand more
    array([[[0. , 0.4, 0. ],
            [0. , 0.9, 0. ]]])
    >>> pca.inverse_transform([[-0.5], [0.5]]).shape  # two poses
    (2, 2)
    >>> bool(pca.reconstruction_error(X).max() < 0.03)
    True
    """

    _auto_metric = "position"
    _parameter_constraints: ClassVar[dict] = {
        **METRIC_CONSTRAINTS,
        "n_components": [
            Interval(Integral, 1, None, closed="left"),
            Interval(RealNotInt, 0, 1, closed="neither"),
            None,
        ],
        "n_jobs": [None, Integral],
    }

    def __init__(self, skeleton=None, *, n_components=None, metric="auto", n_jobs=None):
        self.skeleton = skeleton
        self.n_components = n_components
        self.metric = metric
        self.n_jobs = n_jobs

    def fit(self, X, y=None):
        """Find the mean and the components.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs)
            Poses: joint angles, rad.
        y : Ignored
            Not used, present for API consistency by convention.

        Returns
        -------
        PoseTangentPCA
            The fitted estimator.
        """
        self.fit_transform(X)
        return self

    @fit_context(prefer_skip_nested_validation=True)
    def fit_transform(self, X, y=None):
        """Find the mean and the components, and return the scores of the poses.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs)
            Poses: joint angles, rad.
        y : Ignored
            Not used, present for API consistency by convention.

        Returns
        -------
        ndarray of shape (n_samples, n_components)
            Scores, m; rad under "angle". float32 for float32 poses, else float64.
        """
        given = self._check_X(X, reset=True, ensure_min_samples=2)
        X = given.astype(np.float64)
        self.mean_ = SPACES[type(self.metric_)].mean(X, self.skeleton_, self.metric_, self.n_jobs)
        space = self._space()
        vectors = space.vectors(X)
        U, sizes, directions = np.linalg.svd(vectors, full_matrices=False)
        U, directions = svd_flip(U, directions, u_based_decision=False)
        variances = sizes**2 / (len(X) - 1)
        n = self._choose_n_components(sizes, variances, X.shape)
        n_varying = min(n, _count_varying(sizes, len(X)))
        directions = directions[:n_varying]
        steps = space.steps(X, U[:, :n_varying] / sizes[:n_varying], directions)
        # Directions without variance are arbitrary, so they are set to zero.
        self._directions, self._steps, self.components_, self.explained_variance_, self.singular_values_ = (
            np.concatenate([known, np.zeros((n - len(known), *known.shape[1:]))])
            for known in (directions, steps, space.motions(steps), variances[:n_varying], sizes[:n_varying])
        )
        self.explained_variance_ratio_ = self.explained_variance_ / variances.sum()
        self.n_components_ = n
        return self._scores(vectors, given.dtype)

    def transform(self, X):
        """Compute the scores of poses.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs)
            Poses: joint angles, rad.

        Returns
        -------
        ndarray of shape (n_samples, n_components)
            Scores, m; rad under "angle". float32 for float32 poses, else float64.
        """
        check_is_fitted(self, "n_components_")
        X = self._check_X(X, reset=False)
        return self._scores(self._space().vectors(X.astype(np.float64)), X.dtype)

    def inverse_transform(self, X):
        """Compute the poses of scores.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_components)
            Scores, m; rad under "angle".

        Returns
        -------
        ndarray of shape (n_samples, n_dofs)
            Poses: joint angles, rad, in the representation closest to `mean_`. float32 for float32 scores, else
            float64.
        """
        check_is_fitted(self, "n_components_")
        scores = check_array(X, dtype=[np.float64, np.float32], estimator=self, input_name="X")
        return self._space().move(scores.astype(np.float64) @ self._steps).astype(scores.dtype, copy=False)

    def reconstruction_error(self, X):
        """Compute the distance of each pose from its reconstruction; use poses that were not in `fit`.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs)
            Poses: joint angles, rad.

        Returns
        -------
        ndarray of shape (n_samples,)
            Root mean squared distance of the joints, m: √(Σ w_j ‖p_j − q_j‖² / Σ w_j), with w_j the weight of joint j,
            and p_j and q_j its positions in the pose and in ``inverse_transform(transform(X))``. Without a skeleton,
            the root mean squared difference of the columns, rad. Always float64.
        """
        check_is_fitted(self, "n_components_")
        X = self._check_X(X, reset=False).astype(np.float64)
        found = self.inverse_transform(self._scores(self._space().vectors(X), X.dtype))
        if self.skeleton_ is None:
            return np.sqrt(np.square(X - found).mean(axis=1))
        squared = np.square(weighted_positions(X, self.skeleton_) - weighted_positions(found, self.skeleton_))
        return np.sqrt(squared.sum(axis=1) / self.skeleton_.weights.sum())

    def _learn_metric(self, skeleton):
        super()._learn_metric(skeleton)
        require(self.metric_, "PoseTangentPCA", "tangent vectors", has_vectors(self.metric_))

    def _space(self):
        return SPACES[type(self.metric_)](self.mean_, self.skeleton_, self.metric_, self.n_jobs)

    def _choose_n_components(self, sizes, variances, shape):
        n_varying = _count_varying(sizes, shape[0])
        if sizes[0] <= ROUNDING * np.sqrt(shape[0]):
            raise ValueError(f"poses must differ under the metric {self.metric_.label!r}, got {shape[0]} equal poses")
        if self.n_components is None:
            return n_varying
        if isinstance(self.n_components, Integral):
            if int(self.n_components) > min(shape):
                raise ValueError(
                    f"n_components={self.n_components} must be at most min(n_samples, n_dofs)={min(shape)}"
                )
            return int(self.n_components)
        reached = np.searchsorted(np.cumsum(variances) / variances.sum(), self.n_components, side="right") + 1
        return min(int(reached), n_varying)

    def _scores(self, vectors, dtype):
        return (vectors @ self._directions.T).astype(dtype, copy=False)

    @property
    def _n_features_out(self):
        return self.n_components_

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.transformer_tags.preserves_dtype = ["float64", "float32"]
        return tags


def _count_varying(sizes, n_samples):
    """Number of components with variance, from the singular values.

    Vectors from a mean sum to zero, so n poses have at most n − 1. Under "geodesic" the sum is zero only up to the
    tolerance of the mean, which is more than rounding.
    """
    return min(int((sizes > VARIES * sizes[0]).sum()), n_samples - 1)
