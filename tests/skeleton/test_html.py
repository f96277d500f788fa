"""Skeletons and datasets show themselves in a notebook as a table; a motion by functions that `skpose` fills in."""

import re
import subprocess
import sys
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from skpose import Bone, Motion, Skeleton
from skpose.datasets import MotionDataset, humanoid, make_gait
from skpose.skeleton._html import MOST_ROWS

ARM = Skeleton(
    [
        Bone('<b>&"elbow', None, (0.3, 0, 0), "xyz", limits=((-1, 1), (0, 2), (0, 0.5)), weight=2),
        Bone("wrist", '<b>&"elbow', (0.25, 0, 0)),
    ]
)


def cells_of(text):
    """The summary, the headings and the rows of a table; text that is not well-formed is refused."""
    root = ET.fromstring(text)
    headings, *rows = [[cell.text or "" for cell in row] for row in root.iter("tr")]
    return root.find("summary/code").text, headings, rows


def test_a_skeleton_is_a_table_of_its_bones():
    summary, headings, rows = cells_of(ARM._repr_html_())
    assert summary == repr(ARM)
    assert headings == ["joint", "parent", "dofs", "length, m", "limits", "weight"]
    assert rows == [
        ['<b>&"elbow', "the root", "xyz", "0.3", "-57 to 57°, 0 to 115°, 0 to 29°", "2"],
        ["wrist", '<b>&"elbow', "rigid", "0.25", "", "1"],
    ]


def test_limits_and_weights_are_shown_where_there_are_any():
    _, headings, rows = cells_of(Skeleton.chain(3)._repr_html_())
    assert headings == ["joint", "parent", "dofs", "length, m"]
    assert len(rows) == 3


def test_a_dataset_is_a_table_of_its_motions():
    gait = make_gait(n_subjects=2, n_sequences=1, random_state=0)
    summary, headings, rows = cells_of(gait._repr_html_())
    assert summary == repr(gait)
    assert headings == ["motion", "subject", "trial", "action", "frames", "frame rate, Hz", "duration, s", "joints"]
    assert [row[3] for row in rows] == gait.actions.tolist()
    assert [int(row[4]) for row in rows] == [len(motion) for motion in gait]
    _, headings, rows = cells_of(gait.retarget(gait[0].skeleton, method="orientations")._repr_html_())
    assert headings[-1] == "retargeted by"
    assert rows[1][-1].startswith("orientations")


def test_a_dataset_has_the_labels_that_it_has_and_they_are_escaped():
    motion = Motion(Skeleton.chain(2), np.zeros((3, 2)), 10)
    _, headings, rows = cells_of(MotionDataset([motion], actions=["<script>alert(1)</script>"])._repr_html_())
    assert headings[:2] == ["motion", "action"]
    assert rows[0][1] == "<script>alert(1)</script>"
    assert MotionDataset([])._repr_html_() == "<p><code>MotionDataset(0 motions)</code></p>"


def test_a_long_table_says_how_many_rows_it_leaves_out():
    motion = Motion(Skeleton.chain(2), np.zeros((3, 2)), 10)
    text = MotionDataset([motion] * (MOST_ROWS + 7))._repr_html_()
    assert len(cells_of(text)[2]) == MOST_ROWS
    assert "… and 7 more" in text


@pytest.mark.parametrize("shown", [ARM, humanoid(), make_gait(2, 1, random_state=0)], ids=repr)
def test_a_table_is_small_and_has_no_colours_that_a_dark_notebook_hides(shown):
    text = shown._repr_html_()
    assert len(text) < 8_000
    assert set(re.findall(r'style="([^"]*)"', text)) == {"text-align: left", "color: inherit; border-spacing: 1em 0"}
    assert not re.search(r"<(script|link|img|style)|class=|http", text)


def test_a_motion_shows_itself_where_its_package_is_all_that_is_imported():
    program = (
        "import sys; from skpose.skeleton import Motion, Skeleton; assert 'skpose.view' not in sys.modules; "
        "motion = Motion(Skeleton.chain(2), [[0, 0], [1, 1]], 30); print(motion.play().title, motion._repr_html_()[:4])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "motion <svg\n"
