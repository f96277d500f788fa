"""Symmetry: of motions that are symmetric, of known asymmetries, of mirrored motions, of recordings."""

from dataclasses import replace

import numpy as np
import pytest
from reference import forward_kinematics
from scipy.spatial.transform import Rotation
from walkers import walk

from skpose import Motion
from skpose.biomechanics import gait_events, symmetry
from skpose.datasets import humanoid

PERSON = humanoid()
SIGNS = {"x": 1.0, "y": -1.0, "z": -1.0}  # of angles about the axes under the reflection across x


def squat(n=101, rate=50):
    """Both sides bend at once."""
    depth = np.sin(np.linspace(0, np.pi, n)) ** 2
    angles = np.zeros((n, PERSON.n_dofs))
    for name, degrees in {"thigh_rx": -80, "shank_rx": 100, "foot_rx": -20, "upper_arm_rx": -60}.items():
        for side in ("left", "right"):
            angles[:, PERSON.dof_names.index(f"{side}_{name}")] = np.radians(degrees) * depth
    angles[:, PERSON.dof_names.index("chest_rx")] = 0.4 * depth
    return Motion(PERSON, angles, rate)


def stride(n=101, rate=100):
    """One cycle of random smooth curves: the right does half a cycle later what the left does, mirrored."""
    rng = np.random.default_rng(0)
    phases = np.linspace(0, 1, n)
    angles = np.zeros((n, PERSON.n_dofs))
    for column, name in enumerate(PERSON.dof_names):
        if name.startswith("left_"):
            waves = rng.normal(scale=0.25, size=3)
            shifts = rng.uniform(0, 2 * np.pi, size=3)
            sign = SIGNS[name[-1]]
            for k in (1, 2, 3):
                for at, lag, factor in ((column, 0.0, 1.0), (_other(column, name), 0.5, sign)):
                    angles[:, at] += factor * waves[k - 1] * np.sin(2 * np.pi * k * (phases - lag) + shifts[k - 1])
        elif not name.startswith("right_"):  # the trunk repeats after half a cycle, or changes sides
            k = 2 if SIGNS[name[-1]] > 0 else 1
            angles[:, column] = 0.1 * np.sin(2 * np.pi * k * phases)
    return Motion(PERSON, angles, rate)


def _other(column, name):
    return PERSON.dof_names.index(name.replace("left", "right"))


def with_angle(motion, name, change):
    angles = motion.angles.copy()
    angles[:, motion.skeleton.dof_names.index(name)] += change
    return replace(motion, angles=angles)


@pytest.mark.parametrize(
    ("motion", "shift"), [(squat(), "none"), (stride(), "half cycle"), (stride(100), "half cycle")]
)
def test_symmetric_motions_have_no_deviations(motion, shift):
    """With an even number of frames half a cycle is between two frames, and what is between two poses is slerp."""
    found = symmetry(motion)
    exact = len(motion) % 2 == 1
    assert found.shift == shift
    for values, limit in ((found.positions, 1e-12), (found.directions, 1e-5), (found.rotations, 1e-5)):
        assert np.nanmax(values) < (limit if exact else 0.5)
    if exact:
        assert "no joint differs" in repr(found)
    assert found.distances[shift] < 0.02 < found.distances["half cycle" if shift == "none" else "none"]


