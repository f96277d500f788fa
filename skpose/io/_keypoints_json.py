"""Keypoints in JSON files: of OpenPose in 3-D, of MediaPipe's world landmarks, and in the style of COCO.

There is no standard, and programs write what their estimator returns. So a file is a frame, a list of frames, or has
one under a known key; a frame has its points under a known key, or is the points themselves.
"""

import json
import re
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import numpy as np

from skpose.io._arguments import PathLike
from skpose.io._error import MocapFormatError
from skpose.io._source import Source
from skpose.io._stored import FRAME, Stored, at_frames
from skpose.keypoints._shared import REMEDY

FRAMES = "frames", "instance_info", "results", "data"
RATES = "fps", "frame_rate", "frameRate", "framerate"
# Keys of points in three dimensions, the best first; then those of pictures.
WORLD = "pose_world_landmarks", "poseWorldLandmarks", "world_landmarks", "worldLandmarks", "hand_world_landmarks"
SPATIAL = *WORLD, "pose_keypoints_3d", "keypoints_3d", "keypoints3d", "keypoints3D"
PERSONS = "people", "instances", "annotations", "poses", "persons"
UNDECIDED = "keypoints", "joints", "points", "landmark"
FLAT = "pose_landmarks", "poseLandmarks", "landmarks", "pose_keypoints_2d", "pose_keypoints", "keypoints_2d"
SURE = "visibility", "confidence", "score", "likelihood", "presence"
SCORES = "keypoint_scores", "keypoints_scores", "scores"
COCO_FLAT = 3  # numbers a point, x, y and whether it is visible, in COCO's flat lists
OPENPOSE = 4  # x, y, z and 1 or 0, in OpenPose's


class Points(NamedTuple):
    """The points of one frame: rows of x, y, z, and how sure, NaN where it is not said."""

    names: list[str] | None
    rows: list[list[float]]


class Frames(NamedTuple):
    """The points of each frame, None where nobody is seen, and what the file says of them."""

    points: list[Points | None]
    names: list[str] | None
    frame_rate: float | None
    numbers: list[float] | None


