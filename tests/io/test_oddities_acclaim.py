"""Oddities of ASF and AMC files from many programs, one a test: read correctly, or refused with a remedy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from skpose import forward_kinematics
from skpose.io import MocapFormatError, load_amc

pytestmark = pytest.mark.filterwarnings("ignore:.*replaces the unit:UserWarning")  # scale=1, for round numbers

ASF = """:version 1.10
:units
  length 1
  angle deg
:root
  order TX TY TZ RX RY RZ
  axis XYZ
  position 0 0 0
  orientation 0 0 0
:bonedata
  begin
    id 1
    name hip
    direction 1 0 0
    length 2
    axis 0 0 0 XYZ
  end
  begin
    id 2
    name knee
    direction 0 0 1
    length 3
    axis 10 20 30 XYZ
    dof rx rz
    limits (-10 20)
           (-30 40)
  end
  begin
    id 3
    name toe
    direction 0 1 0
    length 1
    axis 0 0 90 XYZ
    dof ry
  end
:hierarchy
  begin
    root hip
    hip knee
    knee toe
  end
"""
AMC = """:FULLY-SPECIFIED
:DEGREES
1
root 1 2 3 10 20 30
knee 40 50
toe 60
2
root 4 5 6 11 21 31
knee 41 51
toe 61
"""


def changed(text, *changes):
    """Return the text with each (old, new) replaced once; all must be there."""
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text


@pytest.fixture
def load(tmp_path):
    def load(asf=ASF, amc=AMC, **options):
        (tmp_path / "a.asf").write_text(asf, newline="")
        (tmp_path / "a.amc").write_text(amc, newline="")
        return load_amc(tmp_path / "a.amc", tmp_path / "a.asf", **{"scale": 1, "frame_rate": 120} | options)

    return load


@pytest.fixture
def refused(load):
    def refused(asf=ASF, amc=AMC, **options):
        """Return the name of the file and the line of an error."""
        with pytest.raises(MocapFormatError) as caught:
            load(asf, amc, **options)
        return caught.value.filename.rsplit("/", 1)[-1], caught.value.line

    return refused


def same(one, other):
    assert one.skeleton == other.skeleton
    for name in ("angles", "root_positions", "root_angles"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_a_bone_without_dofs_is_rigid_and_numbers_are_assigned_by_name(load):
    """Extrinsic XYZ about the bone's own axes: R = C · M · C⁻¹ with M = Rz · Ry · Rx."""
    motion = load()
    assert motion.skeleton.dof_names == ("knee_rx", "knee_rz", "toe_ry")
    np.testing.assert_allclose(np.degrees(motion.angles), [[40, 50, 60], [41, 51, 61]])
    hip, knee, toe = forward_kinematics(motion.angles, motion.skeleton)[0]
    C = Rotation.from_euler("xyz", [10, 20, 30], degrees=True)
    R = C * Rotation.from_euler("xyz", [40, 0, 50], degrees=True) * C.inv()
    np.testing.assert_allclose(hip, [2, 0, 0])
    np.testing.assert_allclose(knee, hip + R.apply([0, 0, 3]), atol=1e-12)
    C = Rotation.from_euler("z", 90, degrees=True)
    R = R * C * Rotation.from_euler("y", 60, degrees=True) * C.inv()
    np.testing.assert_allclose(toe, knee + R.apply([0, 1, 0]), atol=1e-12)


FORCED = changed(AMC, (":DEGREES", ":FORCE-ALL-JOINTS-BE-3DOF\n:DEGREES"), ("50\ntoe 60", "50 7\ntoe 60 8 9"),
                 ("51\ntoe 61", "51 0\ntoe 61 0 0"))  # fmt: skip


def test_three_dofs_for_every_joint(load, refused):
    """A bone's own first, then the others in the order x, y, z, as in the program that writes such files."""
    motion = load(amc=FORCED)
    assert [bone.dofs for bone in motion.skeleton.bones] == ["", "xyz", "xyz"]
    np.testing.assert_allclose(np.degrees(motion.angles), [[40, 7, 50, 8, 60, 9], [41, 0, 51, 0, 61, 0]])
    plain = load()
    np.testing.assert_allclose(
        forward_kinematics(motion.angles[1:], motion.skeleton), forward_kinematics(plain.angles[1:], plain.skeleton)
    )
    np.testing.assert_allclose(np.degrees(motion.skeleton.limits[:3]), [[-10, 20], [-np.inf, np.inf], [-30, 40]])
    assert refused(amc=FORCED.replace("50 7", "50")) == ("a.amc", 6)


