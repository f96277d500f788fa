"""The base class of metrics."""

import inspect
from types import FunctionType
from typing import Any, ClassVar

import numpy as np
from numba import config
from numba.core.dispatcher import Dispatcher
from sklearn.base import BaseEstimator

from skpose._compiled.pose import loops
from skpose._compiled.pose.tree import Steps, Tree
from skpose._utils.validation import check_integer
from skpose.kinematics._tree import tree_of
from skpose.metrics._means import ArithmeticMeans, ExtrinsicMeans, Sample
from skpose.metrics._own import check_functions
from skpose.skeleton import Skeleton

NO_STEPS = Steps.of(1, wrap=False)  # of metrics that need no line
_COMPILED_TYPE = FunctionType if getattr(config, "DISABLE_JIT", False) else Dispatcher
# Members that are true only together with the `encode` and `measure` of their class.


class Metric(BaseEstimator):
    """A distance between poses, with its parameters.

    A metric does not hold a skeleton: skeletons come with the data. Parameters are arguments of the constructor, as in
    scikit-learn, so that a grid search can use ``metric__n_steps``. Two metrics are equal if their classes and
    parameters are equal.

    To define your own metric, derive a class from this one; see the page "A metric of one's own". It needs two compiled
    functions, `encode` and `measure`, and `n_codes`, the length of the code of a pose. All other members have defaults.

    Attributes
    ----------
    name : str
        The name in tables, plots and pages. The default is the name of the class. For the metrics of this package it is
        also the short form, as in ``metric="spatial"``.
    unit : str
        The unit of a distance.
    equation : str
        The distance between poses a and b, in LaTeX.
    source : str
        Where it is defined.
    needs_skeleton : bool
        Whether the poses must have a skeleton.
    iterative : bool
        Whether each pair is solved iteratively, in float64, and may not converge.
    has_gradients : bool
        Whether distances have gradients everywhere. If not, means are found by BFGS, and motions have no means.
    encode : callable
        Compiled function that writes the code of a pose; see `compile_encode`.
    measure : callable
        Compiled function that computes the distances from one code to others; see `compile_measure`.
    encode_work, measure_work : float
        Cost per number of a code, of encoding a pose and of measuring a pair, in units of about 0.2 ns. They only
        affect the choice between methods that give the same result.

    Examples
    --------
    >>> from skpose.metrics import Spatial
    >>> Spatial(n_steps=20)
    Spatial(n_steps=20)
    >>> Spatial() == Spatial(n_steps=10), Spatial().unit
    (True, 'm')
    """

    name: ClassVar[str]
    unit: ClassVar[str] = "m"
    equation: ClassVar[str] = ""
    source: ClassVar[str] = ""
    needs_skeleton: ClassVar[bool] = True
    iterative: ClassVar[bool] = False
    has_gradients: ClassVar[bool] = True

    encode: ClassVar[Any]
    measure: ClassVar[Any]
    encode_work: ClassVar[float] = 60
    measure_work: ClassVar[float] = 1

    _parameter_constraints: ClassVar[dict] = {}

    def __init_subclass__(cls) -> None:
        """Make compiled functions static, and refuse other functions than those of the inherited bounds and means."""
        super().__init_subclass__()
        for name in ("encode", "measure"):
            function = inspect.getattr_static(cls, name, None)
            if isinstance(function, Dispatcher | FunctionType):  # and not a property
                setattr(cls, name, staticmethod(function))
            inherited = getattr(super(cls, cls), name, None)
            if inherited is not None and inherited is not getattr(cls, name):
                raise TypeError(f"{cls.__name__} must derive from Metric, as its {name} is another distance")
        cls.name = vars(cls).get("name", cls.__name__)

    @property
    def label(self) -> str:
        """The name, with the parameters that are not the defaults."""
        signature = inspect.signature(type(self)).parameters
        changed = [(key, value) for key, value in self._parameters() if value != signature[key].default]
        given = ", ".join(f"{key}={value!r}" for key, value in changed)
        return f"{type(self).__name__}({given})" if changed else self.name

    @property
    def steps(self) -> Steps:
        """The steps of the line between two poses, an argument of `encode` and `measure`."""
        return NO_STEPS

    def n_codes(self, tree: Tree, n_dofs: int) -> int:
        """Length of the code of a pose.

        Parameters
        ----------
        tree : Tree
            The arrays of the skeleton.
        n_dofs : int
            Number of columns of a pose.

        Returns
        -------
        int
            How many numbers `encode` writes.
        """
        raise NotImplementedError(f"{type(self).__name__} must define n_codes(tree, n_dofs), the length of a code")

    def lower_bound(self) -> "Metric | None":
        """Metric that is never greater than this one and is the Euclidean distance of codes.

        Searches use it. Without one they measure all pairs.

        Returns
        -------
        Metric or None
            The bound, None if there is none.
        """
        return None

    def upper_bound(self) -> "Metric | None":
        """Metric that is never less than this one and far cheaper.

        Returns
        -------
        Metric or None
            The bound, None if there is none.
        """
        return None

    @property
    def has_means(self) -> bool:
        """Whether poses have means under this metric."""
        return type(self).sample is not Metric.sample

    def sample(self, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton | None, n_jobs: int) -> Sample:
        """Weighted poses, for the search for their mean or median.

        Parameters
        ----------
        X : ndarray of shape (n_poses, n_dofs)
            Poses: joint angles, rad.
        weights : ndarray of shape (n_poses,)
            Their weights, which sum to 1.
        skeleton : Skeleton or None
            Their skeleton; None where the metric needs none.
        n_jobs : int
            Threads.

        Returns
        -------
        Sample
            What the search needs from the metric.
        """
        raise NotImplementedError(f"{type(self).__name__} has no means: it defines no sample()")

    def direct_means(self, X: np.ndarray, skeleton: Skeleton | None) -> ArithmeticMeans | ExtrinsicMeans | None:
        """Means of poses under any weights, where they need no search from pose to pose.

        Parameters
        ----------
        X : ndarray of shape (n_poses, n_dofs)
            Poses: joint angles, rad.
        skeleton : Skeleton or None
            Their skeleton; None where the metric needs none.

        Returns
        -------
        ArithmeticMeans, ExtrinsicMeans or None
            The means, None if they need a search.
        """
        return None

    def check_params(self) -> None:
        """Refuse invalid parameters, as scikit-learn's estimators do."""
        try:
            self._validate_params()
        except ValueError as error:  # which scikit-learn would ascribe to the function that is called
            raise ValueError(str(error)) from None
        for function in ("encode", "measure"):
            if not isinstance(getattr(self, function, None), _COMPILED_TYPE):
                raise ValueError(
                    f"{type(self).__name__}.{function} must be compiled: make it with metrics.compile_{function}"
                )

    def _parameters(self) -> list[tuple[str, Any]]:
        return sorted(self.get_params(deep=False).items())

    def _check_functions(self, tree: Tree, n_dofs: int) -> None:
        """Refuse functions of a user's metric that would write beyond a code, or do not measure a distance."""
        n_codes = self.n_codes(tree, n_dofs)
        check_integer(n_codes, 0, f"{type(self).__name__}.n_codes()")
        ours = (kind for kind in Metric.__subclasses__() if kind.__module__.startswith("skpose."))
        owner = next((kind for kind in ours if getattr(kind, "encode", None) is self.encode), None)
        if owner is not None and n_codes != (expected := owner.n_codes(self, tree, n_dofs)):
            raise ValueError(f"{type(self).__name__}.n_codes() must be {expected}, as encode writes, got {n_codes}")
        check_functions(self, tree, n_dofs, n_codes)

    def tree_for(self, skeleton: Skeleton | None, dtype: np.dtype | None = None) -> Tree:
        """Arrays of the skeleton for compiled code.

        Parameters
        ----------
        skeleton : Skeleton or None
            The skeleton.
        dtype : dtype, default=None
            Type of its numbers; None is float64.

        Returns
        -------
        Tree
            The arrays of the skeleton, empty where the metric needs none.
        """
        used = skeleton if self.needs_skeleton else None
        return tree_of(used) if dtype is None else tree_of(used, dtype)

    def encode_poses(self, poses: np.ndarray, skeleton: Skeleton | None) -> np.ndarray:
        """Codes of poses, in float64.

        Parameters
        ----------
        poses : ndarray of shape (n_poses, n_dofs)
            Poses: joint angles, rad.
        skeleton : Skeleton or None
            Their skeleton; None where the metric needs none.

        Returns
        -------
        ndarray of shape (n_poses, n_codes)
            The codes.
        """
        tree = self.tree_for(skeleton)
        self._check_functions(tree, poses.shape[1])
        codes = np.empty((len(poses), self.n_codes(tree, poses.shape[1])))
        loops.encode_poses(poses, self.encode, tree, self.steps, codes)
        return codes

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Metric) and type(self) is type(other) and self._parameters() == other._parameters()

    def __hash__(self) -> int:
        return hash((type(self), *self._parameters()))


def require_skeleton(skeleton: Skeleton | None) -> Skeleton:
    if skeleton is None:
        raise ValueError("the metric needs a skeleton, got None")
    return skeleton
