"""Symmetry of a movement: the left against the mirrored right, joint by joint, over the cycle."""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from skpose._utils.typing import DataFrame
from skpose._utils.validation import check_choice, check_kind
from skpose._utils.warnings import warn
from skpose.biomechanics._segments import find_shown
from skpose.kinematics import forward_kinematics
from skpose.kinematics._anatomy import joint_places, rotation_places
from skpose.motions._alignment import joint_rotations
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._interpolation import interpolate_poses
from skpose.skeleton._rest import NO_DIRECTION, degrees_between
from skpose.skeleton._sides import partners

NONE, HALF = "none", "half cycle"
CLOSED = 0.2  # of the farthest distance from the first pose, within which the last pose of a cycle is
# Of a cycle that may be missing or too much, besides half a frame, to which events are rounded. 98 % of the strides of
# CMU's walks pass, as without this limit; 5 % of those without 11 % of a stride, 26 % without it; none without 15 %.
LATE = 0.06
ENDS = 0.04  # of the cycle, at each end, over which its velocity is averaged
MOVING = 0.35  # of the usual speed: what is slower at both ends, as squats are, does not show how late it ends
NEAR = 0.15  # of the motion, tolerance of the lag of the two sides from none or half
BETTER = 0.7  # of the distance without a shift; a lag with less is better
AS_GOOD = 1.3  # times the distance at half a cycle; a lag with less is as good, as in several cycles
EQUAL = 1e-9  # m, of rounding
LAGS = 60  # that are compared

Quantity = Literal["position", "direction", "rotation"]


class JointAsymmetry(NamedTuple):
    """The asymmetry of one joint, and when it is largest; see `SymmetryResult.joint_asymmetries`.

    Attributes
    ----------
    joint : str
        Name of the joint in the skeleton.
    place : str
        Name for readers: for people the place, with the joint's name if that differs, such as "left knee (lfemur)". For
        rotations it is the place of the joint that turns.
    largest : float
        The largest deviation over the cycle, m or degrees.
    mean : float
        The mean over the cycle, m or degrees.
    phase : float
        Where it is largest, % of the cycle.

    Examples
    --------
    >>> from skpose.biomechanics import JointAsymmetry
    >>> JointAsymmetry("left_shank", "left knee (left_shank)", 10.0, 2.0, 50.0).phase
    50.0
    """

    joint: str
    place: str
    largest: float
    mean: float
    phase: float


