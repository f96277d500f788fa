"""Skeletons and motions passed where poses belong are refused in words, by functions and by estimators."""

import importlib
import inspect
from pathlib import Path

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.metrics import pairwise_distances

import skpose
from skpose import (
    Bone,
    MedoidShift,
    Motion,
    PoseDistanceTransformer,
    PoseKNeighborsTransformer,
    PoseRadiusNeighborsTransformer,
    Skeleton,
    SpatialMDS,
    forward_kinematics,
    geodesic,
    metric_tensor,
    pose_distances,
    pose_distances_chunked,
    pose_metric,
    poses_from_rotations,
    position_jacobian,
    rotations_from_poses,
)
from skpose._validation.motions import is_motion
from skpose._validation.skeletons import is_skeleton
from skpose.datasets import MotionDataset
from skpose.geodesics import frechet_mean
from skpose.kinematics import retarget

ARM = Skeleton.chain(2)
MOTION = Motion(ARM, np.linspace([0, 0], [1, 2], 5), 10)
POSES = MOTION.angles

OF_POSES = {
    "pose_distances": ("X", lambda X: pose_distances(X, skeleton=ARM)),
    "pose_distances, no skeleton": ("X", lambda X: pose_distances(X, metric="angle")),
    "pose_distances, Y": ("Y", lambda X: pose_distances(POSES, X, skeleton=ARM)),
    "pose_distances_chunked": ("X", lambda X: list(pose_distances_chunked(X, skeleton=ARM))),
    "forward_kinematics": ("angles", lambda X: forward_kinematics(X, ARM)),
    "position_jacobian": ("angles", lambda X: position_jacobian(X, ARM)),
    "metric_tensor": ("angles", lambda X: metric_tensor(X, ARM)),
    "frechet_mean": ("X", lambda X: frechet_mean(X, ARM)),
}
ESTIMATORS = [
    PoseDistanceTransformer(ARM),
    PoseKNeighborsTransformer(ARM, n_neighbors=2),
    PoseRadiusNeighborsTransformer(ARM),
    SpatialMDS(skeleton=ARM),
    MedoidShift(ARM, bandwidth=1.0),
    PoseDistanceTransformer(metric="angle"),
    MedoidShift(bandwidth=1.0, metric="precomputed"),
]
OF_POSES |= {f"fit of {one!r}": ("X", lambda X, one=one: clone(one).fit(X)) for one in ESTIMATORS}
OF_POSES |= {
    f"predict of {one!r}": ("X", lambda X, one=one: clone(one).fit(POSES).predict(X)) for one in ESTIMATORS[4:5]
}
OF_POSES |= {
    f"transform of {one!r}": ("X", lambda X, one=one: clone(one).fit(POSES).transform(X)) for one in ESTIMATORS[:4]
}


@pytest.mark.parametrize("name", OF_POSES)
def test_a_motion_or_a_skeleton_is_no_array_of_poses(name):
    argument, function = OF_POSES[name]
    expected = f"^{argument} must be an array of poses, got a "
    with pytest.raises(TypeError, match=expected + r"Motion: pass motion\.angles$"):
        function(MOTION)
    with pytest.raises(TypeError, match=expected + "Skeleton: pass it as skeleton=$"):
        function(ARM)
    with pytest.raises(TypeError, match=expected + "list of Motions: pass the angles of one, or MotionDataset"):
        function([MOTION, MOTION])


@pytest.mark.parametrize("argument", ["start", "end"])
def test_a_motion_or_a_skeleton_is_not_one_pose(argument):
    ends = {"start": POSES[0], "end": POSES[1]}
    expected = f"^{argument} must be one pose, got a "
    with pytest.raises(TypeError, match=expected + r"Motion: pass a row of motion\.angles$"):
        geodesic(**ends | {argument: MOTION}, skeleton=ARM)
    with pytest.raises(TypeError, match=expected + "Skeleton"):
        geodesic(**ends | {argument: ARM}, skeleton=ARM)


