import numpy as np
import pytest
from matplotlib.figure import Figure

from skpose import Skeleton, forward_kinematics
from skpose.plot import PoseDisplay
from skpose.statistics import PoseTangentPCA

CHAIN = Skeleton.chain(3)


X = np.random.default_rng(0).normal(scale=0.4, size=(20, 3))


@pytest.fixture
def pca():
    return PoseTangentPCA(CHAIN).fit(X)


def test_poses_along_a_component(pca):
    display = PoseDisplay.from_estimator(pca, 1, n_poses=3, extent=1.5)
    poses = pca.inverse_transform(1.5 * np.sqrt(pca.explained_variance_[1]) * np.outer([-1, 0, 1], [0, 1, 0]))
    np.testing.assert_allclose(display.positions, forward_kinematics(poses, CHAIN), atol=1e-12)
    assert [label.get_text() for label in display.ax_.get_xticklabels()] == ["−1.5", "0", "+1.5"]
    share = pca.explained_variance_ratio_[1]
    assert display.ax_.get_xlabel() == f"standard deviations along component 2, {share:.0%} of the variance"
    assert len(display.ax_.get_lines()) == 3


def test_the_mean_is_in_the_middle_and_drawn_into_the_given_axes(pca):
    ax = Figure().subplots()
    display = PoseDisplay.from_estimator(pca, ax=ax, projection="yx", color="black")
    assert display.ax_ is ax
    assert display.figure_ is ax.figure
    np.testing.assert_allclose(display.positions[2], forward_kinematics(pca.mean_[None], CHAIN)[0], atol=1e-12)
    assert display.ax_.get_ylabel() == "x (m)"
    assert {line.get_color() for line in ax.get_lines()} == {"black"}
