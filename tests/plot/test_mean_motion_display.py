import re
from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
import pytest

from skpose.datasets import make_gait
from skpose.motions import mean_motion
from skpose.plot import MeanMotionDisplay
from skpose.plot._axes import SIDES

pytestmark = pytest.mark.usefixtures("agg")


@pytest.fixture(scope="module")
def mean():
    return mean_motion(make_gait(2, 1, activities=["walk"], duration=1, frame_rate=20, random_state=0))


def test_the_map_is_the_standard_deviation_of_each_joint_in_time(mean):
    display = MeanMotionDisplay.from_mean(mean, vmax=9.0)
    (image,) = display.ax_.get_images()
    np.testing.assert_array_equal(image.get_array(), 100 * mean.joint_std.T)
    assert image.get_clim() == (0.0, 9.0)
    names = mean.skeleton.joint_names
    assert [label.get_text() for label in display.ax_.get_yticklabels()] == list(names)
    assert display.ax_.get_yticks().tolist() == list(range(len(names)))
    left, right, bottom, top = image.get_extent()
    assert (left, right) == (-0.5 / 20, (len(mean) - 0.5) / 20)
    assert (bottom, top) == (len(names) - 0.5, -0.5)  # the first joint is at the top
    assert display.ax_.get_xlabel() == "time of the mean (s)"


def test_names_are_readable_and_have_the_colours_of_their_sides(mean):
    display = MeanMotionDisplay.from_mean(mean)
    display.figure_.canvas.draw()
    labels = display.ax_.get_yticklabels()
    boxes = [label.get_window_extent() for label in labels]
    assert not any(a.overlaps(b) for a, b in pairwise(boxes))
    assert all(box.x0 >= 0 for box in boxes)
    colours = {label.get_text(): label.get_color() for label in labels}
    assert (colours["left_hand"], colours["right_hand"], colours["head"]) == (SIDES["left"], SIDES["right"], "black")


def test_without_a_frame_rate_frames_into_given_axes(mean):
    arrays = mean_motion([mean.poses, mean.poses + 0.1], skeleton=mean.skeleton)
    _, ax = plt.subplots()
    display = MeanMotionDisplay.from_mean(arrays, ax=ax)
    assert display.ax_ is ax
    assert ax.get_xlabel() == "frame of the mean"
    assert ax.get_xlim() == (-0.5, len(mean) - 0.5)


def test_refuses_what_is_no_mean(mean):
    with pytest.raises(TypeError, match=re.escape("mean must be a skpose.motions.MeanMotion, got Motion")):
        MeanMotionDisplay.from_mean(mean.to_motion())
