"""Joint angles of mirrored motions are those of the other side: exactly, if the skeleton is mirrored too."""

from dataclasses import replace

import numpy as np
import pytest

from skpose import Bone, Motion, Skeleton, forward_kinematics
from skpose.biomechanics import joint_angles
from skpose.datasets import humanoid

ACROSS = np.array([-1.0, 1.0, 1.0])
CHANGES_SIGN = "pelvis_list", "pelvis_rotation", "trunk_bending", "trunk_rotation", "neck_bending", "neck_rotation"


def partner_of(name, names):
    """The joint or the angle of the other side, itself in the middle."""
    words = {"left": "right", "right": "left"}
    other = "_".join(words.get(word, word) for word in name.split("_"))
    if other == name and {"l": "r", "r": "l"}.get(name[0], "") + name[1:] in names:
        other = {"l": "r", "r": "l"}[name[0]] + name[1:]
    return other


def signs_of(axes):
    """What the mirror across x makes of angles about axes, the last letters of names: an axis along x turns around."""
    return np.array([1.0 if axis[-1] == "x" else -1.0 for axis in axes])


def mirror_image(motion):
    """The motion in the mirror across x, and its skeleton, without the library."""
    skeleton, mirror = motion.skeleton, np.diag(ACROSS)
    names, bones, columns = list(skeleton.joint_names), [], []
    for bone in skeleton.bones:
        other = skeleton.bones[names.index(partner_of(bone.name, names))]
        rest = None if other.rest_rotation is None else mirror @ np.array(other.rest_rotation) @ mirror
        bones.append(Bone(bone.name, bone.parent, ACROSS * other.offset, other.dofs, rest))
        columns += [skeleton.dof_names.index(name) for name in other.dof_names]
    image = Skeleton(bones, offset_frame=skeleton.offset_frame)
    return replace(
        motion,
        skeleton=image,
        angles=motion.angles[:, columns] * signs_of(image.dof_names),
        root_positions=motion.root_positions * ACROSS,
        root_angles=motion.root_angles * signs_of(motion.root_axes.lower()),
    )


def assert_exchanged(motion, other, atol):
    one, two = joint_angles(motion), joint_angles(other)
    for name in one.names:
        sign = -1.0 if name in CHANGES_SIGN else 1.0
        expected = sign * one[name]
        np.testing.assert_allclose(two[partner_of(name, one.names)], expected, atol=atol, err_msg=name)


def random_motion(skeleton):
    rng = np.random.default_rng(0)
    waves = rng.uniform(0, 6, skeleton.n_dofs) + rng.uniform(0.1, 0.3, skeleton.n_dofs) * np.arange(40)[:, None]
    root = rng.normal(scale=0.2, size=(2, 40, 3))
    return Motion(skeleton, 0.4 * np.sin(waves), 30.0, root_positions=root[0], root_angles=root[1])


def test_a_symmetric_skeleton_is_its_own_mirror_image():
    motion = random_motion(humanoid())
    assert_exchanged(motion, motion.mirrored(), 1e-9)


def test_an_image_of_any_skeleton_has_the_angles_of_the_other_side():
    person, rng = humanoid(), np.random.default_rng(1)
    bones = [bone._replace(offset=bone.offset + rng.normal(scale=0.01, size=3)) for bone in person.bones]
    motion = random_motion(Skeleton(bones, offset_frame=person.offset_frame))
    image = mirror_image(motion)
    names = motion.skeleton.joint_names
    others = [names.index(partner_of(name, names)) for name in names]
    here, there = (forward_kinematics(one.angles, one.skeleton) for one in (motion, image))
    np.testing.assert_allclose(there, ACROSS * here[:, others], atol=1e-12)
    assert_exchanged(motion, image, 1e-9)
    with pytest.raises(AssertionError):  # `Motion.mirrored` keeps the skeleton: another motion
        assert_exchanged(motion, motion.mirrored(), 1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("k", [0, 12, 20])
def test_recordings(cmu, k):
    """`Motion.mirrored` keeps the skeleton, whose left and right bones do not point in quite mirrored directions."""
    motion = cmu[k]
    assert_exchanged(motion, mirror_image(motion), 1e-9)
    assert_exchanged(motion, motion.mirrored(), 1e-4)


@pytest.mark.slow
def test_mirrored_recordings_agree_as_the_directions_at_rest_do(cmu, hdm05):
    """The numbers of docs/biomechanics.md: subject 03's arms are no mirror images, nor are forearms of HDM05."""
    for dataset, most, odd_most in ((cmu, 3e-4, {"shoulder_plane": 1.3}), (hdm05, 0.002, {})):
        for motion, subject in zip(dataset, dataset.subjects, strict=True):
            one, two = joint_angles(motion), joint_angles(motion.mirrored())
            for name in one.names:
                off = np.abs(two[partner_of(name, one.names)] * (-1.0 if name in CHANGES_SIGN else 1.0) - one[name])
                off = np.minimum(off, np.abs(360.0 - off))
                stem = name.rpartition("_")[0]
                limit = most
                if dataset is cmu and subject == "03":
                    limit = odd_most.get(stem, 0.08)
                elif dataset is hdm05 and stem.startswith(("elbow", "wrist")):
                    limit = 0.5
                assert np.nanmax(off, initial=0.0) < limit, (subject, name)
