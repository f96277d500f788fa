"""The frames of keypoint files: their order, their numbers, their times; one person in each."""

import io
import json
import warnings

import numpy as np
import pytest

from skpose.io import MocapFormatError, load_keypoints
from skpose.keypoints import layouts

COCO = layouts["coco17"]
N = 12
ARRAY = np.random.default_rng(0).uniform(-0.9, 0.9, (N, 17, 3))
FRAMES = ARRAY.tolist()


def read(document, **options):
    file = io.BytesIO((document if isinstance(document, str) else json.dumps(document)).encode())
    return load_keypoints(file, **({"layout": COCO, "frame_rate": 30} | options))


def messages(call, *arguments, **options):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call(*arguments, **options)
    return [str(one.message) for one in caught]


def at_frames(numbers, order=None):
    """Return positions with the frames of ARRAY where their numbers say, NaN elsewhere."""
    numbers = np.asarray(numbers)
    found = np.full((numbers.max() - numbers.min() + 1, 17, 3), np.nan)
    found[numbers - numbers.min()] = ARRAY[: len(numbers)] if order is None else ARRAY[order]
    return found


def same(found, positions):
    np.testing.assert_array_equal(found.positions[:, :17], positions)


def results(ids, key="image_id"):
    """Return a list of results in COCO's style, an entry for each person of each image."""
    return [{key: i, "category_id": 1, "keypoints": frame, "score": 0.9} for i, frame in zip(ids, FRAMES, strict=False)]


GAPS = [0, 1, 2, 10, 11, 12]


@pytest.mark.parametrize("key", ["image_id", "imageId", "frame", "Frame", "frameIndex", "frame_idx", "frame_id"])
@pytest.mark.parametrize("name", [None, "{:06}.jpg", "cam2/walk_{}.png", "{}", "v1-{:04}_jpg.rf.8f3a"])
def test_results_stay_at_the_time_of_their_image(key, name):
    ids = GAPS if name is None else [name.format(i) for i in GAPS]
    same(read(results(ids, key)), at_frames(GAPS))
    same(read(results([0, 1, 2], key)), ARRAY[:3])


