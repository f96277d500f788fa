import functools
from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
import pytest
from conftest import SKELETONS

from skpose import Motion, Skeleton, forward_kinematics, geodesic, plot, pose_distances
from skpose.biomechanics import JointAngles
from skpose.manifold import SpatialMDS
from skpose.metrics import Spatial
from skpose.motions import align_motions
from skpose.plot import (
    AlignmentDisplay,
    DistanceMatrixDisplay,
    GeodesicDisplay,
    JointAnglesDisplay,
    MDSDisplay,
    PoseDisplay,
)
from skpose.plot._axes import SIDES
from skpose.skeleton._sides import sides
from skpose.statistics import PoseTangentPCA

pytestmark = pytest.mark.usefixtures("agg")


ARM = Skeleton.chain(3)


START, END = [0.2, 0.3, 0.0], [2.4, 0.2, 0.1]


X = np.random.default_rng(0).normal(size=(20, 3))


@functools.cache
def shortest_path():
    return geodesic(START, END, ARM)


@functools.cache
def aligned():
    return align_motions(X[:8], X[8:], skeleton=ARM)


@functools.cache
def drawn_bones(line):
    """Segments of a line with gaps, (n, 2, 2)."""
    points = np.stack(line.get_data(), axis=1).reshape(-1, 3, 2)
    assert np.isnan(points[:, 2]).all()
    return points[:, :2]


def some_angles():
    return JointAngles(("knee_flexion_left",), 100 * X[:, :1], np.arange(20) / 10, "rest pose", {})


DISPLAYS = {
    "pose": lambda ax: PoseDisplay.from_pose(START, ARM, ax=ax),
    "positions": lambda ax: PoseDisplay.from_positions(np.ones((3, 3)), ARM, ax=ax),
    "strip": lambda ax: PoseDisplay.from_poses(X[:3], ARM, ax=ax),
    "motion": lambda ax: PoseDisplay.from_motion(Motion(ARM, X, 10), ax=ax),
    "path": lambda ax: PoseDisplay.from_geodesic(shortest_path(), ARM, ax=ax),
    "embedding": lambda ax: MDSDisplay.from_estimator(SpatialMDS(skeleton=ARM).fit(X), X, X[:, 0] > 0, ax=ax),
    "matrix": lambda ax: DistanceMatrixDisplay.from_poses(X, ARM, sequence=np.repeat([0, 1], 10), ax=ax),
    "geodesic": lambda ax: GeodesicDisplay.from_geodesic(shortest_path(), ARM, ax=ax, resolution=5),
    "alignment": lambda ax: AlignmentDisplay.from_alignment(aligned(), ax=ax),
    "angles": lambda ax: JointAnglesDisplay.from_angles(some_angles(), [(0, 10), (10, 20)], ax=ax),
    "component": lambda ax: PoseDisplay.from_estimator(PoseTangentPCA(ARM).fit(X), ax=ax),
}


@pytest.mark.parametrize("name", DISPLAYS)
def test_draws_into_the_given_axes_or_new_ones_and_opens_no_window(name, monkeypatch):
    monkeypatch.setattr(plt, "show", lambda: pytest.fail("a window was opened"))
    figure, ax = plt.subplots(layout="constrained")
    display = DISPLAYS[name](ax)
    assert display.ax_ is ax
    assert display.figure_ is figure
    new = DISPLAYS[name](None)
    assert new.ax_ is not ax
    again = display.plot()
    assert again is display
    assert display.ax_ is not ax
    figure.canvas.draw()  # as a user's savefig does


@pytest.mark.parametrize("name", ["humanoid", "bvh", "mixed joints"])
def test_bones_are_where_the_joints_are(name):
    skeleton = SKELETONS[name]
    pose = np.random.default_rng(0).normal(size=skeleton.n_dofs)
    display = PoseDisplay.from_pose(pose, skeleton, projection="zy", label="it")
    F = np.concatenate([forward_kinematics(pose[None], skeleton)[0], np.zeros((1, 3))])
    lines = display.ax_.lines
    expected = np.stack([F[skeleton.parents], F[:-1]], axis=1)[..., [2, 1]]
    drawn = np.concatenate([drawn_bones(line) for line in lines])
    np.testing.assert_array_equal(*(np.unique(bones.reshape(-1, 4), axis=0) for bones in (drawn, expected)))
    assert len(drawn) == len(expected)
    assert (lines[0].get_label(), display.ax_.get_xlabel()) == ("it", "z (m)")
    assert [line.get_label()[0] for line in lines[1:]] == ["_"] * (len(lines) - 1)  # not in a legend


