"""Data from which fit_skeleton makes no skeleton, or one with a warning, and data that are few or flat."""

from dataclasses import replace

import numpy as np
import pytest
from people import ARM, PEOPLE, lengths, moving, one_bone

from skpose import forward_kinematics
from skpose.keypoints import fit_skeleton, layouts


@pytest.fixture(params=list(layouts))
def layout(request):
    return layouts[request.param]


def test_hips_and_trunk_on_one_line_are_refused():
    layout = layouts["coco17"]
    positions = moving(layout, n=10)
    names = list(layout.names)
    line = {"left_hip": 0.1, "right_hip": -0.1, "left_shoulder": 0.7, "right_shoulder": 0.3}
    for name, x in line.items():
        positions[:, names.index(name)] = [x, 1.0, 0.0]
    with pytest.raises(
        ValueError, match=r"axes of 'pelvis' cannot be found.*'left_hip', 'right_hip', 'neck' .* one line"
    ):
        fit_skeleton(positions, layout)


def test_a_straight_arm_has_a_rest_pose():
    skeleton = fit_skeleton([[[0.0, 0, 0], [0, 0.3, 0], [0, 0.55, 0]]] * 4, ARM)
    np.testing.assert_allclose(
        forward_kinematics(np.zeros((1, 6)), skeleton)[0, 1:], [[0, 0.3, 0], [0, 0.55, 0]], atol=1e-12
    )


def test_directions_that_cancel_each_other_have_no_mean_and_one_is_taken():
    positions = [[[0.0, 0, 0], [0, 0.3, 0], [0, 0.55, 0]], [[0.0, 0, 0], [0, -0.3, 0], [0, -0.55, 0]]]
    skeleton = fit_skeleton(positions, ARM)
    assert np.isfinite(skeleton.rest_rotations).all()
    np.testing.assert_allclose(list(lengths(skeleton).values()), [0, 0.3, 0.25])


def test_all_points_in_one_place_are_refused(layout):
    with pytest.raises(ValueError, match="all points are in one place"):
        fit_skeleton(np.ones((5, len(layout.names), 3)), layout)


def test_a_bone_of_length_zero_is_kept():
    positions = np.zeros((5, 3, 3))
    positions[:, 2] = [0.0, 0.5, 0.0]
    assert lengths(fit_skeleton(positions, ARM)) == {"shoulder": 0.0, "elbow": 0.0, "wrist": 0.5}


def test_positions_that_are_all_nan_are_refused(layout):
    with pytest.raises(ValueError, match="no point is seen in any frame"):
        fit_skeleton(np.full((5, len(layout.names), 3), np.nan), layout)


def test_no_frames_are_refused(layout):
    with pytest.raises(ValueError, match="no frames"):
        fit_skeleton(np.zeros((0, len(layout.names), 3)), layout)


def test_a_point_that_is_never_seen_is_refused_and_the_remedy_works():
    layout = layouts["coco17"]
    positions = moving(layout)
    positions[:, layout.names.index("left_ear")] = np.nan
    keypoints = layout.keypoints(positions, 25)
    with pytest.raises(ValueError, match=r"never seen in \d+ frames: 'left_ear'; .*layout.without\(\['left_ear'\]\)"):
        fit_skeleton(keypoints, layout)
    assert "left_ear" not in fit_skeleton(keypoints, layout.without(["left_ear"]))
    positions[:, layout.names.index("left_hip")] = np.nan
    with pytest.raises(ValueError, match=r"'left_ear', 'left_hip', 'pelvis'; .*a Layout of your own"):
        fit_skeleton(positions, layout)


def test_a_point_that_is_never_seen_with_its_parent_is_refused():
    positions = one_bone(0.3, 10, 0.0, 0)
    positions[:5, 2], positions[5:, 1] = np.nan, np.nan
    with pytest.raises(ValueError, match="'wrist' and its parent 'elbow' are never seen in one frame"):
        fit_skeleton(positions, ARM)


def limb_that_is_never_seen_with_the_root(layout):
    positions = moving(layout, n=20)
    positions[:10, [layout.names.index("left_wrist")]] = np.nan
    positions[10:, [layout.names.index("left_hip")]] = np.nan
    return positions


def test_a_limb_that_is_never_seen_with_the_root_stands_where_it_does_in_everyone():
    layout = layouts["coco17"]
    skeleton = fit_skeleton(limb_that_is_never_seen_with_the_root(layout), layout)
    np.testing.assert_array_equal(skeleton.rest_rotations, fit_skeleton(moving(layout), layout).rest_rotations)


def test_an_unknown_limb_that_is_never_seen_with_the_root_is_refused():
    layout = layouts["coco17"]
    names = ["left_flipper" if name == "left_wrist" else name for name in layout.names]
    parents = {"left_flipper" if name == "left_wrist" else name: parent for name, parent in layout.parents.items()}
    other = replace(layout, names=names, parents=parents)
    with pytest.raises(ValueError, match="'left_elbow' to 'left_flipper' is seen in no frame that shows how the root"):
        fit_skeleton(limb_that_is_never_seen_with_the_root(layout), other)


@pytest.mark.parametrize("name", PEOPLE)
@pytest.mark.parametrize(("unit", "scale"), [("millimetres", 1e3), ("centimetres", 1e2)])
def test_other_units_are_named(name, unit, scale):
    layout, factor = layouts[name], 1 / scale
    with pytest.warns(UserWarning, match=f"if positions are in {unit}, pass {factor:g} \\* positions"):
        fit_skeleton(scale * moving(layout), layout)


def test_a_hand_in_metres_has_no_warning():
    fit_skeleton(one_bone(0.05, 50, 0.0, 0) * [1, 0.1, 1], ARM)


def test_keypoints_of_another_layout_are_refused():
    keypoints = layouts["coco17"].keypoints(moving(layouts["coco17"]), 25)
    with pytest.raises(ValueError, match="the keypoints have no point named 'spine', as the layout 'h36m17' has"):
        fit_skeleton(keypoints, layouts["h36m17"])
    with pytest.raises(ValueError, match="no 'pelvis' and no 'neck', which the layout 'coco17' makes"):
        fit_skeleton(keypoints.select(layouts["coco17"].names), layouts["coco17"])


def test_a_name_is_no_layout():
    with pytest.raises(TypeError, match=r"got str: pass skpose.keypoints.layouts\['coco17'\]"):
        fit_skeleton(moving(layouts["coco17"]), "coco17")
