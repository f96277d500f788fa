"""Tables for notebooks, without colours, so that they are legible on white and on black."""

import html
from collections.abc import Mapping, Sequence

import numpy as np

from skpose._utils.validation import SkeletonLike

MOST_ROWS = 50


def foldable_table(title: str, columns: Mapping[str, Sequence[object]]) -> str:
    """An HTML table of columns by their headings, folded below a title; at most the first 50 rows."""
    n_rows = len(next(iter(columns.values())))
    heading = f"<code>{html.escape(title)}</code>"
    if not n_rows:
        return f"<p>{heading}</p>"
    rows = [
        _row("th", list(columns)),
        *(_row("td", row) for row in list(zip(*columns.values(), strict=True))[:MOST_ROWS]),
    ]
    more = f"<p>… and {n_rows - MOST_ROWS} more</p>" if n_rows > MOST_ROWS else ""
    table = f'<table style="color: inherit; border-spacing: 1em 0">{"".join(rows)}</table>'
    return f"<details><summary>{heading}</summary>{table}{more}</details>"


def _row(tag: str, cells: Sequence[object]) -> str:
    style = ' style="text-align: left"'
    return f"<tr>{''.join(f'<{tag}{style}>{html.escape(str(cell))}</{tag}>' for cell in cells)}</tr>"


def columns_of_bones(skeleton: SkeletonLike) -> dict[str, list[str]]:
    """The bones of a skeleton as columns of a table; limits and weights if there are any."""
    bones = skeleton.bones
    columns = {
        "joint": [bone.name for bone in bones],
        "parent": ["the root" if bone.parent is None else bone.parent for bone in bones],
        "dofs": [bone.dofs or "rigid" for bone in bones],
        "length, m": [f"{length:.3g}" for length in np.linalg.norm(skeleton.offsets, axis=1)],
    }
    if skeleton.limits is not None:
        columns["limits"] = [", ".join(_range(bone.is_slide, *pair) for pair in bone.limits or ()) for bone in bones]
    if (skeleton.weights != 1.0).any():
        columns["weight"] = [f"{weight:.3g}" for weight in skeleton.weights]
    return columns


def _range(in_metres: bool, low: float, high: float) -> str:
    return f"{low:.3g} to {high:.3g} m" if in_metres else f"{np.degrees(low):.0f} to {np.degrees(high):.0f}°"
