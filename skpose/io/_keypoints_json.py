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
    numbers_of,
    positions_only,
    time_key,
)
from skpose.keypoints._pictures import REMEDY, complaint_of_flat

# Keys of a frame: of its people in OpenPose, MMPose and COCO; of points in three dimensions in OpenPose, MediaPipe and
# TensorFlow.js; of points in two or three dimensions; and of points in a picture.
PEOPLE = "people", "instances", "annotations"
SPATIAL = (
    *("pose_keypoints_3d", "pose_world_landmarks", "worldLandmarks", "hand_world_landmarks"),
    *("keypoints_3d", "keypoints3D"),
)
POINTS = "keypoints"
FLAT = "pose_keypoints_2d", "pose_landmarks", "landmarks"
SURE = "visibility", "confidence", "score", "likelihood", "presence"
SCORES = "keypoint_scores", "keypoints_scores", "scores"  # of all points, next to them
TIMES = "timestamps", "times"  # of all frames, next to them


Entry = tuple[Any, Any]  # a frame as it is in the document, and its number, None if it has none


class Frame(NamedTuple):
    """The points of one frame."""

    names: list[str] | None
    rows: np.ndarray  # (n_points, 4): x, y, z, and how sure, NaN where it is not said


def is_json(source: Source) -> bool:
    return source.kind == "text" and source.head.lstrip()[:1] in ("{", "[")


def read_json(source: Source, n_points: int | None) -> Stored:
    """The positions of a JSON file, of this many points if that is known."""
    document = _parse(source)
    names = rate = None
    if isinstance(document, dict):
        names = _category_names(document)
        if (given := document.get("fps", document.get("frame_rate"))) is not None:
            rate = float(given) if _is_number(given) else np.nan
            if not (rate > 0.0 and np.isfinite(rate) and np.isfinite(1.0 / rate)):
                raise source.error(f"fps: expected a positive number, found {str(given)[:40]}")
    n_points = len(names) if names else n_points
    entries = _list_entries(source, document, n_points)
    times = {key: document[key] for key in TIMES if key in document} if isinstance(document, dict) else {}
    return _read_entries(source, entries, names, n_points, times)._replace(frame_rate=rate)


def json_files(folder: PathLike) -> list[Path]:
    """The JSON files of a folder, in the order of their last number, as OpenPose counts frames."""
    files = sorted(path for path in Path(folder).iterdir() if path.suffix.lower() == ".json")
    return sorted(files, key=_last_number)


def _last_number(path: Path) -> int:
    return int((re.findall(r"\d{1,15}", path.stem) or ["-1"])[-1])


def read_folder(source: Source, files: list[Path], n_points: int | None) -> Stored:
    """The positions of JSON files, a frame or a part of the frames in each; `source` is for errors."""
    sources = [Source(path, "a JSON file") for path in files]
    parts = [_list_entries(one, _parse(one), n_points) for one in sources]
    if all(len(part) == 1 for part in parts) and all(_last_number(path) >= 0 for path in files):
        parts = [[(part[0][0], _last_number(path))] for part, path in zip(parts, files, strict=True)]
    return _read_entries(source, [entry for part in parts for entry in part], None, n_points)


def _parse(source: Source) -> Any:
    try:
        return json.loads(source.data.decode(errors="replace"))
    except json.JSONDecodeError as error:
        message = f"JSON is damaged or cut short: {error.msg}"
        raise MocapFormatError(source.name, error.lineno, message, error.colno) from None
    except (RecursionError, ValueError) as error:  # lists within lists, and numbers of thousands of digits
        raise source.error(f"JSON is damaged: {error}") from None


