"""Keypoints of JSON files as programs write them, compared with the arrays that they were made of."""

import io
import json

import numpy as np
import pytest

from skpose.io import MocapFormatError, load_keypoints
from skpose.keypoints import layouts

N = 6
RNG = np.random.default_rng(1)
LAYOUTS = {name: layouts[name] for name in ("body25", "mediapipe33", "coco17", "mediapipe_hand21")}
ARRAYS = {name: RNG.uniform(-0.9, 0.9, (N, len(layout.names), 3)) for name, layout in LAYOUTS.items()}
SURE = {name: RNG.uniform(0.1, 1.0, array.shape[:2]) for name, array in ARRAYS.items()}


def file_of(document):
    return io.BytesIO((document if isinstance(document, str) else json.dumps(document)).encode())


def read(document, name, **options):
    return load_keypoints(file_of(document), LAYOUTS[name], **({"frame_rate": 30} | options))


def expected(name, sure=True, frames=slice(None)):
    """Return the keypoints that numpy alone makes of the arrays."""
    confidences = SURE[name][frames] if sure else None
    return LAYOUTS[name].keypoints(ARRAYS[name][frames], 30, confidences)


def same(found, wanted):
    np.testing.assert_array_equal(found.positions, wanted.positions)
    np.testing.assert_array_equal(found.confidences, wanted.confidences)
    assert (found.names, found.frame_rate, found.up) == (wanted.names, wanted.frame_rate, wanted.up)


def objects(name, t, sure="visibility", **more):
    """Return the points of a frame as objects with x, y, z."""
    rows = zip(ARRAYS[name][t].tolist(), SURE[name][t].tolist(), strict=True)
    return [dict(zip("xyz", row, strict=True)) | ({sure: c} if sure else {}) | more for row, c in rows]


def openpose(t, extra=True):
    """Return a frame as OpenPose writes it with --3d: x, y, z and 1 or 0."""
    rows = np.concatenate([ARRAYS["body25"][t], np.ones((25, 1))], axis=1)
    rows[3] = 0.0
    person = {"person_id": [-1], "pose_keypoints_2d": [], "pose_keypoints_3d": rows.ravel().tolist()}
    return {
        "version": 1.3,
        "people": [person | ({"face_keypoints_3d": [], "hand_left_keypoints_3d": []} if extra else {})],
    }


def seen_by_openpose(frames=range(N)):
    array = ARRAYS["body25"][list(frames)].copy()
    array[:, 3] = np.nan
    return LAYOUTS["body25"].keypoints(array, 30)


def test_a_folder_of_openpose(tmp_path):
    for t in range(N):
        (tmp_path / f"walk_{t:012}_keypoints.json").write_text(json.dumps(openpose(t)))
    (tmp_path / "notes.txt").write_text("not read")
    same(load_keypoints(tmp_path, "body25", frame_rate=30), seen_by_openpose())
    first = tmp_path / f"walk_{0:012}_keypoints.json"
    first.rename(first.with_suffix(".JSON"))
    same(load_keypoints(str(tmp_path), "body25", frame_rate=30), seen_by_openpose())
    # A frame in which nobody is seen, and one without a file: not seen, at their time.
    (tmp_path / f"walk_{1:012}_keypoints.json").write_text(json.dumps({"version": 1.3, "people": []}))
    (tmp_path / f"walk_{3:012}_keypoints.json").unlink()
    found, wanted = load_keypoints(tmp_path, "body25", frame_rate=30), seen_by_openpose()
    assert len(found) == N
    assert np.isnan(found.positions[[1, 3]]).all()
    np.testing.assert_array_equal(found.positions[[0, 2, 4, 5]], wanted.positions[[0, 2, 4, 5]])
    (tmp_path / f"walk_{2:012}_keypoints.json").write_text(json.dumps({"people": [openpose(2)["people"][0]] * 2}))
    with pytest.raises(MocapFormatError):
        load_keypoints(tmp_path, "body25", frame_rate=30)


@pytest.mark.filterwarnings("ignore:.* is taken as the :UserWarning")  # points at random in one frame
def test_one_frame_and_a_list_of_frames_of_openpose():
    same(read(openpose(0), "body25"), seen_by_openpose([0]))
    same(read([openpose(t) for t in range(N)], "body25"), seen_by_openpose())
    same(
        read({"fps": 30, "frames": [openpose(t, False) for t in range(N)]}, "body25", frame_rate=None),
        seen_by_openpose(),
    )


