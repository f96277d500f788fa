"""Lengths of bones by fit_skeleton: free of the bias of noise, with warnings of bones that stretch."""

import numpy as np
import pytest
from conftest import in_space
from people import ARM, errors, lengths, moving, one_bone, true_lengths

from skpose.keypoints import fit_skeleton, layouts
from skpose.keypoints._lengths import bone_length


@pytest.fixture(params=list(layouts))
def layout(request):
    return layouts[request.param]


def test_lengths_without_noise_are_exact(layout):
    assert max(map(abs, errors(fit_skeleton(moving(layout), layout), true_lengths(layout)).values())) < 1e-12


def test_lengths_with_noise_of_1_cm_are_within_1_percent(layout):
    truth = true_lengths(layout)
    positions = moving(layout, n=3000)
    noise = 0.01 * np.random.default_rng(0).normal(size=positions.shape)
    found = errors(fit_skeleton(positions + noise, layout), truth)
    assert max(abs(error) for name, error in found.items() if truth[name] > 0.06) < 0.01
    assert max(map(abs, found.values())) < 0.06  # bones that are as short as the noise


def test_the_length_of_a_short_bone_is_unbiased_where_the_mean_is_not():
    found, means = [], []
    for seed in range(30):
        positions = one_bone(0.05, 300, 0.01, seed)
        found.append(lengths(fit_skeleton(positions, ARM))["elbow"])
        means.append(np.linalg.norm(positions[:, 1] - positions[:, 0], axis=1).mean())
    assert abs(np.mean(found) / 0.05 - 1.0) < 0.01
    assert np.mean(means) / 0.05 - 1.0 > 0.07


def test_outliers_do_not_change_a_length():
    positions = one_bone(0.3, 500, 0.01, seed=0)
    positions[::10, 1] += np.random.default_rng(1).normal(size=(50, 3))
    assert abs(lengths(fit_skeleton(positions, ARM))["elbow"] / 0.3 - 1.0) < 0.01


def test_confidences_weigh_the_frames():
    positions = np.concatenate([one_bone(0.3, 100, 0.0, 0), one_bone(0.33, 100, 0.0, 1)])
    confidences = np.ones((200, 3))
    confidences[100:] = 0.1
    rng = np.random.default_rng(0).permutation(200)  # in no order of time, so that nothing changes slowly
    keypoints = ARM.keypoints(positions[rng], 25, confidences[rng])
    plain, weighted = fit_skeleton(positions[rng], ARM), fit_skeleton(keypoints, ARM)
    assert abs(lengths(plain)["elbow"] - 0.315) < 0.002
    assert abs(lengths(weighted)["elbow"] - 0.3) < 0.002


def test_a_bone_that_stretches_slowly_is_named_with_its_spread():
    change = 0.2 * np.sin(np.linspace(0, 20, 400))
    with pytest.warns(UserWarning, match="bones stretch slowly.*elbow by 14 % ") as caught:
        skeleton = fit_skeleton(one_bone(0.3, 400, 0.005, 0, change), ARM)
    assert len(caught) == 1
    assert "wrist" not in str(caught[0].message)
    assert abs(lengths(skeleton)["elbow"] / 0.3 - 1.0) < 0.02


def test_noise_of_the_same_spread_is_no_stretch():
    for seed in range(20):  # warnings are errors
        fit_skeleton(one_bone(0.3, 400, 0.03, seed), ARM)


def test_a_length_that_is_lost_in_noise_is_named():
    with pytest.warns(UserWarning, match=r"lengths of bones are uncertain.*: elbow ±.* \(standard error\)"):
        fit_skeleton(one_bone(0.02, 300, 0.02, seed=0), ARM)
    with pytest.warns(UserWarning, match="lengths of bones are uncertain"):
        fit_skeleton(one_bone(0.1, 5, 0.02, seed=0), ARM)  # few frames


def test_standard_errors_are_those_of_repetition():
    for length, noise in ((0.3, 0.01), (0.05, 0.01)):
        distances = [
            np.linalg.norm(np.diff(one_bone(length, 200, noise, s)[:, :2], axis=1)[:, 0], axis=1) for s in range(300)
        ]
        found = [bone_length(d, np.ones(200)) for d in distances]
        spread = np.std([one.value for one in found])
        assert 0.8 < np.mean([one.error for one in found]) / spread < 1.2


@pytest.mark.slow
@pytest.mark.parametrize("database", ["cmu", "hdm05"])
def test_bones_of_recorded_people(database, request):
    layout, rng = layouts["cmu31"], np.random.default_rng(0)
    motions = {}
    for motion in request.getfixturevalue(database).motions:
        motions.setdefault(motion.skeleton, []).append(motion)
    for skeleton, theirs in motions.items():
        positions = np.concatenate([np.insert(in_space(m), 0, m.root_positions, axis=1) for m in theirs])
        truth = lengths(skeleton)
        assert max(map(abs, errors(fit_skeleton(positions, layout), truth).values())) < 1e-12
        noisy = np.concatenate(
            [positions + 0.01 * rng.normal(size=positions.shape) for _ in range(-(-5000 // len(positions)))]
        )
        found = errors(fit_skeleton(noisy, layout), truth)
        assert np.median(np.abs(list(found.values()))) < 0.003
        assert max(abs(error) for name, error in found.items() if truth[name] > 0.05) < 0.01
