"""Weights of the joints in distances: those of the bones, and those that are meant where there are none."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from skpose.skeleton._mass import mass_weights
from skpose.skeleton._selection import checked_names

if TYPE_CHECKING:
    from skpose.skeleton._skeleton import Skeleton

ROOT = -1
SAME_PLACE = 1e-9  # m; files that print nine digits leave this much between joints in one place


def with_weights(skeleton: "Skeleton", weights: Mapping[str, float] | ArrayLike | Literal["mass"]) -> "Skeleton":
    r"""Return the skeleton with weights of its joints in distances.

    In every metric but "angle" the position of a joint of weight w counts :math:`\sqrt{w}` times: F(θ) stacks
    :math:`\sqrt{w_j}\, p_j(\theta)`, and "rotation" has :math:`\sqrt{\sum_b w_b \ell_b^2 \varphi_b^2}`, the weight of
    a bone being that of the joint at its far end. Joints of weight zero are not seen. What carries none but such joints
    costs no time, and its columns of a pose have no effect.

    Parameters
    ----------
    weights : mapping of str to float, array-like of shape (n_joints,), or "mass"
        A mapping, or a series of pandas whose index has names, gives weights to the joints that it names, and the
        others keep theirs. An array gives one to each of ``skeleton.joint_names``. "mass" gives each joint its share of
        the mass of a person, after the mean of the women and men of [1]_: of each segment as much to either end as puts
        the centre of mass where it is. Lengths are then those of the kinetic energy of these masses, for a person of
        1 kg.

    Returns
    -------
    Skeleton
        With the same bones otherwise; its `weights` are the weights.

    Raises
    ------
    ValueError
        For a name that no joint has, a weight that is negative or not finite, weights that are all zero; for "mass",
        if a segment of the person is not found by the names of the joints.

    Notes
    -----
    Without weights every joint counts 1, but joints that always stand in one place count once: one of them has weight 1
    and the others 0.

    "mass" finds thighs, shanks, feet, upper arms, forearms, hands and the head by name. The trunk, without the pelvis,
    is spread evenly over the length of the spine. What belongs to the root is left out, as the root does not move.

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
        if weights != "mass":
            raise ValueError(f'weights must be a mapping, an array or "mass", got {weights!r}')
        weights = mass_weights(skeleton)
    weights = _by_name(weights)
    if isinstance(weights, Mapping):
        checked_names(skeleton, weights, "weights")
        given = [weights.get(bone.name, bone.weight) for bone in skeleton.bones]
    else:
        array = np.asarray(weights)
        if array.shape != (skeleton.n_joints,):
            got = weights if array.ndim == 0 else f"an array of shape {array.shape}"
            raise ValueError(
                f"weights must have one number for each of the {skeleton.n_joints} joints in skeleton.joint_names, got "
                f"{got}"
            )
        given = list(array)
    found = replace(skeleton, bones=tuple(b._replace(weight=w) for b, w in zip(skeleton.bones, given, strict=True)))
    if not found.weights.any():
        raise ValueError("weights must be positive for at least one joint, but all are zero")
    return found


def _by_name(weights: Any) -> Any:
    """Return a series with names in its index as a mapping, anything else as it is."""
    labels = getattr(weights, "index", None)
    named = getattr(weights, "ndim", None) == 1 and labels is not None and any(isinstance(one, str) for one in labels)
    return dict(weights.items()) if named else weights


def joint_weights(skeleton: "Skeleton") -> np.ndarray:
    """Return the weights (n_joints,) of the joints; joints in one place count once where none is given."""
    weights = np.ones(skeleton.n_joints)
    taken = set()
    for j, (bone, place) in enumerate(zip(skeleton.bones, _places(skeleton), strict=True)):
        if bone.weight is not None:
            weights[j] = bone.weight
        elif place in taken:
            weights[j] = 0.0
        if weights[j] > 0.0:
            taken.add(place)
    return weights


def _places(skeleton: "Skeleton") -> list[tuple]:
    """Return for each joint a key that is the same for all joints that stand in one place in every pose."""
    axes = [ROOT]  # of the root, then of each joint: the joint whose dofs rotate it, itself or the nearest one above
    to_axes = [np.eye(3)]  # from the joint's own axes to these
    places: list[tuple[int, np.ndarray]] = [(ROOT, np.zeros(3))]  # axes, and coordinates in them
    centres: dict[int, tuple] = {}  # the places about which axes rotate
    found: dict[int, list[np.ndarray]] = {}  # coordinates of the places in each joint's axes

    def key(place: tuple[int, np.ndarray]) -> tuple:
        frame, numbers = place
        if frame != ROOT and _is_near(numbers, np.zeros(3)):
            return centres[frame]
        known = found.setdefault(frame, [])
        number = next((i for i, one in enumerate(known) if _is_near(numbers, one)), len(known))
        if number == len(known):
            known.append(numbers)
        return frame, number

    for j, (bone, parent) in enumerate(zip(skeleton.bones, skeleton.parents + 1, strict=True)):
        axes.append(j if bone.dofs else axes[parent])
        to_axes.append(np.eye(3) if bone.dofs else to_axes[parent] @ skeleton.rest_rotations[j])
        carrier = j + 1 if skeleton.offset_frame == "own" else parent
        frame, start = axes[carrier], places[parent]
        if skeleton.offsets[j].any():
            before = start[1] if start[0] == frame else np.zeros(3)
            centres.setdefault(frame, key(start))
            places.append((frame, before + to_axes[carrier] @ skeleton.offsets[j]))
        else:
            places.append(start)
    return [key(place) for place in places[1:]]


def _is_near(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(np.abs(a - b).max() <= SAME_PLACE)