@pytest.mark.parametrize(
    ("motion", "at"),
    [(squat(), 50.0), (stride(), 30.0)],
    ids=["squat", "stride"],
)
def test_a_known_asymmetry_is_found_where_it_is(motion, at):
    """The left knee bends by 10° more around one phase; the right one is compared with it half a cycle away."""
    phases = np.linspace(0, 100, len(motion))
    bump = np.where(np.abs(phases - at) <= 10, np.cos((phases - at) / 10 * np.pi / 2) ** 2, 0.0)
    found = symmetry(with_angle(motion, "left_shank_rx", np.radians(10) * bump))
    first, second, *others = found.joint_asymmetries("rotation")
    assert {first.joint, second.joint} == {"left_shank", "right_shank"}
    of = {one.joint: one for one in (first, second)}
    lag = 0.0 if found.shift == "none" else 50.0
    assert of["left_shank"].phase == pytest.approx(at, abs=1e-9)
    assert of["right_shank"].phase == pytest.approx((at + lag) % 100, abs=1e-9)
    for one in (first, second):
        assert one.largest == pytest.approx(10.0, abs=1e-6)
        assert one.mean == pytest.approx(10.0 * bump.mean(), rel=0.01)
    assert all(one.largest < 1e-5 for one in others)
    # The shank's direction is 10° off, the thigh's is not; the ankle is off by the chord of an arc of 10°.
    j = PERSON.joint_names.index("left_shank")
    row = int(np.argmin(np.abs(phases - at)))
    length = np.linalg.norm(PERSON.offsets[j])
    assert found.directions[row, j] == pytest.approx(10.0, abs=1e-6)
    assert np.nanmax(found.directions[:, PERSON.joint_names.index("left_thigh")]) < 1e-5
    assert found.positions[row, j] == pytest.approx(2 * length * np.sin(np.radians(5)), rel=1e-9)
    assert not found.positions[np.abs(phases - at) > 10.01, j].round(12).any()
    assert "at" in repr(found)
    assert "left_toes differs most" in repr(found) or "right_toes differs most" in repr(found)


@pytest.mark.parametrize("shift", ["auto", "none", "half cycle"])
@pytest.mark.parametrize("n", [101, 64])
def test_a_mirrored_motion_has_the_sides_exchanged(shift, n):
    rng = np.random.default_rng(1)
    motion = stride(n)
    closed = np.sin(np.pi * np.linspace(0, 1, n))[:, None] ** 2
    motion = replace(motion, angles=motion.angles + 0.1 * closed * rng.normal(size=PERSON.n_dofs))
    one, other = symmetry(motion, shift=shift), symmetry(motion.mirrored(), shift=shift)
    assert one.shift == other.shift
    exchanged = [one.joints.index(name) for name in one.partners]
    np.testing.assert_allclose(one.positions, other.positions[:, exchanged], atol=1e-9)
    np.testing.assert_allclose(one.directions, other.directions[:, exchanged], atol=1e-6)
    np.testing.assert_allclose(one.rotations, other.rotations[:, exchanged], atol=1e-6)


def test_deviations_are_those_of_an_independent_reference():
    """Without a shift: positions and directions of the left against those of the right, reflected."""
    rng = np.random.default_rng(2)
    motion = Motion(PERSON, 0.4 * rng.normal(size=(12, PERSON.n_dofs)), 30)
    found = symmetry(motion, shift="none")
    reflection = np.array([-1.0, 1.0, 1.0])
    for name, partner in zip(found.joints, found.partners, strict=True):
        j, k = PERSON.joint_names.index(name), PERSON.joint_names.index(partner)
        assert partner == name.replace("left", "RIGHT").replace("right", "left").replace("RIGHT", "right")
        for row, pose in enumerate(motion.angles):
            F = np.reshape(forward_kinematics(pose, PERSON), (-1, 3))
            assert found.positions[row, found.joints.index(name)] == pytest.approx(
                np.linalg.norm(F[j] - reflection * F[k]), abs=1e-12
            )
            parents = [F[PERSON.parents[i]] if PERSON.parents[i] >= 0 else np.zeros(3) for i in (j, k)]
            a, b = F[j] - parents[0], reflection * (F[k] - parents[1])
            cosine = a @ b / np.linalg.norm(a) / np.linalg.norm(b)
            assert np.cos(np.radians(found.directions[row, j])) == pytest.approx(cosine, abs=1e-9)


def test_the_tilt_of_the_root_is_a_joint_if_it_is_asked_for():
    """A pelvis that leans by 8° to the left does so by 16° against its mirror image."""
    motion = squat()
    lean = np.radians(8.0) * np.ones((len(motion), 1))
    motion = replace(motion, root_angles=lean, root_axes="z")
    assert np.nanmax(symmetry(motion).positions) < 1e-12
    found = symmetry(motion.with_root("tilt"))
    first = found.joint_asymmetries("rotation")[0]
    assert (first.joint, round(first.largest, 6)) == ("root", 16.0)
    assert np.isnan(found.directions[:, found.joints.index("root")]).all()  # of no length


