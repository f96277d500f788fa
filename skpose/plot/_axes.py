"""Shared parts of the displays: axes to draw into, legends, and colours that colour-blind people can distinguish."""

import math

# M. Okabe, K. Ito, "Color universal design", 2008; without its yellow, which is hard to see on white.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000")
# Of labels: the first six of these, and fourteen that are farthest from those before them, each in turn, in Oklab, with
# normal vision and without red or green cones; on white and on #181818 with a contrast of two at least.
PALETTE = (
    *COLOURS[:6],
    *("#900c54", "#0000fc", "#906cfc", "#844800", "#60309c", "#90c090", "#846078"),
    *("#d800cc", "#cc0048", "#fc546c", "#245478", "#486c48", "#fc84cc", "#8400c0"),
)
# The middle line is drawn first, so that a legend has its colour, and limbs are in front of it.
SIDES = {"": "#606060", "left": COLOURS[0], "right": COLOURS[1]}
CURVED = {"polar", "aitoff", "hammer", "lambert", "mollweide"}  # projections of matplotlib whose lines are no lines
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
INSIDE = 7  # labels in a legend, which stands next to the axes where there are more
LINE = 1.5  # height of one in a legend, font sizes
GAP = 0.01  # between the axes and the legend, of their widths
OUTSIDE = {
    "loc": "upper left",
    "bbox_to_anchor": (1.0 + GAP, 1.0),
    "borderaxespad": 0.0,
    "borderpad": 0.0,
    "frameon": False,
    "fontsize": "small",
    "handlelength": 1.0,
    "handletextpad": 0.5,
    "columnspacing": 1.0,
}


def axes(ax, caller, figsize=None, projection=None):
    """Return the given axes, or new ones in a figure of a size in inches, and their figure."""
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise ImportError(f"{caller} needs matplotlib: pip install 'skpose[plot]'") from None

    if getattr(ax, "name", None) in CURVED:
        raise ValueError(
            f"ax must have straight axes, as poses are drawn in metres, got a projection {ax.name!r}: make it by "
            "plt.subplots()"
        )
    if getattr(ax, "name", None) == "3d" and projection != "3d":
        raise ValueError(
            f"{caller.partition('.')[0]} draws in two dimensions, got an ax of three: make it by plt.subplots(); "
            "PoseDisplay draws a pose in three"
        )
    if ax is None:
        _, ax = plt.subplots(figsize=figsize, layout="constrained", subplot_kw={"projection": projection})
    return ax, ax.figure


def label_style(i):
    """Return the colour and the marker of a label: twenty colours, then the same with other markers."""
    return {"color": PALETTE[i % len(PALETTE)], "marker": MARKERS[(i + 2 * (i // len(PALETTE))) % len(MARKERS)]}


def add_legend(ax, *, is_new):
    """Add the legend of labels, on the right of the axes where there are many.

    A new figure becomes wider by it. In that of others the axes give it the room: the layout sees to that, and without
    one they shrink here, so that the legend stands where they stood.
    """
    n = len(ax.get_legend_handles_labels()[1])
    if n <= INSIDE:
        return ax.legend()
    figure = ax.figure
    points = 72.0 * ax.get_window_extent().height / figure.dpi
    size = ax.legend(**OUTSIDE).get_texts()[0].get_fontsize()
    legend = ax.legend(**OUTSIDE, ncols=math.ceil(n / max(int(points / (LINE * size)), 1)))
    width = legend.get_window_extent().width
    if is_new:
        figure.set_figwidth(figure.get_figwidth() + width / figure.dpi)
    elif figure.get_layout_engine() is None:
        box, share = ax.get_position(), width / figure.bbox.width + GAP
        ax.set_position([box.x0, box.y0, max(box.width - share, box.width / 3.0), box.height])
    return legend
