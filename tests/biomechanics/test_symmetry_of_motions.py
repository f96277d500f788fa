"""Symmetry of synthetic movements with known asymmetries."""

from dataclasses import replace

import numpy as np
import pytest
from reference import forward_kinematics

from skpose import Motion
from skpose.biomechanics import symmetry
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
    assert "toes" in repr(found)


@pytest.mark.parametrize("shift", ["auto", "none", "half cycle"])
@pytest.mark.parametrize("n", [101, 64])
def test_a_mirrored_motion_has_the_sides_exchanged(shift, n):
    rng = np.random.default_rng(1)
    motion = stride(n)
    closed = np.sin(np.pi * np.linspace(0, 1, n))[:, None] ** 2
    motion = replace(motion, angles=motion.angles + 0.1 * closed * rng.normal(size=PERSON.n_dofs))
    one, other = symmetry(motion, shift=shift), symmetry(motion.mirrored(), shift=shift)
    assert one.shift == other.shift
    exchanged = [one.skeleton.joint_names.index(name) for name in one.partners]
    np.testing.assert_allclose(one.positions, other.positions[:, exchanged], atol=1e-9)
    np.testing.assert_allclose(one.directions, other.directions[:, exchanged], atol=1e-6)
    np.testing.assert_allclose(one.rotations, other.rotations[:, exchanged], atol=1e-6)


def test_deviations_are_those_of_an_independent_reference():
    """Without a shift: positions and directions of the left against those of the right, reflected."""
    rng = np.random.default_rng(2)
    motion = Motion(PERSON, 0.4 * rng.normal(size=(3, PERSON.n_dofs)), 30)
    found = symmetry(motion, shift="none")
    reflection = np.array([-1.0, 1.0, 1.0])
    world = np.array([np.reshape(forward_kinematics(pose, PERSON), (-1, 3)) for pose in motion.angles])
    bones = world - np.concatenate([world, np.zeros((3, 1, 3))], axis=1)[:, PERSON.parents]
    for j, (name, partner) in enumerate(zip(found.skeleton.joint_names, found.partners, strict=True)):
        assert partner == name.replace("left", "RIGHT").replace("right", "left").replace("RIGHT", "right")
        k = found.skeleton.joint_names.index(partner)
        apart = np.linalg.norm(world[:, j] - reflection * world[:, k], axis=1)
        np.testing.assert_allclose(found.positions[:, j], apart, atol=1e-12)
        a, b = bones[:, j], reflection * bones[:, k]
        cosine = (a * b).sum(axis=1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
        np.testing.assert_allclose(np.cos(np.radians(found.directions[:, j])), cosine, atol=1e-9)


def test_several_cycles_and_parts_of_one_are_refused():
    one = stride()
    for motion in (Motion.concatenate([one[:-1], one]), Motion.concatenate([one[:-1]] * 3), one[:80]):
        if len(motion) == 80:
            motion = Motion.concatenate([one[:-1], motion])
        with pytest.raises(ValueError, match="not one cycle"):
            symmetry(motion)
    assert symmetry(Motion.concatenate([one[:-1], one]), shift="none").shift == "none"
    with pytest.raises(ValueError, match="needs one cycle"):
        symmetry(one[:60], shift="half cycle")


def test_invalid_arguments_are_refused():
    with pytest.raises(ValueError, match="3 frames"):
        symmetry(squat()[:2])
    with pytest.raises(TypeError, match="motion must be a Motion"):
        symmetry(squat().angles)
    with pytest.raises(ValueError, match="shift must be"):
        symmetry(squat(), shift="half")
    with pytest.raises(ValueError, match="pass axis='x'"):
        symmetry(squat(), axis="z")
