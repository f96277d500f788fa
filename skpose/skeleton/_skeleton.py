"""The skeleton: a tree of bones of fixed length, and the degrees of freedom (dofs) of its joints."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from skpose._typing import ArrayLike
from skpose._validation.names import near_names
from skpose.skeleton._bone import BALL, Bone, check_bone, is_axes, mean_bone
from skpose.skeleton._comparison import check_comparable
from skpose.skeleton._html import columns_of_bones, foldable_table
from skpose.skeleton._selection import select_bones
from skpose.skeleton._weights import joint_weights, weight_bones


@dataclass(frozen=True, repr=False)
class Skeleton:
    """A tree of bones of fixed length whose joints rotate about given axes.

    The root is the point to which the first bones are attached. It stays at the origin, unrotated, and is not counted
    among the joints. A skeleton is immutable; equal bones make equal skeletons. It is a mapping of names to bones:
    ``skeleton["left_hand"]``, ``"left_hand" in skeleton``, ``len(skeleton)``, ``list(skeleton)``.

    Parameters
    ----------
    bones : iterable of Bone
        The bones, in any order; plain tuples of the fields of `Bone`, in their order, are accepted.
        They are kept in the given order, except that a parent comes before its children.
    offset_frame : {"own", "parent"}, default="own"
        Axes in which the offsets are given. "own": a joint's dofs rotate the bone that *ends* at it (ASF). "parent":
        they rotate the bones that *start* at it (BVH).

    Attributes
    ----------
    joint_names : tuple of str
        Names of the joints, without the root.
    dof_names : tuple of str
        One name for each column of an array of poses, such as "lfemur_rx"; columns are in rad, those of slides in m.
    parents : ndarray of shape (n_joints,)
        Index of each joint's parent, -1 for the root; a parent comes before its children.
    offsets : ndarray of shape (n_joints, 3)
        The bones' offsets, m.
    rest_rotations : ndarray of shape (n_joints, 3, 3)
        The joints' constant rotations.
    limits : ndarray of shape (n_dofs, 2) or None
        Range of each dof, rad or m, infinite where a bone has none; None where no bone has any.
    weights : ndarray of shape (n_joints,)
        How much each joint counts in distances, see `with_weights`.
    n_joints, n_dofs : int
        Numbers of joints and of dofs.

    Raises
    ------
    ValueError
        For a cycle, an unknown parent, a name given twice, a number that is not finite, axes or limits that do not
        fit; the message names the bone.

    See Also
    --------
    skpose.io.load_asf : Read a skeleton from an ASF file.
    skpose.io.load_bvh : Read a skeleton and its motion from a BVH file.
    skpose.robots.load_robot : Read a robot from a URDF or MJCF file.

    Examples
    --------
    >>> from skpose import Bone, Skeleton
    >>> arm = Skeleton([
    ...     Bone("elbow", None, (0.3, 0, 0), "xyz"),
    ...     Bone("wrist", "elbow", (0.25, 0, 0), "y", limits=((0.0, 2.6),)),
    ... ])
    >>> arm
    Skeleton(n_joints=2, n_dofs=4)
    >>> arm.dof_names
    ('elbow_rx', 'elbow_ry', 'elbow_rz', 'wrist_ry')
    >>> arm["wrist"].parent
    'elbow'
    """

    bones: tuple[Bone, ...]
    offset_frame: Literal["own", "parent"] = "own"

    if TYPE_CHECKING:

        def __init__(self, bones: Iterable[Bone | tuple], offset_frame: Literal["own", "parent"] = "own") -> None: ...

    def __post_init__(self) -> None:
        if self.offset_frame not in ("own", "parent"):
            raise ValueError(f'offset_frame must be "own" or "parent", got {self.offset_frame!r}')
        bones = _in_tree_order([check_bone(Bone(*bone)) for bone in self.bones])
        if not any(bone.dofs for bone in bones):
            raise ValueError("a skeleton needs at least one degree of freedom, but no bone has any dofs")
        object.__setattr__(self, "bones", bones)
        _check_dof_names(self.dof_names)

    @classmethod
    def chain(cls, n: int) -> "Skeleton":
        """Return a planar arm: n bones of 1 m, each rotating about z at its near end.

        Parameters
        ----------
        n : int
            Number of bones.

        Returns
        -------
        Skeleton
            With joints "joint_1" to "joint_n".

        Examples
        --------
        >>> from skpose import Skeleton
        >>> Skeleton.chain(3).dof_names
        ('joint_1_rz', 'joint_2_rz', 'joint_3_rz')
        """
        names: list[Any] = [None, *(f"joint_{i}" for i in range(1, n + 1))]
        return cls(Bone(name, parent, (1.0, 0.0, 0.0), "z") for parent, name in pairwise(names))

    @classmethod
    def mean(cls, skeletons: Iterable["Skeleton"]) -> "Skeleton":
        """Return the bone-wise mean: one skeleton on which the poses of several people can be compared.

        Each bone gets the mean length and the mean direction of all bones of its name, the (chordal) mean of their
        rest rotations, and the widest of their limits.

        Parameters
        ----------
        skeletons : iterable of Skeleton
            At least one; with the same joints, parents, dofs and offset frame.

        Returns
        -------
        Skeleton
            With the bones in the order of the first.

        Raises
        ------
        ValueError
            If the skeletons differ in more than lengths, directions and limits (such as weights), or if the directions
            of a bone at angle zero, or two rest rotations of a joint, are more than 45° apart, as in a T-pose and an
            A-pose; the message names the joint. `skpose.kinematics.retarget` converts motions to one rest pose.
        """
        skeletons = list(skeletons)
        if not skeletons:
            raise ValueError("the mean skeleton needs at least one skeleton, got none")
        for i, one in enumerate(skeletons):
            if not isinstance(one, Skeleton):
                raise TypeError(f"skeletons[{i}] must be a skpose.Skeleton, got {type(one).__name__}")
        first = skeletons[0]
        remedy = (
            "Convert the motions to one rest pose first: "
            'skpose.kinematics.retarget(motion, skeletons[0], method="orientations")'
        )
        other_rig = 'skpose.kinematics.retarget(motion, skeletons[0], method="auto") converts motions of different rigs'
        check_comparable(skeletons, [f"skeletons[{i}]" for i in range(len(skeletons))], remedy, other_rig)
        by_name = [{bone.name: bone for bone in skeleton.bones} for skeleton in skeletons]
        return cls((mean_bone([bones[name] for bones in by_name]) for name in first.joint_names), first.offset_frame)

    def to_rotvec(self) -> "Skeleton":
        """Return the skeleton with every joint of two or three Euler dofs as a ball joint.

        Hinges stay, and rigid joints. A ball joint has no limits: those of the joints that change are dropped.

        Returns
        -------
        Skeleton
            With the same bones otherwise; `Motion.to_rotvec` turns poses into its poses.

        Examples
        --------
        >>> from skpose import Bone, Skeleton
        >>> arm = Skeleton([Bone("elbow", None, (0.3, 0, 0), "ZXY"), Bone("wrist", "elbow", (0.25, 0, 0), "z")])
        >>> arm.to_rotvec().dof_names
        ('elbow_rotvec_x', 'elbow_rotvec_y', 'elbow_rotvec_z', 'wrist_rz')
        """
        bones = (b._replace(dofs=BALL, limits=None) if b.n_dofs > 1 else b for b in self.bones)
        return Skeleton(bones, self.offset_frame)

    def to_euler(self, order: str) -> "Skeleton":
        """Return the skeleton with every ball joint as a joint with three Euler dofs.

        Parameters
        ----------
        order : str
            Three different letters in the notation of `Bone`: "xyz" is extrinsic, "ZXY" intrinsic.

        Returns
        -------
        Skeleton
            With the same bones otherwise; `Motion.to_euler` turns poses into its poses.

        Raises
        ------
        ValueError
            If the order is not three different letters in one case.

        Examples
        --------
        >>> from skpose import Bone, Skeleton
        >>> Skeleton([Bone("elbow", None, (0.3, 0, 0), "rotvec")]).to_euler("ZXY").dof_names
        ('elbow_rz', 'elbow_rx', 'elbow_ry')
        """
        if not is_axes(order) or len(order) != 3:
            raise ValueError(
                f'order must be three different letters in one case, such as "xyz" or "ZXY", got {order!r}'
            )
        return Skeleton((b._replace(dofs=order) if b.is_ball else b for b in self.bones), self.offset_frame)

    def __getitem__(self, name: str) -> Bone:
        """Return the bone that ends at the joint of a name: ``skeleton["left_hand"]``."""
        if not isinstance(name, str):
            raise TypeError(
                f"a skeleton is indexed by the name of a joint, got {type(name).__name__}: skeleton.bones has the "
                "bones by number"
            )
        for bone in self.bones:
            if bone.name == name:
                return bone
        raise KeyError(f"the skeleton has no joint {name!r}: {near_names(self.joint_names, name)}")

    def __contains__(self, name: object) -> bool:
        """Return whether a joint has this name: ``"left_hand" in skeleton``."""
        return name in self.joint_names

    def __iter__(self) -> Iterator[str]:
        """Yield the names of the joints, as iteration over a dictionary yields its keys."""
        return iter(self.joint_names)

    def __len__(self) -> int:
        return len(self.bones)

    def __array__(self, dtype: object = None, copy: bool | None = None) -> np.ndarray:
        """Return an array of no dimension that holds the skeleton.

        Without it numpy takes what has a length for a sequence, and makes a table of names of the list of skeletons
        among which a grid search chooses.
        """
        if dtype is not None and np.dtype(dtype) != object:  # type: ignore[call-overload]
            raise TypeError("a Skeleton is no array of numbers")
        array = np.empty((), dtype=object)
        array[()] = self
        return array

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, without the root."""
        return tuple(bone.name for bone in self.bones)

    @cached_property
    def dof_names(self) -> tuple[str, ...]:
        """One name for each column of an array of poses."""
        return tuple(name for bone in self.bones for name in bone.dof_names)

    @cached_property
    def parents(self) -> np.ndarray:
        """Index of each joint's parent, -1 for the root."""
        index: dict[str | None, int] = {None: -1, **{name: i for i, name in enumerate(self.joint_names)}}
        return _freeze([index[bone.parent] for bone in self.bones], dtype=np.intp)

    @cached_property
    def offsets(self) -> np.ndarray:
        """The bones' offsets, m, of shape (n_joints, 3)."""
        return _freeze([bone.offset for bone in self.bones])

    @cached_property
    def rest_rotations(self) -> np.ndarray:
        """The joints' constant rotations, of shape (n_joints, 3, 3)."""
        return _freeze([np.eye(3) if b.rest_rotation is None else b.rest_rotation for b in self.bones])

    @cached_property
    def limits(self) -> np.ndarray | None:
        """Range of each dof, rad, of shape (n_dofs, 2); None where no bone has any."""
        if all(bone.limits is None for bone in self.bones):
            return None
        free = (-np.inf, np.inf)
        return _freeze([pair for b in self.bones for pair in (b.limits or [free] * b.n_dofs)])

    @cached_property
    def weights(self) -> np.ndarray:
        """Weight of each joint in distances."""
        return _freeze(joint_weights(self))

    def with_weights(self, weights: Mapping[str, float] | ArrayLike | Literal["mass"]) -> "Skeleton":
        r"""Return the skeleton with weights of its joints in distances.

        In every metric but "angle" the position of a joint of weight w counts :math:`\sqrt{w}` times: F(θ) stacks
        :math:`\sqrt{w_j}\, p_j(\theta)`, and "rotation" has :math:`\sqrt{\sum_b w_b \ell_b^2 \varphi_b^2}`, the weight
        of a bone being that of the joint at its far end. Joints of weight zero are not seen. What carries none but such
        joints costs no time, and its columns of a pose have no effect.

        Parameters
        ----------
        weights : mapping of str to float, array-like of shape (n_joints,), or "mass"
            A mapping, or a series of pandas whose index has names, gives weights to the joints that it names, and the
            others keep theirs. An array gives one to each of ``skeleton.joint_names``. "mass" gives each joint its
            share of the mass of a person, after the mean of the women and men of [1]_: of each segment as much to
            either end as puts the centre of mass where it is. Lengths are then those of the kinetic energy of these
            masses, for a person of 1 kg.

        Returns
        -------
        Skeleton
            With the same bones otherwise; its `weights` are the weights.

        Raises
        ------
        ValueError
            For a name that no joint has, a weight that is negative or not finite, weights that are all zero; for
            "mass", if a segment of the person is not found by the names of the joints.

        Notes
        -----
        Without weights every joint counts 1, but joints that always stand in one place count once: one of them has
        weight 1 and the others 0.

        "mass" finds thighs, shanks, feet, upper arms, forearms, hands and the head by name. The trunk, without the
        pelvis, is spread evenly over the length of the spine. What belongs to the root is left out, as the root does
        not move.

        References
        ----------
        .. [1] P. de Leva, "Adjustments to Zatsiorsky-Seluyanov's segment inertia parameters", Journal of Biomechanics
           29(9), 1996, table 4, :doi:`10.1016/0021-9290(95)00178-6`.

        Examples
        --------
        >>> from skpose import pose_distances
        >>> from skpose.datasets import humanoid
        >>> skeleton = humanoid()
        >>> without_hands = skeleton.with_weights({"left_hand": 0, "right_hand": 0})
        >>> a, b = [[0.0] * 42], [[0.3] * 42]
        >>> pose_distances(a, b, skeleton=skeleton, metric="position").round(2)
        array([[1.99]])
        >>> pose_distances(a, b, skeleton=without_hands, metric="position").round(2)
        array([[1.73]])
        >>> float(skeleton.with_weights("mass").weights.sum().round(2))
        0.82
        """
        weighted = replace(self, bones=weight_bones(self, weights))
        if not weighted.weights.any():
            raise ValueError("weights must be positive for at least one joint, but all are zero")
        return weighted

    def select(self, joints: str | Iterable[str] | None = None, *, drop: str | Iterable[str] = ()) -> "Skeleton":
        """Return the skeleton of some joints, and of those that carry them.

        The dofs of all other joints are no columns of its poses any more. `Motion.select` and `MotionDataset.select` do
        the same with motions; ``X[:, part.columns_in(skeleton)]`` does it with an array of poses.

        Parameters
        ----------
        joints : str or iterable of str, default=None
            Joints to keep. All joints between them and the root are kept too, as these carry them. None keeps all.
        drop : str or iterable of str, default=()
            Joints to leave out, each with all that it carries.

        Returns
        -------
        Skeleton
            With the kept bones, unchanged, in their order.

        Raises
        ------
        ValueError
            For a name that no joint has, or if no joint with dofs is left.

        See Also
        --------
        with_weights : Joints of weight zero are not seen, and the columns of poses stay.

        Examples
        --------
        >>> from skpose.datasets import humanoid
        >>> skeleton = humanoid()
        >>> skeleton.select("left_hand").joint_names
        ('abdomen', 'chest', 'left_clavicle', 'left_upper_arm', 'left_forearm', 'left_hand')
        >>> skeleton.select(drop=["left_pelvis", "right_pelvis"])  # the upper part of the body
        Skeleton(n_joints=12, n_dofs=28)
        """
        return replace(self, bones=select_bones(self, joints, drop))

    def columns_in(self, skeleton: "Skeleton") -> np.ndarray:
        """Return the columns, in poses of a larger skeleton, of the dofs of this one.

        Parameters
        ----------
        skeleton : Skeleton
            A skeleton that has all dofs of this one, by name.

        Returns
        -------
        ndarray of shape (n_dofs,)
            Indices into ``skeleton.dof_names``.

        Raises
        ------
        ValueError
            If one of the dofs is not among those of the skeleton.

        Examples
        --------
        >>> from skpose import Skeleton
        >>> arm = Skeleton.chain(3)
        >>> arm.select("joint_2").columns_in(arm)
        array([0, 1])
        """
        index = {name: i for i, name in enumerate(skeleton.dof_names)}
        missing = [name for name in self.dof_names if name not in index]
        if missing:
            raise ValueError(f"the other skeleton has no dof {missing[0]!r}: it must be the one that this is a part of")
        return np.array([index[name] for name in self.dof_names], dtype=np.intp)

    @property
    def n_joints(self) -> int:
        """Number of joints, without the root."""
        return len(self.bones)

    @cached_property
    def n_dofs(self) -> int:
        """Number of dofs, the columns of an array of poses."""
        return len(self.dof_names)

    @cached_property
    def _hash(self) -> int:
        return hash((self.bones, self.offset_frame))

    def __hash__(self) -> int:
        return self._hash

    def __repr__(self) -> str:
        given = {bone.name: bone.weight for bone in self.bones if bone.weight is not None}
        weights = f"weights={given}" if len(given) <= 4 else f"weights of {len(given)} joints"
        return f"Skeleton(n_joints={self.n_joints}, n_dofs={self.n_dofs}" + (f", {weights})" if given else ")")

    def _repr_html_(self) -> str:
        """Return the bones as a table, which a notebook shows."""
        return foldable_table(repr(self), columns_of_bones(self))

    def __reduce__(self) -> tuple:
        return Skeleton, (self.bones, self.offset_frame)

    def __deepcopy__(self, memo: dict) -> "Skeleton":
        return self  # immutable; scikit-learn's clone copies every parameter


