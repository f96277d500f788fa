"""Scores of motion without a truth: feet that skate, float or sink, and jerk. They measure what a viewer sees as wrong.

The foot that stands is the slower one of those near the floor. A foot has two points, the ankle and
the ball or else the toe, each with its own height above the floor while it stands, so that a foot that rolls from the
heel to the toe stands all the time.
"""

from collections.abc import Sequence
from numbers import Real
from typing import Any, NamedTuple

import numpy as np
from scipy.ndimage import minimum_filter1d, uniform_filter1d

from skpose._utils.sklearn import Interval, StrOptions, validate_params
from skpose._utils.units import extent_of
from skpose.keypoints import Keypoints
from skpose.kinematics._anatomy import ANKLE, BALL, SIDES, TOE, find_anatomy
from skpose.kinematics._ground import speeds_of
from skpose.skeleton import Motion

Recording = Motion | Keypoints
Feet = Sequence[Sequence[str]]

TALL = 1.7  # m, of a person to whom heights and speeds apply
LOW = 0.03  # m above its floor; higher points of a foot do not stand
UPRIGHT = 0.7  # of the largest extent: the height of the body while it stands
STRIDE = 0.6  # s in which a foot stands: the floor is the median of the lowest points in as long a time
WINDOW = 0.05  # s before and after a frame over which its speed is measured: a frame at 20 Hz
GMD_RATE, GMD_LOW, GMD_SPEED, GMD_WINDOW = 20.0, 0.05, 0.5, 5  # Hz, m, m/s, frames
AMONG = 0.005  # m, the tolerance of PhysDiff
CONSTRAINTS: dict[str, list] = {
    "motion": [Motion, Keypoints],
    "feet": ["array-like", None],
    "floor": [Interval(Real, None, None, closed="neither"), None],
    "average": [StrOptions(["feet"]), None],
}


class Soles(NamedTuple):
    """Points of both feet in time, up last."""

    points: np.ndarray  # (n_frames, 2, n_parts, 3) m
    heights: np.ndarray  # (n_frames, 2, n_parts) above the floor of each part, m
    floors: np.ndarray  # (n_parts,) the heights at which they stand, m


def soles_of(motion: Recording, feet: Feet | None = None, floor: float | None = None) -> Soles:
    """Ankles and balls of both feet, as far as both sides have them, or the points that are given."""
    if isinstance(motion, Motion) and len(motion) > 1 and not np.ptp(motion.root_positions, axis=0).any():
        raise ValueError("motion must have a root that moves over the floor, got constant root_positions")
    positions = motion.positions() if isinstance(motion, Motion) else motion.positions
    names = motion.skeleton.joint_names if isinstance(motion, Motion) else motion.names
    if feet is not None:
        if len(feet) != 2 or len(feet[0]) != len(feet[1]) or not {*feet[0], *feet[1]} <= {*names}:
            raise ValueError(f"feet must be as many names of points of the left as of the right foot, got {feet!r}")
        columns = [[names.index(name) for name in side] for side in feet]
    else:
        marks = find_anatomy(motion.skeleton).joints if isinstance(motion, Motion) else {}
        parts = [part for part in (ANKLE, BALL, TOE) if all(f"{side}_{part}" in marks for side in SIDES)]
        if not parts:
            raise ValueError("motion must have the joints of two feet: pass their names as feet=")
        parts = [part for part in parts if part != TOE or BALL not in parts]  # a rigid toe dips into the floor
        columns = [[marks[f"{side}_{part}"] for part in parts] for side in SIDES]
    points = positions[:, columns][..., [("xyz".index(motion.up) + i) % 3 for i in (1, 2, 3)]]
    if floor is None:
        heights = np.ptp(positions[..., "xyz".index(motion.up)], axis=1)
        stands = heights > UPRIGHT * (extent_of(positions) or TALL)
        lowest = np.nanmin(points[stands if stands.any() else ~stands][..., 2], axis=1)
        floors = np.median(minimum_filter1d(lowest, max(1, round(STRIDE * motion.frame_rate)), axis=0), axis=0)
    else:
        floors = np.full(len(columns[0]), float(floor))
    return Soles(points, points[..., 2] - floors, floors)


