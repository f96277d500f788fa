"""Principal components of poses, in the tangent space at their mean."""

from numbers import Integral
from typing import ClassVar

import numpy as np
from sklearn.base import BaseEstimator, ClassNamePrefixFeaturesOutMixin, TransformerMixin
from sklearn.utils.extmath import svd_flip
from sklearn.utils.validation import check_array, check_is_fitted

from skpose._base import PoseEstimatorMixin
from skpose._compat.sklearn import Interval, RealNotInt, fit_context
from skpose.kinematics._shared import weighted_positions
from skpose.metrics._shared import METRIC_CONSTRAINTS, require
from skpose.statistics._spaces import SPACES, Space, why_no_vectors

VARIES = 1e-7  # singular value, relative to the largest, above which poses vary
ROUNDING = 1e-12  # root mean square of all scores, m or rad, below which there is only rounding


class PoseTangentPCA(PoseEstimatorMixin, ClassNamePrefixFeaturesOutMixin, TransformerMixin, BaseEstimator):
    r"""Principal component analysis of poses, whose every point is a pose: bones keep their lengths.

    PCA of joint positions breaks bones, and PCA of joint angles does not know which angles move much. This is PCA of
    vectors in the tangent space at a mean pose, in which lengths are distances of the joints: principal geodesic
    analysis in its linear form [1]_, under the metric of the positions, eq. 15 of [2]_. Scores are in m.

    Parameters
    ----------
    skeleton : Skeleton, default=None
        The skeleton of all poses. Needed by all metrics but "angle".
    n_components : int or float, default=None
        Number of components, at most the number of poses and that of their columns; a float between 0 and 1 is the
        share of the variance that they have to explain. None keeps all in which the poses vary. Where an int asks for
        more than these, the others explain no variance, and no direction is made up for them: their variances, their
        rows of `components_` and all their scores are zero.
    metric : str or Metric, default="auto"
        "angle", "position", "geodesic" or such an object: the vectors that stand for poses. "position" linearises the
        positions along the straight line from the joint-wise mean; "geodesic" takes the logarithms at the intrinsic
        mean, a geodesic a pose; "angle" takes the columns as they are, so that it is scikit-learn's PCA. "auto" is
        "position" with a skeleton, else "angle" and a warning.
    n_jobs : int, default=None
        Threads for "geodesic". Results do not depend on it.

    Attributes
    ----------
    mean_ : ndarray of shape (n_dofs,)
        The mean, a pose, rad. All its scores are zero.
    components_ : ndarray of shape (n_components, 3 * n_joints)
        Motions of the joints: the velocity of each as the score grows, m per m of score.
        ``components_.reshape(-1, skeleton.n_joints, 3)`` has one row for each joint. Times the square roots of the
        weights they are orthonormal, but for rows of zeros. The largest entry of each, so scaled, is positive. Joints
        without weight move with the others under "position", and have zeros under "geodesic". Under "angle" of shape
        (n_components, n_dofs), as in scikit-learn.
    explained_variance_ : ndarray of shape (n_components,)
        Variance of the scores about the mean pose, m².
    explained_variance_ratio_ : ndarray of shape (n_components,)
        Their shares of the sum over all components.
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
    SpatialMDS : Coordinates from distances, without a path back to poses.
    frechet_mean, log_map, exp_map : The mean, and poses as vectors, of "geodesic".
    skpose.plot.TangentPCADisplay : Poses along a component.

    Notes
    -----
    *Position.* The mean is the pose from which the mean step to the poses is zero. A step δ has, for a joint with three
    dofs, the rotation vector from the mean about the joint's own axes, so that the order of Euler angles has no effect;
    other angles have their difference, wrapped to [−π, π]. With J the Jacobian at the mean, of positions times the
    square roots of their weights, the vectors are J δ and their inner products :math:`\delta^T J^T J \delta`.
    `inverse_transform` goes along the straight line, ball joints by slerp. A component is also a combination of the
    steps of the training poses. So twists that no joint shows at the mean, as of a straight arm, come back as they vary
    with the scores. ``transform(inverse_transform(scores))`` gives the scores, up to half a turn of each joint.

    The base is this joint-wise mean, not ``frechet_mean(metric="position")``. As its mean step is zero, the scores of
    the training poses have mean zero; and twists, which positions do not show, have a mean too.

    *Geodesic.* Lengths of vectors are distances. `inverse_transform` follows geodesics, `exp_map`.

    "position" takes O(n_samples · n_joints²) time. Fitted attributes are float64, also for float32 poses.

    References
    ----------
    .. [1] P. T. Fletcher, C. Lu, S. M. Pizer, S. Joshi, "Principal geodesic analysis for the study of nonlinear
       statistics of shape", IEEE Transactions on Medical Imaging 23(8), 2004, :doi:`10.1109/TMI.2004.831793`.
    .. [2] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, appendix B, :doi:`10.1007/978-3-642-31567-1_3`.

    Examples
    --------
    An arm that swings, with a little noise at the hand: one component.

    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.statistics import PoseTangentPCA
    >>> arm = Skeleton.chain(2)
    >>> X = np.linspace([-0.5, 0.0], [0.5, 0.2], 20) + np.random.default_rng(0).normal(scale=0.01, size=(20, 2))
    >>> pca = PoseTangentPCA(arm, n_components=1).fit(X)
    >>> pca.explained_variance_ratio_.round(2)
    array([1.])
    >>> pca.components_.reshape(-1, 2, 3).round(1) + 0.0  # both joints go up, and the hand farther
    array([[[0. , 0.4, 0. ],
            [0. , 0.9, 0. ]]])
    >>> pca.inverse_transform([[-0.5], [0.5]]).shape  # two poses
    (2, 2)
    >>> bool(pca.reconstruction_error(X).max() < 0.03)
    True
    """

    _auto_metric = "position"
    _is_experimental = True
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
        # Where the poses do not vary there is only rounding, in which any direction is as good as another.
        self._directions, self._steps, self.components_, self.explained_variance_, self.singular_values_ = (
            _with_zeros(known, n)
            for known in (directions, steps, space.motions(steps), variances[:n_varying], sizes[:n_varying])
        )
        self.explained_variance_ratio_ = self.explained_variance_ / variances.sum()
        self.n_components_ = n
        return self._scores(vectors, given.dtype)

    def transform(self, X):
        """Return the scores of poses.

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
        """Return the poses of scores.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_components)
            Scores, m; rad under "angle".

        Returns
        -------
        ndarray of shape (n_samples, n_dofs)
            Poses: joint angles, rad, as numbers near those of `mean_`. float32 for float32 scores, else float64.
        """
        check_is_fitted(self, "n_components_")
        self._check_how_to_answer()
        scores = check_array(X, dtype=[np.float64, np.float32], estimator=self, input_name="X")
        if scores.shape[1] != self.n_components_:
            raise ValueError(f"X must have {self.n_components_} columns, one for each component, got {scores.shape[1]}")
        return self._space().move(scores.astype(np.float64) @ self._steps).astype(scores.dtype, copy=False)

    def reconstruction_error(self, X):
        """Return how far each pose is from the pose of its scores: poses that were not in `fit` state how well it does.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs)
            Poses: joint angles, rad.

        Returns
        -------
        ndarray of shape (n_samples,)
            Root mean squared distance of the joints, m: √(Σ w_j ‖p_j − q_j‖² / Σ w_j), with p and q the positions of
            joint j in the pose and in ``inverse_transform(transform(X))``, and w its weight. Without a skeleton the
            root mean squared difference of the columns, rad. float64, also for float32 poses.
        """
        check_is_fitted(self, "n_components_")
        X = self._check_X(X, reset=False).astype(np.float64)
        found = self.inverse_transform(self._scores(self._space().vectors(X), X.dtype))
        if self.skeleton_ is None:
            return np.sqrt(np.square(X - found).mean(axis=1))
        squared = np.square(weighted_positions(X, self.skeleton_) - weighted_positions(found, self.skeleton_))
        return np.sqrt(squared.sum(axis=1) / self.skeleton_.weights.sum())

    def _learn_metric(self, skeleton):
        """Store the metric that the parameter states on a skeleton: one that has vectors."""
        super()._learn_metric(skeleton)
        require(self.metric_, "PoseTangentPCA", "vectors that stand for poses", why_no_vectors)

    def _space(self) -> Space:
        """Return the space of vectors at the mean."""
        return SPACES[type(self.metric_)].at(self.mean_, self.skeleton_, self.metric_, self.n_jobs)

    def _choose_n_components(self, sizes, variances, shape):
        """Return the number of components that the parameter asks for, from all singular values and variances."""
        n_varying = _count_varying(sizes, shape[0])
        if sizes[0] <= ROUNDING * np.sqrt(shape[0]):
            raise ValueError(
                f"poses of X must differ under the metric {self.metric_.label!r}, got {shape[0]} equal poses"
            )
        if self.n_components is None:
            return n_varying
        if isinstance(self.n_components, Integral):
            if int(self.n_components) > min(shape):
                raise ValueError(
                    f"n_components must be at most {min(shape)} for poses of shape {shape}, got {self.n_components}"
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
    """Return the number of components in which poses vary, from their singular values.

    The vectors from a mean sum to zero, so that n poses vary in n − 1. Under "geodesic" the sum is zero up to the
    tolerance of the mean, which is more than rounding and no variance either.
    """
    return min(int((sizes > VARIES * sizes[0]).sum()), n_samples - 1)


def _with_zeros(rows, n):
    """Return rows with as many zero rows after them as make n."""
    return np.concatenate([rows, np.zeros((n - len(rows), *rows.shape[1:]))])
