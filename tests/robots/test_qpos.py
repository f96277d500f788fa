"""Motions of robots as MuJoCo's qpos and back, and as files."""

import io

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from skpose import Motion
from skpose.io import MocapFormatError
from skpose.robots import load_robot, motion_from_qpos, qpos_from_motion

mujoco = pytest.importorskip("mujoco")

from robot_files import ROBOTS, SCENE, compiled, opened, random_qpos  # noqa: E402


def moving(text, held=None, n=50, seed=0, **root):
    """Return a smooth motion of a robot."""
    robot = load_robot(opened(text), held=held)
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, n)[:, None]
    angles = np.sin(t * rng.uniform(1, 4, robot.n_dofs)) * rng.normal(size=robot.n_dofs)
    return Motion(robot, angles, 50, **root)


def test_quaternions_are_continuous():
    t = np.linspace(0, 4 * np.pi, 200)
    turning = np.stack([0.2 * np.sin(t), 0.1 * t, t], axis=1)
    text = ROBOTS["free root"][0]
    motion = moving(text, n=200, root_positions=turning, root_angles=turning, up="z")
    qpos = qpos_from_motion(motion, opened(text))
    assert qpos.shape == (200, 9)
    assert np.abs(np.diff(qpos, axis=0)).max() < 0.1
    assert qpos[0, 3] >= 0
    expected = Rotation.from_euler("xyz", turning).as_matrix()
    assert_allclose(Rotation.from_quat(qpos[:, [4, 5, 6, 3]]).as_matrix(), expected, atol=1e-12)


def test_motions_come_back_from_qpos():
    text = ROBOTS["free root"][0]
    motion = moving(text, root_positions=np.random.default_rng(1).normal(size=(50, 3)), up="z")
    again = motion_from_qpos(qpos_from_motion(motion, opened(text)), opened(text), 50)
    assert again.skeleton == motion.skeleton
    assert_array_equal(again.angles, motion.angles)
    assert_array_equal(again.root_positions, motion.root_positions)
    assert (again.up, again.root_name, again.frame_rate) == ("z", "pelvis", 50)
    none = motion_from_qpos(np.zeros((0, 9)), opened(text), 50)
    assert len(none) == 0
    assert qpos_from_motion(none, opened(text)).shape == (0, 9)


def test_the_root_is_where_the_body_is_in_the_world():
    """Also of a link that joints carry, which are no columns."""
    model = compiled(SCENE)
    data = mujoco.MjData(model)
    rng = np.random.default_rng(3)
    qpos = np.stack([random_qpos(model, {}, rng) for _ in range(5)])
    with pytest.raises(MocapFormatError, match="'waist' is held"):
        motion_from_qpos(qpos, io.StringIO(SCENE), 30, held={"waist": 0.5})
    motion = motion_from_qpos(qpos, io.StringIO(SCENE), 30, root="torso")
    orientations = Rotation.from_euler(motion.root_axes, motion.root_angles).as_matrix()
    for i, row in enumerate(qpos):
        data.qpos[:] = row
        mujoco.mj_kinematics(model, data)
        assert_allclose(motion.root_positions[i], data.body("torso").xpos, atol=1e-14)
        assert_allclose(orientations[i], data.body("torso").xmat.reshape(3, 3), atol=1e-14)
    with pytest.raises(MocapFormatError, match="'pull', 'floating', 'waist', 'hip'"):
        qpos_from_motion(motion, io.StringIO(SCENE), root="torso")


def test_worlds_with_another_axis_up_are_turned():
    text = ROBOTS["free root"][0]
    stands = Rotation.from_euler("x", [-90], degrees=True) * Rotation.from_euler("z", [40], degrees=True)
    angles = stands.as_euler("xyz").reshape(1, 3)
    motion = Motion(load_robot(opened(text)), [[0.1, 0.2]], 30, [[1, 2, 3]], angles, up="y")
    (qpos,) = qpos_from_motion(motion, opened(text))
    assert_allclose(qpos[:3], [1, -3, 2])
    assert_allclose(qpos[3:7], Rotation.from_euler("z", 40, degrees=True).as_quat()[[3, 0, 1, 2]], atol=1e-15)
    lying = Motion(motion.skeleton, motion.angles, 30)  # the default of up is y
    with pytest.warns(UserWarning, match='up="z"'):
        qpos_from_motion(lying, opened(text))


