"""Keypoints in JSON files, in the forms of OpenPose in 3-D, MediaPipe, COCO and MMPose.

A file is a frame, a list of frames, or has one under a key; a frame has its points under a key of one of these tools,
or is the points themselves.
"""

import json
import re
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from skpose.io._arguments import PathLike
from skpose.io._error import MocapFormatError
from skpose.io._source import Source
from skpose.io._stored import (
    Stored,
    Times,
    as_confidences,
    at_frames,
    frame_key,
    frame_numbers,
    numbers_in,
    positions_only,
    time_key,
)
from skpose.keypoints._shared import REMEDY, complaint_of_flat

# Keys of a frame: of its people in OpenPose, MMPose and COCO; of points in three dimensions in OpenPose, MediaPipe and
# TensorFlow.js; of points that may be in two or three; and of those of pictures.
PEOPLE = "people", "instances", "annotations"
SPATIAL = (
    *("pose_keypoints_3d", "pose_world_landmarks", "worldLandmarks", "hand_world_landmarks"),
    *("keypoints_3d", "keypoints3D"),
)
POINTS = "keypoints"
FLAT = "pose_keypoints_2d", "pose_landmarks", "landmarks"
SURE = "visibility", "confidence", "score"
RATES = "fps", "frame_rate"

Rows = list[list[float]]  # x, y, z and how sure of each point


class Frame(NamedTuple):
    """The points of one frame."""

    names: list[str] | None
    rows: np.ndarray  # (n_points, 4): x, y, z, and how sure, NaN where it is not said


class Listed(NamedTuple):
    """The frames of a document, with their numbers if they are under these."""

    frames: list[Any]
    numbers: list[float] | None = None


class Parts(NamedTuple):
    """The frames of a file, None where nobody is seen, and what the file says of them."""

    frames: list[Frame | None]
    names: list[str] | None
    frame_rate: float | None
    numbers: list[float] | None
    times: Times | None


def is_json(source: Source) -> bool:
    return source.kind == "text" and source.head.lstrip()[:1] in ("{", "[")


def read_json(source: Source, n_points: int | None) -> Stored:
    """Return the positions of a JSON file, of this many points if that is known."""
    parts = _read_parts(source, n_points)
    stored = _stack(source, parts.frames, parts.names)._replace(frame_rate=parts.frame_rate, times=parts.times)
    return at_frames(source, stored, parts.numbers)


def json_files(folder: PathLike) -> list[Path]:
    """Return the JSON files of a folder, in the order of their last number, as OpenPose counts frames."""
    files = sorted(path for path in Path(folder).iterdir() if path.suffix.lower() == ".json")
    return sorted(files, key=_last_number)


def read_folder(source: Source, files: list[Path], n_points: int | None) -> Stored:
    """Return the positions of JSON files, a frame or a part of the frames in each; `source` is the first file."""
    parts = [_read_parts(Source(path, "a JSON file"), n_points) for path in files]
    frames = [frame for part in parts for frame in part.frames]
    given = [number for part in parts for number in part.numbers or ()]
    numbers = given if len(given) == len(frames) else None
    if len(frames) == len(files):
        numbers = [float(_last_number(path)) for path in files]
        numbers = None if -1.0 in numbers else numbers
    stored = _stack(source, frames, None)
    times = [part.times for part in parts if part.times is not None]
    if len(times) == len(parts) and len({one.key for one in times}) == 1:
        values = np.concatenate([one.values for one in times])
        stored = stored._replace(times=Times(times[0].key, values, None if numbers is None else np.array(numbers)))
    return at_frames(source, stored, numbers)


def _last_number(path: Path) -> int:
    return int((re.findall(r"\d{1,15}", path.stem) or ["-1"])[-1])


