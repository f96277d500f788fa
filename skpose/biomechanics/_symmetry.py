"""Symmetry of a movement: the left against the mirrored right, joint by joint, over the cycle."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from skpose._validation.options import check_choice, check_kind
from skpose._warnings import warn
from skpose.biomechanics._seen import find_shown
from skpose.biomechanics._tables import frame_of
from skpose.kinematics import forward_kinematics
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import NO_DIRECTION, interpolate_poses, partners, rotations_of

if TYPE_CHECKING:
    import pandas

NONE, HALF = "none", "half cycle"
CLOSED = 0.2  # of the farthest distance from the first pose, within which the last pose of a cycle is
# Of a cycle: by how much it may be too short or too long, as its poses move at both ends, and half a frame, to which
# events are rounded. Of the strides from contact to contact in CMU's walks 98 % pass, as without this limit; of those
# that lack 11 % of a stride 5 %, and 26 % without it; that lack 15 % none.
LATE = 0.06
ENDS = 0.04  # of the cycle, at each end, over which its velocity is averaged
MOVING = 0.35  # of the usual speed: what is slower at both ends, as squats are, does not show how late it ends
NEAR = 0.15  # of the motion, by which the lag of the two sides may differ from none or half
BETTER = 0.7  # of the distance without a shift, below which another lag is the better one
AS_GOOD = 1.3  # times the distance at half a cycle, below which another lag is as good: that of several cycles
EQUAL = 1e-9  # m, of rounding
LAGS = 60  # that are compared
MOST_NAMES = 5  # of joints in a message

Quantity = Literal["position", "direction", "rotation"]


class JointAsymmetry(NamedTuple):
    """The asymmetry of one joint, and when it is largest; see `SymmetryResult.joint_asymmetries`.

    Attributes
    ----------
    joint : str
        Name of the joint.
    largest : float
        The largest deviation over the cycle, m or degrees.
    mean : float
        The mean over the cycle, m or degrees.
    phase : float
        Where it is largest, % of the cycle.

    Examples
    --------
    >>> from skpose.biomechanics import JointAsymmetry
    >>> JointAsymmetry("left_shank", 10.0, 2.0, 50.0).phase
    50.0
    """

    joint: str
    largest: float
    mean: float
    phase: float


@dataclass(frozen=True, eq=False, repr=False)
class SymmetryResult:
    """Deviations of each joint from the mirrored joint of the other side, as `symmetry` finds them.

    Attributes
    ----------
    joints : tuple of str
        The joints, ``skeleton.joint_names``.
    partners : tuple of str
        The joint that each is compared with; itself on the middle line.
    phases : ndarray of shape (n_frames,)
        Share of the motion, from 0 to 100 %.
    positions : ndarray of shape (n_frames, n_joints)
        Distance between the position of the joint and the mirror image of that of its partner, the root at the origin
        in its own axes, m.
    directions : ndarray of shape (n_frames, n_joints)
        Angle between the direction of the bone to the joint and the mirrored one of its partner, in the axes of the
        root, degrees; NaN for bones of no length.
    rotations : ndarray of shape (n_frames, n_joints)
        Angle between the rotation of the joint relative to its parent and the mirrored one of its partner, degrees;
        NaN for joints without dofs.
    shift : {"none", "half cycle"}
        How much later the other side does the same.
    distances : dict of str to float
        Mean deviation of positions without a shift, "none", and with one of half a cycle, m; NaN for the latter where
        the motion is no cycle.
    frame_rate : float
        Frame rate of the motion, Hz.
    axis : {"x", "y", "z"}
        The axis across which the motion is mirrored.

    Examples
    --------
    >>> from skpose import Motion
    >>> from skpose.biomechanics import symmetry
    >>> from skpose.datasets import humanoid
    >>> symmetry(Motion(humanoid(), [[0.0] * 42] * 10, frame_rate=10))
    SymmetryResult(10 frames at 10 Hz, 22 joints mirrored across x, shift none, no joint differs)
    """

    joints: tuple[str, ...]
    partners: tuple[str, ...]
    phases: np.ndarray
    positions: np.ndarray
    directions: np.ndarray
    rotations: np.ndarray
    shift: str
    distances: dict[str, float]
    frame_rate: float
    axis: str

    def __repr__(self) -> str:
        most = self.joint_asymmetries("position")[0]
        differs = "no joint differs"
        if most.largest > EQUAL:
            differs = f"{most.joint} differs most: by {most.largest:.3g} m at {most.phase:.0f} %"
        other = HALF if self.shift == NONE else NONE
        means = ""
        if np.isfinite(self.distances[other]) and max(self.distances.values()) > EQUAL:
            means = f" (mean {self.distances[self.shift]:.2g} m, shift {other} {self.distances[other]:.2g} m)"
        return (
            f"SymmetryResult({len(self.phases)} frames at {self.frame_rate:g} Hz, {len(self.joints)} joints mirrored "
            f"across {self.axis}, shift {self.shift}{means}, {differs})"
        )

    def joint_asymmetries(self, quantity: Quantity = "rotation") -> list[JointAsymmetry]:
        """Return which joint differs from the other side, when, and by how much.

        Parameters
        ----------
        quantity : {"position", "direction", "rotation"}, default="rotation"
            Which deviation. A hip that rotates otherwise moves knee and foot too; its rotation alone shows the hip.

        Returns
        -------
        list of JointAsymmetry
            One for each joint that has the quantity, that of the largest deviation first.

        Raises
        ------
        ValueError
            For another quantity.
        """
        check_choice("quantity", quantity, ("position", "direction", "rotation"))
        values = getattr(self, quantity + "s")
        found = [
            JointAsymmetry(name, float(column.max()), float(column.mean()), float(self.phases[column.argmax()]))
            for name, column in zip(self.joints, values.T, strict=True)
            if np.isfinite(column).all()
        ]
        return sorted(found, key=lambda one: -one.largest)

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the deviations as a pandas DataFrame, one row for each joint and frame.

        Returns
        -------
        pandas.DataFrame
            Columns "joint", "partner", "phase [%]", "position [m]", "direction [deg]" and "rotation [deg]".

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        n_frames, n_joints = self.positions.shape
        return frame_of(
            {
                "joint": np.repeat(self.joints, n_frames),
                "partner": np.repeat(self.partners, n_frames),
                "phase [%]": np.tile(self.phases, n_joints),
                "position [m]": self.positions.T.ravel(),
                "direction [deg]": self.directions.T.ravel(),
                "rotation [deg]": self.rotations.T.ravel(),
            }
        )


def symmetry(
    motion: Motion,
    *,
    shift: Literal["auto", "none", "half cycle"] = "auto",
    axis: Literal["x", "y", "z"] = "x",
) -> SymmetryResult:
    r"""Compare the left with the mirrored right, joint by joint, over one cycle of a movement.

    With m the motion and m' its mirror image, see `Motion.mirrored`, joint j at phase φ is compared with the same joint
    of m' at φ + s. The shift s is none for movements that both sides do at once, such as squats, and half a cycle for
    those that they do in turn, such as strides. Time is not warped: a limp, in which one step takes longer, is a
    deviation.

    Parameters
    ----------
    motion : Motion
        One movement with its first and last frame: a squat, or a stride from a contact of a foot to its next, both
        included.
    shift : {"auto", "none", "half cycle"}, default="auto"
        "auto" takes the shift at which the two sides differ less, half a cycle only if the motion ends about where it
        begins.
    axis : {"x", "y", "z"}, default="x"
        The axis that points to the left or to the right at angle zero, see `Motion.mirrored`.

    Returns
    -------
    SymmetryResult
        Deviations in m and degrees, of each joint at each phase, the shift, and how far both shifts are.

    Raises
    ------
    TypeError
        If `motion` is no Motion.
    ValueError
        For what `Motion.mirrored` refuses, such as a side without a partner; for fewer than three frames; with "auto"
        if the sides resemble each other most at a time that is neither none nor half of the motion, which then is no
        cycle or several; with "half cycle" if the motion is no cycle: if it ends elsewhere than it begins, by a fifth
        of its farthest pose, or by the velocity at both ends more than 6 % of its length before or after its first one.

    Warns
    -----
    UserWarning
        If positions to which the motion was fitted do not show all joints in all frames, see `Motion`.

    See Also
    --------
    gait_events : Strides of a walk.
    skpose.motions.segment_repetitions : Repetitions of a movement.
    skpose.motions.mean_motion : The typical repetition, of which the deviations are systematic.

    Notes
    -----
    The root is no part of it: positions and directions are in its axes, so that a pelvis that drops on one side is
    not seen. ``symmetry(motion.with_root("tilt"))`` makes its tilt a joint as others. A mirrored limb keeps the lengths
    of its side, so that legs of different lengths are no asymmetry.

    Directions are shown by positions alone. Rotations have twists about bones too, which poses that were fitted to
    positions of keypoints do not show where a limb is straight: use directions there.

    Time and memory O(frames · joints), and once that many for each of 60 lags.

    Examples
    --------
    A squat in which the left knee bends by 10° more at the lowest point:

    >>> import numpy as np
    >>> from skpose import Motion
    >>> from skpose.biomechanics import symmetry
    >>> from skpose.datasets import humanoid
    >>> person = humanoid()
    >>> depth = np.sin(np.linspace(0, np.pi, 101)) ** 2
    >>> angles = np.zeros((101, person.n_dofs))
    >>> for name, degrees in {"thigh_rx": -80, "shank_rx": 100, "foot_rx": -20}.items():
    ...     for side in ("left", "right"):
    ...         angles[:, person.dof_names.index(f"{side}_{name}")] = np.radians(degrees) * depth
    >>> angles[:, person.dof_names.index("left_shank_rx")] += np.radians(10) * depth
    >>> result = symmetry(Motion(person, angles, frame_rate=50))
    >>> result  # doctest: +NORMALIZE_WHITESPACE
    SymmetryResult(101 frames at 50 Hz, 22 joints mirrored across x, shift none (mean 0.011 m, shift half cycle 0.11 m),
                   left_toes differs most: by 0.0822 m at 50 %)
    >>> most = result.joint_asymmetries("rotation")[0]
    >>> most.joint, round(most.largest, 3), most.phase
    ('left_shank', 10.0, 50.0)
    """
    check_kind(motion, Motion, "motion", "the frames of one movement, with the skeleton that has left and right")
    check_choice("shift", shift, ("auto", NONE, HALF))
    if len(motion) < 3:
        raise ValueError(f"symmetry compares the frames of a movement and needs at least 3, got {len(motion)}")
    mirror = motion.mirrored(axis)
    _warn_of_unseen(motion)
    there, image = (forward_kinematics(one.angles, motion.skeleton) for one in (motion, mirror))
    numbers = motion.frame_numbers - motion.frame_numbers[0]
    opening = _find_opening(there, numbers, motion.frame_rate)
    is_closed = not opening
    if shift == HALF and not is_closed:
        raise ValueError(f'shift="half cycle" needs a cycle, whose last pose is about its first one, but {opening}')
    by_half = interpolate_poses(motion.skeleton.bones, mirror.angles, _rows_after(numbers, 0.5))
    image_by_half = forward_kinematics(by_half, motion.skeleton)
    distances = {
        NONE: float(_distances(there, image).mean()),
        HALF: float(_distances(there, image_by_half).mean()) if is_closed else np.nan,
    }
    chosen: str = shift
    if shift == "auto":
        chosen = HALF if distances[HALF] < distances[NONE] - EQUAL else NONE
        _check_lag(there, image, opening, distances, chosen, motion)
    others, its_angles = (image, mirror.angles) if chosen == NONE else (image_by_half, by_half)
    skeleton = motion.skeleton
    return SymmetryResult(
        joints=skeleton.joint_names,
        partners=tuple(skeleton.joint_names[k] for k in partners(skeleton.joint_names)),
        phases=100.0 * numbers / numbers[-1],
        positions=_distances(there, others),
        directions=_angles_between(_bones(there, skeleton), _bones(others, skeleton), skeleton),
        rotations=_rotations_between(motion.angles, its_angles, skeleton),
        shift=chosen,
        distances=distances,
        frame_rate=motion.frame_rate,
        axis=axis,
    )


def _warn_of_unseen(motion: Motion) -> None:
    """Warn of joints whose positions are not known in all frames: what they are compared with is a guess."""
    names = motion.skeleton.joint_names
    frames = (~find_shown(motion, range(len(names)))).sum(axis=0)
    if frames.any():
        unseen = [f"{name} in {n}" for name, n in zip(names, frames, strict=True) if n]
        more = f" and {len(unseen) - MOST_NAMES} more joints" if len(unseen) > MOST_NAMES else ""
        warn(
            f"positions are not seen in some of the {len(motion)} frames: of {', '.join(unseen[:MOST_NAMES])}{more}. "
            "There the fit has a pose that nobody measured, and what symmetry finds of these joints, of their partners "
            "and of the mean rests on it: leave them out, motion.select(drop=...), or choose frames that show them"
        )


def _rows_after(numbers: np.ndarray, share: float) -> np.ndarray:
    """Return the rows, not whole, of each frame's time and a share of the motion, which goes round."""
    later = numbers + share * numbers[-1]
    later = np.where(later > numbers[-1], later - numbers[-1], later)
    return np.interp(later, numbers, np.arange(len(numbers)))


