"""Rest poses of layouts."""

from dataclasses import replace

import numpy as np
import pytest
from people import moving, standing
from scipy.spatial.transform import Rotation

from skpose.keypoints import fit_skeleton, layouts
from skpose.skeleton._rest import directions_at_zero

LARGEST = 45.0  # degrees by which rest poses may differ in one data set


@pytest.fixture(params=["coco17", "smpl24", "opencap43"])
def layout(request):
    return layouts[request.param]


def doing(layout, lift, n=60, seed=0):
    """Positions of a person who moves about a pose that is not that of standing: arms and thighs lifted forward."""
    names, rng = list(layout.points), np.random.default_rng(seed)
    found = np.stack([[standing(name) for name in names]] * n)
    times = np.linspace(0, 6, n)
    for joint in ("shoulder", "hip", "clavicle", "hipjoint"):
        for name in names:
            if joint not in (name.split("_")[-1], name[1:]):
                continue
            below = [name]
            for one in below:
                below += [child for child in names if layout.parents[child] == one]
            angles = -lift + 0.2 * np.sin(times + rng.uniform(0, 6))
            turns, indices = Rotation.from_euler("x", angles[:, None]), [names.index(one) for one in below]
            for i in indices:
                found[:, i] = turns.apply(found[:, i] - standing(name)) + standing(name)
    found = found[:, : len(layout.names)]
    return {"y": found, "z": found[..., [2, 0, 1]], "-y": found * [1.0, -1.0, -1.0]}[layout.up]


def test_people_who_do_different_things_have_one_rest_pose(layout):
    one, other = (fit_skeleton(doing(layout, lift), layout) for lift in (0.2, 1.6))
    np.testing.assert_allclose(one.rest_rotations, other.rest_rotations, atol=1e-12)
    apart = np.degrees(np.arccos(np.clip((directions_at_zero(one) * directions_at_zero(other)).sum(axis=1), -1, 1)))
    apart[np.linalg.norm(one.offsets, axis=1) == 0.0] = 0.0
    assert apart.max() < LARGEST / 2  # rigid points in the axes of what they are rigid with


def test_exchanged_sides_warn():
    for name in ("coco17", "cmu31"):
        layout = layouts[name]
        positions = moving(layout)
        with pytest.warns(UserWarning, match="point backward"):
            fit_skeleton(positions * [-1, 1, 1], layout)
        swapped = {a: b for pair in layout.pairs for a, b in (pair, pair[::-1])}
        names = [swapped.get(point, point) for point in layout.names]
        with pytest.warns(UserWarning, match="point backward"):
            fit_skeleton(positions, replace(layout, names=names))
