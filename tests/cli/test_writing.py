"""`skpose retarget`, `convert` and `angles`."""

import csv
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import robot_of_hinges
from walkers import walk

from skpose import Bone, Motion, Skeleton, forward_kinematics, inverse_kinematics
from skpose._cli.main import main
from skpose.biomechanics import gait_events, joint_angles
from skpose.datasets import humanoid
from skpose.io import load_bvh, load_keypoints, load_motion, save_npz
from skpose.keypoints import Keypoints, fit_skeleton, layouts
from skpose.kinematics import retarget
from skpose.robots import retarget_to_robot

pytestmark = pytest.mark.usefixtures("walks_in_folder")


def assert_equal(motion, expected):
    assert motion.skeleton == expected.skeleton
    assert motion.frame_rate == pytest.approx(expected.frame_rate)
    for name in ("angles", "root_positions", "root_angles"):
        np.testing.assert_allclose(getattr(motion, name), getattr(expected, name), atol=1e-12)


def save_arm(name, names=("elbow", "wrist"), dofs="xyz"):
    """Write a motion of an arm of two bones."""
    upper, lower = names
    skeleton = Skeleton([Bone(upper, None, (0.3, 0, 0), dofs), Bone(lower, upper, (0.25, 0, 0), dofs)])
    motion = Motion(skeleton, np.random.default_rng(0).uniform(-1, 1, (5, skeleton.n_dofs)), 20, np.ones((5, 3)))
    save_npz(name, motion)
    return motion


def test_retarget(capsys):
    motion, other = save_arm("arm.npz"), save_arm("other.npz", dofs="rotvec")
    assert main(["retarget", "arm.npz", "--onto", "other.npz"]) == 0
    assert capsys.readouterr().out == "arm.npz: by orientations, 2 of 2 joints, directions within 0°\n"
    assert main(["retarget", "arm.npz", "--onto", "other.npz", "--factor", "2", "--out", "there.npz"]) == 0
    assert_equal(load_motion("there.npz"), retarget(motion, other.skeleton, method="orientations", scale=2.0))
    assert main(["retarget", "anna.bvh", "ben.bvh", "--onto", "anna.bvh"]) == 0
    assert capsys.readouterr().out.splitlines()[-2:] == [
        "anna.bvh: by same numbers",
        "ben.bvh: by same numbers, scaled by 0.99",
    ]
    assert main(["retarget", "anna.bvh", "ben.bvh", "--onto", "anna.bvh", "--out", "m.bvh"]) == 1


def test_retargeted_files_have_the_unit_of_the_target(capsys):
    assert main(["convert", "anna.bvh", "--out", "cm.bvh", "--out-scale", "0.01"]) == 0
    assert main(["retarget", "cm.bvh", "--onto", "cm.bvh", "--scale", "0.01", "--out", "again.bvh"]) == 0
    assert capsys.readouterr().out.endswith(
        "read this one with --scale 0.01\nagain.bvh: " + repr(load_motion("anna.bvh")) + "\n"
    )
    assert_equal(load_motion("again.bvh", scale=0.01), load_motion("cm.bvh", scale=0.01))


@pytest.mark.filterwarnings("ignore")
def test_counterparts(capsys):
    motion, other = save_arm("arm.npz"), save_arm("other.npz", ("upper", "lower"), "rotvec")
    command = ["retarget", "arm.npz", "--onto", "other.npz"]
    assert main(command) == 1
    assert "joints" in capsys.readouterr().err
    assert main([*command, "--joints", "upper=elbow", "lower=wrist", "--out", "there.npz"]) == 0
    joints = {"upper": "elbow", "lower": "wrist"}
    assert_equal(load_motion("there.npz"), retarget(motion, other.skeleton, method="auto", joints=joints))


def test_retarget_onto_a_robot():
    skeleton, (motion, _) = robot_of_hinges.robot(), robot_of_hinges.walk()
    save_npz("walk.npz", motion)
    save_npz("robot.npz", Motion(skeleton, np.zeros((1, skeleton.n_dofs)), 30.0, up="z"))
    joints = robot_of_hinges.counterparts(skeleton)
    pairs = [f"{robot}={person}" for robot, person in joints.items()]
    command = ["retarget", "walk.npz", "--onto", "robot.npz", "--method", "limbs", "--out", "there.npz"]
    assert main([*command, "--joints", *pairs]) == 0
    assert_equal(load_motion("there.npz"), retarget_to_robot(motion, skeleton, joints=joints))


