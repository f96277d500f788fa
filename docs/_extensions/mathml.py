r"""Formulas as MathML, which browsers draw by themselves: no JavaScript and nothing from the network.

docutils converts them, which Sphinx needs anyway. Its converter reads ``\frac12`` as twelve over what follows, so that
fractions without braces are refused.
"""

import re

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util import logging

logger = logging.getLogger(__name__)


def markup(node, as_block):
    """Return the MathML of a formula, in one line; warn of what cannot be converted."""
    tex = node.astext()
    try:
        if re.search(r"frac\s*[^{\s]", tex):
            raise MathError("a fraction without braces")
        return re.sub(r"\n\s*", "", tex2mathml(tex, as_block=as_block))
    except MathError as error:
        logger.warning("no MathML for %r: %s", tex, error, location=node)
        return ""


def visit_math(self, node):
    self.body.append(markup(node, False))
    raise nodes.SkipNode


def visit_displaymath(self, node):
    self.body.append(f'<div class="math">{markup(node, True)}</div>')
    raise nodes.SkipNode


def setup(app):
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_displaymath, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