def _read_parts(source: Source, n_points: int | None) -> Parts:
    try:
        document = json.loads(source.data.decode("utf-8", errors="replace"))
    except json.JSONDecodeError as error:
        message = f"JSON is damaged or cut short: {error.msg}"
        raise MocapFormatError(source.name, error.lineno, message, error.colno) from None
    except (RecursionError, ValueError) as error:  # lists within lists, and numbers of thousands of digits
        raise source.error(f"JSON is damaged: {error}") from None
    names = rate = None
    if isinstance(document, dict):
        names = _category_names(document)
        if (given := next((document[key] for key in RATES if key in document), None)) is not None:
            rate = float(given) if _is_number(given) else np.nan
            if not (rate > 0.0 and np.isfinite(rate) and np.isfinite(1.0 / rate)):
                raise source.error(f"fps: expected a positive number, found {str(given)[:40]}")
    n_points = len(names) if names else n_points
    listed = _list_frames(source, document, n_points)
    reader = _Reader(source, n_points)
    frames = [reader.frame(frame) for frame in listed.frames]
    if complaint := complaint_of_flat(reader.flat):
        reader.refuse_flat(f"{complaint}. If the third numbers are z, write keypoints_3d")
    numbers = listed.numbers or _numbers(source, listed.frames)
    return Parts(frames, names, rate, numbers, _times(listed.frames, numbers))


