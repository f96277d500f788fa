"""Kinds of files of robots, by their first element."""

import re
from typing import Literal

# Blanks, declarations and comments before the first element, none of which is tried in another way, and its name.
FIRST_ELEMENT = re.compile(
    r"(?:\s|(?><\?.*?\?>)|(?><!--.*?-->)|(?><!DOCTYPE[^>\[]*(?:\[.*?\])?[^>]*>))*+<([\w:.-]+)", re.DOTALL
)
KINDS: dict[str, Literal["MJCF", "URDF"]] = {"mujoco": "MJCF", "robot": "URDF"}


def first_element(text: str) -> str:
    """Return the name of the first element of a text in XML, nothing where there is none."""
    found = FIRST_ELEMENT.match(text.removeprefix("\ufeff"))
    return found[1] if found else ""


def robot_kind(head: str) -> Literal["MJCF", "URDF"] | None:
    """Return which kind of robot the beginning of a text is, None if it is none."""
    return KINDS.get(first_element(head))
