"""Skeletons and motions passed where poses belong are refused in words, by functions and by estimators."""

import numpy as np
import pytest
from sklearn.base import clone

from skpose import (
    MedoidShift,
    Motion,
    PoseDistanceTransformer,
    PoseKNeighborsTransformer,
    PoseRadiusNeighborsTransformer,
    Skeleton,
    SpatialMDS,
    forward_kinematics,
    frechet_mean,
    geodesic,
    metric_tensor,
    pose_distances,
    pose_distances_chunked,
    position_jacobian,
)

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
    MedoidShift(1.0, skeleton=ARM),
    PoseDistanceTransformer(metric="angle"),
    MedoidShift(1.0, metric="precomputed"),
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
