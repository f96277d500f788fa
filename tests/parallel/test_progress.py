"""Long work shows its progress if requested."""

import numpy as np
import pytest
from conftest import random_tree

from skpose import PoseKNeighborsTransformer, pose_distances
from skpose._utils import progress as progress_module
from skpose._utils.progress import progress
from skpose.cluster import MedoidShift
from skpose.metrics import pose_distances_chunked

TREE = random_tree(0)


@pytest.fixture(scope="module")
def X():
    return np.random.default_rng(0).normal(0, 0.3, size=(60, TREE.n_dofs))


def test_a_line_is_printed_every_ten_seconds(capsys, monkeypatch):
    now = [0.0]
    monkeypatch.setattr(progress_module.time, "monotonic", lambda: now[0])
    with progress("work", 100, verbose=1) as advance:
        for _ in range(100):
            now[0] += 4.0
            advance()
    lines = capsys.readouterr().err.splitlines()
    assert (lines[0], lines[-1]) == ("work: 3%, 0:06:28 to go", "work: done in 400.0 s")
    assert len(lines) == 33 + 1


@pytest.mark.parametrize("verbose", [0, 1])
def test_progress_is_shown_if_requested(X, capsys, verbose):
    for call in (
        lambda: pose_distances(X, metric="angle", verbose=verbose),
        lambda: list(pose_distances_chunked(X, metric="angle", verbose=verbose)),
        lambda: PoseKNeighborsTransformer(TREE, verbose=verbose).fit_transform(X),
        lambda: MedoidShift(TREE, bandwidth=1.0, verbose=verbose).fit(X),
    ):
        call()
        captured = capsys.readouterr()
        assert captured.out == ""
        assert ("60" in captured.err) == bool(verbose)