def drawn_by_colour(ax):
    """The bones of each colour in an axes, (n, 2, 2)."""
    found = {}
    for line in ax.lines:
        found.setdefault(line.get_color(), []).append(drawn_bones(line))
    return {colour: np.concatenate(bones) for colour, bones in found.items()}


@pytest.mark.parametrize("draw", ["pose", "motion", "path"])
def test_left_and_right_have_two_colours(draw):
    """In every display of limbs; x points to the left of the person, whose limbs hang down at angle zero."""
    skeleton = SKELETONS["humanoid"]
    pose = np.zeros(skeleton.n_dofs)
    ax = {
        "pose": lambda: PoseDisplay.from_pose(pose, skeleton),
        "positions": lambda: PoseDisplay.from_positions(forward_kinematics(pose[None], skeleton)[0], skeleton),
        "strip": lambda: PoseDisplay.from_poses(pose[None], skeleton),
        "motion": lambda: PoseDisplay.from_motion(Motion(skeleton, pose[None], 10)),
        "path": lambda: PoseDisplay.from_geodesic(geodesic(pose, pose, skeleton), skeleton, n_poses=2),
    }[draw]().ax_
    bones = drawn_by_colour(ax)
    assert list(bones) == list(SIDES.values())
    grey, left, right = bones.values()
    n_figures = 2 if draw == "path" else 1
    assert [len(part) for part in (grey, left, right)] == [4 * n_figures, 9 * n_figures, 9 * n_figures]
    if n_figures == 1:
        assert (left[:, 1, 0] > 0).all()
        np.testing.assert_allclose(right * [-1, 1], left, atol=1e-12)
        np.testing.assert_allclose(grey[..., 0], 0, atol=1e-12)


def test_degrees_are_noticed_once():
    with pytest.warns(UserWarning, match="^values of pose reach 143, .* pass np.radians") as found:
        PoseDisplay.from_pose([143.0, 90.0, 60.0], ARM)
    with pytest.warns(UserWarning, match="^values of X reach") as more:
        DistanceMatrixDisplay.from_poses(100 * X, ARM)
    for warnings in (found, more):
        assert len(warnings) == 1
        assert warnings[0].filename == __file__


def test_figures_of_a_strip_do_not_overlap_and_keep_their_size():
    skeleton = SKELETONS["humanoid"]
    poses = np.random.default_rng(0).normal(scale=0.3, size=(5, skeleton.n_dofs))
    display = PoseDisplay.from_poses(poses, skeleton, labels="abcde", title="pose", projection="xy")
    figures = [np.concatenate([drawn_bones(line) for line in display.ax_.lines[3 * i : 3 * i + 3]]) for i in range(5)]
    order = np.argsort([["", "left", "right"].index(side) for side in sides(skeleton.joint_names)], kind="stable")
    for i, figure in enumerate(figures):
        F = np.concatenate([forward_kinematics(poses[i : i + 1], skeleton)[0], np.zeros((1, 3))])
        expected = np.stack([F[skeleton.parents], F[:-1]], axis=1)[order, :, :2]
        shift = figure - expected
        np.testing.assert_allclose(shift[..., 0], shift[0, 0, 0], atol=1e-12)
        np.testing.assert_allclose(shift[..., 1], 0, atol=1e-12)
    for left, right in pairwise(figures):
        assert left[..., 0].max() < right[..., 0].min()
    assert [label.get_text() for label in display.ax_.get_xticklabels()] == list("abcde")


def test_times_and_lengths_below_a_strip():
    motion = PoseDisplay.from_motion(Motion(ARM, X, 10), n_poses=3)
    assert motion.labels == ["0.00", "1.00", "1.90"]  # frames 0, 10 and 19
    few = PoseDisplay.from_motion(Motion(ARM, X[:2], 10), n_poses=8)
    assert len(few.positions) == 2
    path = shortest_path()
    along = PoseDisplay.from_geodesic(path, ARM, n_poses=3)
    assert along.labels == ["0.00", f"{path.curve_length / 2:.2f}", f"{path.curve_length:.2f}"]
    np.testing.assert_allclose(along.positions, forward_kinematics(path.resample(3), ARM))


