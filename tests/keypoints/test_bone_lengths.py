"""Lengths of bones from noisy positions."""

import numpy as np
import pytest
from people import ARM, errors, lengths, moving, one_bone, true_lengths

from skpose.keypoints import fit_skeleton, layouts


@pytest.fixture(params=["coco17", "smpl24", "opencap43"])
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


def test_stretching_bones_warn():
    change = 0.2 * np.sin(np.linspace(0, 20, 400))
    with pytest.warns(UserWarning, match="bones stretch: elbow by 14 %") as caught:
        skeleton = fit_skeleton(one_bone(0.3, 400, 0.005, 0, change), ARM)
    assert len(caught) == 1
    assert "wrist" not in str(caught[0].message)
    assert abs(lengths(skeleton)["elbow"] / 0.3 - 1.0) < 0.02
