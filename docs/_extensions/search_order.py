"""Order of what a search finds: the pages that define a parameter of that name come first, the changelog last."""

import inspect
import json
from pathlib import Path

from sphinx.util import import_object

NAME = "parameters.js"


def parameters_of(docnames):
    """Return for each name of a parameter the pages of the reference that have it: classes first, then short ones."""
    found = {}
    for doc in docnames:
        thing = import_object(doc.removeprefix("api/"))
        if callable(thing):
            names = list(inspect.signature(thing).parameters)
            for name in names:
                found.setdefault(name, []).append((not inspect.isclass(thing), len(names), doc))
    return {name: [doc for *_, doc in sorted(pages)] for name, pages in sorted(found.items())}


def write(app, exception):
    if exception is None and app.builder.format == "html":
        found = parameters_of(doc for doc in app.env.found_docs if doc.startswith("api/"))
        content = f"const PAGES_OF_PARAMETERS = {json.dumps(found, separators=(',', ':'))};\n"
        Path(app.outdir, "_static", NAME).write_text(content, encoding="utf-8")


def load(app, pagename, templatename, context, doctree):
    if pagename == "search":
        app.add_js_file(NAME)


def setup(app):
    app.connect("html-page-context", load)
    app.connect("build-finished", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
