"""The directive ``player``: a player of a generated motion, or its own contents where there is none."""

from docutils import nodes
from sphinx.util.docutils import SphinxDirective


def html_of(name):
    """Return the HTML that shows the motion of a name; empty as long as the library has no player."""
    return ""


class Player(SphinxDirective):
    """Show the motion of a name in a player; the contents, such as a picture, stand in its place."""

    has_content = True
    required_arguments = 1

    def run(self):
        html = html_of(self.arguments[0])
        if html:
            return [nodes.raw("", html, format="html")]
        box = nodes.container(classes=["player"])
        self.state.nested_parse(self.content, self.content_offset, box)
        return [box]


def setup(app):
    app.add_directive("player", Player)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
