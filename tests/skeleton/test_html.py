"""Tables of skeletons in notebooks."""

import xml.etree.ElementTree as ET

from skpose import Bone, Skeleton

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