class _Reader:
    """Finds the points of each frame of a document."""

    def __init__(self, source: Source, n_points: int | None):
        self.source, self.n_points = source, n_points
        self.flat: list[list[list[float]]] = []  # frames of three numbers a point: x, y, z or COCO's x, y, v

    def refuse_flat(self, what: str) -> None:
        raise self.source.error(f"these are keypoints in two dimensions: {what}. {REMEDY}")

    def frame(self, frame: Any) -> Frame | None:
        """Return the points of the one person of a frame; None if nobody is seen."""
        if not isinstance(frame, dict):
            return self.points(frame, "")
        keys = {key for key, value in frame.items() if value not in (None, [], {})}
        if key := next((key for key in SPATIAL if key in keys), None):
            return self.with_scores(frame, key)
        if key := next((key for key in PEOPLE if key in frame), None):
            return self.one(frame[key])
        if POINTS in frame:
            return self.with_scores(frame, POINTS)
        if key := next((key for key in FLAT if key in keys), None):
            self.refuse_flat(f"{key} are in units of a picture")
        return None if frame.keys() & {*SPATIAL, *FLAT} else self.points(frame, "")

    def one(self, people: Any) -> Frame | None:
        """Return the points of the only person of a list."""
        if not isinstance(people, list) or len(people) > 1:
            found = len(people) if isinstance(people, list) else _kind(people)
            raise self.source.error(f"expected one person, found {found}: keep the same one in every frame")
        return self.frame(people[0]) if people else None

    def with_scores(self, frame: dict, key: str) -> Frame | None:
        """Return the points under a key, with MMPose's scores next to them."""
        found, scores = self.points(frame[key], key), frame.get("keypoint_scores")
        if found is not None and scores is not None:
            if not isinstance(scores, list) or len(scores) != len(found.rows):
                raise self.source.error(f"keypoint_scores: expected {len(found.rows)} numbers, found {_kind(scores)}")
            found.rows[:, 3] = self.numbers(scores)
        return found

    def points(self, points: Any, key: str) -> Frame | None:
        """Return the points under a key: rows, objects, objects by name, or all numbers in one list."""
        if isinstance(points, dict) and "landmark" in points:  # of MediaPipe's solutions
            points = points["landmark"]
        if points in (None, [], {}):
            return None
        if isinstance(points, dict):
            named = {name: point for name, point in points.items() if isinstance(point, dict | list)}
            return Frame(list(named), self.rows(list(named.values())))
        if not isinstance(points, list):
            raise self.source.error(f"expected points, found {_kind(points)}")
        first = points[0]
        if _is_number(first):
            return Frame(None, self.flat_rows(points, key))
        is_person = isinstance(first, dict) and not {"x", "X"} & first.keys()
        if is_person or (isinstance(first, list) and first and not _is_number(first[0])):
            return self.one(points)
        names = [point["name"] for point in points if isinstance(point, dict) and isinstance(point.get("name"), str)]
        if names and len(names) < len(points):
            raise self.source.error("expected a name of each point or of none")
        return Frame(names or None, self.rows(points))

    def flat_rows(self, numbers: list, key: str) -> np.ndarray:
        """Return numbers without lists of points between them as rows."""
        n, widths = len(numbers), [width for width in (3, 4) if len(numbers) % width == 0]
        if key == "pose_keypoints_3d":  # OpenPose
            widths = [4] if n % 4 == 0 else []
        elif self.n_points and n in (3 * self.n_points, 4 * self.n_points):
            widths = [n // self.n_points]
        if not widths or (len(widths) > 1 and key in SPATIAL):
            raise self.source.error(f"expected x, y, z, or with a score, found {n} numbers: pass layout= or names=")
        rows = self.rows([numbers[i : i + widths[0]] for i in range(0, n, widths[0])])
        if widths[0] == 3 and key not in SPATIAL:
            self.flat.append(rows[:, :3].tolist())
        return rows

    def rows(self, points: list) -> np.ndarray:
        """Return x, y, z, and how sure, of points; NaN where one is not seen or it is not said."""
        return self.numbers([self.point(point) for point in points]).reshape(-1, 4)

    def point(self, point: Any) -> list:
        if point is None:
            return [None] * 4
        if isinstance(point, dict):
            lower = {str(key).lower(): value for key, value in point.items()}
            if {"x", "y"} <= lower.keys() and "z" not in lower:
                self.refuse_flat("points have x and y, and no z")
            if "w" in lower or not {"x", "y", "z"} <= lower.keys():
                raise self.source.error(f"expected a point with x, y and z, found {_kind(point)}")
            return [lower["x"], lower["y"], lower["z"], next((lower[key] for key in SURE if key in lower), None)]
        if isinstance(point, list) and len(point) == 2:
            self.refuse_flat("points have two numbers")
        if not isinstance(point, list) or len(point) not in (3, 4):
            raise self.source.error(f"expected a point with x, y and z, found {_kind(point)}: pass layout= or names=?")
        return [*point, None][:4]

    def numbers(self, values: list) -> np.ndarray:
        """Return numbers as an array, NaN for null."""
        try:
            return np.array(values, dtype=np.float64)
        except (TypeError, ValueError, OverflowError) as error:
            raise self.source.error(f"expected numbers: {error}") from None


def _list_frames(source: Source, document: Any, n_points: int | None) -> Listed:
    """Return the frames of a document, which may be one of them."""
    if isinstance(document, dict):
        if "annotations" in document and "images" in document:
            return _coco_frames(source, document)
        frames = document.get("frames", document.get("instance_info"))  # the latter of MMPose
        if isinstance(frames, list):
            return Listed(frames)
        if isinstance(frames, dict):
            if (found := _by_number(frames, numbers_in(list(frames)))) is None:
                raise source.error(f"frames: expected a list, or an object by numbers, found {_kind(frames)}")
            return found
        numbered = {key: value for key, value in document.items() if key.isdecimal() and len(key) < 100}
        others = [value for key, value in document.items() if key not in numbered and isinstance(value, dict | list)]
        return (None if others else _by_number(numbered, None)) or Listed([document])
    if not isinstance(document, list) or not document:
        raise source.error(f"expected keypoints, found {_kind(document)}")
    first = document[0]
    if isinstance(first, list) and first and _is_number(first[0]):
        is_frame = n_points and len(first) in (3 * n_points, 4 * n_points) and (n_points > 1 or len(document) > 1)
        return Listed(document if is_frame else [document])
    return Listed([document] if _is_number(first) or _is_point(first) else document)


def _by_number(frames: dict, numbers: list[float] | None) -> Listed | None:
    """Return the frames of an object whose keys are their numbers, in the order of these; None if they are not."""
    if all(key.isdecimal() for key in frames):
        numbers = [float(key) for key in frames]
    if not frames or numbers is None or any(map(_is_point, frames.values())):
        return None
    order = np.argsort(numbers, kind="stable")
    return Listed([list(frames.values())[i] for i in order], [numbers[i] for i in order])


def _coco_frames(source: Source, document: dict) -> Listed:
    """Return the annotations of each image of a COCO file, in the order of the images' numbers."""
    images, annotations = document["images"], document["annotations"]
    if not all(isinstance(one, list) and all(isinstance(x, dict) for x in one) for one in (images, annotations)):
        raise source.error("images and annotations: expected lists of objects, as in COCO's files")
    people: dict[str, list] = {str(image.get("id")): [] for image in images}
    for annotation in annotations:
        if (key := str(annotation.get("image_id"))) not in people:
            raise source.error(f"annotations: there is no image of the id {key}")
        people[key].append(annotation)
    if len(people) < len(images):
        raise source.error("images: expected a different id of each")
    frames = [{"annotations": one} for one in people.values()]
    candidates = [_numbers(source, images)]
    for values in ([image.get(key) for image in images] for key in ("file_name", "id")):
        if len(values) > 1 and all(isinstance(value, str) for value in values):
            candidates.append(numbers_in(values))
        elif all(_is_number(value) for value in values):
            candidates.append([float(value) for value in values])
    numbers = next((one for one in candidates if one is not None and len(set(one)) == len(images)), None)
    if numbers is None:
        return Listed(frames)
    order = np.argsort(numbers, kind="stable")
    return Listed([frames[i] for i in order], [numbers[i] for i in order])


def _category_names(document: dict) -> list[str] | None:
    """Return the names of the points of a COCO or MMPose file."""
    categories = document.get("categories")
    category = categories[0] if isinstance(categories, list) and categories else document.get("meta_info")
    if not isinstance(category, dict):
        return None
    by_id = category.get("keypoint_id2name", {})
    names = category.get("keypoints") or (list(by_id.values()) if isinstance(by_id, dict) else None)
    return names if isinstance(names, list) and names and all(isinstance(name, str) for name in names) else None


def _numbers(source: Source, frames: list) -> list[float] | None:
    """Return the number of each frame, if all say it; None follows the frame before."""
    seen = [frame for frame in frames if frame is not None]
    if not seen or not all(isinstance(frame, dict) for frame in seen):
        return None
    keys = [frame_key(frame) for frame in seen]
    if None in keys or len(set(keys)) > 1:
        if any(key is not None for key in keys):
            raise source.error("expected the number of a frame in each of them, or in none")
        return None
    values = [frame[keys[0]] for frame in seen]
    if not all(isinstance(value, str) or _is_number(value) for value in values):
        raise source.error(f"{keys[0]}: expected numbers of frames, found something else")
    numbers = frame_numbers(source, str(keys[0]), values)
    if numbers is None or len(seen) == len(frames):
        return numbers
    given, found = iter(numbers), list[float]()
    for frame in frames:
        found.append(next(given) if frame is not None else found[-1] + 1.0 if found else np.nan)
    return found


def _times(frames: list, numbers: list[float] | None) -> Times | None:
    """Return the time of each frame, if all say it as a number."""
    keys = {time_key(frame) if isinstance(frame, dict) else None for frame in frames}
    key = keys.pop() if len(keys) == 1 else None
    if key is None or not all(_is_number(frame[key]) and abs(frame[key]) < 1e300 for frame in frames):
        return None
    values = np.array([frame[key] for frame in frames], dtype=np.float64)
    return Times(key, values, None if numbers is None else np.array(numbers))


def _stack(source: Source, frames: list[Frame | None], names: list[str] | None) -> Stored:
    """Return the points of all frames as arrays, by their names if they have any."""
    seen = [frame for frame in frames if frame is not None]
    if not seen:
        raise source.error("expected keypoints in three dimensions, found none in any frame")
    if len({frame.names is None for frame in seen}) > 1:
        raise source.error("points have names in some frames, and none in others")
    if seen[0].names is not None:
        names = positions_only(source, list(dict.fromkeys(name for frame in seen for name in frame.names or ())))
    counts = {len(names)} if names else set()
    counts |= {len(frame.rows) for frame in seen if frame.names is None}
    if len(counts) > 1:
        raise source.error(f"expected the same number of points in every frame, found {sorted(counts)[:2]}")
    array = np.full((len(frames), counts.pop(), 4), np.nan)
    index = {name: i for i, name in enumerate(names or ())}
    for rows, frame in zip(array, frames, strict=True):
        if frame is not None and frame.names is not None:
            chosen = [i for i, name in enumerate(frame.names) if name in index]
            rows[[index[frame.names[i]] for i in chosen]] = frame.rows[chosen]
        elif frame is not None:
            rows[:] = frame.rows
    positions, sure = array[:, :, :3], array[:, :, 3]
    if np.isnan(sure).all():
        return Stored(positions, None, names)
    is_seen = ~np.isnan(positions).any(axis=2)
    return Stored(positions, np.where(np.isnan(sure), is_seen, as_confidences(source, sure)), names)


def _is_point(value: Any) -> bool:
    """Whether a value is one point: an object with x and y, or as many numbers as a point has."""
    if isinstance(value, dict):
        return {"x", "y"} <= {str(key).lower() for key in value}
    return isinstance(value, list) and 0 < len(value) <= 4 and all(map(_is_number, value))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _kind(value: Any) -> str:
    if isinstance(value, dict):
        return f"an object with {', '.join(map(repr, list(value)[:6])) or 'nothing'}"
    return f"a list of {len(value)}" if isinstance(value, list) else repr(value)[:40]