class _Reader:
    """Finds the points of frames in a document; errors say where in it."""

    def __init__(self, source: Source, n_points: int | None):
        self.source, self.n_points = source, n_points

    def refuse(self, where: str, message: str) -> NoReturn:
        raise self.source.error(f"{where}: {message}" if where else message)

    def refuse_flat(self, where: str, what: str) -> NoReturn:
        self.refuse(where, f"these are keypoints in two dimensions, {what}. {REMEDY}")

    def frame(self, frame: Any, where: str) -> Points | None:
        """Return the points of the one person of a frame; None if nobody is seen."""
        if frame is None:
            return None
        if isinstance(frame, dict):
            if key := next((key for key in SPATIAL if frame.get(key) not in (None, [], {})), None):
                return self.with_scores(frame, key, where)
            if key := next((key for key in PERSONS if key in frame), None):
                return self.one(frame[key], f"{where}.{key}".lstrip("."))
            if key := next((key for key in UNDECIDED if key in frame), None):
                return self.with_scores(frame, key, where)
            if key := next((key for key in FLAT if frame.get(key) not in (None, [], {})), None):
                remedy = "; MediaPipe gives metres as pose_world_landmarks" if "andmarks" in key else ""
                self.refuse_flat(f"{where}.{key}".lstrip("."), f"in units of a picture{remedy}")
            if any(key in frame for key in (*SPATIAL, *FLAT)):
                return None  # nobody is seen
        return self.frame_of(frame, where, "")

    def with_scores(self, frame: dict, key: str, where: str) -> Points | None:
        """Return the points under a key, with the scores that the frame has next to them."""
        found = self.frame_of(frame[key], f"{where}.{key}".lstrip("."), key)
        scores = next((frame[one] for one in SCORES if isinstance(frame.get(one), list)), None)
        if found is None or scores is None:
            return found
        if len(scores) != len(found.rows):
            self.refuse(where, f"expected a score for each of {len(found.rows)} points, found {len(scores)}")
        rows = [[*row[:3], self.number(score, where)] for row, score in zip(found.rows, scores, strict=True)]
        return Points(found.names, rows)

    def one(self, people: Any, where: str) -> Points | None:
        """Return the points of the only person of a list."""
        if not isinstance(people, list):
            self.refuse(where, f"expected a list of people, found {_kind(people)}")
        if len(people) > 1:
            self.refuse(where, f"expected one person, found {len(people)}: keep the same one in every frame")
        return self.frame(people[0], f"{where}[0]") if people else None

    def frame_of(self, points: Any, where: str, key: str) -> Points | None:
        """Return the points under a key, which may be those of a list with one person."""
        if isinstance(points, dict) and set(points) >= {"landmark"}:
            points = points["landmark"]
        if points is None or points == [] or points == {}:
            return None
        if isinstance(points, dict):
            named = {name: point for name, point in points.items() if isinstance(point, dict | list)}
            if not named:
                self.refuse(where, f"expected points in three dimensions, found {_kind(points)}")
            return Points(list(named), [self.point(point, f"{where}.{name}") for name, point in named.items()])
        if not isinstance(points, list):
            self.refuse(where, f"expected points, found {_kind(points)}")
        first = points[0]
        if _is_number(first):
            return Points(None, self.flat(points, where, key))
        is_person = isinstance(first, dict) and not {"x", "X"} & first.keys()
        if is_person or (isinstance(first, list) and first and not _is_number(first[0])):
            return self.one(points, where)
        rows = [self.point(point, f"{where}[{i}]") for i, point in enumerate(points)]
        given = [point.get("name", point.get("part")) if isinstance(point, dict) else None for point in points]
        names = [name for name in given if isinstance(name, str)]
        if names and len(names) < len(rows):
            self.refuse(where, "some points have a name, and some have none")
        return Points(names or None, rows)

    def flat(self, numbers: list, where: str, key: str) -> list[list[float]]:
        """Return numbers without lists of points between them as rows."""
        n = len(numbers)
        if key == "pose_keypoints_3d":
            width = OPENPOSE
        elif self.n_points and n in (3 * self.n_points, 4 * self.n_points):
            width = n // self.n_points
        elif n % 12 == 0 and key in SPATIAL:
            self.refuse(where, f"{n} numbers may be {n // 3} or {n // 4} points: pass layout=, or names=")
        else:
            width = next((width for width in (COCO_FLAT, OPENPOSE) if n % width == 0), 0)
        if width == 0 or n % width:
            self.refuse(where, f"expected x, y, z and how sure of each point, found {n} numbers")
        if width == COCO_FLAT and key not in SPATIAL:
            self.refuse_flat(where, "COCO's x, y, and 0, 1 or 2 for how visible each point is")
        return [self.point(numbers[i : i + width], f"{where}[{i}]") for i in range(0, n, width)]

    def point(self, point: Any, where: str) -> list[float]:
        """Return x, y, z, and how sure, of a point; NaN where it is not seen or not said."""
        if point is None:
            return [np.nan] * 4
        if isinstance(point, dict):
            lower = {str(key).lower(): value for key, value in point.items()}
            if "x" in lower and "y" in lower and "z" not in lower:
                self.refuse_flat(where, "with x and y and no z")
            if not {"x", "y", "z"} <= lower.keys():
                self.refuse(where, f"expected a point with x, y and z, found {', '.join(map(repr, list(lower)[:6]))}")
            sure = next((lower[key] for key in SURE if key in lower), None)
            point = [lower["x"], lower["y"], lower["z"], sure]
        if not isinstance(point, list) or len(point) not in (2, 3, 4):
            found = f"{len(point)} numbers" if isinstance(point, list) else _kind(point)
            self.refuse(where, f"expected a point with x, y and z, found {found}")
        if len(point) == 2:
            self.refuse_flat(where, "with two numbers for each point")
        return [self.number(value, where) for value in (*point, None)[:4]]

    def number(self, value: Any, where: str) -> float:
        """Return a number; NaN for null."""
        if value is None:
            return np.nan
        if not _is_number(value):
            self.refuse(where, f"expected a number, found {_kind(value)}")
        try:
            return float(value)
        except OverflowError:
            self.refuse(where, "expected a number, found one of hundreds of digits")


