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
from skpose.io._frame_times import Times, time_key
from skpose.io._source import Source
from skpose.io._stored import Stored, as_confidences, at_frames, frame_key, frame_numbers, numbers_in, positions_only
from skpose.keypoints._shared import REMEDY, complaint_of_flat

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
TIMES = "timestamps", "times"
MOST_DIGITS = 100  # of the number of a frame
COCO_FLAT = 3  # numbers a point, x, y and whether it is visible, in COCO's flat lists
OPENPOSE = 4  # x, y, z and 1 or 0, in OpenPose's


class Points(NamedTuple):
    """The points of one frame: rows of x, y, z, and how sure, NaN where it is not said."""

    names: list[str] | None
    rows: list[list[float]]


class Listed(NamedTuple):
    """The frames of a document as they are there, where each is, and what the document says of them."""

    frames: list[Any]
    where: list[str]
    numbers: list[float] | None = None
    times: list[Any] | None = None


class Frames(NamedTuple):
    """The points of each frame, None where nobody is seen, and what the file says of them."""

    points: list[Points | None]
    names: list[str] | None
    frame_rate: float | None
    numbers: list[float] | None
    times: Times | None


class _Reader:
    """Finds the points of frames in a document; errors say where in it."""

    def __init__(self, source: Source, n_points: int | None):
        self.source, self.n_points = source, n_points
        self.flat_frames: dict[str, list] = {}  # of three numbers a point, x, y, z or COCO's x, y, v, by their places

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
            return Points(
                list(named), [self.point(point, f"{where}.{name}".lstrip(".")) for name, point in named.items()]
            )
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
        rows = [self.point(numbers[i : i + width], f"{where}[{i}]") for i in range(0, n, width)]
        if width == COCO_FLAT and key not in SPATIAL:
            self.flat_frames[where] = [row[:3] for row in rows]
        return rows

    def check_flat(self) -> None:
        """Refuse flat lists of three numbers for each point of which the third ones are not plainly z."""
        if complaint := complaint_of_flat(list(self.flat_frames.values())):
            self.refuse_flat(
                next(iter(self.flat_frames)),
                f"x, y, and how visible or how sure each point is: {complaint}. If the third numbers are z, write "
                "keypoints_3d, or lists of [x, y, z]",
            )

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
            if "w" in lower:
                self.refuse(where, "expected a point with x, y and z, found x, y, z and w, as of a rotation")
            point = [lower["x"], lower["y"], lower["z"], sure]
        if not isinstance(point, list) or len(point) not in (2, 3, 4):
            found = f"{len(point)} numbers" if isinstance(point, list) else _kind(point)
            if isinstance(point, list) and point and isinstance(point[0], list | dict):
                found = f"a list of {len(point)} points; frames are a list, or an object by their numbers"
            elif isinstance(point, list) and len(point) > OPENPOSE and self.n_points is None:
                found += "; if these are the points of a frame, pass layout=, or names="
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
    stored = _stack(source, found.points, found.names)._replace(frame_rate=found.frame_rate, times=found.times)
    return at_frames(source, stored, found.numbers)


def json_files(folder: PathLike) -> list[Path]:
    """Return the JSON files of a folder, in the order of their last number, as OpenPose counts frames."""
    files = sorted(path for path in Path(folder).iterdir() if path.suffix.lower() == ".json")
    return sorted(files, key=lambda path: int(_last_number(path)))


def read_folder(source: Source, files: list[Path], n_points: int | None) -> Stored:
    """Return the positions of JSON files, one or more frames in each; errors name the file, or the source of all."""
    parts = []
    for path in files:
        with Source(path, "a JSON file") as file:
            parts.append(_read_frames(file, n_points))
    points = [one for part in parts for one in part.points]
    numbers: list[float] | None = None
    if len(points) == len(files):
        if all(_last_number(path) != "-1" for path in files):
            numbers = [float(_last_number(path)) for path in files]
    elif all(part.numbers is not None for part in parts):
        numbers = [number for part in parts for number in part.numbers or ()]
    stored = _stack(source, points, None)
    times = [part.times for part in parts if part.times is not None]
    if len(times) == len(parts) and len({one.key for one in times}) == 1:
        values = np.concatenate([one.values for one in times])
        stored = stored._replace(times=Times(times[0].key, values, None if numbers is None else np.array(numbers)))
    return at_frames(source, stored, numbers)


def _last_number(path: Path) -> str:
    return next(iter(reversed(re.findall(r"\d{1,15}", path.stem))), "-1")


