"""The page of `skpose check`: each finding is played at its frame."""

from dataclasses import replace

import numpy as np
import pytest

from skpose.checks import check_motion
from skpose.checks._report import report
from skpose.datasets import make_actions


@pytest.mark.slow
def test_a_click_plays_a_finding_at_its_frame(browser):
    kick = make_actions(1, 1, actions=["kick"], random_state=0)[0]
    jumps = np.isin(np.arange(len(kick)), (80, 100)).cumsum()[:, None] * [0.0, 0.0, 0.3]
    motions = [kick, replace(kick, root_positions=kick.root_positions + jumps)]
    findings = [one for one in check_motion(motions[1]) if one.kind == "jump"]
    page = report([one._replace(motion=1) for one in findings], ["<b>kick</b>", "jumps & jumps"], motions.__getitem__)
    shown = browser.show(page)
    assert shown.text("nav li span:nth-child(2)") == "jumps & jumps"
    assert shown.js("document.querySelector('[aria-current]').id") == "finding-0"
    shown.click("#finding-1")
    shown.wait_for(
        "document.querySelector('[aria-current]')?.id === 'finding-1' && Boolean(window.skpose?.state.drawn)"
    )
    first = findings[1].frames[0]
    start = max(0, first - 60)  # a second before, at 60 Hz
    assert shown.js("skpose.tick()") == first - start
    assert shown.problems() == []
