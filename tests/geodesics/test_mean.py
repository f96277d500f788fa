import numpy as np
import pytest
import reference
from conftest import SKELETONS
from scipy.optimize import least_squares, minimize
from sklearn.exceptions import ConvergenceWarning

from skpose import Skeleton, forward_kinematics, geodesic, pose_distances
from skpose.datasets import make_gait
from skpose.geodesics import frechet_mean
from skpose.kinematics import position_jacobian
from skpose.metrics import Geodesic

METRICS = ["position", "geodesic"]
ONE_BONE = Skeleton.chain(1)


def swing(n=21, seed=0):
    """Poses of an arm that swings widely, with a shoulder, an elbow and a hand."""
    wave = np.linspace(-1.2, 1.2, n)
    noise = np.random.default_rng(seed).normal(scale=0.05, size=(n, 3))
    return Skeleton.chain(3), np.stack([wave, 0.3 + 0.4 * wave, 0.2 * wave], axis=1) + noise


def bone_lengths(positions, skeleton):
    """(..., n_joints, 3) joint positions → lengths of the bones."""
    near = np.concatenate([positions, np.zeros_like(positions[..., :1, :])], axis=-2)[..., skeleton.parents, :]
    return np.linalg.norm(positions - near, axis=-1)


def total(skeleton, metric, pose, X, weights):
    if metric == "geodesic":  # down to rounding, where pose_distances stops earlier
        return weights @ np.array([geodesic(pose, x, skeleton, tol=0.0).length for x in X]) ** 2
    return weights @ pose_distances(pose[None], X, skeleton=skeleton, metric=metric)[0] ** 2


def test_one_bone_has_the_mean_direction():
    """On a circle the extrinsic mean is the direction of the mean vector, the intrinsic one the mean of the angles."""
    rng = np.random.default_rng(0)
    angles, weights = rng.uniform(-1.3, 1.3, 30), rng.uniform(0, 2, 30)
    extrinsic = frechet_mean(angles[:, None], ONE_BONE, sample_weight=weights)
    direction = np.arctan2(weights @ np.sin(angles), weights @ np.cos(angles))
    np.testing.assert_allclose(extrinsic.pose, [direction], atol=1e-9)
    intrinsic = frechet_mean(angles[:, None], ONE_BONE, metric=Geodesic(40), sample_weight=weights, tol=1e-5)
    np.testing.assert_allclose(intrinsic.pose, [np.average(angles, weights=weights)], atol=1e-3)
    np.testing.assert_allclose(
        intrinsic.variance, np.average((angles - intrinsic.pose) ** 2, weights=weights), rtol=1e-3
    )


@pytest.mark.filterwarnings("ignore:values of angles reach:UserWarning")  # of the other optimiser's poses
@pytest.mark.parametrize("name", SKELETONS)
def test_the_extrinsic_mean_is_what_an_optimiser_finds(name):
    skeleton = SKELETONS[name]
    X = np.random.default_rng(0).normal(scale=0.4, size=(12, skeleton.n_dofs))
    F, scale = reference.F(X, skeleton), np.repeat(np.sqrt(reference.weights(skeleton)), 3)
    target = F.mean(axis=0)
    mean = frechet_mean(X, skeleton)
    assert mean.converged
    start = X[((F - target) ** 2).sum(axis=1).argmin()]
    other = least_squares(
        lambda pose: scale * forward_kinematics(pose[None], skeleton).ravel() - target,
        start,
        lambda pose: scale[:, None] * position_jacobian(pose[None], skeleton)[0],
        xtol=1e-15, ftol=1e-15, gtol=1e-12,
    )  # fmt: skip
    found = ((scale * forward_kinematics(mean.pose[None], skeleton).ravel() - target) ** 2).sum()
    assert found < 2 * other.cost * (1 + 1e-6)  # there may be several minima, one of them lower
    np.testing.assert_allclose(mean.variance, found + ((F - target) ** 2).sum(axis=1).mean(), rtol=1e-12)
    np.testing.assert_allclose(mean.variance, total(skeleton, "position", mean.pose, X, np.full(12, 1 / 12)), rtol=1e-9)


@pytest.mark.parametrize("metric", METRICS)
def test_no_pose_next_to_it_is_better(metric):
    skeleton, X = swing()
    weights = np.random.default_rng(1).dirichlet(np.ones(len(X)))
    mean = frechet_mean(X, skeleton, metric=metric, sample_weight=weights, tol=1e-5)
    assert mean.converged
    np.testing.assert_allclose(mean.variance, total(skeleton, metric, mean.pose, X, weights), rtol=1e-7)
    for pose in [*X, *(mean.pose + np.random.default_rng(2).normal(scale=0.02, size=(20, 3)))]:
        assert total(skeleton, metric, pose, X, weights) > mean.variance


@pytest.mark.parametrize("metric", METRICS)
def test_bones_keep_their_lengths_as_the_mean_of_positions_does_not(metric):
    skeleton, X = swing()
    F = forward_kinematics(X, skeleton)
    shrunk = bone_lengths(F.mean(axis=0), skeleton)
    assert (shrunk < 0.85).all()
    mean = frechet_mean(X, skeleton, metric=metric)
    np.testing.assert_allclose(bone_lengths(forward_kinematics(mean.pose[None], skeleton)[0], skeleton), 1, atol=1e-12)


