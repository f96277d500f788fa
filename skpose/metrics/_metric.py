"""The base class of metrics: what the floors above ask of one, and what a metric of one's own has to say."""

import inspect
from collections.abc import Callable
from types import FunctionType
from typing import Any, ClassVar, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numba import config
from numba.core.dispatcher import Dispatcher
from sklearn.base import BaseEstimator

from skpose._compat.sklearn import InvalidParameterError, validate_parameter_constraints
from skpose._compiled.pose import loops
from skpose._compiled.pose.tree import Steps, Tree
from skpose._validation.options import check_integer
from skpose.kinematics._shared import tree_of
from skpose.metrics._direct_means import DirectMeans
from skpose.metrics._own import check_functions
from skpose.metrics._sample import Sample
from skpose.skeleton import Skeleton

NO_STEPS = Steps.of(1, wrap=False)  # of metrics that need no line
_COMPILED_TYPE = FunctionType if getattr(config, "DISABLE_JIT", False) else Dispatcher
_COMPILED = "encode", "measure", "measure_within"
# What stays true of a class that measures anew: the rest is of the metric that it inherits from, and refused.
_INHERITABLE = {"encode", "measure", "steps", "unit", "needs_skeleton", "encode_work", "measure_work"}


# Names of the parameters of each class: scikit-learn inspects the constructor at each call, for some 10 µs.
_PARAMETERS: "WeakKeyDictionary[type[Metric], tuple[str, ...]]" = WeakKeyDictionary()


def _find_member(cls: type, name: str) -> Any:
    """Return a member of a class as it is written there."""
    return inspect.getattr_static(cls, name, None)


class CoarseBound(NamedTuple):
    """A lower bound of a metric, computed in float32: encode and measure as a metric has them."""

    encode: Callable
    measure: Callable
    n_codes: Callable[[Tree], int]
    slack: Callable[[Tree], float]  # by how much rounding may lengthen the bound, m


