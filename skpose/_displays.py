"""Ways to show a motion, which `skpose` fills in: a motion shows itself by pages that stand far below it in the flow
of data.
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
    """Functions that a motion calls to show itself."""

    player: Callable[[Any], Page]  # the page that plays a motion
    strip: Callable[[Any], str]  # some of its poses as a picture, in HTML


displays = Displays()
