"""Generated gait: published curves, people who differ as real ones do."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

from skpose import forward_kinematics
from skpose.datasets import humanoid, make_gait
from skpose.datasets._curves import CURVES, LIMB_DOFS, evaluate, series_of
from skpose.datasets._spreads import POSTURE, STYLE, posture_of_person, posture_of_recording, style_of_person

ROOT = Path(__file__).parents[2]
DOFS = humanoid().dof_names
LIMBS = [key for key in POSTURE if key not in DOFS]


def test_gait_is_determined_by_its_seed():
    one, same, other = (make_gait(2, 1, random_state=seed) for seed in (0, 0, 1))
    for a, b, c in zip(one, same, other, strict=True):
        np.testing.assert_array_equal(a.angles, b.angles)
        assert a.skeleton == b.skeleton
        assert not np.array_equal(a.angles, c.angles)


def test_gait_has_the_requested_motions():
    gait = make_gait(3, 2, activities=["run"], duration=1.5, frame_rate=20, random_state=0)
    assert len(gait) == 6
    assert set(gait.actions) == {"run"}
    assert list(gait.subjects) == ["01", "01", "02", "02", "03", "03"]
    assert all(len(motion) == 30 and motion.frame_rate == 20 for motion in gait)
    with pytest.raises(ValueError, match=r"activities must be among \['walk', 'run'\], got 'swim'"):
        make_gait(activities=["walk", "swim"])
    with pytest.raises(ValueError, match="The 'n_subjects' parameter of make_gait must be"):
        make_gait(0)


# Degrees and hundredths of the gait cycle within which curves of healthy adults peak.
PUBLISHED_PEAKS = {
    ("walk", "hip_flexion", "max"): ((18, 38), (80, 112)),
    ("walk", "hip_flexion", "min"): ((-25, -2), (35, 65)),
    ("walk", "knee_flexion", "max"): ((45, 78), (60, 85)),
    ("walk", "ankle_dorsiflexion", "max"): ((2, 18), (28, 55)),
    ("walk", "ankle_dorsiflexion", "min"): ((-30, -8), (50, 72)),
    ("run", "hip_flexion", "max"): ((45, 65), (70, 95)),
    ("run", "knee_flexion", "max"): ((80, 110), (55, 80)),
    ("run", "ankle_dorsiflexion", "max"): ((15, 32), (10, 30)),
    ("run", "ankle_dorsiflexion", "min"): ((-30, -12), (30, 55)),
}


@pytest.mark.parametrize(("activity", "curve", "peak"), PUBLISHED_PEAKS)
def test_gait_curves_peak_at_the_published_times(activity, curve, peak):
    (low, high), (early, late) = PUBLISHED_PEAKS[activity, curve, peak]
    cycle = np.linspace(0, 1, 500, endpoint=False)
    values = evaluate(series_of(CURVES[activity][curve]), cycle)
    at = values.argmax() if peak == "max" else values.argmin()
    assert low < values[at] < high
    assert early <= 100 * cycle[at] <= late or early <= 100 * cycle[at] + 100 <= late


@pytest.mark.parametrize("activity", ["walk", "run"])
def test_six_harmonics_reproduce_the_curves(activity):
    """The Fourier series differs from the points that it is made from by at most twice their rounding."""
    for curve, points in CURVES[activity].items():
        fitted = evaluate(series_of(points), np.arange(len(points)) / len(points))
        assert np.abs(fitted - points).max() < 1.0, curve


def test_gait_moves_like_gait():
    """Feet alternate, arms swing against the legs, and running flexes knees and elbows more than walking."""
    gait = make_gait(4, 1, random_state=0)
    flexion = {}
    for motion, action in zip(gait, gait.actions, strict=True):
        P = dict(
            zip(
                motion.skeleton.joint_names,
                forward_kinematics(motion.angles, motion.skeleton).swapaxes(0, 1),
                strict=True,
            )
        )
        z = {name: P[name][:, 2] for name in P}
        assert np.corrcoef(z["left_foot"], z["right_foot"])[0, 1] < -0.5
        assert np.corrcoef(z["left_hand"], z["left_foot"])[0, 1] < -0.3
        assert P["head"][:, 1].min() > 0.3
        assert P["left_foot"][:, 1].max() < 0
        angles = dict(zip(motion.skeleton.dof_names, np.degrees(motion.angles).T, strict=True))
        flexion.setdefault(action, []).append((angles["left_shank_rx"].max(), -angles["left_forearm_rx"].mean()))
    knee, elbow = (np.mean(flexion["run"], axis=0) - np.mean(flexion["walk"], axis=0)).tolist()
    assert knee > 15
    assert elbow > 40


def test_subjects_differ_in_height_and_proportions():
    skeletons = [motion.skeleton for motion in make_gait(5, 1, activities=["walk"], random_state=0)]
    lengths = np.array([np.linalg.norm(skeleton.offsets, axis=1) for skeleton in skeletons])
    assert (lengths.std(axis=0) > 0).all()
    shares = lengths / lengths.sum(axis=1, keepdims=True)
    assert (shares.std(axis=0) > 0).all()


def test_humanoid_has_the_requested_height():
    for height in (1.5, 2.0):
        skeleton = humanoid(height)
        P = forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton)[0]
        P = dict(zip(skeleton.joint_names, P, strict=True))
        np.testing.assert_allclose(P["head"][1] - P["left_foot"][1], height, rtol=0.01)
        np.testing.assert_allclose(P["left_hand"] * [-1, 1, 1], P["right_hand"], atol=1e-12)
    longer = humanoid(proportions={"thigh": 2.0})
    ratio = np.linalg.norm(longer.offsets, axis=1) / np.linalg.norm(humanoid().offsets, axis=1)
    assert {name for name, r in zip(longer.joint_names, ratio, strict=True) if r > 1.5} == {"left_thigh", "right_thigh"}
    with pytest.raises(ValueError, match=r"proportions names \['tail'\]"):
        humanoid(proportions={"tail": 2.0})
    for height in (0, -1.7, np.nan, np.inf, "1.7", None):
        with pytest.raises(ValueError, match="The 'height' parameter of humanoid must be"):
            humanoid(height)
    for factor in (0, -1, np.nan, "1"):
        with pytest.raises(ValueError, match=r"proportions must be positive numbers, got .* for 'thigh'"):
            humanoid(proportions={"thigh": factor})


def within_chance(values, spread):
    """Whether independent normal values have this standard deviation, but for one case in a million."""
    if spread == 0.0:
        return not np.any(values)
    n = len(values)
    low, high = chi2.ppf([5e-7, 1 - 5e-7], n) / n
    return low <= np.mean(np.square(values)) / spread**2 <= high


def test_postures_have_the_spreads_of_the_table():
    """Both sides share one part; by the other they differ, in the mirror: rotations about y and z change sign."""
    rng = np.random.RandomState(0)
    person, recording = (
        dict(zip(DOFS, np.transpose([draw(rng, DOFS) for _ in range(3000)]), strict=True))
        for draw in (posture_of_person, posture_of_recording)
    )
    for key, spread in POSTURE.items():
        if key not in LIMBS:
            assert within_chance(person[key], spread.shared), key
            assert within_chance(recording[key], spread.recording), key
            continue
        sign = 1 if key.endswith("rx") else -1
        left, right = person[f"left_{key}"], sign * person[f"right_{key}"]
        parts = [(left + right) / 2, (left - right) / 2]
        for part, size in zip(parts, (spread.shared, spread.apart), strict=True):
            assert within_chance(part, size), key
        for side in ("left", "right"):
            assert within_chance(recording[f"{side}_{key}"], spread.recording), key
    r = np.corrcoef([values for name, values in recording.items() if "clavicle" not in name])
    assert np.abs(r - np.eye(len(r))).max() < 5 / np.sqrt(3000)


def test_postures_of_a_limb_are_correlated_as_in_the_table():
    """Each dof with the same axis of the joint before it; dofs of other axes, and the two parts, are independent."""
    rng = np.random.RandomState(0)
    person = dict(zip(DOFS, np.transpose([posture_of_person(rng, DOFS) for _ in range(3000)]), strict=True))
    sign = {key: 1 if key.endswith("rx") else -1 for key in LIMBS}
    part = {(key, "shared"): person[key] for key in POSTURE if key not in LIMBS}
    for key in LIMBS:
        left, right = person[f"left_{key}"], sign[key] * person[f"right_{key}"]
        part |= {(key, "shared"): left + right, (key, "apart"): left - right}
    parent = {bone.name: bone.parent for bone in humanoid().bones}
    seen = 0
    for key, spread in POSTURE.items():
        side = "" if key in DOFS else "left_"
        before = f"{(parent[side + key[:-3]] or '').removeprefix('left_')}{key[-3:]}"
        for name, r in (("shared", spread.shared_r), ("apart", spread.apart_r)):
            if r:
                seen += 1
                measured = np.corrcoef(part[key, name], part[before, name])[0, 1]
                assert abs(measured - r) < 5 * (1 - r**2) / np.sqrt(3000) + 1e-9, key
    assert seen > 12
    axes = [[values for (key, _), values in part.items() if key[-1] == axis and values.any()] for axis in "xyz"]
    across = np.corrcoef(np.concatenate(axes))
    first = len(axes[0])
    assert np.abs(across[:first, first:]).max() < 5 / np.sqrt(3000)
    both = [np.stack([part[key, name] for key in LIMBS if part[key, name].any()]) for name in ("shared", "apart")]
    between = np.corrcoef(np.concatenate(both))[: len(both[0]), len(both[0]) :]
    assert np.abs(between).max() < 5 / np.sqrt(3000)


def test_styles_have_the_spreads_of_the_table():
    rng = np.random.RandomState(0)
    styles = [style_of_person(rng) for _ in range(3000)]
    for curve, (amplitude, phase) in STYLE.items():
        factor, shift = np.transpose([style[curve] for style in styles])
        assert within_chance(np.log(factor), amplitude), curve
        assert within_chance(shift, phase), curve


def test_generated_people_differ_by_the_spreads_of_the_table():
    """The mean of a dof that follows no curve is the person's posture and the recording's."""
    gait = make_gait(150, 1, activities=["walk"], frame_rate=20, random_state=0)
    means = np.degrees([motion.angles.mean(axis=0) for motion in gait])
    curves = {dof for dof, *_ in LIMB_DOFS.values()} | {"abdomen_rx", "abdomen_ry", "chest_rx", "chest_ry", "neck_rx"}
    still = 0
    for name, column in zip(DOFS, means.T, strict=True):
        key = name.removeprefix("left_").removeprefix("right_")
        if key not in curves and not key.startswith("clavicle"):  # which only sway
            still += 1
            assert within_chance(column - column.mean(), np.hypot(POSTURE[key].people, POSTURE[key].recording)), name
    assert still > 15


@pytest.fixture(scope="module")
def benchmark():
    """The program that measures the spreads."""
    path = ROOT / "benchmarks" / "spreads.py"
    if not path.is_file():
        pytest.skip("the benchmarks are not here")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(path.parent))
        spec = importlib.util.spec_from_file_location("spreads", path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    sys.modules.pop("common", None)
    return module


def test_variance_components_are_those_of_the_analysis_of_variance(benchmark):
    """In a balanced design with one group the closed form: mean squares between and within people."""
    rng = np.random.default_rng(0)
    people, n = np.repeat([*"abcdefgh"], 5), 5
    by = benchmark.design(["one"] * 40, people)
    assert by.people == 7
    for size in (0.0, 0.3, 1.0, 30.0):
        y = size * rng.normal(size=8).repeat(n) + rng.normal(size=40) + 100.0
        rows = y.reshape(8, n)
        between = n * np.var(rows.mean(axis=1), ddof=1)
        within = np.mean(np.var(rows, axis=1, ddof=1))
        none = between <= within  # over people
        expected = (0.0, np.std(y, ddof=1)) if none else (np.sqrt((between - within) / n), np.sqrt(within))
        np.testing.assert_allclose(benchmark.components(y, by), expected, rtol=1e-4, atol=1e-6)


def test_means_of_groups_do_not_count_as_spread(benchmark):
    rng = np.random.default_rng(0)
    groups = np.array(["CMU walk"] * 12 + ["CMU run"] * 8 + ["HDM05 jog"] * 9)
    people = np.array([*"aabbbcccdddd", *"aabbccee", *"xxxyyyzzz"])
    by = benchmark.design(groups, people)
    assert by.people == 6  # eight people, two databases
    y = rng.normal(size=len(groups))
    shift = {"CMU walk": 0.0, "CMU run": 40.0, "HDM05 jog": -70.0}
    moved = y + [shift[group] for group in groups]
    np.testing.assert_allclose(benchmark.components(moved, by), benchmark.components(y, by), rtol=1e-6, atol=1e-9)


def test_the_table_is_what_the_benchmark_measures(benchmark, cmu, hdm05):
    datasets = benchmark.databases(cmu, hdm05)
    recorded = benchmark.recordings(datasets)
    by = benchmark.design(recorded.group, recorded.person)
    assert by.people == 6
    for key, spread in benchmark.spreads(recorded, by).items():
        np.testing.assert_allclose(spread, POSTURE[key], atol=0.051, err_msg=key)
    for curve, style in benchmark.styles(recorded, by).items():
        np.testing.assert_allclose(style, STYLE[curve], atol=0.0051, err_msg=curve)


def test_real_poses_keep_the_directions_of_limbs_on_the_humanoid(benchmark, cmu, hdm05):
    bones = {
        "femur": ("hipjoint", "pelvis", "thigh"),
        "tibia": ("femur", "thigh", "shank"),
        "humerus": ("clavicle", "clavicle", "upper_arm"),
        "radius": ("humerus", "upper_arm", "forearm"),
    }
    person = humanoid()
    for motion in (cmu.motions[0], hdm05.motions[0]):
        angles = np.radians(benchmark.on_humanoid(motion)[0])
        real, ours = (
            dict(zip(skeleton.joint_names, forward_kinematics(X, skeleton).swapaxes(0, 1), strict=True))
            for X, skeleton in ((motion.angles, motion.skeleton), (angles, person))
        )
        for side in ("left", "right"):
            for end, (start, our_start, our_end) in bones.items():
                a = real[side[0] + end] - real[side[0] + start]
                b = ours[f"{side}_{our_end}"] - ours[f"{side}_{our_start}"]
                cosine = (a * b).sum(axis=1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
                np.testing.assert_allclose(cosine, 1.0, atol=1e-3, err_msg=f"{side} {end}")
