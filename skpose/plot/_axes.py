"""Shared parts of the displays: axes, legends, and colours that colour-blind people can distinguish."""

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
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
INSIDE = 7  # labels in a legend inside the axes; longer legends stand next to them
LINES = 20  # of a legend next to the axes
OUTSIDE = {
    "loc": "upper left",
    "bbox_to_anchor": (1.01, 1.0),
    "borderaxespad": 0.0,
    "borderpad": 0.0,
    "frameon": False,
    "fontsize": "small",
    "handlelength": 1.0,
    "handletextpad": 0.5,
    "columnspacing": 1.0,
}


def axes(ax, figsize=None, projection=None):
    """The given axes, or new ones in a figure of a size in inches, and their figure."""
    import matplotlib.pyplot as plt

    if ax is not None and (ax.name == "3d") != (projection == "3d"):
        raise ValueError(f"ax must have {'three' if projection else 'two'} dimensions for this display and projection")
    if ax is None:
        _, ax = plt.subplots(figsize=figsize, layout="constrained", subplot_kw={"projection": projection})
    return ax, ax.figure


def plain(name):
    """A name as matplotlib shows it literally: between dollar signs it expects formulas."""
    return str(name).replace("$", r"\$")


def label_style(i):
    """Colour and marker of a label: twenty colours; repeated and similar ones get other markers."""
    again, colour = divmod(i, len(PALETTE))
    marker = colour + colour // len(MARKERS) + again
    return {"color": PALETTE[colour], "marker": MARKERS[marker % len(MARKERS)]}
