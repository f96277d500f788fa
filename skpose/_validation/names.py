"""Words about names, of joints or others, that nobody has."""

from collections.abc import Sequence
from difflib import get_close_matches


def near_names(names: Sequence[str], name: str, otherwise: str = "skeleton.joint_names are its joints") -> str:
    """Return in words which names are near to an unknown one; upper and lower case are near. `otherwise`: none is."""
    lower = {one.lower(): one for one in names}
    near = [repr(lower[found]) for found in get_close_matches(name.lower(), lower)]
    return f"did you mean {' or '.join(near)}?" if near else otherwise
