"""Names of `skpose.view` that the other packages of skpose use, in addition to the public ones."""

from skpose.view._page import save_temporarily
from skpose.view._points import points_scene
from skpose.view._scene import AXES, scene_of
from skpose.view._strip import strip

__all__ = [
    "AXES",
    "points_scene",
    "save_temporarily",
    "scene_of",
    "strip",
]
