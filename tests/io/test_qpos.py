"""Motions of robots as MuJoCo's qpos and back, and as files."""

import io

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

from skpose import Motion
from skpose.io import MocapFormatError, load_motion, load_robot, motion_from_qpos, qpos_from_motion, save_csv, save_npz

mujoco = pytest.importorskip("mujoco")

from robots import ROBOTS, SCENE, compiled, mjcf, opened, random_qpos  # noqa: E402


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
    text = mjcf('<body name="a"><joint name="s" type="ball"/><body name="b" pos="1 0 0"/></body>')
    robot = load_robot(opened(text))
    vectors = t[:, None] * [0.6, 0, 0.8]
    qpos = qpos_from_motion(Motion(robot, vectors, 50, up="z"), opened(text))
    assert np.abs(np.diff(qpos, axis=0)).max() < 0.1
    assert_allclose(motion_from_qpos(-qpos, opened(text), 50).angles, vectors, atol=1e-12)


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
    with pytest.raises(MocapFormatError, match=r"joint 'waist' is held at 0.5, and in qpos it is at .* at frame \d"):
        motion_from_qpos(qpos, io.StringIO(SCENE), 30, held={"waist": 0.5})
    motion = motion_from_qpos(qpos, io.StringIO(SCENE), 30, root="torso")
    orientations = Rotation.from_euler(motion.root_axes, motion.root_angles).as_matrix()
    for i, row in enumerate(qpos):
        data.qpos[:] = row
        mujoco.mj_kinematics(model, data)
        assert_allclose(motion.root_positions[i], data.body("torso").xpos, atol=1e-14)
        assert_allclose(orientations[i], data.body("torso").xmat.reshape(3, 3), atol=1e-14)
    with pytest.raises(MocapFormatError, match="qpos has numbers of 'pull', 'floating', 'waist', 'hip', which 'torso'"):
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
    with pytest.warns(UserWarning, match=r'y is the axis that points up.* use dataclasses.replace\(motion, up="z"\)'):
        qpos_from_motion(lying, opened(text))
    sideways = Motion(motion.skeleton, motion.angles, 30, [[1, 2, 3]], [[0, np.pi / 2, 0]], up="x")
    (qpos,) = qpos_from_motion(sideways, opened(text))
    assert_allclose(qpos[:7], [-3, 2, 1, 1, 0, 0, 0], atol=1e-15)


def test_held_quaternions_have_either_sign():
    text, held = ROBOTS["held"]
    motion = moving(text, held)
    qpos = qpos_from_motion(motion, opened(text), held=held)
    at = compiled(text).joint("s").qposadr[0]
    qpos[::2, at : at + 4] *= -1
    assert_array_equal(motion_from_qpos(qpos, opened(text), 50, held=held).angles, motion.angles)


def test_errors_of_qpos_from_motion():
    text, held = ROBOTS["held"]
    motion = moving(text, held)
    given = {"held": held}
    with pytest.raises(TypeError, match=r"motion must be a skpose.Motion, got ndarray: Motion\(skeleton, poses"):
        qpos_from_motion(motion.angles, opened(text))
    with pytest.raises(MocapFormatError, match="the motion has no columns 'x', 'y', 's_anchor_rotvec_x'"):
        qpos_from_motion(motion, opened(text))
    less = {name: value for name, value in held.items() if name != "w"}
    with pytest.raises(MocapFormatError, match=r"the motion has no columns 'w': .* held at a value, held="):
        qpos_from_motion(motion, opened(text), held=less)
    with pytest.raises(MocapFormatError, match=r"the motion's bone '.*' is none of this robot: .* root= and held="):
        qpos_from_motion(motion, opened(text), held=held | {"y": 0.1})
    with pytest.raises(MocapFormatError, match="the motion has columns 'yaw', which are no columns of this robot"):
        qpos_from_motion(motion, opened(text), held=held | {"yaw": 0.1})
    with pytest.raises(MocapFormatError, match=r"columns 'root_rotvec_x'.*: motion.without_root"):
        qpos_from_motion(motion.with_root("whole"), opened(text), **given)
    away = moving(text, held, root_positions=np.linspace(0, [1, 0, 0], 50))
    with pytest.raises(MocapFormatError, match="'world' has no free joint, and the root of the motion moves, by 1 m"):
        qpos_from_motion(away, opened(text), **given)
    with pytest.raises(MocapFormatError, match="the motion has columns"):
        qpos_from_motion(motion, opened(ROBOTS["free root"][0]))


def test_errors_of_motion_from_qpos():
    text, held = ROBOTS["held"]
    with pytest.raises(
        ValueError, match=r"qpos must have shape \(n_frames, 11\), 4 for a ball joint × 1 \+ 7 joints, "
    ):
        motion_from_qpos(np.zeros((3, 10)), opened(text), 30, held=held)
    free = ROBOTS["free root"][0]
    with pytest.raises(ValueError, match="at frame 0 must be a quaternion of length one, got"):
        motion_from_qpos(np.zeros((3, 9)), io.StringIO(free), 30)
    with pytest.raises(ValueError, match="qpos holds nan at frame 0, column 0"):
        motion_from_qpos(np.full((3, 9), np.nan), io.StringIO(free), 30)
    with pytest.raises(ValueError, match="frame_rate"):
        motion_from_qpos(np.zeros((3, 9)), io.StringIO(free), 0)


def test_files_of_motions_keep_the_names(tmp_path):
    pandas = pytest.importorskip("pandas")
    text, held = ROBOTS["held"]
    motion = moving(text, held, up="z")
    save_npz(tmp_path / "a.npz", motion)
    again = load_motion(tmp_path / "a.npz")
    assert again.skeleton == motion.skeleton
    assert_array_equal(again.angles, motion.angles)
    assert_array_equal(
        qpos_from_motion(again, opened(text), held=held), qpos_from_motion(motion, opened(text), held=held)
    )
    save_csv(tmp_path / "a.csv", motion)
    table = pandas.read_csv(tmp_path / "a.csv")
    assert list(table.columns[-3:]) == ["yaw", "v", "bend"]
    assert_array_equal(table[list(motion.skeleton.dof_names)], motion.angles)
