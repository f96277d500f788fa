"""A map of all joints against time, one row for each joint."""

import numpy as np

from skpose.plot._axes import SIDES
from skpose.skeleton._sides import sides

ROW = 0.19  # inches: the height of a joint
LARGEST_FONT = 9.0  # points


def draw_joint_map(ax, values, names, edges, label, style, bar_ax=None) -> None:
    """Draw values (n_frames, n_joints) from the left to the right edge, and a colour bar in `bar_ax` or next to it.

    Names of joints are as small as their rows need, and have the colours of their sides.
    """
    extent = (*edges, len(names) - 0.5, -0.5)
    defaults = {"cmap": "viridis", "interpolation": "nearest", "vmin": 0.0, "aspect": "auto"}
    if not values.any():
        defaults["vmax"] = 1.0  # else matplotlib makes room below zero
    image = ax.imshow(values.T, extent=extent, **defaults | style)
    ax.figure.colorbar(image, ax=ax, cax=bar_ax, label=label)
    row = ax.get_window_extent().height / ax.figure.dpi * 72 / len(names)  # points
    ax.set_yticks(np.arange(len(names)), names, fontsize=min(LARGEST_FONT, 0.8 * row))
    for text, side in zip(ax.get_yticklabels(), sides(names), strict=True):
        text.set_color(SIDES[side] if side else "black")
    ax.tick_params(axis="y", length=0)
