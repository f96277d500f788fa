"""Labels of `MDSDisplay`: groups in the legend, or a colour bar."""

import numpy as np
import pandas as pd
import pytest

from skpose.plot import DistanceMatrixDisplay, MDSDisplay
from skpose.plot._axes import PALETTE

pytestmark = pytest.mark.usefixtures("agg")


POINTS = np.random.default_rng(0).normal(size=(60, 2))


SPEEDS = np.linspace(0.5, 3.0, 60)


def entries(display):
    """Text of the legend, and the number of points of each group."""
    drawn = [len(group.get_offsets()) for group in display.ax_.collections]
    return dict(zip([text.get_text() for text in display.ax_.get_legend().get_texts()], drawn, strict=True))


def test_floats_of_many_values_have_a_colour_bar():
    speeds = np.linspace(0.5, 3.0, len(PALETTE) + 1)
    points = np.random.default_rng(0).normal(size=(len(speeds), 2))
    display = MDSDisplay.from_embedding(points, speeds)
    (drawn,) = display.ax_.collections
    np.testing.assert_array_equal(drawn.get_array(), speeds)
    assert display.ax_.get_legend() is None
    assert drawn.colorbar.vmin == speeds[0]
    for few in (speeds[:-1], np.arange(len(speeds))):  # classes
        display = MDSDisplay.from_embedding(points[: len(few)], few)
        assert len(display.ax_.get_legend().get_texts()) == len(few)
        assert len(display.figure_.axes) == 1


def test_labels_that_matplotlib_hides():
    assert entries(MDSDisplay.from_embedding(POINTS, ["", "_a", "b"] * 20)) == {'""': 20, '"_a"': 20, "b": 20}


def test_dollar_signs_are_text():
    names = [r"$\x$", "$1 and $2"]
    display = MDSDisplay.from_embedding(POINTS[:2], names)
    display.figure_.canvas.draw()  # where matplotlib would fail at the formula
    D = DistanceMatrixDisplay(np.eye(2), np.arange(2), names).plot()
    D.figure_.canvas.draw()


@pytest.mark.parametrize("labels", [["a", None, None], [0.5, np.nan, np.nan], pd.Series(["a", None, pd.NA])], ids=repr)
def test_missing_labels_are_refused(labels):
    with pytest.raises(ValueError, match="labels"):
        MDSDisplay.from_embedding(POINTS[:3], labels)


def test_numbers_and_texts_are_sorted_as_texts():
    assert entries(MDSDisplay.from_embedding(POINTS, [1, "a"] * 30)) == {"1": 30, "a": 30}
