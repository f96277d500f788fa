"""What formats leave open, and files may state wrongly: the unit of length, the frame rate, the axis that points up,
names given twice, and whether a point at the origin is a lost one.
"""

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.units import complaint_of_extent
from skpose._utils.validation import check_choice, check_frame_rate, check_positive
from skpose.io._source import NUMBER, Source
from skpose.keypoints import Keypoints
from skpose.keypoints._checks import UPS, complaint_of_origin, settle_up, turn_up
from skpose.skeleton import Motion
from skpose.skeleton._root import root_angles_of, root_orientations
from skpose.skeleton._upright import complaint_of_up

Axis = Literal["x", "y", "z"]
Up = Literal["x", "y", "z", "-x", "-y", "-z"]
# Half a turn that makes an axis point up that points down.
HALF_TURNS = {up: Rotation.from_rotvec(np.pi * about) for up, about in zip(UPS[3:], np.eye(3)[[1, 0, 0]], strict=True)}
Zeros = Literal["seen", "missing"]
CHOICES: dict[str, tuple] = {
    "on_nan": ("raise", "drop"),
    "trust": ("header", "rows"),
    "stretch": ("raise", "mean"),
    "missing": ("raise", "rest"),
    "root_offset": ("replace", "add"),
    "up": (None, *UPS),
    "zeros": (None, "seen", "missing"),
}

METRES = {
    "m": 1.0, "meter": 1.0, "metre": 1.0, "meters": 1.0, "metres": 1.0,
    "cm": 0.01, "centimeter": 0.01, "centimetre": 0.01, "centimeters": 0.01, "centimetres": 0.01,
    "mm": 0.001, "millimeter": 0.001, "millimetre": 0.001, "millimeters": 0.001, "millimetres": 0.001,
    "in": 0.0254, "inch": 0.0254, "inches": 0.0254,
    "ft": 0.3048, "foot": 0.3048, "feet": 0.3048,
}  # fmt: skip
ANGLES = ("rad", "rads", "radian", "radians", "deg", "degs", "degree", "degrees", "°")
FEWEST = 4  # letters of a name that is cut short, as in C3D files without room for more

SAME = 0.01  # relative difference between two roundings of one rate
SLOWEST, FASTEST = 2.0, 2000.0  # Hz, of recordings of people


def check_options(**options: Any) -> None:
    """Check the options that several readers have, by their names."""
    for name, value in options.items():
        if name in CHOICES:
            check_choice(name, value, CHOICES[name])
        elif value is not None and (name, value) != ("scale", "auto"):
            check_frame_rate(value) if name == "frame_rate" else check_positive(name, value)


def read_unit(source: Source, where: str, unit: str, scale: float | None, at: Any = None) -> float:
    """The metres of one unit: the scale, or else by the name of the unit in any case, also if it is cut off."""
    word = unit.strip().lower()
    names = [name for name in (*METRES, *ANGLES) if name == word or (len(word) >= FEWEST and name.startswith(word))]
    metres = {METRES.get(name, 0.0) for name in names}  # 0.0 of angles
    if 0.0 in metres or (scale is None and len(metres) != 1):
        advice = "" if 0.0 in metres else ": pass scale="
        raise source.error(f"{where}: expected a unit of length such as mm, cm or m, found {unit[:40]!r}{advice}", at)
    if scale is None:
        return metres.pop()
    return choose_scale(source, scale, metres.pop() if len(metres) == 1 else scale, where)


def choose_scale(source: Source, given: float, stated: float, where: str) -> float:
    """The given scale, with a warning if the file states another unit."""
    if not agree(given, stated):
        source.warn(f"scale={given:g} replaces the unit of {where}, {stated:.4g} m")
    return given


def choose_rate(source: Source, given: float | None, stated: float, where: str) -> float:
    """The frame rate, Hz: `given`, with a warning if the file states another, or the file's own."""
    if given is None:
        return stated
    if SLOWEST <= stated <= FASTEST and not agree(given, stated):
        source.warn(
            f"frame_rate={given:g} replaces the {stated:g} Hz of {where}, so that it lasts {stated / given:.3g} times "
            "as long; Motion.resample changes the rate"
        )
    return given