def _read_frames(source: Source, n_points: int | None) -> Frames:
    document = _parse(source)
    rate = names = None
    if isinstance(document, dict):
        rate = _rate(source, document)
        names = _category_names(document)
    reader = _Reader(source, len(names) if names else n_points)
    listed = _list_frames(reader, document)
    points = [reader.frame(frame, where) for frame, where in zip(listed.frames, listed.where, strict=True)]
    reader.check_flat()
    numbers = _numbers(reader, listed)
    return Frames(points, names, rate, numbers, _times(listed, numbers))


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


def _list_frames(reader: _Reader, document: Any) -> Listed:
    """Return the frames of a document, which may be one of them."""
    if isinstance(document, dict):
        times = next((document[key] for key in TIMES if isinstance(document.get(key), list)), None)
        if "annotations" in document and "images" in document:
            return _coco_frames(reader, document)
        for key in FRAMES:
            if isinstance(document.get(key), list):
                return _list(document[key], key, times)
            by_number = document.get(key)
            if isinstance(by_number, dict) and (found := _by_number(by_number, f"{key}.", key == FRAMES[0])):
                return found
            if isinstance(by_number, dict) and key == FRAMES[0]:
                reader.refuse(
                    key, f"expected a list of frames, or an object by their numbers, found {_kind(by_number)}"
                )
        for key in WORLD:  # with a time for each they are frames; else they are people
            if times is not None and isinstance(document.get(key), list) and len(times) == len(document[key]):
                return _list(document[key], key, times)
        return _by_number(document, "") or Listed([document], [""])
    if not isinstance(document, list):
        reader.refuse("", f"expected keypoints, found {_kind(document)}")
    if not document:
        reader.refuse("", "expected keypoints, found an empty list")
    first = document[0]
    if isinstance(first, list) and first and _is_number(first[0]):
        n = reader.n_points
        is_frame = n is not None and len(first) in (3 * n, 4 * n) and (n > 1 or len(document) > 1)
        return _list(document, "") if is_frame else Listed([document], [""])
    return Listed([document], [""]) if _is_number(first) or _is_point(first) else _list(document, "")


def _list(frames: list, key: str, times: list | None = None) -> Listed:
    """Return the frames of a list, with their times if there is one for each."""
    has_times = times is not None and len(times) == len(frames)
    return Listed(frames, [f"{key}[{i}]" for i in range(len(frames))], times=times if has_times else None)


def _by_number(frames: dict, where: str, are_frames: bool = False) -> Listed | None:
    """Return the frames of an object whose keys are their numbers, in the order of these; None if they are not."""
    numbered = {key: float(key) for key in frames if key.isdecimal() and len(key) < MOST_DIGITS}
    if are_frames and not numbered and (numbers := numbers_in(list(frames))) is not None:
        numbered = dict(zip(frames, numbers, strict=True))
    others_are_frames = any(isinstance(frames[key], dict | list) for key in frames.keys() - numbered.keys())
    if not numbered or others_are_frames or any(_is_point(frames[key]) for key in numbered):
        return None
    keys = sorted(numbered, key=numbered.__getitem__)
    return Listed([frames[key] for key in keys], [f"{where}{key}" for key in keys], [numbered[key] for key in keys])


def _coco_frames(reader: _Reader, document: dict) -> Listed:
    """Return the annotations of each image of a COCO file, in the order of the images' numbers."""
    for key in ("images", "annotations"):
        if not isinstance(document[key], list) or not all(isinstance(one, dict) for one in document[key]):
            reader.refuse(key, "expected a list of objects, as in COCO's files")
    images, found = document["images"], dict[str, list]()
    for i, image in enumerate(images):
        if str(image.get("id")) in found:
            reader.refuse(f"images[{i}]", f"the id {image.get('id')!r} is that of an image before")
        found[str(image.get("id"))] = []
    for i, annotation in enumerate(document["annotations"]):
        if str(annotation.get("image_id")) not in found:
            reader.refuse(f"annotations[{i}]", f"there is no image of the id {annotation.get('image_id')!r}")
        found[str(annotation.get("image_id"))].append(annotation)
    where = [f"images[{i}]" for i in range(len(images))]
    listed = Listed([{"annotations": people} for people in found.values()], where)
    numbers = _image_numbers(reader, Listed(images, where))
    if numbers is None:
        return listed
    order = sorted(range(len(images)), key=numbers.__getitem__)
    return Listed([listed.frames[i] for i in order], [where[i] for i in order], [numbers[i] for i in order])


