"""Poses in axes of three dimensions, and labels and legends that can be read."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from conftest import SKELETONS

from skpose import Skeleton, forward_kinematics
from skpose.plot import PoseDisplay

pytestmark = pytest.mark.usefixtures("agg")


ARM = Skeleton.chain(3)


def drawn_bones(ax):
    """Segments of all lines in axes of three dimensions, (n, 2, 3)."""
    points = np.concatenate([np.stack(line.get_data_3d(), axis=1).reshape(-1, 3, 3) for line in ax.lines])
    assert np.isnan(points[:, 2]).all()
    return points[:, :2]


@pytest.mark.parametrize("projection", ["zxy", "xyz"])
def test_bones_are_where_the_joints_are(projection):
    skeleton = SKELETONS["humanoid"]
    pose = np.random.default_rng(0).normal(size=skeleton.n_dofs)
    display = PoseDisplay.from_pose(pose, skeleton, projection=projection, label="it")
    ax, columns = display.ax_, ["xyz".index(axis) for axis in projection]
    F = np.concatenate([forward_kinematics(pose[None], skeleton)[0], np.zeros((1, 3))])
    expected = np.stack([F[skeleton.parents], F[:-1]], axis=1)[..., columns]
    np.testing.assert_array_equal(*(np.unique(bones.reshape(-1, 6), axis=0) for bones in (drawn_bones(ax), expected)))
    assert [ax.get_xlabel(), ax.get_ylabel(), ax.get_zlabel()] == [f"{axis} (m)" for axis in projection]
    assert [line.get_label()[0] for line in ax.lines] == ["i"] + ["_"] * (len(ax.lines) - 1)
    display.figure_.canvas.draw()


def test_axes_and_projection_must_fit():
    figure = plt.figure()
    flat, deep = figure.add_subplot(121), figure.add_subplot(122, projection="3d")
    assert PoseDisplay.from_pose(np.zeros(3), ARM, ax=deep).projection_ == "zxy"
    for ax, projection in ((deep, "xy"), (flat, "zxy"), (None, "xzy"), (None, "xxy")):
        with pytest.raises(ValueError, match="projection"):
            PoseDisplay.from_pose(np.zeros(3), ARM, ax=ax, projection=projection)
