"""Keypoints as a file states them, before a layout or names are given, and which frames they are of, and when."""

import re
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from skpose.io._source import NUMBER, Source

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