FORMS = {
    "tasks": lambda t: {
        "pose_landmarks": [[{"x": 0.5, "y": 0.5, "z": 0.1}]],
        "pose_world_landmarks": [objects("mediapipe33", t)],
    },
    "solutions": lambda t: {"pose_world_landmarks": {"landmark": objects("mediapipe33", t)}},
    "a list": lambda t: {"pose_world_landmarks": objects("mediapipe33", t)},
    "javascript": lambda t: {"landmarks": [[]], "worldLandmarks": [objects("mediapipe33", t)]},
    "presence too": lambda t: {"pose_world_landmarks": objects("mediapipe33", t, presence=0.5)},
    "rows": lambda t: {
        "pose_world_landmarks": np.column_stack([ARRAYS["mediapipe33"][t], SURE["mediapipe33"][t]]).tolist()
    },
    "names": lambda t: {
        "pose_world_landmarks": [
            point | {"name": name.upper()}
            for name, point in list(zip(LAYOUTS["mediapipe33"].names, objects("mediapipe33", t), strict=True))[::-1]
        ]
    },
    "by name": lambda t: {
        "timestamp": t / 30,
        **dict(zip(map(str.upper, LAYOUTS["mediapipe33"].names), objects("mediapipe33", t), strict=True)),
    },
    "no key": lambda t: objects("mediapipe33", t),
    "tfjs": lambda t: {"keypoints": [{"x": 320.0, "y": 200.0}], "keypoints3D": objects("mediapipe33", t, "score")},
}


@pytest.mark.parametrize("form", FORMS)
def test_mediapipe(form):
    frames = [FORMS[form](t) for t in range(N)]
    same(read(frames, "mediapipe33"), expected("mediapipe33"))
    same(read({"fps": 30, "frames": frames}, "mediapipe33", frame_rate=None), expected("mediapipe33"))
    same(read(frames[0], "mediapipe33"), expected("mediapipe33", frames=slice(1)))


def test_a_hand():
    frames = [{"hand_world_landmarks": [objects("mediapipe_hand21", t, None)]} for t in range(N)]
    same(read(frames, "mediapipe_hand21"), expected("mediapipe_hand21", sure=False))


def test_names_that_come_and_go_are_points_that_are_not_seen():
    frames = [{"nose": [0.1, 1.6, 0.2], "hip": {"X": 0.0, "Y": 1.0, "Z": 0.1}}, {"hip": [0, 1.1, 0.1]}]
    found = load_keypoints(file_of(frames), frame_rate=10)
    assert found.names == ("nose", "hip")
    np.testing.assert_array_equal(found.positions[:, 1], [[0, 1, 0.1], [0, 1.1, 0.1]])
    np.testing.assert_array_equal(found.confidences, [[1, 1], [0, 1]])


def coco_rows(t):
    """Return x, y, z and COCO's v: 0 not labelled, 1 hidden, 2 visible."""
    flags = np.where(SURE["coco17"][t] > 0.5, 2, 1)
    flags[0] = 0
    return np.column_stack([ARRAYS["coco17"][t], flags])


def coco_seen():
    array = ARRAYS["coco17"].copy()
    array[:, 0] = np.nan
    return LAYOUTS["coco17"].keypoints(array, 30)


def test_files_in_the_style_of_coco():
    names = list(LAYOUTS["coco17"].names)
    document = {
        "images": [{"id": 7 + t, "file_name": f"{t}.png"} for t in range(N)],
        "annotations": [
            {
                "id": t,
                "image_id": 7 + t,
                "category_id": 1,
                "keypoints": coco_rows(t).ravel().tolist(),
                "num_keypoints": 16,
            }
            for t in range(N)
        ][::-1],
        "categories": [{"id": 1, "name": "person", "keypoints": names}],
    }
    same(read(document, "coco17"), coco_seen())
    same(load_keypoints(file_of(document), "coco17", frame_rate=30), coco_seen())
    assert load_keypoints(file_of(document), frame_rate=30).names == tuple(names)
    one = document | {"annotations": document["annotations"][1:]}
    assert np.isnan(read(one, "coco17").positions[5]).all()
    twice = document | {"annotations": document["annotations"] * 2}
    with pytest.raises(MocapFormatError):
        read(twice, "coco17")
    with pytest.raises(MocapFormatError):
        read(document | {"images": document["images"][:-1]}, "coco17")


def test_mmpose():
    """Its demo writes instance_info, with rows of x, y, z and scores apart or not."""
    info = [{"frame_id": t, "instances": [{"keypoints": ARRAYS["coco17"][t].tolist()}]} for t in range(N)]
    names = dict(enumerate(LAYOUTS["coco17"].names))
    document = {"meta_info": {"keypoint_id2name": names}, "instance_info": info}
    same(read(document, "coco17"), expected("coco17", sure=False))
    scored = [
        one | {"instances": [one["instances"][0] | {"keypoint_scores": SURE["coco17"][t].tolist()}]}
        for t, one in enumerate(info)
    ]
    same(read(document | {"instance_info": scored}, "coco17"), expected("coco17"))


@pytest.mark.parametrize("key", ["likelihood", "presence"])
def test_words_for_how_sure_a_point_is(key):
    same(read([objects("coco17", t, key) for t in range(N)], "coco17"), expected("coco17"))


