"""Functions by which motions and keypoints show themselves, filled in by `skpose`: the pages are layers above them."""

from collections.abc import Callable
from typing import Any, TypeAlias

Page: TypeAlias = Any  # `skpose.view.Page`


class Displays:
    """Functions that a motion or keypoints call."""

    player: Callable[..., Page]  # `skpose.view.player`


displays = Displays()
