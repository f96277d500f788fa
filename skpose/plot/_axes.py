"""Shared parts of the displays: axes to draw into, and colours that colour-blind people can distinguish."""

# M. Okabe, K. Ito, "Color universal design", 2008; without its yellow, which is hard to see on white.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000")
# The middle line is drawn first, so that a legend has its colour, and limbs are in front of it.
SIDES = {"": "#606060", "left": COLOURS[0], "right": COLOURS[1]}
MARKERS = ("o", "s", "^", "D", "v", "P", "X")


def axes(ax, caller, figsize=None, projection=None):
    """Return the given axes, or new ones in a figure of a size in inches, and their figure."""
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise ImportError(f"{caller} needs matplotlib: pip install 'skpose[plot]'") from None

    if ax is None:
        _, ax = plt.subplots(figsize=figsize, layout="constrained", subplot_kw={"projection": projection})
    return ax, ax.figure