@pytest.mark.parametrize("key", ["scores", "keypoint_scores", "keypoints_scores"])
def test_scores_next_to_the_points(key):
    frames = [{"keypoints": ARRAYS["coco17"][t].tolist(), key: SURE["coco17"][t].tolist()} for t in range(N)]
    same(read(frames, "coco17"), expected("coco17"))
    frames[0][key] = frames[0][key][1:]
    with pytest.raises(MocapFormatError):
        read(frames, "coco17")


def test_null_and_nan_are_not_seen():
    array = ARRAYS["coco17"][:2].tolist()
    array[0][3], array[1][5][1], array[1][6][0] = None, None, float("nan")
    found = read(array, "coco17")
    assert np.argwhere(found.confidences[:, :17] == 0).tolist() == [[0, 3], [1, 5], [1, 6]]


PIXELS = np.column_stack([RNG.uniform(0, 640, (17, 2)), RNG.integers(1, 3, 17)]).ravel().tolist()
FLAT = [
    {"people": [{"pose_keypoints_2d": RNG.uniform(0, 640, 75).tolist(), "pose_keypoints_3d": []}]},
    [{"image_id": 1, "category_id": 1, "keypoints": PIXELS, "score": 0.9}],
    {
        "images": [{"id": 1}],
        "annotations": [{"image_id": 1, "keypoints": PIXELS}],
        "categories": [{"keypoints": list(LAYOUTS["coco17"].names)}],
    },
    [{"keypoints": RNG.uniform(0, 640, (17, 2)).tolist(), "keypoint_scores": [1.0] * 17}],
    [{"keypoints": [{"x": 3.0, "y": 4.0, "score": 0.5}] * 17}],
    [{"pose_landmarks": objects("mediapipe33", 0)}],
    [{"landmarks": [objects("mediapipe33", 0)]}],
    RNG.uniform(0, 640, (4, 17, 2)).tolist(),
]


@pytest.mark.parametrize("document", FLAT)
def test_two_dimensions_are_refused_in_words(document):
    with pytest.raises(MocapFormatError):
        load_keypoints(file_of(document), frame_rate=30)


@pytest.mark.parametrize("form", ["coco", "keypoint_scores", "objects"])
@pytest.mark.parametrize("sure", ["flags", "overshoot", "percent"])
def test_scores_above_1(form, sure):
    rng = np.random.default_rng(4)
    scores = {
        "flags": rng.integers(0, 3, (N, 17)),
        "overshoot": np.where(rng.uniform(size=(N, 17)) < 0.1, 1.07, 0.8),
        "percent": rng.uniform(0, 100, (N, 17)),
        "logits": rng.uniform(0.9, 1.9, (N, 17)),
    }[sure]
    frames = {
        "coco": lambda t: {"keypoints": np.column_stack([ARRAYS["coco17"][t], scores[t]]).ravel().tolist()},
        "keypoint_scores": lambda t: {
            "keypoints_3d": ARRAYS["coco17"][t].tolist(),
            "keypoint_scores": scores[t].tolist(),
        },
        "objects": lambda t: [
            p | {"score": c} for p, c in zip(objects("coco17", t, None), scores[t].tolist(), strict=True)
        ],
    }
    document = [frames[form](t) for t in range(N)]
    if sure in ("flags", "overshoot"):
        same(read(document, "coco17"), LAYOUTS["coco17"].keypoints(ARRAYS["coco17"], 30, np.minimum(scores, 1)))
        return
    with pytest.raises(MocapFormatError):
        read(document, "coco17")


POINT = {"x": 0.1, "y": 0.2, "z": 0.3}


@pytest.mark.parametrize(
    "document",
    [
        [[POINT, POINT | {"w": 1.0}]],
        "[",
        "[" * 100_000,
        "[" + "9" * 5000 + "]",
        "[[]]",
        [[POINT, {"x": "a", "y": 2, "z": 3}]],
        [[POINT], [POINT, POINT]],
        [[POINT | {"name": "a"}], [POINT]],
        {"fps": -1, "frames": [[POINT]]},
        {"people": [{"pose_keypoints_3d": [1, 2, 3, 1, 2]}]},
        {"hello": "world"},
        {"images": [3], "annotations": []},
        {"Loop": "wrap", "Frames": [[0.0] * 44] * 4},
        [{"keypoints": [0.1, 0.2, 2, 0.7, 0.9, 1]}],  # COCO's visibility
        {"keypoints": [[POINT] * 2] * 3, "scores": [[0.5] * 2] * 3, "timestamps": [0.0, 0.1, 0.2]},
        [{"keypoints_3d": {"a": POINT, "b": POINT}, "scores": {"a": 0.1}}],
    ],
)
def test_what_is_refused(document):
    with pytest.raises(MocapFormatError):
        load_keypoints(file_of(document), frame_rate=30, names=["a", "b"])
