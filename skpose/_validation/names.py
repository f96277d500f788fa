"""Words about names of joints that nobody has."""

from collections.abc import Sequence
from difflib import get_close_matches


def near_names(joint_names: Sequence[str], name: str) -> str:
    """Return in words which names are near to an unknown one; upper and lower case are near."""
    lower = {joint.lower(): joint for joint in joint_names}
    near = [repr(lower[found]) for found in get_close_matches(name.lower(), lower)]
    return f"did you mean {' or '.join(near)}?" if near else "skeleton.joint_names are its joints"
