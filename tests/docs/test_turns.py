"""The page on which a shoulder and a wrist turn: its numbers are those of the library."""

import numpy as np
import pytest
from pages_to_try import open_page, open_window, turns

from skpose import pose_distances
from skpose.datasets import humanoid

SHOWN = "[...document.querySelectorAll('figcaption output')].map((e) => e.textContent)"


@pytest.fixture(scope="module")
def window():
    yield from open_window()


@pytest.fixture
def turned(window, tmp_path):
    open_page(window, turns.page(), tmp_path)
    window.wait_for("window.shown && !window.shown().rising")
    return window


def expected_texts(degrees):
    skeleton = humanoid()
    X = np.zeros((3, skeleton.n_dofs))
    for row, column in enumerate(turns.TURNS.values(), start=1):
        X[row, skeleton.dof_names.index(column)] = np.radians(degrees)
    found = [pose_distances(X[:1], X[1:], skeleton=skeleton, metric=metric)[0] for metric in ("angle", "spatial")]
    return [text for angle, spatial in np.transpose(found) for text in (f"{angle:.2f} rad", f"{spatial:.2f} m")]


def test_numbers_are_those_of_the_library(turned):
    assert turned.run(SHOWN) == expected_texts(60)
    assert turned.errors() == []


def test_the_slider_turns_both(turned):
    turned.run("Object.assign(document.getElementById('turn'), {value: 25}).dispatchEvent(new Event('input'))")
    assert turned.run(SHOWN) == expected_texts(25)


@pytest.mark.parametrize("figure", ["shoulder", "wrist"])
def test_a_drag_of_the_hand_turns_both(turned, figure):
    """From where the hand is to straight below the joint that turns."""
    before = turned.run(SHOWN)
    x, y = turned.run(
        f"(() => {{ const {{left, top}} = document.querySelector('#{figure} canvas').getBoundingClientRect();"
        f" const hand = shown().hands['{figure}']; return [left + hand.x, top + hand.y]; }})()"
    )
    for kind, dx in (("mousePressed", 0), ("mouseMoved", -3), ("mouseMoved", -6), ("mouseReleased", -6)):
        turned.call("Input.dispatchMouseEvent", type=kind, x=x + dx, y=y + 3, button="left", buttons=1, clickCount=1)
    after = turned.run(SHOWN)
    assert after != before
    assert after[0] == after[2]  # one angle
    assert float(after[0].split()[0]) < float(before[0].split()[0])


def test_all_of_the_turns_is_in_a_small_frame(window, tmp_path):
    open_page(window, turns.page(), tmp_path)
    window.open((tmp_path / "page.html").as_uri(), width=547, height=328, still=True)
    window.wait_for("window.shown && shown().hands.shoulder")
    bottom = "document.getElementById('claim').getBoundingClientRect().bottom"
    assert window.run(f"[{bottom} <= 328, document.documentElement.scrollHeight <= 328]") == [True, True]