def _list_entries(source: Source, document: Any, n_points: int | None) -> list[Entry]:
    """The frames of a document, which may be one of them, in the order of their numbers."""
    if isinstance(document, dict):
        if "annotations" in document and "images" in document:
            return _coco_entries(source, document)
        frames = document.get("frames", document.get("instance_info"))  # the latter of MMPose
        if isinstance(frames, list):
            return _with_numbers(source, frames)
        if isinstance(frames, dict):
            if (numbers := numbers_of(list(frames))) is None:
                raise source.error(f"frames: expected a list, or an object by numbers, found {_kind(frames)}")
            return _sort(list(frames.values()), numbers)
        numbered = {key: value for key, value in document.items() if key.isdecimal() and len(key) < 100}
        others = [value for key, value in document.items() if key not in numbered and isinstance(value, dict | list)]
        if not numbered or others or any(map(_is_point, numbered.values())):
            return [(document, None)]
        return _sort(list(numbered.values()), [float(key) for key in numbered])
    if not isinstance(document, list) or not document:
        raise source.error(f"expected keypoints, found {_kind(document)}")
    first = document[0]
    if isinstance(first, list) and first and _is_number(first[0]):
        is_frame = n_points and len(first) in (3 * n_points, 4 * n_points) and (n_points > 1 or len(document) > 1)
    else:
        is_frame = not _is_number(first) and not _is_point(first)
    return _with_numbers(source, document) if is_frame else [(document, None)]


def _with_numbers(source: Source, frames: list) -> list[Entry]:
    """The frames with their numbers, if all that are not null have one; null ones follow the frame before."""
    seen = [frame for frame in frames if frame is not None]
    keys = [frame_key(frame) if isinstance(frame, dict) else None for frame in seen]
    if not any(keys):
        return [(frame, None) for frame in frames]
    if len(set(keys)) > 1:
        raise source.error("expected the number of a frame in each of them, or in none")
    key = str(keys[0])
    values = [frame[key] for frame in seen]
    numbers = numbers_of(values)
    if numbers is None and not ("image" in key.lower() and all(isinstance(value, str) for value in values)):
        raise source.error(f"{key}: expected the numbers of frames, found {str(values[0])[:40]!r}")
    if len(set(numbers or values)) < len(values):
        raise source.error(f"{key}: expected each frame once, with one person: keep the same person in every frame")
    if numbers is None:
        return [(frame, None) for frame in frames]
    given, number, entries = iter(numbers), numbers[0] - frames.index(seen[0]) - 1.0, list[Entry]()
    for frame in frames:
        number = number + 1.0 if frame is None else next(given)
        entries.append((frame, number))
    return entries


def _sort(frames: list, numbers: list[float]) -> list[Entry]:
    return sorted(zip(frames, numbers, strict=True), key=lambda entry: entry[1])


def _coco_entries(source: Source, document: dict) -> list[Entry]:
    """The annotations of each image of a COCO file, by its number, that in the name of its file, or its id."""
    images, annotations = document["images"], document["annotations"]
    if not all(isinstance(one, list) and all(isinstance(x, dict) for x in one) for one in (images, annotations)):
        raise source.error("images and annotations: expected lists of objects, as in COCO's files")
    people: dict[str, list] = {str(image.get("id")): [] for image in images}
    for annotation in annotations:
        if (key := str(annotation.get("image_id"))) not in people:
            raise source.error(f"annotations: there is no image of the id {key[:40]}")
        people[key].append(annotation)
    if len(people) < len(images):
        raise source.error("images: expected a different id of each")
    frames = [{"annotations": one} for one in people.values()]
    for name in (frame_key(images[0]) if images else None, "file_name", "id"):
        numbers = numbers_of([image.get(name) for image in images])
        if numbers is not None and len(set(numbers)) == len(images):
            return _sort(frames, numbers)
    return [(frame, None) for frame in frames]


def _category_names(document: dict) -> list[str] | None:
    """The names of the points of a COCO or MMPose file."""
    categories = document.get("categories")
    category = categories[0] if isinstance(categories, list) and categories else document.get("meta_info")
    if not isinstance(category, dict):
        return None
    by_id = category.get("keypoint_id2name")
    names = category.get("keypoints") or (list(by_id.values()) if isinstance(by_id, dict) else None)
    return names if isinstance(names, list) and names and all(isinstance(name, str) for name in names) else None


