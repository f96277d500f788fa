import numpy as np
import pytest
import reference
from conftest import MIXED, random_tree, weighted
from sklearn.decomposition import PCA

from skpose import Bone, Skeleton, forward_kinematics, pose_distances
from skpose.geodesics import frechet_mean, log_map
from skpose.kinematics import position_jacobian as jacobian_of
from skpose.statistics import PoseTangentPCA

CHAIN = Skeleton.chain(3)
METRICS = ["angle", "position", "geodesic"]
TREES = {
    "angles": random_tree(0, n=7),
    "mixed": random_tree(1, n=7, kinds=MIXED),
    "weighted": weighted(random_tree(2, n=7, kinds=MIXED), 2),
}


def poses_of(skeleton, n=30, scale=0.4, seed=0):
    """Poses with variances that differ, about a pose that is not zero."""
    rng = np.random.default_rng(seed)
    scales = scale * rng.uniform(0.2, 1.0, skeleton.n_dofs)
    return rng.normal(scale=0.5, size=skeleton.n_dofs) + rng.normal(size=(n, skeleton.n_dofs)) * scales


def bone_lengths(X, skeleton):
    joints = forward_kinematics(X, skeleton)
    near = np.concatenate([joints, np.zeros_like(joints[:, :1])], axis=1)[:, skeleton.parents]
    return np.linalg.norm(joints - near, axis=2)


# --- against other PCAs ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n_components", [None, 2, 0.8])
def test_without_a_skeleton_it_is_scikit_learns(n_components):
    X, new = poses_of(CHAIN), poses_of(CHAIN, seed=1)
    pca, other = PoseTangentPCA(n_components=n_components, metric="angle").fit(X), PCA(n_components).fit(X)
    for name in ("mean_", "components_", "explained_variance_", "explained_variance_ratio_", "singular_values_"):
        np.testing.assert_allclose(getattr(pca, name), getattr(other, name), atol=1e-12, err_msg=name)
    assert pca.n_components_ == other.n_components_
    np.testing.assert_allclose(pca.transform(new), other.transform(new), atol=1e-12)
    scores = other.transform(new)
    np.testing.assert_allclose(pca.inverse_transform(scores), other.inverse_transform(scores), atol=1e-12)
    off = np.square(other.inverse_transform(scores) - new).mean(axis=1)
    np.testing.assert_allclose(pca.reconstruction_error(new), np.sqrt(off), atol=1e-12)


def test_small_movements_are_pca_of_positions():
    """The positions are linear then, and both find the same variances and components."""
    skeleton = TREES["mixed"]
    X = poses_of(skeleton, scale=1e-5, n=60)
    F = reference.F(X, skeleton)
    pca, other = PoseTangentPCA(skeleton, n_components=4).fit(X), PCA(4).fit(F)
    np.testing.assert_allclose(pca.explained_variance_, other.explained_variance_, rtol=1e-3)
    cosines = np.abs((other.components_ * pca.components_ * roots(skeleton)).sum(axis=1))
    np.testing.assert_allclose(cosines, 1.0, atol=1e-4)


def roots(skeleton):
    return np.repeat(np.sqrt(reference.weights(skeleton)), 3)


def test_the_vectors_of_position_are_the_jacobian_times_the_wrapped_differences():
    """By the definition, for joints of one angle, whose mean step is the circular mean of the differences."""
    X = poses_of(CHAIN) + 2.0 * np.pi * np.random.default_rng(3).integers(-2, 3, (30, 3))
    pca = PoseTangentPCA(CHAIN).fit(X)
    steps = reference.differences(pca.mean_, X, wrap=True)
    np.testing.assert_allclose(steps.mean(axis=0), 0.0, atol=1e-9)
    vectors = steps @ jacobian_of(pca.mean_[None], CHAIN)[0].T
    U, S, Vt = np.linalg.svd(vectors, full_matrices=False)
    np.testing.assert_allclose(pca.singular_values_, S[: pca.n_components_], rtol=1e-9)
    np.testing.assert_allclose(np.abs(pca.transform(X)), np.abs(U * S)[:, : pca.n_components_], atol=1e-9)
    np.testing.assert_allclose(np.abs(pca.components_), np.abs(Vt[: pca.n_components_]), atol=1e-9)


def test_the_vectors_of_geodesic_are_logarithms_at_the_intrinsic_mean():
    skeleton = Skeleton.chain(3).with_weights([1.0, 2.0, 0.5])
    X = poses_of(skeleton, n=12)
    pca = PoseTangentPCA(skeleton, metric="geodesic").fit(X)
    np.testing.assert_array_equal(pca.mean_, frechet_mean(X, skeleton, metric="geodesic").pose)
    vectors = log_map(pca.mean_, X, skeleton).reshape(12, -1) * roots(skeleton)
    sizes = np.linalg.svd(vectors, compute_uv=False)[: pca.n_components_]
    np.testing.assert_allclose(pca.singular_values_, sizes, rtol=1e-9)
    expected = pose_distances(pca.mean_[None], X, skeleton=skeleton, metric="geodesic")[0]
    np.testing.assert_allclose(np.linalg.norm(pca.transform(X), axis=1), expected, rtol=5e-3)


