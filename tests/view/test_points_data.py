"""What a page holds of keypoints: positions, which are seen, and the bones of a layout."""

from dataclasses import replace

import numpy as np
import pytest
from pages import data_of

from skpose import Keypoints, Motion, Skeleton
from skpose.keypoints import Layout, layouts
from skpose.skeleton._sides import sides
from skpose.view import player
from skpose.view._scene import unpack

ARM = Motion(Skeleton.chain(2), np.zeros((3, 2)), 30)

pytestmark = pytest.mark.filterwarnings("ignore:.* is taken as the axis that points up:UserWarning")  # random points


def walking(names, n=30, up="y", seed=0):
    """Points that go far, of which some are not seen for a while, one never."""
    rng = np.random.default_rng(seed)
    positions = rng.normal(size=(1, len(names), 3)) + rng.normal(scale=0.1, size=(n, len(names), 3)).cumsum(axis=0)
    positions[5:9, 1] = positions[:4, 2] = positions[-3:, 2] = positions[12, :-1] = np.nan
    return Keypoints(positions, names, 50, up=up)


def one(keypoints, **options):
    (data,) = data_of(keypoints.play(**options))["motions"]
    return data


def positions_of(data):
    """The positions (n_frames, n_points, 3) that a page draws, NaN where it draws none."""
    root = unpack(data["root"])
    positions = unpack(data["joints"]).reshape(len(root), -1, 3) + root[:, None]
    positions[unpack(data["seen"]) < 0.5] = np.nan
    return positions


@pytest.mark.parametrize("up", "yz")
def test_points_are_where_they_are_and_none_is_made_up(up):
    keypoints = walking(["a", "b", "c", "d"], up=up)
    data = one(keypoints)
    axes = {"x": [2, 0, 1], "y": [0, 1, 2], "z": [1, 2, 0]}[up]
    expected = keypoints.positions[..., axes]
    expected = expected - [0, np.nanmin(expected[..., 1]), 0]
    found = positions_of(data)
    np.testing.assert_array_equal(np.isnan(found), np.isnan(expected))
    error = np.nanmax(np.linalg.norm(found - expected, axis=2))
    assert error <= data["error"] / 1e3 * (1 + 1e-6) < 1e-3
    assert np.nanmin(found[..., 1]) == pytest.approx(0, abs=1e-3)
    assert data["axes"] == "".join("xyz"[axis] for axis in axes)
    assert (data["rate"], data["start"], data["numbers"], data["headings"]) == (50, 0, None, None)


def test_the_middle_does_not_jump_where_points_are_lost():
    keypoints = walking(["a", "b", "c", "d"])
    middle = unpack(one(keypoints)["root"])
    steps = np.linalg.norm(np.diff(middle, axis=0), axis=1)
    assert steps.max() < 0.3
    whole = replace(keypoints, positions=np.zeros((5, 4, 3)) + np.arange(4)[:, None], confidences=None)
    np.testing.assert_allclose(unpack(one(whole)["root"]), np.full((5, 3), 1.5), atol=1e-3)


@pytest.mark.parametrize("name", ["coco17", list(layouts)[-1]])
def test_bones_are_those_of_the_layout_that_has_the_names(name):
    layout = layouts[name]
    data = one(walking(list(layout.names)))
    assert data["layout"] == name
    assert data["names"] == list(layout.points)
    bones = {point: data["names"][p] for point, p in zip(data["names"], data["parents"], strict=True) if p >= 0}
    assert bones == {point: parent for point, parent in layout.parents.items() if parent is not None}
    assert data["sides"] == sides(layout.points)
    seen = unpack(data["seen"])
    for i, point in enumerate(layout.points):
        if point in layout.midpoints:  # where all its parts are seen
            parts = [layout.points.index(part) for part in layout.midpoints[point]]
            np.testing.assert_array_equal(seen[:, i], seen[:, parts].min(axis=1))


def test_names_keep_their_spelling_and_others_have_no_bones():
    names = [name.upper() for name in layouts["coco17"].names]
    data = one(walking([*names, "racket"]))
    assert data["layout"] == "coco17"
    assert data["names"] == [*names, "pelvis", "neck", "racket"]
    assert data["parents"][-1] == -1
    assert data["names"][data["parents"][names.index("LEFT_KNEE")]] == "LEFT_HIP"
    assert positions_of(data).shape[1] == 20


def test_a_layout_that_is_given():
    limb = Layout("limb", ["a", "b"], {"mid": None, "a": "mid", "b": "a"}, midpoints={"mid": ["a", "b"]})
    data = one(walking(["c", "b", "a"]), layout=limb)
    assert (data["layout"], data["names"], data["parents"]) == ("limb", ["a", "b", "mid", "c"], [2, 0, -1, -1])
    coco = walking(list(layouts["coco17"].names))
    assert one(coco, layout="coco17") == one(coco)
    assert data_of(player([coco, ARM], layout="coco17"))["motions"][0]["layout"] == "coco17"
