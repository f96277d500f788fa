"""Labels of `MDSDisplay`: groups in the legend, or a colour bar."""

import numpy as np
import pandas as pd
import pytest

from skpose.plot import MDSDisplay
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


@pytest.mark.parametrize("make", [MDSDisplay.from_embedding, MDSDisplay])
@pytest.mark.parametrize(
    "labels",
    [
        ["a", None, None],
        [0.5, np.nan, np.nan],
        ["a", None, float("nan")],
        ["a", float("nan"), float("nan")],
        ("a", np.nan, np.ma.masked),
        [1, np.ma.masked, np.ma.masked],
        ["a", pd.NA, pd.NaT],
        np.array(["a", pd.NA, np.nan], object),
        np.array(["2020-01-01", "NaT", "NaT"], "datetime64[ns]"),
        pd.Series([1, None, None], dtype="Int64"),
        pd.Series(["a", None, None], dtype="string"),
        pd.Series(["a", None, None], dtype="category"),
        pd.Categorical(["a", None, None], ordered=True),
        pd.Series([pd.Timestamp(0), pd.NaT, pd.NaT]),
        np.ma.array([1, 2, 3], mask=[False, True, True]),
        np.ma.array(["a", "b", "c"], mask=[False, True, True]),
    ],
    ids=repr,
)
def test_labels_that_are_missing(labels, make):
    with pytest.raises(ValueError, match=r'labels .* got 2 of 3 that are missing, such as None or NaN: .* "unknown"'):
        make(POINTS[:3], labels)


def test_labels_that_matplotlib_hides():
    assert entries(MDSDisplay.from_embedding(POINTS, ["", "_a", "b"] * 20)) == {'""': 20, '"_a"': 20, "b": 20}


@pytest.mark.parametrize("style", [{"c": "red"}, {"color": "red"}, {"facecolor": "red"}])
def test_a_colour_that_is_given(style):
    """There is no colour bar then, and groups differ by their markers."""
    display = MDSDisplay.from_embedding(POINTS, SPEEDS, **style)
    assert len(display.figure_.axes) == 1
    groups = MDSDisplay.from_embedding(POINTS, ["a", "b"] * 30, **style)
    assert entries(groups) == {"a": 30, "b": 30}
    alone = MDSDisplay.from_embedding(POINTS, **style)
    for shown in (display, groups, alone):
        for drawn in shown.ax_.collections:
            np.testing.assert_array_equal(drawn.get_facecolor()[:, :3], [[1, 0, 0]])


def test_a_colour_bar_of_other_numbers():
    (drawn,) = MDSDisplay.from_embedding(POINTS, SPEEDS, c=-SPEEDS).ax_.collections
    assert drawn.colorbar.vmin == -3.0


def test_floats_that_are_kept_as_objects():
    display = MDSDisplay.from_embedding(POINTS, SPEEDS.astype(object))
    np.testing.assert_array_equal(display.ax_.collections[0].get_array(), SPEEDS)
    assert len(display.figure_.axes) == 2


def test_an_ordered_categorical_has_its_order():
    sizes = pd.CategoricalDtype(["small", "medium", "large", "huge"], ordered=True)
    given = ["large", "small", "small", "medium", "large", "large"] * 10
    expected = {"small": 20, "medium": 10, "large": 30}
    for labels in (pd.Series(given, dtype=sizes), pd.Categorical(given, dtype=sizes)):
        display = MDSDisplay.from_embedding(POINTS, labels)
        assert list(entries(display).items()) == list(expected.items())
        np.testing.assert_array_equal(display.labels, given)
    labels = pd.Series(given, dtype="category")  # without an order
    assert list(entries(MDSDisplay.from_embedding(POINTS, labels))) == ["large", "medium", "small"]


@pytest.mark.parametrize("labels", [np.array([1, "a"] * 30, object), [1, "a"] * 30, np.array([(1,), "a"] * 30, object)])
def test_labels_that_cannot_be_compared_are_sorted_as_texts(labels):
    assert set(entries(MDSDisplay.from_embedding(POINTS, labels)).values()) == {30}


def test_the_class_takes_what_from_embedding_takes():
    direct = MDSDisplay(POINTS.tolist(), ["b", "a", "a"] * 20, [0.5, 0.25]).plot()
    assert entries(direct) == {"a": 40, "b": 20}
    assert direct.ax_.get_ylabel() == "component 2 (m), 25% of the variance"
    with pytest.raises(ValueError, match="labels must be one for each of the 60 poses"):
        MDSDisplay(POINTS, ["a"])
    with pytest.raises(ValueError, match="at least two components"):
        MDSDisplay(POINTS[:, :1])
