"""The directive ``drop``: a page into which BVH files are dropped, to see them and their distances."""

import re
import tempfile
from pathlib import Path

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from skpose.datasets import make_gait
from skpose.io import save_bvh
from skpose.view._page import Page, page_of
from skpose.view._player import page as player_page
from skpose.view._skeleton import NUMBERS

HERE = Path(__file__).parent
MARKER = "data of the motions"
ASSETS = (
    "page.css",
    HERE / "drop.css",
    "page.js",
    *NUMBERS[:3],
    "figure.js",
    HERE / "bvh.js",
    HERE / "scene.js",
    HERE / "drop.js",
)


def text_of(motion):
    """Return the BVH file of a motion, in centimetres, with four digits after each point."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "motion.bvh")
        save_bvh(path, motion, scale=0.01)
        return re.sub(r"(\.\d{4})\d+", r"\1", path.read_text(encoding="utf-8"))


def policy_of(html, kind):
    """Return the digests by which a page names its scripts or styles."""
    return re.search(rf"{kind}-src ([^;]*);", html)[1]


def page():
    """Return the page, with a walk and a run in it; the player that it fills is a frame in it."""
    gait = make_gait(n_subjects=1, n_sequences=1, frame_rate=30, random_state=0)
    player = player_page([], None, overlay=False, title=MARKER).html
    data = {
        "player": re.sub(r'(id="data">)[^<]*', rf'\1"{MARKER}"', player),
        "marker": f'"{MARKER}"',
        "examples": [
            {"name": f"{action}.bvh", "text": text_of(motion)}
            for motion, action in zip(gait, gait.actions, strict=True)
        ],
    }
    html = page_of("Your files", "BVH files to compare", data, HERE / "drop.html", ASSETS).html
    for kind in ("script", "style"):  # a frame has the policy of the page that it is in, and its own
        html = html.replace(f"{kind}-src ", f"{kind}-src {policy_of(player, kind)} ", 1)
    return Page(html, "Your files", "BVH files to compare")


class Drop(SphinxDirective):
    """Show the page."""

    def run(self):
        return [nodes.container("", nodes.raw("", page()._repr_html_(), format="html"), classes=["drop"])]


def setup(app):
    app.add_directive("drop", Drop)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
