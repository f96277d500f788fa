"""Robots against MuJoCo's own kinematics: positions and orientations of all bodies, derivatives, names, limits."""

import io
import sys
import warnings

import numpy as np
import pytest
import reference
from numpy.testing import assert_allclose, assert_array_equal

from skpose import Motion, forward_kinematics
from skpose.io import MocapFormatError
from skpose.robots import load_robot, motion_from_qpos, qpos_from_motion

mujoco = pytest.importorskip("mujoco")

from robot_files import ROBOTS, SCENE, TWO_FREE, compiled, link, mjcf, opened, random_qpos, root_of, urdf  # noqa: E402

TIGHT = 1e-13  # m, and of entries of matrices


@pytest.mark.parametrize("name", ROBOTS)
def test_bodies_are_where_mujoco_has_them(name):
    text, held = ROBOTS[name]
    robot, model = load_robot(opened(text), held=held), compiled(text)
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    root = root_of(model, robot)
    for _ in range(5):
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
    assert load_robot(io.StringIO(mjcf('<body name="a"><joint name="i"/></body>'))).limits is None


def test_includes_are_read(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "arm.xml").write_text(
        '<mujocoinclude><body name="a"><joint name="i"/></body></mujocoinclude>'
    )
    (tmp_path / "robot.xml").write_text(mjcf('<include file="parts/arm.xml"/>'))
    assert load_robot(str(tmp_path / "robot.xml")).dof_names == ("i",)
    (tmp_path / "parts" / "arm.xml").unlink()
    with pytest.raises(MocapFormatError, match=r"^robot\.xml: .*parts/arm.xml") as caught:
        load_robot(tmp_path / "robot.xml")
    assert caught.value.filename == str(tmp_path / "robot.xml")


def test_included_files_are_in_the_folder(tmp_path, monkeypatch):
    (tmp_path / "arm.xml").write_text('<mujocoinclude><body name="a"><joint name="i"/></body></mujocoinclude>')
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner" / "link.xml").symlink_to(tmp_path / "arm.xml")
    for file in ("../arm.xml", str(tmp_path / "arm.xml"), "link.xml"):
        (tmp_path / "inner" / "robot.xml").write_text(mjcf(f'<include file="{file}"/>'))
        with pytest.raises(MocapFormatError, match="in the folder"):
            load_robot(tmp_path / "inner" / "robot.xml")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(MocapFormatError, match="open file"):
        load_robot(io.StringIO(mjcf('<include file="arm.xml"/>')))
    (tmp_path / "self.xml").write_text(mjcf('<include file="self.xml"/>'))
    with pytest.raises(MocapFormatError, match="twice"):
        load_robot("self.xml")


def test_sizes_are_bounded():
    arm = '<body name="a"><joint name="i"/></body>'
    few = f'<replicate count="3"><replicate count="2">{arm}</replicate></replicate>'
    assert load_robot(io.StringIO(mjcf(few))).n_dofs == 6
    with pytest.raises(MocapFormatError, match="elements"):
        load_robot(io.StringIO(mjcf(few.replace('"3"', '"99999"'))))
    cloth = '<flexcomp name="f" type="grid" count="900 900 900" spacing="1 1 1" dim="3"/>'
    assert load_robot(io.StringIO(mjcf(f'<body name="b"><joint name="j"/>{cloth}</body>'))).dof_names == ("j",)


def test_errors_have_the_line_of_the_file():
    geoms = '<geom\n size="1"/><site name="s>"/>\n<camera name="c">\n</camera>'
    with pytest.raises(MocapFormatError, match=r"line\D+5"):
        load_robot(io.StringIO(mjcf(f'<body name="a">{geoms}\n<joint names="i"/></body>')))


def test_the_root_without_a_free_joint():
    robot = load_robot(io.StringIO(mjcf('<body name="a" pos="0 0 1"><joint name="i"/></body>')))
    assert robot.joint_names == ("a",)
    assert_array_equal(robot.offsets, [[0, 0, 1]])  # from the world
    assert load_robot(opened(ROBOTS["URDF"][0])).joint_names == ("thigh", "shank", "sole", "toe", "arm")
    assert load_robot(opened(ROBOTS["URDF that floats"][0])).joint_names == ("arm",)


def test_another_root():
    with pytest.warns(UserWarning, match=r"left out: 'table'.*'waist'"):
        robot = load_robot(io.StringIO(SCENE), root="torso")
    assert robot.joint_names == ("arm",)
    text, held = ROBOTS["held"]
    assert load_robot(opened(text), held=held).dof_names == ("yaw", "v", "bend")
    for root in ("tors", "world"):
        with pytest.raises(MocapFormatError, match="root"):
            load_robot(io.StringIO(SCENE), root=root)