def _freeze(values: Any, dtype: type = np.float64) -> np.ndarray:
    array: np.ndarray = np.array(values, dtype=dtype)
    array.flags.writeable = False
    return array


def _check_dof_names(names: Sequence[str]) -> None:
    """Refuse two columns of poses of one name: files and tables know columns by these."""
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"two dofs have the name {twice!r}; every column of a pose needs its own: see Bone's dof_name")


def _in_tree_order(bones: Sequence[Bone]) -> tuple[Bone, ...]:
    """Return the bones, each after its parent, otherwise in the given order."""
    by_name: dict[str | None, Bone] = {}
    for bone in bones:
        if bone.name in by_name:
            raise ValueError(f"bone {bone.name!r} is given twice; every joint needs its own name")
        by_name[bone.name] = bone
    placed: dict[str, Bone] = {}
    for bone in bones:
        chain: dict[str, Bone] = {}
        while bone.name not in placed:
            if bone.name in chain:
                cycle = " -> ".join([*chain, bone.name])
                raise ValueError(f"bone {bone.name!r} is a child of itself, through {cycle}")
            chain[bone.name] = bone
            if bone.parent is None:
                break
            if bone.parent not in by_name:
                raise ValueError(
                    f"bone {bone.name!r} is a child of {bone.parent!r}, which is not among the bones; "
                    "a child of the root has parent None"
                )
            bone = by_name[bone.parent]
        placed.update(reversed(chain.items()))
    return tuple(placed.values())
