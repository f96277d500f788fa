"""Poses in axes of three dimensions, and labels and legends that can be read."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from conftest import SKELETONS

from skpose import Skeleton, forward_kinematics, geodesic
from skpose.plot import GeodesicDisplay, PoseDisplay
from skpose.plot._axes import SIDES

pytestmark = pytest.mark.usefixtures("agg")

ARM = Skeleton.chain(3)


def drawn_bones(ax):
    """Segments of all lines in axes of three dimensions, (n, 2, 3)."""
    points = np.concatenate([np.stack(line.get_data_3d(), axis=1).reshape(-1, 3, 3) for line in ax.lines])
    assert np.isnan(points[:, 2]).all()
    return points[:, :2]


@pytest.mark.parametrize("projection", ["zxy", "xyz", "yzx"])
@pytest.mark.parametrize("skeleton", SKELETONS.values(), ids=SKELETONS)
def test_bones_are_where_the_joints_are(skeleton, projection):
    pose = np.random.default_rng(0).normal(size=skeleton.n_dofs)
    display = PoseDisplay.from_pose(pose, skeleton, projection=projection, label="it")
    ax, columns = display.ax_, ["xyz".index(axis) for axis in projection]
    F = np.concatenate([forward_kinematics(pose[None], skeleton)[0], np.zeros((1, 3))])
    expected = np.stack([F[skeleton.parents], F[:-1]], axis=1)[..., columns]
    np.testing.assert_array_equal(*(np.unique(bones.reshape(-1, 6), axis=0) for bones in (drawn_bones(ax), expected)))
    assert [ax.get_xlabel(), ax.get_ylabel(), ax.get_zlabel()] == [f"{axis} (m)" for axis in projection]
    assert [line.get_label()[0] for line in ax.lines] == ["i"] + ["_"] * (len(ax.lines) - 1)
    display.figure_.canvas.draw()


def test_three_axes_show_no_mirror_image():
    """The third axis is the cross product of the others, on the page as in the file."""
    for projection in ("zxy", "xyz", "yzx"):
        first, second, third = np.eye(3)[["xyz".index(axis) for axis in projection]]
        np.testing.assert_array_equal(np.cross(first, second), third)
    for projection in ("xzy", "yxz", "zyx"):
        with pytest.raises(ValueError, match="exchange left and right"):
            PoseDisplay.from_pose(np.zeros(3), ARM, projection=projection)


def test_lengths_are_equal_in_all_directions_and_sides_have_colours():
    skeleton = SKELETONS["humanoid"]
    ax = PoseDisplay.from_pose(np.zeros(skeleton.n_dofs), skeleton, projection="zxy").ax_
    ranges = np.array([np.ptp(ax.get_xlim3d()), np.ptp(ax.get_ylim3d()), np.ptp(ax.get_zlim3d())])
    shares = ranges / ax.get_box_aspect()
    np.testing.assert_allclose(shares, shares[0])
    assert {line.get_color() for line in ax.lines} == set(SIDES.values())


def test_given_axes_are_drawn_into_and_must_fit_the_view():
    figure = plt.figure()
    flat, deep = figure.add_subplot(121), figure.add_subplot(122, projection="3d")
    assert PoseDisplay.from_pose(np.zeros(3), ARM, ax=deep, projection="zxy").ax_ is deep
    assert PoseDisplay.from_pose(np.zeros(3), ARM, ax=deep).projection_ == "zxy"
    with pytest.raises(ValueError, match=r'ax has three dimensions, got projection=.xy.: pass three axes.*"zxy"'):
        PoseDisplay.from_pose(np.zeros(3), ARM, ax=deep, projection="xy")
    with pytest.raises(
        ValueError, match=r"projection='zxy' has three axes and needs an ax of three dimensions.*subplot_kw"
    ):
        PoseDisplay.from_pose(np.zeros(3), ARM, ax=flat, projection="zxy")
    with pytest.raises(ValueError, match="must have each of x, y, z once"):
        PoseDisplay.from_pose(np.zeros(3), ARM, projection="xxy")


@pytest.mark.slow
def test_the_legend_of_a_geodesic_covers_no_point_of_the_curves():
    rng = np.random.default_rng(0)
    for _ in range(12):
        path = geodesic(rng.normal(size=3), rng.normal(size=3), ARM)
        figure, axes = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
        for ax in (axes[0], None):  # as in the gallery, and alone
            display = GeodesicDisplay.from_geodesic(path, ARM, ax=ax, resolution=5)
            display.figure_.canvas.draw()
            box = display.ax_.get_legend().get_window_extent().padded(6)  # half a marker, pixels
            for line in display.ax_.lines:
                for point in display.ax_.transData.transform(np.stack(line.get_data(), axis=1)):
                    assert not box.contains(*point)
            plt.close(display.figure_)
        plt.close(figure)