def agree(one: float, other: float) -> bool:
    """Whether two rates or scales differ by no more than rounding."""
    return abs(one - other) <= SAME * other


def stand(motion: Motion, up: str | None, source: Source, default: Axis = "y") -> Motion:
    """A motion with its up axis: `up`, or the default, with a warning if people stand along another axis.

    If the axis points down the world is turned by half a turn: about x for y and z, about y for x.
    """
    if up is None:
        source.warn(complaint_of_up(motion, default))
        up = default
    if up in HALF_TURNS:
        turn = HALF_TURNS[up]
        angles, axes = motion.root_angles, motion.root_axes
        if len(motion):
            turned = turn * root_orientations(motion.root_angles, motion.root_axes)
            angles, axes = root_angles_of(turned, np.zeros(3), motion.root_axes)
        motion = replace(motion, root_positions=turn.apply(motion.root_positions), root_angles=angles, root_axes=axes)
    axis: Any = up[-1]
    return replace(motion, up=axis)


def quarter_turn(before: str, after: str) -> np.ndarray:
    """The rotation matrix (3, 3) of the world that takes one axis to another; zeros and ones."""
    axes = [np.eye(3)["xyz".index(axis)] for axis in (before, after)]
    return np.round(Rotation.from_rotvec(np.pi / 2 * np.cross(*axes)).as_matrix()) + 0.0


def check_even(motion: Motion, format_has: str) -> None:
    """Refuse a motion with frames left out for a format with one time between all frames."""
    if (np.diff(motion.frame_numbers) > 1).any():
        raise ValueError(
            f"some frame_numbers are left out, and {format_has} one time between all frames: "
            "dataclasses.replace(motion, frame_numbers=None) writes the frames without regard to their times"
        )


def keypoints_of_markers(
    source: Source,
    positions: np.ndarray,
    names: Sequence[str],
    frame_rate: float,
    scale: float,
    zeros: Zeros | None,
    up: Any,
    usual: tuple[Up, str],
) -> Keypoints:
    """Markers in m, without lost ones, with the axis that points up; `usual` has a reason with it."""
    lost = (positions == 0.0).all(axis=2)
    if zeros == "missing":
        positions[lost] = np.nan
    elif zeros is None and lost.any():
        source.warn(complaint_of_origin(lost, names))
    positions = positions * scale
    if up is None:
        up, complaint = settle_up(positions, names, *usual)
        source.warn(complaint)
    positions, axis = turn_up(positions, up)
    found = Keypoints(positions, names, frame_rate, up=axis)
    source.warn(complaint_of_extent(found.positions, scale))
    return found


def number_names(source: Source, names: list[str]) -> list[str]:
    """A different name for each point: the first of a name keeps it, the others are numbered, with a warning."""
    unique: dict[str, str] = {}
    for name in names:
        unique[unused_name(name, unique, names)] = name
    warn_of_renamed(source, "points", unique)
    return list(unique)


def unused_name(name: str, used: Collection[str], reserved: Collection[str]) -> str:
    """The name, numbered if it is used; numbered names are never reserved ones."""
    new, count = name, 1
    while new in used or (count > 1 and new in reserved):
        count += 1
        new = f"{name}_{count}"
    return new


def warn_of_renamed(source: Source, what: str, names: dict[str, str]) -> None:
    """Warn if new names, the keys, differ from those in the file."""
    renamed = [(new, name) for new, name in names.items() if name != new]
    if renamed:
        source.warn(f"several {what} are named {renamed[0][1]!r}; the next one is {renamed[0][0]!r} here")


# --- keypoints as a file states them ----------------------------------------------------------------------------------