def slips_of(soles: Soles, times: np.ndarray) -> np.ndarray:
    """Speed along the floor (n_frames, 2), m/s, of the slowest point of each foot near it; infinite in the air."""
    speeds = speeds_of(soles.points[..., :2], times, WINDOW)
    return np.where(soles.heights < LOW, speeds, np.inf).min(axis=2)


@validate_params(CONSTRAINTS | {"rule": [StrOptions(["slip", "gmd"])]}, prefer_skip_nested_validation=True)
def foot_skating(
    motion: Recording,
    *,
    rule: str = "slip",
    feet: Feet | None = None,
    floor: float | None = None,
    average: str | None = "feet",
) -> Any:
    r"""How much the feet slide while they stand: speed of the standing foot, or share of the frames that skate.

    "slip" is the mean speed along the floor of the foot that stands, m/s: in each frame the slowest point of both feet
    among those within 3 cm of the floor. Speeds are measured over 0.1 s, so that the result hardly depends on the frame
    rate. "gmd" is the skating ratio of Guided Motion Diffusion [1]_: the share of the steps from frame to frame in
    which a foot is below 5 cm before and after and moves along the floor by more than 2.5 cm, that is 0.5 m/s at 20 Hz,
    also in the mean over five steps.

    Parameters
    ----------
    motion : Motion or Keypoints
        The motion, with the positions of the root, m. "gmd" interpolates it linearly to 20 Hz, the rate of its
        definition.
    rule : {"slip", "gmd"}, default="slip"
        What is measured.
    feet : two sequences of str, default=None
        Names of the points of the left and of the right foot, in the same order, the ankle first. None finds the ankle
        and the ball of a Motion, or else the toe. "gmd" takes the second of them.
    floor : float, default=None
        Height of the floor, m. None is where each point of the feet stands; for "gmd" the lowest point of all frames,
        as in HumanML3D.
    average : {"feet"} or None, default="feet"
        Whether both feet are one. None: an array of the left and the right foot. A foot that never stands has NaN.

    Returns
    -------
    float or ndarray of shape (2,)
        Speed, m/s, or share of steps.

    Raises
    ------
    TypeError
        If `motion` is neither a `Motion` nor `Keypoints`.
    ValueError
        If feet are not found, the root never moves, or the motion has fewer than two frames.

    See Also
    --------
    skpose.checks.check_motion : Where feet skate.

    Notes
    -----
    "gmd" counts the toes of a swinging foot that pass low above the floor, so that it is not zero for real recordings:
    in 235 recordings of CMU and HDM05 0.02 on average, in walks 0.01, at most 0.4. "slip" is 0.09 m/s in walks, 0.05
    m/s in other motions, and 0.6 m/s in runs, whose feet are low and fast before they leave the floor.

    References
    ----------
    .. [1] K. Karunratanakul, K. Preechakul, S. Suwajanakorn, S. Tang, "Guided Motion Diffusion for controllable human
       motion synthesis", ICCV 2023, :doi:`10.1109/ICCV51070.2023.00205`.

    Examples
    --------
    Both feet slide sideways at 0.2 m/s:

    >>> import numpy as np
    >>> from skpose import Motion
    >>> from skpose.datasets import humanoid
    >>> from skpose.scores import foot_skating
    >>> path = np.linspace([0.0, 0.0, 0.0], [0.4, 0.0, 0.0], 61)
    >>> slide = Motion(humanoid(), np.zeros((61, 42)), 30, path)
    >>> round(foot_skating(slide), 3), foot_skating(slide, rule="gmd")
    (0.2, 0.0)
    """
    if len(motion) < 2:
        raise ValueError(f"motion must have at least two frames, got {len(motion)}")
    if rule == "gmd":
        return _skating_ratio(motion, feet, floor, average)
    slips = slips_of(soles_of(motion, feet, floor), motion.times)
    stands = np.isfinite(slips) & (slips == slips.min(axis=1, keepdims=True))
    both = slips.min(axis=1)
    if average:
        return float(both[np.isfinite(both)].mean()) if np.isfinite(both).any() else np.nan
    return np.array(
        [slip[stood].mean() if stood.any() else np.nan for slip, stood in zip(slips.T, stands.T, strict=True)]
    )