def _read_entries(
    source: Source,
    entries: list[Entry],
    names: list[str] | None,
    n_points: int | None,
    times: dict[str, Any] | None = None,  # next to the frames
) -> Stored:
    """The points of all frames as arrays, by their names if they have any, where their numbers say."""
    reader = _Reader(source, n_points)
    frames = [reader.frame(frame) for frame, _ in entries]
    if complaint := complaint_of_flat(reader.flat):
        raise reader.flat_error(f"{complaint}. If the third numbers are z, write keypoints_3d")
    seen = [frame for frame in frames if frame is not None]
    if len({frame.names is None for frame in seen}) != 1:
        raise source.error("expected keypoints in three dimensions, all with names or all without, found none")
    if seen[0].names is not None:
        names = positions_only(source, list(dict.fromkeys(name for frame in seen for name in frame.names or ())))
    counts = {len(names)} if names else set()
    counts |= {len(frame.rows) for frame in seen if frame.names is None}
    if len(counts) != 1:
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
    confidences = None
    if not np.isnan(sure).all():
        is_seen = ~np.isnan(positions).any(axis=2)
        confidences = np.where(np.isnan(sure), is_seen, as_confidences(source, sure))
    numbers = [number for _, number in entries]
    numbers_or_none = None if None in numbers else numbers
    keys = {time_key(frame) if isinstance(frame, dict) else None for frame, _ in entries}
    by_key = {key: [frame[key] for frame, _ in entries] for key in keys if key and len(keys) == 1} | (times or {})
    stored = Stored(positions, confidences, names)
    for key, values in by_key.items():
        if isinstance(values, list) and len(values) == len(entries) and all(map(_is_number, values)):
            stored = stored._replace(times=Times(key, reader.numbers(values), numbers_or_none))
    return at_frames(source, stored, numbers_or_none)


class _Reader:
    """Finds the points of each frame of a document."""

    def __init__(self, source: Source, n_points: int | None):
        self.source, self.n_points = source, n_points
        self.flat: list[list[list[float]]] = []  # frames of three numbers a point: x, y, z or COCO's x, y, v

    def flat_error(self, what: str) -> MocapFormatError:
        return self.source.error(f"these are keypoints in two dimensions: {what}. {REMEDY}")

    def frame(self, frame: Any) -> Frame | None:
        """The points of the one person of a frame; None without a person."""
        if not isinstance(frame, dict):
            return self.points(frame, "")
        keys = [key for key in (*SPATIAL, *PEOPLE, POINTS, *FLAT) if key in frame]
        key = next((key for key in keys if frame[key] not in (None, [], {})), None)
        if key in PEOPLE:
            return self.one(frame[key])
        if key in FLAT:
            raise self.flat_error(f"{key} are in units of a picture")
        if key is None:
            return None if keys else self.points(frame, "")
        found = self.points(frame[key], key)
        given = next((one for one in SCORES if isinstance(frame.get(one), list | dict)), None)
        if found is not None and given is not None:
            scores = frame[given]
            if not isinstance(scores, list) or len(scores) != len(found.rows):
                raise self.source.error(f"{given}: expected {len(found.rows)} numbers, found {_kind(scores)}")
            found.rows[:, 3] = self.numbers(scores)
        return found

    def one(self, people: Any) -> Frame | None:
        """The points of the only person of a list."""
        if not isinstance(people, list) or len(people) > 1:
            found = len(people) if isinstance(people, list) else _kind(people)
            raise self.source.error(f"expected one person, found {found}: keep the same one in every frame")
        return self.frame(people[0])

    def points(self, points: Any, key: str) -> Frame | None:
        """The points under a key: rows, objects, objects by name, or all numbers in one list."""
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
        """Numbers without lists of points between them as rows."""
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
        """X, y, z, and how sure, of points; NaN where one is not seen or it is not said."""
        return self.numbers([self.point(point) for point in points]).reshape(-1, 4)

    def point(self, point: Any) -> list:
        if point is None:
            return [None] * 4
        if isinstance(point, dict):
            lower = {str(key).lower(): value for key, value in point.items()}
            if "w" in lower:
                raise self.source.error("expected a point with x, y and z, found x, y, z and w, as of a rotation")
            if {"x", "y", "z"} <= lower.keys():
                return [lower["x"], lower["y"], lower["z"], next((lower[key] for key in SURE if key in lower), None)]
        elif isinstance(point, list) and len(point) in (3, 4):
            return [*point, None][:4]
        if _is_point(point):
            raise self.flat_error("points have x and y, and no z")
        raise self.source.error(f"expected a point with x, y and z, found {_kind(point)}: pass layout= or names=?")

    def numbers(self, values: list) -> np.ndarray:
        """Numbers as an array, NaN for null."""
        try:
            return np.array(values, dtype=np.float64)
        except (TypeError, ValueError, OverflowError) as error:
            raise self.source.error(f"expected numbers: {error}") from None


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
