"""The directive ``player``: the player of a motion, by its name; nothing where there is none."""

from docutils import nodes
from sphinx.util.docutils import SphinxDirective


def html_of(name):
    """Return the HTML that plays the motion of a name; empty as long as the library has no player."""
    return ""


class Player(SphinxDirective):
    """Play a motion in the page."""

    required_arguments = 1

    def run(self):
        html = html_of(self.arguments[0])
        return [nodes.container("", nodes.raw("", html, format="html"), classes=["player"])] if html else []


def setup(app):
    app.add_directive("player", Player)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
