"""The skeleton: a tree of bones of fixed length, and the degrees of freedom (dofs) of its joints."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.typing import ArrayLike
from skpose._utils.upper_layers import upper_layers
from skpose._utils.validation import check_choice, near_names
from skpose.skeleton._bone import BALL, Bone, check_bone, is_axes, mean_bone, ranges_of
from skpose.skeleton._rest import check_comparable
from skpose.skeleton._rotations import joint_positions

SAME_PLACE = 1e-9  # m; files that print nine digits leave this much between joints in one place


@dataclass(frozen=True, repr=False)
class Skeleton:
    """A tree of bones of fixed length.

    The root is the point to which the first bones are attached. It stays at the origin, unrotated, and is not counted
    among the joints. A skeleton is immutable; skeletons with equal bones are equal. It works as a mapping of names to
    bones: ``skeleton["left_hand"]``, ``"left_hand" in skeleton``, ``len(skeleton)``, ``list(skeleton)``.

    Parameters
    ----------
    bones : iterable of Bone
        The bones, or plain tuples of the fields of `Bone`. They keep their order, except that parents come before their
        children.
    offset_frame : {"own", "parent"}, default="own"
        Axes in which the offsets are given. "own": a joint's dofs rotate the bone that *ends* at it (ASF). "parent":
        they rotate the bones that *start* at it (BVH).

    Attributes
    ----------
    joint_names : tuple of str
        Names of the joints, without the root.
    dof_names : tuple of str
        One name for each column of an array of poses, such as "lfemur_rx"; columns are in rad, slides in m.
    parents : ndarray of shape (n_joints,)
        Index of each joint's parent, -1 for the root; a parent comes before its children.
    offsets : ndarray of shape (n_joints, 3)
        The bones' offsets, m.
    rest_rotations : ndarray of shape (n_joints, 3, 3)
        The joints' constant rotations.
    limits : ndarray of shape (n_dofs, 2) or None
        Range of each dof, rad or m, infinite without limits; None if no bone has limits.
    weights : ndarray of shape (n_joints,)
        Weight of each joint in distances, see `with_weights`.
    n_joints, n_dofs : int
        Numbers of joints and of dofs.

    Raises
    ------
    ValueError
        For a cycle, an unknown parent, a duplicate name, a number that is not finite, axes or limits that do not fit;
        the message names the bone.

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
        check_choice("offset_frame", self.offset_frame, ("own", "parent"))
        bones = _in_tree_order([check_bone(Bone(*bone)) for bone in self.bones])
        if not any(bone.dofs for bone in bones):
            raise ValueError("a skeleton needs at least one bone with dofs")
        object.__setattr__(self, "bones", bones)
        for name, n in Counter(self.dof_names).items():
            if n > 1:
                raise ValueError(f"two dofs have the name {name!r}, see dof_name of Bone")

    @classmethod
    def chain(cls, n: int) -> "Skeleton":
        """Make a planar arm: n bones of 1 m, each rotating about z at its near end.

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
        """Average skeletons bone by bone, to compare the poses of several people on one skeleton.

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
            If the skeletons differ in more than lengths, directions and limits, or if the directions of a bone at angle
            zero, or two rest rotations of a joint, are more than 45° apart, as in a T-pose and an A-pose.
            `skpose.kinematics.retarget` converts motions to one rest pose.
        """
        skeletons = list(skeletons)
        if not skeletons:
            raise ValueError("the mean skeleton needs at least one skeleton, got none")
        remedy = "skpose.kinematics.retarget(motion, skeletons[0]) converts motions"
        check_comparable(skeletons, [f"skeletons[{i}]" for i in range(len(skeletons))], remedy, remedy)
        first, frame = skeletons[0], skeletons[0].offset_frame
        return cls((mean_bone([skeleton[name] for skeleton in skeletons]) for name in first.joint_names), frame)

    def to_rotvec(self) -> "Skeleton":
        """Replace joints of two or three Euler dofs by ball joints.

        Hinges and rigid joints stay. Ball joints have no limits, so limits of the replaced joints are dropped.

        Returns
        -------
        Skeleton
            With the same bones otherwise; `Motion.to_rotvec` converts poses.

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
        """Replace ball joints by joints with three Euler dofs.

        Parameters
        ----------
        order : str
            Three different letters in the notation of `Bone`: "xyz" is extrinsic, "ZXY" intrinsic.

        Returns
        -------
        Skeleton
            With the same bones otherwise; `Motion.to_euler` converts poses.

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
            raise ValueError(f'order must be three different letters, such as "xyz" or "ZXY", got {order!r}')
        return Skeleton((b._replace(dofs=order) if b.is_ball else b for b in self.bones), self.offset_frame)

    def __getitem__(self, name: str) -> Bone:
        """The bone that ends at a joint: ``skeleton["left_hand"]``."""
        for bone in self.bones:
            if bone.name == name:
                return bone
        raise KeyError(f"the skeleton has no joint {name!r}: {near_names(self.joint_names, str(name))}")

    def __iter__(self) -> Iterator[str]:
        """Yield the names of the joints, as a dictionary its keys: ``"left_hand" in skeleton``."""
        return iter(self.joint_names)

    def __len__(self) -> int:
        return len(self.bones)

    def __array__(self, dtype: object = None, copy: bool | None = None) -> np.ndarray:
        """An array of no dimension that holds the skeleton.

        Without it numpy takes a list of skeletons, as in a grid search, for a table of names.
        """
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
        """Range of each dof, rad, of shape (n_dofs, 2); None if no bone has limits."""
        return None if all(bone.limits is None for bone in self.bones) else _freeze(ranges_of(self.bones))

    @cached_property
    def weights(self) -> np.ndarray:
        """Weight of each joint in distances."""
        generic = np.random.default_rng(0).uniform(-1.0, 1.0, (1, self.n_dofs))
        points = joint_positions(self, generic, Rotation.identity(1))[0, 1:]
        weights = np.ones(self.n_joints)
        for j, bone in enumerate(self.bones):
            near = np.abs(points[:j] - points[j]).max(axis=1, initial=0.0) <= SAME_PLACE
            if bone.weight is not None:
                weights[j] = bone.weight
            elif (weights[:j][near] > 0.0).any():
                weights[j] = 0.0  # joints at one point in every pose count once
        return _freeze(weights)

    def with_weights(self, weights: Mapping[str, float] | ArrayLike | Literal["mass"]) -> "Skeleton":
        r"""Set weights of the joints in distances.

        In every metric except "angle" the position of a joint of weight w counts :math:`\sqrt{w}` times: F(θ) stacks
        :math:`\sqrt{w_j}\, p_j(\theta)`, and "rotation" is :math:`\sqrt{\sum_b w_b \ell_b^2 \varphi_b^2}`, with the
        weight of the joint at the far end of each bone. Joints of weight zero have no effect; if all joints that a bone
        carries have weight zero, its columns of a pose have no effect either, and cost no time.

        Parameters
        ----------
        weights : mapping of str to float, array-like of shape (n_joints,), or "mass"
            A mapping, or a pandas Series indexed by name, sets the weights of some joints; the others keep theirs. An
            array sets one for each of ``skeleton.joint_names``. "mass" gives each joint its share of the mass of a
            person, the mean of women and men of [1]_: each segment is split between its ends such that its centre of
            mass is preserved. Lengths then measure the kinetic energy of a person of 1 kg.

        Returns
        -------
        Skeleton
            With the same bones otherwise.

        Raises
        ------
        ValueError
            For an unknown joint, a weight that is negative or not finite, weights that are all zero; for "mass", if a
            segment of the person is not found.

        Notes
        -----
        By default every joint has weight 1. Among joints always at one point only the first has weight.

        "mass" finds the person as `skpose.kinematics.retarget` does. The trunk, without the pelvis, is spread evenly
        over the length of the spine. The mass at the root is left out, as the root does not
        move.

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
        if isinstance(weights, str):
            check_choice("weights", weights, ("mass",))
            weights = upper_layers.mass_weights(self)
        by_name: dict[Any, Any] = dict(weights.items()) if hasattr(weights, "items") else {}  # of pandas Series too
        if isinstance(weights, Mapping) or any(isinstance(name, str) for name in by_name):
            check_joints(self, by_name, "weights")
            given = [by_name.get(bone.name, bone.weight) for bone in self.bones]
        else:
            array = np.asarray(weights)
            if array.shape != (self.n_joints,):
                raise ValueError(f"weights must have shape ({self.n_joints},), one per joint, got {array.shape}")
            given = list(array)
        bones = tuple(bone._replace(weight=weight) for bone, weight in zip(self.bones, given, strict=True))
        weighted = replace(self, bones=bones)
        if not weighted.weights.any():
            raise ValueError("weights must be positive for at least one joint")
        return weighted

    def select(self, joints: str | Iterable[str] | None = None, *, drop: str | Iterable[str] = ()) -> "Skeleton":
        """Select some joints, with all joints between them and the root.

        Poses of the result lack the columns of the other joints. `Motion.select` and `MotionDataset.select` do the same
        with motions; ``X[:, part.columns_in(skeleton)]`` does it with an array of poses.

        Parameters
        ----------
        joints : str or iterable of str, default=None
            Joints to keep, with all joints between them and the root. None keeps all.
        drop : str or iterable of str, default=()
            Joints to leave out, each with all that it carries.

        Returns
        -------
        Skeleton
            With the kept bones, unchanged, in their order.

        Raises
        ------
        ValueError
            For an unknown joint, or if no joint with dofs is left.

        See Also
        --------
        with_weights : Joints of weight zero have no effect, but keep their columns.

        Examples
        --------
        >>> from skpose.datasets import humanoid
        >>> skeleton = humanoid()
        >>> skeleton.select("left_hand").joint_names
        ('abdomen', 'chest', 'left_clavicle', 'left_upper_arm', 'left_forearm', 'left_hand')
        >>> skeleton.select(drop=["left_pelvis", "right_pelvis"])  # the upper part of the body
        Skeleton(n_joints=12, n_dofs=28)
        """
        kept = set(self.joint_names) if joints is None else set(check_joints(self, joints, "joints"))
        dropped = set(check_joints(self, drop, "drop"))
        for bone in self.bones:
            if bone.parent in dropped:
                dropped.add(bone.name)
        return replace(self, bones=with_carriers(self, kept - dropped))

    def columns_in(self, skeleton: "Skeleton") -> np.ndarray:
        """Find the columns of this skeleton's dofs in poses of a larger one.

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
            If the skeleton lacks one of the dofs.

        Examples
        --------
        >>> from skpose import Skeleton
        >>> arm = Skeleton.chain(3)
        >>> arm.select("joint_2").columns_in(arm)
        array([0, 1])
        """
        index = {name: i for i, name in enumerate(skeleton.dof_names)}
        if not set(self.dof_names) <= index.keys():
            raise ValueError("columns_in needs a skeleton that has all dofs of this one")
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

    def __reduce__(self) -> tuple:
        return Skeleton, (self.bones, self.offset_frame)

    def __deepcopy__(self, memo: dict) -> "Skeleton":
        return self  # immutable; scikit-learn's clone copies every parameter


