"""Robots against MuJoCo's own kinematics: positions and orientations of all bodies, derivatives, names, limits."""

import io
import re
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
import reference
from numpy.testing import assert_allclose, assert_array_equal

from skpose import Motion, forward_kinematics, pose_distances, position_jacobian
from skpose._cli.main import main
from skpose.io import (
    MocapFormatError,
    file_format,
    load_bvh,
    load_motion,
    load_robot,
    motion_from_qpos,
    qpos_from_motion,
)

mujoco = pytest.importorskip("mujoco")

from robots import BALL, FREE, ROBOTS, SCENE, TWO_FREE, compiled, link, mjcf, opened, random_qpos, root_of, urdf  # noqa: E402

TIGHT = 1e-13  # m, and of entries of matrices


def right_jacobian(vector):
    """Return the angular velocity in the rotated axes per change of a rotation vector."""
    angle = np.linalg.norm(vector)
    x, y, z = vector
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) - (1 - np.cos(angle)) / angle**2 * K + (angle - np.sin(angle)) / angle**3 * K @ K


@pytest.mark.parametrize("name", ROBOTS)
def test_bodies_are_where_mujoco_has_them(name):
    text, held = ROBOTS[name]
    robot, model = load_robot(opened(text), held=held), compiled(text)
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    root = root_of(model, robot)
    for _ in range(20):
        qpos = random_qpos(model, held, rng)
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        motion = motion_from_qpos([qpos], opened(text), 30, held=held)
        assert motion.skeleton == robot
        to_root = data.xmat[root].reshape(3, 3)
        (positions,) = forward_kinematics(motion.angles, robot)
        orientations, slow = reference.orientations_and_positions(motion.angles, robot)
        assert_allclose(positions, slow[0], rtol=0, atol=TIGHT)
        bodies = [b for b in range(model.nbody) if b != root and model.body(b).name in robot.joint_names]
        assert len(bodies) == model.nbody - root - 1
        for body in bodies:
            at = robot.joint_names.index(model.body(body).name)
            expected = to_root.T @ (data.xpos[body] - data.xpos[root])
            assert_allclose(positions[at], expected, rtol=0, atol=TIGHT)
            turned = to_root.T @ data.xmat[body].reshape(3, 3)
            assert_allclose(orientations[at].as_matrix()[0], turned, rtol=0, atol=TIGHT)
        # And back, to the same numbers, quaternions but for the sign.
        assert_allclose(data.qpos, qpos)
        again = qpos_from_motion(motion, opened(text), held=held)[0]
        data.qpos[:] = again
        before = data.xpos.copy(), data.xmat.copy()
        mujoco.mj_kinematics(model, data)
        assert_allclose(data.xpos, before[0], rtol=0, atol=TIGHT * 10)
        assert_allclose(data.xmat, before[1], rtol=0, atol=TIGHT * 10)


@pytest.mark.parametrize("name", ROBOTS)
def test_jacobians_are_those_of_mujoco(name):
    text, held = ROBOTS[name]
    robot, model = load_robot(opened(text), held=held), compiled(text)
    data, rng = mujoco.MjData(model), np.random.default_rng(1)
    root = root_of(model, robot)
    data.qpos[:] = random_qpos(model, held, rng)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    motion = motion_from_qpos([data.qpos], opened(text), 30, held=held)
    J = position_jacobian(motion.angles, robot)[0].reshape(robot.n_joints, 3, robot.n_dofs)
    to_root = data.xmat[root].reshape(3, 3).T
    for body in range(root + 1, model.nbody):
        jacobian = np.zeros((3, model.nv))
        mujoco.mj_jacBody(model, data, jacobian, None, body)
        expected, column = [], 0
        for i in range(model.njnt):
            if model.jnt_type[i] == FREE or model.joint(i).name in held:
                continue
            at = model.jnt_dofadr[i]
            if model.jnt_type[i] == BALL:
                vector = motion.angles[0, column : column + 3]
                expected.append(to_root @ jacobian[:, at : at + 3] @ right_jacobian(vector))
                column += 3
            else:
                expected.append(to_root @ jacobian[:, [at]])
                column += 1
        at = robot.joint_names.index(model.body(body).name)
        assert_allclose(J[at], np.concatenate(expected, axis=1), rtol=0, atol=TIGHT * 10)