def test_a_motion_that_is_not_the_robots():
    text, held = ROBOTS["held"]
    motion = moving(text, held)
    with pytest.raises(MocapFormatError, match="skeleton"):
        qpos_from_motion(motion, opened(text))
    with pytest.raises(MocapFormatError, match="skeleton"):
        qpos_from_motion(motion, opened(text), held=held | {"y": 0.1})
    with pytest.raises(MocapFormatError, match="'root'"):
        qpos_from_motion(motion.with_root("whole"), opened(text), held=held)
    away = moving(text, held, root_positions=np.linspace(0, [1, 0, 0], 50))
    with pytest.raises(MocapFormatError, match="no free joint"):
        qpos_from_motion(away, opened(text), held=held)


def test_qpos_of_another_robot():
    free = ROBOTS["free root"][0]
    for qpos, message in (
        (np.zeros((3, 10)), "shape"),
        (np.zeros((3, 9)), "length one"),
        (np.full((3, 9), np.nan), "NaN"),
    ):
        with pytest.raises(ValueError, match=message):
            motion_from_qpos(qpos, io.StringIO(free), 30)


STANDING = """<mujoco><worldbody><body name="pelvis"><freejoint/>
  <body name="left_leg" pos="0 0.1 0"><joint name="left_hip" axis="0 1 0" range="-90 90"/>
    <body name="left_foot" pos="0 0 -0.7"/></body>
  <body name="right_leg" pos="0 -0.1 0"><joint name="right_hip" axis="0 1 0" range="-90 90"/>
    <body name="right_foot" pos="0 0 -0.7"/></body>
</body></worldbody></mujoco>"""


def walk_of_robot(heading, order):
    """Return qpos of a robot that leans by 5° and goes forward, and its orientations."""
    turns = Rotation.from_euler("ZY", [[heading + 10 * np.sin(t / 3), 5] for t in range(40)], degrees=True)
    positions = np.add(np.cumsum(0.05 * turns.apply([1.0, 0.0, 0.0]), axis=0), [0.0, 0.0, 0.7])
    numbers = turns.as_quat()[:, [3, 0, 1, 2]] if order == "wxyz" else turns.as_quat()
    angles = 0.3 * np.sin(np.arange(40)[:, None] / 3) * [1.0, -1.0]
    return np.hstack([positions, numbers, angles]), turns


@pytest.mark.parametrize("heading", [0, 90, 180])
@pytest.mark.parametrize(("order", "other"), [("wxyz", "xyzw"), ("xyzw", "wxyz")])
def test_the_order_of_quaternions_is_stated_and_checked(heading, order, other):
    qpos, turns = walk_of_robot(heading, order)
    motion = motion_from_qpos(qpos, io.StringIO(STANDING), 30, quaternion=order)
    found = Rotation.from_euler(motion.root_axes, motion.root_angles)
    assert_allclose((found * turns.inv()).magnitude(), 0.0, atol=1e-9)
    with pytest.warns(UserWarning, match=f"quaternion='{order}'"):
        motion_from_qpos(qpos, io.StringIO(STANDING), 30, quaternion=other)


@pytest.mark.parametrize(("columns", "factor", "what"), [(slice(7, 9), 57.3, "rad"), (slice(0, 3), 100, "metres")])
def test_degrees_and_centimetres_warn(columns, factor, what):
    qpos, _ = walk_of_robot(0, "wxyz")
    qpos[:, columns] *= factor
    with pytest.warns(UserWarning, match=what):
        motion_from_qpos(qpos, io.StringIO(STANDING), 30)