def test_convert_a_motion(capsys):
    motion = load_bvh("anna.bvh")
    assert main(["convert", "anna.bvh", "--out", "a.npz"]) == 0
    assert_equal(load_motion("a.npz"), motion)
    assert main(["convert", "a.npz", "--out", "a.csv"]) == 0
    table = np.genfromtxt("a.csv", delimiter=",", names=True)
    np.testing.assert_array_equal(table[motion.skeleton.dof_names[0]], motion.angles[:, 0])
    assert main(["convert", "a.npz", "--out-scale", "0.01", "--out", "a.bvh"]) == 0
    assert "read this one with --scale 0.01" in capsys.readouterr().out
    positions = [forward_kinematics(one.angles, one.skeleton) for one in (motion, load_bvh("a.bvh", scale=0.01))]
    np.testing.assert_allclose(*positions, atol=1e-6)


def test_convert_changes_a_motion():
    motion = load_bvh("anna.bvh")
    options = ["--from", "0.2", "--to", "0.7", "--rotations", "rotvec", "--frame-rate", "40"]
    assert main(["convert", "anna.bvh", *options, "--out", "a.npz"]) == 0
    assert_equal(load_motion("a.npz"), motion[4:14].to_rotvec().resample(40))  # without the frame at 0.7 s
    assert main(["convert", "anna.bvh", "--from", "1", "--out", "b.npz"]) == 1


@pytest.mark.parametrize("options", [[], ["--endpoint"]])
@pytest.mark.filterwarnings("ignore:the cycle ends:UserWarning")
def test_convert_to_a_loop(options):
    motion = load_bvh("anna.bvh")
    assert main(["convert", "anna.bvh", "--cycle", *options, "--out", "loop.npz"]) == 0
    loop = load_motion("loop.npz")
    assert_equal(loop, motion.to_cycle(endpoint=bool(options)))
    np.testing.assert_allclose(*forward_kinematics(loop.angles[[0, -1]], loop.skeleton), atol=1e-9)


def test_convert_to_smpl_and_back(capsys):
    """Joints are at the same places, whatever the rig calls them."""
    assert main(["convert", "anna.bvh", "--smpl", "--out", "smpl.npz"]) == 0
    assert main(["convert", "smpl.npz", "--out", "back.bvh"]) == 0
    assert main(["convert", "anna.bvh", "--out", "joints.npy"]) == 0
    before, after = (load_bvh(name).to_keypoints() for name in ("anna.bvh", "back.bvh"))
    for one, other in (("left_shank", "left_knee"), ("right_forearm", "right_elbow")):
        np.testing.assert_allclose(before.select([one]).positions, after.select([other]).positions, atol=1e-6)
    assert np.load("joints.npy").shape[1:] == (22, 3)
    save_npz("points.npz", before)
    assert main(["convert", "points.npz", "--smpl", "--out", "no.npz"]) == 1
    assert "skeleton" in capsys.readouterr().err


def test_convert_keypoints(capsys):
    positions = np.random.default_rng(0).uniform(size=(8, 3, 3))
    save_npz("points.npz", Keypoints(positions, ["a", "b", "c"], 20))
    assert main(["convert", "points.npz", "--from", "0.1", "--frame-rate", "10", "--out", "p.csv"]) == 0
    found = load_keypoints("p.csv")
    np.testing.assert_allclose(found.positions, positions[2::2])
    assert found.frame_rate == 10
    for option in (["--cycle", "--out", "q.csv"], ["--out", "q.bvh"]):
        assert main(["convert", "points.npz", *option]) == 1
        assert "skeleton" in capsys.readouterr().err


# Joint angles


def read_angles(path):
    with Path(path).open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return header, np.array([[float(cell or "nan") for cell in row] for row in rows])


@pytest.fixture
def sway():
    """A motion of a person who sways, standing in the first frame, as sway.npz."""
    skeleton = humanoid()
    poses = 0.05 * np.sin(np.arange(8) / 3)[:, None] * np.random.default_rng(0).normal(size=skeleton.n_dofs)
    motion = Motion(skeleton, poses, 30)
    save_npz("sway.npz", motion)
    return motion


def test_angles_of_a_motion(sway, capsys):
    save_npz("still.npz", Motion(sway.skeleton, np.zeros((3, sway.skeleton.n_dofs)), 30))
    for i, (options, zero) in enumerate(
        (([], None), (["--zero", "0"], 0), (["--zero", "still.npz"], load_motion("still.npz")))
    ):
        assert main(["angles", "sway.npz", *options, "--out", f"{i}.csv"]) == 0
        header, table = read_angles(f"{i}.csv")
        expected = joint_angles(sway, zero=zero)
        assert header == ["time [s]", *(f"{name} [deg]" for name in expected.names)]
        np.testing.assert_allclose(table[:, 0], sway.times, atol=1e-5)
        np.testing.assert_allclose(table[:, 1:], expected.degrees, atol=1e-4)
        assert expected.zero in capsys.readouterr().out


