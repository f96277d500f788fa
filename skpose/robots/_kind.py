"""Kinds of files of robots, by their first element."""

import os
import re
from pathlib import Path
from typing import Literal

from skpose.io._arguments import Readable

# Blanks, declarations and comments before the first element, none of which is tried twice, and its name.
FIRST_ELEMENT = re.compile(
    r"(?:\s|(?><\?.*?\?>)|(?><!--.*?-->)|(?><!DOCTYPE[^>\[]*(?:\[.*?\])?[^>]*>))*+<([\w:.-]+)", re.DOTALL
)
HEAD = 1 << 18  # bytes, at most, that say what a file is
KINDS: dict[str, Literal["MJCF", "URDF"]] = {"mujoco": "MJCF", "robot": "URDF"}


def first_element(text: str) -> str:
    """Return the name of the first element of a text in XML, nothing where there is none."""
    found = FIRST_ELEMENT.match(text.removeprefix("\ufeff"))
    return found[1] if found else ""


def robot_kind(head: str) -> Literal["MJCF", "URDF"] | None:
    """Return which kind of robot the beginning of a text is, None if it is none."""
    return KINDS.get(first_element(head))


def is_robot(path: Readable) -> bool:
    """Return whether a file, or an open file of bytes, is a robot, by its beginning."""
    if not isinstance(path, str | os.PathLike):
        return robot_kind(path.read(HEAD).decode("utf-8", errors="replace")) is not None
    with Path(path).open("rb") as file:
        return robot_kind(file.read(HEAD).decode("utf-8", errors="replace")) is not None