@pytest.mark.parametrize("name", [None, "{:06}.jpg", "{}"])
def test_two_people_of_an_image_are_refused(name):
    ids = [i // 2 if name is None else name.format(i // 2) for i in range(6)]
    shown = repr(ids[0])
    with pytest.raises(MocapFormatError):
        read(results(ids))
    with pytest.raises(MocapFormatError):
        read(results(["walk.jpg", "walk.jpg"]))


def coco(images):
    """Return a file in COCO's style with the frames of ARRAY, one an image, of any numbers and order."""
    annotations = [
        {"image_id": image["id"], "keypoints": [number for point in frame for number in (*point, 2)]}
        for image, frame in zip(images, FRAMES, strict=False)
    ]
    return {"images": images, "annotations": annotations[::-1], "categories": [{"keypoints": list(COCO.names)}]}


ORDER = [3, 0, 2, 9, 1]
IMAGES = {
    "frame_idx": lambda i, k: {"id": i, "file_name": f"{i}.jpg", "frame_idx": k},
    "frame_id": lambda i, k: {"id": f"x{i}", "frame_id": k},
    "file_name": lambda i, k: {"id": i, "file_name": f"session1/{k:012}.jpg"},
    "file_name of Roboflow": lambda i, k: {"id": i, "file_name": f"walk_mp4-{k}_jpg.rf.{7919 * i:x}.jpg"},
    "id": lambda i, k: {"id": k, "file_name": "abc"[i % 3] + "walk.jpg"},
    "id alone": lambda i, k: {"id": k},
}


@pytest.mark.parametrize("form", IMAGES)
def test_images_are_in_the_order_of_their_numbers(form):
    for numbers in (ORDER, [0, 1, 2, 10], [2, 1, 0]):
        images = [IMAGES[form](i, k) for i, k in enumerate(numbers)]
        same(read(coco(images)), at_frames(numbers))


def test_frames_by_their_numbers():
    keys = [10, 2, 0, 1]
    wanted = at_frames(keys)
    for frame in (lambda points: points, lambda points: {"keypoints_3d": points}, lambda points: {"people": [points]}):
        document = {str(key): frame(FRAMES[i]) for i, key in enumerate(keys)}
        same(read(document), wanted)
        same(read({"fps": 30, "frames": document}, frame_rate=None), wanted)
        same(read({"fps": 30, **document}, frame_rate=None), wanted)
    same(read({"frames": {f"frame_{key}": FRAMES[i] for i, key in enumerate(keys)}}), wanted)
    same(read({"0": FRAMES[0], "1": None, "2": FRAMES[1]}), at_frames([0, 2]))
    points = {str(i): point for i, point in enumerate(FRAMES[0])}
    found = read(points, layout=None)
    assert (len(found), found.names) == (1, tuple(points))
    with pytest.raises(MocapFormatError):
        read({"frames": {"a": FRAMES[0], "b": FRAMES[1]}})
    with pytest.raises(MocapFormatError):
        read({"a": FRAMES[0], "b": FRAMES[1]})


def test_flat_lists_are_frames_where_the_number_of_points_is_known():
    rows = ARRAY.reshape(N, -1)
    sure = np.full((N, 17, 1), 0.5)
    for document in (rows.tolist(), {"frames": rows.tolist()}, {str(i): row for i, row in enumerate(rows.tolist())}):
        same(read(document), ARRAY)
        same(read(document, layout=None, names=COCO.names), ARRAY)
    found = read(np.concatenate([ARRAY, sure], axis=2).reshape(N, -1).tolist())
    same(found, ARRAY)
    assert (found.confidences[:, :17] == 0.5).all()
    with pytest.raises(MocapFormatError):
        read(rows.tolist(), layout=None)
    pixels = np.concatenate([ARRAY[..., :2] * 300 + 320, np.full((N, 17, 1), 2)], axis=2)
    with pytest.raises(MocapFormatError):
        read(pixels.reshape(N, -1).tolist())


PIXELS = ARRAY[..., :2] * 300 + 320
THIRDS = {
    "visibility": np.random.default_rng(1).integers(0, 3, (N, 17)),
    "scores": np.random.default_rng(1).uniform(0, 1, (N, 17)),
    "scores that overshoot": np.random.default_rng(1).uniform(0, 1.09, (N, 17)),
    "percent": np.random.default_rng(1).uniform(0, 100, (N, 17)),
    "depth in another unit": ARRAY[..., 2],
}


@pytest.mark.parametrize("third", THIRDS)
def test_flat_keypoints_are_looked_at(third):
    """COCO's lists of x, y and visibility have the form of x, y, z."""
    same(read([{"keypoints": frame.ravel().tolist()} for frame in ARRAY]), ARRAY)
    for unit in (100, 1000):
        found = read([{"keypoints": frame.ravel().tolist()} for frame in unit * ARRAY], scale=1 / unit)
        np.testing.assert_allclose(found.positions[:, :17], ARRAY)
    flat = np.concatenate([PIXELS, THIRDS[third][:, :, None]], axis=2)
    flat[3] = 0.0  # nobody is seen
    document = [{"keypoints": frame.ravel().tolist()} for frame in flat]
    with pytest.raises(MocapFormatError):
        read(document)
    with pytest.raises(MocapFormatError):
        read(document, layout=None, names=COCO.names)
    if third != "depth in another unit":
        picture = flat / [640, 640, 1]
        with pytest.raises(MocapFormatError):
            read([{"keypoints": frame.ravel().tolist()} for frame in picture])


def table(key, times, numbers=None):
    """Return a CSV file of ARRAY with a column of times, and one of the numbers of frames."""
    header = [key, *(["frame"] if numbers is not None else [])]
    rows = [[t, *([] if numbers is None else [numbers[i]])] for i, t in enumerate(times)]
    header += [f"{name}_{axis}" for name in COCO.names for axis in "xyz"]
    lines = [",".join(map(str, [*row, *frame.ravel()])) for row, frame in zip(rows, ARRAY, strict=True)]
    return "\n".join([",".join(header), *lines])


def listed(key, times, numbers=None):
    """Return a list of frames with their times and numbers."""
    more = [{} if numbers is None else {"frame": number} for number in numbers or range(N)]
    return [{key: t, "keypoints_3d": frame} | one for t, frame, one in zip(times, FRAMES, more, strict=True)]


def timestamps(key, times, numbers=None):
    """Return frames with a list of their times next to them."""
    assert key == "timestamps"
    frames = [{"keypoints_3d": frame} for frame in FRAMES]
    if numbers is not None:
        frames = [{"frame": number} | frame for number, frame in zip(numbers, frames, strict=True)]
    return {"timestamps": times, "frames": frames}


FORMS = [(table, "time"), (table, "Time (s)"), (listed, "timestamp"), (timestamps, "timestamps")]


@pytest.mark.parametrize(("form", "key"), FORMS)
def test_times_that_contradict_the_frame_rate(form, key):
    file = form(key, [5.0 + i / 60 for i in range(N)])
    (message,) = messages(read, file)
    assert f"frames are at 60 Hz by '{key}', but 30 Hz is taken: pass frame_rate=60 if these times are" in message
    assert messages(read, file, frame_rate=60) == []
    assert messages(read, file, frame_rate=59.94) == []
    with pytest.raises(ValueError, match=r"does not state its frame rate: pass frame_rate=, in Hz; '.*' has 60 Hz"):
        read(file, frame_rate=None)


@pytest.mark.parametrize(
    "times",
    [
        range(N),  # counts of frames
        [1.7e9] * N,  # of the recording
        ["2024-01-01T12:00:00"] * N,
        [i / 30 + 0.004 * (-1) ** i for i in range(N)],  # of a camera
        [round(i / 30, 2) for i in range(N)],
    ],
)
@pytest.mark.parametrize("form", [table, listed])
def test_times_that_say_nothing_against_the_rate(form, times):
    assert messages(read, form("timestamp", list(times))) == []


def test_frames_of_a_folder_with_several_in_a_file(tmp_path):
    numbers = [0, 1, 4, 8]
    entries = results(numbers, "frame")
    (tmp_path / "part1.json").write_text(json.dumps(entries[:3]))
    (tmp_path / "part2.json").write_text(json.dumps(entries[3:]))
    same(load_keypoints(tmp_path, COCO, frame_rate=30), at_frames(numbers))
