"""A page into which BVH files are dropped, to see them and their distances."""

import re
import tempfile
from pathlib import Path

from skpose.datasets import make_gait
from skpose.io import save_bvh
from skpose.kinematics import _anatomy
from skpose.kinematics._ground import LEVEL, LOW, SHORT, SLOW, WINDOW
from skpose.metrics._registry import METRICS
from skpose.skeleton import _sides
from skpose.skeleton._rest import LARGEST_DIFFERENCE
from skpose.view import _shape
from skpose.view._explorer import NUMBERS
from skpose.view._page import Page, page_of
from skpose.view._player import page as player_page
from skpose.view._scene import AXES
from skpose.view._shape import OF_LENGTH, OF_POINT, THICKEST, THINNEST

HERE = Path(__file__).parent
MARKER = "data of the motions"
ASSETS = (
    "page.css",
    HERE / "drop.css",
    "page.js",
    *NUMBERS,
    "figure.js",
    HERE / "people.js",
    HERE / "person.js",
    HERE / "bvh.js",
    HERE / "scene.js",
    HERE / "drop.js",
)


def text_of(motion):
    """Return the BVH file of a motion, in centimetres, with four digits after each point."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "motion.bvh")
        save_bvh(path, motion, scale=0.01)
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
        short = (line if line.startswith("Frame Time") else re.sub(r"(\.\d{4})\d+", r"\1", line) for line in lines)
        return "".join(short)


def policy_of(html, kind):
    """Return the digests by which a page names its scripts or styles."""
    return re.search(rf"{kind}-src ([^;]*);", html)[1]


def constants_of(module, *others):
    """Return what a module names in capitals, as JSON can hold it, without some others."""
    names = [name for name in vars(module) if name.isupper() and not name.startswith("_") and name not in others]
    return {name: constant_of(vars(module)[name]) for name in names}


def constant_of(value):
    """Return a value with its regular expressions as those of JavaScript: their source and flags."""
    if isinstance(value, tuple):
        return [constant_of(one) for one in value]
    if not isinstance(value, re.Pattern):
        return value
    source = value.pattern
    for python, ours in ((r"[^\W_]", r"[\p{L}\p{N}]"), (r"[\W_]", r"[^\p{L}\p{N}]"), (r"\d", r"\p{Nd}")):
        source = source.replace(python, ours)
    return [source, "isu" if value.flags & re.IGNORECASE else "su"]  # a point is any letter: names have no line ends


def page():
    """Return the page, with a walk and a run in it; the player that it fills is a frame in it."""
    gait = make_gait(n_subjects=1, n_sequences=1, frame_rate=30, random_state=0)
    player = player_page([], None, overlay=False, title=MARKER).html
    data = {
        "constants": {
            "axes": AXES,
            "ground": {"window": WINDOW, "slow": SLOW, "short": SHORT, "level": LEVEL, "low": LOW},
            "link": {"thickest": THICKEST, "ofLength": OF_LENGTH, "thinnest": THINNEST, "ofPoint": OF_POINT},
            "sides": constants_of(_sides, "PATTERNS"),
            "anatomy": constants_of(_anatomy, "NONE", "T"),
            "person": constants_of(_shape, "DIRECTIONS"),
            "degrees": LARGEST_DIFFERENCE,
            "units": {name: metric.unit for name, metric in METRICS.items()},
        },
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