@dataclass(frozen=True, eq=False, repr=False)
class SymmetryResult:
    """Deviations of each joint from the mirrored joint of the other side.

    Attributes
    ----------
    partners : tuple of str
        The joint that each is compared with; itself on the middle line.
    phases : ndarray of shape (n_frames,)
        Share of the motion, from 0 to 100 %.
    positions : ndarray of shape (n_frames, n_joints)
        Distance between the joint and the mirror image of its partner, the root at the origin
        in its own axes, m.
    directions : ndarray of shape (n_frames, n_joints)
        Angle between the direction of the bone to the joint and the mirrored one of its partner, in the axes of the
        root, degrees; NaN for bones of no length.
    rotations : ndarray of shape (n_frames, n_joints)
        Angle between the rotation of the joint relative to its parent and the mirrored one of its partner, degrees;
        NaN for joints without dofs.
    shift : {"none", "half cycle"}
        Time shift of the other side.
    distances : dict of str to float
        Mean deviation of positions without a shift, "none", and with one of half a cycle, m; NaN for the latter if the
        motion is not a cycle.
    frame_rate : float
        Frame rate of the motion, Hz.
    axis : {"x", "y", "z"}
        The axis across which the motion is mirrored.
    skeleton : Skeleton
        The skeleton of the motion.

    Examples
    --------
    >>> from skpose import Motion
    >>> from skpose.biomechanics import symmetry
    >>> from skpose.datasets import humanoid
    >>> symmetry(Motion(humanoid(), [[0.0] * 42] * 10, frame_rate=10))
    SymmetryResult(10 frames at 10 Hz, 22 joints mirrored across x, shift none, no joint differs)
    """

    partners: tuple[str, ...]
    phases: np.ndarray
    positions: np.ndarray
    directions: np.ndarray
    rotations: np.ndarray
    shift: str
    distances: dict[str, float]
    frame_rate: float
    axis: str
    skeleton: Skeleton

    def __repr__(self) -> str:
        most = self.joint_asymmetries("position")[0]
        differs = f"largest {most.largest:.3g} m at {most.place}" if most.largest > EQUAL else "no joint differs"
        return (
            f"SymmetryResult({len(self.phases)} frames at {self.frame_rate:g} Hz, {len(self.partners)} joints mirrored "
            f"across {self.axis}, shift {self.shift}, {differs})"
        )

    def joint_asymmetries(self, quantity: Quantity = "rotation") -> list[JointAsymmetry]:
        """Rank the joints by their largest deviation.

        Parameters
        ----------
        quantity : {"position", "direction", "rotation"}, default="rotation"
            The deviation. A different rotation of a hip moves knee and foot too; only rotations locate it at the hip.

        Returns
        -------
        list of JointAsymmetry
            One for each joint that has the quantity, the largest deviation first.

        Raises
        ------
        ValueError
            For another quantity.
        """
        check_choice("quantity", quantity, ("position", "direction", "rotation"))
        values = getattr(self, quantity + "s")
        places = rotation_places(self.skeleton) if quantity == "rotation" else joint_places(self.skeleton)
        found = [
            JointAsymmetry(name, place, float(column.max()), float(column.mean()), float(self.phases[column.argmax()]))
            for name, place, column in zip(self.skeleton.joint_names, places, values.T, strict=True)
            if np.isfinite(column).all()
        ]
        return sorted(found, key=lambda one: -one.largest)

    def to_pandas(self) -> DataFrame:
        """Convert the deviations to a pandas DataFrame, one row for each joint and frame.

        Returns
        -------
        pandas.DataFrame
            Columns "joint", "position of", "rotation of", "partner", "phase [%]", "position [m]", "direction [deg]" and
            "rotation [deg]".

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        n_frames, n_joints = self.positions.shape
        import pandas

        return pandas.DataFrame(
            {
                "joint": np.repeat(self.skeleton.joint_names, n_frames),
                "position of": np.repeat(joint_places(self.skeleton), n_frames),
                "rotation of": np.repeat(rotation_places(self.skeleton), n_frames),
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

    Let m be the motion and m' its mirror image, see `Motion.mirrored`. Joint j at phase φ is compared with the same
    joint of m' at φ + s. The shift s is zero for simultaneous movements of both sides, such as squats, and half a cycle
    for alternating ones, such as strides. Time is not warped: a limp, in which one step takes longer, is a deviation.

    Parameters
    ----------
    motion : Motion
        One movement: a squat, or a stride from a contact of a foot to its next, both frames included.
    shift : {"auto", "none", "half cycle"}, default="auto"
        "auto" takes the shift with the smaller deviation, half a cycle only if the motion is a cycle.
    axis : {"x", "y", "z"}, default="x"
        The axis that points to the left or to the right at angle zero, see `Motion.mirrored`.

    Returns
    -------
    SymmetryResult
        Deviations in m and degrees, of each joint at each phase, the shift, and the mean deviations of both shifts.

    Raises
    ------
    TypeError
        If `motion` is not a Motion.
    ValueError
        If `Motion.mirrored` raises it, such as for a side without a partner; for fewer than three frames; with "auto"
        if the sides are most alike at another shift, as in a motion of several cycles; with "half cycle" if the motion
        is not a cycle: its last pose is a fifth of the largest distance from the first, or the velocities at its ends
        show that it ends more than 6 % too early or too late.

    Warns
    -----
    UserWarning
        If the positions to which the motion was fitted do not show all joints in all frames, see `Motion`.

    See Also
    --------
    gait_events : Strides of a walk.
    skpose.motions.segment_repetitions : Repetitions of a movement.
    skpose.motions.mean_motion : The typical repetition, for systematic deviations.

    Notes
    -----
    Positions and directions are in the axes of the root, so that a pelvis that drops on one side is not seen;
    ``symmetry(motion.with_root("tilt"))`` adds its tilt as a joint. A mirrored limb keeps the lengths of its side, so
    that legs of different lengths are not an asymmetry.

    Rotations include twists about bones, which keypoints do not show for a straight limb: use directions there.

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
    >>> result  # doctest: +ELLIPSIS
    SymmetryResult(101 frames at 50 Hz, 22 joints mirrored across x, shift none, largest 0.0822 m at left toe ...)
    >>> most = result.joint_asymmetries("rotation")[0]
    >>> most.place, round(most.largest, 3), most.phase
    ('left knee (left_shank)', 10.0, 50.0)
    """
    check_kind(motion, Motion, "motion", "pass the frames of one movement")
    check_choice("shift", shift, ("auto", NONE, HALF))
    if len(motion) < 3:
        raise ValueError(f"symmetry needs at least 3 frames, got {len(motion)}")
    mirror = motion.mirrored(axis)
    _warn_of_unseen(motion)
    there, image = (forward_kinematics(one.angles, motion.skeleton) for one in (motion, mirror))
    numbers = motion.frame_numbers - motion.frame_numbers[0]
    away = np.sqrt(np.square(there - there[0]).sum(axis=(1, 2)))
    is_closed = bool(away[-1] <= CLOSED * away.max() and abs(_frames_late(there, numbers)) <= LATE * numbers[-1] + 0.5)
    if shift == HALF and not is_closed:
        raise ValueError(f"shift={HALF!r} needs one cycle, motion[start : stop + 1], but the ends are different poses")
    later = numbers + 0.5 * numbers[-1]
    later = np.where(later > numbers[-1], later - numbers[-1], later)  # a cycle begins again
    rows = np.interp(later, numbers, np.arange(len(numbers)))
    by_half = interpolate_poses(motion.skeleton.bones, mirror.angles, rows)
    image_by_half = forward_kinematics(by_half, motion.skeleton)
    distances = {
        NONE: float(np.linalg.norm(there - image, axis=2).mean()),
        HALF: float(np.linalg.norm(there - image_by_half, axis=2).mean()) if is_closed else np.nan,
    }
    chosen: str = shift
    if shift == "auto":
        chosen = HALF if distances[HALF] < distances[NONE] - EQUAL else NONE
        _check_lag(there, image, is_closed, distances, chosen)
    others, its_angles = (image, mirror.angles) if chosen == NONE else (image_by_half, by_half)
    skeleton = motion.skeleton
    directions = degrees_between(_bones(there, skeleton), _bones(others, skeleton))
    directions[:, np.linalg.norm(skeleton.offsets, axis=1) <= NO_DIRECTION] = np.nan
    return SymmetryResult(
        partners=tuple(skeleton.joint_names[k] for k in partners(skeleton.joint_names)),
        phases=100.0 * numbers / numbers[-1],
        positions=np.linalg.norm(there - others, axis=2),
        directions=directions,
        rotations=np.degrees(joint_rotations(motion.angles, its_angles, skeleton)),
        shift=chosen,
        distances=distances,
        frame_rate=motion.frame_rate,
        axis=axis,
        skeleton=skeleton,
    )