def _skating_ratio(motion: Recording, feet: Feet | None, floor: float | None, average: str | None) -> Any:
    """The rule "gmd"."""
    positions = motion.positions() if isinstance(motion, Motion) else motion.positions
    soles = soles_of(motion, feet, float(np.nanmin(positions[..., "xyz".index(motion.up)])) if floor is None else floor)
    times = np.arange(motion.times[0], motion.times[-1] + 1e-9, 1.0 / GMD_RATE)
    ball = min(1, soles.points.shape[2] - 1)
    tracks = soles.points[:, :, ball].reshape(len(motion), -1).T
    if np.isnan(tracks).any():
        raise ValueError("motion must have the balls of both feet in all frames for this rule")
    balls = np.stack([np.interp(times, motion.times, track) for track in tracks], axis=1).reshape(-1, 2, 3)
    if len(balls) < 2:
        raise ValueError(f"motion must have at least two frames at 20 Hz, got {len(balls)}")
    low = balls[..., 2] - soles.floors[ball] < GMD_LOW
    speeds = np.linalg.norm(np.diff(balls[..., :2], axis=0), axis=2) * GMD_RATE
    means = uniform_filter1d(speeds, GMD_WINDOW, axis=0, mode="constant")
    skates = low[1:] & low[:-1] & (speeds > GMD_SPEED) & (means > GMD_SPEED)
    return float(skates.any(axis=1).mean()) if average else skates.mean(axis=0)


@validate_params(
    CONSTRAINTS | {"tolerance": [Interval(Real, 0, None, closed="left")]}, prefer_skip_nested_validation=True
)
def foot_floating(
    motion: Recording,
    *,
    feet: Feet | None = None,
    floor: float | None = None,
    tolerance: float = AMONG,
    average: str | None = "feet",
) -> Any:
    """Mean height of the lowest point of the feet above the floor, mm, as in PhysDiff.

    Parameters
    ----------
    motion : Motion or Keypoints
        The motion, with the positions of the root, m.
    feet : two sequences of str, default=None
        Names of the points of the left and of the right foot, see `foot_skating`.
    floor : float, default=None
        Height, m, at which a standing foot has its lowest point. None is the height at which each point stands in this
        motion, which shows floating of a part of the motion only.
    tolerance : float, default=0.005
        Heights up to this, m, are zero.
    average : {"feet"} or None, default="feet"
        "feet": the lower foot of each frame. None: an array of the left and the right foot.

    Returns
    -------
    float or ndarray of shape (2,)
        Mean over all frames, mm. Jumps and the flights of runs count, too: compare with real motion of the same kind.

    Raises
    ------
    TypeError
        If `motion` is neither a `Motion` nor `Keypoints`.
    ValueError
        If feet are not found, or the root never moves.

    See Also
    --------
    foot_penetration : The same below the floor.

    References
    ----------
    .. [1] Y. Yuan, J. Song, U. Iqbal, A. Vahdat, J. Kautz, "PhysDiff: physics-guided human motion diffusion model",
       ICCV 2023, sec. 4, :doi:`10.1109/ICCV51070.2023.01467`, where the lowest vertex of a body counts.

    Examples
    --------
    A person stands, and hovers 10 cm above the floor for a quarter of the time:

    >>> import numpy as np
    >>> from skpose import Motion
    >>> from skpose.datasets import humanoid
    >>> from skpose.scores import foot_floating
    >>> up = np.repeat([0.0, 0.1], [45, 15])[:, None] * [0.0, 1.0, 0.0]
    >>> round(foot_floating(Motion(humanoid(), np.zeros((60, 42)), 30, up)), 3)
    25.0
    """
    return _depth(soles_of(motion, feet, floor).heights, tolerance, average)


