"""The scripts that compute poses, distances and figures in a page, compared with the library."""

import json

import numpy as np
import pytest
from conftest import MIXED, SKELETONS, random_tree, weighted

from skpose import forward_kinematics, pose_distances
from skpose.view._explorer import NUMBERS, skeleton_data
from skpose.view._page import asset
from skpose.view._shape import find_shape, outline

pytestmark = pytest.mark.slow

TREES = SKELETONS | {"mixed": weighted(random_tree(11, 14, "parent", MIXED), 11), "balls": random_tree(10, 14, "own")}
DOCUMENT = """<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>numbers</title></head><body>
<script type="application/json" id="data">{{}}</script><script type="module">
{scripts}
Object.assign(window, {{ Skeleton, distances, centresOf, outlineOf }});
</script></body></html>
"""
SCRIPT = """(({ data, X, Y }) => {
  const [skeleton, [first, second]] = [new Skeleton(data), [X, Y].map((rows) => rows.map((x) => Float64Array.from(x)))];
  return {
    positions: first.map((x) => [...skeleton.positions(x)]),
    middle: first.map((x, i) => [...skeleton.positions(skeleton.between(x, second[i], 0.3))]),
    distances: first.map((x, i) => distances(skeleton, x, second[i], 10)),
  };
})"""


@pytest.fixture(scope="module")
def scripts(browser):
    names = ("page.js", *NUMBERS, "figure.js", "shape.js")
    browser.show(DOCUMENT.format(scripts="\n".join(map(asset, names))))
    browser.wait_for("Boolean(window.Skeleton)")
    assert browser.problems() == []
    return browser


def random_poses(tree, n, seed, extent=3.0):
    return np.random.default_rng(seed).uniform(-extent, extent, (n, tree.n_dofs))


@pytest.mark.parametrize("name", TREES)
def test_positions_and_distances_are_those_of_the_library(scripts, name):
    tree = TREES[name]
    X, Y = random_poses(tree, 6, 0, extent=7.0), random_poses(tree, 6, 1)
    Y[-1] = X[-1] + 1e-5
    data = {"data": skeleton_data(tree), "X": X.tolist(), "Y": Y.tolist()}
    found = scripts.run(f"{SCRIPT}({json.dumps(data)})")
    positions = np.reshape(found["positions"], (6, -1, 3))
    np.testing.assert_allclose(positions, forward_kinematics(X, tree), rtol=0, atol=1e-12)
    for metric in ("angle", "position", "rotation", "spatial"):
        expected = pose_distances(X, Y, skeleton=tree, metric=metric).diagonal()
        np.testing.assert_allclose([one[metric] for one in found["distances"]], expected, rtol=1e-8, err_msg=metric)


@pytest.mark.parametrize("name", ["humanoid", "bvh"])
def test_figures_are_hulls_of_the_same_discs(scripts, name):
    skeleton = TREES[name]
    shape, pose = find_shape(skeleton), random_poses(skeleton, 1, 2, extent=0.5)
    points = np.concatenate([np.zeros((1, 3)), forward_kinematics(pose, skeleton)[0]])
    arguments = f"{json.dumps(shape.data())}, {json.dumps(points.tolist())}"
    centres = np.array(scripts.run(f"centresOf({arguments}, () => true)"))
    np.testing.assert_allclose(centres, shape.centres(points), atol=1e-12)
    hull = list(shape.parts[0].hulls[0])
    discs = [{"x": x, "y": y, "radius": r} for (x, y), r in zip(centres[hull, :2], shape.radii[hull], strict=True)]
    found = scripts.run(f"outlineOf({json.dumps(discs)}).map(({{ x, y }}) => [x, y])")
    np.testing.assert_allclose(found, outline(centres[hull, :2], shape.radii[hull]))
