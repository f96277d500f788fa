"""Ways to show motions and keypoints, which `skpose` fills in: they show themselves by pages that stand far below them
in the flow of data.
"""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol


class Page(Protocol):
    """A page for the browser, `skpose.view.Page`."""

    html: str
    title: str
    note: str

    @property
    def n_bytes(self) -> int: ...

    def save(self, path: str | os.PathLike) -> None: ...

    def open(self) -> Path: ...

    def _repr_html_(self) -> str: ...


class Displays:
    """Functions that a motion or keypoints call to show themselves."""

    player: Callable[..., Page]  # the page that plays them, with the options of `skpose.view.player`
    strip: Callable[[Any], str]  # some of its poses as a picture, in HTML


displays = Displays()
