"""Numbers in another unit than is expected are noticed: degrees for radians, files in other units than metres."""

import io
import warnings

import numpy as np
import pytest
from conftest import DATA

from skpose import (
    MedoidShift,
    Motion,
    PoseDistanceTransformer,
    PoseKNeighborsTransformer,
    Skeleton,
    SpatialMDS,
    forward_kinematics,
    geodesic,
    metric_tensor,
    pose_distances,
    pose_distances_chunked,
    position_jacobian,
    rotations_from_poses,
)
from skpose.datasets import humanoid
from skpose.geodesics import frechet_mean, geometric_median
from skpose.io import load_bvh
from skpose.skeleton._rest import size_of

ARM = Skeleton.chain(3)
RADIANS = np.random.default_rng(0).uniform(-1.5, 1.5, (6, 3))
DEGREES = np.degrees(RADIANS)

CALLS = {
    "pose_distances": lambda X: pose_distances(X, skeleton=ARM),
    "pose_distances, two arrays": lambda X: pose_distances(X, X.copy(), skeleton=ARM),
    "pose_distances, angle": lambda X: pose_distances(X, skeleton=ARM, metric="angle"),
    "pose_distances_chunked": lambda X: list(pose_distances_chunked(X, skeleton=ARM, working_memory=1e-4)),
    "forward_kinematics": lambda X: forward_kinematics(X, ARM),
    "position_jacobian": lambda X: position_jacobian(X, ARM),
    "metric_tensor": lambda X: metric_tensor(X, ARM),
    "frechet_mean": lambda X: frechet_mean(X, ARM),
    "geometric_median": lambda X: geometric_median(X, ARM, metric="angle"),
    "geodesic": lambda X: geodesic(X[0], X[1], ARM),
    "rotations_from_poses": lambda X: rotations_from_poses(X, ARM, form="6d"),
    "Motion": lambda X: Motion(ARM, X, 10),
    "transformer": lambda X: PoseDistanceTransformer(ARM).fit_transform(X),
    "neighbors": lambda X: PoseKNeighborsTransformer(ARM, n_neighbors=2).fit(X),
    "mds": lambda X: SpatialMDS(skeleton=ARM).fit(X),
    "mds with landmarks": lambda X: SpatialMDS(skeleton=ARM, landmarks=3, random_state=0).fit_transform(X),
    "medoid shift": lambda X: MedoidShift(ARM, bandwidth=1.0).fit_predict(X),
}


def caught(call, *arguments):
    """Warnings of a call."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        call(*arguments)
    return found


@pytest.mark.parametrize("name", CALLS)
def test_degrees_are_noticed_once_in_a_call_at_the_users_line(name):
    (warning,) = caught(CALLS[name], DEGREES)
    assert warning.category is UserWarning
    assert warning.filename == __file__
    message = str(warning.message)
    assert "reach" in message
    assert "if they are in degrees, pass np.radians(" in message
    assert caught(CALLS[name], RADIANS) == []


def test_without_a_skeleton_any_unit_is_right():
    """The metric "angle" of degrees is that of radians, in degrees."""
    degrees, radians = (pose_distances(X, metric="angle") for X in (DEGREES, RADIANS))
    np.testing.assert_allclose(degrees, np.degrees(radians))


def test_unwrapped_recordings_are_no_degrees():
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
def test_a_file_in_another_unit_than_metres_is_noticed(factor, unit, scale):
    with pytest.warns(UserWarning, match=f"if the file is in {unit}, pass scale={scale}, which makes that 1.") as found:
        skeleton = load_bvh(bvh(factor)).skeleton
    assert len(found) == 1
    assert found[0].filename == __file__
    assert f"the skeleton is {size_of(skeleton):.3g} m from end to end at angle zero" in str(found[0].message)
    assert caught(lambda: load_bvh(bvh(factor), scale=float(scale))) == []