def test_weights_of_joints_have_no_effect():
    motion = with_angle(stride(), "left_shank_rx", 0.1)
    weights = dict.fromkeys(PERSON.joint_names, 0.5) | {"left_hand": 0.0}
    other = symmetry(replace(motion, skeleton=PERSON.with_weights(weights)))
    np.testing.assert_array_equal(symmetry(motion).positions, other.positions)


def test_euler_angles_and_rotation_vectors_are_equal():
    motion = with_angle(stride(), "left_thigh_rz", 0.1)
    one, other = symmetry(motion), symmetry(motion.to_rotvec())
    np.testing.assert_allclose(one.positions, other.positions, atol=1e-9)
    rotating = np.isfinite(one.rotations)
    np.testing.assert_allclose(one.rotations[rotating], other.rotations[rotating], atol=1e-5)


def test_the_table_has_a_row_for_each_joint_and_frame():
    found = symmetry(with_angle(stride(), "left_shank_rx", 0.1))
    table = found.to_pandas()
    assert len(table) == len(found.joints) * len(found.phases)
    worst = table.loc[table["position [m]"].idxmax()]
    first = found.joint_asymmetries("position")[0]
    assert (worst["joint"], worst["phase [%]"], worst["position [m]"]) == (first.joint, first.phase, first.largest)
    rows = table[table["joint"] == "left_shank"]
    np.testing.assert_array_equal(rows["rotation [deg]"], found.rotations[:, found.joints.index("left_shank")])
    assert (rows["partner"] == "right_shank").all()
    with pytest.raises(ValueError, match="quantity must be 'position' or 'direction' or 'rotation', got 'angle'"):
        found.joint_asymmetries("angle")


def test_joints_without_a_quantity_have_none():
    found = symmetry(walk()[: int(120 / 110 * 100) + 1], shift="none")
    assert np.isnan(found.rotations[:, found.joints.index("left_hip")]).all()
    assert "left_hip" not in {one.joint for one in found.joint_asymmetries("rotation")}
    assert "left_hip" in {one.joint for one in found.joint_asymmetries("position")}


def test_several_cycles_and_parts_of_one_are_refused():
    one = stride()
    for motion in (Motion.concatenate([one[:-1], one]), Motion.concatenate([one[:-1]] * 3), one[:80]):
        if len(motion) == 80:
            motion = Motion.concatenate([one[:-1], motion])
        with pytest.raises(ValueError, match=r"which is neither none nor half of the motion"):
            symmetry(motion)
    assert symmetry(Motion.concatenate([one[:-1], one]), shift="none").shift == "none"
    with pytest.raises(ValueError, match='shift="half cycle" needs a cycle, whose last pose is about its first one'):
        symmetry(one[:60], shift="half cycle")


