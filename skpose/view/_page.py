"""A page: one self-contained HTML file.

A page loads nothing from the network, and its Content-Security-Policy forbids it: only scripts and styles with the
digests in the page run. The scripts are compressed, and a short one unpacks them. Data, including names from files, are
JSON in an inert element, and the scripts show them as text.
"""

import base64
import hashlib
import html
import json
import tempfile
import webbrowser
import zlib
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

from skpose._utils.files import PathLike, new_file

Asset = str | Path

HEIGHT = 600  # of a page in a notebook, px
# Characters by which text could end the element that holds it. json.dumps escapes all that is not ASCII.
ESCAPED = {ord(character): f"\\u{ord(character):04x}" for character in "<>&"}

DOCUMENT = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; script-src '{starter_digest}' \
'{script_digest}'; style-src '{style_digest}'; base-uri 'none'; form-action 'none'">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="skpose">
<title>{title}</title>
<style>{style}</style>
</head>
<body>
{body}
<script type="application/json" id="data">{data}</script>
<script data-program="{program}">{starter}</script>
</body>
</html>
"""


class Page:
    """One HTML file that needs neither the network nor any other file.

    `skpose.view.player` makes one. In a notebook a page shows itself.

    Parameters
    ----------
    html : str
        The whole file.
    title : str
        Its title.
    note : str
        A short summary of its content.

    Examples
    --------
    >>> from skpose.datasets import make_gait
    >>> from skpose.view import player
    >>> page = player(make_gait(1, 1, random_state=0).motions[0], labels=["a walk"])
    >>> page.title, page.note
    ('a walk', '1 motion, positions within 0.027 mm')
    >>> page.html.startswith("<!DOCTYPE html>")
    True
    """

    def __init__(self, html: str, title: str, note: str):
        self.html, self.title, self.note = html, title, note

    @property
    def n_bytes(self) -> int:
        """The size of the file, bytes."""
        return len(self.html.encode("utf-8"))

    def save(self, path: PathLike) -> None:
        """Write the page to a new file.

        Parameters
        ----------
        path : str or path
            The file; nothing that exists is overwritten.

        Raises
        ------
        OSError
            If the file exists, or cannot be written.
        """
        with new_file(path) as new:
            new.write_bytes(self.html.encode("utf-8"))

    def open(self) -> Path:
        """Write the page to a temporary file and show it in the browser.

        Returns
        -------
        Path
            The file, which stays.
        """
        path = Path(tempfile.mkdtemp(prefix="skpose_")) / "view.html"
        self.save(path)
        webbrowser.open(path.as_uri())
        return path

    def _repr_html_(self) -> str:
        """The page as a sandboxed frame in a notebook."""
        return (
            f'<figure style="margin: 0"><iframe srcdoc="{html.escape(self.html)}" title="{html.escape(self.title)}" '
            f'sandbox="allow-scripts allow-downloads" style="width: 100%; height: {HEIGHT}px; border: 0"></iframe>'
            f"<figcaption>{html.escape(self.title)}: {html.escape(self.note)}</figcaption></figure>"
        )

    def __repr__(self) -> str:
        return f"Page({self.title!r}, {self.n_bytes / 1e3:.0f} kB, {self.note})"


def check_labels(labels: Sequence[str] | None, default: list[str]) -> list[str]:
    """The names of motions in a page."""
    if labels is None:
        return default
    if isinstance(labels, str) or len(labels) != len(default):
        raise ValueError(f"labels must be a list of {len(default)} names, got {labels!r}")
    return [str(label) for label in labels]


def page_of(
    title: str, note: str, data: dict[str, Any], body: Asset, assets: Sequence[Asset], markup: str = ""
) -> Page:
    """Make the page of some data.

    Parameters
    ----------
    title, note : str
        See `Page`.
    data : dict
        Data as JSON can hold it; the scripts find it in the element "data".
    body : str or Path
        Name of the asset that is the body's markup, or a file elsewhere.
    assets : sequence of str or Path
        Names of scripts and styles, in the order of their dependencies, and of further markup.
    markup : str, default=""
        More markup at the end of the body, with its texts escaped.
    """
    style, script = ("\n".join(map(asset, assets_of(assets, kind))) for kind in (".css", ".js"))
    starter = asset("start.js")
    return Page(
        DOCUMENT.format(
            starter_digest=_digest(starter),
            script_digest=_digest(script),
            style_digest=_digest(style),
            # A lone surrogate, of a name that was no UTF-8, has no bytes; as a reference the browser replaces it.
            title=html.escape(title).encode("ascii", "xmlcharrefreplace").decode(),
            style=style,
            body="\n".join([*map(asset, [body, *assets_of(assets, ".html")]), markup])
            .encode("ascii", "xmlcharrefreplace")
            .decode(),
            data=json.dumps(data, separators=(",", ":"), allow_nan=False).translate(ESCAPED),
            program=base64.b64encode(zlib.compress(script.encode("utf-8"), 9)).decode("ascii"),
            starter=starter,
        ),
        title,
        note,
    )


def assets_of(names: Sequence[Asset], suffix: str) -> list[Asset]:
    return [name for name in names if str(name).endswith(suffix)]


def asset(name: Asset) -> str:
    """The content of a file of the folder assets, or elsewhere."""
    file = name if isinstance(name, Path) else resources.files("skpose.view").joinpath("assets", name)
    return file.read_text(encoding="utf-8")


def _digest(content: str) -> str:
    """The digest of a script or a style in the policy."""
    return "sha256-" + base64.b64encode(hashlib.sha256(content.encode("utf-8")).digest()).decode()