def _freeze(values: Any, dtype: type = np.float64) -> np.ndarray:
    array: np.ndarray = np.array(values, dtype=dtype)
    array.flags.writeable = False
    return array


def _in_tree_order(bones: Sequence[Bone]) -> tuple[Bone, ...]:
    """The bones, each after its parent, otherwise in the given order."""
    by_name = {bone.name: bone for bone in bones}
    if len(by_name) < len(bones):
        raise ValueError("every bone needs its own name, but some are equal")
    placed: dict[str, Bone] = {}
    for bone in bones:
        chain: dict[str, Bone] = {}
        while bone.name not in placed:
            if bone.name in chain:
                raise ValueError(f"bone {bone.name!r} is a child of itself")
            chain[bone.name] = bone
            if bone.parent is None:
                break
            if bone.parent not in by_name:
                raise ValueError(f"parent {bone.parent!r} of bone {bone.name!r} does not exist; the root is None")
            bone = by_name[bone.parent]
        placed.update(reversed(chain.items()))
    return tuple(placed.values())


def with_carriers(skeleton: Skeleton, names: Iterable[str]) -> tuple[Bone, ...]:
    """The bones of these joints and of all joints between them and the root."""
    kept: set[str | None] = set(names)
    for bone in reversed(skeleton.bones):
        if bone.name in kept:
            kept.add(bone.parent)
    return tuple(bone for bone in skeleton.bones if bone.name in kept)


def check_joints(skeleton: Skeleton, names: str | Iterable[str], parameter: str) -> list[str]:
    """Names of joints as a list; refuse unknown ones."""
    listed = [names] if isinstance(names, str) else list(names)
    for name in listed:
        if name not in skeleton.joint_names:
            near = near_names(skeleton.joint_names, str(name))
            raise ValueError(f"{parameter} has {name!r}, which is not a joint: {near}")
    return listed
