"""Tiles of the gallery hold one axes of a figure, which fills them, in the colours of light and of dark pages."""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

pytest.importorskip("sphinx_gallery", reason="sphinx-gallery is of the extra docs")
sys.path.insert(0, str(Path(__file__).parents[2] / "docs" / "_extensions"))


import tiles

pytestmark = pytest.mark.usefixtures("agg")


def tile_of(ax, folder):
    """Return the two versions of a tile, as images from 0 to 1."""
    tiles.save_tile(ax, folder / "tile.png")
    image = plt.imread(folder / "tile.png")
    assert image.shape == (*tiles.SIZE[::-1], 4)
    return np.split(image, 2)


def test_the_axes_of_a_tile():
    figure, (small, large) = plt.subplots(1, 2, width_ratios=(1, 2))
    inside = large.inset_axes((0.6, 0.6, 0.3, 0.3))
    for ax in (small, inside):
        ax.plot([0, 1])
    assert tiles.choose_axes(figure) is small  # the larger one is empty
    large.plot([0, 1])
    assert tiles.choose_axes(figure) is large
    assert [tiles.choose_axes(figure, k) for k in (1, 2, 3)] == [small, inside, large]


def test_a_tile_in_both_colours_without_what_is_around(tmp_path):
    figure, (left, right) = plt.subplots(1, 2)
    left.fill([0, 1, 1, 0], [0, 0, 1, 1], color="red")
    right.fill([0, 1, 1, 0], [0, 0, 1, 1], color="black", linewidth=0, label="all")
    right.set(xlim=(-1, 1), ylim=(0, 1), title="a title", xlabel="x")
    right.legend()
    figure.suptitle("a text")
    light, dark = tile_of(right, tmp_path)
    half = light.shape[1] // 2
    for image in (light, dark):
        assert not image[:, : half - 2, 3].any()
        assert (image[:, half + 2 :, 3] == 1.0).all()
    assert not light[:, half + 2 :, :3].any()
    np.testing.assert_allclose(dark[:, half + 2 :, :3] - tiles.INK, 0.0, atol=1 / 255)
