"""Suggestions for misspelt names."""

from collections.abc import Sequence
from difflib import get_close_matches


def near_names(names: Sequence[str], name: str, otherwise: str = "skeleton.joint_names lists the joints") -> str:
    """A question with the names similar to an unknown one; `otherwise` if there are none."""
    lower = {one.lower(): one for one in names}
    near = [repr(lower[found]) for found in get_close_matches(name.lower(), lower)]
    return f"did you mean {' or '.join(near)}?" if near else otherwise
