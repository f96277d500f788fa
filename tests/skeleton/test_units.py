"""Warnings about degrees and other units of length."""

import io
import warnings

import numpy as np
import pytest
from conftest import DATA

from skpose import Motion, Skeleton, forward_kinematics, geodesic, pose_distances
from skpose.datasets import humanoid
from skpose.geodesics import frechet_mean
from skpose.io import load_bvh, load_keypoints
from skpose.preprocessing import PoseDistanceTransformer

ARM = Skeleton.chain(3)
RADIANS = np.random.default_rng(0).uniform(-1.5, 1.5, (6, 3))
DEGREES = np.degrees(RADIANS)

CALLS = {
    "pose_distances": lambda X: pose_distances(X, skeleton=ARM),
    "pose_distances, two arrays": lambda X: pose_distances(X, X.copy(), skeleton=ARM),
    "forward_kinematics": lambda X: forward_kinematics(X, ARM),
    "frechet_mean": lambda X: frechet_mean(X, ARM),
    "geodesic": lambda X: geodesic(X[0], X[1], ARM),
    "Motion": lambda X: Motion(ARM, X, 10),
    "transformer": lambda X: PoseDistanceTransformer(ARM).fit_transform(X),
}


def caught(call, *arguments):
    """Warnings of a call."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        call(*arguments)
    return found


@pytest.mark.parametrize("name", CALLS)
def test_degrees_warn_once_at_the_users_line(name):
    (warning,) = caught(CALLS[name], DEGREES)
    assert warning.category is UserWarning
    assert warning.filename == __file__
    assert "np.radians(" in str(warning.message)
    assert caught(CALLS[name], RADIANS) == []


def test_without_a_skeleton_any_unit_is_right():
    """The metric "angle" of degrees is that of radians, in degrees."""
    degrees, radians = (pose_distances(X, metric="angle") for X in (DEGREES, RADIANS))
    np.testing.assert_allclose(degrees, np.degrees(radians))


def test_unwrapped_recordings_do_not_warn():
    """Some turns of every joint, and many of few joints, are those of real movements."""
    some = RADIANS + 2 * np.pi * np.random.default_rng(0).integers(-2, 3, RADIANS.shape)
    assert caught(forward_kinematics, some, ARM) == []
    person = humanoid()
    spinning = np.random.default_rng(0).uniform(-1, 1, (50, person.n_dofs))
    spinning[:, :3] += np.linspace(0, 200, 50)[:, None]
    assert caught(forward_kinematics, spinning, person) == []


def bvh(scale=1.0):
    """The person of the test data, whose file is in centimetres, in another unit: numbers times the scale."""
    lines = []
    for line in (DATA / "biped.bvh").read_text().splitlines(keepends=True):
        words = line.split()
        if words and words[0] == "OFFSET":
            line = "OFFSET " + " ".join(str(float(word) * scale) for word in words[1:]) + "\n"
        lines.append(line)
    return io.StringIO("".join(lines))


@pytest.mark.parametrize(
    ("factor", "unit", "scale"),
    [(1.0, "centimetres", "0.01"), (10.0, "millimetres", "0.001"), (0.01 / 0.0254, "inches", "0.0254")],
)
def test_files_in_other_units_warn(factor, unit, scale):
    with pytest.warns(UserWarning, match=f"in {unit}, pass scale={scale}") as found:
        load_bvh(bvh(factor))
    assert len(found) == 1
    assert found[0].filename == __file__


@pytest.mark.parametrize(
    ("height", "unit", "scale"), [(1.5, "feet", "0.3048"), (1.6, "feet", "0.3048"), (1.5, "decimetres", "0.1")]
)
def test_keypoints_of_a_person_in_other_units_warn(height, unit, scale):
    """In feet people are 4.9 or 5.2 units tall, on either side of what a horse and its rider have in metres."""
    person = np.random.default_rng(0).uniform(-0.3, 0.3, (5, 6, 3))
    person[:, 0], person[:, 1] = 0.0, [0.0, height, 0.1]
    options = {"names": [f"p{i}" for i in range(6)], "frame_rate": 30, "zeros": "seen"}
    file = io.BytesIO()
    np.save(file, person / float(scale))
    with pytest.warns(UserWarning, match=f"in {unit}, pass scale={scale}"):
        load_keypoints(io.BytesIO(file.getvalue()), **options)
    assert caught(lambda: load_keypoints(io.BytesIO(file.getvalue()), scale=float(scale), **options)) == []


def test_two_people_apart_have_no_unit_of_their_own():
    person = np.random.default_rng(0).uniform([-0.2, 0.0, -0.2], [0.2, 1.7, 0.2], (5, 6, 3))
    file = io.BytesIO()
    np.save(file, np.concatenate([person, np.add(person, [3.0, 0.0, 0.0])], axis=1))
    file.seek(0)
    names = [f"p{i}" for i in range(12)]
    assert caught(lambda: load_keypoints(file, names=names, frame_rate=30)) == []
