"""One skeleton from several recordings of a person, keypoints one after another, and skeletons with two equal sides."""

from dataclasses import replace

import numpy as np
import pytest
from people import ALONE, ARM, lengths, moving, one_bone
from scipy.spatial.transform import Rotation

from skpose import Motion, forward_kinematics, inverse_kinematics
from skpose.keypoints import Keypoints, Layout, fit_skeleton, layouts


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


def test_recordings_may_come_one_after_another(recordings):
    """From a generator, a view of a dictionary, an iterator; a single one may be nested lists."""
    layout = layouts["coco17"]
    skeleton = fit_skeleton(recordings, layout)
    arrays = [moving(layout, n=60, seed=n) for n in (0, 1)]
    assert fit_skeleton((each for each in recordings), layout) == skeleton
    assert fit_skeleton(dict(enumerate(recordings)).values(), layout) == skeleton
    assert fit_skeleton(iter(recordings), layout) == skeleton
    assert fit_skeleton((each for each in arrays), layout) == fit_skeleton(arrays, layout)
    assert fit_skeleton(arrays[0].tolist(), layout) == fit_skeleton(arrays[0], layout)
    with pytest.raises(TypeError, match=r"got dict, a mapping: pass list\(mapping\.values\(\)\)"):
        fit_skeleton(dict(enumerate(recordings)), layout)
    with pytest.raises(ValueError, match="keypoints have no frames"):
        fit_skeleton((each for each in ()), layout)


def test_the_skeleton_reaches_all_recordings(recordings):
    skeleton = fit_skeleton(recordings, layouts["coco17"])
    for keypoints in recordings:
        assert inverse_kinematics(keypoints, skeleton).residuals.max() < 1e-6


def test_recordings_do_not_follow_each_other_in_time():
    """Lengths that differ between recordings of one frame each are no slow change: only time shows one."""
    frames = np.concatenate([one_bone(0.3, 60, 0.0, 0), one_bone(0.4, 60, 0.0, 1)])
    with pytest.warns(UserWarning, match="bones stretch slowly"):
        fit_skeleton(frames, ARM)
    fit_skeleton(list(frames[:, None]), ARM)  # warnings are errors here


def test_recordings_with_another_axis_up_are_turned():
    layout = replace(ARM, name="z")
    y_up = one_bone(0.3, 40, 0.0, 0)
    turned = Keypoints(y_up[..., [2, 0, 1]], ARM.names, 25, up="z")
    one = fit_skeleton([Keypoints(y_up, ARM.names, 25), turned], layout)
    np.testing.assert_allclose(one.rest_rotations, fit_skeleton(y_up, layout).rest_rotations, atol=1e-12)
    np.testing.assert_allclose(one.offsets, fit_skeleton(y_up, layout).offsets, atol=1e-12)


def test_errors_name_the_recording(recordings):
    layout = layouts["coco17"]
    with pytest.raises(ValueError, match=r"keypoints\[1\] have no point named 'nose'"):
        fit_skeleton([recordings[0], recordings[1].select(recordings[1].names[1:])], layout)
    with pytest.raises(ValueError, match=r"keypoints\[1\]: positions must have three coordinates"):
        fit_skeleton([moving(layout), np.zeros((5, 17, 4))], layout)
    with pytest.raises(ValueError, match="keypoints have no frames"):
        fit_skeleton([recordings[0][:0], recordings[1][:0]], layout)
    assert fit_skeleton([recordings[0], recordings[1][:0]], layout) == fit_skeleton(recordings[0], layout)


def test_keypoints_one_after_another(recordings):
    one = recordings[0]
    again = Keypoints.concatenate([one[:50], one[50:50], one[50:]])
    np.testing.assert_array_equal(again.positions, one.positions)
    np.testing.assert_array_equal(again.confidences, one.confidences)
    assert (again.names, again.frame_rate, again.up) == (one.names, 25, "y")
    shuffled = one.select(one.names[::-1])
    np.testing.assert_array_equal(Keypoints.concatenate([one, shuffled]).positions[len(one) :], one.positions)