def _find_opening(positions: np.ndarray, numbers: np.ndarray, frame_rate: float) -> str:
    """Return in words why a motion is no cycle, whose last pose is about its first one; empty if it is."""
    remedy = "cut it from an event to the next one of its kind, both frames included, motion[start : stop + 1]"
    away = np.sqrt(np.square(positions - positions[0]).sum(axis=(1, 2)))
    if away[-1] > CLOSED * away.max():
        return f"the motion ends elsewhere than it begins: {remedy}"
    late = _frames_late(positions, numbers)
    if abs(late) > LATE * numbers[-1] + 0.5:
        when = "after" if late > 0.0 else "before"
        return f"the motion ends {abs(late) / frame_rate:.2g} s {when} it is at its first pose again: {remedy}"
    return ""


def _frames_late(positions: np.ndarray, numbers: np.ndarray) -> float:
    """Return by how many frames the last pose is behind the first one, by the velocity at both ends; 0 if slow."""
    few = max(1, round(ENDS * len(positions)))
    span = numbers[few] + numbers[-1] - numbers[-1 - few]
    velocity = (positions[few] - positions[0] + positions[-1] - positions[-1 - few]) / span
    steps = np.diff(positions, axis=0) / np.diff(numbers)[:, None, None]
    usual = np.median(np.sqrt(np.square(steps).sum(axis=(1, 2))))
    speed = np.sqrt(np.square(velocity).sum())
    if speed <= MOVING * usual:
        return 0.0
    return float(((positions[-1] - positions[0]) * velocity).sum() / speed**2)