def test_an_embedding_has_a_colour_and_a_marker_for_each_label():
    mds = SpatialMDS(skeleton=ARM).fit(X)
    labels = np.array(["run", "walk", "jump", "stand"])[np.arange(20) % 4]
    display = MDSDisplay.from_estimator(mds, X, labels)
    assert [text.get_text() for text in display.ax_.get_legend().get_texts()] == ["jump", "run", "stand", "walk"]
    drawn = np.concatenate([dots.get_offsets() for dots in display.ax_.collections])
    order = np.argsort(labels, kind="stable")
    np.testing.assert_allclose(drawn, mds.transform(X)[order])
    assert len({tuple(dots.get_facecolor()[0]) for dots in display.ax_.collections}) == 4
    twenty = MDSDisplay.from_embedding(X, np.arange(20)).ax_.collections
    assert len({tuple(dots.get_facecolor()[0]) for dots in twenty}) == 20
    many = MDSDisplay.from_embedding(np.repeat(X, 7, axis=0), np.arange(140)).ax_.collections  # more than colours
    assert len({(*dots.get_facecolor()[0], dots.get_paths()[0].vertices.tobytes()) for dots in many}) == 140
    share = mds.explained_variance_ratio_[0]
    assert display.ax_.get_xlabel() == f"component 1 (m), {share:.0%} of the variance"
    assert MDSDisplay.from_estimator(SpatialMDS(metric="angle").fit(X), X).unit == "rad"
    assert MDSDisplay.from_estimator(SpatialMDS(skeleton=ARM, metric="angle").fit(X), X).unit == "rad"
    assert MDSDisplay.from_embedding(X).ax_.get_legend() is None


def legend_and_axes(display):
    """Return where the legend and the axes of a display are, with tick labels and names, in pixels."""
    display.figure_.canvas.draw()
    return display.ax_.get_legend().get_window_extent(), display.ax_.get_window_extent()


@pytest.mark.parametrize(("n", "layout"), [(8, "constrained"), (40, "new")])
def test_a_legend_of_many_labels_is_next_to_the_axes(n, layout):
    if layout == "new":
        displays = [MDSDisplay.from_embedding(np.repeat(X, 2, axis=0), np.arange(40) % n)]
    else:
        many = np.repeat(X, 2, axis=0), np.arange(40) % n
        _, axes = plt.subplots(1, 2, figsize=(14, 5), layout=layout)
        displays = [MDSDisplay.from_embedding(*many, ax=ax) for ax in axes]
    for i, display in enumerate(displays):
        legend, axes = legend_and_axes(display)
        assert legend.x0 >= axes.x1
        assert legend.y0 >= axes.y0 - 1.0
        assert axes.width > 100.0
        beyond = display.figure_.bbox.x1 if i + 1 == len(displays) else displays[1].ax_.get_window_extent().x0
        assert legend.x1 <= beyond
    plt.close("all")


def test_a_legend_of_few_labels_is_in_the_axes():
    legend, axes = legend_and_axes(MDSDisplay.from_embedding(X, np.arange(20) % 7))
    assert axes.x0 <= legend.x0 <= legend.x1 <= axes.x1


def test_neighbours_of_one_name_share_a_label_in_their_middle():
    sequence, D = np.repeat([0, 1, 2, 3], [4, 6, 3, 7]), np.zeros((20, 20))
    display = DistanceMatrixDisplay.from_distances(D, sequence=sequence, names=["walk", "walk", "run", "walk"])
    assert [label.get_text() for label in display.ax_.get_xticklabels()] == ["walk", "run", "walk"]
    np.testing.assert_array_equal(display.ax_.get_yticks(), [4.5, 11.0, 16.0])
    widths = {line.get_xdata()[0]: line.get_linewidth() for line in display.ax_.lines if len({*line.get_xdata()}) == 1}
    assert sorted(widths) == [3.5, 9.5, 12.5]
    assert widths[3.5] < widths[9.5] == widths[12.5]


