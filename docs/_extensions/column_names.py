"""Tables of the class "cards" have in each cell the name of its column, which only narrow windows show.

There each row is a card of its own: text of five columns has no room next to each other. `skpose.css` does it.
"""

from docutils import nodes
from sphinx.transforms.post_transforms import SphinxPostTransform


class NameColumns(SphinxPostTransform):
    """Write the name of the column at the beginning of each cell but the first of a row."""

    default_priority = 600

    def run(self, **kwargs):
        for table in self.document.findall(lambda node: isinstance(node, nodes.table) and "cards" in node["classes"]):
            (head,) = next(table.findall(nodes.thead)).children
            names = [entry.astext() for entry in head]
            for row in next(table.findall(nodes.tbody)):
                for name, entry in list(zip(names, row, strict=True))[1:]:
                    if entry.astext():
                        entry.insert(0, nodes.inline("", name, classes=["column-name"]))


def setup(app):
    app.add_post_transform(NameColumns)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