def test_two_free_robots_need_a_root():
    with pytest.raises(MocapFormatError, match="root="):
        load_robot(io.StringIO(TWO_FREE))
    with pytest.warns(UserWarning, match="left out: 'a', 'arm'"):
        robot = load_robot(io.StringIO(TWO_FREE), root="b")
    motion = Motion(robot, [[0.5]], 30, up="z")
    with pytest.raises(MocapFormatError, match="held="):
        qpos_from_motion(motion, io.StringIO(TWO_FREE), root="b")
    other = {"a_joint": [1, 2, 3, 1, 0, 0, 0], "i": 0.25}
    qpos = qpos_from_motion(motion, io.StringIO(TWO_FREE), root="b", held=other)
    assert_array_equal(qpos, [[1, 2, 3, 1, 0, 0, 0, 0.25, 0, 0, 0, 1, 0, 0, 0, 0.5]])
    assert motion_from_qpos(qpos, io.StringIO(TWO_FREE), 30, root="b").root_name == "b"
    with pytest.raises(MocapFormatError, match="'a_joint' is held"):
        motion_from_qpos(qpos, io.StringIO(TWO_FREE), 30, root="b", held={"a_joint": [1, 2, 3, 0, 1, 0, 0]})


def test_objects_next_to_a_robot_are_left_out():
    box = '<body name="box"><freejoint name="floats"/><body name="lid"/></body>'
    with pytest.warns(UserWarning, match="left out: 'box', 'lid'"):
        robot = load_robot(opened(mjcf('<body name="arm" pos="0 0 1"><joint name="i"/></body>' + box)))
    assert robot.joint_names == ("arm",)


@pytest.mark.parametrize("held", [{"arms": 0}, {"w": [1, 2]}, {"w": 45}])
def test_wrong_held_values(held):
    text, whole = ROBOTS["held"]
    with pytest.raises(MocapFormatError, match="held"):
        load_robot(opened(text), held=whole | held)


@pytest.mark.parametrize("robot", ["urdf", "mjcf"])
def test_limits_in_the_wrong_order_warn(robot):
    texts = {
        "urdf": urdf(link("a", "base", "revolute").replace('lower="-1"', 'lower="3"')),
        "mjcf": mjcf('<body name="a"><joint name="a_joint" range="3 2"/><body name="b" pos="1 0 0"/></body>'),
    }
    with pytest.warns(UserWarning, match="wrong order.*'a_joint'"):
        assert load_robot(opened(texts[robot])).limits is None


def test_constraints_tendons_and_limits_that_are_not_kept():
    text = mjcf(
        '<body name="a"><joint name="i"/>'
        '<body name="b" pos="1 0 0"><joint name="j" type="ball" range="0 40"/></body></body>',
        "",
        '<tendon><fixed name="pull"><joint joint="i" coef="1"/></fixed></tendon>'
        '<equality><connect body1="a" body2="b" anchor="0 0 0"/></equality>',
    )
    with pytest.warns(UserWarning, match="'a and b'.*'pull'.*limits of ball joints.*'j'") as caught:
        load_robot(opened(text))
    assert (len(caught), caught[0].filename) == (1, __file__)
    mimic = '<mimic joint="left_joint" multiplier="-2" offset="0.1"/></joint>'
    text = urdf(link("left", "base", "revolute"), link("right", "base", "revolute").replace("</joint>", mimic))
    with pytest.warns(UserWarning, match="mimic joints.*right_joint"):
        assert load_robot(opened(text)).dof_names == ("left_joint", "right_joint")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<mujoco><worldbody><body></worldbody></mujoco>", "mismatched"),
        (mjcf('<body name="a"><freejoint/></body>'), "no joint that moves"),
        (mjcf('<body name="a" pos="nan 0 0"><joint name="i"/></body>'), "finite"),
        (urdf('<xacro:include filename="a"/>'), "xacro"),
        ("<html><body/></html>", "html"),
    ],
)
def test_damaged_files(text, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot.xml").write_text(text)
    with pytest.raises(MocapFormatError, match=rf"^robot\.xml(, line 1)?: .*{message}"):
        load_robot("robot.xml")
    assert [path.name for path in tmp_path.iterdir()] == ["robot.xml"]  # MuJoCo does not write a log


def test_mujoco_is_optional(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ImportError, match=r"skpose\[robot\]"):
        load_robot("robot.xml")


def test_meshes_are_not_needed():
    text = mjcf(
        '<body name="a"><freejoint/><geom type="mesh" mesh="m"/>'
        '<body name="b" pos="1 0 0"><joint name="i"/></body></body>',
        '<asset><mesh name="m" file="none.stl"/></asset>',
    )
    assert load_robot(opened(text)).dof_names == ("i",)


@pytest.mark.parametrize("robot", ["unitree_g1", "booster_t1", "engineai_pm01", "galaxea_r1pro"])
def test_robots_of_the_folder(robots_folder, robot):
    path = robots_folder / f"{robot}.xml"
    model = mujoco.MjModel.from_xml_path(str(path))
    qpos = np.stack([random_qpos(model, {}, np.random.default_rng(i)) for i in range(5)])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        motion = motion_from_qpos(qpos, path, 30)
    data, names = mujoco.MjData(model), motion.skeleton.joint_names
    bodies = [b for b in range(model.nbody) if model.body(b).name in names]
    root = min(bodies) - 1
    for row, found in zip(qpos, forward_kinematics(motion.angles, motion.skeleton), strict=True):
        data.qpos[:] = row
        mujoco.mj_kinematics(model, data)
        expected = (data.xpos[bodies] - data.xpos[root]) @ data.xmat[root].reshape(3, 3)
        at = [names.index(model.body(b).name) for b in bodies]
        assert_allclose(found[at], expected, rtol=0, atol=TIGHT)
