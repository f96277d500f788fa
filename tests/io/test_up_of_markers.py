"""The axis that points up in files of points whose names say nothing: people stand on a floor."""

import io
import json
import warnings

import c3d_files
import numpy as np
import pytest

from skpose import forward_kinematics
from skpose.datasets import make_gait
from skpose.io import load_c3d, load_keypoints, load_trc

# What takes y to each direction, by turns and half turns of the world.
ALONG = {
    "y": np.eye(3),
    "z": np.eye(3)[[2, 0, 1]],
    "-y": np.diag([1.0, -1.0, -1.0]),
    "-z": np.diag([1.0, -1.0, -1.0]) @ np.eye(3)[[2, 0, 1]],
}


def walking():
    """Return the joints of a person who walks, 1.6 m tall, y up; the lower foot stands."""
    walk = make_gait(1, 1, activities=["walk"], duration=3, frame_rate=60, random_state=0)[0]
    joints = forward_kinematics(walk.angles, walk.skeleton)
    feet = joints[:, [walk.skeleton.joint_names.index(name) for name in ("left_foot", "right_foot")]]
    lower = feet[:-1, :, 1].argmin(axis=1)
    steps = np.diff(feet, axis=0)[np.arange(len(lower)), lower]
    joints[1:] -= np.cumsum(steps, axis=0)[:, None]
    return joints - [0.0, joints[..., 1].min() - 0.02, 0.0]


WALK = walking()
STANDING = np.repeat(WALK[:1], 10, axis=0) + np.array([0.3, 0.0, 0.2])
# A person who sits, with the back at rest, and moves arms and feet in front of it: no floor.
SITTING = np.repeat(WALK[:1], 60, axis=0)
SITTING[:, 6:] += np.sin(np.arange(60) / 3)[:, None, None] * [0.0, 0.1, 0.3] + [0.0, 0.0, 0.5]


def c3d(positions, axis_up):
    names = [f"m{i}" for i in range(positions.shape[1])]
    return io.BytesIO(c3d_files.c3d_file(1000 * positions, names, axis_up=axis_up))


def trc(positions):
    n, m, _ = positions.shape
    names = "\t\t\t".join(f"m{i}" for i in range(m))
    rows = [f"{t + 1}\t{t / 60:.4f}\t" + "\t".join(map(str, row.ravel())) for t, row in enumerate(positions)]
    keys = "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits"
    head = ["PathFileType\t4", keys, f"60\t60\t{n}\t{m}\tm", f"Frame#\tTime\t{names}", ""]
    return io.StringIO("\n".join(head + rows))


def array(positions):
    return io.BytesIO(json.dumps(positions.tolist()).encode())


def load_points(file, **options):
    return load_keypoints(file, names=[f"m{i}" for i in range(WALK.shape[1])], frame_rate=60, **options)


def heights(markers):
    return markers.positions[..., "xyz".index(markers.up)]


@pytest.mark.parametrize(
    ("stated", "true"), [("-Z", "z"), ("+Y", "z"), ("+Z", "y"), ("-Y", "z"), ("+Z", "-z"), ("+Z", "-y")]
)
def test_the_floor_under_a_walk_wins_over_the_header_of_c3d(stated, true):
    file = c3d(WALK @ ALONG[true].T, stated)
    with pytest.warns(UserWarning, match=f"{true} is taken"):
        markers = load_c3d(file)
    np.testing.assert_allclose(heights(markers), WALK[..., 1], atol=1e-4)


@pytest.mark.parametrize(("load", "write"), [(load_trc, trc), (load_points, array)])
def test_the_floor_wins_over_what_is_usual(load, write):
    with pytest.warns(UserWarning, match="z is taken"):
        markers = load(write(WALK @ ALONG["z"].T))
    np.testing.assert_allclose(heights(markers), WALK[..., 1])
    assert load(write(WALK)).up == "y"
    assert load(write(WALK @ ALONG["z"].T), up="x").up == "x"  # the user knows better


def test_a_person_who_stands_below_the_floor_by_the_header():
    with pytest.warns(UserWarning, match="z is taken"):
        markers = load_c3d(c3d(STANDING @ ALONG["z"].T, "-Z"))
    np.testing.assert_allclose(heights(markers), STANDING[..., 1], atol=1e-4)


def test_a_person_who_stands_along_another_axis_is_a_warning():
    with pytest.warns(UserWarning, match="up='z'"):
        assert load_trc(trc(STANDING @ ALONG["z"].T)).up == "y"


@pytest.mark.parametrize("positions", [WALK, STANDING, SITTING])
def test_nothing_is_said_where_header_and_points_agree(positions):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert load_c3d(c3d(positions @ ALONG["z"].T, "+Z")).up == "z"
        assert load_trc(trc(positions)).up == "y"