# --- properties ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", TREES)
def test_components_are_motions_of_the_joints(name):
    """The derivative of the positions by a score, orthonormal when scaled by the roots of the weights."""
    skeleton = TREES[name]
    pca = PoseTangentPCA(skeleton, n_components=3).fit(poses_of(skeleton))
    scaled = pca.components_ * roots(skeleton)
    np.testing.assert_allclose(scaled @ scaled.T, np.eye(3), atol=1e-9)
    for k in range(3):
        scores = 1e-5 * np.array([[1.0], [-1.0]]) * np.eye(3)[k]
        up, down = reference.forward_kinematics(pca.inverse_transform(scores), skeleton).reshape(2, -1)
        np.testing.assert_allclose((up - down) / 2e-5, pca.components_[k], atol=1e-6)
        assert scaled[k, np.abs(scaled[k]).argmax()] > 0


@pytest.mark.parametrize("name", TREES)
def test_scores_come_back_and_bones_keep_their_lengths(name):
    skeleton = TREES[name]
    pca = PoseTangentPCA(skeleton, n_components=3).fit(poses_of(skeleton))
    scores = np.random.default_rng(1).normal(size=(5, 3)) * np.sqrt(pca.explained_variance_)
    X = pca.inverse_transform(scores)
    np.testing.assert_allclose(pca.transform(X), scores, atol=1e-9)
    np.testing.assert_allclose(bone_lengths(X, skeleton), np.tile(np.linalg.norm(skeleton.offsets, axis=1), (5, 1)))


def test_scores_of_geodesics_come_back():
    pca = PoseTangentPCA(CHAIN, n_components=3, metric="geodesic").fit(poses_of(CHAIN, n=12))
    scores = np.random.default_rng(1).normal(size=(5, 3)) * np.sqrt(pca.explained_variance_)
    np.testing.assert_allclose(pca.transform(pca.inverse_transform(scores)), scores, atol=1e-4)
    X = poses_of(CHAIN, n=5, seed=2)
    assert (pca.reconstruction_error(X) < 1e-4).all()  # three components are all


@pytest.mark.parametrize("metric", METRICS)
def test_variances_are_those_of_the_scores(metric):
    X = poses_of(CHAIN, n=12)
    pca = PoseTangentPCA(CHAIN, metric=metric)
    scores = pca.fit_transform(X)
    np.testing.assert_array_equal(scores, pca.transform(X))
    np.testing.assert_allclose(pca.explained_variance_, np.square(scores).sum(axis=0) / 11, rtol=1e-9)
    np.testing.assert_allclose(pca.singular_values_, np.linalg.norm(scores, axis=0), rtol=1e-9)
    np.testing.assert_allclose(pca.explained_variance_ratio_.sum(), 1.0)
    assert (np.diff(pca.explained_variance_) <= 0).all()


def test_the_error_of_the_joints_is_what_it_says():
    skeleton = TREES["weighted"]
    X, new = poses_of(skeleton), poses_of(skeleton, n=4, seed=5)
    pca = PoseTangentPCA(skeleton, n_components=2).fit(X)
    found = pca.inverse_transform(pca.transform(new))
    w = reference.weights(skeleton)
    gaps = reference.forward_kinematics(new, skeleton) - reference.forward_kinematics(found, skeleton)
    expected = np.sqrt(np.square(gaps).sum(axis=2) @ w / w.sum())
    np.testing.assert_allclose(pca.reconstruction_error(new), expected, rtol=1e-9)


def test_a_twist_comes_back_as_it_varies_with_the_scores():
    """At the mean the arm is straight, and its twist, which moves no joint there, rises with the shoulder."""
    arm = Skeleton([Bone("elbow", None, (0.3, 0.0, 0.0), "rotvec"), Bone("wrist", "elbow", (0.25, 0.0, 0.0), "y")])
    rise = np.linspace(-1.0, 1.0, 21)
    X = np.stack([0.5 * rise, 0.0 * rise, rise, 0.0 * rise], axis=1)
    pca = PoseTangentPCA(arm).fit(X)
    assert pca.n_components_ == 1
    np.testing.assert_allclose(pca.inverse_transform(pca.transform(X)), X, atol=1e-9)


# --- weights, conventions of angles ----------------------------------------------------------------------------------


# --- conduct ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("metric", METRICS)
def test_components_without_variance_are_zero(metric):
    """As many components as poses, as scikit-learn's PCA has them, but no direction is made of rounding."""
    X = poses_of(CHAIN, n=3)
    pca, two = (PoseTangentPCA(CHAIN, n_components=k, metric=metric).fit(X) for k in (3, 2))
    assert pca.n_components_ == 3
    assert PoseTangentPCA(CHAIN, metric=metric).fit(X).n_components_ == 2
    for name in ("components_", "explained_variance_", "explained_variance_ratio_", "singular_values_"):
        known, more = getattr(two, name), getattr(pca, name)
        np.testing.assert_array_equal(more, np.concatenate([known, np.zeros_like(known[:1])]), err_msg=name)
    others = poses_of(CHAIN, n=12)[3:]
    scores = pca.transform(others)
    np.testing.assert_array_equal(scores, np.c_[two.transform(others), np.zeros(len(others))])
    scores[:, 2] = 1.0
    np.testing.assert_array_equal(pca.inverse_transform(scores), two.inverse_transform(scores[:, :2]))