def test_the_unit_of_angles(load, refused):
    """Either file may state it, or both if they agree."""
    silent, no_head = changed(ASF, ("  angle deg\n", "")), changed(AMC, (":DEGREES\n", ""))
    for files in ((silent, AMC), (ASF, no_head), (silent, no_head)):
        same(load(*files), load())
    in_radians = changed(AMC, (":DEGREES", ":RADIANS"))
    motion = load(silent, in_radians)  # the ASF file's own axes and limits are in degrees, the default
    np.testing.assert_array_equal(motion.angles[0], [40, 50, 60])
    assert motion.skeleton == load().skeleton
    np.testing.assert_array_equal(load(changed(ASF, ("angle deg", "angle rad")), no_head).angles[0], [40, 50, 60])
    assert refused(ASF, in_radians) == ("a.amc", 2)


def test_the_unit_of_length(load, refused):
    """CMU's: one unit is 1/length inch."""
    asf = changed(ASF, ("length 1", "length 0.45"))
    np.testing.assert_allclose(load(asf, scale=None).skeleton.offsets[0], [2 / 0.45 * 0.0254, 0, 0])
    np.testing.assert_allclose(load(asf, scale=None).root_positions[0], np.array([1, 2, 3]) / 0.45 * 0.0254)
    with pytest.warns(UserWarning, match="scale=2"):
        np.testing.assert_allclose(load(asf, scale=2).skeleton.offsets[0], [4, 0, 0])
    missing = changed(ASF, ("  length 1\n", ""))
    assert load(missing).skeleton == load().skeleton
    assert refused(missing, scale=None) == ("a.asf", None)


def test_orders_of_axes_and_channels(load):
    reordered = changed(ASF, ("order TX TY TZ RX RY RZ", "order RZ TX RY TY RX TZ"), ("axis XYZ", "axis ZYX"))
    motion = load(reordered, changed(AMC, ("1 2 3 10 20 30", "30 1 20 2 10 3"), ("4 5 6 11 21 31", "31 4 21 5 11 6")))
    np.testing.assert_array_equal(motion.root_positions, load().root_positions)
    assert motion.root_axes == "zyx"
    np.testing.assert_array_equal(motion.root_angles, load().root_angles[:, ::-1])
    bone = load(changed(ASF, ("axis 10 20 30 XYZ", "axis 10 20 30 ZXY"))).skeleton.bones[1]
    assert bone.dofs == "zx"
    np.testing.assert_allclose(bone.rest_rotation, Rotation.from_euler("zxy", [30, 10, 20], degrees=True).as_matrix())
    np.testing.assert_allclose(np.degrees(bone.limits), [(-30, 40), (-10, 20)])


def test_position_and_orientation_of_the_root_are_added(load):
    asf = changed(ASF, ("position 0 0 0", "position 10 0 -1"), ("orientation 0 0 0", "orientation 90 0 -5"))
    motion = load(asf)
    np.testing.assert_array_equal(motion.root_positions, [[11, 2, 2], [14, 5, 5]])
    np.testing.assert_allclose(np.degrees(motion.root_angles), [[100, 20, 25], [101, 21, 26]])
    assert motion.skeleton == load().skeleton


@pytest.mark.parametrize(
    "written",
    [
        "limits (-10 20)\n(-30 40)",
        "limits (-10 20) (-30 40)",
        "limits\n(-10 20)\n\n(-30 40)",
        "limits ( -10 20 )\n -30 40",
    ],
)
def test_layouts_of_limits(written, load):
    same(load(changed(ASF, ("limits (-10 20)\n           (-30 40)", written))), load())


def test_a_frame_without_a_bone(load, refused):
    amc = changed(AMC, ("knee 41 51\n", ""))
    assert refused(amc=amc) == ("a.amc", 9)  # where the frame ends
    np.testing.assert_allclose(np.degrees(load(amc=amc, missing="rest").angles), [[40, 50, 60], [0, 0, 61]])
    no_root = load(amc=changed(AMC, ("root 4 5 6 11 21 31\n", "")), missing="rest")
    np.testing.assert_array_equal(no_root.root_positions, [[1, 2, 3], [0, 0, 0]])


def test_frames_with_nan(load, refused):
    amc = changed(AMC, ("knee 40 50", "knee nan 50"))
    assert refused(amc=amc) == ("a.amc", 5)
    with pytest.warns(UserWarning, match=r"a\.amc: 1 of 2 frames have a number that is NaN or infinite"):
        np.testing.assert_array_equal(load(amc=amc, on_nan="drop").angles, load().angles[1:])


RIGID = changed(AMC, ("knee 40", "hip 0 0.0 -0\nknee 40"), ("toe 61", "toe 61\nhip 0e5"))  # as some programs write


def test_rigid_bones_may_be_listed_with_zeros(load, refused):
    """In any number, also in some frames only, and with three dofs for every joint that has any."""
    same(load(amc=RIGID), load())
    same(load(amc=changed(RIGID, ("hip 0e5", ""))), load())
    same(load(amc=changed(RIGID, ("hip 0 0.0 -0", "hip"))), load())
    forced = changed(FORCED, ("knee 40", "hip 0 0 0\nknee 40"), ("knee 41", "hip 0 0 0\nknee 41"))
    same(load(amc=forced), load(amc=FORCED))