def _warn_of_unseen(motion: Motion) -> None:
    """Warn about joints whose positions are not known in all frames."""
    shown = find_shown(motion, range(motion.skeleton.n_joints)).all(axis=0)
    if not shown.all():
        names = np.array(motion.skeleton.joint_names)[~shown]
        warn(
            f"positions of {', '.join(names[:5])}{' and more' * (len(names) > 5)} are not seen in all frames, so their "
            "asymmetry is a guess: leave them out with select"
        )


def _frames_late(positions: np.ndarray, numbers: np.ndarray) -> float:
    """The number of frames between the first pose and the last, by the velocity at both ends; 0 if slow."""
    few = max(1, round(ENDS * len(positions)))
    span = numbers[few] + numbers[-1] - numbers[-1 - few]
    velocity = (positions[few] - positions[0] + positions[-1] - positions[-1 - few]) / span
    steps = np.diff(positions, axis=0) / np.diff(numbers)[:, None, None]
    usual = np.median(np.sqrt(np.square(steps).sum(axis=(1, 2))))
    speed = np.sqrt(np.square(velocity).sum())
    if speed <= MOVING * usual:
        return 0.0
    return float(((positions[-1] - positions[0]) * velocity).sum() / speed**2)


def _check_lag(there: np.ndarray, image: np.ndarray, is_closed: bool, distances: dict[str, float], shift: str) -> None:
    """Refuse a motion whose sides do the same at another lag than none and half: no cycle, or several."""
    n = len(there)
    lags = np.unique(np.linspace(0, n - 1 if is_closed else n // 2, LAGS).astype(int))
    lags = lags[(lags > NEAR * n) & ~(is_closed & (np.abs(lags - n / 2) < NEAR * n)) & (lags < (1 - NEAR) * n)]
    shifts = [(lag, np.roll(image[:-1], -lag, axis=0) if is_closed else image[lag:]) for lag in lags.tolist()]
    means = [(np.linalg.norm(there[: len(other)] - other, axis=2).mean(), lag) for lag, other in shifts]
    nearest, best = min(means, default=(np.inf, 0))
    as_good = shift == NONE or nearest < AS_GOOD * distances[HALF]
    if as_good and nearest < BETTER * distances[NONE] - EQUAL:
        raise ValueError(
            f"the sides are alike {best} frames apart, so it is not one cycle: cut it, or pass shift={NONE!r}"
        )


def _bones(positions: np.ndarray, skeleton: Skeleton) -> np.ndarray:
    """The vectors (n, n_joints, 3) from the parents to the joints."""
    padded = np.concatenate([positions, np.zeros_like(positions[:, :1])], axis=1)
    return positions - padded[:, skeleton.parents]
