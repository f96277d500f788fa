"""Figures in one picture, in Chromium: a near one is before a far one, and an edge is between them."""

from dataclasses import replace

import numpy as np
import pytest
from player_page import projected, state_of

from skpose import Bone, Motion, Skeleton
from skpose.view import player

pytestmark = pytest.mark.slow
COLOURS = np.array([(0, 114, 178), (192, 79, 0)])  # of the two figures


@pytest.mark.parametrize("near", [0, 1])
def test_the_near_figure_is_in_front_with_an_edge_around_it(browser, near):
    """Two bars that cross at their joints: the near one is seen, paper on both sides of it, then the far one."""
    halves = (0.0, 0.5, 0.0), (0.5, 0.5, 0.0)
    bars = [Skeleton([Bone("bar", None, half, "z"), Bone("end", "bar", half, "z")]) for half in halves]
    motions = [Motion(bar, [[0.0, 0.0]], 30) for bar in bars]
    starts = [(0.5, 0.0, 0.0), (0.0, 0.0, 0.0)]  # the second one crosses the first
    places = [np.add(start, (0.0, 0.0, 0.3 if i == near else -0.3)) for i, start in enumerate(starts)]
    motions = [replace(motion, root_positions=[place]) for motion, place in zip(motions, places, strict=True)]
    browser.open(player(motions, overlay=True))
    browser.choose("#place", "world")
    for control in ("#ground", "#axes"):
        browser.click(control)
    browser.driver.execute_script("skpose.stage.camera.azimuth = 0; skpose.stage.camera.elevation = 0.001")
    browser.press("ARROW_UP", css="canvas")
    state, picture = state_of(browser), browser.picture()
    ends = [projected(state, points) for points in state["views"][0]["points"]]
    (a, _, b), (c, _, d) = ends
    share = np.linalg.solve(np.stack([b - a, c - d], axis=1), c - a)
    crossing = a + share[0] * (b - a)
    assert (share > 0.1).all()
    assert (share < 0.9).all()
    far = ends[1 - near]
    along = (far[2] - far[0]) / np.linalg.norm(far[2] - far[0])
    line = [picture[tuple(np.rint(crossing + step * along).astype(int)[::-1])] for step in np.arange(-60, 60, 0.5)]
    nearest = [int(np.argmin([np.abs(p - q).sum() for q in (*COLOURS, (255, 255, 255))])) for p in line]
    runs = [nearest[i] for i in range(len(nearest)) if i == 0 or nearest[i] != nearest[i - 1]]
    middle = runs.index(near)
    assert runs[middle - 2 : middle + 3] == [1 - near, 2, near, 2, 1 - near]
