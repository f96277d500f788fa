"""Tiles of the gallery: one axes of an example's figure, drawn anew at the size of a tile, for light and dark pages.

``# sphinx_gallery_tile = (2, 1)`` in an example chooses the first axes of its second figure; without it, that is the
largest axes of the first. Texts around the axes are left out, as nobody could read them; markers and lines keep their
size, so that they are as clear as in the example. The two versions are one picture, light above dark, of which the
style sheet shows one.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba_array
from sphinx_gallery.scrapers import matplotlib_scraper

WIDTH, HEIGHT = 2.4, 1.6  # inches, of 100 px of a page each
DENSITY = 3  # pixels of the picture for each of a page
SIZE = (round(100 * DENSITY * WIDTH), 2 * round(100 * DENSITY * HEIGHT))
MARGIN = 0.08
STRIP = 3.2  # width by height from which axes are cut rather than shown whole
INK, PAPER = np.array([0.91, 0.92, 0.93]), np.array([0.078, 0.094, 0.118])  # of a dark page
LIST_OF_TAGS = ".. raw:: html\n\n  <div id='sg-tag-list' class='sphx-glr-tag-list'></div>\n"
COLOURS = "facecolor", "edgecolor", "color", "markerfacecolor", "markeredgecolor"


def choose_axes(figure, number=None):
    """Return an axes with data by its number, from 1, or the largest one; axes inside others are before these."""
    drawn = [ax for ax in figure.findobj(Axes) if ax.has_data()]
    return drawn[number - 1] if number else max(drawn, key=lambda ax: ax.bbox.width * ax.bbox.height)


def fill(ax):
    """Set the limits of axes of equal scales so that they fill a tile; strips are cut at both ends."""
    (left, low), (right, high) = ax.dataLim.get_points()
    wide, tall = right - left, high - low
    if wide <= STRIP * tall:
        tall = max(tall, wide * HEIGHT / WIDTH)
    tall *= 1 + 2 * MARGIN
    wide = tall * WIDTH / HEIGHT
    middle, centre = (left + right) / 2, (low + high) / 2
    ax.set(xlim=(middle - wide / 2, middle + wide / 2), ylim=(centre - tall / 2, centre + tall / 2))


def magnify(ax):
    """Place axes of three dimensions, which have wide margins, so that what is drawn fills a tile."""
    rows, columns = np.nonzero(pixels(ax.figure)[::-1, :, 3])
    x, y = columns / (SIZE[0] - 1), rows / (SIZE[1] / 2 - 1)
    zoom = (1 - 2 * MARGIN) / max(np.ptp(x), np.ptp(y))
    ax.set_position([0.5 - zoom * (x.min() + x.max()) / 2, 0.5 - zoom * (y.min() + y.max()) / 2, zoom, zoom])


def isolate(ax):
    """Make axes the whole of their figure, of the size of a tile and without what is around them."""
    figure = ax.get_figure(root=True)
    figure.set_layout_engine("none")
    if ax not in figure.axes:  # but in another
        figure.add_axes(ax)
        ax.set_axes_locator(None)
    for other in figure.get_children():
        other.set_visible(other is ax)
    if ax.get_legend():
        ax.get_legend().remove()
    ax.set_axis_off()
    ax.set_title("")
    ax.patch.set_visible(False)
    figure.set_size_inches(WIDTH, HEIGHT)
    ax.set_position([0, 0, 1, 1])
    if ax.name == "3d":
        magnify(ax)
    else:
        if ax.get_aspect() == 1.0 and not ax.images:
            fill(ax)
        ax.set_aspect("auto")


def darken(colours):
    """Return colours for a dark page: greys between its paper and its ink, the others somewhat lighter."""
    rgb = colours[:, :3]
    colourful = np.ptp(rgb, axis=1, keepdims=True) > 0.1
    grey = INK + rgb.mean(axis=1, keepdims=True) * (PAPER - INK)
    return np.hstack([np.where(colourful, rgb + 0.2 * (1.0 - rgb), grey), colours[:, 3:]])


def recolour(ax):
    """Give all that is drawn in axes its colour on a dark page."""
    for artist in ax.findobj():
        names = [name for name in COLOURS if hasattr(artist, f"get_{name}") and hasattr(artist, f"set_{name}")]
        if "facecolor" in names and "color" in names:
            names.remove("color")  # which sets both others
        known = {name: to_rgba_array(getattr(artist, f"get_{name}")()) for name in names}
        for name, colours in known.items():
            if len(colours):
                changed = darken(colours)
                getattr(artist, f"set_{name}")(changed if hasattr(artist, "get_offsets") else changed[0])


def pixels(figure):
    """Return a figure as an image, transparent where nothing is drawn."""
    figure.set_dpi(100 * DENSITY)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.array(canvas.buffer_rgba())


def save_tile(ax, path):
    """Write the tile of axes; their figure is changed for that, for good."""
    isolate(ax)
    light = pixels(ax.figure)
    if not ax.images:  # which are the same in the dark, with what is drawn on them
        recolour(ax)
    plt.imsave(path, np.vstack([light, pixels(ax.figure)]))


def scraper(block, variables, gallery_conf):
    """Save the figures of a block as Sphinx-Gallery does, and the tile of the example if it is of one of them."""
    paths, conf = variables["image_path_iterator"], variables["file_conf"]
    before = len(paths)
    figures = [plt.figure(number) for number in plt.get_fignums()]
    text = matplotlib_scraper(block, variables, gallery_conf)
    figure, axes = conf.get("tile", (1, None))
    if before < figure <= before + len(figures):
        path = Path(paths.image_path.format(figure))
        path = path.with_name(f"{path.stem}_tile.png")
        save_tile(choose_axes(figures[figure - before - 1], axes), path)
        conf["thumbnail_path"] = str(path)
    return text


def skip_lists_of_tags(app, name, source):
    """Leave out the empty lists of tags, which have one identifier in all sections."""
    source[0] = source[0].replace(LIST_OF_TAGS, "")


def setup(app):
    app.connect("source-read", skip_lists_of_tags)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