def read_json(source: Source, n_points: int | None) -> Stored:
    """Return the positions of an open JSON file, of so many points if that is known."""
    found = _read_frames(source, n_points)
    stored = _stack(source, found.points, found.names)._replace(frame_rate=found.frame_rate)
    return at_frames(source, stored, found.numbers)


def json_files(folder: PathLike) -> list[Path]:
    """Return the JSON files of a folder, in the order of their last number, as OpenPose counts frames."""
    files = sorted(path for path in Path(folder).iterdir() if path.suffix.lower() == ".json")
    return sorted(files, key=lambda path: int(_last_number(path)))


def read_folder(source: Source, files: list[Path], n_points: int | None) -> Stored:
    """Return the positions of JSON files, one or more frames in each; errors name the file, or the source of all."""
    points: list[Points | None] = []
    for path in files:
        with Source(path, "a JSON file") as file:
            points += _read_frames(file, n_points).points
    numbers = None
    if len(points) == len(files) and all(_last_number(path) != "-1" for path in files):
        numbers = [float(_last_number(path)) for path in files]
    return at_frames(source, _stack(source, points, None), numbers)


def _last_number(path: Path) -> str:
    return next(iter(reversed(re.findall(r"\d{1,15}", path.stem))), "-1")


def _read_frames(source: Source, n_points: int | None) -> Frames:
    document = _parse(source)
    rate = names = None
    if isinstance(document, dict):
        rate = _rate(source, document)
        names = _category_names(document)
    reader = _Reader(source, len(names) if names else n_points)
    frames, where = _frames(reader, document)
    points = [reader.frame(frame, f"{where}[{i}]" if where is not None else "") for i, frame in enumerate(frames)]
    return Frames(points, names, rate, _numbers(reader, frames))


def _parse(source: Source) -> Any:
    text = b"".join(chunk.text for chunk in source.chunks())
    try:
        return json.loads(text.removeprefix(b"\xef\xbb\xbf").decode("utf-8", errors="replace"))
    except json.JSONDecodeError as error:
        raise MocapFormatError(
            source.name, error.lineno, f"JSON is damaged or cut short: {error.msg}", error.colno
        ) from None
    except RecursionError:
        raise source.error("lists within lists within lists, deeper than any keypoints") from None
    except ValueError as error:  # of numbers of thousands of digits
        raise source.error(f"JSON is damaged: {error}") from None


def _frames(reader: _Reader, document: Any) -> tuple[list, str | None]:
    """Return the frames of a document, and under which key they are; None if it is one frame."""
    if isinstance(document, dict):
        if "annotations" in document and "images" in document:
            return _coco_frames(reader, document), "images"
        for key in FRAMES:
            if isinstance(document.get(key), list):
                return document[key], key
        times = document.get("timestamps")
        for key in WORLD:  # with a time for each they are frames; else they are people
            if isinstance(times, list) and isinstance(document.get(key), list) and len(times) == len(document[key]):
                return document[key], key
        return [document], None
    if not isinstance(document, list):
        reader.refuse("", f"expected keypoints, found {_kind(document)}")
    if not document:
        reader.refuse("", "expected keypoints, found an empty list")
    first = document[0]
    is_point = isinstance(first, dict) and {"x", "y"} <= {str(key).lower() for key in first}
    if is_point or _is_number(first) or (isinstance(first, list) and first and _is_number(first[0])):
        return [document], None
    return document, ""