COCO = {
    "shoulder": "clavicle",
    "elbow": "upper_arm",
    "wrist": "forearm",
    "hip": "pelvis",
    "knee": "thigh",
    "ankle": "shank",
}


def save_points(motion, *missing):
    """Write points of "coco17" of a motion of `humanoid`, without some of them, as points.npz."""
    P = forward_kinematics(motion.angles, motion.skeleton)
    names = {f"{side}_{mark}": f"{side}_{joint}" for mark, joint in COCO.items() for side in ("left", "right")}
    points = {name: P[:, motion.skeleton.joint_names.index(joint)] for name, joint in names.items()}
    points |= {name: P[:, 3] + [0.0, 0.0, 0.1 + 0.01 * len(name)] for name in ("nose", "left_eye", "right_eye")}
    points |= {name: P[:, 3] + [x, 0.0, 0.0] for name, x in (("left_ear", 0.08), ("right_ear", -0.08))}
    kept = [name for name in points if name not in missing]
    save_npz("points.npz", Keypoints(np.stack([points[name] for name in kept], axis=1), kept, 30))


@pytest.mark.filterwarnings("ignore")
def test_angles_of_keypoints(sway, capsys):
    """Points that are missing are left out, unless a joint of the legs or the root depends on them."""
    save_points(sway, "left_eye")
    assert main(["angles", "points.npz", "--out", "a.csv"]) == 0
    assert "without left_eye of the layout coco17" in capsys.readouterr().out
    layout = layouts["coco17"].without(["left_eye"])
    points = layout.keypoints(load_keypoints("points.npz"))
    expected = joint_angles(inverse_kinematics(points, fit_skeleton(points, layout)).to_motion())
    header, table = read_angles("a.csv")
    assert header[1:] == [f"{name} [deg]" for name in expected.names]
    np.testing.assert_allclose(table[:, 1:], expected.degrees, atol=1e-4)
    for i, name in enumerate(("left_hip", "left_ankle")):
        Path("points.npz").unlink()
        save_points(sway, name)
        assert main(["angles", "points.npz", "--out", f"{i}.csv"]) == 1
        assert not Path(f"{i}.csv").exists()


def test_angles_that_are_refused(sway, capsys):
    save_npz("points.npz", Keypoints(np.random.default_rng(0).uniform(size=(4, 3, 3)), ["a", "b", "c"], 30))
    assert main(["angles", "points.npz", "--out", "a.csv"]) == 1
    assert "--layout" in capsys.readouterr().err
    assert main(["angles", "sway.npz", "--zero", "points.npz", "--out", "a.csv"]) == 1
    assert "--zero" in capsys.readouterr().err


def test_angles_over_cycles(capsys):
    """Two walks and a recording without strides are one table; several files need --cycles."""
    save_npz("a.npz", walk(duration=3.0))
    save_npz("b.npz", walk(step=0.5, duration=3.0))
    save_npz("c.npz", walk(duration=1.0))
    assert main(["angles", "a.npz", "b.npz", "c.npz", "--cycles", "--out", "d.csv"]) == 0
    assert "c.npz: GaitEvents(none" in capsys.readouterr().out
    table = pd.read_csv("d.csv")
    assert set(table["trial"]) == {"a", "b"}
    motion = load_motion("b.npz")
    expected = joint_angles(motion).cycles(gait_events(motion))
    np.testing.assert_allclose(table["value [deg]"][table["trial"] == "b"], expected["value [deg]"], atol=1e-4)
    assert main(["angles", "c.npz", "--cycles", "--out", "e.csv"]) == 1
    assert main(["angles", "a.npz", "b.npz", "--out", "e.csv"]) == 1
    assert "--cycles" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.filterwarnings("default:in zero, mean of 517 standing frames:UserWarning")
def test_markers_with_zero_from_the_standing_trial(opensim_folder, capsys):
    files = (str(opensim_folder / name) for name in ("squats1.trc", "static1.trc"))
    squats, standing = files
    assert main(["angles", squats, "--zero", standing, "--out", "a.csv"]) == 0
    captured = capsys.readouterr()
    assert "mean of 517 standing frames" in captured.out
    assert "right elbow is bent by 35°" in captured.err
