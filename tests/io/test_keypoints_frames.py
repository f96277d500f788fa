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


@pytest.mark.parametrize("key", ["image_id", "frame", "frameIndex"])
@pytest.mark.parametrize("name", [None, "{:06}.jpg", "v1-{:04}_jpg.rf.8f3a"])
def test_results_stay_at_the_time_of_their_image(key, name):
    ids = GAPS if name is None else [name.format(i) for i in GAPS]
    same(read(results(ids, key)), at_frames(GAPS))


@pytest.mark.parametrize("name", ["{}", "{:06}.jpg", "walk.jpg"])
def test_two_people_of_an_image_are_refused(name):
    with pytest.raises(MocapFormatError):
        read(results([name.format(i // 2) for i in range(6)]))


def coco(images):
    """Return a file in COCO's style with the frames of ARRAY, one an image, of any numbers and order."""
    annotations = [
        {"image_id": image["id"], "keypoints": [number for point in frame for number in (*point, 2)]}
        for image, frame in zip(images, FRAMES, strict=False)
    ]
    return {"images": images, "annotations": annotations[::-1], "categories": [{"keypoints": list(COCO.names)}]}


IMAGES = {
    "frame_idx": lambda i, k: {"id": i, "file_name": f"{i}.jpg", "frame_idx": k},
    "file_name": lambda i, k: {"id": i, "file_name": f"walk_mp4-{k}_jpg.rf.{7919 * i:x}.jpg"},
    "id": lambda i, k: {"id": k, "file_name": "abc"[i % 3] + "walk.jpg"},
}


@pytest.mark.parametrize("form", IMAGES)
def test_images_are_in_the_order_of_their_numbers(form):
    numbers = [3, 0, 2, 9, 1]
    same(read(coco([IMAGES[form](i, k) for i, k in enumerate(numbers)])), at_frames(numbers))


def test_frames_by_their_numbers():
    keys = [10, 2, 0, 1]
    document = {str(key): {"keypoints_3d": FRAMES[i]} for i, key in enumerate(keys)}
    for one in (document, {"frames": document}, {"fps": 30, **document}):
        same(read(one), at_frames(keys))
    same(read({"frames": {f"frame_{key}": FRAMES[i] for i, key in enumerate(keys)}}), at_frames(keys))
    points = {str(i): point for i, point in enumerate(FRAMES[0])}
    found = read(points, layout=None)
    assert (len(found), found.names) == (1, tuple(points))
    with pytest.raises(MocapFormatError):
        read({"frames": {"a": FRAMES[0], "b": FRAMES[1]}})


def test_flat_lists_are_frames_where_the_number_of_points_is_known():
    rows = ARRAY.reshape(N, -1).tolist()
    same(read(rows), ARRAY)
    same(read({"frames": rows}, layout=None, names=COCO.names), ARRAY)
    with pytest.raises(ValueError, match="layout="):
        read(rows, layout=None)


PIXELS = ARRAY[..., :2] * 300 + 320
THIRDS = {
    "visibility": np.random.default_rng(1).integers(0, 3, (N, 17)),
    "scores": np.random.default_rng(1).uniform(0, 1, (N, 17)),
    "depth in another unit": ARRAY[..., 2],
}


@pytest.mark.parametrize("third", THIRDS)
def test_flat_keypoints_are_looked_at(third):
    """COCO's lists of x, y and visibility have the form of x, y, z."""
    same(read([{"keypoints": frame.ravel().tolist()} for frame in ARRAY]), ARRAY)
    flat = np.concatenate([PIXELS, THIRDS[third][:, :, None]], axis=2)
    with pytest.raises(MocapFormatError):
        read([{"keypoints": frame.ravel().tolist()} for frame in flat])


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


@pytest.mark.parametrize(("form", "key"), [(table, "Time (s)"), (listed, "timestamp")])
def test_times_that_contradict_the_frame_rate(form, key):
    file = form(key, [5.0 + i / 60 for i in range(N)])
    (message,) = messages(read, file)
    assert "frame_rate=60" in message
    assert messages(read, file, frame_rate=59.94) == []
    gap = [*range(6), *range(9, N + 3)]
    assert len(messages(read, form(key, [k / 30 for k in gap]))) == 1
    assert messages(read, form(key, [k / 30 for k in gap], gap)) == []


@pytest.mark.parametrize("key", ["timestamps", "times"])
def test_times_next_to_the_frames(key):
    document = {"frames": FRAMES, key: [i / 60 for i in range(N)]}
    (message,) = messages(read, document)
    assert "frame_rate=60" in message
    assert messages(read, document, frame_rate=60) == []
    assert messages(read, document | {key: [0.0, 1.0]}) == []  # of something else


def test_all_frames_under_one_key_with_their_times():
    times = [i / 30 for i in range(N)]
    same(read({"pose_world_landmarks": FRAMES, "timestamps": times}), ARRAY)


@pytest.mark.parametrize("order", [[*range(1000), *range(1030, 2000)], [*range(1000), 1001, 1000, *range(1002, 2000)]])
def test_times_that_have_gaps_or_go_back(order):
    frames = [{"time": i / 30, "hip": [0, 1, 0], "neck": [0, 1.6, 0]} for i in order]
    assert len(messages(read, frames, layout=None)) == 1
    even = [frame | {"time": i / 30} for i, frame in enumerate(frames)]
    assert messages(read, even, layout=None) == []


def test_frames_of_nobody_keep_their_time():
    frames = [{"frame": 5 + i, "keypoints_3d": frame} for i, frame in enumerate(FRAMES)]
    gap = [None, *frames[1:3], None, None, *frames[5:]]
    by_image = [frame and {"image_id": "abcdefghijkl"[i], "keypoints_3d": FRAMES[i]} for i, frame in enumerate(gap)]
    numbered = ARRAY[1:].copy()  # from the first number
    numbered[[2, 3]] = np.nan
    same(read(gap), numbered)
    for document in (by_image, [frame and frame["keypoints_3d"] for frame in gap]):
        found = read(document)
        assert len(found) == N
        assert np.isnan(found.positions[[0, 3, 4]]).all()
        np.testing.assert_array_equal(found.positions[5:, :17], ARRAY[5:])


@pytest.mark.parametrize(
    "times",
    [
        range(N),  # counts of frames
        ["2024-01-01T12:00:00"] * N,
        [round(i / 30, 2) for i in range(N)],
    ],
)
def test_times_that_say_nothing_against_the_rate(times):
    assert messages(read, listed("timestamp", list(times))) == []


def test_frames_of_a_folder_with_several_in_a_file(tmp_path):
    numbers = [0, 1, 4, 8]
    entries = results(numbers, "frame")
    (tmp_path / "part1.json").write_text(json.dumps(entries[:3]))
    (tmp_path / "part2.json").write_text(json.dumps(entries[3:]))
    same(load_keypoints(tmp_path, COCO, frame_rate=30), at_frames(numbers))
