"""Which repetition was wrong, where and when: the table of repetitions, against known wrong ones and plain numpy."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from squats import RATE, SKELETON, column, squats

from skpose import Motion, Skeleton, forward_kinematics
from skpose.datasets import make_gait
from skpose.motions import segment_repetitions
from skpose.motions._deviations import LEAST, deviations_of

COLUMNS = ["repetition", "joint", "phase [%]", "frame", "time [s]"]
COLUMNS += ["x [m]", "y [m]", "z [m]", "deviation [m]", "spread [m]", "unusual"]
LEG = "thigh", "shank", "foot", "toes"
LARGE = 4.0  # of "unusual", of ten repetitions


def find(motion):
    return segment_repetitions(motion, n_surrogates=19, random_state=0)


def assert_named(motion, cycles, wrong, side, large=LARGE):
    """The most unusual row names the repetition, the limb and the phase, and no other repetition is as unusual."""
    found = find(motion)
    assert len(found) == len(cycles)
    table = found.to_pandas()
    row = table.loc[table["unusual"].idxmax()]
    first, last = cycles[wrong]
    assert row["repetition"] == wrong
    assert row["joint"] in {f"{side}_{name}" for name in LEG}
    assert 0.37 < (row["time [s]"] - first) / (last - first) < 0.63
    assert 35.0 < row["phase [%]"] < 65.0
    assert row["unusual"] > large
    others = table.loc[table["repetition"] != wrong, "unusual"]
    assert others.max() < large
    # What is unusual is there alone: in the other leg, and before and after, it is as usual as in the others.
    unusual = table[table["unusual"] > large]
    assert unusual["joint"].str.startswith(side).all()
    assert unusual["phase [%]"].between(30.0, 70.0).all()


def cases(n_fast, n):
    """Wrong repetitions by seed, sides in turn; those after the first are slow."""
    for seed in range(n):
        marks = () if seed < n_fast else pytest.mark.slow
        yield pytest.param(seed, (3 * seed) % 10, ("left", "right")[seed % 2], marks=marks, id=str(seed))


@pytest.mark.parametrize(("seed", "wrong", "side"), list(cases(4, 20)))
def test_the_wrong_one_of_ten_squats_is_named(seed, wrong, side):
    motion, cycles = squats(seed, wrong, side)
    assert_named(motion, cycles, wrong, side)


@pytest.mark.slow
@pytest.mark.parametrize(("method", "side"), [("geodesic", "left"), ("spline", "right")])
def test_the_wrong_one_of_squats_through_key_poses_is_named(method, side):
    motion, cycles = squats(3, 6, side, method=method)
    assert_named(motion, cycles, 6, side, large=3.5)


def test_of_two_wrong_ones_both_are_named():
    first, _ = squats(5, 2, "left")
    second, _ = squats(5, 7, "right")
    usual, _ = squats(5)
    both = replace(usual, angles=first.angles + second.angles - usual.angles)
    table = find(both).to_pandas()
    assert set(table.loc[table["unusual"] > LARGE, "repetition"]) == {2, 7}


@pytest.mark.parametrize("seeds", [range(5), pytest.param(range(5, 30), marks=pytest.mark.slow)], ids=["5", "25"])
@pytest.mark.parametrize("spread", [1.0, 2.0])
def test_nothing_is_named_where_nothing_is_wrong(seeds, spread):
    """In one recording of ten at most the largest number is above 4, and in none above 5: see the benchmark."""
    largest = np.array([find(squats(seed, spread=spread)[0]).to_pandas()["unusual"].max() for seed in seeds])
    assert (largest > LARGE).mean() <= 0.1
    assert largest.max() < 5.0


@pytest.fixture(scope="module")
def ten():
    """Ten squats, the fifth of them wrong; and their table."""
    motion, cycles = squats(1, 4, "left")
    found = find(motion)
    return motion, cycles, found, found.to_pandas()


def test_one_row_for_each_repetition_joint_and_phase(ten):
    motion, _, found, table = ten
    assert list(table.columns) == COLUMNS
    names = SKELETON.joint_names
    np.testing.assert_array_equal(table["repetition"], np.repeat(np.arange(10), 20 * len(names)))
    assert table["joint"].tolist() == [name for _ in range(10) for name in names for _ in range(20)]
    np.testing.assert_allclose(table["phase [%]"], np.tile(5.0 * (np.arange(20) + 0.5), 10 * len(names)))
    np.testing.assert_allclose(
        np.linalg.norm(table[["x [m]", "y [m]", "z [m]"]], axis=1), table["deviation [m]"], atol=1e-12
    )
    assert (found.starts[table["repetition"]] <= table["frame"]).all()
    assert (table["frame"] < found.stops[table["repetition"]]).all()
    np.testing.assert_array_equal(table["time [s]"], motion.times[table["frame"]])
    frames = table["frame"].to_numpy().reshape(10, len(names), 20)
    assert (np.diff(frames, axis=2) >= 0).all()
    assert (frames == frames[:, :1]).all()
    assert table.attrs == {
        "n_repetitions": 10,
        "n_phases": 20,
        "reference": "median of the other repetitions, after dynamic time warping",
        "typical_spread": pytest.approx(table["spread [m]"].median()),
        "root": "left out: a repetition that is wrong in where the whole body is, or leans, is not unusual",
        "axes": "those of the root",
        "phase": table.attrs["phase"],
    }
    first = f"frame {found.starts[0]} of the recording, at {motion.times[found.starts[0]]:.2f} s, "
    assert f"0 % is where repetitions begin, such as {first}and" in table.attrs["phase"]
    assert "of a recording that is cut elsewhere it may be another pose" in table.attrs["phase"]
    np.testing.assert_allclose(
        table["unusual"], table["deviation [m]"] / (table["spread [m]"] + table.attrs["typical_spread"]), rtol=1e-12
    )


def test_x_y_z_lead_from_the_others_to_the_joint_in_the_axes_of_the_root(ten):
    """The left knee is in: to the right, which is −x of the humanoid, by as much as the thigh rotates."""
    motion, _, _, table = ten
    knee = table[(table["repetition"] == 4) & (table["joint"] == "left_thigh")]
    row = knee.loc[knee["deviation [m]"].idxmax()]
    usual, _ = squats(1)
    at = int(row["frame"])
    j = SKELETON.joint_names.index("left_thigh")
    wrong, right = (forward_kinematics(one.angles[at : at + 1], SKELETON)[0, j] for one in (motion, usual))
    assert row["x [m]"] < -0.08
    np.testing.assert_allclose(row[["x [m]", "y [m]", "z [m]"]].astype(float), wrong - right, atol=0.03)


def test_repetitions_of_equal_length_and_tempo_against_numpy():
    """Repetitions that differ in a joint that the alignment does not see: differences from the median of the rest."""
    n, frames = 5, 201
    rng = np.random.default_rng(0)
    skeleton = Skeleton.chain(2).with_weights({"joint_1": 1.0, "joint_2": 0.0})
    swing = np.sin(np.linspace(0, np.pi, frames))
    elbows = rng.normal(0, 0.2, n)
    growing = np.linspace(0, 2, frames) ** 2
    poses = [np.stack([swing, elbow * growing], axis=1) for elbow in elbows]
    found = deviations_of(poses, skeleton, 10)
    positions = np.stack([forward_kinematics(one, skeleton) for one in poses])
    for k in range(n):
        others = np.delete(positions, k, axis=0)
        reference = np.median(others, axis=0)
        far = np.linalg.norm(positions[k] - reference, axis=2)
        spread = np.median(np.linalg.norm(others - reference, axis=3), axis=0)
        for p in range(10):
            inside = slice(20 * p, 20 * p + 21)
            np.testing.assert_allclose(found.distances[k, p], far[inside].mean(axis=0), atol=5e-3)
            near = slice(max(0, 20 * p - 20), 20 * p + 41)
            np.testing.assert_allclose(found.spread[k, p], spread[near].mean(axis=0), atol=5e-3)
    assert found.distances[:, :, 0].max() < 1e-9  # the first joint does not differ
    np.testing.assert_allclose(found.frames, np.tile(20 * np.arange(10) + 10, (n, 1)), atol=0.5)


def test_a_wrong_one_leaves_the_others_as_they_are(ten):
    """The median of the rest moves by less than the rest varies."""
    motion, _, found, _ = ten
    usual, _ = squats(1)
    parts = [usual[a:b].angles for a, b in zip(found.starts, found.stops, strict=True)]
    wrong = [motion[a:b].angles for a, b in zip(found.starts, found.stops, strict=True)]
    before, after = (deviations_of(one, SKELETON, 20) for one in (parts, wrong))
    others = np.delete(np.arange(10), 4)
    moved = np.abs(after.distances[others] - before.distances[others])
    assert moved.max() < before.typical_spread * 1.5
    assert after.distances[4].max() > 6 * before.typical_spread


@pytest.mark.parametrize("speed", [0.5, 0.8, 1.7])
def test_tempo_has_no_effect(ten, speed):
    """A repetition at another tempo, or that slows down on its way, is at the same phase in the same poses."""
    _, _, found, _ = ten
    poses = [motion.angles for motion in found.motions]
    before = deviations_of(poses, SKELETON, 20)
    n = len(poses[2])
    even = np.linspace(0, 1, round(n / speed))
    for course in (even, even + 0.06 * np.sin(2 * np.pi * even)):
        at = course * (n - 1)
        other = np.stack([np.interp(at, np.arange(n), column) for column in poses[2].T], axis=1)
        after = deviations_of([*poses[:2], other, *poses[3:]], SKELETON, 20)
        assert np.abs(after.vectors - before.vectors).max() < 0.02
        assert np.abs(after.vectors - before.vectors).mean() < 0.002
        np.testing.assert_allclose(after.frames[2] * (n - 1) / (len(other) - 1), before.frames[2], atol=0.1 * n)


def test_the_order_of_repetitions_has_no_effect(ten):
    poses = [motion.angles for motion in ten[2].motions]
    forward, backward = deviations_of(poses, SKELETON, 20), deviations_of(poses[::-1], SKELETON, 20)
    np.testing.assert_allclose(forward.ratios, backward.ratios[::-1], atol=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_strides_that_are_cut_by_the_ends_of_the_recording_are_not_unusual(seed):
    """Walks are cut anywhere; without open ends the first and the last stride had numbers of 5 to 18."""
    walk = make_gait(1, 1, activities=["walk"], duration=6, frame_rate=20, random_state=seed)[0]
    found = find(walk)
    assert len(found) >= 5
    table = found.to_pandas()
    assert table["unusual"].max() < 5.0
    assert 0.9 < len(table) / (len(found) * 20 * walk.skeleton.n_joints) <= 1.0


@pytest.mark.parametrize("share", [0.2, 0.3])  # where the movement is fast
@pytest.mark.parametrize("at_end", [False, True])
def test_phases_that_a_repetition_lacks_have_no_numbers(ten, share, at_end):
    poses = [motion.angles for motion in squats_without_a_wrong_one(ten)]
    before = deviations_of(poses, SKELETON, 20)
    cut = round(share * len(poses[3]))
    poses[3] = poses[3][:-cut] if at_end else poses[3][cut:]
    after = deviations_of(poses, SKELETON, 20)
    missing = np.isnan(after.frames[3])
    first = np.flatnonzero(~missing)[[0, -1]]
    assert missing.mean() == pytest.approx(share, abs=0.08)
    assert missing[-1 if at_end else 0]
    assert not missing[first[0] : first[1] + 1].any()
    assert not np.isnan(np.delete(after.frames, 3, axis=0)).any()
    for numbers in (after.vectors[..., 0], after.ratios):
        np.testing.assert_array_equal(np.isnan(numbers[3]).all(axis=1), missing)
    both = ~np.isnan(after.ratios[3])
    assert after.ratios[3][both].max() < np.nanmax(before.ratios) + 1.5


def test_an_arm_that_is_up_all_along_is_named_at_all_phases(ten):
    poses = [motion.angles.copy() for motion in squats_without_a_wrong_one(ten)]
    poses[6][:, column("left_upper_arm_rz")] += 1.5
    found = deviations_of(poses, SKELETON, 20)
    arm = [SKELETON.joint_names.index(f"left_{name}") for name in ("upper_arm", "forearm", "hand")]
    assert not np.isnan(found.ratios).any()
    assert found.ratios[6][:, arm].min() > LARGE
    assert np.delete(found.ratios, 6, axis=0).max() < LARGE


@pytest.mark.parametrize("last", [False, True])
def test_what_is_wrong_at_an_end_is_not_cut_off(ten, last):
    poses = [motion.angles.copy() for motion in squats_without_a_wrong_one(ten)]
    n = len(poses[6]) // 8
    poses[6][-n:] += 1.0 * (np.arange(SKELETON.n_dofs) == column("right_upper_arm_rz")) * last
    poses[6][:n] += 1.0 * (np.arange(SKELETON.n_dofs) == column("right_upper_arm_rz")) * (not last)
    found = deviations_of(poses, SKELETON, 20)
    k, p, j = np.unravel_index(np.nanargmax(found.ratios), found.ratios.shape)
    assert (k, SKELETON.joint_names[j].startswith("right_")) == (6, True)
    assert p > 16 if last else p < 3
    assert not np.isnan(found.ratios[6]).any()


def squats_without_a_wrong_one(ten):
    """The repetitions of the recording without a wrong one."""
    usual, _ = squats(1)
    return [usual[a:b] for a, b in zip(ten[2].starts, ten[2].stops, strict=True)]


@pytest.mark.parametrize("n_phases", [1, 2, 7, 50, 200])
def test_any_number_of_phases(ten, n_phases):
    table = ten[2].to_pandas(n_phases=n_phases)
    assert len(table) == 10 * SKELETON.n_joints * n_phases
    assert np.isfinite(table.drop(columns="joint").to_numpy(dtype=float)).all()


def test_equal_repetitions_are_not_unusual():
    once = squats(0, n=1)[0].angles
    found = deviations_of([once] * 6, SKELETON, 20)
    assert found.ratios.max() < 1e-6
    bent = once.copy()
    bent[60:80, SKELETON.dof_names.index("left_shank_rx")] += 0.2
    found = deviations_of([once] * 5 + [bent], SKELETON, 20)
    assert found.ratios[5].max() > 1e3  # any deviation from what never varies
    assert found.ratios[:5].max() < 1e-6


def some_of(found, n):
    return replace(found, starts=found.starts[:n], stops=found.stops[:n], motions=found.motions[:n])


@pytest.mark.parametrize("n", [2, 3, 4])
def test_few_repetitions_have_deviations_and_no_spread(ten, n):
    table = some_of(ten[2], n).to_pandas()
    assert np.isfinite(table["deviation [m]"]).all()
    assert np.isfinite(table["unusual"]).all() == (n >= LEAST)
    assert table["spread [m]"].isna().all() == table["unusual"].isna().all() == (n < LEAST)
    if n == 2:  # each is the reference of the other
        x, y = (table.loc[table["repetition"] == k, ["x [m]", "y [m]", "z [m]"]].to_numpy() for k in (0, 1))
        np.testing.assert_allclose(x, -y, atol=1e-12)


@pytest.mark.parametrize("n", [0, 1])
def test_one_repetition_is_refused(ten, n):
    with pytest.raises(ValueError, match=rf"needs at least two, got {n or 'none'}: segment_repetitions finds more"):
        some_of(ten[2], n).to_pandas()


def test_arrays_take_the_skeleton_that_they_were_found_with(ten):
    motion, _, _, table = ten
    found = segment_repetitions(motion.angles, skeleton=SKELETON, n_surrogates=19, random_state=0)
    of_array = found.to_pandas()
    assert of_array["time [s]"].isna().all()
    for name in COLUMNS:
        if name != "time [s]":
            np.testing.assert_array_equal(of_array[name], table[name])


@pytest.mark.filterwarnings("ignore:metric='auto' is")
def test_arrays_without_a_skeleton_are_refused(ten):
    found = segment_repetitions(ten[0].angles, n_surrogates=19, random_state=0, metric="angle")
    with pytest.raises(ValueError, match="repetitions of an array without one: pass skeleton= to segment_repetitions"):
        found.to_pandas()


@pytest.mark.parametrize(("n_phases", "message"), [(0, "at least 1"), (2.5, "whole number"), (201, "200 or less")])
def test_phases_out_of_range_are_refused(ten, n_phases, message):
    with pytest.raises(ValueError, match=message):
        ten[2].to_pandas(n_phases=n_phases)


def test_times_are_those_of_the_recording(ten):
    """Frames that are missing keep their times."""
    motion, _, found, _ = ten
    assert found.times.tolist() == motion.times.tolist()
    later = Motion(SKELETON, motion.angles, RATE, frame_numbers=np.arange(len(motion)) + 500)
    table = find(later).to_pandas()
    np.testing.assert_allclose(table["time [s]"], 10.0 + table["frame"] / RATE)


def test_without_pandas(ten, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"pip install 'skpose\[pandas\]'"):
        ten[2].to_pandas()


def test_repetitions_that_lack_frames_are_a_warning():
    motion, _ = squats(5, n=4)
    middle = len(motion) // 2

    def find_without(n):
        """The repetitions if n frames in the middle of the recording are missing."""
        kept = np.delete(np.arange(len(motion)), np.s_[middle : middle + n])
        return find(Motion(SKELETON, motion.angles[kept], RATE, frame_numbers=kept))

    assert len(find_without(1)) == 4  # is no matter
    with pytest.warns(UserWarning, match=r"repetition \d lacks 20 of the frames \d+ to \d+, and is compared as if"):
        find_without(20)
