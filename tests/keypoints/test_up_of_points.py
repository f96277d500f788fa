"""The up axis of keypoints."""

import io
import warnings
from dataclasses import replace

import numpy as np
import pytest
from people import standing_in

from skpose.io import load_keypoints
from skpose.keypoints import fit_skeleton, layouts

COCO = layouts["coco17"]
RNG = np.random.default_rng(0)
# What brings a direction up to y, by half a turn of the world first.
TURNS = {"-x": [-1.0, 1.0, -1.0], "-y": [1.0, -1.0, -1.0], "-z": [1.0, -1.0, -1.0]}
DIRECTIONS = ["x", "-y", "-z"]


def person(layout, n=30):
    """Positions (n, n_names, 3) of a standing person, y up, with noise."""
    at = standing_in(layout)
    return np.array([at[name] for name in layout.names]) + 0.003 * RNG.normal(size=(n, len(layout.names), 3))


def along(direction, positions):
    """Positions, with y up, in a world in which another direction points up."""
    if len(direction) == 2:
        return along(direction[1], positions) * TURNS[direction]
    order = {"x": [1, 2, 0], "y": [0, 1, 2], "z": [2, 0, 1]}[direction]
    return positions[..., order]


def file_of(array):
    file = io.BytesIO()
    np.save(file, array)
    file.seek(0)
    return file


def messages(call, *arguments, **options):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call(*arguments, **options)
    return [str(one.message) for one in caught]


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_remedies(direction):
    positions = person(COCO)
    array = along(direction, positions)
    stated = replace(COCO, up=direction)
    of_array = stated.keypoints(array, 30)
    of_file = load_keypoints(file_of(array), COCO, frame_rate=30, up=direction)
    of_names = load_keypoints(file_of(array), names=COCO.names, frame_rate=30, up=direction)
    np.testing.assert_array_equal(of_array.positions, of_file.positions)
    np.testing.assert_array_equal(of_array.positions[:, :17], of_names.positions)
    assert of_array.up == of_file.up == of_names.up == direction[-1]
    i = "xyz".index(direction[-1])
    np.testing.assert_allclose(of_names.positions[..., i], positions[..., 1])
    assert messages(fit_skeleton, of_array, stated) == []
