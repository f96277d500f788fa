"""Skeletons from several recordings, and symmetric skeletons."""

from dataclasses import replace

import numpy as np
import pytest
from people import ALONE, lengths, moving

from skpose import forward_kinematics
from skpose.keypoints import Keypoints, fit_skeleton, layouts


@pytest.fixture
def recordings():
    """Two recordings of a person in COCO's layout, at different rates, as keypoints."""
    layout = layouts["coco17"]
    return [layout.keypoints(moving(layout, n=n, seed=n), rate) for n, rate in ((120, 25), (80, 30))]


def test_several_recordings_are_one_person(recordings):
    layout = layouts["coco17"]
    together = Keypoints(np.concatenate([each.positions for each in recordings]), recordings[0].names, 25)
    skeleton = fit_skeleton(recordings, layout)
    np.testing.assert_allclose(skeleton.offsets, fit_skeleton(together, layout).offsets, atol=1e-12)
    for one in (tuple(recordings), [each.select((*layout.names, "pelvis", "neck")) for each in recordings]):
        assert fit_skeleton(one, layout) == skeleton
    assert fit_skeleton(recordings[:1], layout) == fit_skeleton(recordings[0], layout)
    arrays = [moving(layout, n=n, seed=n) for n in (120, 80)]
    assert fit_skeleton(arrays, layout) == skeleton
    assert fit_skeleton([arrays[0].tolist(), recordings[1]], layout) == skeleton


def uneven(layout, seed=0):
    """Positions of a person whose right limbs, and right half of the pelvis and the face, are 3 % longer."""
    positions = moving(layout, n=200, seed=seed)
    keypoints = layout.keypoints(positions, 25)
    at = dict(zip(keypoints.names, np.moveaxis(keypoints.positions, 1, 0), strict=True))
    names, found = [layout.root], {layout.root: at[layout.root]}
    for name in names:
        names += [child for child in layout.points if layout.parents[child] == name]
        if name != layout.root:
            parent = layout.parents[name]
            factor = 1.03 if name in {right for _, right in layout.pairs} else 1.0
            found[name] = found[parent] + factor * (at[name] - at[parent])
    return Keypoints(np.stack([found[name] for name in layout.points], axis=1), layout.points, 25, up=keypoints.up)


@pytest.mark.parametrize("name", ["coco17", "smpl24", "opencap43"])
def test_symmetric_skeletons_are_their_own_mirror_image(name):
    layout = layouts[name].without(ALONE.get(name, []))
    if not layout.pairs:
        return
    keypoints = uneven(layout)
    skeleton, plain = fit_skeleton(keypoints, layout, symmetric=True), fit_skeleton(keypoints, layout)
    found, own = lengths(skeleton), lengths(plain)
    for left, right in layout.pairs:
        np.testing.assert_allclose(found[left], found[right], rtol=1e-12)
        np.testing.assert_allclose(found[left], (own[left] + own[right]) / 2, rtol=1e-9)  # both are seen as often
        assert own[right] / own[left] > 1.02
    at = dict(zip(skeleton.joint_names, forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton)[0], strict=True))
    for left, right in layout.pairs:
        np.testing.assert_allclose(at[left], at[right] * [-1, 1, 1], atol=1e-12)
    for one in set(layout.points) - {one for pair in layout.pairs for one in pair}:
        assert abs(at[one][0]) < 1e-12, one


def test_different_sides_warn():
    layout = layouts["h36m17"]
    keypoints = layout.keypoints(moving(layout), 25)
    elbow, wrist = (keypoints.names.index(name) for name in ("left_elbow", "left_wrist"))
    positions = keypoints.positions.copy()
    positions[:, wrist] += 0.3 * (positions[:, wrist] - positions[:, elbow])
    with pytest.warns(UserWarning, match=r"left_wrist 34\.5 cm, right_wrist 26\.6 cm"):
        fit_skeleton(replace(keypoints, positions=positions), layout, symmetric=True)
    fit_skeleton(replace(keypoints, positions=positions), layout)  # they may differ