def test_arguments_in_another_order_are_refused_in_words():
    with pytest.raises(TypeError, match=r"^Y must be an array of poses, got a Skeleton: pass it as skeleton=$"):
        pose_distances(POSES, ARM)
    words = r"its arguments are X, Y, and those that need their name, as in skeleton=\.\.\., are skeleton, metric, "
    with pytest.raises(TypeError, match=r"^pose_distances\(\) got 3 arguments without a name: " + words):
        pose_distances(POSES, POSES, ARM)
    with pytest.raises(TypeError, match=r"^pose_distances\(\) got an unexpected keyword argument 'metrics': its"):
        pose_distances(POSES, metrics="angle")
    with pytest.raises(TypeError, match=r"^frechet_mean\(\) missing a required argument: 'skeleton': its arguments"):
        frechet_mean(POSES)
    with pytest.raises(TypeError, match="angles must be an array of poses, got a Skeleton"):
        forward_kinematics(ARM, POSES)


def test_the_signature_is_what_it_was():
    import inspect

    parameters = inspect.signature(pose_distances).parameters
    assert list(parameters)[:3] == ["X", "Y", "skeleton"]
    assert parameters["skeleton"].kind is inspect.Parameter.KEYWORD_ONLY


WITH_SKELETON = {
    "pose_distances": lambda skeleton: pose_distances(POSES, skeleton=skeleton),
    "pose_distances_chunked": lambda skeleton: list(pose_distances_chunked(POSES, skeleton=skeleton)),
    "pose_metric": lambda skeleton: pose_metric(skeleton),
    "forward_kinematics": lambda skeleton: forward_kinematics(POSES, skeleton),
    "position_jacobian": lambda skeleton: position_jacobian(POSES, skeleton),
    "metric_tensor": lambda skeleton: metric_tensor(POSES, skeleton),
    "geodesic": lambda skeleton: geodesic(POSES[0], POSES[1], skeleton),
    "frechet_mean": lambda skeleton: frechet_mean(POSES, skeleton),
    "rotations_from_poses": lambda skeleton: rotations_from_poses(POSES, skeleton, form="6d"),
    "poses_from_rotations": lambda skeleton: poses_from_rotations(np.zeros((5, 2, 3)), skeleton, form="rotvec"),
    "Motion": lambda skeleton: Motion(skeleton, POSES, 10),
    "retarget": lambda skeleton: retarget(MOTION, skeleton),
    "MotionDataset.poses": lambda skeleton: MotionDataset([MOTION]).poses(skeleton=skeleton),
} | {f"fit of {one!r}": lambda s, one=one: clone(one).set_params(skeleton=s).fit(POSES) for one in ESTIMATORS[:5]}


@pytest.mark.parametrize("name", WITH_SKELETON)
def test_what_has_a_skeleton_is_none(name):
    for value in (MOTION, MotionDataset([MOTION])):
        with pytest.raises(
            TypeError, match=rf"^skeleton must be a skpose\.Skeleton, got {type(value).__name__}: pass its"
        ):
            WITH_SKELETON[name](value)
    with pytest.raises(TypeError, match=r"got ndarray: poses come first, then the skeleton$"):
        WITH_SKELETON[name](POSES)
    with pytest.raises(TypeError, match=r"got str: skpose\.io\.load_motion\(path\)\.skeleton reads one from a file$"):
        WITH_SKELETON[name]("walk.bvh")


@pytest.mark.parametrize("name", WITH_SKELETON)
def test_messages_name_no_private_modules(name):
    """What is no skeleton at all; and None, where a skeleton is needed."""
    for value in (5, *([] if name in NO_SKELETON else [None])):
        with pytest.raises((TypeError, ValueError), match=r"skpose\.Skeleton") as found:
            WITH_SKELETON[name](value)
        assert "._" not in str(found.value)


# None is a value of theirs.
NO_SKELETON = {"pose_distances", "pose_distances_chunked", "pose_metric", "MotionDataset.poses"} | {
    name for name in WITH_SKELETON if name.startswith("fit of")
}


BALLS = Skeleton([Bone("a", None, (1, 0, 0), "zx"), Bone("b", "a", (1, 0, 0), "y"), Bone("c", "b", (1, 0, 0))])