@validate_params(
    CONSTRAINTS | {"tolerance": [Interval(Real, 0, None, closed="left")]}, prefer_skip_nested_validation=True
)
def foot_penetration(
    motion: Recording,
    *,
    feet: Feet | None = None,
    floor: float | None = None,
    tolerance: float = AMONG,
    average: str | None = "feet",
) -> Any:
    """Mean depth of the lowest point of the feet below the floor, mm, as in PhysDiff.

    Parameters
    ----------
    motion : Motion or Keypoints
        The motion, with the positions of the root, m.
    feet : two sequences of str, default=None
        Names of the points of the left and of the right foot, see `foot_skating`.
    floor : float, default=None
        Height, m, at which a standing foot has its lowest point; None as in `foot_floating`.
    tolerance : float, default=0.005
        Depths up to this, m, are zero.
    average : {"feet"} or None, default="feet"
        "feet": the lower foot of each frame. None: an array of the left and the right foot.

    Returns
    -------
    float or ndarray of shape (2,)
        Mean over all frames, mm.

    Raises
    ------
    TypeError
        If `motion` is neither a `Motion` nor `Keypoints`.
    ValueError
        If feet are not found, or the root never moves.

    See Also
    --------
    foot_floating : The same above the floor, with the source.

    Examples
    --------
    A person stands, and sinks by 10 cm for a fifth of the time:

    >>> import numpy as np
    >>> from skpose import Motion
    >>> from skpose.datasets import humanoid
    >>> from skpose.scores import foot_penetration
    >>> down = np.repeat([0.0, -0.1], [48, 12])[:, None] * [0.0, 1.0, 0.0]
    >>> round(foot_penetration(Motion(humanoid(), np.zeros((60, 42)), 30, down)), 3)
    20.0
    """
    return _depth(-soles_of(motion, feet, floor).heights, tolerance, average, lowest=np.max)


def _depth(heights: np.ndarray, tolerance: float, average: str | None, lowest: Any = np.min) -> Any:
    """Mean distance beyond the floor, mm, of heights (n_frames, 2, n_parts)."""
    of_feet = lowest(heights, axis=2)
    beyond = lowest(of_feet, axis=1) if average else of_feet
    means = 1e3 * np.nanmean(np.where(beyond <= tolerance, 0.0, beyond), axis=0)
    return float(means) if average else means


@validate_params(
    {
        "motion": [Motion, Keypoints],
        "kind": [StrOptions(["peak", "area"])],
        "reference": [Interval(Real, 0, None, closed="left")],
    },
    prefer_skip_nested_validation=True,
)
def jerk(motion: Recording, *, kind: str = "peak", reference: float = 0.0) -> float:
    r"""Jerk of the joints, the third derivative of their positions in the world: its peak, or the area under it.

    With :math:`j_f` the largest jerk of the joints at frame f, "peak" is the largest of them, and "area" is the
    integral of :math:`|j_f - r|` over time, divided by the duration. FlowMDM [1]_ measures both around transitions,
    with r the mean over real motion.

    Parameters
    ----------
    motion : Motion or Keypoints
        The motion, with the positions of the root, m. Frames with missing points do not count.
    kind : {"peak", "area"}, default="peak"
        What is measured.
    reference : float, default=0
        The jerk r, m/s³, of "area": the "area" of real motion with reference 0 is its mean jerk.

    Returns
    -------
    float
        Jerk, m/s³.

    Raises
    ------
    TypeError
        If `motion` is neither a `Motion` nor `Keypoints`.
    ValueError
        If there are not four consecutive frames.

    See Also
    --------
    skpose.metrics.Jerk : The distance of two motions by the jerks of their joints.

    Notes
    -----
    Derivatives are third differences times the cube of the frame rate. Noise of a fixed size grows by that cube, so
    compare motions at one rate, such as ``motion.resample(30)``.

    References
    ----------
    .. [1] G. Barquero, S. Escalera, C. Palmero, "Seamless human motion composition with blended positional encodings",
       CVPR 2024, :doi:`10.1109/CVPR52733.2024.00051`.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Motion, Skeleton
    >>> from skpose.scores import jerk
    >>> along = np.arange(31)[:, None] ** 3 / 30**3 * [1.0, 0.0, 0.0]  # x = t³ m: a jerk of 6 m/s³
    >>> motion = Motion(Skeleton.chain(1), np.zeros((31, 1)), 30, along)
    >>> round(jerk(motion), 6), round(jerk(motion, kind="area", reference=1.0), 6)
    (6.0, 5.0)
    """
    positions = motion.positions() if isinstance(motion, Motion) else motion.positions
    frames = motion.frame_numbers if isinstance(motion, Motion) else np.arange(len(motion))
    together = frames[3:] - frames[:-3] == 3
    third = np.diff(positions, n=3, axis=0)[together] if len(positions) > 3 else np.zeros((0, 1, 3))
    found = np.linalg.norm(third, axis=2)
    found = found[~np.isnan(found).any(axis=1)].max(axis=1, initial=0.0) * motion.frame_rate**3
    if not len(found):
        raise ValueError("motion must have four consecutive frames with all points")
    return float(found.max() if kind == "peak" else np.abs(found - reference).mean())