MOST = 100  # frames for each that is stored: a larger number of a frame is damage, and would need the memory
# Keys of the number of a frame, the best first, without regard to case and signs between words; the last is an image.
FRAME = "frame", "frameid", "frameindex", "frameidx", "framenumber", "framenum", "frameno", "fnum", "imageid"
# The first or last word, without sides, of names of rotations, velocities, forces and other vectors.
NO_POSITION = (
    *("rot", "rotation", "rotations", "angle", "angles", "euler", "quat", "quaternion", "orientation"),
    *("vel", "velocity", "acc", "accel", "acceleration", "accelerometer", "gyr", "gyro", "gyroscope", "omega"),
    *("mag", "magnetometer", "force", "forces", "grf", "moment", "moments", "torque", "torques", "power", "gravity"),
)
SIDES = "l", "left", "r", "right"
WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
LONGEST = 100  # characters of a name that are looked at
FLAGS = 0.0, 1.0, 2.0  # COCO's: not labelled, labelled and hidden, visible
HIGHEST = 2.0  # score of an estimator whose scores are from 0 to 1 and overshoot
# Keys and headers of times, such as time, timestamp_ms and Time (s).
TIME = re.compile(
    r"\s*(?:times?|time_?stamps?|ts?)(?:[\s_.\-(\[]*(s|secs?|seconds?|ms|msecs?|millis|milliseconds?|us|microseconds?"
    r"|ns|nanoseconds?)[)\]]?)?\s*",
    re.IGNORECASE,
)
SECONDS = {"s": 1.0, "micro": 1e-6, "m": 1e-3, "u": 1e-6, "n": 1e-9}  # of a unit, by how it begins
CLOSE, DRIFT = 0.02, 0.4  # relative difference of rates, and the resulting shift in frames: less may be jitter
LONG = 1.5  # steps of time over the usual one: a frame is left out


class Times(NamedTuple):
    """The times of the frames that are stored, in a unit that is known or not, and the numbers of these frames."""

    key: str
    values: np.ndarray  # (n_stored,)
    numbers: Sequence[float] | None

    def _steps(self) -> tuple[np.ndarray, bool]:
        """The times from one frame to the next, without gaps and steps back, and whether there are none of these."""
        with np.errstate(all="ignore"):
            steps = np.diff(self.values) / (1.0 if self.numbers is None else np.diff(self.numbers))
        steps = steps[np.abs(steps) < 1e100]  # sums of others may overflow
        if not steps.any():  # times that are all the same say nothing
            return steps[:0], True
        usual = (steps > 0.0) & (steps <= LONG * np.median(steps))
        return steps[usual], bool(usual.all())

    def rate(self, near: float = 50.0) -> float:
        """The frame rate, Hz, in the unit of the key, or the one nearest to a rate; NaN if not known."""
        steps, _ = self._steps()
        interval = float(steps.mean()) if len(steps) else np.nan
        if not 1e-12 < interval < 1e12 or (steps == 1.0).all():  # times that count frames have no unit
            return np.nan
        match = TIME.fullmatch(self.key)
        unit = (match[1] or "").lower() if match else ""
        units = [seconds for start, seconds in SECONDS.items() if unit.startswith(start)][:1] or SECONDS.values()
        return float(min((1.0 / (interval * seconds) for seconds in units), key=lambda rate: abs(np.log(rate / near))))

    def complaint(self, frame_rate: float) -> str:
        """Say that the times contradict a frame rate, by more than jitter, or have gaps; empty if they do not."""
        rate = self.rate(frame_rate)
        apart = abs(frame_rate / rate - 1.0)
        if apart > CLOSE and apart * len(self.values) > DRIFT:
            return (
                f"frames are at {rate:.4g} Hz by {self.key!r}, but {frame_rate:g} Hz is taken: "
                f"pass frame_rate={rate:.4g} if these times are right"
            )
        return "" if self._steps()[1] else f"frames are taken as equally spaced, but {self.key!r} has gaps or goes back"


class Stored(NamedTuple):
    """Positions and what the file states about them; None if it does not state it."""

    positions: np.ndarray  # (n_frames, n_points, 3), NaN where not seen
    confidences: np.ndarray | None  # (n_frames, n_points)
    names: list[str] | None
    frame_rate: float | None = None
    up: Any = None
    times: Times | None = None
    scale: float | None = None  # metres per unit
    why: str = ""  # why `up` is taken, if the file does not state it


