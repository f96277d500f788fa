"""Keypoints as a file states them, before a layout or names are given: numbers, and the frames that they are of."""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from skpose.io._frame_times import Times
from skpose.io._source import Source
from skpose.io._words import NUMBER

MOST = 100  # frames for each that is stored: a larger number of a frame is damage, and would need the memory
# The first columns of the tables that `save_csv` writes, of positions and of angles.
POINTS_HEAD = "frame", "time", "frame_rate", "up"
ANGLES_HEAD = (*POINTS_HEAD, "root_axes")
# Keys of the number of a frame, the best first, without regard to case and signs between words.
FRAME = "frame", "frameid", "frameindex", "frameidx", "framenumber", "framenum", "frameno", "fnum"
IMAGE = "imageid"
# The last word of names of what has three coordinates and is no position.
NO_POSITION = (
    *("rot", "rotation", "rotations", "angle", "angles", "euler", "quat", "quaternion", "orientation"),
    *("vel", "velocity", "acc", "acceleration", "gyro"),
)
WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
LONGEST = 100  # characters of a name that are looked at
FLAGS = 0.0, 1.0, 2.0  # COCO's: not labelled, labelled and hidden, visible
HIGHEST = 2.0  # score of an estimator whose scores are from 0 to 1 and overshoot


class Stored(NamedTuple):
    """Positions with what the file says of them; None for what it does not say."""

    positions: np.ndarray  # (n_frames, n_points, 3), NaN where not seen
    confidences: np.ndarray | None  # (n_frames, n_points)
    names: list[str] | None
    frame_rate: float | None = None
    up: Any = None  # "x", "y" or "z"
    times: Times | None = None


def frame_key(keys: Iterable[str]) -> str | None:
    """Return the key of these, if any, that is the number of the frame, or the image that is the frame."""
    found = {re.sub(r"[\W_]", "", key).lower(): key for key in reversed(list(keys))}
    return next((found[word] for word in (*FRAME, IMAGE) if word in found), None)


def is_image(key: str) -> bool:
    """Return whether a key is that of an image, of which each person has an entry."""
    return re.sub(r"[\W_]", "", key).lower() == IMAGE


def frame_numbers(source: Source, values: Sequence[float | str], key: str) -> list[float] | None:
    """Return the numbers of frames from numbers, or from names with a number in them, such as those of images.

    None if names have no number; these are refused where two are the same.
    """
    is_number = [not isinstance(value, str) or NUMBER.fullmatch(value) is not None for value in values]
    if all(is_number):
        numbers: list[float] | None = [float(value) for value in values]
    elif any(is_number):
        raise source.error(f"{key}: expected a number, found {str(values[is_number.index(False)])[:40]!r}")
    else:
        numbers = numbers_in([str(value) for value in values])
        if numbers is None and not is_image(key):
            raise source.error(f"{key}: expected a number, found {str(values[0])[:40]!r}")
    counts = Counter(values if numbers is None else numbers)
    if max(counts.values(), default=0) > 1 and (numbers is None or is_image(key)):
        given: Sequence[float | str] = values if numbers is None else numbers
        one = next(value for value in given if counts[value] > 1)
        value = values[list(given).index(one)]
        shown = repr(value[:40]) if isinstance(value, str) else f"{value:g}"
        raise source.error(
            f"{key}: expected one person, found {counts[one]} entries of {shown}: keep the same one in every frame"
        )
    return numbers


def numbers_in(names: Sequence[str]) -> list[float] | None:
    """Return the number by which names differ, as of walk_08.png and walk_09.png; None if they have none.

    Numbers that are the same in all names, as of a camera, play no part, and neither does what follows the number.
    """
    if len(set(names)) < 2:
        return [0.0] * len(names)
    first, last = min(names), max(names)  # which differ first where some differ
    same = next((i for i, (a, b) in enumerate(zip(first, last, strict=False)) if a != b), min(len(first), len(last)))
    start = len(re.sub(r"\d+$", "", first[:same]))
    found = [re.match(r"\d{1,300}", name[start:]) for name in names]
    return None if None in found else [float(match[0]) for match in found if match]


def positions_only(source: Source, names: Sequence[str]) -> list[str]:
    """Return the names of points but for those of rotations, velocities and the like, with a warning of these."""
    last = [(WORD.findall(name[-LONGEST:]) or [""])[-1].lower() for name in names]
    others = [name for name, word in zip(names, last, strict=True) if word in NO_POSITION]
    if not others:
        return list(names)
    shown = ", ".join(repr(name[:40]) for name in others[:3]) + (" and others" if len(others) > 3 else "")
    if len(others) == len(names):
        raise source.error(f"expected positions of points, found {shown}, which are none by their names")
    source.warn(f"{shown}: no positions by the name, and left out; give them other names if they are")
    return [name for name in names if name not in others]


def at_frames(source: Source, stored: Stored, numbers: Sequence[float] | None) -> Stored:
    """Return positions with each frame where its number says; frames without one are not seen."""
    if numbers is None or not len(numbers):
        return stored
    given = np.asarray(numbers, dtype=np.float64)
    if not (np.isfinite(given).all() and (given % 1.0 == 0.0).all() and np.abs(given).max() < 2**53):
        raise source.error("numbers of frames: expected whole numbers")
    steps = np.diff(given)
    if (steps < 1.0).any():
        at = int(np.argmax(steps < 1.0))
        raise source.error(
            f"numbers of frames: {given[at + 1]:g} follows {given[at]:g}; expected each once, in order: one row or "
            "entry a frame, of one person"
        )
    n = given[-1] - given[0] + 1.0
    if n > MOST * len(given):
        raise source.error(f"numbers of frames go from {given[0]:g} to {given[-1]:g} in {len(given)} frames")
    if n == len(given):
        return stored
    at = (given - given[0]).astype(np.int64)
    positions = np.full((int(n), *stored.positions.shape[1:]), np.nan)
    positions[at] = stored.positions
    confidences = stored.confidences
    if confidences is not None:
        confidences = np.zeros(positions.shape[:2])
        confidences[at] = stored.confidences
    return stored._replace(positions=positions, confidences=confidences)


def as_confidences(source: Source, scores: np.ndarray) -> np.ndarray:
    """Return scores as confidences from 0 to 1: COCO's 1 and 2 are seen, and so is what overshoots 1."""
    if scores.max(initial=0.0) <= 1.0 or np.isin(scores, FLAGS).all():
        return np.minimum(scores, 1.0)
    if scores.max() > HIGHEST or (scores > 1.0).mean() > 0.5:
        remedy = ": divide percent by 100" if scores.max() > HIGHEST else ""
        raise source.error(
            f"confidences must be from 0, not seen, to 1, or COCO's 0, 1 and 2; found {scores.max():.4g}{remedy}"
        )
    return np.minimum(scores, 1.0)