def test_errors_for_keypoints_that_do_not_follow_each_other(recordings):
    one, other = recordings
    for parts, message in (
        ([], "at least one recording, got none"),
        ([one, other], r"recordings\[1\] has frame_rate 30, but recordings\[0\] 25: .*fit_skeleton takes"),
        ([one, replace(one, up="z")], r"recordings\[1\] has up 'z', but recordings\[0\] 'y': rotate"),
        ([one, one.select(one.names[1:])], r"recordings\[1\] has other points .* only one of them has 'nose'"),
    ):
        with pytest.raises(ValueError, match=message):
            Keypoints.concatenate(parts)
    with pytest.raises(TypeError, match="put them into a list"):
        Keypoints.concatenate(one)
    with pytest.raises(TypeError, match=r"recordings\[0\] must be Keypoints, got ndarray"):
        Keypoints.concatenate([one.positions])


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


@pytest.mark.parametrize("name", list(layouts))
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


def test_motions_of_symmetric_skeletons_are_mirrored_exactly():
    layout = layouts["kinect25"]
    keypoints = uneven(layout)
    skeleton = fit_skeleton(keypoints, layout, symmetric=True)
    motion = inverse_kinematics(keypoints, skeleton).to_motion()
    partner = {one: other for pair in layout.pairs for one, other in (pair, pair[::-1])}
    other = [skeleton.joint_names.index(partner.get(name, name)) for name in skeleton.joint_names]

    def world(one):
        root = Rotation.from_euler(one.root_axes, one.root_angles).as_matrix()
        return np.einsum("nij,nkj->nki", root, forward_kinematics(one.angles, skeleton)) + one.root_positions[:, None]

    image = motion.mirrored()
    np.testing.assert_allclose(world(image), world(motion)[:, other] * [-1, 1, 1], atol=1e-12)
    np.testing.assert_allclose(image.mirrored().angles, motion.angles, atol=1e-12)


def test_the_side_that_is_seen_more_counts_more():
    layout = layouts["h36m17"]
    keypoints = uneven(layout)
    confidences = keypoints.confidences.copy()
    confidences[50:, keypoints.names.index("right_wrist")] = 0.0
    seen = replace(keypoints, confidences=confidences)
    own, found = lengths(fit_skeleton(seen, layout)), lengths(fit_skeleton(seen, layout, symmetric=True))
    expected = 0.8 * own["left_wrist"] + 0.2 * own["right_wrist"]
    np.testing.assert_allclose(found["left_wrist"], expected, rtol=1e-9)


def test_sides_that_differ_much_are_named():
    layout = layouts["h36m17"]
    keypoints = layout.keypoints(moving(layout), 25)
    elbow, wrist = (keypoints.names.index(name) for name in ("left_elbow", "left_wrist"))
    positions = keypoints.positions.copy()
    positions[:, wrist] += 0.3 * (positions[:, wrist] - positions[:, elbow])
    with pytest.warns(
        UserWarning, match=r"differ in their lengths: left_wrist and right_wrist with 34\.5 and 26\.6 cm"
    ):
        fit_skeleton(replace(keypoints, positions=positions), layout, symmetric=True)
    fit_skeleton(replace(keypoints, positions=positions), layout)  # they may differ


def test_layouts_without_two_equal_sides_are_refused():
    with pytest.raises(ValueError, match="'arm' has no left and right by name"):
        fit_skeleton(one_bone(0.3, 20, 0.0, 0), ARM, symmetric=True)
    parents = {"hips": None, "left_hip": "hips", "right_hip": "hips", "left_knee": "left_hip", "right_knee": "hips"}
    alone = layouts["opencap_mocap55"]
    with pytest.raises(
        ValueError, match=r"'R_sh4', 'R_thigh5' have no partner .* layout\.without\(\['R_sh4', 'R_thigh5'"
    ):
        fit_skeleton(moving(alone, n=5), alone, symmetric=True)
    layout = Layout("uneven", list(parents), parents)
    with pytest.raises(ValueError, match="'left_knee' is attached to 'left_hip' and 'right_knee' to 'hips'"):
        fit_skeleton(np.zeros((5, 5, 3)), layout, symmetric=True)
    layout = replace(layout, parents=parents | {"right_knee": "right_hip"}, rigid=["left_knee"])
    with pytest.raises(ValueError, match="of 'left_knee' and 'right_knee' one is rigid"):
        fit_skeleton(np.zeros((5, 5, 3)), layout, symmetric=True)


def test_the_poses_of_a_symmetric_skeleton_are_a_motion():
    layout = layouts["coco17"]
    skeleton = fit_skeleton(uneven(layout), layout, symmetric=True)
    assert len(Motion(skeleton, np.zeros((3, skeleton.n_dofs)), 25).mirrored()) == 3
