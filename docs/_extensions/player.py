"""The directive ``player``: the player of a motion, by its name."""

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

from skpose.datasets import make_gait
from skpose.view import player


def walk_and_run():
    """Return the page of a walk and a run of one generated person."""
    gait = make_gait(n_subjects=1, n_sequences=1, random_state=0)
    return player(gait, labels=list(gait.actions))


PAGES = {"walk": walk_and_run}


def html_of(name):
    """Return the HTML that plays the motions of a name."""
    return PAGES[name]()._repr_html_()


class Player(SphinxDirective):
    """Play a motion in the page."""

    required_arguments = 1

    def run(self):
        html = nodes.raw("", html_of(self.arguments[0]), format="html")
        return [nodes.container("", html, classes=["player"])]


def setup(app):
    app.add_directive("player", Player)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