class Metric(BaseEstimator):
    """A distance between poses, with its parameters.

    A metric says what is measured, not on which skeleton: skeletons come with the data. It has the parameters of its
    constructor as a scikit-learn estimator has them, so that ``metric__n_steps`` can be searched over. Two metrics are
    equal if their classes and parameters are.

    To define a metric of one's own, derive from this class; see the page "A metric of one's own". `encode` and
    `measure` are two compiled functions, and `n_codes` is how many numbers the first one writes for a pose. All other
    members have defaults.

    Attributes
    ----------
    name : str
        The name in tables, plots and pages, by default that of the class; for the metrics of this package also the
        short form, ``metric="spatial"``.
    unit : str
        The unit of a distance.
    equation : str
        The distance between poses a and b, in LaTeX.
    source : str
        Where it is defined.
    needs_skeleton : bool
        Whether the poses must have a skeleton.
    iterative : bool
        Whether each pair is solved by iterations, in float64, and may not converge.
    has_gradients : bool
        Whether distances have gradients everywhere: if not, means are searched by BFGS, and there are none of motions.
    encode : callable
        Compiled: writes the code of a pose, all that the metric needs of it; see `compile_encode`.
    measure : callable
        Compiled: computes the distances from one code to others; see `compile_measure`.
    measure_within : callable or None
        The same up to a limit, and above it any lower bound that is above it.
    coarse_bound : CoarseBound or None
        A lower bound that is cheaper than the metric, for searches.
    encode_work, measure_work : float
        Cost for each number of a code, of a pose and of a pair. Adding one square to a sum is 1, some 0.2 ns. They
        choose between methods that give the same result.

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
    measure_within: ClassVar[Any] = None
    encode_work: ClassVar[float] = 60
    measure_work: ClassVar[float] = 1

    _parameter_constraints: ClassVar[dict] = {}

    def __init_subclass__(cls) -> None:
        """Keep compiled functions as they are, which would become methods; refuse the bounds and means of another one.

        Raises
        ------
        TypeError
            For a class that measures anew, but inherits from another metric what is true of that only.
        """
        super().__init_subclass__()
        for name in _COMPILED:
            function = inspect.getattr_static(cls, name, None)
            if isinstance(function, Dispatcher | FunctionType):  # and no property
                setattr(cls, name, staticmethod(function))
        above = cls.__mro__[1 : cls.__mro__.index(Metric)]
        if "name" not in vars(cls) and getattr(cls, "name", None) in (None, *(base.__name__ for base in above)):
            cls.name = cls.__name__
        for member in sorted(vars(Metric).keys() | {"name"}):
            if member.startswith("_") or member in _INHERITABLE:
                continue
            of = next(base for base in cls.__mro__ if member in vars(base) or base is Metric)
            functions = ["encode"] if member == "n_codes" else ["encode", "measure"]
            own = of is cls or of is Metric or not issubclass(of, Metric)
            if not own and any(_find_member(of, name) is not _find_member(cls, name) for name in functions):
                raise TypeError(
                    f"{cls.__name__} measures another distance than {of.__name__}, but inherits {member} from it: "
                    f"derive {cls.__name__} from Metric; it may use {of.__name__}.encode"
                )

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Return the parameters by name.

        Parameters
        ----------
        deep : bool, default=True
            Not used, as no parameter of a metric has parameters of its own.

        Returns
        -------
        dict
            The parameters; numpy's numbers are Python's.
        """
        cls = type(self)
        if cls not in _PARAMETERS:
            _PARAMETERS[cls] = tuple(super().get_params(deep=False))
        given = {name: getattr(self, name) for name in _PARAMETERS[cls]}
        return {name: value.item() if isinstance(value, np.generic) else value for name, value in given.items()}

    @property
    def label(self) -> str:
        """The name, and the parameters where they are not the defaults: for tables, plots and pages."""
        signature = inspect.signature(type(self)).parameters
        changed = [(key, value) for key, value in self._parameters() if value != signature[key].default]
        given = ", ".join(f"{key}={value!r}" for key, value in changed)
        return f"{type(self).__name__}({given})" if changed else self.name

    @property
    def steps(self) -> Steps:
        """The steps of the line from pose to pose, which `encode` and `measure` get."""
        return NO_STEPS

    @property
    def coarse_bound(self) -> CoarseBound | None:
        """A lower bound that is cheaper than the metric, for searches; None if there is none."""
        return None

    def n_codes(self, tree: Tree, n_dofs: int) -> int:
        """Return the length of the code of a pose.

        Parameters
        ----------
        tree : Tree
            The skeleton as compiled code has it.
        n_dofs : int
            Number of the columns of a pose.

        Returns
        -------
        int
            How many numbers `encode` writes.
        """
        raise NotImplementedError(f"{type(self).__name__} must define n_codes(tree, n_dofs), the length of a code")

    def lower_bound(self) -> "Metric | None":
        """Return a metric that is never more than this one and is the Euclidean distance of codes; None for none.

        Searches rest on it. Without one they measure all pairs.

        Returns
        -------
        Metric or None
            The bound.
        """
        return None

    def upper_bound(self) -> "Metric | None":
        """Return a metric that is never less than this one and takes far less time; None for none.

        Returns
        -------
        Metric or None
            The bound.
        """
        return None

    def why_no_means(self) -> str:
        """Return why no mean can be found under this metric; empty where one can.

        Returns
        -------
        str
            The reason, for an error.
        """
        return "it defines no Metric.sample" if type(self).sample is Metric.sample else ""

    def sample(self, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton | None, n_jobs: int) -> Sample:
        """Return weighted poses, for the search for their mean or median.

        Parameters
        ----------
        X : ndarray of shape (n_poses, n_dofs)
            Poses: joint angles, rad.
        weights : ndarray of shape (n_poses,)
            Their weights, of sum 1.
        skeleton : Skeleton or None
            Their skeleton; None where the metric needs none.
        n_jobs : int
            Threads.

        Returns
        -------
        Sample
            What the search asks of the metric.
        """
        raise ValueError(f"{self!r} has no means: {self.why_no_means()}")

    def direct_means(self, X: np.ndarray, skeleton: Skeleton | None) -> DirectMeans | None:
        """Return the means of any weightings of poses, where they take no search from pose to pose; else None.

        Parameters
        ----------
        X : ndarray of shape (n_poses, n_dofs)
            Poses: joint angles, rad.
        skeleton : Skeleton or None
            Their skeleton; None where the metric needs none.

        Returns
        -------
        DirectMeans or None
            The means, by weights.
        """
        return None

    def check_params(self) -> None:
        """Refuse parameters that are not as `_parameter_constraints` says, as scikit-learn's estimators do."""
        given = self.get_params(deep=False)
        try:
            validate_parameter_constraints(self._parameter_constraints, given, type(self).__name__)
        except InvalidParameterError as error:  # in which scikit-learn would put the name of the function called
            raise ValueError(str(error)) from None
        name = type(self).__name__
        for key, value in given.items():
            if isinstance(value, bool) and "boolean" not in self._parameter_constraints.get(key, ["boolean"]):
                raise ValueError(f"{key} of {name} must be a number, got {value}")
            if words := self._why_not_hashable(key, value):
                raise ValueError(words)
        for function in ("encode", "measure"):
            if not isinstance(getattr(self, function, None), _COMPILED_TYPE):
                raise ValueError(
                    f"{name}.{function} must be a compiled function: make it with skpose.metrics.compile_{function}, "
                    "or take that of another metric"
                )

    def _parameters(self) -> list[tuple[str, Any]]:
        """Return the parameters by name, in their order."""
        return sorted(self.get_params(deep=False).items())

    def _check_functions(self, tree: Tree, n_dofs: int) -> None:
        """Refuse functions of a metric of one's own that would write beyond a code, or give what is no distance."""
        try:
            n_codes = self.n_codes(tree, n_dofs)
        except TypeError as error:
            raise ValueError(
                f"{type(self).__name__}.n_codes must be a method, n_codes(self, tree, n_dofs), that returns the length "
                f"of a code: {error}"
            ) from error
        check_integer(n_codes, 0, f"what {type(self).__name__}.n_codes returns, the length of a code,")
        if (owner := _OWNERS.get(self.encode)) is not None:
            expected = owner.n_codes(self, tree, n_dofs)
            if n_codes != expected:
                raise ValueError(
                    f"{type(self).__name__}.n_codes gives {n_codes}, but its encode, that of {owner.__name__}, writes "
                    f"{expected} numbers: return as many"
                )
        check_functions(self, tree, n_dofs, n_codes)

    def tree_for(self, skeleton: Skeleton | None, dtype: np.dtype | None = None) -> Tree:
        """Return the skeleton as compiled code has it; an empty one where the metric needs none.

        Parameters
        ----------
        skeleton : Skeleton or None
            The skeleton.
        dtype : dtype, default=None
            Type of its numbers; None is float64.

        Returns
        -------
        Tree
            The arrays of the skeleton.
        """
        used = skeleton if self.needs_skeleton else None
        return tree_of(used) if dtype is None else tree_of(used, dtype)

    def encode_poses(self, poses: np.ndarray, skeleton: Skeleton | None) -> np.ndarray:
        """Return the codes of poses, in float64.

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
        for key, value in self._parameters():
            if words := self._why_not_hashable(key, value):
                raise TypeError(words)
        return hash((type(self), *self._parameters()))

    def _why_not_hashable(self, key: str, value: Any) -> str:
        """Return in words what is wrong with a parameter that has no hash; nothing if it has one."""
        try:
            hash(value)
        except TypeError:
            return (
                f"parameters of metrics are numbers, words or tuples of them, so that metrics can be compared, but "
                f"{key} of {type(self).__name__} is {value!r}, a {type(value).__name__}: pass a tuple"
            )
        return ""


_OWNERS: dict[Any, type[Metric]] = {}  # of the library's own encodes: whose codes have the length that they write


def own_encode(cls: type[Metric]) -> type[Metric]:
    """Note, as a decorator, that the length of what a class's encode writes is what its `n_codes` states."""
    _OWNERS[cls.encode] = cls
    return cls


def require_skeleton(skeleton: Skeleton | None) -> Skeleton:
    """Return the skeleton of a metric that needs one, which `resolve` has seen to."""
    if skeleton is None:
        raise ValueError("the metric needs a skeleton, got None")
    return skeleton
