"""What tests of the pages that visitors try share: the pages, opened in Chromium."""

import json
import re
import sys
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
sys.path[:0] = [str(DOCS), str(DOCS / "_extensions")]

import drop  # noqa: E402
import live_pages  # noqa: E402
import turns  # noqa: E402
from devtools import Window, chromium  # noqa: E402

__all__ = ["DATA", "drop", "live_pages", "open_drop_page", "open_page", "open_window", "page_data", "turns"]
DATA = Path(__file__).parents[1] / "data"


def open_window():
    """Yield a window of Chromium, for a fixture."""
    if not chromium():
        pytest.skip("there is no Chromium")
    with Window() as window:
        yield window


def open_page(window, page, folder):
    path = folder / "page.html"
    page.save(path)
    window.open(path.as_uri())
    return window


def open_drop_page(window, folder):
    """Open the page into which files are dropped."""
    page = open_page(window, drop.page(), folder)
    page.wait_for("window.drop && drop.state.values")
    return page


def page_data(page):
    return json.loads(re.search(r'id="data">(.*?)</script>', page.html, flags=re.S)[1])