@pytest.mark.parametrize("rate", [50.0, 120.0])
def test_strides_that_are_cut_short_or_long_are_refused(rate):
    """A stride of 1.1 s, from each of its phases; an end that is off by a tenth is near to where it begins."""
    motion, length = walk(width=0.18, rate=rate, cadence=120 / 1.1), round(1.1 * rate)
    for start in range(length // 2, 3 * length // 2, length // 10):
        for off in (-1, 0, 1):
            assert symmetry(motion[start : start + length + 1 + off]).shift == "half cycle"
        for off, when in ((-0.11, "before"), (0.11, "after")):
            cut = motion[start : start + length + 1 + round(off * length)]
            with pytest.raises(ValueError, match=r"about half of the motion of [01]\.\d* s, but the motion ends"):
                symmetry(cut)
            words = rf"whose last pose.* but the motion ends (elsewhere|0\.\d+ s {when} it is at its first pose again)"
            with pytest.raises(ValueError, match=words):
                symmetry(cut, shift="half cycle")


@pytest.mark.slow
def test_strides_of_walks_are_whole_and_cuts_are_not(cmu):
    """Of the strides of CMU's walks from contact to contact 98 % pass, of those without their last 11 % 5 %."""
    shifts = {"whole": [], "cut": []}
    for motion, action in zip(cmu, cmu.actions, strict=True):
        if action == "walk":
            events = gait_events(motion)
            for start, _, stop in events.frames[events.strides].tolist():
                cut = round(start + 0.89 * (stop - start))
                for kind, part in (("whole", motion[start : stop + 1]), ("cut", motion[start : cut + 1])):
                    try:
                        shifts[kind].append(symmetry(part).shift)
                    except ValueError:
                        shifts[kind].append("refused")
    passed = {kind: np.mean(np.array(found) == "half cycle") for kind, found in shifts.items()}
    assert passed["whole"] > 0.97
    assert passed["cut"] < 0.06


def test_a_movement_that_is_slow_at_both_ends_may_end_early():
    """A squat whose last frames are missing: both sides do the same at once."""
    motion = squat()
    assert symmetry(motion[:93]).shift == "none"
    assert symmetry(motion[:93], shift="half cycle").shift == "half cycle"


def test_what_cannot_be_compared_is_refused():
    with pytest.raises(ValueError, match="at least 3, got 2"):
        symmetry(squat()[:2])
    with pytest.raises(TypeError, match=r"motion must be a skpose\.Motion, got ndarray"):
        symmetry(squat().angles)
    with pytest.raises(ValueError, match="shift must be 'auto' or 'none' or 'half cycle', got 'half'"):
        symmetry(squat(), shift="half")
    with pytest.raises(ValueError, match="pass axis='x'"):
        symmetry(squat(), axis="z")


def test_steps_of_unequal_time_are_deviations():
    """The right foot comes down at 44 % of the stride, a limp."""
    even, limp = (symmetry(walk(phase=phase, width=0.18)[55:165], shift="half cycle") for phase in (0.5, 0.44))
    assert even.positions.mean() < 0.005
    assert limp.positions.mean() > 4 * even.positions.mean()


@pytest.mark.slow
def test_healthy_walks_against_the_same_with_one_side_altered(cmu):
    """20° more bend in the left knee are found in the left knee, in the median recording by about 20° more."""
    added = []
    for motion, action in zip(cmu, cmu.actions, strict=True):
        if action != "walk":
            continue
        events = gait_events(motion)
        start, _, stop = events.frames[events.strides[0]]
        step = motion[int(start) : int(stop) + 1]
        healthy = symmetry(step)
        altered = symmetry(with_angle(step, "ltibia_rx", np.radians(20)))
        assert healthy.shift == altered.shift == "half cycle"
        assert healthy.distances["half cycle"] < 0.5 * healthy.distances["none"]
        knee = healthy.joints.index("ltibia")
        added.append(altered.rotations[:, knee].mean() - healthy.rotations[:, knee].mean())
        others = [j for j, name in enumerate(healthy.joints) if name not in ("ltibia", "rtibia")]
        np.testing.assert_allclose(altered.rotations[:, others], healthy.rotations[:, others], atol=1e-9)
    assert len(added) == 26
    assert min(added) > 5.0
    assert np.median(added) > 10.0


def test_rotations_are_relative_to_parents():
    """Of a hip that rotates otherwise the rotations of the hip alone, the directions of all below it."""
    motion = squat()
    lean = with_angle(motion, "left_thigh_rz", np.radians(5))
    found = symmetry(lean)
    thigh, shank = (found.joints.index(f"left_{name}") for name in ("thigh", "shank"))
    i = [name for name in PERSON.dof_names if name.startswith("left_thigh")]
    assert [name[-1] for name in i] == ["x", "y", "z"]
    order = PERSON.bones[thigh].dofs
    columns = [PERSON.dof_names.index(name) for name in i]
    expected = [
        np.degrees((Rotation.from_euler(order, a).inv() * Rotation.from_euler(order, b)).magnitude())
        for a, b in zip(motion.angles[:, columns], lean.angles[:, columns], strict=True)
    ]
    np.testing.assert_allclose(found.rotations[:, thigh], expected, atol=1e-5)
    assert np.nanmax(found.rotations[:, shank]) < 1e-5
    assert found.directions[:, shank].max() > 1.0


def test_joints_that_are_not_seen_are_a_warning():
    motion = squat()
    seen = np.ones((len(motion), PERSON.n_joints), bool)
    assert symmetry(replace(motion, seen=seen)).distances["none"] < 1e-9
    seen[20:60, list(PERSON.joint_names).index("left_hand")] = False
    with pytest.warns(UserWarning, match="not seen in some of the 101 frames: of left_hand in 40. There the fit has"):
        symmetry(replace(motion, seen=seen))
