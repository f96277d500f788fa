import numpy as np
import pytest
from conftest import SKELETONS

from skpose import Motion, Skeleton, forward_kinematics
from skpose.motions import align_motions
from skpose.plot import AlignmentDisplay

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
def test_the_map_has_the_largest_difference_of_each_frame(quantity, factor):
    found = align_motions(*two_motions())
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
    assert [label.rpartition("(")[2].rstrip(")") for label in labels] == [found.skeleton.joint_names[j] for j in shown]
    assert {"distance": "left ankle (left_shank)", "rotation": "left knee (left_shank)"}[quantity] in labels
    assert "abdomen" in labels  # it begins at the root, which is not a joint of the hips
    np.testing.assert_array_equal(display.map_ax_.get_yticks(), np.arange(len(shown)))
    assert image.get_clim()[0] == 0.0


def figures(display):
    """The points of each figure in the display's pixels, as they are drawn: a list of (n, 2)."""
    found = []
    for ax in display.strips_ax_.child_axes:
        points = np.concatenate([np.stack(line.get_data(), axis=1) for line in ax.lines])
        found.append(ax.transData.transform(points[~np.isnan(points[:, 0])]))
    return found


def test_poses_keep_their_shape_and_stand_at_their_times():
    projection = "zy"
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


def test_the_time_of_the_second_motion():
    a, b = two_motions()
    display = AlignmentDisplay.from_alignment(align_motions(a, b))
    ticks = {label.get_text(): label.get_position()[0] for label in display.strips_ax_.get_xticklabels()}
    assert ticks.keys() == {"0", "0.5", "1", "1.5", "2", "2.5"}
    for text, position in ticks.items():  # 2.9 s of b are as wide as 1.9 s of a
        np.testing.assert_allclose(position, float(text) * 1.9 / 2.9, atol=1e-12)
    inside = AlignmentDisplay.from_alignment(align_motions(b[10:20], b, alignment="subsequence"))
    ticks = [float(label.get_text()) for label in inside.strips_ax_.get_xticklabels()]
    assert (ticks[0], ticks[-1]) == (1.0, 1.8)  # of 1.0 to 1.9 s
    np.testing.assert_allclose(inside.strips_ax_.get_xticks(), np.array(ticks) - 1.0, atol=1e-12)


@pytest.mark.parametrize("lengths", [(1, 1), (7, 1)])
def test_short_motions_can_be_drawn(lengths):
    a, b = two_motions("mixed joints", *lengths)
    display = AlignmentDisplay.from_alignment(align_motions(a, b))
    display.figure_.canvas.draw()
    assert np.isfinite([*display.map_ax_.get_xlim(), *display.strips_ax_.get_xlim()]).all()
    at_rest = align_motions(np.zeros((3, 2)), np.zeros((3, 2)), skeleton=ARM)
    still = AlignmentDisplay.from_alignment(at_rest, projection="zx")
    still.figure_.canvas.draw()  # seen along its bones, the arm is a point