def _coco_frames(reader: _Reader, document: dict) -> list:
    """Return the annotations of each image of a COCO file."""
    for key in ("images", "annotations"):
        if not isinstance(document[key], list) or not all(isinstance(one, dict) for one in document[key]):
            reader.refuse(key, "expected a list of objects, as in COCO's files")
    found: dict[Any, list] = {}
    for i, image in enumerate(document["images"]):
        if str(image.get("id")) in found:
            reader.refuse(f"images[{i}]", f"the id {image.get('id')!r} is that of an image before")
        found[str(image.get("id"))] = []
    for i, annotation in enumerate(document["annotations"]):
        if str(annotation.get("image_id")) not in found:
            reader.refuse(f"annotations[{i}]", f"there is no image of the id {annotation.get('image_id')!r}")
        found[str(annotation.get("image_id"))].append(annotation)
    return [{"annotations": people} for people in found.values()]


def _category_names(document: dict) -> list[str] | None:
    """Return the names of the points of a COCO or MMPose file."""
    for key in ("categories", "meta_info"):
        value = document.get(key)
        value = value[0] if isinstance(value, list) and value else value
        if isinstance(value, dict):
            names = value.get("keypoints", value.get("keypoint_names"))
            by_id = value.get("keypoint_id2name")
            if isinstance(by_id, dict) and all(str(i) in by_id for i in range(len(by_id))):
                names = [by_id[str(i)] for i in range(len(by_id))]
            if isinstance(names, list) and names and all(isinstance(name, str) for name in names):
                return names
    return None


def _rate(source: Source, document: dict) -> float | None:
    found = next((document[key] for key in RATES if key in document), None)
    if found is None:
        return None
    if not _is_number(found) or not 0 < found < 1e9 or not np.isfinite(1.0 / found):
        raise source.error(f"fps: expected a positive number, found {str(found)[:40]}")
    return float(found)


def _numbers(reader: _Reader, frames: list) -> list[float] | None:
    """Return the number of each frame, if all say it."""
    key = next((key for key in FRAME if all(isinstance(one, dict) and key in one for one in frames)), None)
    if key is None:
        return None
    return [reader.number(one[key], f"[{i}].{key}") for i, one in enumerate(frames)]


def _stack(source: Source, frames: list[Points | None], names: list[str] | None) -> Stored:
    """Return the points of all frames as arrays, by their names if they have any."""
    seen = [points for points in frames if points is not None]
    if not seen:
        raise source.error("expected keypoints in three dimensions, found none in any frame")
    if any((points.names is None) != (seen[0].names is None) for points in seen):
        raise source.error("points have names in some frames, and none in others")
    if seen[0].names is not None:
        names = list(dict.fromkeys(name for points in seen for name in points.names or ()))
    elif len({len(points.rows) for points in seen}) > 1 or (names and len(names) != len(seen[0].rows)):
        counts = sorted({len(points.rows) for points in seen} | {len(names or seen[0].rows)})
        raise source.error(f"expected the same number of points in every frame, found {counts[0]} and {counts[-1]}")
    array = np.full((len(frames), len(names or seen[0].rows), 4), np.nan)
    index = {name: i for i, name in enumerate(names or ())}
    for frame, points in zip(array, frames, strict=True):
        if points is not None:
            frame[[index[name] for name in points.names] if points.names is not None else slice(None)] = points.rows
    return Stored(array[:, :, :3], _confidences(array), names)


def _confidences(array: np.ndarray) -> np.ndarray | None:
    """Return how sure each point is; COCO's 1 and 2 are seen, and so are scores above 1."""
    sure = array[:, :, 3]
    if np.isnan(sure).all():
        return None
    return np.where(np.isnan(sure), ~np.isnan(array[:, :, :3]).any(axis=2), np.minimum(sure, 1.0))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _kind(value: Any) -> str:
    if isinstance(value, dict):
        return f"an object with {', '.join(map(repr, list(value)[:6])) or 'nothing'}"
    return f"a list of {len(value)}" if isinstance(value, list) else repr(value)[:40]
