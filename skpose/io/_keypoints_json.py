"""Keypoints in JSON files, in the forms of OpenPose in 3-D, MediaPipe, COCO and MMPose.

A file is a frame, a list of frames, or has one under a key; a frame has its points under a key of one of these tools,
or is the points themselves.
"""

import json
from operator import itemgetter
from reprlib import repr  # abbreviates
from typing import Any

import numpy as np

from skpose.io._conventions import (
    Stored,
    Times,
    as_confidences,
    at_frames,
    frame_key,
    frame_numbers,
    numbers_of,
    positions_only,
    time_key,
)
from skpose.io._source import MocapFormatError, Source, last_number
from skpose.keypoints._checks import REMEDY

# Keys of a frame: of its people in OpenPose, MMPose and COCO; of points in three dimensions in OpenPose, MediaPipe and
# TensorFlow.js, or of points in two or three; and of points in a picture.
PEOPLE = "people", "instances", "annotations"
POINTS = (
    *("pose_keypoints_3d", "pose_world_landmarks", "worldLandmarks", "hand_world_landmarks"),
    *("keypoints_3d", "keypoints3D", "keypoints"),
)
AMBIGUOUS = "keypoints", ""  # a third number may be z, a score or COCO's visibility
PICTURE = "pose_keypoints_2d", "pose_landmarks", "landmarks"
SURE = "visibility", "confidence", "score", "likelihood", "presence"
SCORES = "keypoint_scores", "keypoints_scores", "scores"  # of all points, next to them
TIMES = "timestamps", "times"  # of all frames, next to them

Entry = tuple[Any, Any]  # a frame as it is in the document, and its number, None if it has none
UNSEEN = [None] * 4
Points = dict[Any, list]  # x, y, z and the confidence of each point, by its name or by its index; None if not known


def is_json(source: Source) -> bool:
    return source.kind == "text" and source.head.lstrip()[:1] in ("{", "[")


def read_json(source: Source, n_points: int | None) -> Stored:
    """The positions of a JSON file, of this many points if that is known."""
    document = parse_json(source)
    whole = document if isinstance(document, dict) else {}
    names = _category_names(whole)
    n_points = len(names) if names else n_points
    parts = zip(source.parts, document, strict=True) if source.parts else [(source, document)]
    frames = [_list_entries(part, content) for part, content in parts]
    numbers = [last_number(part.name) for part in source.parts]
    if max(map(len, frames)) == 1 and min(numbers, default=-1) >= 0:
        frames = [[(frame, number)] for ((frame, _),), number in zip(frames, numbers, strict=True)]
    stored = _read_entries(source, [entry for part in frames for entry in part], names, n_points, whole)
    return stored._replace(frame_rate=whole.get("fps", whole.get("frame_rate")))


def parse_json(source: Source) -> Any:
    """The document of a file, or the list of those of the files of a folder."""
    if source.parts:
        return [parse_json(part) for part in source.parts]
    try:
        return json.loads(source.data.decode(errors="replace"))
    except json.JSONDecodeError as error:
        raise MocapFormatError(
            source.name, error.lineno, f"JSON is damaged or cut short: {error.msg}", error.colno
        ) from None
    except (RecursionError, ValueError) as error:  # lists within lists, and numbers of thousands of digits
        raise source.error(f"JSON is damaged: {error}") from None


def _list_entries(source: Source, document: Any) -> list[Entry]:
    """The frames of a document, which may be one of them, in the order of their numbers."""
    if isinstance(document, dict):
        if "annotations" in document and "images" in document:
            return _coco_entries(source, document)
        numbered = {key: value for key, value in document.items() if key.isdecimal() and len(key) < 100}
        others = [value for key, value in document.items() if key not in numbered and isinstance(value, dict | list)]
        frames = document.get("frames", document.get("instance_info"))  # the latter of MMPose
        if numbered and not others and not any(map(_is_point, numbered.values())):
            frames = numbered
        if isinstance(frames, dict):
            numbers = frame_numbers(source, "frames", list(frames))
            return sorted(zip(frames.values(), numbers or (), strict=True), key=itemgetter(1))
        listed: list = next((document[key] for key in POINTS if isinstance(document.get(key), list)), [])
        if any(isinstance(document.get(key), list) and len(document[key]) == len(listed) > 0 for key in TIMES):
            frames = listed
            if any(key in document for key in SCORES):
                raise source.error("expected scores in each frame, found them next to the list of frames")
        return _with_numbers(source, frames) if isinstance(frames, list) else [(document, None)]
    if not isinstance(document, list) or not document:
        raise source.error(f"expected keypoints, found {repr(document)}")
    first = document[0]
    return [(document, None)] if _is_number(first) or _is_point(first) else _with_numbers(source, document)


