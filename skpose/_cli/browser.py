"""Pages in the browser, as --open asks for; where there is none, in words."""

import os
import sys
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from skpose.view import Page

DISPLAYS = "DISPLAY", "WAYLAND_DISPLAY", "BROWSER"  # variables of X, of Wayland, and of who chooses a browser


def show_file(path: Path) -> None:
    """Open a page in the browser, or print why not: the page is written nevertheless."""
    if not has_display():
        _print_why_not(f"there is no display for a browser here: open {path} elsewhere")
    elif not webbrowser.open(path.absolute().as_uri()):
        _print_why_not(f"no browser was found: open {path} elsewhere")


def show_page(page: "Page") -> None:
    """Open a page that is in no file yet, if there is a display."""
    if not has_display():
        _print_why_not("there is no display for a browser here: skpose view makes a page of the file")
        return
    from skpose.view._shared import save_temporarily  # slow to import

    show_file(save_temporarily(page))


def _print_why_not(reason: str) -> None:
    print(f"skpose: --open: {reason}", file=sys.stderr)


def has_display() -> bool:
    """Return whether a browser may have a display; without one, one in the terminal would take that over."""
    if sys.platform in ("win32", "cygwin", "darwin"):
        return True
    return any(os.environ.get(name) for name in DISPLAYS)