def test_columns_are_the_joints_in_the_order_of_qpos():
    text, held = ROBOTS["several joints in a link"]
    robot = load_robot(opened(text), held=held)
    assert robot.dof_names == ("a", "b", "c", "d")
    assert robot.joint_names == ("a_anchor", "b_anchor", "arm", "hand")
    assert robot.offset_frame == "parent"
    assert_array_equal(robot.offsets, [[0.1, 0.2, 0.3], [0, 0, 0], [0, 0, 0], [0.3, 0, 0]])
    assert_array_equal(robot.weights, [1, 0, 0, 1])  # joints in one place count once


def test_a_joint_at_another_point_has_a_bone_to_it_and_back():
    robot = load_robot(
        io.StringIO(mjcf('<body name="a" pos="0 0 1"><joint name="j" pos="0 0 0.2" axis="0 1 0"/></body>'))
    )
    assert robot.joint_names == ("j_anchor", "a")
    assert_array_equal(robot.offsets, [[0, 0, 1.2], [0, 0, -0.2]])
    assert robot["j_anchor"].dof_name == "j"
    assert robot["a"].dofs == ""


def test_limits_are_those_of_joints_that_have_any():
    robot = load_robot(
        io.StringIO(
            mjcf(
                '<body name="a"><joint name="i" range="-90 45" ref="30"/><joint name="j" axis="1 0 0"/>'
                '<joint name="k" range="-10 10" limited="false" axis="0 1 0"/></body>'
            )
        )
    )
    assert_allclose(robot.limits, [[-np.pi / 2, np.pi / 4], [-np.inf, np.inf], [-np.inf, np.inf]])
    explicit = mjcf(
        '<body name="a"><joint name="i" range="-1 2" limited="true"/><joint name="j" axis="1 0 0"/></body>',
        '<compiler autolimits="false" angle="radian"/>',
    )
    assert_allclose(load_robot(io.StringIO(explicit)).limits, [[-1, 2], [-np.inf, np.inf]])
    continuous = urdf(link("a", "base", "continuous"), link("b", "a", "revolute"))
    assert_allclose(load_robot(opened(continuous)).limits, [[-np.inf, np.inf], [-1, 2]])
    assert load_robot(io.StringIO(mjcf('<body name="a"><joint name="i"/></body>'))).limits is None


def test_limits_that_are_none_are_a_warning():
    text = urdf(link("a", "base", "revolute").replace('lower="-1"', 'lower="3"'))
    with pytest.warns(UserWarning, match=r"limits in the wrong order are none: 'a_joint' from 3 to 2"):
        assert load_robot(opened(text)).limits is None
    text = urdf(link("a", "base", "revolute").replace('lower="-1"', 'lower="2"'))
    with pytest.warns(UserWarning, match="'a_joint' has equal lower and upper limits, limit ignored"):
        assert load_robot(opened(text)).limits is None
    text = mjcf('<body name="a"><joint name="s" type="ball" range="0 40"/><body name="b" pos="1 0 0"/></body>')
    with pytest.warns(UserWarning, match="limits of ball joints are not kept: 's'"):
        assert load_robot(opened(text)).limits is None


def test_ball_joints_have_the_columns_of_bones():
    text = mjcf('<body name="a"><joint name="s" type="ball"/><body name="b" pos="1 0 0"/></body>')
    robot = load_robot(opened(text))
    assert robot.dof_names == ("a_rotvec_x", "a_rotvec_y", "a_rotvec_z")


def test_what_has_no_name_gets_one():
    text = mjcf(
        '<body><joint/><joint axis="0 1 0"/><body name="body_3"><joint axis="1 0 0"/><body pos="1 0 0"/></body></body>'
    )
    robot = load_robot(opened(text))
    assert robot.dof_names == ("body_1_joint", "body_1_joint_", "body_3_joint")
    assert robot.joint_names == ("body_1_joint_anchor", "body_1", "body_3", "body_3_")


