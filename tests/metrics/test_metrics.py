"""Every metric against its definition, and the facts that the library is built on."""

import numpy as np
import pytest
import reference
from conftest import SKELETONS, whole_turns, with_either_wrap

from skpose import Skeleton, pose_distances
from skpose.metrics import Angle, Position, Spatial
from skpose.metrics._registry import METRICS

DEFINED = with_either_wrap(name for name in METRICS if name != "geodesic")  # has tests of its own
STEPS = [Spatial(n, wrap) for n in (1, 2, 3, 100) for wrap in (True, False)]


def test_agrees_with_its_definition(skeleton, poses):
    for metric in [*DEFINED, *STEPS]:
        expected = reference.distances(poses[:2], poses, skeleton, metric.name, **metric.get_params())
        distances = pose_distances(poses[:2], poses, skeleton=skeleton, metric=metric)
        np.testing.assert_allclose(distances, expected, rtol=1e-10, atol=1e-12, err_msg=repr(metric))
    one_step, chord = (pose_distances(poses, skeleton=skeleton, metric=metric) for metric in (Spatial(1), "position"))
    np.testing.assert_allclose(one_step, chord, rtol=1e-12)


def test_fact_1_a_chord_is_no_longer_than_a_curve(skeleton, poses):
    chord, *curves = (
        pose_distances(poses, skeleton=skeleton, metric=metric)
        for metric in (Position(), Spatial(), Spatial(wrap=False), Spatial(3))
    )
    for curve in curves:
        assert (chord <= curve * (1 + 1e-12)).all()


@pytest.mark.filterwarnings("ignore:values of .* reach:UserWarning")
def test_fact_2_whole_turns_do_not_count(skeleton, poses):
    turns = whole_turns(poses, skeleton, np.random.default_rng(3).integers(-20, 20, size=poses.shape))
    has_balls = any(bone.is_ball for bone in skeleton.bones)
    metrics = [Position(), METRICS["rotation"](), Spatial(), *([] if has_balls else [Angle(wrap=True)])]
    for metric in metrics:
        wound, plain = (pose_distances(X, poses, skeleton=skeleton, metric=metric) for X in (poses + turns, poses))
        np.testing.assert_allclose(wound, plain, atol=1e-11)
    literal = pose_distances(poses[:2] + turns[:2], poses, skeleton=skeleton, metric=Spatial(50, wrap=False))
    expected = reference.distances(poses[:2] + turns[:2], poses, skeleton, "spatial", n_steps=50)
    np.testing.assert_allclose(literal, expected, rtol=1e-10, atol=1e-10)


def test_a_half_turn_is_as_far_from_either_end():
    skeleton = Skeleton.chain(3)
    a, b = np.array([[0.0, 0.5, np.pi]]), np.array([[np.pi, 0.5 - np.pi, 0.0]])
    for turns in (0.0, 2 * np.pi, -4 * np.pi):
        there, back = pose_distances(a, b + turns, skeleton=skeleton), pose_distances(b + turns, a, skeleton=skeleton)
        np.testing.assert_allclose(there, back, rtol=1e-12)


def test_fact_3_spatial_breaks_the_triangle_inequality():
    """To swing a stretched arm far, it helps to fold it in between: the detour is shorter than the straight line."""
    start, folded, end = np.array([[0.0, 0, 0]]), np.array([[1.5, 1, 0]]), np.array([[3.0, 0, 0]])
    direct, there, back = (
        pose_distances(a, b, skeleton=Skeleton.chain(3), metric=Spatial(100))[0, 0]
        for a, b in ((start, end), (start, folded), (folded, end))
    )
    assert there + back < 0.99 * direct


def test_fact_4_a_twist_of_the_last_bone_moves_nothing():
    skeleton = SKELETONS["humanoid"]
    X = np.zeros((2, skeleton.n_dofs))
    X[1, skeleton.dof_names.index("head_ry")] = 1.0
    for metric in ("position", "spatial"):
        assert pose_distances(X, skeleton=skeleton, metric=metric)[0, 1] < 1e-12
    assert pose_distances(X, skeleton=skeleton, metric="rotation")[0, 1] > 0.1


@pytest.mark.parametrize("angle", [1e-9, 0.5, np.pi])
def test_rotation_of_one_bone_is_its_length_times_the_angle(angle):
    skeleton = Skeleton([("a", None, (0, 2, 0), "x"), ("b", "a", (0, 1, 0))])
    distance = pose_distances([[0.3]], [[0.3 + angle]], skeleton=skeleton, metric="rotation")
    np.testing.assert_allclose(distance, np.sqrt(5) * angle, rtol=1e-7 if angle < 1e-8 else 1e-12)


def test_the_line_of_one_joint_is_its_arc():
    """The chords of the arc have a closed form."""
    radii = np.sqrt(1**2 + 2**2 + 3**2 + 4**2)
    for n_steps in (1, 10, 100):
        metric = Spatial(n_steps)
        distance = pose_distances([[0.0, 0, 0, 0]], [[2.0, 0, 0, 0]], skeleton=Skeleton.chain(4), metric=metric)
        np.testing.assert_allclose(distance, radii * n_steps * 2 * np.sin(1.0 / n_steps), rtol=1e-12)


@pytest.mark.slow
def test_cmu_poses_against_the_naive_definition(cmu):
    """Two poses of each recording; of two recordings also those on either side of a jump by 360°."""
    skeleton, rng = cmu.skeleton, np.random.default_rng(0)
    X, sequence = cmu.poses()
    chosen = np.concatenate([rng.choice(np.flatnonzero(sequence == i), 2) for i in range(len(cmu))])
    for trial in ("19", "26"):
        i = int(np.flatnonzero((cmu.subjects == "35") & (cmu.trials == trial))[0])
        frames = np.flatnonzero(sequence == i)
        by_angle = frames[np.argsort(X[frames, skeleton.dof_names.index("rhand_rz")])]
        assert np.ptp(X[by_angle, skeleton.dof_names.index("rhand_rz")]) > 2 * np.pi
        chosen = np.concatenate([chosen, by_angle[[0, -1, 1, -2]]])
    X = X[chosen]
    pairs = np.concatenate([rng.integers(len(X), size=(60, 2)), len(X) - 1 - np.argwhere(np.tri(8, k=-1))])
    for metric in DEFINED:
        expected = [reference.distance(X[i], X[j], skeleton, metric.name, **metric.get_params()) for i, j in pairs]
        distances = pose_distances(X, skeleton=skeleton, metric=metric)[tuple(pairs.T)]
        np.testing.assert_allclose(distances, expected, rtol=0, atol=1e-9)
