"""Xsens MVNX files: the origins of body segments, in m, z up, as XML.

"MVN User Manual", Movella, section MVNX, https://www.movella.com/hubfs/MVN_User_Manual.pdf.
"""

import io
from xml.etree import ElementTree

import numpy as np

from skpose.io._source import Source, parse
from skpose.io._stored import Stored

# Frames of another type are poses of the calibration.
USUAL = "normal"


def is_mvnx(source: Source) -> bool:
    return source.kind == "text" and "<mvnx" in source.head[:2000].lower()


def read_mvnx(source: Source) -> Stored:
    names, rate, rows = list[str](), "", list[np.ndarray]()
    try:
        for _, element in ElementTree.iterparse(io.BytesIO(source.data)):
            kind = element.tag.rpartition("}")[2]
            if kind == "segment":
                names.append(element.get("label", ""))
            elif kind == "subject":
                rate = element.get("frameRate", "")
            elif kind == "frame":
                if element.get("type", USUAL) == USUAL:
                    texts = [child.text or "" for child in element if child.tag.rpartition("}")[2] == "position"]
                    numbers = parse(" ".join(texts).encode())
                    rows.append(np.empty(0) if numbers is None else numbers)
                element.clear()  # for memory
    except (ElementTree.ParseError, LookupError, ValueError) as error:  # damage, or an unknown encoding
        raise source.error(f"XML is damaged or cut short: {error}") from None
    if not rows or not names or any(len(row) != 3 * len(names) for row in rows):
        raise source.error("expected segments, and <position> of all of them in each frame: export MVNX with positions")
    positions = np.reshape(rows, (len(rows), len(names), 3))
    return Stored(positions, None, names, source.number(rate, "frameRate"), "z", why="as in MVN")