@pytest.mark.parametrize("shape", [(5, 9), (5, 12), (5, 3, 3), (5, 4, 3)])
@pytest.mark.parametrize("door", ["pose_distances", "forward_kinematics", "frechet_mean", "fit", "Motion"])
def test_positions_of_joints_are_recognised(door, shape):
    """With the root or without it, as rows or as (n_poses, n_joints, 3); lists too."""
    doors = {
        "pose_distances": lambda X: pose_distances(X, skeleton=BALLS),
        "forward_kinematics": lambda X: forward_kinematics(X, BALLS),
        "frechet_mean": lambda X: frechet_mean(X, BALLS),
        "fit": lambda X: PoseDistanceTransformer(BALLS).fit(X),
        "Motion": lambda X: Motion(BALLS, X, 10),
    }
    for X in (np.ones(shape), np.ones(shape).tolist()):
        with pytest.raises(ValueError, match="look like positions of the joints, and poses are their angles, rad"):
            doors[door](X)


def test_the_remedy_for_positions_is_the_metric_position():
    """Distances between positions relative to the root are what "position" measures."""
    F = forward_kinematics(POSES, ARM).reshape(len(POSES), -1)
    np.testing.assert_allclose(pairwise_distances(F), pose_distances(POSES, skeleton=ARM, metric="position"), atol=1e-7)


@pytest.mark.parametrize(
    ("shape", "form"),
    [((5, 2, 4), "quaternion_wxyz"), ((5, 2, 6), "6d"), ((5, 2, 3, 3), "matrix"), ((5, 2, 3), "rotvec")],
)
def test_rotations_of_joints_are_recognised(shape, form):
    with pytest.raises(ValueError, match=rf"look like rotations of the joints: .*form='{form}'\) makes poses of them"):
        pose_distances(np.ones(shape), skeleton=BALLS)


def test_an_array_of_another_width_is_no_sign():
    for X in (np.ones((5, 7)), np.ones((5, 7, 2))):
        with pytest.raises(
            ValueError, match=r"X (has 7 columns|must have shape \(n_poses, 3\), got \(5, 7, 2\))"
        ) as found:
            pose_distances(X, skeleton=BALLS)
        assert "look like" not in str(found.value)


@pytest.mark.parametrize("form", [["6d"], None, 6, "6D", {}])
def test_a_form_is_a_name(form):
    with pytest.raises(ValueError, match=r"form must be one of 'quaternion_wxyz', .*, got "):
        rotations_from_poses(POSES, ARM, form=form)
    with pytest.raises(ValueError, match=r"form must be one of 'quaternion_wxyz', .*, got "):
        poses_from_rotations(np.zeros((5, 2, 3)), ARM, form=form)


def test_lazy_arrays_are_checked_likewise():
    da = pytest.importorskip("dask.array")
    X = da.from_array(POSES)
    with pytest.raises(TypeError, match=r"^Y must be an array of poses, got a Skeleton: pass it as skeleton=$"):
        pose_distances(X, ARM)
    with pytest.raises(ValueError, match="look like positions of the joints"):
        pose_distances(da.ones((5, 9)), skeleton=BALLS)
    with pytest.raises(ValueError, match="look like positions of the joints"):
        pose_distances(da.ones((5, 3, 3)), skeleton=BALLS)


def test_skeletons_of_a_mean_are_skeletons():
    with pytest.raises(TypeError, match=r"skeletons\[1\] must be a skpose\.Skeleton, got Motion"):
        Skeleton.mean([ARM, MOTION])


def empty(kind):
    """An object of a class, without its fields."""
    return next(base for base in (tuple, Exception, float, object) if issubclass(kind, base)).__new__(kind)


def test_no_other_public_class_is_taken_for_a_skeleton_or_a_motion():
    """Checks recognise both by what their classes have."""
    homes = sorted(path.parent.name for path in Path(skpose.__file__).parent.glob("[!_]*/__init__.py"))
    modules = [importlib.import_module(f"skpose.{name}") for name in homes]
    classes = {getattr(module, name) for module in modules for name in module.__all__ if name != "layouts"}
    classes = [value for value in classes if inspect.isclass(value)]
    assert len(classes) > 30
    assert [one for one in classes if is_skeleton(empty(one))] == [Skeleton]
    assert [one for one in classes if is_motion(empty(one))] == [Motion]
    assert not is_skeleton(Skeleton)  # the class itself
    assert not is_motion(Motion)