def _with_numbers(source: Source, frames: list) -> list[Entry]:
    """The frames with their numbers, if they have any; then those that are null are where no number is."""
    seen = [frame for frame in frames if frame is not None]
    key = next((key for frame in seen if isinstance(frame, dict) and (key := frame_key(frame))), None)
    if key is None:
        return [(frame, None) for frame in frames]
    numbers = frame_numbers(source, key, [frame.get(key) if isinstance(frame, dict) else None for frame in seen])
    return [(frame, None) for frame in frames] if numbers is None else list(zip(seen, numbers, strict=True))


def _coco_entries(source: Source, document: dict) -> list[Entry]:
    """The annotations of each image of a COCO file, by its number, that in the name of its file, or its id."""
    images = document["images"]
    try:
        people: dict[Any, list] = {image["id"]: [] for image in images}
        for annotation in document["annotations"]:
            people[annotation["image_id"]].append(annotation)
        key = frame_key(images[0])
    except (KeyError, TypeError, IndexError, AttributeError):
        raise source.error("expected images with an id, and annotations with the id of one as image_id") from None
    if len(people) < len(images):
        raise source.error("images: expected a different id of each")
    for name in (key, "file_name", "id"):
        numbers = numbers_of([image.get(name) for image in images])
        if numbers is not None and len(set(numbers)) == len(images):
            return sorted(zip(people.values(), numbers, strict=True), key=itemgetter(1))
    return [(frame, None) for frame in people.values()]


def _category_names(document: dict) -> list[str] | None:
    """The names of the points of a COCO or MMPose file."""
    categories = document.get("categories")
    category = categories[0] if isinstance(categories, list) and categories else document.get("meta_info")
    if not isinstance(category, dict):
        return None
    by_id = category.get("keypoint_id2name")
    names = list(by_id.values()) if isinstance(by_id, dict) else category.get("keypoints")
    return names if isinstance(names, list) and all(isinstance(name, str) for name in names) else None


def _read_entries(
    source: Source, entries: list[Entry], names: list[str] | None, n_points: int | None, document: dict
) -> Stored:
    """The points of all frames as arrays, by their names if they have any, where their numbers say."""
    frames = [_read_frame(source, frame, n_points) for frame, _ in entries]
    points = list(dict.fromkeys(point for frame in frames for point in frame))
    named = [point for point in points if isinstance(point, str)]
    if not points or 0 < len(named) < len(points):
        raise source.error("expected keypoints in three dimensions, all with names or all without, found none")
    counts = sorted({len(frame) for frame in frames if frame})
    if named:
        names = points = positions_only(source, named)
    elif counts != [len(names or points)]:
        raise source.error(f"expected {len(names or points)} points in every frame, found {counts[0]}")
    array = _numbers(
        source,
        [[frame.get(point, UNSEEN) for point in points] for frame in frames],
        (len(frames), len(points), 4),
    )
    positions = array[:, :, :3]
    sure = np.where(np.isnan(array[:, :, 3]), ~np.isnan(positions).any(axis=2), array[:, :, 3])
    given = [number for _, number in entries if number is not None]
    numbers = given if len(given) == len(entries) else None
    stored = Stored(positions, as_confidences(source, sure), names)
    dicts = [frame for frame, _ in entries if isinstance(frame, dict)]
    key = time_key(dicts[0]) if dicts else None
    times = {key: [frame.get(key) for frame in dicts]} if key else {key: document.get(key) for key in TIMES}
    for key, values in times.items():
        if isinstance(values, list) and len(values) == len(entries) and all(map(_is_number, values)):
            stored = stored._replace(times=Times(key, _numbers(source, values, (len(values),)), numbers))
    return at_frames(source, stored, numbers)