def time_key(keys: Iterable[str]) -> str | None:
    """The first of the keys that is the time of a frame."""
    return next((key for key in keys if len(key) < LONGEST and TIME.fullmatch(key)), None)


def frame_key(keys: Iterable[str]) -> str | None:
    """The key that is the number of the frame, or the image that is the frame."""
    found = {re.sub(r"[\W_]", "", key).lower(): key for key in reversed(list(keys))}
    return next((found[word] for word in FRAME if word in found), None)


def numbers_of(values: Sequence[Any]) -> list[float] | None:
    """Numbers, of frames or images, from numbers or from texts by which they differ; None if they have none.

    Of walk_08.png and walk_09.png they are 8 and 9. Numbers that are the same in all texts, as of a camera, play no
    part, and neither does what follows the number.
    """
    texts = [str(value) for value in values]
    if all(map(NUMBER.fullmatch, texts)):
        return [float(text) for text in texts]
    if len(set(texts)) < 2 or not all(isinstance(value, str) for value in values):
        return None
    differ = (i for i, letters in enumerate(zip(*texts, strict=False)) if len(set(letters)) > 1)
    start = len(re.sub(r"\d+$", "", texts[0][: next(differ, min(map(len, texts)))]))
    found = [match for text in texts if (match := re.match(r"\d{1,300}", text[start:]))]
    return [float(match[0]) for match in found] if len(found) == len(texts) else None


def frame_numbers(source: Source, key: str, values: Sequence[Any]) -> list[float] | None:
    """The numbers of frames by the values of their key; None for images without numbers."""
    numbers = numbers_of(values)
    is_image = "image" in key.lower() and all(isinstance(value, str) for value in values)
    if (numbers is None and not is_image) or len(set(numbers or values)) < len(values):
        raise source.error(f"{key}: expected a number or an image of each frame, each once: keep one person")
    return numbers


def at_frames(source: Source, stored: Stored, numbers: Sequence[float] | None) -> Stored:
    """Positions with each frame where its number says; frames without one are not seen."""
    if not numbers:
        return stored
    given = np.asarray(numbers, dtype=np.float64)
    n = given[-1] - given[0] + 1.0
    if not ((given % 1.0 == 0.0).all() and (np.diff(given) > 0.0).all() and n <= MOST * len(given)):
        raise source.error("expected whole numbers of frames, each once, in order, without large gaps")
    at = (given - given[0]).astype(np.int64)

    def place(array: np.ndarray, otherwise: float) -> np.ndarray:
        found = np.full((int(n), *array.shape[1:]), otherwise)
        found[at] = array
        return found

    confidences = None if stored.confidences is None else place(stored.confidences, 0.0)
    return stored._replace(positions=place(stored.positions, np.nan), confidences=confidences)


def positions_only(source: Source, names: Sequence[str]) -> list[str]:
    """Leave out the names of rotations, velocities and the like, with a warning."""
    words = [[word.lower() for word in WORD.findall(name[-LONGEST:])] for name in names]
    ends = [[word for word in some if word not in SIDES] for some in words]
    kept = [name for name, some in zip(names, ends, strict=True) if not {*some[:1], *some[-1:]} & {*NO_POSITION}]
    if len(kept) == len(names):
        return kept
    others = {*names} - {*kept}
    shown = ", ".join(repr(name[:40]) for name in names if name in others)[:120]
    if not kept:
        raise source.error(f"expected positions of points, found {shown}")
    source.warn(f"{shown}: not positions by their names, and left out")
    return kept


def as_confidences(source: Source, scores: np.ndarray) -> np.ndarray:
    """Scores as confidences from 0 to 1: COCO's 1 and 2 are seen, and so is what overshoots 1; NaN is 0."""
    scores = np.nan_to_num(scores, posinf=np.inf)
    is_flags = np.isin(scores, FLAGS).all()
    if not is_flags and (scores.max(initial=0.0) > HIGHEST or (scores > 1.0).mean() > 0.5):
        raise source.error(f"confidences must be from 0, not seen, to 1, found {scores.max():.4g}")
    return np.minimum(scores, 1.0)
