"""The findings of `skpose reproduce` as text, Markdown and figures."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure  # without pyplot: no window, no backend

from skpose._cli.studies.reproduce import DIFFERENCES, N_DRAWS, Findings
from skpose.metrics._registry import METRICS
from skpose.plot import GeodesicDisplay, MDSDisplay
from skpose.plot._axes import COLOURS

HEAD = ("section", "quantity", "paper", "here", f"{N_DRAWS} draws", "sequences", "poses", "test")


def cells(findings: Findings) -> list[tuple[str, ...]]:
    """The rows of the table, without its head."""
    return [
        (row.section, row.quantity, row.paper, row.first, row.draws, str(row.n_sequences), f"{row.n_poses:,}", row.test)
        for row in findings.rows
    ]


def text(findings: Findings) -> str:
    """The table for a terminal, and the differences from the paper."""
    rows = [HEAD, *cells(findings)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(HEAD))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    return "\n".join([*lines, "", "Differences from the paper:", *(f"- {note}" for note in _notes(findings))])


def markdown(findings: Findings, source: str, seed: int) -> str:
    """The same as a Markdown document with the figures."""
    table = ["| " + " | ".join(row) + " |" for row in [HEAD, ("---",) * len(HEAD), *cells(findings)]]
    pictures = [f"![{caption}]({name})" for name, caption in CAPTIONS.items()]
    paper = "S. Hauberg, K. S. Pedersen, AMDO 2012, [doi](https://doi.org/10.1007/978-3-642-31567-1_3)"
    return "\n".join(
        [
            "# Section 3 of the paper, repeated",
            "",
            f"{paper}, on {source}; seed {seed}. Poses at 12 Hz, ten steps to a curve.",
            "",
            *table,
            "",
            "Differences from the paper:",
            "",
            *(f"- {note}" for note in _notes(findings)),
            "",
            "\n\n".join(pictures),
            "",
        ]
    )


def _notes(findings: Findings) -> list[str]:
    return [*DIFFERENCES, *findings.notes]


CAPTIONS = {
    "figure_3.png": "Figure 3: (a) a geodesic and the straight line, (b) the ratio of their lengths for 100 pairs",
    "figure_4.png": "Figure 4: (a, b) two people's walks in two dimensions, (c) the share of variance in one",
}


def draw(findings: Findings, figure_3: Path, figure_4: Path) -> None:
    """Write figures 3 and 4 as PNG files."""
    figure = Figure(figsize=(11, 4.5), layout="constrained")
    left, right = figure.subplots(1, 2)
    skeleton, start, end = findings.pair
    display = GeodesicDisplay.from_poses(start, end, skeleton, ax=left)
    left.set_title(f"(a) the pair of lowest ratio, {display.ratio_:.3f}")
    right.hist(findings.ratios, bins=20, color=COLOURS[0])
    lowest = findings.ratios.min()
    right.axvline(lowest, color=COLOURS[1], linestyle="--", label=f"lowest, {lowest:.3f} (paper: 0.94)")
    right.set(xlabel="length of the geodesic / length of the line", ylabel="pairs of walking poses")
    right.yaxis.get_major_locator().set_params(integer=True)
    right.set_title("(b) how good the straight line is")
    right.legend()
    figure.savefig(figure_3, dpi=120)

    figure = Figure(figsize=(15, 4.5), layout="constrained")
    *planes, last = figure.subplots(1, len(findings.walkers) + 1, squeeze=False)[0]
    for ax, letter, (metric, (embedding, people, shares)) in zip(planes, "ab", findings.walkers.items(), strict=False):
        unit = METRICS[metric].unit
        MDSDisplay.from_embedding(embedding, people, shares=shares, unit=unit, ax=ax)
        ax.get_legend().set_title("person")
        ax.set_title(f"({letter}) two people's walks, “{metric}”")
    for (metric, shares), colour in zip(findings.shares.items(), COLOURS, strict=False):
        last.hist(shares, bins=np.linspace(0, 1, 21), color=colour, alpha=0.6, label=f"“{metric}”")
    last.set(xlabel="share of variance in the first component", ylabel="sequences")
    last.set_title("(c) share of variance in one component")
    last.legend()
    figure.savefig(figure_4, dpi=120)
