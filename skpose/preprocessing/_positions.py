"""Poses from the positions of joints, as a step of a scikit-learn pipeline."""

from numbers import Integral, Real
from typing import ClassVar

import numpy as np
from sklearn.base import BaseEstimator, TransformerMixin
from sklearn.utils.validation import check_is_fitted, validate_data

from skpose._base import EstimatorMixin
from skpose._utils.sklearn import Interval, StrOptions, check_feature_names_in, fit_context
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import (
    check_names,
    check_poses,
    limits_of,
)
from skpose.keypoints import Keypoints
from skpose.kinematics import forward_kinematics, inverse_kinematics
from skpose.skeleton import Motion, Skeleton


class PoseFromPositions(EstimatorMixin, TransformerMixin, BaseEstimator):
    """Transform positions of joints to poses, row by row, by inverse kinematics.

    With it a pipeline begins with keypoints::

        make_pipeline(
            PoseFromPositions(skeleton),
            PoseKNeighborsTransformer(skeleton),
            KNeighborsClassifier(metric="precomputed"),
        )

    Parameters
    ----------
    skeleton : Skeleton, default=None
        The skeleton of all poses, such as the result of `fit_skeleton`. Required: None fails in `fit`.
    joint_limits : {"ignore", "enforce"}, default="ignore"
        "enforce" keeps angles inside ``skeleton.limits``, which are rounded inwards for float32.
    regularization : float, default=0.0
        Stiffness of the joints towards the rest pose, m/rad, see `inverse_kinematics`: some 0.01 to 0.03 for noisy
        positions.
    n_jobs : int, default=None
        Threads, or workers of a ``joblib.parallel_config`` context. Poses do not depend on it.
    verbose : int, default=0
        Whether to show progress.

    Attributes
    ----------
    skeleton_ : Skeleton
        The skeleton in use.
    n_features_in_ : int
        Number of features seen during `fit`, three for each joint.
    feature_names_in_ : ndarray of shape (`n_features_in_`,)
        Names of features seen during `fit`. Defined only when `X` has feature names that are all strings.

    See Also
    --------
    inverse_kinematics : The same for sequences, ten times as fast, with confidences as weights.
    fit_skeleton : The skeleton of keypoints.

    Notes
    -----
    `fit` learns nothing from X, and checks it. A pose depends only on its own row, so cross-validation and the order of
    frames do not change it. For consecutive frames `inverse_kinematics` is faster, and keeps angles if a joint is lost
    for some frames.

    The position and the orientation of the root are not part of a pose: `inverse_transform` gives positions relative to
    the root, in its axes. To make the orientation of the root part of the poses, use `inverse_kinematics`,
    ``FittedPoses.to_motion`` and ``Motion.with_root``.

    Some 1 ms a row of 30 joints and 56 dofs, on one thread.

    References
    ----------
    S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding", AMDO
    2012, eq. 2, :doi:`10.1007/978-3-642-31567-1_3`.

    Examples
    --------
    An elbow that is bent by a right angle, seen from anywhere:

    >>> import numpy as np
    >>> from skpose import Bone, Skeleton
    >>> from skpose.preprocessing import PoseFromPositions
    >>> arm = Skeleton(
    ...     [
    ...         Bone("shoulder", None, (0, 0, 0)),
    ...         Bone("elbow", "shoulder", (0.3, 0, 0)),
    ...         Bone("wrist", "elbow", (0.25, 0, 0), "z"),
    ...     ]
    ... )
    >>> X = [[2.0, 0.0, 0.0, 2.0, 0.3, 0.0, 2.0, 0.3, 0.25]]
    >>> transformer = PoseFromPositions(arm).fit(X)
    >>> np.degrees(np.abs(transformer.transform(X))).round(6)
    array([[90.]])
    >>> transformer.get_feature_names_out()
    array(['wrist_rz'], dtype=object)
    """

    skeleton_: Skeleton

    _parameter_constraints: ClassVar[dict] = {
        "skeleton": [Skeleton, None],
        "joint_limits": [StrOptions(["ignore", "enforce"])],
        "regularization": [Interval(Real, 0, None, closed="left")],
        "n_jobs": [None, Integral],
        "verbose": ["verbose"],
    }

    def __init__(self, skeleton=None, *, joint_limits="ignore", regularization=0.0, n_jobs=None, verbose=0):
        self.skeleton = skeleton
        self.joint_limits = joint_limits
        self.regularization = regularization
        self.n_jobs = n_jobs
        self.verbose = verbose

    @fit_context(prefer_skip_nested_validation=True)
    def fit(self, X, y=None):
        """Check the positions.

        Parameters
        ----------
        X : array-like of shape (n_samples, 3 * n_joints)
            Positions of the joints in the world, m: x, y and z of each, in the order of ``skeleton.joint_names``; NaN
            where a joint is not seen. The columns of a data frame that are named "NAME_x", "NAME_y", "NAME_z" must be
            in this order.
        y : Ignored
            Not used, present for API consistency by convention.

        Returns
        -------
        PoseFromPositions
            The fitted transformer.
        """
        self._check_X(X, reset=True)
        return self

    def transform(self, X):
        """Poses whose joints are nearest to the positions.

        Parameters
        ----------
        X : array-like of shape (n_samples, 3 * n_joints)
            Positions of the joints in the world, m; NaN where a joint is not seen.

        Returns
        -------
        ndarray of shape (n_samples, n_dofs)
            Joint angles, rad; float32 for float32 positions, else float64.

        Warns
        -----
        ConvergenceWarning, UserWarning
            As `inverse_kinematics`: for rows that do not converge; for rows without a joint, which get the rest pose;
            for positions that are likely in another unit than the skeleton.
        """
        check_is_fitted(self, "skeleton_")
        positions = self._check_X(X, reset=False)
        fitted = inverse_kinematics(
            positions,
            self.skeleton_,
            initial=np.zeros((len(positions), self.skeleton_.n_dofs)),  # one for each: no row depends on others
            joint_limits=self.joint_limits,
            regularization=self.regularization,
            n_jobs=self.n_jobs,
            verbose=self.verbose,
        )
        poses = fitted.poses.astype(positions.dtype, copy=False)
        return _clip_rounded(poses, self.skeleton_.limits) if self.joint_limits == "enforce" else poses

    def inverse_transform(self, X):
        """Positions of the joints of poses, relative to the root and in its axes.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs)
            Poses: joint angles, rad.

        Returns
        -------
        ndarray of shape (n_samples, 3 * n_joints)
            Positions, m, as `forward_kinematics` computes them; float32 for float32 poses, else float64.
        """
        check_is_fitted(self, "skeleton_")
        X = check_poses(X, self.skeleton_, "X")
        warn_of_degrees(X=X, in_estimator=True)
        return forward_kinematics(X, self.skeleton_).reshape(len(X), -1)

    def get_feature_names_out(self, input_features=None):
        """Names of the columns of poses, ``skeleton.dof_names``.

        Parameters
        ----------
        input_features : array-like of str, default=None
            Names of the columns of positions; they are checked, and have no effect.

        Returns
        -------
        ndarray of shape (n_dofs,) of str objects
            Names of the dofs.
        """
        check_is_fitted(self, "skeleton_")
        check_feature_names_in(self, input_features, generate_names=False)
        return np.asarray(self.skeleton_.dof_names, dtype=object)

    def _check_X(self, X, *, reset):
        """X as positions (n_samples, n_joints, 3); with `reset` also learn the skeleton."""
        skeleton = self.skeleton if reset else self.skeleton_
        if skeleton is None:
            raise ValueError("PoseFromPositions needs skeleton=, got None: skpose.keypoints.fit_skeleton makes one")
        if reset:
            self._forget()
            if self.joint_limits == "enforce":
                limits_of(skeleton)  # refused in fit already
        if isinstance(X, Keypoints | Motion | Skeleton):
            raise TypeError(f"X must be an array of positions, got {type(X).__name__}")
        names = [f"{joint}_{axis}" for joint in skeleton.joint_names for axis in "xyz"]
        check_names(X, names, "X", '[f"{joint}_{axis}" for joint in skeleton.joint_names for axis in "xyz"]')
        X = validate_data(self, X, dtype=[np.float64, np.float32], ensure_all_finite="allow-nan", reset=reset)
        positions = self._positions(X, skeleton)
        self.skeleton_ = skeleton
        return positions

    def _positions(self, X, skeleton):
        if X.shape[1] != 3 * skeleton.n_joints:
            raise ValueError(f"X must have {3 * skeleton.n_joints} columns, positions of the joints, got {X.shape[1]}")
        return X.reshape(len(X), -1, 3)

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.input_tags.allow_nan = True
        tags.transformer_tags.preserves_dtype = ["float64", "float32"]
        return tags


def _clip_rounded(poses, limits):
    """Clip poses to limits rounded inwards, to numbers of their own type."""
    lower, upper = limits.astype(poses.dtype).T
    lower = np.where(lower < limits[:, 0], np.nextafter(lower, np.inf, dtype=lower.dtype), lower)
    upper = np.where(upper > limits[:, 1], np.nextafter(upper, -np.inf, dtype=upper.dtype), upper)
    return np.clip(poses, lower, upper)