def test_a_matrix_has_borders_between_sequences_and_names_in_their_middle():
    sequence = np.repeat([3, 5, 4], [4, 6, 10])
    display = DistanceMatrixDisplay.from_poses(X, ARM, sequence=sequence, names=["a", "b", "c"], metric="position")
    np.testing.assert_array_equal(display.ax_.images[0].get_array(), pose_distances(X, skeleton=ARM, metric="position"))
    assert sorted(line.get_xdata()[0] for line in display.ax_.lines if line.get_xdata()[0] == line.get_xdata()[1]) == [
        3.5, 9.5,
    ]  # fmt: skip
    np.testing.assert_array_equal(display.ax_.get_xticks(), [1.5, 6.5, 14.5])
    assert DistanceMatrixDisplay.from_poses(X, metric="angle").figure_.axes[1].get_ylabel() == "distance (rad)"


def test_a_geodesic_is_drawn_with_the_line_and_the_ratio_of_their_lengths():
    path = shortest_path()
    line = pose_distances([START], [END], skeleton=ARM, metric=Spatial(len(path.path) - 1))[0, 0]
    display = GeodesicDisplay.from_geodesic(path, ARM, resolution=5)
    np.testing.assert_allclose(display.ratio_, path.length / line, rtol=1e-12)
    straight, curve = (np.stack(drawn.get_data(), axis=1) for drawn in display.ax_.lines)
    np.testing.assert_allclose(straight[[0, -1]], curve[[0, -1]], atol=1e-9)
    assert len(curve) == len(path.path)


@pytest.mark.parametrize(
    ("draw", "name"),
    [
        (lambda: PoseDisplay.from_pose(START, None), "skeleton"),
        (lambda: PoseDisplay.from_pose(START, ARM, projection="front"), "projection"),
        (lambda: PoseDisplay.from_positions(np.ones((2, 3)), ARM), "positions"),
        (lambda: PoseDisplay.from_motion(Motion(ARM, X[:0], 10)), "motion"),
        (lambda: PoseDisplay.from_motion(Motion(ARM, X, 10), n_poses=0), "n_poses"),
        (lambda: PoseDisplay.from_poses(X, ARM, labels=["a"]), "labels"),
        (lambda: GeodesicDisplay.from_geodesic(ARM, shortest_path()), "geodesic"),
        (lambda: GeodesicDisplay.from_geodesic(shortest_path(), Skeleton.chain(2)), "skeleton"),
        (lambda: MDSDisplay.from_estimator(X, SpatialMDS()), "mds"),
        (lambda: MDSDisplay.from_embedding(X[:, :1]), "embedding"),
        (lambda: DistanceMatrixDisplay.from_distances(X), "distances"),
        (lambda: DistanceMatrixDisplay.from_poses(X, ARM, sequence=[1]), "sequence"),
        (lambda: AlignmentDisplay.from_alignment(X), "alignment"),
        (lambda: AlignmentDisplay.from_alignment(aligned(), quantity="angle"), "quantity"),
        (lambda: JointAnglesDisplay.from_angles(X), "angles"),
        (lambda: PoseDisplay.from_estimator(PoseTangentPCA(ARM).fit(X), 3), "component"),
        (lambda: PoseDisplay.from_pose(START, ARM, ax=plt.figure().add_subplot(), projection="zxy"), "ax"),
    ],
)
def test_wrong_arguments_are_refused_by_name(draw, name):
    with pytest.raises((TypeError, ValueError), match=rf"\b{name}\b"):
        draw()


def test_all_displays_are_tested_here():
    names = {type(DISPLAYS[name](None)).__name__ for name in DISPLAYS}
    assert names == {name for name in plot.__all__ if name.endswith("Display")}


def test_equal_poses_can_be_drawn():
    """Nothing is divided by a length of zero: warnings are errors here."""
    display = GeodesicDisplay.from_geodesic(geodesic(START, START, ARM), ARM, resolution=4)
    assert display.ratio_ == 1.0
    for shown in (
        display,
        PoseDisplay.from_poses(np.zeros((3, 3)), ARM, projection="zy"),
        DistanceMatrixDisplay.from_poses(np.zeros((3, 3)), ARM),
        MDSDisplay.from_embedding(np.zeros((3, 2)), ["a", "b", "b"], shares=[0.0, 0.0]),
    ):
        shown.figure_.canvas.draw()
        assert np.isfinite([*shown.ax_.get_xlim(), *shown.ax_.get_ylim()]).all()
