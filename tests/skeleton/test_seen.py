"""Which joints had positions where poses were fitted to them: every function that returns a motion keeps it."""

from dataclasses import replace

import numpy as np
import pytest

from skpose import Motion, Skeleton, forward_kinematics, inverse_kinematics
from skpose.datasets import humanoid, make_gait
from skpose.geodesics import interpolate
from skpose.io import load_motion, save_npz
from skpose.kinematics import retarget
from skpose.motions import mean_motion

SKELETON = humanoid()
NAMES = list(SKELETON.joint_names)
N = 12


@pytest.fixture
def seen():
    """A third of the joints, at random in each frame, is not seen."""
    return np.random.default_rng(0).random((N, len(NAMES))) < 0.67


@pytest.fixture
def motion(seen):
    return replace(make_gait(1, 1, frame_rate=10, random_state=0)[0][:N], seen=seen)


def test_fitted_poses_know_what_they_were_fitted_to(seen):
    walk = make_gait(1, 1, frame_rate=10, random_state=0)[0][:N]
    positions = forward_kinematics(walk.angles, SKELETON)
    positions[~seen] = np.nan
    fitted = inverse_kinematics(positions, SKELETON)
    np.testing.assert_array_equal(fitted.to_motion(10).seen, seen)
    assert fitted.to_motion(10).fitted
    assert not walk.fitted
    assert walk.seen is None


def test_frames(motion, seen):
    np.testing.assert_array_equal(motion[2:7].seen, seen[2:7])
    np.testing.assert_array_equal(motion[::-1].seen, seen[::-1])
    np.testing.assert_array_equal(motion[3].seen, seen[3:4])
    recorded = replace(motion, seen=None)
    both = Motion.concatenate([motion, recorded])
    np.testing.assert_array_equal(both.seen, np.concatenate([seen, np.ones_like(seen)]))
    assert Motion.concatenate([recorded, recorded]).seen is None
    finer = motion.resample(20)
    np.testing.assert_array_equal(finer.seen[::2], seen)
    np.testing.assert_array_equal(finer.seen[1::2], seen[:-1] & seen[1:])


def test_joints(motion, seen):
    part = motion.select(drop=["left_thigh", "head"])
    columns = [NAMES.index(name) for name in part.skeleton.joint_names]
    np.testing.assert_array_equal(part.seen, seen[:, columns])
    other = [name.replace("left", "R").replace("right", "left").replace("R", "right") for name in NAMES]
    np.testing.assert_array_equal(motion.mirrored().seen, seen[:, [NAMES.index(name) for name in other]])
    whole = motion.with_root("whole")
    np.testing.assert_array_equal(whole.seen[:, 1:], seen)
    assert not whole.seen[:, 0].any()
    np.testing.assert_array_equal(whole.without_root().seen, seen)
    for same in (motion.to_rotvec(), motion.to_rotvec().to_euler("zyx"), motion.unwrap()):
        np.testing.assert_array_equal(same.seen, seen)


@pytest.mark.filterwarnings("ignore:the cycle ends:UserWarning", "ignore:the joints move:UserWarning")
def test_cycles(motion, seen):
    cycle = motion.to_cycle()
    np.testing.assert_array_equal(cycle.seen, np.concatenate([seen, seen[-1:]]))
    np.testing.assert_array_equal(cycle.repeat(3).seen, np.concatenate([seen, seen, cycle.seen]))


def test_files(motion, seen, tmp_path):
    save_npz(tmp_path / "m.npz", motion)
    np.testing.assert_array_equal(load_motion(tmp_path / "m.npz").seen, seen)
    save_npz(tmp_path / "r.npz", replace(motion, seen=None))
    assert load_motion(tmp_path / "r.npz").seen is None


def test_what_is_between_key_poses_and_a_mean_is_seen_where_all_of_them_are(motion, seen):
    between = interpolate(motion[:2], frame_rate=30)
    np.testing.assert_array_equal(between.seen, np.broadcast_to(seen[0] & seen[1], between.seen.shape))
    mean = mean_motion([motion, motion]).to_motion()
    np.testing.assert_array_equal(mean.seen, seen)
    assert mean_motion([replace(motion, seen=None)] * 2).to_motion().seen is None


@pytest.mark.parametrize("method", ["numbers", "orientations", "positions"])
def test_another_skeleton_shows_what_its_counterparts_do(motion, seen, method):
    order = ["left_thigh", *(name for name in NAMES if not name.startswith("left_thigh"))]
    bones = sorted(SKELETON.bones, key=lambda bone: order.index(bone.name) if bone.parent is None else 99)
    other = Skeleton([bone._replace(offset=1.1 * np.asarray(bone.offset)) for bone in bones])
    assert other.joint_names != SKELETON.joint_names
    there = retarget(motion, other, method=method)
    columns = [NAMES.index(name) for name in other.joint_names]
    np.testing.assert_array_equal(there.seen, seen[:, columns])


@pytest.mark.parametrize("given", [np.ones((N, 2), bool), np.ones((N, len(NAMES)))])
def test_what_is_no_array_of_frames_and_joints_is_refused(motion, given):
    with pytest.raises(ValueError, match=r"seen must be True, None or an array of bool of shape \(12, 22\)"):
        replace(motion, seen=given)
    assert replace(motion, seen=True).seen.all()
    assert repr(replace(motion, seen=True)).startswith("Motion(12 frames at 10 Hz, 1.2 s, y up, fitted to positions, S")
    assert "fitted to positions (50 % of joints unseen)" in repr(
        replace(motion, seen=np.arange(N * 22).reshape(N, 22) % 2 == 0)
    )


def test_notebooks_show_a_fitted_motion(motion):
    longer = Motion.concatenate([motion] * 3)
    assert "fitted to positions" in longer._repr_html_()