def test_the_intrinsic_mean_of_two_poses_is_the_middle_of_the_geodesic():
    skeleton, X = swing()
    a, b = X[3], X[17]
    mean = frechet_mean([a, b], skeleton, metric=Geodesic(40), tol=1e-5)
    path = geodesic(a, b, skeleton, metric=Geodesic(40))
    half = forward_kinematics(path.resample(3)[1:2], skeleton)
    np.testing.assert_allclose(forward_kinematics(mean.pose[None], skeleton), half, atol=0.01)
    np.testing.assert_allclose(mean.variance, path.length**2 / 4, rtol=5e-3)


@pytest.mark.parametrize("metric", METRICS)
def test_weights_count_poses(metric):
    skeleton, X = swing(5)
    counts = [3, 0, 1, 2, 1]
    weighted = frechet_mean(X, skeleton, metric=metric, sample_weight=counts, tol=1e-5)
    repeated = frechet_mean(np.repeat(X, counts, axis=0), skeleton, metric=metric, tol=1e-5)
    np.testing.assert_allclose(weighted.pose, repeated.pose, atol=1e-4)
    np.testing.assert_allclose(weighted.variance, repeated.variance, rtol=1e-6)


@pytest.mark.parametrize("metric", ["position", "rotation"])
def test_weights_count_poses_that_are_far_apart(metric):
    """Searches from several poses take some of them, which stand for their copies, too."""
    skeleton, counts = Skeleton.chain(5), [1, 2, 3, 1, 2]
    X = np.random.default_rng(0).uniform(-np.pi, np.pi, (5, 5))
    weighted = frechet_mean(X, skeleton, metric=metric, sample_weight=counts)
    repeated = frechet_mean(np.repeat(X, counts, axis=0), skeleton, metric=metric)
    np.testing.assert_allclose(weighted.variance, repeated.variance, rtol=1e-9)


@pytest.mark.parametrize("metric", METRICS)
def test_whole_turns_do_not_matter(metric):
    skeleton, X = swing()
    shifted = X + 2 * np.pi * np.random.default_rng(0).integers(-2, 3, X.shape)
    one, other = (frechet_mean(poses, skeleton, metric=metric, tol=1e-5) for poses in (X, shifted))
    F = [forward_kinematics(mean.pose[None], skeleton) for mean in (one, other)]
    np.testing.assert_allclose(*F, atol=1e-4)
    np.testing.assert_allclose(one.variance, other.variance, rtol=1e-6)


def test_a_gait_has_an_intrinsic_mean():
    gait = make_gait(n_subjects=1, n_sequences=1, random_state=0)
    X, _ = gait.poses(1.5)
    extrinsic, intrinsic = (frechet_mean(X, gait.skeleton, metric=metric) for metric in METRICS)
    assert intrinsic.converged
    assert intrinsic.variance < total(gait.skeleton, "geodesic", extrinsic.pose, X, np.full(len(X), 1 / len(X)))


def test_opposite_poses_have_a_mean():
    """The mean of the positions is the root itself, as far from every pose as from any other."""
    mean = frechet_mean([[0.0], [np.pi]], ONE_BONE)
    np.testing.assert_allclose(mean.variance, 2)
    skeleton = Skeleton.chain(2)
    mean = frechet_mean([[0.0, 0.0], [np.pi, 0.0]], skeleton)
    np.testing.assert_allclose(mean.variance, 1 + 5)  # folded; stretched, which is a saddle, it would be 5 + 5


def test_cmu_poses(cmu):
    motion = cmu.motions[0].resample(6)
    for metric in METRICS:
        mean = frechet_mean(motion.angles, motion.skeleton, metric=metric, n_jobs=2)
        D = pose_distances(motion.angles, skeleton=motion.skeleton, metric=metric, n_jobs=2)
        assert mean.converged
        assert mean.variance < (D**2).mean(axis=1).min()
        lengths = bone_lengths(forward_kinematics(mean.pose[None], motion.skeleton)[0], motion.skeleton)
        np.testing.assert_allclose(lengths, np.linalg.norm(motion.skeleton.offsets, axis=1), atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("metric", ["position", "rotation"])
def test_no_other_start_leads_to_a_better_mean_of_two_poses(metric):
    """Poses far apart have several local minima."""

    def variance(pose):
        return np.square(pose_distances(pose[None], X, skeleton=skeleton, metric=metric)).mean()

    for seed in range(4):
        rng, n = np.random.default_rng(seed), 3 + seed
        skeleton, X = Skeleton.chain(n), rng.uniform(-np.pi, np.pi, (2, n))
        starts = [*X, X.mean(axis=0), *rng.uniform(-np.pi, np.pi, (3, n))]
        best = min(minimize(variance, start, method="BFGS").fun for start in starts)
        assert frechet_mean(X, skeleton, metric=metric).variance <= 1.003 * best


def test_warns_when_it_does_not_converge():
    skeleton, X = swing()
    for metric in METRICS:
        with pytest.warns(ConvergenceWarning, match="raise max_iter"):
            mean = frechet_mean(X, skeleton, metric=metric, max_iter=1)
        assert not mean.converged
