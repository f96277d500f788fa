"""Positions to which no skeleton can be fitted, and other units."""

import numpy as np
import pytest
from people import moving

from skpose.keypoints import fit_skeleton, layouts


def test_collinear_hips_and_trunk_are_refused():
    layout = layouts["coco17"]
    positions = moving(layout, n=10)
    names = list(layout.names)
    line = {"left_hip": 0.1, "right_hip": -0.1, "left_shoulder": 0.7, "right_shoulder": 0.3}
    for name, x in line.items():
        positions[:, names.index(name)] = [x, 1.0, 0.0]
    with pytest.raises(ValueError, match="orientation of 'pelvis'"):
        fit_skeleton(positions, layout)


def test_a_point_that_is_never_seen_is_refused_and_the_remedy_works():
    layout = layouts["coco17"]
    positions = moving(layout)
    positions[:, layout.names.index("left_ear")] = np.nan
    keypoints = layout.keypoints(positions, 25)
    with pytest.raises(ValueError, match="never seen: left_ear"):
        fit_skeleton(keypoints, layout)
    assert "left_ear" not in fit_skeleton(keypoints, layout.without(["left_ear"]))
    positions[:, layout.names.index("left_hip")] = np.nan
    with pytest.raises(ValueError, match="left_ear, left_hip, pelvis"):
        fit_skeleton(positions, layout)


@pytest.mark.parametrize(("unit", "scale"), [("millimetres", 1e3), ("centimetres", 1e2)])
def test_other_units_warn(unit, scale):
    layout = layouts["coco17"]
    with pytest.warns(UserWarning, match=f"in {unit}"):
        fit_skeleton(scale * moving(layout), layout)