def _image_numbers(reader: _Reader, images: Listed) -> list[float] | None:
    """Return the number of the frame of each image: its own, the one in the name of its file, or its id."""
    if (numbers := _numbers(reader, images)) is not None:
        return numbers
    for key in ("file_name", "id"):
        values = [image.get(key) for image in images.frames]
        if len(values) > 1 and all(isinstance(value, str) for value in values):
            numbers = numbers_in(values)
        elif all(_is_number(value) for value in values):
            numbers = values
        if numbers is not None and len(set(numbers)) == len(numbers):
            return numbers
    return None


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


def _numbers(reader: _Reader, listed: Listed) -> list[float] | None:
    """Return the number of each frame, if all say it."""
    if listed.numbers is not None:
        return listed.numbers
    frames = [one for one in listed.frames if one is not None]
    if not frames or not all(isinstance(one, dict) for one in frames):
        return None
    key = frame_key([key for key in frames[0] if all(key in one for one in frames)])
    if key is None:
        has_number = [frame_key(one) is not None for one in frames]
        if any(has_number):
            reader.refuse("", f"{sum(has_number)} of {len(frames)} frames have a number: expected one in each, or none")
        return None
    values = [one[key] if isinstance(one[key], str) else reader.number(one[key], key) for one in frames]
    numbers = frame_numbers(reader.source, values, key)
    if numbers is None or len(frames) == len(listed.frames):
        return numbers
    given, all_of_them = iter(numbers), list[float]()
    for one in listed.frames:  # one in which nobody is seen follows the one before
        all_of_them.append(next(given) if one is not None else all_of_them[-1] + 1.0 if all_of_them else np.nan)
    return all_of_them


def _times(listed: Listed, numbers: list[float] | None) -> Times | None:
    """Return the time of each frame, if all say it as a number."""
    key, values = TIMES[0], listed.times
    if values is None:
        frames = listed.frames
        keys = [time_key(one) for one in frames if isinstance(one, dict)]
        if len(keys) < len(frames) or not keys or keys[0] is None or len(set(keys)) > 1:
            return None
        key = keys[0]
        values = [one[key] for one in frames]
    if not all(_is_number(value) and abs(value) < 1e300 for value in values):
        return None
    return Times(key, np.array(values, dtype=np.float64), None if numbers is None else np.array(numbers))


def _stack(source: Source, frames: list[Points | None], names: list[str] | None) -> Stored:
    """Return the points of all frames as arrays, by their names if they have any."""
    seen = [points for points in frames if points is not None]
    if not seen:
        raise source.error("expected keypoints in three dimensions, found none in any frame")
    if any((points.names is None) != (seen[0].names is None) for points in seen):
        raise source.error("points have names in some frames, and none in others")
    if seen[0].names is not None:
        names = positions_only(source, list(dict.fromkeys(name for points in seen for name in points.names or ())))
    elif len({len(points.rows) for points in seen}) > 1 or (names and len(names) != len(seen[0].rows)):
        counts = sorted({len(points.rows) for points in seen} | {len(names or seen[0].rows)})
        raise source.error(f"expected the same number of points in every frame, found {counts[0]} and {counts[-1]}")
    array = np.full((len(frames), len(names or seen[0].rows), 4), np.nan)
    index = {name: i for i, name in enumerate(names or ())}
    for frame, points in zip(array, frames, strict=True):
        if points is not None and points.names is not None:
            chosen = [i for i, name in enumerate(points.names) if name in index]
            frame[[index[points.names[i]] for i in chosen]] = np.reshape([points.rows[i] for i in chosen], (-1, 4))
        elif points is not None:
            frame[:] = points.rows
    return Stored(array[:, :, :3], _confidences(source, array), names)


def _confidences(source: Source, array: np.ndarray) -> np.ndarray | None:
    """Return how sure each point is; where it is not said, whether it is seen."""
    sure = array[:, :, 3]
    if np.isnan(sure).all():
        return None
    found = as_confidences(source, np.nan_to_num(sure, posinf=np.inf))
    return np.where(np.isnan(sure), ~np.isnan(array[:, :, :3]).any(axis=2), found)


def _is_point(value: Any) -> bool:
    """Return whether a value is one point: an object with x and y, or as many numbers as a point has."""
    if isinstance(value, dict):
        return {"x", "y"} <= {str(key).lower() for key in value}
    return isinstance(value, list) and 0 < len(value) <= OPENPOSE and all(map(_is_number, value))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _kind(value: Any) -> str:
    if isinstance(value, dict):
        return f"an object with {', '.join(map(repr, list(value)[:6])) or 'nothing'}"
    return f"a list of {len(value)}" if isinstance(value, list) else repr(value)[:40]
