"""Skeletons and motions passed where poses belong are refused in words, by functions and by estimators."""

import numpy as np
import pytest
from sklearn.base import clone

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
    metric_tensor,
    pose_distances,
    pose_distances_chunked,
    position_jacobian,
)
from skpose.geodesics import frechet_mean

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


@pytest.mark.parametrize(
    ("shape", "form"),
    [((5, 2, 4), "quaternion_wxyz"), ((5, 2, 6), "6d"), ((5, 2, 3, 3), "matrix"), ((5, 2, 3), "rotvec")],
)
def test_rotations_of_joints_are_recognised(shape, form):
    with pytest.raises(ValueError, match=rf"look like rotations of the joints: .*form='{form}'\) makes poses of them"):
        pose_distances(np.ones(shape), skeleton=BALLS)
