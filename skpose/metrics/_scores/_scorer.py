"""Scorers for scikit-learn: by signature, for regressors whose targets are positions, poses or rotations."""

from typing import Any

import numpy as np
from sklearn.base import is_regressor

from skpose._typing import ArrayLike
from skpose._validation.options import check_integer
from skpose.metrics._scores._signature import Call, compute, parse_signature
from skpose.skeleton import Skeleton


def get_scorer(signature: str, *, skeleton: Skeleton | None = None, n_frames: int | str | None = None) -> "PoseScorer":
    """Return a scorer for scikit-learn: ``cross_val_score(model, X, y, scoring=get_scorer("PA-MPJPE|mm"))``.

    In scikit-learn more is better: errors are negative. Names for ``scoring=`` are those of scikit-learn alone, so that
    this scorer is an object.

    Parameters
    ----------
    signature : str
        The score, see `pose_score`.
    skeleton : Skeleton, default=None
        The skeleton, where targets are poses and the score is of positions or rotations. None is the one of the
        regressor if it has learnt poses on one, as `PoseKernelRegressor` has, also as the last step of a pipeline or
        the best of a search; otherwise targets are positions, (n_samples, 3 n_joints), or rotations.
    n_frames : int or "all", default=None
        For scores of motions (accelerations, DTW-MJE, NPSS): the frames of a motion, where each row of y is a motion,
        (n_samples, n_frames * n_columns), frame after frame; "all" where the rows to be scored are the consecutive
        frames of one motion.

    Returns
    -------
    callable
        ``scorer(estimator, X, y, sample_weight=None)``, a float, for ``scoring=`` of `sklearn.model_selection`.

    Raises
    ------
    ValueError
        For a signature that is not understood; for a score of motions without `n_frames`; when called, as the function
        of the score, and for a score of positions of a regressor that has learnt poses without a skeleton.

    See Also
    --------
    pose_score : The number itself.
    sklearn.metrics.make_scorer : Takes `mpjpe` and the others too: ``make_scorer(mpjpe, greater_is_better=False)``.

    Examples
    --------
    >>> import numpy as np
    >>> from sklearn.linear_model import Ridge
    >>> from sklearn.model_selection import cross_val_score
    >>> from skpose import forward_kinematics
    >>> from skpose.datasets import make_gait
    >>> from skpose.metrics import get_scorer
    >>> from skpose.statistics import PoseKernelRegressor
    >>> walk = make_gait(1, 1, activities=["walk"], duration=4, frame_rate=30, random_state=0)[0]
    >>> time = 2 * np.pi * np.arange(len(walk.angles))[:, None] / walk.frame_rate
    >>> X = np.hstack([np.sin(time), np.cos(time)])
    >>> positions = forward_kinematics(walk.angles, walk.skeleton).reshape(len(X), -1)  # 3 columns for each joint
    >>> scorer = get_scorer("PA-MPJPE|mm")
    >>> scorer
    get_scorer('PA-MPJPE|mm')
    >>> cross_val_score(Ridge(), X, positions, scoring=scorer, cv=3).shape
    (3,)
    >>> cross_val_score(PoseKernelRegressor(walk.skeleton), X, walk.angles, scoring=scorer, cv=3).shape
    (3,)
    """
    return PoseScorer(signature, skeleton, n_frames)


class PoseScorer:
    """A scorer as `get_scorer` returns it.

    Parameters
    ----------
    signature : str
        The score.
    skeleton : Skeleton or None
        The skeleton of targets that are poses.
    n_frames : int, "all" or None
        The frames of a row.
    """

    def __init__(self, signature: str, skeleton: Skeleton | None, n_frames: int | str | None):
        call = parse_signature(signature)
        if call.kind.is_sequence and n_frames is None:
            raise ValueError(
                f"{call.name} is of motions: n_frames= says how many frames each row of y has, or n_frames='all' that "
                "the rows that are scored are the consecutive frames of one motion"
            )
        if n_frames is not None:
            if not call.kind.is_sequence:
                raise ValueError(f"{call.name} is of frames in any order, and takes no n_frames=, got {n_frames!r}")
            if n_frames != "all":
                check_integer(n_frames, 2, "n_frames")
        self.signature, self.skeleton, self.n_frames, self._call = signature, skeleton, n_frames, call

    def __call__(self, estimator: Any, X: ArrayLike, y: ArrayLike, sample_weight: ArrayLike | None = None) -> float:
        """Return the score of the predictions, its sign such that more is better."""
        pred = estimator.predict(X)
        skeleton = self.skeleton if self.skeleton is not None else _skeleton_of(estimator, self._call)
        true = y
        if self.n_frames not in (None, "all"):
            true, pred = (self._split(values, name) for values, name in ((y, "y"), (pred, "the prediction")))
        score = compute(self._call, true, pred, skeleton, sample_weight)
        return float(score) if self._call.kind.greater_is_better else -float(score)

    def _split(self, values: Any, name: str) -> list[np.ndarray]:
        """Return rows as motions, (n_frames, n_columns) each."""
        array = np.asarray(values)
        n_frames = int(self.n_frames)  # type: ignore[arg-type]
        if array.ndim != 2 or array.shape[1] % n_frames:
            raise ValueError(
                f"{name} must have rows of n_frames={n_frames} frames, one after another, got shape {array.shape}: the "
                "number of columns is no multiple"
            )
        return list(array.reshape(len(array), n_frames, -1))

    def __repr__(self) -> str:
        given = {"skeleton": self.skeleton, "n_frames": self.n_frames}
        options = "".join(f", {key}={value!r}" for key, value in given.items() if value is not None)
        return f"get_scorer({self.signature!r}{options})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, PoseScorer) and vars(self) == vars(other)

    def __hash__(self) -> int:
        return hash((self.signature, self.n_frames))

    def __getstate__(self) -> tuple[Any, ...]:
        return self.signature, self.skeleton, self.n_frames

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        self.__init__(*state)  # type: ignore[misc]


def _skeleton_of(estimator: Any, call: Call) -> Skeleton | None:
    """Return the skeleton on which a regressor has learnt poses; None of one that has learnt something else."""
    inner = estimator
    while True:
        for name in ("best_estimator_", "regressor_"):
            if hasattr(inner, name):
                inner = getattr(inner, name)
                break
        else:
            if not hasattr(inner, "steps"):
                break
            inner = inner.steps[-1][1]
    if call.kind.takes not in ("positions", "rotations") or not (is_regressor(inner) and hasattr(inner, "skeleton_")):
        return None
    if inner.skeleton_ is None:
        raise ValueError(
            f"{type(inner).__name__} has learnt joint angles without a skeleton, and {call.name} is of "
            f"{call.kind.takes}: pass get_scorer(..., skeleton=...), or use 'Angle|rad'"
        )
    return inner.skeleton_