def _distances(positions: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return distances (n, n_joints), m."""
    return np.linalg.norm(positions - others, axis=2)


def _check_lag(
    there: np.ndarray, image: np.ndarray, opening: str, distances: dict[str, float], shift: str, motion: Motion
) -> None:
    """Refuse a motion in which the sides do the same at another lag than none and half: no cycle, or several."""
    n, is_closed = len(there), not opening
    lags = np.unique(np.linspace(0, n - 1 if is_closed else n // 2, LAGS).astype(int))
    lags = lags[(lags > NEAR * n) & ~(is_closed & (np.abs(lags - n / 2) < NEAR * n)) & (lags < (1 - NEAR) * n)]
    best, nearest = 0, np.inf
    for lag in lags.tolist():
        shifted = np.roll(image[:-1], -lag, axis=0) if is_closed else image[lag:]
        mean = float(_distances(there[: len(shifted)], shifted).mean())
        if mean < nearest:
            best, nearest = lag, mean
    as_good = shift == NONE or nearest < AS_GOOD * distances[HALF]
    if as_good and nearest < BETTER * distances[NONE] - EQUAL:
        seconds, whole = best / motion.frame_rate, (n - 1) / motion.frame_rate
        words = (
            f"the other side does the same {seconds:.2g} s later (mean deviation {nearest:.2g} m, against "
            f"{distances[NONE]:.2g} m at once), which is"
        )
        if opening and abs(best - n / 2) < NEAR * n:
            raise ValueError(f"{words} about half of the motion of {whole:.2g} s, but {opening}")
        raise ValueError(
            f"{words} neither none nor half of the motion of {whole:.2g} s: symmetry needs one cycle, such as "
            'motion[start : stop + 1] from a contact of a foot to its next, or shift="none" for what both sides do at '
            "once"
        )


def _bones(positions: np.ndarray, skeleton: Skeleton) -> np.ndarray:
    """Return the vectors (n, n_joints, 3) from the parents to the joints."""
    padded = np.concatenate([positions, np.zeros_like(positions[:, :1])], axis=1)
    return positions - padded[:, skeleton.parents]


def _angles_between(a: np.ndarray, b: np.ndarray, skeleton: Skeleton) -> np.ndarray:
    """Return the angles (n, n_joints) between bones, degrees; NaN for those of no length."""
    sine, cosine = np.linalg.norm(np.cross(a, b), axis=2), (a * b).sum(axis=2)
    angles = np.degrees(np.arctan2(sine, cosine))
    angles[:, np.linalg.norm(skeleton.offsets, axis=1) <= NO_DIRECTION] = np.nan
    return angles


def _rotations_between(a: np.ndarray, b: np.ndarray, skeleton: Skeleton) -> np.ndarray:
    """Return the angles (n, n_joints) between rotations relative to parents, degrees; NaN without dofs."""
    angles, first = np.full((len(a), skeleton.n_joints), np.nan), 0
    for j, bone in enumerate(skeleton.bones):
        columns, first = slice(first, first + bone.n_dofs), first + bone.n_dofs
        if bone.dofs:
            here, there = (rotations_of(bone, poses[:, columns]) for poses in (a, b))
            angles[:, j] = np.degrees((here.inv() * there).magnitude())
    return angles
