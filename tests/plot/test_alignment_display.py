from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
import pytest
from conftest import SKELETONS
from matplotlib.collections import LineCollection

from skpose import Motion, Skeleton, forward_kinematics
from skpose.datasets import make_gait
from skpose.motions import align_motions
from skpose.plot import AlignmentDisplay
from skpose.plot._axes import SIDES

pytestmark = pytest.mark.usefixtures("agg")

ARM = Skeleton.chain(2)


def two_motions(name="humanoid", n=20, m=30):
    """A movement, and the same one at another tempo with noise."""
    skeleton = SKELETONS[name]
    rng = np.random.default_rng(0)
    ends = rng.uniform(-0.7, 0.7, size=(3, skeleton.n_dofs))
    times = np.linspace(0, 2, n), 2 * np.linspace(0, 1, m) ** 2
    through = [np.stack([np.interp(t, range(3), column) for column in ends.T], axis=1) for t in times]
    return [Motion(skeleton, X + rng.normal(scale=0.02, size=X.shape), 10) for X in through]


@pytest.mark.parametrize(("quantity", "factor"), [("distance", 100), ("rotation", 180 / np.pi)])
@pytest.mark.parametrize("name", ["humanoid", "tree"])
def test_the_map_has_the_largest_difference_of_each_frame(name, quantity, factor):
    found = align_motions(*two_motions(name))
    display = AlignmentDisplay.from_alignment(found, quantity=quantity)
    (image,) = display.map_ax_.images
    array = {"distance": found.joint_distances, "rotation": found.joint_rotations}[quantity]
    shown = [j for j, bone in enumerate(found.skeleton.bones) if bone.dofs or quantity == "distance"]
    expected = np.zeros((len(found.a), len(shown)))
    for (i, _), values in zip(found.path, array[:, shown], strict=True):
        expected[i] = np.maximum(expected[i], factor * values)
    np.testing.assert_allclose(image.get_array(), expected.T, rtol=1e-12)
    assert image.get_extent() == [-0.05, 1.95, len(shown) - 0.5, -0.5]  # s: a frame is in the middle of its column
    labels = [label.get_text() for label in display.map_ax_.get_yticklabels()]
    assert labels == [found.skeleton.joint_names[j] for j in shown]
    np.testing.assert_array_equal(display.map_ax_.get_yticks(), np.arange(len(shown)))
    assert image.get_clim()[0] == 0.0


def test_a_spoiled_joint_is_the_brightest():
    motion, _ = two_motions()
    angles = motion.angles.copy()
    angles[12, motion.skeleton.dof_names.index("right_forearm_rx")] += 1.0
    display = AlignmentDisplay.from_motions(motion, Motion(motion.skeleton, angles, 10), quantity="rotation")
    values = display.map_ax_.images[0].get_array()
    row, frame = np.unravel_index(values.argmax(), values.shape)
    assert (display.map_ax_.get_yticklabels()[row].get_text(), frame) == ("right_forearm", 12)


def figures(display):
    """The points of each figure in the display's pixels, as they are drawn: a list of (n, 2)."""
    found = {}
    for line in display.strips_ax_.lines:
        points = np.stack(line.get_data(), axis=1)
        where = line.get_transform().transform(points[~np.isnan(points[:, 0])])
        found.setdefault(id(line.get_transform()), []).append(where)
    return [np.concatenate(parts) for parts in found.values()]


