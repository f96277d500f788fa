"""The person of a layout at rest: the same for everyone, so that poses of several people compare.

The person stands upright, with bent knees and with the forearms held forward, as in running, so that joints are in the
middle of what they can do. An arm that hangs down at rest is half a turn away when it is raised, where rotation vectors
jump, and so is a straight shank in a squat. The thighs point down: where nothing shows how the pelvis is rotated about
the line of the hips, it is such that thighs and trunk are near to rest.
"""

import numpy as np

from skpose.keypoints._layout import Layout
from skpose.skeleton._sides import sides, without_side

# Where points stand, m: x to the left, y up, z forward. Only the directions from one to another are used.
_MIDDLE = (
    (("root", "pelvis", "hips", "hip", "midhip", "hipcenter", "spinebase"), (0.0, 0.95, 0.0)),
    (("lowerback", "spine1"), (0.0, 1.05, 0.0)),
    (("spine", "spine2", "spinemid", "upperback"), (0.0, 1.16, 0.0)),
    (("spine3", "chest", "thorax", "sternum"), (0.0, 1.3, 0.0)),
    (("spineshoulder", "shouldercenter", "lowerneck"), (0.0, 1.42, 0.0)),
    (("neck", "c7"), (0.0, 1.45, 0.0)),
    (("upperneck",), (0.0, 1.53, 0.0)),
    (("head",), (0.0, 1.65, 0.0)),
    (("nose",), (0.0, 1.58, 0.12)),
)
_LEFT = (
    (("hip", "hipjoint", "hjc"), (0.1, 0.92, 0.0)),
    (("knee", "femur", "kne", "kjc"), (0.1, 0.5, 0.0)),
    (("ankle", "tibia", "ank", "ajc"), (0.1, 0.18, -0.27)),
    (("heel",), (0.1, 0.12, -0.33)),
    (("foot",), (0.1, 0.12, -0.17)),
    (("toe", "toes", "bigtoe", "smalltoe", "footindex"), (0.1, 0.08, -0.1)),
    (("collar",), (0.08, 1.42, 0.0)),
    (("shoulder", "clavicle", "sho"), (0.18, 1.45, 0.0)),
    (("elbow", "humerus", "elb", "ejc"), (0.29, 1.23, 0.13)),
    (("radius",), (0.27, 1.13, 0.3)),
    (("wrist", "wjc"), (0.265, 1.105, 0.345)),
    (("hand", "fin"), (0.26, 1.06, 0.41)),
    (("index", "pinky"), (0.255, 1.05, 0.43)),
    (("handtip", "fingers"), (0.25, 1.02, 0.48)),
    (("thumb",), (0.22, 1.08, 0.4)),
    (("eye", "eyeinner", "eyeouter"), (0.03, 1.62, 0.1)),
    (("ear",), (0.08, 1.6, 0.01)),
    (("mouth",), (0.025, 1.54, 0.1)),
)
# A hand alone, with x to the side of the thumb and y to the fingers, which are straight.
_HAND = {"wrist": (0.0, 0.0, 0.0)} | {
    f"{finger}{joint}": (x, y, 0.0)
    for finger, x, heights in (
        ("thumb", 0.05, (0.03, 0.06, 0.09, 0.115)),
        ("indexfinger", 0.03, (0.09, 0.13, 0.155, 0.175)),
        ("middlefinger", 0.01, (0.09, 0.135, 0.16, 0.185)),
        ("ringfinger", -0.01, (0.09, 0.13, 0.155, 0.175)),
        ("pinky", -0.03, (0.08, 0.115, 0.135, 0.15)),
    )
    for joint, y in zip(
        ("cmc", "mcp", "ip", "tip") if finger == "thumb" else ("mcp", "pip", "dip", "tip"), heights, strict=True
    )
}
# Points that are in front of their parents, however the person moves.
_IN_FRONT = {"nose", "foot", "footindex", "toe", "bigtoe", "smalltoe"}
_POSITIONS = {
    "": {name: point for names, point in _MIDDLE for name in names} | _HAND,
    "left": {name: point for names, point in _LEFT for name in names},
}


def standing_directions(layout: Layout) -> dict[str, np.ndarray]:
    """The directions (3,) of bones at rest, in the axes of the root; of those alone whose points are known."""
    positions = {}
    for name, (plain, side) in _plain_names(layout).items():
        point = _POSITIONS["left" if side else ""].get(plain)
        if point is not None:
            positions[name] = np.array(point) * [-1.0 if side == "right" else 1.0, 1.0, 1.0]
    directions = {}
    for name, parent in layout.parents.items():
        if parent in positions and name in positions:
            bone = positions[name] - positions[parent]
            size = np.linalg.norm(bone)
            if size > 0.0:
                directions[name] = bone / size
    return directions


def in_front(layout: Layout) -> list[str]:
    """Points that are in front of their parents: toes and the nose."""
    return [name for name, (plain, _) in _plain_names(layout).items() if plain in _IN_FRONT]


def _plain_names(layout: Layout) -> dict[str, tuple[str, str]]:
    """The name of each point without the side, in lower case, and the side."""
    found = zip(layout.points, sides(layout.points), strict=True)
    words = {name: (without_side(name) if side else name, side) for name, side in found}
    plain = {name: "".join(filter(str.isalnum, word)).lower() for name, (word, _) in words.items()}
    return {name: (plain[name].removesuffix("study"), side) for name, (_, side) in words.items()}  # OpenCap's names
