import numpy as np
import pytest

from skpose.datasets import make_gait
from skpose.motions import mean_motion
from skpose.plot import MeanMotionDisplay

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
    labels = [label.get_text() for label in display.ax_.get_yticklabels()]
    assert [label.rpartition("(")[2].rstrip(")") for label in labels] == list(names)
    assert labels[names.index("left_shank")] == "left ankle (left_shank)"
    assert display.ax_.get_yticks().tolist() == list(range(len(names)))
    left, right, bottom, top = image.get_extent()
    assert (left, right) == (-0.5 / 20, (len(mean) - 0.5) / 20)
    assert (bottom, top) == (len(names) - 0.5, -0.5)  # the first joint is at the top
    assert display.ax_.get_xlabel() == "time of the mean (s)"