@pytest.mark.parametrize("projection", ["xy", "zy"])
def test_poses_keep_their_shape_and_stand_at_their_times(projection):
    found = align_motions(*two_motions())
    display = AlignmentDisplay.from_alignment(found, n_poses=6, projection=projection)
    display.figure_.canvas.draw()
    columns = ["xyz".index(axis) for axis in projection]
    for inches in (None, (5, 9), (14, 6)):
        if inches:
            display.figure_.set_size_inches(inches)
            display.figure_.canvas.draw()
        drawn = figures(display)
        assert len(drawn) == 12
        pairs = display.strips_ax_.collections[1].get_segments()  # 1.9 s of the first, and 29 frames of the second
        frames = [round(10 * top) for (top, _), _ in pairs], [round(29 * bottom / 1.9) for _, (bottom, _) in pairs]
        times = [top for (top, _), _ in pairs] + [bottom for _, (bottom, _) in pairs]
        scales = []
        for figure, time, pose in zip(drawn, times, [*found.a[frames[0]], *found.b[frames[1]]], strict=True):
            joints = np.append(forward_kinematics(pose[None], found.skeleton)[0], np.zeros((1, 3)), axis=0)
            bones = np.concatenate([joints[found.skeleton.parents], joints[:-1]])[:, columns]
            scales.append(np.ptp(figure, axis=0) / np.ptp(bones, axis=0))
            shape = np.sort(scales[-1] * (bones - bones.min(axis=0)), axis=0)
            np.testing.assert_allclose(np.sort(figure - figure.min(axis=0), axis=0), shape, atol=1e-6)
            middle = (figure[:, 0].min() + figure[:, 0].max()) / 2
            np.testing.assert_allclose(middle, display.strips_ax_.transData.transform((time, 0))[0], atol=1e-6)
        np.testing.assert_allclose(scales, scales[0][0], rtol=1e-6)
        box = display.strips_ax_.get_window_extent()
        assert all(box.y0 <= figure[:, 1].min() and figure[:, 1].max() <= box.y1 for figure in drawn)
        assert min(figure[:, 1].min() for figure in drawn[:6]) > max(figure[:, 1].max() for figure in drawn[6:])
        assert max(np.ptp(figure[:, 0]) for figure in drawn) < box.width / 6


def test_lines_join_pairs_of_the_path():
    found = align_motions(*two_motions())
    display = AlignmentDisplay.from_alignment(found, n_poses=5)
    grey, black = (c for c in display.strips_ax_.collections if isinstance(c, LineCollection))
    expected = {(round(i / 10, 9), round(1.9 * j / 29, 9)) for i, j in found.path}
    for collection in (grey, black):
        ends = [(round(line[0][0], 9), round(line[1][0], 9)) for line in collection.get_segments()]
        assert set(ends) <= expected
        assert ends == sorted(ends)
    assert len(black.get_segments()) == 5
    assert len(grey.get_segments()) == len(found.path)  # few enough for all
    assert all(line[0][1] > line[1][1] for line in grey.get_segments())


def test_the_time_of_the_second_motion():
    a, b = two_motions()
    display = AlignmentDisplay.from_motions(a, b)
    ticks = {label.get_text(): label.get_position()[0] for label in display.strips_ax_.get_xticklabels()}
    assert ticks.keys() == {"0", "0.5", "1", "1.5", "2", "2.5"}
    for text, position in ticks.items():  # 2.9 s of b are as wide as 1.9 s of a
        np.testing.assert_allclose(position, float(text) * 1.9 / 2.9, atol=1e-12)
    inside = AlignmentDisplay.from_motions(b[10:20], b, alignment="subsequence")
    ticks = [float(label.get_text()) for label in inside.strips_ax_.get_xticklabels()]
    assert (ticks[0], ticks[-1]) == (1.0, 1.8)  # of 1.0 to 1.9 s
    np.testing.assert_allclose(inside.strips_ax_.get_xticks(), np.array(ticks) - 1.0, atol=1e-12)


def test_frames_where_there_is_no_frame_rate():
    a, b = (motion.angles for motion in two_motions())
    display = AlignmentDisplay.from_motions(a, b, skeleton=SKELETONS["humanoid"], metric="position", window=0.5)
    assert [ax.get_xlabel() for ax in (display.map_ax_, display.strips_ax_)] == ["frame of a", "frame of b"]
    assert display.map_ax_.get_xlim() == (-0.5, 19.5)
    assert (
        display.alignment.distance
        == align_motions(a, b, skeleton=SKELETONS["humanoid"], metric="position", window=0.5).distance
    )


