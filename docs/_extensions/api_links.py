"""Literals that name a public object are links to its page: ``pose_distances(X)``, ``Motion.resample``.

What examples call ``skeleton``, ``motion`` and ``dataset`` are a `Skeleton`, a `Motion` and a `MotionDataset`.
"""

import re

from docutils import nodes
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util.nodes import make_refnode

INSTANCES = {"skeleton": "Skeleton", "motion": "Motion", "dataset": "MotionDataset", "keypoints": "Keypoints"}


def short_names(objects):
    """Return the full name of each object by its last parts: "Motion" and "Motion.resample"."""
    found = {}
    for full, entry in objects.items():
        if entry.aliased:  # the private module that an object is written in
            continue
        parts = full.split(".")
        n = 2 if entry.objtype in {"method", "property", "attribute"} else 1
        found.setdefault(".".join(parts[-n:]), full)
        found[full] = full
    return found


def name_in(literal):
    """Return the name that a literal is, or calls, or None; a method of an instance as that of its class."""
    found = re.fullmatch(r"([A-Za-z_][\w.]*)(\(.*\))?", literal, flags=re.DOTALL)
    if found is None:
        return None
    first, _, rest = found[1].partition(".")
    return f"{INSTANCES[first]}.{rest}" if rest and first in INSTANCES else found[1]


class LinkLiterals(SphinxPostTransform):
    """Wrap each literal that names a public object into a link, but for titles and the page of the object itself."""

    default_priority = 500

    def run(self, **kwargs):
        if self.app.builder.format != "html":
            return
        objects = self.env.get_domain("py").objects
        names = short_names(objects)
        for literal in list(self.document.findall(nodes.literal)):
            parent = literal.parent
            if isinstance(parent, nodes.reference | nodes.title):
                continue
            full = names.get(name_in(literal.astext()))
            if full is None or objects[full].docname == self.env.docname:
                continue
            entry = objects[full]
            text = literal.deepcopy()
            parent.replace(
                literal,
                make_refnode(self.app.builder, self.env.docname, entry.docname, entry.node_id, text, title=full),
            )


def setup(app):
    app.add_post_transform(LinkLiterals)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