def test_quarter_turns_are_exact():
    text = mjcf('<body name="a" euler="90 0 0"><joint name="i"/><body name="b" quat="0.707107 0 0.707107 0"/></body>')
    robot = load_robot(opened(text))
    assert_array_equal(robot.rest_rotations[0], [[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    assert_array_equal(robot.rest_rotations[1], [[0, 0, 1], [0, 1, 0], [-1, 0, 0]])


def test_the_root_is_the_body_with_the_free_joint():
    with pytest.warns(
        UserWarning, match="links that 'pelvis' does not carry are left out: 'table', 'drawer', 'target'"
    ):
        robot = load_robot(io.StringIO(SCENE))
    assert robot.joint_names == ("torso", "arm", "leg")
    assert robot.dof_names == ("waist", "shoulder", "hip")


def test_another_root():
    with pytest.warns(UserWarning, match="left out: 'table', .*; joints that carry 'torso' move the root .*: 'waist'"):
        robot = load_robot(io.StringIO(SCENE), root="torso")
    assert robot.joint_names == ("arm",)
    with pytest.raises(MocapFormatError, match="root='tors' is no link of this file: did you mean 'torso'"):
        load_robot(io.StringIO(SCENE), root="tors")
    with pytest.raises(MocapFormatError, match=r"root='world' carries 'pelvis', which moves freely.*root='pelvis'"):
        load_robot(io.StringIO(SCENE), root="world")


def test_two_free_robots_need_a_root():
    with pytest.raises(MocapFormatError, match=r"2 links with joints move freely, 'a', 'b', .*: choose it, root='a'"):
        load_robot(io.StringIO(TWO_FREE))
    with pytest.warns(UserWarning, match="'b' does not carry are left out: 'a', 'arm'"):
        robot = load_robot(io.StringIO(TWO_FREE), root="b")
    motion = Motion(robot, [[0.5]], 30, up="z")
    expected = (
        r"qpos has numbers of 'a_joint', 'i', .* held=.'a_joint': .0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0., 'i': 0.0.$"
    )
    with pytest.raises(MocapFormatError, match=expected):
        qpos_from_motion(motion, io.StringIO(TWO_FREE), root="b")
    other = {"a_joint": [1, 2, 3, 1, 0, 0, 0], "i": 0.25}
    qpos = qpos_from_motion(motion, io.StringIO(TWO_FREE), root="b", held=other)
    assert_array_equal(qpos, [[1, 2, 3, 1, 0, 0, 0, 0.25, 0, 0, 0, 1, 0, 0, 0, 0.5]])
    assert motion_from_qpos(qpos, io.StringIO(TWO_FREE), 30, root="b").root_name == "b"
    with pytest.raises(MocapFormatError, match="joint 'a_joint' is held at"):
        motion_from_qpos(qpos, io.StringIO(TWO_FREE), 30, root="b", held={"a_joint": [1, 2, 3, 0, 1, 0, 0]})
    with pytest.raises(
        MocapFormatError, match=r"held\['a_joint'\] must be seven numbers, the position, m, and the quat"
    ):
        load_robot(io.StringIO(TWO_FREE), root="b", held={"a_joint": 0})


def test_objects_next_to_a_robot_are_no_part_of_it():
    box = '<body name="box"><freejoint name="floats"/><body name="lid"/></body>'
    text = mjcf('<body name="arm" pos="0 0 1"><joint name="i"/></body>' + box)
    for root in (None, "world"):
        with pytest.warns(
            UserWarning, match=r"links that are no part of it \(objects, mocap\) are left out: 'box', 'lid'"
        ):
            robot = load_robot(opened(text), root=root)
        assert robot.joint_names == ("arm",)
    text = mjcf(box + '<body name="base"><freejoint/><body name="arm"><joint name="i"/></body></body>')
    with pytest.warns(UserWarning, match="'base' does not carry are left out: 'box', 'lid'"):
        assert load_robot(opened(text)).joint_names == ("arm",)


def test_without_a_free_joint_the_root_is_the_world_and_that_of_urdf_its_first_link():
    robot = load_robot(io.StringIO(mjcf('<body name="a" pos="0 0 1"><joint name="i"/></body>')))
    assert robot.joint_names == ("a",)
    assert_array_equal(robot.offsets, [[0, 0, 1]])
    assert load_robot(opened(ROBOTS["URDF"][0])).joint_names == ("thigh", "shank", "sole", "toe", "arm")
    assert load_robot(opened(ROBOTS["URDF with a link world"][0])).joint_names == ("base", "arm")
    assert load_robot(opened(ROBOTS["URDF that floats"][0])).joint_names == ("arm",)


def test_bodies_that_a_program_moves_are_no_part_of_a_robot():
    target = '<body name="target" mocap="true" pos="0 0 1"><body name="flag" pos="0 0 1"/></body>'
    text = mjcf('<body name="arm" pos="0 0 1"><joint name="i"/></body>' + target)
    with pytest.warns(UserWarning, match="are left out: 'target', 'flag'"):
        assert load_robot(opened(text)).joint_names == ("arm",)


def test_slides_are_columns():
    robot = load_robot(opened(ROBOTS["slides"][0]))
    assert robot.dof_names[:4] == ("x", "y", "yaw", "lift")
    assert robot.dof_names[-2:] == ("grip", "bend")
    assert robot["grip_anchor"].is_slide
    assert_array_equal(robot["grip_anchor"].limits, [[0.0, 0.04]])  # m
    with pytest.raises(ValueError, match="all columns, in rad, but x, y, lift and 1 more are in m"):
        pose_distances(np.zeros((2, robot.n_dofs)), skeleton=robot, metric="angle")


def test_joints_that_carry_the_root_move_it():
    text, held = ROBOTS["held"]
    assert load_robot(opened(text), held=held).dof_names == ("yaw", "v", "bend")
    with pytest.warns(UserWarning, match="joints that carry 'base' move the root and are no columns: 'x', 'y', 'yaw'"):
        assert load_robot(opened(text), root="base", held={"grip": 0}).dof_names[0] == "s_anchor_rotvec_x"


@pytest.mark.parametrize(
    ("held", "message"),
    [
        ({"arms": 0}, r"held\['arms'\] is no joint of this file: "),
        ({"w": [1, 2]}, r"held\['w'\] must be a number, rad, got \[1, 2\]"),
        ({"w": "1.5 rad"}, r"held\['w'\] must be a number, rad, got '1.5 rad'"),
        ({"w": np.nan}, r"held\['w'\] must be a number, rad, got nan"),
        ({"w": 45}, r"held\['w'\] must be a number, rad, within its limits, -1.5708 to 1.5708, got 45"),
        ({"x": [1]}, r"held\['x'\] must be a number, m, got \[1\]"),
        ({"s": 1.0}, r"held\['s'\] must be a rotation vector, rad, got 1.0"),
    ],
)
def test_errors_of_held(held, message):
    text, whole = ROBOTS["held"]
    with pytest.raises(MocapFormatError, match=message):
        load_robot(opened(text), held={**whole, **held})


def test_held_is_a_mapping():
    with pytest.raises(TypeError, match="held must be a mapping of joints to values, got list"):
        load_robot(opened(ROBOTS["held"][0]), held=["x"])


def test_files_that_are_missing_are_no_error(tmp_path):
    text = mjcf(
        '<body name="a"><freejoint/><geom type="mesh" mesh="m" material="k"/><geom class="v" mesh="n"/>'
        '<body name="b" pos="1 0 0"><joint name="i"/><geom type="hfield" hfield="h"/></body></body>',
        '<compiler meshdir="assets" texturedir="assets"/><default><default class="v"><geom type="mesh"/></default>'
        '</default><asset><mesh name="m" file="none.stl"/><mesh name="n" file="none.obj" scale="1 1 1"/>'
        '<texture name="t" type="2d" file="none.png"/><material name="k" texture="t"/>'
        '<hfield name="h" file="none.png" size="1 1 1 1"/></asset>',
        '<deformable><skin name="s" file="none.skn"/></deformable>',
    )
    (tmp_path / "robot.xml").write_text(text)
    assert load_robot(tmp_path / "robot.xml").dof_names == ("i",)
    mesh = '<visual><geometry><mesh filename="package://robot_description/meshes/a.dae"/></geometry></visual>'
    mesh += (
        '<collision><geometry><mesh filename="file:///none/a.stl" scale="0.001 0.001 0.001"/></geometry></collision>'
    )
    assert load_robot(opened(urdf(link("a", "base", "revolute", inside=mesh)))).joint_names == ("a",)


def test_masses_and_motors_play_no_part():
    text = mjcf(
        '<body name="a"><inertial pos="0 0 1" mass="1" fullinertia="1 1 9 0 0 0"/><joint name="i"/><site name="s"/>'
        '<body name="b" pos="1 0 0"><joint name="j"/><camera/><light/></body></body>',
        '<compiler settotalmass="10" balanceinertia="false" boundmass="0" inertiafromgeom="true"/><size memory="100"/>',
        '<actuator><motor joint="i"/></actuator><sensor><jointpos joint="i"/><framepos objtype="site" objname="s"/>'
        '</sensor><keyframe><key qpos="0 1" ctrl="1"/></keyframe><contact><exclude body1="a" body2="b"/></contact>'
        '<custom><numeric name="n" data="1"/><text name="t" data="x"/><tuple name="u"><element objtype="site" '
        'objname="s"/></tuple></custom>',
    )
    with pytest.raises(ValueError, match="inertia"):
        mujoco.MjModel.from_xml_string(text)
    assert load_robot(opened(text)).dof_names == ("i", "j")
    heavy = '<inertial><mass value="-1"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'
    assert load_robot(opened(urdf(link("a", "base", "revolute", inside=heavy)))).joint_names == ("a",)


def test_constraints_and_tendons_are_named():
    text = mjcf(
        '<body name="a"><joint name="i"/><site name="s"/><body name="b" pos="1 0 0"><site name="t"/><joint name="j"/>'
        "</body></body>",
        "",
        '<tendon><fixed name="pull"><joint joint="i" coef="1"/></fixed><spatial><site site="s"/><site site="t"/>'
        '</spatial></tendon><equality><connect body1="a" body2="b" anchor="0 0 0"/><weld name="w" body1="a"/>'
        '<joint joint1="i" joint2="j"/><joint joint1="i" active="false"/></equality>'
        '<actuator><position tendon="pull"/></actuator>',
    )
    expected = (
        "equality constraints are not kept, and poses may break them: connect of a and b, w (weld of a and world), "
        "joint of i and j; tendons are not kept: 'pull', one without a name"
    )
    with pytest.warns(UserWarning, match=re.escape(expected)) as caught:
        load_robot(opened(text))
    assert len(caught) == 1
    assert caught[0].filename == __file__
    with pytest.warns(UserWarning, match=f"the model: {re.escape(expected)}"):
        load_robot(compiled(text))


def test_a_comment_about_a_template_is_none():
    text = urdf("<!-- <xacro:include filename='a'/> made this -->", link("a", "base", "revolute"))
    assert load_robot(opened(text)).joint_names == ("a",)


def test_mimic_joints_have_columns_and_a_warning():
    mimic = '<mimic joint="left_joint" multiplier="-2" offset="0.1"/></joint>'
    text = urdf(link("left", "base", "revolute"), link("right", "base", "revolute").replace("</joint>", mimic))
    with pytest.warns(UserWarning, match=r"columns of their own.*: right_joint = -2 left_joint \+ 0.1$"):
        assert load_robot(opened(text)).dof_names == ("left_joint", "right_joint")


def test_includes_are_read(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "arm.xml").write_text(
        '<mujocoinclude><body name="a"><joint name="i"/></body></mujocoinclude>'
    )
    (tmp_path / "robot.xml").write_text(mjcf('<include file="parts/arm.xml"/>'))
    assert load_robot(str(tmp_path / "robot.xml")).dof_names == ("i",)
    with pytest.raises(
        MocapFormatError, match=r"^arm\.xml: this is a part of a robot \(MJCF\) that another file includes"
    ):
        load_robot(tmp_path / "parts" / "arm.xml")
    (tmp_path / "parts" / "arm.xml").unlink()
    with pytest.raises(MocapFormatError, match=r"^robot\.xml: MuJoCo cannot read this file: .*parts/arm.xml") as caught:
        load_robot(tmp_path / "robot.xml")
    assert caught.value.filename == str(tmp_path / "robot.xml")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<mujoco><worldbody><body></worldbody></mujoco>", "MuJoCo cannot read this file: .*MISMATCHED"),
        (mjcf('<body name="a" foo="1"/>'), "MuJoCo cannot read this file: .*unrecognized attribute: 'foo'"),
        (mjcf('<body name="a"><joint name="i" axis="0 0 0"/></body>'), "axis too small"),
        (mjcf('<body name="a"><joint name="i"/></body>' * 2), "repeated name"),
        (mjcf('<body name="a"/>'), "'world' carries no joint that moves, and a skeleton needs one"),
        (mjcf('<body name="a"><freejoint/></body>'), "'world' carries no joint that moves, and a skeleton needs one"),
        (
            mjcf('<body name="a" pos="nan 0 0"><joint name="i"/></body>'),
            "link 'a': its place has numbers that are not fin",
        ),
        (mjcf('<body name="a"><joint name="i" pos="nan 0 0"/></body>'), "link 'a': a joint has numbers that are not"),
        (urdf(link("a", "nothing", "revolute")), "MuJoCo cannot read this file"),
        (urdf('<xacro:include filename="a"/>'), "a template of a URDF .xacro.: expand it first, with xacro FILE"),
        ('<sdf version="1.6"/>', "a file of Gazebo"),
        ("<OpenSimDocument/>", "a model of OpenSim, .*load_trc"),
        (
            "<html><body/></html>",
            "expected a robot, <mujoco> .MJCF. or <robot> .URDF. as the first element, found <html>",
        ),
        ("HIERARCHY\nROOT a", "expected a robot, .* found 'HIERARCHY ROOT a'"),
        ("version https://git-lfs.github.com/spec/v1\n", "Git LFS"),
        ("", "expected a robot, .* found ''"),
        ("<!-- a -->" * 5000, "expected a robot"),
    ],
)
def test_errors(text, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(MocapFormatError, match=message):
        load_robot(opened(text))
    Path("robot.xml").write_text(text)
    with pytest.raises(MocapFormatError, match=rf"^robot\.xml: .*{message}"):
        load_robot("robot.xml")
    assert [path.name for path in tmp_path.iterdir()] == ["robot.xml"]  # MuJoCo writes no log


def test_errors_of_paths(tmp_path):
    with pytest.raises(FileNotFoundError):
        load_robot(tmp_path / "none.xml")
    with pytest.raises(TypeError, match=r"expected a path, an open file or a mujoco.MjModel, got int"):
        load_robot(3)
    with pytest.raises(MocapFormatError, match="decompress it first"):
        load_robot(io.BytesIO(b"\x1f\x8b\x08"))


def test_mujoco_prints_and_writes_nothing(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    before = mujoco.get_mju_user_warning()
    text = urdf(link("a", "base", "revolute").replace('lower="-1"', 'lower="2"'))
    with pytest.warns(UserWarning, match="equal lower and upper"):
        load_robot(opened(text))
    assert capfd.readouterr() == ("", "")
    assert not list(tmp_path.iterdir())
    assert mujoco.get_mju_user_warning() is before


def test_the_package_is_named_where_it_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ImportError, match=r"load_robot needs MuJoCo: pip install 'skpose\[robot\]'"):
        load_robot("robot.xml")
    motion = load_bvh(io.StringIO(BVH))
    with pytest.raises(ImportError, match="qpos_from_motion needs MuJoCo"):
        qpos_from_motion(motion, "robot.xml")


def test_versions_that_are_too_old(monkeypatch):
    monkeypatch.setattr(mujoco, "__version__", "3.9.1")
    with pytest.raises(
        ImportError, match=r"load_robot needs MuJoCo 3.10 or later, and 3.9.1 is installed: pip install"
    ):
        load_robot(io.StringIO(ROBOTS["free root"][0]))
    monkeypatch.setattr(mujoco, "__version__", "3.10.0")
    assert load_robot(io.StringIO(ROBOTS["free root"][0])).n_dofs == 2
    with pytest.raises(ImportError, match=r"load_robot of a URDF file needs MuJoCo 4.0 or later, and 3.10.0 is"):
        load_robot(io.StringIO(ROBOTS["URDF"][0]))


BVH = """HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\nJOINT b\n{\nOFFSET 0 1 0
CHANNELS 1 Xrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\n}\nMOTION\nFrames: 1\nFrame Time: 0.1\n0 0 0 0\n"""


def test_a_compiled_model_is_a_robot():
    for name in ("free root", "points of joints", "random 3"):
        text, held = ROBOTS[name]
        assert load_robot(compiled(text), held=held) == load_robot(opened(text), held=held)


@pytest.mark.parametrize("read", [load_motion, load_bvh, file_format])
def test_readers_of_motions_name_the_reader_of_robots(read, tmp_path):
    for name, kind in (("free root", "MJCF"), ("URDF", "URDF")):
        (tmp_path / "robot").write_text(ROBOTS[name][0])
        with pytest.raises(MocapFormatError, match=rf"this is a robot \({kind}\), which load_robot reads, not a"):
            read(tmp_path / "robot")


def test_info_prints_a_robot(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("robot.xml").write_text(ROBOTS["free root"][0])
    assert main(["info", "robot.xml"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "2 joints besides the root, 2 degrees of freedom",
        "",
        "joint   parent   bone, m  rotates about",
        "thigh   root       0.224  hinge (0, -1, 0) hip",
        "shank   thigh      0.412  hinge (0.577, 0.577, 0.577) knee",
    ]
    Path("lift.xml").write_text(ROBOTS["slides"][0])
    assert main(["info", "lift.xml"]) == 0
    assert "slide (0, 0.894, 0.447) y" in capsys.readouterr().out
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert main(["info", "robot.xml"]) == 1
    assert capsys.readouterr().err == "skpose: load_robot needs MuJoCo: pip install 'skpose[robot]'\n"


@pytest.mark.parametrize("robot", ["unitree_g1", "booster_t1", "engineai_pm01", "galaxea_r1pro"])
def test_robots_of_the_folder(robots_folder, robot):
    path = robots_folder / f"{robot}.xml"
    model = mujoco.MjModel.from_xml_path(str(path))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        skeleton = load_robot(path)
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    is_free = model.jnt_type[0] == FREE
    root = 1 if is_free else root_of(model, skeleton)
    limited = [model.joint(name) for name in skeleton.dof_names]
    limits = np.array([model.jnt_range[j.id] if model.jnt_limited[j.id] else (-np.inf, np.inf) for j in limited])
    assert_array_equal(skeleton.limits, limits)
    qpos = np.stack([random_qpos(model, {}, rng) for _ in range(50)])
    motion = motion_from_qpos(qpos, path, 30)
    positions = forward_kinematics(motion.angles, skeleton)
    names = [name for name in skeleton.joint_names if not name.endswith("_anchor")]
    bodies = [model.body(name).id for name in names]
    assert bodies == list(range(root + 1, model.nbody))
    for row, found in zip(qpos, positions, strict=True):
        data.qpos[:] = row
        mujoco.mj_kinematics(model, data)
        expected = (data.xpos[bodies] - data.xpos[root]) @ data.xmat[root].reshape(3, 3)
        assert_allclose(found[[skeleton.joint_names.index(name) for name in names]], expected, rtol=0, atol=TIGHT)
    again = qpos_from_motion(motion, path)
    again[:, 3:7] *= np.sign((again[:, 3:7] * qpos[:, 3:7]).sum(axis=1, keepdims=True)) if is_free else 1.0
    assert_allclose(again, qpos, rtol=0, atol=1e-12)