@pytest.mark.parametrize("lengths", [(1, 1), (1, 7), (7, 1), (2, 3)])
def test_short_motions_can_be_drawn(lengths):
    a, b = two_motions("mixed joints", *lengths)
    display = AlignmentDisplay.from_motions(a, b)
    display.figure_.canvas.draw()
    assert np.isfinite([*display.map_ax_.get_xlim(), *display.strips_ax_.get_xlim()]).all()
    still = AlignmentDisplay.from_motions(np.zeros((3, 2)), np.zeros((3, 2)), skeleton=ARM, projection="zx")
    still.figure_.canvas.draw()  # seen along its bones, the arm is a point


@pytest.mark.parametrize("place", ["own figure", "one of four", "without a layout"])
def test_names_of_joints_do_not_overlap_and_all_is_inside_the_figure(place):
    ax = None
    if place != "own figure":
        layout = "constrained" if place == "one of four" else None
        _, all_axes = plt.subplots(2, 2, figsize=(16, 14), layout=layout)
        ax = all_axes[1, 0]
    display = AlignmentDisplay.from_motions(*two_motions(), ax=ax)
    display.figure_.canvas.draw()
    boxes = [label.get_window_extent() for label in display.map_ax_.get_yticklabels()]
    assert all(upper.y0 >= lower.y1 for upper, lower in pairwise(boxes))
    assert min(label.get_fontsize() for label in display.map_ax_.get_yticklabels()) > 5
    whole = display.ax_.get_tightbbox(display.figure_.canvas.get_renderer())
    assert whole.x0 >= 0
    assert whole.y0 >= 0
    assert display.map_ax_.get_window_extent().y0 > display.strips_ax_.get_window_extent().y1
    assert display.map_ax_.get_tightbbox().y0 > display.strips_ax_.get_window_extent().y1
    if place != "without a layout":
        assert whole.x1 <= display.figure_.bbox.x1
        assert whole.y1 <= display.figure_.bbox.y1


def test_names_have_the_colours_of_the_sides_and_the_map_a_style():
    display = AlignmentDisplay.from_motions(*two_motions(), cmap="magma", vmax=50)
    colours = {label.get_text(): label.get_color() for label in display.map_ax_.get_yticklabels()}
    assert (colours["head"], colours["left_hand"], colours["right_toes"]) == ("black", SIDES["left"], SIDES["right"])
    (image,) = display.map_ax_.images
    assert (image.get_cmap().name, image.get_clim()) == ("magma", (0.0, 50.0))


WITHOUT = align_motions(np.zeros((3, 2)), np.ones((4, 2)), metric="angle")
SWING = align_motions(np.zeros((3, 2)), np.ones((4, 2)), skeleton=ARM)


@pytest.mark.parametrize(
    ("draw", "error", "message"),
    [
        (
            lambda: AlignmentDisplay.from_alignment(np.zeros((3, 2))),
            TypeError,
            r"^alignment must be a skpose\.motions\.Alignment",
        ),
        (lambda: AlignmentDisplay.from_alignment(WITHOUT), ValueError, "no skeleton and so no joints: pass skeleton="),
        (lambda: AlignmentDisplay.from_alignment(SWING, quantity="angle"), ValueError, "quantity must be"),
        (lambda: AlignmentDisplay.from_alignment(SWING, n_poses=0), ValueError, "n_poses must be a whole number"),
        (
            lambda: AlignmentDisplay.from_alignment(SWING, projection="xx"),
            ValueError,
            "projection must be two of the axes",
        ),
        (
            lambda: AlignmentDisplay.from_motions(ARM, SWING.b),
            TypeError,
            "^a must be one motion, .* got a Skeleton: pass it as skeleton=",
        ),
    ],
)
def test_errors_say_what_was_expected(draw, error, message):
    with pytest.raises(error, match=message):
        draw()
    assert not plt.get_fignums()  # no empty figure is left


def test_equal_motions_have_no_negative_distances():
    motion = make_gait(1, 1, activities=["walk"], duration=1, frame_rate=12, random_state=0)[0]
    display = AlignmentDisplay.from_motions(motion, motion)
    (image,) = display.map_ax_.get_images()
    assert image.get_clim() == (0.0, 1.0)