def _read_frame(source: Source, frame: Any, n_points: int | None) -> Points:
    """The points of the one person of a frame; none without a person."""
    if not isinstance(frame, dict):
        return _read_points(source, frame, "", n_points)
    keys = [key for key in (*POINTS, *PEOPLE, *PICTURE) if key in frame]
    key = next((key for key in keys if frame[key]), None)
    if key in PEOPLE:
        return _read_one(source, frame[key], n_points)
    if key in PICTURE:
        raise source.error(f"{key} are keypoints in two dimensions. {REMEDY}")
    if key is None:
        return {} if keys else _read_points(source, frame, "", n_points)
    found = _read_points(source, frame[key], key, n_points)
    scores = next((frame[one] for one in SCORES if isinstance(frame.get(one), list | dict)), None)
    if isinstance(scores, dict):
        scores = [scores[point] for point in found if point in scores]
    if found and scores is not None:
        if len(scores) != len(found):
            raise source.error(f"expected {len(found)} scores, found {len(scores)}")
        found = {point: [*row[:3], score] for (point, row), score in zip(found.items(), scores, strict=True)}
    return found


def _read_one(source: Source, people: Any, n_points: int | None) -> Points:
    """The points of the only person of a list."""
    if not isinstance(people, list) or len(people) > 1:
        raise source.error(f"expected one person, the same one in every frame, found {repr(people)}")
    return _read_frame(source, people[0], n_points)


def _read_points(source: Source, points: Any, key: str, n_points: int | None) -> Points:
    """The points under a key: rows, objects, objects by name, or all numbers in one list."""
    if isinstance(points, dict):
        points = points.get("landmark", points)  # of MediaPipe's solutions
    if not points:
        return {}
    if isinstance(points, dict):
        return {name: _read_point(source, point) for name, point in points.items() if isinstance(point, dict | list)}
    if not isinstance(points, list):
        raise source.error(f"expected points, found {repr(points)}")
    first = points[0]
    if _is_number(first):
        points = _split(source, points, key, n_points)
    elif (isinstance(first, dict) and not {"x", "X"} & first.keys()) or (
        isinstance(first, list) and first and not _is_number(first[0])
    ):
        return _read_one(source, points, n_points)
    names = [point["name"] for point in points if isinstance(point, dict) and isinstance(point.get("name"), str)]
    if names and len(names) < len(points):
        raise source.error("expected a name of each point or of none")
    return dict(zip(names or range(len(points)), [_read_point(source, point) for point in points], strict=True))


def _split(source: Source, numbers: list, key: str, n_points: int | None) -> list:
    """Points from numbers without lists between them."""
    n = len(numbers)
    widths = [width for width in ((4,) if key == POINTS[0] else (3, 4)) if n % width == 0]  # OpenPose has a score
    if len(widths) > 1:
        widths = [width for width in widths if n == width * (n_points or 0)]
    if not widths:
        raise source.error(f"expected x, y, z, or with a score, found {n} numbers: pass layout= or names=")
    third = [number for number in numbers[2::3] if number is not None]
    if widths[0] == 3 and key in AMBIGUOUS and third and all(z == 2 or 0 <= z <= 1.1 for z in third):
        raise source.error(f"{key or 'lists'}: third numbers look like scores, not z. {REMEDY}")
    return [numbers[i : i + widths[0]] for i in range(0, n, widths[0])]


def _read_point(source: Source, point: Any) -> list:
    """X, y, z and the confidence of a point; None where one is not stated."""
    if point is None:
        return UNSEEN
    if isinstance(point, dict):
        lower = {str(key).lower(): value for key, value in point.items()}
        if {"x", "y", "z"} <= lower.keys() and "w" not in lower:
            return [lower["x"], lower["y"], lower["z"], next((lower[key] for key in SURE if key in lower), None)]
    elif isinstance(point, list) and len(point) in (3, 4):
        return [*point, None][:4]
    what = f"{repr(point)}. {REMEDY}" if _is_point(point) else f"{repr(point)}: pass layout= or names=?"
    raise source.error(f"expected a point with x, y and z, found {what}")


def _numbers(source: Source, values: list, shape: tuple[int, ...]) -> np.ndarray:
    """Numbers as an array of a shape, NaN for null."""
    try:
        return np.array(values, dtype=np.float64).reshape(shape)
    except (TypeError, ValueError, OverflowError) as error:
        raise source.error(f"expected numbers: {error}") from None


def _is_point(value: Any) -> bool:
    """Whether a value is one point: an object with x and y, or as many numbers as a point has."""
    if isinstance(value, dict):
        return {"x", "y"} <= {str(key).lower() for key in value}
    return isinstance(value, list) and 0 < len(value) <= 4 and all(map(_is_number, value))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
